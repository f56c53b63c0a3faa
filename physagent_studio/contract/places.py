"""Places that a statement names: landmarks, supports and objects as points, lines and outlines."""

from dataclasses import dataclass, replace
from typing import Literal

import numpy as np

from physagent_studio.arrays import FloatArray
from physagent_studio.contract.facts import Facts
from physagent_studio.contract.track import (
    Outcome,
    Track,
    Window,
    bounded,
    in_order,
    inside_depth,
    unmeasurable,
    worst,
)
from physagent_studio.contract.words import number
from physagent_studio.program.scene.boards import is_hollow
from physagent_studio.program.scene.shapes import Outline, Placed, gap
from physagent_studio.program.scene.state import Landmark
from physagent_studio.program.statements import LandsIn, PassesOver

EDGE_SLACK = 0.1
"""Share of its width by which a support may reach beyond a line that is its edge."""


@dataclass(frozen=True, eq=False, slots=True)
class Place:
    """Where something is, when the window begins.

    points: (K, 3) world, m. An `area` is flat and lies; an `opening` is what one goes through:
    a goal mouth stands, a hole lies. solid: the body that it is the outline of, if it is one.
    within: (2,) a place on the support that a line is the edge of, m, if it is one.
    """

    name: str
    kind: Literal["point", "line", "area", "opening"]
    points: FloatArray
    solid: Placed | None = None
    height: float = 0.0
    within: FloatArray | None = None

    @property
    def centre(self) -> FloatArray:
        """(3,) mean of the points, m."""
        return self.points.mean(axis=0)

    @property
    def normal(self) -> FloatArray:
        """(3,) unit normal of the plane through the points; two posts stand upright."""
        if len(self.points) < 3:
            along = self.points[-1] - self.points[0]
            normal = np.array([-along[1], along[0], 0.0])
        else:
            normal = np.linalg.svd(self.points - self.centre)[2][2]
        length = float(np.linalg.norm(normal))
        return normal / length if length > 1e-9 else np.array([0.0, 0.0, 1.0])

    @property
    def lies(self) -> bool:
        """Whether its plane is nearer to the horizontal than to the vertical."""
        return len(self.points) >= 3 and abs(float(self.normal[2])) >= 0.7


def place_of(name: str, facts: Facts, step: int) -> Place | str:
    """The place of that name as it is at a step, or why it has none."""
    landmark = facts.program.scene.landmark(name)
    if landmark is not None:
        return _landmark(landmark, facts, step)
    solid = facts.placed_at_start(name, step)
    if solid is None:
        return f"where {name} is has not been found"
    if solid.half_space is not None:
        return Place(name, "area", np.zeros((0, 3)), solid)
    return _footprint(name, solid)


def _landmark(landmark: Landmark, facts: Facts, step: int) -> Place | str:
    if not landmark.points:
        return f"where {landmark.name} is has not been found"
    points = np.array(landmark.points, float)
    kind = landmark.kind
    if len(points) == 1:
        kind = "point"
    elif len(points) == 2 and kind == "area":
        kind = "line"
    place = Place(landmark.name, kind, points)
    solid = facts.placed_at_start(landmark.on, step) if landmark.on and kind == "line" else None
    if solid is None or solid.half_space is not None:
        return place
    return replace(place, within=_within(place, _footprint(landmark.name, solid).points))


def _within(place: Place, corners: FloatArray) -> FloatArray | None:
    """(2,) the middle of a support's corners (K, 3) if the line is an edge of it, else None."""
    middle = corners.mean(axis=0, keepdims=True)
    inside, _ = line_progress(middle, place)
    beyond, _ = line_progress(np.concatenate([middle, corners]), place)
    width = -2 * float(inside[0])
    return middle[0, :2] if beyond.max() <= EDGE_SLACK * width else None


def _footprint(name: str, solid: Placed) -> Place:
    """The outline of a body seen from above, at the height of its top."""
    directions = _compass(32)
    corners = np.array([_reach_point(solid, d) for d in directions])
    top = _reach_point(solid, np.array([0.0, 0.0, 1.0]))[2]
    bottom = _reach_point(solid, np.array([0.0, 0.0, -1.0]))[2]
    corners[:, 2] = top
    distinct = np.linalg.norm(corners - np.roll(corners, 1, axis=0), axis=-1) > 1e-6
    return Place(name, "area", corners[distinct], solid, float(top - bottom))


def _compass(count: int) -> FloatArray:
    # Turned a little off the axes, so that no direction is square to a face.
    angles = 2 * np.pi * (np.arange(count) + 0.37) / count
    return np.stack([np.cos(angles), np.sin(angles), np.zeros(count)], axis=-1)


def _reach_point(solid: Placed, direction: FloatArray) -> FloatArray:
    return solid.support(direction[None])[0]


