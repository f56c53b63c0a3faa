"""What the two sliders of a result and the arrow in the photo may ask for."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import Field

from physagent_studio.program import Frozen
from physagent_studio.program.base import Name
from physagent_studio.program.timing import FASTEST, SLOWEST

Ratio = Annotated[float, Field(ge=0.1, le=10)]
Coordinate = Annotated[float, Field(ge=-1e5, le=1e5)]


class Scale(Frozen):
    """All efforts of the event by one ratio, or another pace; only tried unless `keep`."""

    do: Literal["scale"] = "scale"
    effort: Ratio = 1.0
    pace: Annotated[float, Field(ge=SLOWEST, le=FASTEST)] | None = None
    keep: bool = False


class AimAt(Frozen):
    """A thing goes towards a pixel of the photo; only tried unless `keep`."""

    do: Literal["aim"] = "aim"
    name: Name
    end: tuple[Coordinate, Coordinate]
    keep: bool = False


class Measure(Frozen):
    """How far two pixels of the photo are apart in the scene; nothing is changed."""

    do: Literal["measure"] = "measure"
    a: tuple[Coordinate, Coordinate]
    b: tuple[Coordinate, Coordinate]


class Hide(Frozen):
    """Hides a thing in the 3D view, or all others (`only`), or shows everything again (`none`)."""

    do: Literal["hide"] = "hide"
    name: Annotated[str, Field(max_length=200)] = ""
    how: Literal["this", "only", "none"] = "this"


DirectingIntent = Scale | AimAt | Measure | Hide
