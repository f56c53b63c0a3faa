"""Places on supports that a prompt names: edges and ends, from the supports' geometry."""

from __future__ import annotations

import math
from collections.abc import Iterable

import numpy as np

from physagent_studio.agent.rules.contract.specs import spot_name
from physagent_studio.agent.rules.scene.measures import WAYS, FloatArray, Layout, place_name
from physagent_studio.agent.rules.schedule.scripts.task import SIDE_WAYS
from physagent_studio.language import Place, Reading
from physagent_studio.program.scene.stairs import profile_of
from physagent_studio.program.scene.state import Landmark, Ramp, Slab


def derived_landmarks(layout: Layout, places: Iterable[Place], reading: Reading) -> list[Landmark]:
    """A landmark for each place that is a part of a resolved support."""
    found: list[Landmark] = []
    for place in places:
        if place.ends and all(layout.has(end) for end in place.ends):
            feet = tuple(_foot(layout, end) for end in place.ends)
            found.append(Landmark(name=place.name, kind="line", points=feet))
        if place.kind != "support" or not place.part:
            continue
        points = _points(layout, place, _speaker(reading, place))
        if place.part == "upper_end" and _is_left(reading, place):
            points = _far_end(layout, place) or points
        if points:
            kind = "line" if len(points) > 1 else "point"
            found.append(Landmark(name=place_name(place), kind=kind, on=place.name, points=points))
    return [*found, *_spots(layout, reading)]


def _spots(layout: Layout, reading: Reading) -> list[Landmark]:
    """The spots behind, in front of or beside things where the prompt has something get to."""
    found: dict[str, Landmark] = {}
    for frame in reading.frames:
        for relation, place in frame.places:
            movers = [n for n in frame.patient if layout.has(n) and n != place.name]
            if relation in SIDE_WAYS and place.part == "center" and movers:
                found |= _half_of(layout, relation, place)
            if relation not in SIDE_WAYS or place.kind != "object" or not layout.has(place.name):
                continue
            ahead = frame.sense in ("stop", "settle") and relation == "in_front"
            if not movers or frame.sense == "be" or ahead or frame.negated:
                continue
            way, name = WAYS[SIDE_WAYS[relation]], spot_name(relation, place)
            reach = layout.extent(place.name, way) + layout.extent(movers[0], way)
            spot = layout.position(place.name) + way * (reach + 0.5 * layout.size(movers[0]))
            spot[2] -= layout.height(place.name) / 2
            found[name] = Landmark(name=name, kind="point", points=(_point(spot),))
    return list(found.values())


def _half_of(layout: Layout, relation: str, place: Place) -> dict[str, Landmark]:
    """The middle of that half of a table's top."""
    support = layout.state.support(place.name)
    slab = support.shape if support is not None else None
    if not isinstance(slab, Slab):
        return {}
    way, name = WAYS[SIDE_WAYS[relation]], spot_name(relation, place)
    cos, sin = math.cos(slab.yaw), math.sin(slab.yaw)
    along = slab.size[0] / 2 * abs(cos), slab.size[1] / 2 * abs(sin)
    spot = np.array([*slab.position[:2], slab.position[2] + slab.size[2] / 2])
    return {
        name: Landmark(
            name=name, kind="point", on=place.name, points=(_point(spot + way * max(along) / 2),)
        )
    }


def _foot(layout: Layout, name: str) -> tuple[float, float, float]:
    """The point below the middle of an object, at the height of what it stands on."""
    x, y, z = layout.position(name)
    return _point(np.array([x, y, z - layout.height(name) / 2]))


def _speaker(reading: Reading, place: Place) -> tuple[str, str | None] | None:
    """The object that has to do with the place, and the way it shall go."""
    for frame in reading.frames:
        if any(p == place for _, p in frame.places) and frame.patient:
            name = frame.patient[0]
            ways = [
                f.direction for f in reading.frames if name in f.patient and f.direction in WAYS
            ]
            return name, next((w for w in ways if w in ("left", "right", "away")), None)
    return None


def _points(
    layout: Layout, place: Place, speaker: tuple[str, str | None] | None
) -> tuple[tuple[float, float, float], ...]:
    support = layout.state.support(place.name)
    shape = support.shape if support is not None else None
    if isinstance(shape, Ramp) and place.part == "center":
        lower, upper = _ramp_line(shape, upper=False), _ramp_line(shape, upper=True)
        return (_point(np.mean([*lower, *upper], axis=0)),)
    if isinstance(shape, Ramp):
        return _ramp_line(shape, upper=place.part == "upper_end")
    if not isinstance(shape, Slab):
        return ()
    top = shape.position[2] + shape.size[2] / 2
    if place.part == "center":
        return ((shape.position[0], shape.position[1], top),)
    return _slab_edge(layout, shape, top, speaker, ends=place.part == "end")


