"""Quantities with their units: lengths, speeds, times and angles."""

from physagent_studio.language.syntax.phrases import NounPhrase
from physagent_studio.language.tokens.vocabulary import words_of

LENGTHS = {
    "cm": 0.01, "centimeter": 0.01, "centimetre": 0.01, "m": 1.0, "meter": 1.0, "metre": 1.0,
    "mm": 0.001, "millimeter": 0.001, "millimetre": 0.001, "inch": 0.0254, "foot": 0.305,
    "feet": 0.305, "yard": 0.914, "decimeter": 0.1, "decimetre": 0.1,
}  # fmt: skip
"""Metres of a unit of length."""
SPEEDS = {
    "m/s": 1.0, "cm/s": 0.01, "km/h": 1 / 3.6, "kph": 1 / 3.6, "kmh": 1 / 3.6, "mph": 0.447,
    "mps": 1.0,
}  # fmt: skip
"""Metres per second of a unit of speed."""
TIMES = {"second": 1.0, "sec": 1.0, "s": 1.0, "millisecond": 0.001, "ms": 0.001}
"""Seconds of a unit of time."""
ANGLES = {"degree": 1.0, "deg": 1.0}
UNITS = frozenset((*LENGTHS, *SPEEDS, *TIMES, *ANGLES))
"""All units, in the singular."""
ROUGHLY = words_of("about around roughly approximately nearly almost")
"""Words before a number that leave it as it is."""


def amount_of(phrase: NounPhrase) -> float | None:
    """The number of a quantity; "a metre" is one."""
    if phrase.amount is not None:
        return phrase.amount
    return 1.0 if phrase.determiner in ("a", "an", "one") else None


def in_units(phrase: NounPhrase, units: dict[str, float]) -> float | None:
    """The quantity in SI units or degrees; None where the phrase is none."""
    amount = amount_of(phrase)
    if phrase.head not in units or amount is None:
        return None
    return amount * units[phrase.head]
