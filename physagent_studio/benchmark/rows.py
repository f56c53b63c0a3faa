"""A figure with its bound."""

from collections.abc import Iterable
from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class Row:
    """One measured figure. bound: what it is held to, in words such as "≤ 0.5"; "" for none."""

    name: str
    value: float | int | str
    unit: str
    bound: str
    ok: bool


def at_most(name: str, value: float, bound: float, unit: str = "") -> Row:
    """A figure that may not exceed its bound."""
    return Row(name, float(value), unit, f"≤ {bound:g}", bool(value <= bound))


def at_least(name: str, value: float, bound: float, unit: str = "") -> Row:
    """A figure that may not fall below its bound."""
    return Row(name, float(value), unit, f"≥ {bound:g}", bool(value >= bound))


def shown(name: str, value: float | int | str, unit: str = "") -> Row:
    """A figure without a bound."""
    return Row(name, value, unit, "", True)


def page(title: str, rows: Iterable[Row]) -> str:
    """The rows as a table in Markdown under a title."""
    lines = [f"# {title}", "", "| figure | value | bound | |", "|---|---|---|---|"]
    for row in rows:
        value = f"{row.value:.4g}" if isinstance(row.value, float) else str(row.value)
        told = f"{value} {row.unit}".strip()
        lines.append(f"| {row.name} | {told} | {row.bound or '–'} | {'✓' if row.ok else '✗'} |")
    return "\n".join(lines) + "\n"
