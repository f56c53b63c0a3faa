"""Event frames → contract: what each clause demands of a rollout."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from typing import Any

from physagent_studio.agent.rules.intents import met, prevented
from physagent_studio.agent.rules.layout import Layout
from physagent_studio.agent.rules.reading import EventFrame, Place, Reading
from physagent_studio.agent.rules.reading.vocabulary import SHARES, words_of
from physagent_studio.agent.rules.senses import SENSES
from physagent_studio.agent.rules.senses.beside import beside
from physagent_studio.agent.rules.sequence import afterwards, matched, ranked
from physagent_studio.agent.rules.specs import Context, Spec, place_name
from physagent_studio.program.contract import Contract

_GIVING_WAY = words_of("topple fall collapse flip lean lose_balance knock_over")
"""What happens to a thing because something hits it."""
_WHERE = ("on", "in", "at", "from", "along", "over", "down", "object")
"""Relations to what a thing stands on that only say where the event happens."""
BEGINNING = 12
"""Steps at the beginning in which what "does not move until …" is still, and must be so."""


def contract_of(reading: Reading, layout: Layout) -> Contract:
    """The contract of a prompt over a scene; the same events in other words give the same."""
    draft = _Draft(layout, reading)
    for index, frame in enumerate(reading.frames):
        draft.add(index, frame)
    return Contract.model_validate(
        {
            "clauses": [
                *({"id": c.id, "text": c.text[:4000] or c.id} for c in reading.clauses[:48]),
                *draft.untold_places()[:16],
            ],
            "statements": draft.statements[:256],
            "not_understood": [word[:200] for word in reading.not_understood[:64]],
        }
    )


@dataclass
class _Draft:
    """Statements written so far, as plain data."""

    layout: Layout
    reading: Reading
    statements: list[dict[str, Any]] = field(default_factory=list)

    def add(self, index: int, frame: EventFrame) -> None:
        """Adds the statements of one frame, tied to its clause."""
        build: Callable[[Context], Sequence[Spec]] | None = SENSES.get(frame.sense)
        if build is None:
            return
        if self._until(index, frame):
            return
        subjects = frame.patient or self._everyone(frame)
        groups = [self._demanded(index, frame, subject) for subject in subjects]
        if prevented(self.reading, index) and frame.sense not in ("reach", "approach"):
            self._never(index, frame, groups)
        elif frame.negated and frame.link != "before":
            self._none_of(index, groups, frame.clause)
        elif frame.counted and len(groups) > 1:
            self._count_group(groups, frame)
        elif frame.any_one and len(groups) > 1:
            self._any_group(self._matched(index, frame, groups) or groups, frame.clause)
        else:
            for spec in (one for group in groups for one in group):
                self._state(spec, frame.clause)
            self._order(index, frame, groups)
            self._sequel(index, frame, groups)
            for spec in ranked(frame, groups):
                self._state(spec, frame.clause)
            self._in_time(index, frame, groups)

    def _demanded(self, index: int, frame: EventFrame, subject: str) -> list[Spec]:
        """What the verb demands of one object, and what is said beside it."""
        context = self._context(index, frame, subject)
        found = list(SENSES[frame.sense](context))
        return [*found, *(one for one in beside(context) if one not in found)]

    def _until(self, index: int, frame: EventFrame) -> bool:
        """ "Stands still until the ball hits it": it does so first, and not for ever."""
        following = self.reading.frames[index + 1 : index + 2]
        still = frame.sense in ("stay", "rest", "be") and not frame.negated
        if not still or not following or following[0].link != "until":
            return False
        build = SENSES.get(following[0].sense)
        for subject in frame.patient:
            first = {"subject": subject, "distance": 0.05, "tilt": 15.0, "to_step": BEGINNING}
            self._state(Spec("stays", first), frame.clause)
            other = (*following[0].patient, subject)[0]
            told = list(build(self._context(index + 1, following[0], other))) if build else []
            for event in _events(told)[:1]:
                moved = Spec("moves", {"subject": subject, "distance": 0.05})
                early = Spec("all_of", {}, (Spec("before", {}, (moved, event)),))
                self._state(early.opposite(), frame.clause)
        return True

    def untold_places(self) -> list[dict[str, str]]:
        """Places of the prompt that no statement speaks of, as in "rolls under the table": a
        clause of its own for each, which nothing tests.

        Where a thing is to begin with, and the ground it moves on, need no statement; nor does
        a place in a clause that is untested anyway.
        """
        tested = {row["clause"] for row in self.statements}
        said = {clause.id: clause.text[:3000] for clause in self.reading.clauses}
        named = {
            (row["clause"], name)
            for row in self.statements
            for value in row.values()
            for name in (value if isinstance(value, list) else (value,))
            if isinstance(name, str)
        }
        found: dict[str, str] = {}
        for frame in self.reading.frames:
            for relation, place in frame.places:
                # A landmark may belong to another thing ("the stone at the target").
                clauses = tested if place.kind == "landmark" else {frame.clause}
                mine = {(c, name) for c in clauses for name in (place.name, place_name(place))}
                told = mine & named or frame.clause not in tested
                if not told and not self._is_given(frame, relation, place):
                    text = f"{place.name.replace('_', ' ')}, in “{said[frame.clause]}”"
                    found.setdefault(text, f"{frame.clause}_place_{len(found) + 1}")
        for frame in self.reading.frames:
            for word in self._untold(frame):
                text = f"{word}, in “{said[frame.clause]}”"
                found.setdefault(text, f"{frame.clause}_said_{len(found) + 1}")
        return [{"id": name, "text": text} for text, name in found.items()]

    def _untold(self, frame: EventFrame) -> list[str]:
        """How far, and how in time, where no statement of its clause says it."""
        kinds = {row["kind"] for row in self.statements if row["clause"] == frame.clause}
        found = []
        if frame.share is not None and "covers" not in kinds:
            word = next((w for w, row in SHARES.items() if row == frame.share), "so far")
            found.append(_SAID.get(word, word))
        if frame.timing and frame.timing not in kinds:
            found.append(_SAID[frame.timing])
        return [*found, *_unmeasured(frame, kinds)]

    def _is_given(self, frame: EventFrame, relation: str, place: Place) -> bool:
        if place.kind == "group" or frame.sense in ("be", "hang", "withdrawn"):
            return True
        carriers = {self.layout.ground()}
        for name in (*frame.patient, *frame.agent):
            if self.layout.has(name):
                carriers |= {self.layout.carrier(name), self.layout.base(name)}
        return relation in _WHERE and place.name in carriers

    def _context(self, index: int, frame: EventFrame, subject: str) -> Context:
        return Context(frame, subject, index, self.reading, self.layout, SENSES)

    def _never(self, index: int, frame: EventFrame, groups: list[list[Spec]]) -> None:
        """ "Stops before it touches the cup": that does not happen."""
        for agent in frame.agent:
            for other in frame.patient:
                self._state(Spec("stops_before", {"subject": agent, "before": other}), frame.clause)
        for first in (group[0] for group in groups if group):
            self._state(first.opposite(), frame.clause)

    def _order(self, index: int, frame: EventFrame, groups: list[list[Spec]]) -> None:
        """ "X before Y", "Y after X": both are demanded, and which of them comes first."""
        at = index + 1 if frame.leads else index - 1
        main = self.reading.frames[at] if 0 <= at < len(self.reading.frames) else None
        build = SENSES.get(main.sense) if main is not None else None
        told = any(one.kind == "before" for group in groups for one in group)
        if main is None or build is None or main.negated or told or not main.patient:
            return
        blow = frame.link == "as" and (frame.sense == "hit" or bool(met(frame)))
        caused = blow and main.sense in _GIVING_WAY and not frame.leads
        if frame.link not in ("before", "after", "once") and not caused:
            return
        told_of = [list(build(self._context(at, main, name))) for name in main.patient]
        earlier = next((specs for specs in told_of if _events(specs)), told_of[0])
        mine = next((s for s in _events(groups[0] if groups else []) if s not in earlier), None)
        other = next((s for s in _events(earlier) if s != mine), None)
        if mine is not None and other is not None:
            pair = (other, mine) if frame.link == "before" else (mine, other)
            self._state(Spec("before", {}, pair), frame.clause)

    def _sequel(self, index: int, frame: EventFrame, groups: list[list[Spec]]) -> None:
        """ "First … then … finally": in that order."""
        main = self.reading.frames[index - 1] if index else None
        if main is None or not frame.sequel or main.negated or main.any_one or main.counted:
            return
        if main.sense not in SENSES or frame.link not in ("then", "once"):
            return
        earlier = [s for name in main.patient[:1] for s in self._demanded(index - 1, main, name)]
        order = afterwards(earlier, groups[0] if groups else [])
        if order is not None:
            self._state(order, frame.clause)

    def _matched(self, index: int, frame: EventFrame, groups: list[list[Spec]]) -> list[list[Spec]]:
        """What "the other" does, or the one itself goes on to do, with what the one does."""
        main = self.reading.frames[index - 1] if index else None
        if main is None or set(main.patient) != set(frame.patient) or main.negated:
            return []
        if not main.any_one or main.sense not in SENSES:
            return []
        first = [self._demanded(index - 1, main, name) for name in frame.patient]
        return [list(way) for way in matched(main, frame, first, groups)]

    def _in_time(self, index: int, frame: EventFrame, groups: list[list[Spec]]) -> None:
        """ "One after another", "at the same time": of several, or of this and what was told."""
        if not frame.timing:
            return
        if len(groups) < 2 and index:
            main = self.reading.frames[index - 1]
            if main.sense in SENSES and main.patient and not main.negated:
                groups = [self._demanded(index - 1, main, main.patient[0]), *groups]
        told = [(_events(group) or group)[0] for group in groups if group]
        if len(told) > 1:
            self._state(Spec(frame.timing, {}, tuple(told)), frame.clause)

    def _everyone(self, frame: EventFrame) -> tuple[str, ...]:
        """A wind that names nobody blows on whatever the prompt speaks of; what loses its
        support is what is said to fall."""
        if frame.sense == "withdrawn":
            told = ("lose_support", "fall", "land", "topple")
            falling = [f for f in self.reading.frames if f.sense in told]
            return tuple(dict.fromkeys(n for f in falling for n in f.patient))
        if frame.sense != "wind":
            return ()
        named = {n: None for f in self.reading.frames for n in f.patient}
        return tuple(named) or tuple(item.name for item in self.layout.state.objects)

    def _none_of(self, index: int, groups: list[list[Spec]], clause: str) -> None:
        frame = self.reading.frames[index]
        for agent in frame.agent if "nearly" in frame.manner else ():
            for other in frame.patient:
                near = {"subject": agent, "distance": 0.05, "toward": other}
                self._state(Spec("moves", near), clause)
        following = self.reading.frames[index + 1 : index + 2]
        # "Does not move until …" speaks of the beginning.
        first = bool(following) and following[0].link in ("until", "before")
        touched = self._touched(index, frame)
        for one in (part for group in groups for part in _denied(group, touched)):
            if one.kind == "moves" and not {"direction", "toward"} & set(one.fields):
                still = {"subject": one.fields["subject"], "distance": 0.05, "tilt": 15.0}
                still |= {"to_step": BEGINNING} if first else {}
                self._state(Spec("stays", still), clause)
            else:
                self._state(one.opposite(), clause)

    def _touched(self, index: int, frame: EventFrame) -> bool | None:
        """Whether an earlier clause has the agent touch it; None where nothing acts on it."""
        if not frame.agent:
            return None
        met = (f for f in self.reading.frames[:index] if not f.negated and f.agent)
        return any(
            set(f.agent) & set(frame.agent) and set(f.patient) & set(frame.patient) for f in met
        )

    def _any_group(self, groups: list[list[Spec]], clause: str) -> None:
        of = self._joined(groups, clause)
        if of:
            self._put({"kind": "any_of", "of": of}, f"any_{of[0]}", clause)

    def _count_group(self, groups: list[list[Spec]], frame: EventFrame) -> None:
        """ "At least two of the pins fall"."""
        of = self._joined(groups, frame.clause)
        if of:
            high = len(of) if frame.most is None else frame.most
            count = {"kind": "count_of", "of": of, "low": frame.least, "high": high}
            self._put(count, f"count_{of[0]}", frame.clause)

    def _joined(self, groups: list[list[Spec]], clause: str) -> list[str]:
        """One statement for each group."""
        of: list[str] = []
        for group in groups:
            ids = [self._state(spec, clause) for spec in group]
            if len(ids) > 1:
                ids = [self._put({"kind": "all_of", "of": ids}, f"all_{ids[0]}", clause)]
            of += ids
        return of

    def _state(self, spec: Spec, clause: str) -> str:
        data = dict(spec.fields)
        if spec.kind in ("any_of", "all_of", "in_turn", "together"):
            data["of"] = [self._state(part, clause) for part in spec.parts]
            label = spec.kind if spec.kind in ("in_turn", "together") else "any"
            return self._put({"kind": spec.kind, **data}, f"{label}_{data['of'][0]}", clause)
        if spec.kind == "before":
            first, second = (self._told(part) or self._state(part, clause) for part in spec.parts)
            data |= {"first": first, "second": second}
            return self._put({"kind": "before", **data}, f"{first}_first", clause)
        return self._put({"kind": spec.kind, **data}, _label(spec), clause)

    def _told(self, spec: Spec) -> str | None:
        """The statement that says so already, in whatever clause; only plain ones."""
        if spec.parts:
            return None
        plain = {"kind": spec.kind, **spec.fields}
        serving = self._serving()
        for row in (one for one in self.statements if one["id"] not in serving):
            if {k: v for k, v in row.items() if k not in ("id", "clause")} == plain:
                return row["id"]
        return None

    def _serving(self) -> set[str]:
        """Ids of what only serves a composite, and is not demanded by itself."""
        named = {name for row in self.statements for name in row.get("of", ())}
        pairs = [row for row in self.statements if row["kind"] == "before" and row["id"] in named]
        return named | {row[end] for row in pairs for end in ("first", "second")}

    def _put(self, data: dict[str, Any], label: str, clause: str) -> str:
        """The id of the statement; one that the clause has already is not written twice."""
        for row in self.statements:
            same = {k: v for k, v in row.items() if k not in ("id", "clause")} == data
            if same and row["clause"] == clause:
                return row["id"]
        taken = {row["id"] for row in self.statements}
        name, number = label[:60], 1
        while name in taken:
            number += 1
            name = f"{label[:57]}_{number}"
        self.statements.append({"id": name, "clause": clause, **data})
        return name


_SAID = {
    "alltheway": "all the way", "partway": "part of the way", "mostway": "most of the way",
    "thirdway": "a third of the way", "in_turn": "one after another",
    "together": "at the same time",
}  # fmt: skip
"""How joined words were written."""


def _unmeasured(frame: EventFrame, kinds: set[str]) -> list[str]:
    """Numbers of a clause that no statement of the kind that takes them holds."""
    takes = (
        (frame.distance, ("moves", "stops"), "m"), (frame.speed, ("speed_between",), "m/s"),
        (frame.angle, ("rotates", "flips"), "degrees"), (frame.delay, ("stays",), "s"),
    )  # fmt: skip
    return [
        f"{said:g} {unit}"
        for said, holding, unit in takes
        if said is not None and not kinds & set(holding)
    ]


def _denied(group: list[Spec], touched: bool | None) -> list[Spec]:
    """What "does not …" denies: where it gets to, else the events, and not how they go on.

    touched: an earlier clause has the agent touch it; None without an agent. "Touches it without
    knocking it over" denies that it falls over; "does not slide off the table" that it comes off,
    not that it moves.
    """
    aims = [s for s in group if s.kind in _AIMS and not s.fields.get("negated")]
    if aims:
        return aims
    events = [s for s in group if s.kind in _MOMENTS and _happens(s)]
    effects = [s for s in events if s.kind in _EFFECTS]
    if touched and any(s.kind not in ("contacts", "moves") for s in effects):
        events = [s for s in effects if s.kind != "moves"]
    elif touched is None and any(s.kind in _ENDS_OF_WAY for s in events):
        events = [s for s in events if s.kind not in ("moves", "rotates")]
    return [s for s in events if s.kind != "airborne"] or events or group


def _happens(one: Spec) -> bool:
    """Whether it is an event, and neither a denial nor how things are when the clip begins."""
    return not one.fields.get("negated") and "to_step" not in one.fields


def _events(specs: Sequence[Spec]) -> list[Spec]:
    """Of the demands of a clause those that happen at some moment, the most telling first."""
    found = [s for s in specs if s.kind in _MOMENTS and _happens(s)]
    return sorted(found, key=lambda s: _MOMENTS.index(s.kind))


_EFFECTS = ("topples", "flips", "leaves", "falls", "passes_over")
"""What befalls a thing that something else acts on."""
_ENDS_OF_WAY = ("leaves", "contacts", "passes_over")
"""To where, or off what, something moves."""
_AIMS = ("lands_in", "side_of", "covers")
"""What says where something gets to; "does not roll into the goal" denies that alone."""
_MOMENTS = (
    "topples", "flips", "passes_over", "side_of", "covers", "bounces", "leaves", "contacts",
    "falls", "reverses", "airborne", "moves", "rotates",
)  # fmt: skip


def _label(spec: Spec) -> str:
    parts = [str(spec.fields["subject"]), "not" if spec.fields.get("negated") else "", spec.kind]
    parts += [str(spec.fields[k]) for k in _NAMED if k in spec.fields]
    return "_".join(part for part in parts if part)


_NAMED = ("side", "other", "landmark", "near", "toward", "direction", "before")


def landmarks_needed(reading: Reading) -> tuple[Place, ...]:
    """Places of the prompt that have to become landmarks of the scene, once each."""
    found: dict[str, Place] = {}
    for place in reading.places():
        if place.kind == "landmark" or (place.kind == "support" and place.part):
            found.setdefault(place_name(place), place)
    return tuple(found.values())
