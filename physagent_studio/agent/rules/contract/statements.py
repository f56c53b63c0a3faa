"""The statements of a contract while it is written: plain data, each told once a clause."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

from physagent_studio.agent.rules.contract.specs import Spec
from physagent_studio.program.base import free_name


@dataclass
class Statements:
    """What is stated so far, in order."""

    rows: list[dict[str, Any]] = field(default_factory=list)

    def state(self, spec: Spec, clause: str) -> str:
        """Adds a demand with its parts; returns the id of its statement."""
        data = dict(spec.fields)
        if spec.kind in ("any_of", "all_of", "in_turn", "together"):
            data["of"] = [self.state(part, clause) for part in spec.parts]
            label = spec.kind if spec.kind in ("in_turn", "together") else "any"
            return self.put({"kind": spec.kind, **data}, f"{label}_{data['of'][0]}", clause)
        if spec.kind == "before":
            first, second = (self._told(part) or self.state(part, clause) for part in spec.parts)
            data |= {"first": first, "second": second}
            return self.put({"kind": "before", **data}, f"{first}_first", clause)
        return self.put({"kind": spec.kind, **data}, _label(spec), clause)

    def _told(self, spec: Spec) -> str | None:
        """The statement that says so already, in whatever clause; only plain ones."""
        if spec.parts:
            return None
        plain = {"kind": spec.kind, **spec.fields}
        serving = self._serving()
        for row in (one for one in self.rows if one["id"] not in serving):
            if {k: v for k, v in row.items() if k not in ("id", "clause")} == plain:
                return row["id"]
        return None

    def _serving(self) -> set[str]:
        """Ids of what only serves a composite, and is not demanded by itself."""
        named = {name for row in self.rows for name in row.get("of", ())}
        pairs = [row for row in self.rows if row["kind"] == "before" and row["id"] in named]
        return named | {row[end] for row in pairs for end in ("first", "second")}

    def put(self, data: dict[str, Any], label: str, clause: str) -> str:
        """The id of the statement; one that the clause has already is not written twice."""
        for row in self.rows:
            same = {k: v for k, v in row.items() if k not in ("id", "clause")} == data
            if same and row["clause"] == clause:
                return row["id"]
        name = free_name(label, {row["id"] for row in self.rows})
        self.rows.append({"id": name, "clause": clause, **data})
        return name

    def joined(self, groups: list[list[Spec]], clause: str) -> list[str]:
        """One statement for each group."""
        of: list[str] = []
        for group in groups:
            ids = [self.state(spec, clause) for spec in group]
            if len(ids) > 1:
                ids = [self.put({"kind": "all_of", "of": ids}, f"all_{ids[0]}", clause)]
            of += ids
        return of


def _label(spec: Spec) -> str:
    parts = [str(spec.fields["subject"]), "not" if spec.fields.get("negated") else "", spec.kind]
    parts += [str(spec.fields[k]) for k in _NAMED if k in spec.fields]
    return "_".join(part for part in parts if part)


_NAMED = ("side", "other", "landmark", "near", "toward", "direction", "before")
