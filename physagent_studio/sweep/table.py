"""What a sweep found, a row for each point, as columns."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

from physagent_studio.sweep.plan import Point
from physagent_studio.sweep.run import Ran

Columns = dict[str, list[Any]]
MARGIN, CONTACT = "margin ", "contact "
"""How the columns of margins and of times of first contacts, s, begin."""


def columns_of(found: Iterable[tuple[Point, Ran]]) -> Columns:
    """The columns of points and their runs, in the order of the points; None where one has none.

    target, seed and holds come first, then what was set, by path, margins and contacts.
    """
    rows = [_row(point, ran) for point, ran in found]
    names = dict.fromkeys(name for row in rows for name in row)
    kinds = [_kind(name) for name in names]
    ordered = [name for _, name in sorted(zip(kinds, names, strict=True), key=lambda one: one[0])]
    return {name: [row.get(name) for row in rows] for name in ordered}


def _row(point: Point, ran: Ran) -> dict[str, Any]:
    row: dict[str, Any] = {"target": point.target.label, "holds": ran.holds}
    row |= {"seed": point.seed if point.seed >= 0 else None, "problem": ran.problem}
    row |= {"program": point.program.hash if point.program else "", "rollout": ran.rollout}
    # A field may be a whole number in one program and not in another.
    row |= {path: float(value) for path, value in point.values.items()}
    row |= {f"{MARGIN}{one.id}": one.margin for one in ran.checks if one.demanded}
    return row | {f"{CONTACT}{pair}": seconds for pair, seconds in ran.touches}


def fields_of(columns: Columns) -> list[str]:
    """The columns of what was set."""
    return [name for name in columns if _kind(name) == 1]


def _kind(name: str) -> int:
    if name in ("target", "seed", "holds"):
        return 0
    if name.startswith((MARGIN, CONTACT)):
        return 2 if name.startswith(MARGIN) else 3
    return 4 if name in ("problem", "program", "rollout") else 1
