"""A level top that things are seen to stand on, though nobody clicked it: bounded by its edges.

What fills most of a picture, a table or a counter seen from near by, is no region that grows from
a click: grain, light and reflections divide it. Its edges are found instead. A line of the
picture ends the top where the side towards the things looks like what is around their feet and the
other side does not, along most of the line: joints between boards, and the edges of what lies
on the top, have the top on both sides of them somewhere on their way.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from physagent_studio.arrays import FloatArray
from physagent_studio.reconstruction.photo.line_segments import Segments
from physagent_studio.reconstruction.photo.regions import BoolArray, grow
from physagent_studio.reconstruction.supports.stances import Stance
from physagent_studio.records.case import Image


@dataclass(frozen=True, slots=True)
class TopSettings:
    """Which lines of the picture end a top that nobody clicked."""

    # 0.02..0.2: over the longer side: shorter edges are grain and things
    min_edge_ratio: float = 0.06
    max_bend_rad: float = 0.12  # 0.05..0.4: of an edge as long as the next field says
    # 0.05..0.5: over the longer side: longer edges may bend the more
    bend_length_ratio: float = 0.15
    spacing_px: float = 3.0  # 1..10: between the places along a line that are looked at
    lightness_weight: float = 0.5  # weight, 0..1: of steps in lightness: one top is lit and shaded
    like_lab: float = 14.0  # 6..30: up to which a pixel is like the top
    min_step_lab: float = 6.0  # 2..15: from which a line is an edge there
    ring_ratio: float = 0.1  # 0.03..0.4: over a thing's width: what is around its foot
    # 0.1..0.6: of the colours there that one has to be like: bits of floor are not
    min_common_share: float = 0.3
    # 0.5..1: of a line that is an edge, where the top is on its near side
    min_end_share: float = 0.7
    min_own_share: float = 0.5  # 0.3..1: of the segment itself that is an edge
    # 0.03..0.3: over the longer side: length of the edge along its line
    min_line_ratio: float = 0.09
    # 0.01..0.1: the same, where the edge is all that is left of its line
    min_whole_ratio: float = 0.04
    whole_share: float = 0.6  # 0.4..1: of what other lines have left, from which it is
    # 0..0.3: over a thing's width: of its base's middle, seen past an edge
    max_overhang_ratio: float = 0.1


TOP = TopSettings()


@dataclass(frozen=True, eq=False, slots=True)
class Top:
    """region: (H, W) pixels of the top, without the things on it. edges: those that end it."""

    region: BoolArray
    edges: Segments


def top_around(
    image: Image,
    found: Segments,
    stances: Sequence[Stance],
    bases: FloatArray,
    covered: BoolArray,
) -> Top | None:
    """The level top on which things stand, as far as the picture shows it.

    found: edges of the picture. stances: of the things. bases: (N, 2) pixels of the middles of
    what they stand with. covered: (H, W) pixels of all things. None where the ground around their
    feet is not seen.
    """
    lab = _smooth_lab(image)
    looks = _around_feet(lab, stances, covered)
    if not len(looks):
        return None
    free = ~grow(covered, 3)
    widths = np.array([float(s.width) for s in stances])
    inside = np.ones(covered.shape, bool)
    rows, columns = np.indices(covered.shape)
    kept: list[int] = []
    # A short side is seen to be whole only once the long ones have cut off the rest of its line.
    for k in [*_able(found, free), *_able(found, free)]:
        line = _line(found.ends[k], bases)
        if k in kept or ((bases @ line[:2] + line[2]) < -TOP.max_overhang_ratio * widths).any():
            continue
        if _ends_here(lab, line, found.ends[k], looks, free, inside):
            kept.append(k)
            inside &= line[0] * columns + line[1] * rows + line[2] > 0
    return Top(inside & ~covered, found.only(np.array(kept, int)))


def _able(found: Segments, free: BoolArray) -> list[int]:
    """Edges that may be looked at, longest first: straight, long, and not those of things."""
    side = max(free.shape)
    straight = found.bend < TOP.max_bend_rad * np.maximum(
        1.0, found.length / (TOP.bend_length_ratio * side)
    )
    able = straight & (found.length > TOP.min_edge_ratio * side) & _clear(found.ends, free)
    order = np.argsort(-found.length, kind="stable")
    return [int(k) for k in order if able[k]]


def _smooth_lab(image: Image) -> FloatArray:
    """(H, W, 3) colours without grain, lightness weighted."""
    sigma = 0.002 * max(image.shape[:2])
    lab = cv2.cvtColor(cv2.GaussianBlur(image, (0, 0), sigma), cv2.COLOR_RGB2LAB).astype(float)
    return lab * (TOP.lightness_weight, 1.0, 1.0)


def _around_feet(lab: FloatArray, stances: Sequence[Stance], covered: BoolArray) -> FloatArray:
    """(N, 3) colours of what lies around the feet of things, level with them or nearer."""
    looks = []
    for stance in stances:
        x0, _, x1, y1 = stance.box
        reach = max(8, round(TOP.ring_ratio * (x1 - x0)))
        ring = np.zeros(covered.shape, bool)
        top = max(0, y1 - max(4, round(0.15 * stance.height)))
        ring[top : y1 + reach, max(0, x0 - reach) : x1 + reach] = True
        ring &= ~grow(covered, 3)
        own = lab[ring]
        looks.append(_usual(own[:: max(1, len(own) // 64)]))
    return np.concatenate(looks) if looks else np.zeros((0, 3))


def _usual(looks: FloatArray) -> FloatArray:
    """Of colours (N, 3) those that many others are like: a bit of floor seen there is no top."""
    off = np.linalg.norm(looks[:, None] - looks[None], axis=2)
    return looks[(off < TOP.like_lab).mean(1) > TOP.min_common_share] if len(looks) else looks


def _clear(ends: FloatArray, free: BoolArray) -> NDArray[np.bool_]:
    """(N,) whether most of each edge (N, 2, 2) is no edge of a thing."""
    share = np.linspace(0.05, 0.95, 16)[None, :, None]
    spots = (ends[:, :1] * (1 - share) + ends[:, 1:] * share).astype(int)
    x = np.clip(spots[..., 0], 0, free.shape[1] - 1)
    y = np.clip(spots[..., 1], 0, free.shape[0] - 1)
    return free[y, x].mean(1) > 0.5


def _line(ends: FloatArray, bases: FloatArray) -> FloatArray:
    """(3,) a, b, c of the line through an edge (2, 2), a x + b y + c > 0 towards the bases, px."""
    way = ends[1] - ends[0]
    normal = np.array([-way[1], way[0]]) / max(float(np.hypot(*way)), 1e-9)
    line = np.array([*normal, -float(normal @ ends[0])])
    return line if float(np.median(bases @ line[:2] + line[2])) > 0 else -line


def _ends_here(
    lab: FloatArray,
    line: FloatArray,
    ends: FloatArray,
    looks: FloatArray,
    free: BoolArray,
    inside: BoolArray,
) -> bool:
    """Whether the top ends at a line, wherever the top is seen on the near side of it.

    ends: (2, 2) of the edge itself. free: (H, W) pixels of no thing. inside: those where the top
    may still be.
    """
    spots = _across_picture(line, free.shape)
    if not len(spots):
        return False
    strip = np.linspace(0.004, 0.016, 5) * max(free.shape)
    near, seen = _beside(lab, spots, line[:2], strip, free & inside)
    far, beyond = _beside(lab, spots, -line[:2], strip, np.ones_like(free))
    off = np.linalg.norm(near[:, None] - looks[None], axis=2).min(1)
    step = np.linalg.norm(near - far, axis=1)
    seen &= beyond
    edge = seen & (off < TOP.like_lab) & (step > TOP.min_step_lab)
    on = seen & (off < TOP.min_step_lab) & (step < TOP.min_step_lab)
    share = ((spots - ends[0]) @ (ends[1] - ends[0])) / float(np.sum((ends[1] - ends[0]) ** 2))
    own = (share > 0) & (share < 1) & _beside(lab, spots, line[:2], strip, free)[1]
    # A side of a top that is seen flat is short: it does where it is all that is left of its line.
    least = TOP.min_whole_ratio if edge.sum() > TOP.whole_share * seen.sum() else TOP.min_line_ratio
    long = edge.sum() * TOP.spacing_px > least * max(free.shape)
    clear = (edge & own).sum() > TOP.min_own_share * own.sum()
    return bool(long and clear and edge.sum() >= TOP.min_end_share * (edge | on).sum())


def _across_picture(line: FloatArray, size: tuple[int, ...]) -> FloatArray:
    """(N, 2) places along a line from border to border of the picture."""
    height, width = size
    a, b, c = line
    crossings = []
    if abs(b) > 1e-9:
        crossings += [(x, -(a * x + c) / b) for x in (0.0, width - 1.0)]
    if abs(a) > 1e-9:
        crossings += [(-(b * y + c) / a, y) for y in (0.0, height - 1.0)]
    inside = [p for p in crossings if -1 <= p[0] <= width and -1 <= p[1] <= height]
    if len(inside) < 2:
        return np.zeros((0, 2))
    first = np.array(inside[0])
    last = np.array(max(inside, key=lambda p: float(np.hypot(*(np.array(p) - first)))))
    count = max(2, int(np.hypot(*(last - first)) / TOP.spacing_px))
    return first + np.linspace(0.01, 0.99, count)[:, None] * (last - first)


def _beside(
    lab: FloatArray, spots: FloatArray, way: FloatArray, strip: FloatArray, free: BoolArray
) -> tuple[FloatArray, BoolArray]:
    """(N, 3) mean colour beside each place, at the distances `strip` along `way`; and (N,)

    whether all of that is in the picture and free.
    """
    places = np.round(spots[:, None] + strip[None, :, None] * way).astype(int)
    x, y = places[..., 0], places[..., 1]
    height, width = free.shape
    fine = (x >= 0) & (y >= 0) & (x < width) & (y < height)
    x, y = np.clip(x, 0, width - 1), np.clip(y, 0, height - 1)
    return lab[y, x].mean(1), (fine & free[y, x]).all(1)
