"""How far things can go in the picture: the way that the frame, edges and other things leave."""

import math
from dataclasses import dataclass

import numpy as np

from physagent_studio.agent.rules.scene.measures import FloatArray, Layout
from physagent_studio.arrays import BoolArray
from physagent_studio.contract.picture import beyond_of
from physagent_studio.program.scene.camera import Camera
from physagent_studio.program.scene.shapes import Placed, stretched
from physagent_studio.program.scene.state import Slab


@dataclass(frozen=True, slots=True)
class FramingSettings:
    """How far a motion may go and still be seen."""

    # 0..0.2: of its outline's longer side, by which a thing reaches beyond the frame where a motion
    # ends; what the frame cuts off already may stay as it is
    max_beyond_ratio: float = 0.02
    good_share: float = 0.7  # 0.3..1: of the free way that a motion without an aim takes
    tight_share: float = 0.9  # 0.5..1: of it, where little is free
    wanted_sizes: float = 0.3  # own sizes, 0.1..1: of such a motion, where that much is free
    min_sizes: float = 0.12  # own sizes, 0.05..0.3: likewise, where it is not: less is not seen
    max_way_m: float = 12.0  # 3..50: of any planned motion
    max_lengths: float = 8.0  # own sizes, 2..20: likewise: small things would be lost to the eye
    out_sizes: float = 1.8  # own sizes, 1..3: from where it is last seen whole, to be gone
    out_lengths: float = 1.5  # own lengths, 1..2: likewise, of what is long along its way
    samples_count: int = 160  # 40..500: along the way


FRAMING = FramingSettings()


def free_way(layout: Layout, name: str, way: FloatArray) -> float:
    """How far a thing can go along a level or upward unit direction (3,) and still be seen whole;
    on the level on what carries it and before it meets another thing, m; infinite without a
    camera."""
    free = seen_way(layout, name, way)
    if not math.isfinite(free) or not np.any(way[:2]):
        return free
    free = min(free, _before_edge(layout, name, way))
    here, carrier = layout.position(name), layout.carrier(name)
    return min(
        free,
        *(_before(layout, name, item.name, way, here, carrier) for item in layout.state.objects),
    )


def seen_way(layout: Layout, name: str, way: FloatArray) -> float:
    """How far a thing can go along a unit direction (3,) and still be seen whole, whatever is in
    its way, m; infinite without a camera."""
    body = layout.placed(name)
    if layout.state.camera is None or body is None or body.outline is None:
        return math.inf
    return _seen_way(layout, body, way)


def free_way_from(layout: Layout, name: str, place: FloatArray, way: FloatArray) -> float:
    """The same from another place (3,) on the ground, as it stands now."""
    body = layout.placed(name)
    if layout.state.camera is None or body is None or body.outline is None:
        return math.inf
    moved = Placed(
        body.outline,
        positions=body.positions + (place - layout.position(name)),
        matrices=body.matrices,
    )
    free, ground = _seen_way(layout, moved, way), layout.ground()
    return min(
        free,
        *(_before(layout, name, item.name, way, place, ground) for item in layout.state.objects),
    )


def _seen_way(layout: Layout, body: Placed, way: FloatArray) -> float:
    """How far a body can go along a unit direction (3,) and still be seen whole, m."""
    camera = layout.state.camera
    assert camera is not None
    assert body.outline is not None
    ahead = np.linspace(0.0, FRAMING.max_way_m, FRAMING.samples_count) ** 2 / FRAMING.max_way_m
    here = stretched(body, FRAMING.samples_count)
    moved = Placed(
        body.outline, positions=here.positions + ahead[:, None] * way, matrices=here.matrices
    )
    out = np.flatnonzero(~_is_whole(moved, camera))
    return float(ahead[max(int(out[0]) - 1, 0)]) if len(out) else FRAMING.max_way_m


def seen_along(layout: Layout, name: str, offsets: FloatArray) -> float:
    """Share of a way, offsets (n, 2) from where a thing stands, m, on which it is seen as whole
    as it may be asked to be; 1 without a camera."""
    camera, body = layout.state.camera, layout.placed(name)
    if camera is None or body is None or body.outline is None:
        return 1.0
    here = stretched(body, len(offsets))
    moves = np.column_stack([offsets, np.zeros(len(offsets))])
    moved = Placed(body.outline, positions=here.positions + moves, matrices=here.matrices)
    return float(_is_whole(moved, camera).mean())


def _is_whole(moved: Placed, camera: Camera) -> BoolArray:
    """(T,) whether a body is seen as whole as at its first pose, or nearly all of it."""
    beyond = beyond_of(moved, camera)
    return np.asarray(beyond <= beyond[0] + FRAMING.max_beyond_ratio, bool)


def good_way(layout: Layout, name: str, way: FloatArray) -> float:
    """The way that a motion takes of which nobody says how far it goes, m."""
    free = free_way(layout, name, way)
    size = layout.size(name)
    tight = min(FRAMING.wanted_sizes * size, FRAMING.tight_share * free)
    good = max(FRAMING.good_share * free, tight, FRAMING.min_sizes * size)
    return min(good, FRAMING.max_lengths * size)


def way_hidden(layout: Layout, name: str, way: FloatArray) -> float:
    """How far it goes on from where it was last seen whole until nothing of it is seen, m."""
    long = layout.extent(name, way) + layout.extent(name, -way)
    return max(FRAMING.out_sizes * layout.size(name), FRAMING.out_lengths * long)


def _before_edge(layout: Layout, name: str, way: FloatArray) -> float:
    support = layout.state.support(layout.carrier(name) or "")
    if support is None or not isinstance(support.shape, Slab):
        return math.inf
    return max(layout.way_to_edge(name, way) - layout.extent(name, way), 0.0)


def _before(
    layout: Layout, name: str, other: str, way: FloatArray, here: FloatArray, carrier: str | None
) -> float:
    """Way from a place (3,) on a carrier until it meets another thing that stands on the same;
    infinite where it passes it."""
    if other == name or not layout.has(other) or layout.carrier(other) != carrier:
        return math.inf
    offset = layout.position(other) - here
    across = np.array([-way[1], way[0], 0.0])
    wide = layout.extent(name, across) + layout.extent(other, -across)
    distance = float(offset @ way)
    if distance <= 0 or abs(float(offset @ across)) > wide:
        return math.inf
    return max(distance - layout.extent(name, way) - layout.extent(other, -way), 0.0)