def distance_to(place: Place, points: FloatArray) -> FloatArray:
    """(T,) distance from world points (T, 3) to a place, m; inside an area counts as zero."""
    if place.solid is not None:
        spot = Placed(
            Outline(), positions=points, matrices=np.broadcast_to(np.eye(3), (len(points), 3, 3))
        )
        return np.maximum(gap(spot, place.solid), 0.0)
    if place.kind == "point":
        return np.linalg.norm(points - place.points[0], axis=-1)
    if place.kind == "line":
        return _to_segment(points, place.points[0], place.points[-1])
    flat, height, outline = _in_plane(place, points)
    outside = np.maximum(-inside_depth(flat, outline), 0.0)
    return np.hypot(outside, height)


def gap_to(place: Place, body: Placed) -> FloatArray:
    """(T,) gap between a body's surface and a place, m.

    Lines, points and lying areas reach up as high as the body is large, so that what rolls over
    a line on the ground comes to it with its front.
    """
    if place.solid is not None:
        return gap(body, place.solid)
    points = place.points
    if place.kind in ("point", "line") or place.lies:
        rise = np.array([0.0, 0.0, 2 * body.outline.radius if body.outline else 0.0])
        points = np.concatenate([points, points + rise])
    return gap(body, Placed(Outline(points=points)))


def _to_segment(points: FloatArray, start: FloatArray, end: FloatArray) -> FloatArray:
    along = end - start
    share = np.clip((points - start) @ along / max(float(along @ along), 1e-12), 0, 1)
    return np.linalg.norm(points - (start + share[:, None] * along), axis=-1)


