"""What a sweep found, a row for each point: as columns, as CSV, as Parquet where pyarrow is."""

from __future__ import annotations

import csv
import importlib
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from physagent_studio.exchange.files import written
from physagent_studio.sweep.plan import Point
from physagent_studio.sweep.run import Ran

Row = dict[str, Any]


@dataclass(frozen=True, slots=True)
class Table:
    """Rows by column, and which columns are values, margins, and times of first contacts, s."""

    rows: Sequence[Row]
    fields: tuple[str, ...]
    margins: tuple[str, ...]
    touches: tuple[str, ...]

    @property
    def columns(self) -> tuple[str, ...]:
        """All columns, in their order."""
        return ("target", "seed", *self.fields, "holds", *self.margins, *self.touches, *_REST)

    def column(self, name: str) -> list[Any]:
        """A column's values; None where a row has none."""
        return [row.get(name) for row in self.rows]


_REST = ("problem", "program", "rollout")


def table_of(found: Iterable[tuple[Point, Ran]]) -> Table:
    """The rows of points and their runs, in the order of the points."""
    rows, fields, margins, touches = [], dict[str, None](), dict[str, None](), dict[str, None]()
    for point, ran in found:
        demanded = {f"margin {one.id}": one.margin for one in ran.checks if one.demanded}
        times = {f"contact {one.a} {one.b}": one.seconds for one in ran.touches}
        fields |= dict.fromkeys(point.values)
        margins |= dict.fromkeys(demanded)
        touches |= dict.fromkeys(times)
        rows.append(_row(point, ran) | dict(point.values) | demanded | times)
    return Table(rows, tuple(fields), tuple(margins), tuple(touches))


def _row(point: Point, ran: Ran) -> Row:
    program = point.program.hash if point.program else ""
    return {
        "target": point.target.label, "seed": point.seed if point.seed >= 0 else None,
        "holds": ran.holds, "problem": ran.problem, "program": program, "rollout": ran.rollout,
    }  # fmt: skip


def write_csv(table: Table, path: Path) -> None:
    """The table as CSV; what a row does not have is empty."""
    with written(path) as partial, partial.open("w", newline="", encoding="utf-8") as file:
        rows = csv.DictWriter(file, table.columns, restval="", lineterminator="\n")
        rows.writeheader()
        rows.writerows(table.rows)


def write_parquet(table: Table, path: Path) -> bool:
    """The table as Parquet; False where pyarrow is not installed."""
    try:
        arrow: Any = importlib.import_module("pyarrow")
        files: Any = importlib.import_module("pyarrow.parquet")
    except ImportError:
        return False
    columns: Mapping[str, list[Any]] = {name: table.column(name) for name in table.columns}
    for name in table.fields:
        # A field may be a whole number in one program and not in another.
        columns[name][:] = [None if one is None else float(one) for one in columns[name]]
    with written(path) as partial:
        files.write_table(arrow.table(dict(columns)), partial)
    return True