def _is_left(reading: Reading, place: Place) -> bool:
    """Whether something shall come off a place."""
    rows = (row for frame in reading.frames for row in frame.places)
    return any(row in (("off", place), ("from", place)) for row in rows)


def _far_end(layout: Layout, place: Place) -> tuple[tuple[float, float, float], ...]:
    """The line where what lies behind the top edge of a ramp or a flight of steps ends."""
    support = layout.state.support(place.name)
    ramp = support.shape if support is not None else None
    if not isinstance(ramp, Ramp):
        return ()
    return _ramp_line(ramp, upper=True, flat=max(x for x, _ in profile_of(ramp)) - ramp.run)


def _ramp_line(
    ramp: Ramp, upper: bool, flat: float = 0.0
) -> tuple[tuple[float, float, float], ...]:
    ahead = np.array([math.cos(ramp.yaw), math.sin(ramp.yaw), 0.0])
    across = np.array([-ahead[1], ahead[0], 0.0]) * ramp.width / 2
    middle = np.array(ramp.toe, float)
    if upper:
        middle = middle + ahead * (ramp.run + flat) + WAYS["up"] * ramp.rise
    return (_point(middle - across), _point(middle + across))


def _slab_edge(
    layout: Layout,
    slab: Slab,
    top: float,
    speaker: tuple[str, str | None] | None,
    *,
    ends: bool,
) -> tuple[tuple[float, float, float], ...]:
    """The edge that the object goes to, or is nearest to; ends: one across its longer side."""
    cos, sin = math.cos(slab.yaw), math.sin(slab.yaw)
    along = (np.array([cos, sin, 0.0]), np.array([-sin, cos, 0.0]))
    centre = np.array([slab.position[0], slab.position[1], top])
    edges = []
    longer = int(slab.size[1] > slab.size[0])
    for axis in (longer,) if ends else (0, 1):
        for sign in (1.0, -1.0):
            out = along[axis] * sign
            middle = centre + out * slab.size[axis] / 2
            half = along[1 - axis] * slab.size[1 - axis] / 2
            edges.append((out, middle, half))
    if speaker is None or not layout.has(speaker[0]):
        _, middle, half = edges[0]
        return (_point(middle - half), _point(middle + half))
    name, way = speaker
    position = layout.position(name)

    def badness(edge: tuple[FloatArray, FloatArray, FloatArray]) -> float:
        out, middle, _ = edge
        if way is not None:
            return -float(out @ WAYS[way])  # type: ignore[index]
        return float((middle - position) @ out)

    _, middle, half = min(edges, key=badness)
    return (_point(middle - half), _point(middle + half))


def _point(vector: FloatArray) -> tuple[float, float, float]:
    x, y, z = (round(float(part), 5) for part in vector)
    return (x, y, z)


def assume_open(layout: Layout, reading: Reading) -> tuple[tuple[Landmark, ...], tuple[str, ...]]:
    """All landmarks, open goals put where the prompt makes them likely, and what was assumed.

    Nobody has clicked them and the picture did not show them: the event can still be tried,
    and a person sees what was taken for granted.
    """
    found: list[Landmark] = []
    said: list[str] = []
    for landmark in layout.state.landmarks:
        points = landmark.points or _likely(layout, landmark, reading)
        if not landmark.points and points:
            said.append(f"where '{landmark.name}' is was assumed; click it in the photo")
            landmark = landmark.model_copy(update={"points": points, "source": "assumed"})
        found.append(landmark)
    return tuple(found), tuple(said)


def _likely(
    layout: Layout, landmark: Landmark, reading: Reading
) -> tuple[tuple[float, float, float], ...] | None:
    about = [f for f in reading.frames if any(p.name == landmark.name for _, p in f.places)]
    movers = [n for f in about for n in (*f.agent, *f.patient) if layout.has(n)]
    if not movers or landmark.kind != "opening":
        return None
    mover = movers[0]
    ways = [w for f in reading.frames if mover in (*f.patient, *f.agent) for w in (f.direction,)]
    way = WAYS[next((w for w in ways if w in ("left", "right", "toward_camera")), "away")]  # type: ignore[index]
    distance = max(10 * layout.size(mover), 1.0)
    middle = layout.position(mover) + way * distance
    middle[2] = layout.ground_height()
    across = np.array([-way[1], way[0], 0.0]) * distance * 0.6
    feet = (_point(middle - across), _point(middle + across))
    up = WAYS["up"] * max(0.6 * distance, 4 * layout.size(mover))
    return (*feet, _point(middle + across + up), _point(middle - across + up))
