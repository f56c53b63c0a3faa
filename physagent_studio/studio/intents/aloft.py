"""What the switch of a thing (stands, hangs, floats, falls) and its ground line may ask for."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import Field

from physagent_studio.program import Frozen
from physagent_studio.program.base import Name
from physagent_studio.program.scene.aloft import Carriage
from physagent_studio.studio.intents.directing import Coordinate


class Hold(Frozen):
    """A thing stands, hangs, floats, or nothing holds it."""

    do: Literal["hold"] = "hold"
    name: Name
    how: Carriage


class Ground(Frozen):
    """The ground below a thing in the air is seen at that pixel; only tried unless `keep`."""

    do: Literal["ground"] = "ground"
    name: Name
    end: tuple[Coordinate, Coordinate]
    keep: bool = False


class Raise(Frozen):
    """A thing so many metres above the ground, in its place in the photo."""

    do: Literal["raise"] = "raise"
    name: Name
    height: Annotated[float, Field(ge=0, le=1e4)]


AloftIntent = Hold | Ground | Raise
