"""What nothing can bring about, from sizes alone: it is said at once, and not searched for."""

from __future__ import annotations

from physagent_studio.agent.rules.contract.living import is_living
from physagent_studio.agent.rules.scene.measures import Layout
from physagent_studio.knowledge import kind_of
from physagent_studio.language import EventFrame, Place


def too_high(layout: Layout, frame: EventFrame, name: str, relation: str, place: Place) -> str:
    """Why a thing does not get over another on the ground: "rolls over the crate"; "" where it may.

    Nothing rolls over what is as high as its own middle, nor slides over it.
    """
    other = layout.state.object(place.name)
    if relation != "over" or place.part or other is None or other.body.kind != "rigid":
        return ""
    kind = kind_of(name)
    drives = frame.sense == "move" and kind is not None and bool(kind.wheels)
    if not (drives or frame.sense in ("roll", "slide")) or is_living(name):
        return ""
    known = layout.has(name) and layout.has(place.name) and name != place.name
    beside = known and layout.carrier(place.name) in (layout.ground(), layout.base(name))
    if not beside or layout.height(place.name) < layout.height(name) / 2:
        return ""
    it, what = (word.replace("_", " ") for word in (name, place.name))
    return f"the {it} cannot get over the {what}, which is higher than the middle of the {it}"
