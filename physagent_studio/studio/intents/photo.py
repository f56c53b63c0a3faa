"""What a hand in the photo asks for: masks, scissors, horizon, ramp, size, another shape."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import Field

from physagent_studio.program import Frozen
from physagent_studio.program.base import Name, Pixel, Pixels, Tilt
from physagent_studio.program.scene.state import FormKind, Grounding

Ticket = Annotated[int, Field(ge=0, le=2**53)]


class FindMasks(Frozen):
    """The candidate masks that a grounding would give; nothing is changed yet."""

    do: Literal["masks"] = "masks"
    name: Name
    grounding: Grounding
    ticket: Ticket


class Sketch(Frozen):
    """A photo (base64 of its file) that a new session may be made of: kept to look for masks in."""

    do: Literal["sketch"] = "sketch"
    photo: Annotated[str, Field(max_length=23_000_000)]


class SketchMasks(Frozen):
    """The candidate masks of a thing in that photo; said: all things that are marked in it."""

    do: Literal["sketch_masks"] = "sketch_masks"
    name: Name
    said: Annotated[tuple[tuple[Name, Grounding], ...], Field(max_length=100)]
    ticket: Ticket


class TakeMask(Frozen):
    """The grounding of an object or support as the person wants it; a new name is an object.

    layer: what is wanted is the layer of a stack that the clicks on all of the stack give.
    """

    do: Literal["mask"] = "mask"
    name: Name
    grounding: Grounding
    layer: bool = False


class FindAlike(Frozen):
    """What looks like a thing and is not marked; name "": what the fill covers."""

    do: Literal["like"] = "like"
    name: Annotated[str, Field(max_length=64)] = ""
    ticket: Ticket


class MarkAlike(Frozen):
    """Things in these boxes are like the thing of that name."""

    do: Literal["alike"] = "alike"
    name: Name
    boxes: Annotated[tuple[tuple[Pixels, Pixels, Pixels, Pixels], ...], Field(max_length=16)]


class FindEdge(Frozen):
    """The way along the picture's edges from an anchor to the pointer."""

    do: Literal["edge"] = "edge"
    start: Pixel
    end: Pixel
    ticket: Ticket


class SetHorizon(Frozen):
    """The horizon's row in the middle column, pixels.

    roll: degrees by which it rises to the right; None leaves that as it is.
    """

    do: Literal["horizon"] = "horizon"
    row: Annotated[float, Field(ge=-1e5, le=1e5)]
    roll: Tilt | None = None


class SetSize(Frozen):
    """How large an object is, m."""

    do: Literal["size"] = "size"
    name: Name
    metres: Annotated[float, Field(gt=0, le=1e4)]


class PlaceRamp(Frozen):
    """A ramp by three clicks; without a name a new one."""

    do: Literal["ramp"] = "ramp"
    name: Name | None = None
    toe: Pixel
    foot: Pixel
    top: Pixel


class SwitchForm(Frozen):
    """Another kind of shape for an object; None is the next one."""

    do: Literal["form"] = "form"
    name: Name
    kind: FormKind | None = None


PhotoIntent = (
    FindMasks | TakeMask | FindEdge | SetHorizon | SetSize | PlaceRamp | SwitchForm | Sketch
    | SketchMasks | FindAlike | MarkAlike
)  # fmt: skip