def _in_plane(place: Place, points: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Points in the place's plane (T, 2), heights above it (T,) and its outline (K, 2)."""
    normal = np.array([0.0, 0.0, 1.0]) if place.lies else place.normal
    first = np.cross(normal, [0.0, 0.0, 1.0])
    if np.linalg.norm(first) < 0.1:
        first = np.array([1.0, 0.0, 0.0])
    first /= np.linalg.norm(first)
    axes = np.stack([first, np.cross(normal, first)], axis=-1)
    outline = place.points
    if len(outline) == 2:
        # Two posts: an opening as high as it is wide.
        rise = np.array([0.0, 0.0, float(np.linalg.norm(outline[1] - outline[0]))])
        outline = np.stack([outline[0], outline[1], outline[1] + rise, outline[0] + rise])
    return (
        (points - place.centre) @ axes,
        (points - place.centre) @ normal,
        in_order((outline - place.centre) @ axes),
    )


def lands_in(statement: LandsIn, facts: Facts, window: Window) -> Outcome:
    """Ends within the outline and no higher than it can lie there, or beyond the opening.

    In a thing that moved it is in it where that is in the end.
    """
    track = facts.track(statement.subject, window)
    moved = statement.landmark in facts.rollout.objects
    place = place_of(statement.landmark, facts, window.last if moved else window.first)
    if not isinstance(place, Place):
        return unmeasurable(place)
    if place.kind == "opening" and not place.lies:
        return _behind(track, place)
    if place.kind == "line":
        return _beyond(track, place, at_end=True)
    level = _level(track, place, facts)
    if place.kind == "point":
        away = np.linalg.norm(track.positions[:, :2] - place.points[0, :2], axis=-1)
        inset = track.outline.radius - away
    else:
        flat, _, outline = _in_plane(place, track.positions)
        inset = inside_depth(flat, outline)
    fit = np.minimum(inset, level)
    scale = max(abs(float(inset[0])), track.size)
    return at_the_end(track, fit, scale, "from inside")


def _level(track: Track, place: Place, facts: Facts) -> FloatArray:
    """(W,) how far its centre is below the greatest height at which it still lies there, m."""
    solid = place.solid
    support = facts.program.scene.support(place.name)
    if solid is not None and support is not None and not is_hollow(support.shape):
        # On a table: its top or anything lying on it, not falling past it.
        above = track.positions[:, 2] - float(place.points[:, 2].max())
        return np.minimum(2 * track.outline.radius - above, above + track.outline.radius)
    ceiling = float(place.points[:, 2].max())
    if place.kind == "opening" or solid is not None:
        return ceiling + track.outline.radius - track.positions[:, 2]
    above = track.positions[:, 2] - place.centre[2]
    return 2 * track.outline.radius - np.abs(above)


def at_the_end(track: Track, fit: FloatArray, scale: float, words: str) -> Outcome:
    """fit ≥ 0 at the end; decided when it became so for good."""
    final = float(fit[-1])
    outside = np.nonzero(fit < 0)[0]
    if final >= 0:
        step = track.window.first + (int(outside[-1]) + 1 if len(outside) else 0)
    else:
        step = track.window.first + int(fit.argmax())
    note = "" if final >= 0 else f"{number(-final, 'm')} {words}"
    margin = bounded(final / max(scale, 1e-3))
    return Outcome(margin, final, 0.0, "m", "", step, note, lasting=True)


def _behind(track: Track, place: Place) -> Outcome:
    """Through the opening and on its far side at the end."""
    crossed = _through(track, place)
    _, height, _ = _in_plane(place, track.positions)
    beyond = -np.sign(height[0]) * height if height[0] != 0 else np.abs(height)
    scale = max(abs(float(height[0])), track.size)
    ended = at_the_end(track, beyond, scale, "short of it")
    return worst([crossed, ended])


def _through(track: Track, place: Place) -> Outcome:
    """Crosses the plane of an opening inside its outline."""
    flat, height, outline = _in_plane(place, track.positions)
    inset = inside_depth(flat, outline)
    scale = max(abs(float(height[0])), track.size)
    crossings = np.nonzero(np.sign(height[1:]) * np.sign(height[:-1]) < 0)[0]
    if not len(crossings):
        nearest = int(np.abs(height).argmin())
        miss = max(abs(float(height[nearest])), 1e-6)
        off = max(-float(inset[nearest]), 0.0)
        away = float(np.hypot(miss, off))
        note = f"comes within {number(away, 'm')} of it"
        step = track.window.first + nearest
        return Outcome(bounded(-away / scale), -away, 0.0, "m", "", step, note)
    share = np.abs(height[crossings]) / np.maximum(
        np.abs(height[crossings]) + np.abs(height[crossings + 1]), 1e-12
    )
    points = flat[crossings] + share[:, None] * (flat[crossings + 1] - flat[crossings])
    depths = inside_depth(points, outline)
    best = int(depths.argmax())
    depth = float(depths[best])
    note = "" if depth >= 0 else f"misses it by {number(-depth, 'm')}"
    step = track.window.first + int(crossings[best]) + 1
    return Outcome(bounded(depth / scale), depth, 0.0, "m", "", step, note)


def passes_over(statement: PassesOver, facts: Facts, window: Window) -> Outcome:
    """Its centre crosses the line or the area's edge, goes through the opening, or goes by."""
    track = facts.track(statement.subject, window)
    place = place_of(statement.landmark, facts, window.first)
    if not isinstance(place, Place):
        return unmeasurable(place)
    if place.solid is not None and place.solid.half_space is not None:
        return unmeasurable(f"{place.name} has no edge to pass over")
    if statement.by:
        centre = place.points.mean(axis=0, keepdims=True)
        return _beyond(track, replace(place, kind="point", points=centre), at_end=False)
    if place.kind == "opening":
        return _through(track, place)
    if place.kind in ("line", "point"):
        return _beyond(track, place, at_end=False)
    flat, _, outline = _in_plane(place, track.positions)
    inset = inside_depth(flat, outline)
    progress = inset if inset[0] < 0 else -inset
    scale = max(abs(float(inset[0])), track.size)
    return reached_once(track, progress, scale)


def _beyond(track: Track, place: Place, at_end: bool) -> Outcome:
    """On the far side of a line between its ends, or farther along than a point."""
    progress, lateral = line_progress(track.positions, place, track.size / 2)
    scale = max(abs(float(progress[0])), track.size)
    if at_end:
        return at_the_end(track, np.minimum(progress, np.maximum(lateral, -scale)), scale, "short")
    over = np.nonzero(progress >= 0)[0]
    if len(over) and lateral[over[0]] < 0:
        miss = float(lateral[over[0]])
        note = f"crosses {number(-miss, 'm')} beside it"
        step = track.window.first + int(over[0])
        return Outcome(bounded(miss / scale), miss, 0.0, "m", "", step, note)
    return reached_once(track, progress, scale)


def line_progress(
    points: FloatArray, place: Place, reach: float = 0.0
) -> tuple[FloatArray, FloatArray]:
    """(T,) signed horizontal distance past a line, negative on the side where it starts, and
    (T,) how far inside the line's ends, m. A point counts as the line square to the way there.

    reach: m; what starts no farther beyond the edge of a support than this is past it, for the
    edge is not known better than that, and does not have to come back over it.
    """
    flat, start = points[:, :2], place.points[0, :2]
    if place.kind == "point" or len(place.points) == 1:
        way = start - flat[0]
        unit = way / max(float(np.linalg.norm(way)), 1e-9)
        return (flat - start) @ unit, np.full(len(flat), np.inf)
    end = place.points[-1, :2]
    length = max(float(np.linalg.norm(end - start)), 1e-9)
    along = (end - start) / length
    across = np.array([-along[1], along[0]])
    side = (flat - start) @ across
    sign = 1.0 if side[0] < 0 else -1.0
    if place.within is not None and abs(float(side[0])) <= reach:
        sign = 1.0 if float((place.within - start) @ across) < 0 else -1.0
    position = (flat - start) @ along
    return sign * side, np.minimum(position, length - position)


def reached_once(track: Track, progress: FloatArray, scale: float) -> Outcome:
    """progress ≥ 0 at some time, decided when first reached."""
    best = float(progress.max())
    step = track.first(progress >= 0)
    note = "" if step is not None else f"{number(-best, 'm')} short"
    step = track.window.first + int(progress.argmax()) if step is None else step
    return Outcome(bounded(best / max(scale, 1e-3)), best, 0.0, "m", "", step, note)
