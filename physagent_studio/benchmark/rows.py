"""A figure with its bound."""

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
