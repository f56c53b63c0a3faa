"""Clicked corners moved onto the edges that the picture shows: a hand is a few pixels off."""

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from physagent_studio.arrays import FloatArray
from physagent_studio.knowledge import support_kind
from physagent_studio.program.base import Pixel
from physagent_studio.program.scene.state import Mark, Support
from physagent_studio.reconstruction.photo.line_segments import Segments
from physagent_studio.reconstruction.supports.clicked import CLICKED


@dataclass(frozen=True, slots=True)
class SnapSettings:
    """How far a clicked corner is drawn."""

    reach_ratio: float = 0.012  # 0.003..0.04: over the longer side: a hand is a few pixels off
    max_turn_rad: float = math.radians(5.0)  # 0.02..0.2: between the clicked edge and the picture's
    min_seen_share: float = 0.25  # 0.1..0.8: of a clicked edge along which the picture's is seen


SNAP = SnapSettings()


def snapped(support: Support, found: Segments, size: tuple[int, int]) -> Support:
    """The support with the corners of its marked top where edges of the picture meet.

    found: the picture's straight edges. size: (width, height). Corners move by little; one whose
    two edges are not both seen moves along the one that is. Clicks at the picture's border show
    where an edge leaves it, and stay there.
    """
    corners = support.grounding.marked("top")
    if len(corners) < 3 or support_kind(support.name) != "slab":
        return support
    reach = max(SNAP.reach_ratio * max(size), 4.0)
    sides = [
        _edge_near(np.array(one), np.array(other), found, reach)
        for one, other in zip(corners, [*corners[1:], corners[0]], strict=True)
    ]
    moved = [
        _corner(np.array(corner), sides[k - 1], sides[k], reach, size)
        for k, corner in enumerate(corners)
    ]
    return _with_top(support, moved)


def _edge_near(
    one: FloatArray, other: FloatArray, found: Segments, reach: float
) -> tuple[FloatArray, FloatArray] | None:
    """A point and a unit direction of the picture's edge beside a clicked one; None without."""
    length = float(np.linalg.norm(other - one))
    if length < 4 * reach or not len(found.length):
        return None
    way = (other - one) / length
    normal = np.array([-way[1], way[0]])
    off = (found.ends - one) @ normal
    along = np.clip((found.ends - one) @ way, 0, length)
    shared = np.abs(along[:, 1] - along[:, 0])
    own = (found.ends[:, 1] - found.ends[:, 0]) / found.length[:, None]
    parallel = np.abs(own @ normal) < math.sin(SNAP.max_turn_rad)
    near = parallel & (np.abs(off).max(1) < reach) & (shared > 0.1 * length)
    if not near.any():
        return None
    # Pieces of the strongest line count together; a parallel one beside it does not.
    weight = shared * np.minimum(found.contrast, 40) * np.exp(-np.abs(off).mean(1) / reach)
    best = int(np.flatnonzero(near)[weight[near].argmax()])
    same = near & (np.abs(off.mean(1) - off[best].mean()) < 2.0)
    if float(shared[same].sum()) < SNAP.min_seen_share * length:
        return None
    points = found.ends[same].reshape(-1, 2)
    weights = np.repeat(shared[same], 2)
    middle = np.average(points, axis=0, weights=weights)
    spread = (points - middle) * np.sqrt(weights)[:, None]
    direction = np.linalg.svd(spread)[2][0]
    return middle, direction


def _corner(
    corner: FloatArray,
    before: tuple[FloatArray, FloatArray] | None,
    after: tuple[FloatArray, FloatArray] | None,
    reach: float,
    size: tuple[int, int],
) -> FloatArray:
    """The corner where its two edges meet, or the nearest place on the one that is seen."""
    if _at_the_border(corner, size):
        return corner
    place = corner
    if before is not None and after is not None:
        matrix = np.column_stack([before[1], -after[1]])
        if abs(float(np.linalg.det(matrix))) > math.sin(math.radians(8)):
            place = before[0] + np.linalg.solve(matrix, after[0] - before[0])[0] * before[1]
    else:
        side = before or after
        if side is not None:
            place = side[0] + float((corner - side[0]) @ side[1]) * side[1]
    return place if float(np.linalg.norm(place - corner)) < 2 * reach else corner


def _at_the_border(corner: FloatArray, size: tuple[int, int]) -> bool:
    x, y = corner
    return min(x, y, size[0] - 1 - x, size[1] - 1 - y) <= CLICKED.border_px


def _with_top(support: Support, corners: Sequence[FloatArray]) -> Support:
    rest = iter([(float(x), float(y)) for x, y in corners])

    def put(mark: Mark) -> Mark:
        if mark.role != "top":
            return mark
        place: Pixel = next(rest)
        return mark.model_copy(update={"x": place[0], "y": place[1]})

    marks = tuple(put(mark) for mark in support.grounding.marks)
    grounding = support.grounding.model_copy(update={"marks": marks})
    return support.model_copy(update={"grounding": grounding})
