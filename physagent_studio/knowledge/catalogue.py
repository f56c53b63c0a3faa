"""The tables beside, read once: things, materials, colours, paces of motion, words of sentences.

`objects.yaml` and its neighbours say in their heads what their columns mean.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import cache
from pathlib import Path
from typing import Annotated, Any, Literal, TypeVar

import yaml
from pydantic import BaseModel, ConfigDict, Field, ValidationError, model_validator

from physagent_studio.errors import InputError

Heading = Literal["long_axis", "short_axis", "any_way"]
Form = Literal[
    "sphere", "ellipsoid", "box", "cylinder", "capsule", "frustum", "revolved", "torus", "inflated"
]
Number = Annotated[float, Field(ge=0)]
Positive = Annotated[float, Field(gt=0)]
Share = Annotated[float, Field(ge=0, le=1)]


class _Row(BaseModel):
    model_config = ConfigDict(frozen=True, extra="forbid", allow_inf_nan=False)


R = TypeVar("R", bound=_Row)


class Kind(_Row):
    """A kind of thing; the head of `objects.yaml` says what each field is, with its unit."""

    name: str
    synonyms: tuple[str, ...] = ()
    size: tuple[Positive, Positive] | None = None
    shapes: tuple[Form, ...] = ()
    material: str
    density: Positive | None = None
    depth: Positive | None = None
    aspect: tuple[Positive, Positive] | None = None
    lies: Positive | None = None
    flat: Positive | None = None
    top: Positive | None = None
    support: Literal["floor", "ramp", "stairs", "rails", "wall", "step", "board"] | None = None
    surface: (
        Literal["level", "flat", "high", "raised", "slope", "flight", "upright", "carrier"] | None
    ) = None
    base: Literal["solid", "splayed"] | None = None
    hollow: Literal["open", "lidded", "soft"] | None = None
    parts: tuple[Literal["frame", "stem", "handle", "back"], ...] = ()
    wheels: Heading | None = None
    colours: tuple[str, ...] = ()
    body: Literal["sheet", "flag", "plant", "grains"] | None = None
    buoyant: bool = False
    young: Positive | None = None
    families: tuple[str, ...] = ()
    ground: str | None = None

    @model_validator(mode="after")
    def _whole(self) -> Kind:
        if (self.size is None) != (not self.shapes):
            raise ValueError("size and shapes stand together")
        return self

    @property
    def is_alive(self) -> bool:
        """Whether it is a person or an animal: mostly water, of no plain form."""
        return self.material == "water_filled" and self.shapes == ("inflated",)


class Material(_Row):
    """A material: density in kg/m³, coefficients as the head of `materials.yaml` says.

    words: what says that a thing is made of it. source: where the figures come from.
    """

    name: str
    words: tuple[str, ...]
    density: Positive
    friction: Number
    restitution: Share
    rolling: Number
    source: str
    colours: tuple[str, ...] = ()


class Colour(_Row):
    """What a word stands for: low and high ends of saturation and value, 0 … 1.

    kind: the one of the bounds that it counts as. hue: middle and half width, degrees; None is any.
    """

    name: str
    kind: str = ""
    hue: tuple[float, float] | None = None
    saturation: tuple[Share, Share]
    value: tuple[Share, Share]


class Bounds(_Row):
    """Bounds of a kind of colour. hues: from, to in degrees, around 360 where from > to."""

    name: str
    hues: tuple[float, float]
    saturation: tuple[Share, Share]
    value: tuple[Share, Share]


class Range(_Row):
    """A range of speeds, and the one that is met with most."""

    low: Number
    usual: Number
    high: Number

    @model_validator(mode="before")
    @classmethod
    def _listed(cls, row: Any) -> Any:
        names = ("low", "usual", "high")
        return dict(zip(names, row, strict=True)) if isinstance(row, list | tuple) else row

    @model_validator(mode="after")
    def _ordered(self) -> Range:
        if not self.low <= self.usual <= self.high:
            raise ValueError("low, usual and high rise in this order")
        return self


class Speeds(_Row):
    """One manner of a motion: metres, m/s; lengths, of the moving thing's own length per second."""

    metres: Range
    lengths: Range


