"""What a builder of statements works from, and what it hands back."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from physagent_studio.agent.rules.scene.facing import before_its_back, likely_front
from physagent_studio.agent.rules.scene.measures import OPPOSITE, Layout, level, named_way
from physagent_studio.language import SLOPE_ENDS, EventFrame, Place, Reading
from physagent_studio.program.actions import Direction
from physagent_studio.program.program import Clip
from physagent_studio.program.scene.state import Floor


@dataclass(frozen=True, slots=True)
class SpecSettings:
    """When what holds at the beginning has to be seen."""

    start_steps: int = 20  # 5..60: in which "it stands on …" has to hold
    # of a fall from their own height, .03..0.3: between one and the next of a row that falls in
    # turn; a wave of dominoes takes a tenth to a quarter
    wave_share: float = 0.08
    max_wave_s: float = 0.03  # s, 0.01..0.1: the same of large things
    # of its size, 0.2..1: how far what stood below may be dragged along
    calm_share: float = 0.5
    calm_degrees: float = 15.0  # degrees, 10..45: how far it may tilt
    still_steps: int = 12  # 5..40: in which what "does not move until …" has to be still


SPEC = SpecSettings()


@dataclass(frozen=True)
class Spec:
    """A statement as data, or a composite of `parts`."""

    kind: str
    fields: dict[str, Any] = field(default_factory=dict)
    parts: tuple[Spec, ...] = ()

    def opposite(self) -> Spec:
        """The statement that demands that this one does not hold."""
        # What does not fall over onto its back does not do so onto another side either.
        onto = ("most", "onto") if self.kind == "topples" else ()
        fields = {k: v for k, v in self.fields.items() if k not in onto}
        if fields.pop("negated", False):
            return replace(self, fields=fields)
        return replace(self, fields={**fields, "negated": True})


def spec(kind: str, subject: str, **fields: Any) -> Spec:
    """A statement about one object; None fields are left out."""
    kept = {k: v for k, v in fields.items() if v is not None}
    return Spec(kind, {"subject": subject, **kept})


def any_of(first: Spec, *more: Spec) -> Spec:
    """At least one of the parts."""
    return Spec("any_of", {}, (first, *more)) if more else first


def before(first: Spec, second: Spec) -> Spec:
    """Both, the first earlier."""
    return Spec("before", {}, (first, second))


@dataclass(frozen=True)
class Context:
    """One frame about one of its patients, within the whole reading. steps: of the clip."""

    frame: EventFrame
    subject: str
    index: int
    reading: Reading
    layout: Layout
    senses: Mapping[str, Callable[[Context], Sequence[Spec]]] = field(default_factory=dict)
    steps: int = Clip().steps

    @property
    def size(self) -> float:
        """Mean edge of the subject, m."""
        return self.layout.size(self.subject) if self.layout.has(self.subject) else 0.1

    def length(self, share: float, least: float, most: float) -> float:
        """A threshold that scales with the subject, rounded so that it reads well."""
        return round(min(max(share * self.size, least), most), 3)

    @property
    def earlier(self) -> Sequence[EventFrame]:
        """Frames before this one that are about the same object."""
        return [f for f in self.reading.frames[: self.index] if self.subject in f.patient + f.agent]

    @property
    def later(self) -> Sequence[EventFrame]:
        """Frames after this one that are about the same object."""
        frames = self.reading.frames[self.index + 1 :]
        return [f for f in frames if self.subject in f.patient + f.agent]

    def ways(self) -> tuple[Direction, ...]:
        """The named directions of which one is meant; empty where none is said."""
        frame = self.frame
        off = frame.place("off", "from", "over")
        sloping = frame.place("down", "up") or (off is not None and off.part in SLOPE_ENDS)
        if frame.direction in ("backward", "forward") and sloping:
            # "Slides backwards down the ramp" says how it faces.
            return ()
        return ways_of(frame.direction or frame.origin, frame, self.subject, self.layout)


def ways_of(
    way: str | None, frame: EventFrame, subject: str, layout: Layout
) -> tuple[Direction, ...]:
    """Named directions for a way as said; `forward` and `sideways` depend on the scene."""
    if way == "up" and frame.sense in ("slide", "roll") and _is_level(subject, layout):
        # Towards the upper rim of the picture: on level ground there is no other way up.
        return ("away",)
    if way in ("left", "right", "up", "down", "away", "toward_camera"):
        return (way,)  # type: ignore[return-value]
    if frame.sense == "fall" and not frame.agent and way in ("forward", "backward"):
        # "Falls backwards off the shelf": things face who looks at them.
        slope = layout.downhill(subject) is not None
        if not slope:
            return ("toward_camera",) if way == "forward" else ("away",)
    if way == "forward":
        return (forward(frame, subject, layout),)
    if way == "backward" and frame.agent and subject in frame.patient:
        return (forward(frame, subject, layout),)
    if way == "backward":
        front = likely_front(layout, subject)
        if (downhill := layout.downhill(subject)) is not None:
            # On a slope it says how what has a front faces; what has none goes back up it.
            return (named_way(level(-downhill)),) if front is None else ()
        return ("toward_camera",) if front is None else (OPPOSITE[named_way(front)],)
    if way == "sideways":
        return sideways(subject, layout)
    if way in ("outward", "inward"):
        return apart(frame, subject, layout, inward=way == "inward")
    return ()


def over_way(frame: EventFrame, subject: str, layout: Layout) -> Direction | None:
    """Where a thing falls that falls over backwards, forwards, on its back or its face: an animal
    as it is seen to stand, anything else faces who looks at it. None where that is not said, or
    where something else knocks it over."""
    if frame.agent or subject not in frame.patient:
        return None
    if frame.posture == "supine":
        ahead = before_its_back(layout, subject)
        return "away" if ahead is None else OPPOSITE[named_way(ahead)]
    if frame.posture != "prone":
        if frame.sense not in ("topple", "lean", "lose_balance", "tip_over"):
            return None
        if frame.direction not in ("forward", "backward"):
            return None
    front = likely_front(layout, subject)
    facing: Direction = "toward_camera" if front is None else named_way(front)
    return OPPOSITE[facing] if frame.direction == "backward" else facing


def lies_on(posture: str, subject: str, layout: Layout) -> Direction | None:
    """The side that a thing has down when it lies so, by where that faces at first: what it leans
    its back on, or its front; None where that is not known, or any side does."""
    if posture == "supine" and (ahead := before_its_back(layout, subject)) is not None:
        return OPPOSITE[named_way(ahead)]
    front = likely_front(layout, subject) if posture == "prone" else None
    return None if front is None else named_way(front)


def _is_level(subject: str, layout: Layout) -> bool:
    """Whether a thing stands on level ground, with no slope, steps or wall that lead up."""
    flat = all(isinstance(support.shape, Floor) for support in layout.state.supports)
    return flat and layout.carrier(subject) is not None


def forward(frame: EventFrame, subject: str, layout: Layout) -> Direction:
    """The way a pusher points, else down the slope, else where a thing on wheels, a person or an
    animal faces, else away from the camera."""
    for agent in frame.agent:
        if layout.has(agent) and layout.has(subject):
            way = level(layout.position(subject) - layout.position(agent))
            if float(np.linalg.norm(way)) > 1e-3:
                return named_way(way)
    downhill = layout.downhill(subject)
    if downhill is not None:
        return named_way(level(downhill))
    front = likely_front(layout, subject)
    return "away" if front is None else named_way(front)


def apart(
    frame: EventFrame, subject: str, layout: Layout, *, inward: bool = False
) -> tuple[Direction, ...]:
    """Away from the others that do the same, or towards them."""
    placed = [name for name in frame.patient if layout.has(name)]
    if len(placed) < 2 or subject not in placed:
        return ()
    middle = np.mean([layout.position(name) for name in placed], axis=0)
    way = level(layout.position(subject) - middle) * (-1.0 if inward else 1.0)
    return (named_way(way),) if float(np.linalg.norm(way)) > 1e-3 else ()


def sideways(subject: str, layout: Layout) -> tuple[Direction, Direction]:
    """Left and right, or across the slope that the object is on."""
    downhill = layout.downhill(subject)
    if downhill is not None and named_way(level(downhill)) in ("left", "right"):
        return ("away", "toward_camera")
    return ("left", "right")


def spot_name(relation: str, place: Place) -> str:
    """The name of the spot beside a thing that a program may aim at: `behind_cup`."""
    return f"{relation}_{place.name}"[:64]
