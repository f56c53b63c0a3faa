"""Which way what has a front faces, as far as a scene says: its longer side, a likely front."""

import math
from dataclasses import dataclass, replace

import numpy as np

from physagent_studio.agent.rules.scene.measures import FloatArray, Layout
from physagent_studio.knowledge import Kind, kind_of
from physagent_studio.language import EventFrame, Place, Reading
from physagent_studio.program.rotations import matrix_of
from physagent_studio.program.scene.forms import Inflated, Meshed


@dataclass(frozen=True, slots=True)
class FacingSettings:
    """What shows which way a thing lies, and which of its ends is taken for the front."""

    min_long_ratio: float = 1.3  # 1.1..2: length over width of what shows which way it lies
    min_side_ratio: float = 1.15  # 1..1.5: length over height of an animal seen from its side
    # cosine, 0.1..0.7: of its axis and a way, from which one of its ends lies that way
    min_along_cosine: float = math.cos(math.radians(67.5))
    top_share: float = 0.3  # 0.1..0.5: of its height, which is its top
    min_back_share: float = 0.1  # 0.05..0.4: of its width, by which its top is off its middle
    # share, 0..0.3: of the picture's width, off its middle: what has more room before it than that
    min_room_share: float = 0.1


FACING = FacingSettings()


def long_axis(layout: Layout, name: str) -> tuple[FloatArray, bool]:
    """Level unit axis (3,) of the longer side of its outline, and whether it clearly is longer."""
    item = layout.state.object(name)
    if item is not None and isinstance(item.shape, Inflated) and item.shape.turn is None:
        # It faces the view, and its depth is a guess: how it lies shows in the picture.
        across = np.array([1.0, 0.0, 0.0])
        wide = layout.extent(name, across) + layout.extent(name, -across)
        return across, bool(wide > FACING.min_side_ratio * layout.height(name))
    ways = [
        np.array([math.cos(angle), math.sin(angle), 0.0])
        for angle in np.radians(np.arange(0.0, 180.0, 1.0))
    ]
    extents = np.array([layout.extent(name, way) + layout.extent(name, -way) for way in ways])
    others = np.roll(extents, -90)
    # The smallest upright box around it, from above, lies as it does.
    best = int(np.argmin(extents * others))
    if extents[best] < others[best]:
        best = (best + 90) % 180
    return ways[best], bool(extents[best] > FACING.min_long_ratio * others[best])


def likely_front(layout: Layout, name: str) -> FloatArray | None:
    """Level unit direction (3,) in which a thing on wheels, a person or an animal is likely to
    face: as its wheels have it already, else as photographs are taken, with more room before it
    than behind it, or from before it. None for what has no front."""
    item, kind = layout.state.object(name), _facing_as(name)
    if kind is not None and kind.wheels == "any_way":
        return before_its_back(layout, name)
    if item is not None and item.wheels is not None:
        angle = math.radians(item.wheels.heading)
        return np.array([math.cos(angle), math.sin(angle), 0.0])
    if kind is None or not layout.has(name):
        return None
    if (front := before_its_back(layout, name)) is not None:
        return front
    if not (kind.wheels or kind.is_alive):
        return None
    axis, shown = long_axis(layout, name)
    if kind.wheels == "short_axis":
        axis = np.array([-axis[1], axis[0], 0.0])
    return likely_end(layout, name, axis if shown else None)


def _facing_as(name: str) -> Kind | None:
    """The kind whose front a thing has: a figurine of an animal faces as the animal does."""
    kind = kind_of(name)
    of = kind_of(name.rpartition("_")[0])
    is_figure = kind is not None and kind.shapes == ("inflated",)
    return of if is_figure and of is not None and of.is_alive else kind


def before_its_back(layout: Layout, name: str) -> FloatArray | None:
    """Level unit direction (3,) in which what has a back to lean on faces: away from the side on
    which it is highest; None for what has none, or where that is in its middle."""
    item, kind = layout.state.object(name), kind_of(name)
    if item is None or kind is None or "back" not in kind.parts:
        return None
    if not isinstance(item.shape, Inflated | Meshed) or not item.shape.hull:
        return None
    corners = np.array(item.shape.hull) @ matrix_of(item.rotation).T
    low, high = corners.min(axis=0), corners.max(axis=0)
    top = corners[corners[:, 2] > high[2] - FACING.top_share * (high[2] - low[2])]
    aside = (top[:, 0].mean() - (low[0] + high[0]) / 2) / max(high[0] - low[0], 1e-9)
    if abs(aside) < FACING.min_back_share:
        return None
    return np.array([-1.0 if aside > 0 else 1.0, 0.0, 0.0])


def likely_end(layout: Layout, name: str, axis: FloatArray | None) -> FloatArray:
    """Which way along its axis (3,), level unit, a thing is likely to face; see `likely_front`. It
    faces the camera where no axis is seen."""
    if axis is None:
        return np.array([0.0, -1.0, 0.0])
    aside = _off_the_middle(layout, name)
    across = abs(axis[0]) > FACING.min_along_cosine
    if abs(axis[1]) < FACING.min_along_cosine or (across and abs(aside) > FACING.min_room_share):
        return -axis if axis[0] * aside > 0 else axis
    return axis if axis[1] < 0 else -axis


def _off_the_middle(layout: Layout, name: str) -> float:
    """How far right of the picture's middle a thing is, in shares of the width."""
    camera, spot = layout.state.camera, layout.position(name)
    if camera is None:
        return float(spot[0])
    return float(camera.project(spot[None])[0][0, 0]) / camera.size[0] - 0.5


def backwards_to_its_aim(reading: Reading, layout: Layout) -> Reading:
    """ "The phone shoots backwards and knocks over the glass": what has no front goes to what it is
    told to meet, wherever that lies; the reading with that said."""
    frames: list[EventFrame] = []
    for index, frame in enumerate(reading.frames):
        name = frame.patient[0] if len(frame.patient) == 1 and not frame.agent else ""
        back = frame.direction == "backward" and frame.sense not in ("fall", "topple", "lean")
        if back and layout.has(name) and likely_front(layout, name) is None:
            met = [n for f in reading.frames[index:] if name in f.agent for n in f.patient]
            own = frame.place("toward", "into", "against", "at")
            if own is not None or (met and layout.has(met[0])):
                aim = () if own is not None else (("toward", Place(met[0], "object")),)
                manner = frame.manner - {"backwards"}
                places = (*aim, *frame.places)
                frame = replace(frame, direction=None, manner=manner, places=places)
        frames.append(frame)
    return replace(reading, frames=tuple(frames))