class Pace(_Row):
    """How fast what a sense of motion says is. plain: as said by itself; slow: slowly, gently;
    fast: fast, hard. source: where the figures come from.
    """

    sense: str
    plain: Speeds
    slow: Speeds
    fast: Speeds
    source: Annotated[str, Field(min_length=10)]


class Words(_Row):
    """Words by what they do in a sentence; `words.yaml` says what each list is."""

    times: dict[str, Positive]
    actors: frozenset[str]
    places: dict[Literal["opening", "line", "point", "area"], tuple[str, ...]]
    seen: dict[Literal["frame", "measured_frame", "circle", "line", "band"], frozenset[str]]
    of: frozenset[str]
    stacked: frozenset[str]
    grouped: frozenset[str]
    props: frozenset[str]
    limbs: frozenset[str]
    holders: frozenset[str]
    sounds: frozenset[str]
    laid: frozenset[str]
    pliant: frozenset[str]
    collectives: frozenset[str]
    growth: frozenset[str]
    joined: dict[str, str]
    plurals: dict[str, str]
    singulars: frozenset[str]
    meant: dict[str, str]
    also_things: frozenset[str]
    tints: frozenset[str]
    food: frozenset[str]


class Quantity(_Row):
    """Words for more and less of one quantity, its own nouns, and verbs that say the way too."""

    more: frozenset[str] = frozenset()
    less: frozenset[str] = frozenset()
    of: frozenset[str] = frozenset()
    up: frozenset[str] = frozenset()
    down: frozenset[str] = frozenset()


class Degrees(_Row):
    """The lists of `degrees.yaml`."""

    quantities: dict[str, Quantity]
    deep: frozenset[str]
    raising: frozenset[str]
    lowering: frozenset[str]
    hardly: frozenset[str]
    whole: frozenset[str]
    air: frozenset[str]
    photo: frozenset[str]
    sides: frozenset[str]
    steering: frozenset[str]
    beyond: frozenset[str]
    touching: frozenset[str]
    praise: frozenset[str]
    must: frozenset[str]


@cache
def degrees() -> Degrees:
    """What people say of more and less."""
    return _rows("degrees.yaml", [_read("degrees.yaml")], Degrees)[0]


@cache
def kinds() -> tuple[Kind, ...]:
    """All rows of `objects.yaml`."""
    return _rows("objects.yaml", _read("objects.yaml"), Kind)


@cache
def materials() -> dict[str, Material]:
    """The rows of `materials.yaml` by name."""
    rows = _rows("materials.yaml", _read("materials.yaml"), Material)
    return {row.name: row for row in rows}


@cache
def colours() -> dict[str, Colour]:
    """What English colour words stand for on a screen."""
    rows = _rows("colours.yaml, words", _read("colours.yaml")["words"], Colour)
    return {row.name: row for row in rows}


@cache
def colour_bounds() -> dict[str, Bounds]:
    """Outside of what a thing certainly is not of a kind of colour."""
    rows = _rows("colours.yaml, bounds", _read("colours.yaml")["bounds"], Bounds)
    return {row.name: row for row in rows}


@cache
def word_lists() -> Words:
    """The lists of `words.yaml`."""
    return _rows("words.yaml", [_read("words.yaml")], Words)[0]


def pace_of(sense: str) -> Pace | None:
    """The pace of a sense of motion, None where it has no row."""
    return _by_sense().get(sense)


@cache
def paces() -> tuple[Pace, ...]:
    """All rows of `verbs.yaml`."""
    return _rows("verbs.yaml", _read("verbs.yaml"), Pace)


@cache
def _by_sense() -> dict[str, Pace]:
    return {pace.sense: pace for pace in paces()}


def _read(file: str) -> Any:
    text = Path(__file__).with_name(file).read_text(encoding="utf-8")
    # The parser in C reads the same a good deal faster; not every build of the library has it.
    return yaml.load(text, getattr(yaml, "CSafeLoader", yaml.SafeLoader))


def _rows(file: str, rows: Sequence[Any], model: type[R]) -> tuple[R, ...]:
    found: list[R] = []
    for number, row in enumerate(rows, 1):
        try:
            found.append(model.model_validate(row))
        except ValidationError as error:
            raise InputError(f"{file}, row {number} ({row}): {error}") from None
    return tuple(found)
