"""Shafts beside a mask: poles, trunks, necks and handles between two straight edges.

Patches of one colour cut a shaft to pieces wherever its shine or what is behind it changes. Its two
edges, sought in lightness and in both tints (LSD, Grompone von Gioi et al. 2012), stay parallel.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace

import cv2
import numpy as np
from numpy.typing import NDArray

from physagent_studio.reconstruction.masks.grabcut import side_by_side
from physagent_studio.reconstruction.masks.parts.evidence import Patch
from physagent_studio.reconstruction.photo.regions import BoolArray, disc, grow, shrink

FloatArray = NDArray[np.float64]
CHANNELS = ((0, 1.0), (1, 4.0), (2, 4.0))
"""Channels of Lab in which edges are sought, and how much their steps are enhanced."""
ENLARGED = 2.0
"""By how much the picture is enlarged, so that both edges of what is 3 pixels wide are found."""
SHORTEST = 5.0
"""Pixels of an edge."""
TURN = 10.0
"""Degrees by which the two edges of a shaft may differ."""
NARROW, WIDE = 2.5, 0.38
"""Pixels between the edges at least, and share of the mask's size at most."""
LONG, TAPER = 1.3, 0.4
"""Length over width at least, and how much of the width may go from end to end at most."""
GAP, PART = 6.0, 0.3
"""Pixels, or one and a half widths, or part of the length between the edges' end and the mask."""
JOINED = 0.8
"""Share of a shaft outside of the mask below which a part of it is taken to be in the mask."""
BEYOND, IN_LINE = 15.0, 2.5
"""Pixels within which an edge goes on behind the mask, and that it may be out of line."""
SOON = 128
"""Steps after which most lines through a mask have left it."""
SMOOTH = 0.70
"""Share of a small disc at an end of the contact that is covered where the outline runs on."""


def edges_of(lab: NDArray[np.float32]) -> FloatArray:
    """(N, 4) x0, y0, x1, y1 of straight edges of lightness or tint; lab (H, W, 3), 0 … 255."""

    def lines(one: tuple[int, float]) -> FloatArray:
        channel, enhanced = one
        plane = lab[..., channel]
        plane = plane if channel == 0 else cv2.GaussianBlur(plane, (0, 0), 0.7)
        grey = np.clip((plane - 128) * enhanced + 128, 0, 255).astype(np.uint8)
        large = cv2.resize(grey, None, fx=ENLARGED, fy=ENLARGED, interpolation=cv2.INTER_LINEAR)
        found = cv2.createLineSegmentDetector().detect(large)[0]
        return np.zeros((0, 4)) if found is None else np.asarray(found, float).reshape(-1, 4)

    edges = np.concatenate(side_by_side(lines, CHANNELS)) / ENLARGED
    return edges[np.hypot(edges[:, 2] - edges[:, 0], edges[:, 3] - edges[:, 1]) > SHORTEST]


@dataclass(frozen=True, eq=False, slots=True)
class Strips:
    """What lies between two edges of a picture where they run side by side, M of them.

    edges: (N, 4) all of the picture. start, axis, across: (M, 2) a point and the directions along
    and across. low, high: (M,) pixels from it along the axis between which both edges run. aside,
    slope: (M, 2) how far across each of both lies at the point, and how that changes along.
    """

    edges: FloatArray
    start: FloatArray
    axis: FloatArray
    across: FloatArray
    low: FloatArray
    high: FloatArray
    aside: FloatArray
    slope: FloatArray

    def side(self, which: int, at: FloatArray) -> FloatArray:
        """(M, 2) where one of both edges is, at places (M,) along the axis."""
        aside = self.aside[:, which] + self.slope[:, which] * at
        return self.start + self.axis * at[:, None] + self.across * aside[:, None]

    def widths(self) -> FloatArray:
        """(M, 2) pixels between both edges, at one end and at the other."""
        ends = (self.low, self.high)
        return np.stack(
            [np.linalg.norm(self.side(0, t) - self.side(1, t), axis=1) for t in ends], 1
        )

    def kept(self, which: BoolArray) -> Strips:
        """Some of them (M,)."""
        fields = ("start", "axis", "across", "low", "high", "aside", "slope")
        return replace(self, **{name: getattr(self, name)[which] for name in fields})


def strips_of(edges: FloatArray, widest: float) -> Strips:
    """The strips between edges (N, 4), long and even enough for shafts, `widest` pixels at most."""
    pairs = _pairs(edges, widest)
    one, other = (edges[pairs[:, k]].reshape(-1, 2, 2) for k in (0, 1))
    first, second = one[:, 1] - one[:, 0], other[:, 1] - other[:, 0]
    same = np.sign((first * second).sum(1))[:, None]
    axis = first + np.where(same == 0, 1.0, same) * second
    axis /= np.linalg.norm(axis, axis=1)[:, None]
    across = np.stack([-axis[:, 1], axis[:, 0]], 1)
    points = np.stack([one, other], 1) - one[:, None, :1]
    along = (points * axis[:, None, None]).sum(3)
    aside = (points * across[:, None, None]).sum(3)
    slope = (aside[..., 1] - aside[..., 0]) / (along[..., 1] - along[..., 0])
    low, high = along.min(2).max(1), along.max(2).min(1)
    aside = aside[..., 0] - slope * along[..., 0]
    all_ = Strips(edges, one[:, 0], axis, across, low, high, aside, slope)
    width = all_.widths()
    mean = width.mean(1)
    even = (np.abs(width[:, 0] - width[:, 1]) <= TAPER * mean) & (high - low >= LONG * mean)
    return all_.kept(even & (mean > NARROW) & (mean < widest))


def shafts_beside(
    strips: Strips,
    mask: BoolArray,
    barred: BoolArray,
    open_: tuple[bool, bool, bool, bool] = (False, False, False, False),
    about: BoolArray | None = None,
) -> Iterator[Patch]:
    """The strips that start at the mask (H, W).

    None that passes behind the mask, holds what is barred (H, W) or reaches a rim, left, top, right
    or low, that is not `open_`. about: (H, W) where those are that are wanted; None for everywhere.
    """
    size = np.array(mask.shape[::-1])
    for quad in _at_mask(strips, mask):
        at_rim = (*(quad.min(0) < 1), *(quad.max(0) > size - 2))
        if any(rim and not free for rim, free in zip(at_rim, open_, strict=True)):
            continue
        region = np.zeros(mask.shape, np.uint8)
        cv2.fillPoly(region, [np.rint(quad * 16).astype(np.int32)], 1, shift=4)
        x0, y0 = np.maximum(np.floor(quad.min(0)).astype(int) - 1, 0)
        window = (slice(y0, int(quad[:, 1].max()) + 3), slice(x0, int(quad[:, 0].max()) + 3))
        strip, own = region[window].astype(bool), mask[window]
        free = strip & ~own
        if np.count_nonzero(free) < JOINED * np.count_nonzero(strip):
            # A part of it has joined already: no seams along that one.
            free &= grow(strip & ~grow(own, 2), 3)
        if not free.any() or (free & barred[window]).any():
            continue
        if about is not None and not (free & about[window]).any():
            continue
        if not _passes_behind(quad, strips.edges, mask):
            rows, columns = np.nonzero(free)
            yield Patch.at(rows + y0, columns + x0, mask.shape)


def _at_mask(strips: Strips, mask: BoolArray) -> FloatArray:
    """(K, 4, 2) corners of the strips that come to the mask (H, W), the first and last at it."""
    reach = cv2.distanceTransform((~mask).astype(np.uint8), cv2.DIST_L2, 3)
    far = []
    for at in (strips.low, strips.high):
        middle = (strips.side(0, at) + strips.side(1, at)) / 2
        x, y = np.clip(np.rint(middle), 0, np.array(mask.shape[::-1]) - 1).astype(int).T
        far.append(reach[y, x])
    gap = np.maximum(
        GAP, np.maximum(1.5 * strips.widths().mean(1), PART * (strips.high - strips.low))
    )
    near = np.minimum(*far) <= gap
    strips, (to_low, to_high) = strips.kept(near), (one[near] for one in far)
    from_low = to_low <= to_high
    start = np.where(from_low, strips.low - to_low - 2, strips.high + to_high + 2)
    end = np.where(from_low, strips.high, strips.low)
    corners = ((0, start), (0, end), (1, end), (1, start))
    return np.stack([strips.side(which, at) for which, at in corners], 1)


def runs_on(patch: Patch, mask: BoolArray) -> bool:
    """Whether the outline of the mask (H, W) runs on along the patch at both ends of their contact.

    A part bulges from the thing or prolongs it; what is behind it meets its outline at a corner.
    """
    window = tuple(slice(max(0, side.start - 4), side.stop + 4) for side in patch.window)
    own = mask[window]
    other = grow(patch.region[window], 1) & ~own
    both = cv2.morphologyEx((own | other).astype(np.uint8), cv2.MORPH_CLOSE, disc(1))
    size = float(np.sqrt(np.count_nonzero(mask)))
    spot = disc(int(np.clip(round(0.06 * size), 3, 7))).astype(np.float32)
    covered = cv2.filter2D(
        both.astype(np.float32), -1, spot / spot.sum(), borderType=cv2.BORDER_CONSTANT
    )
    rim = both.astype(bool) & ~shrink(both.astype(bool), 1)
    ends = rim & grow(own, 2) & grow(other, 2)
    count, numbers = cv2.connectedComponents(ends.astype(np.uint8), connectivity=8)
    return count == 3 and all(covered[numbers == k].max() <= SMOOTH for k in (1, 2))


def _pairs(edges: FloatArray, widest: float) -> NDArray[np.int64]:
    """(M, 2) numbers of edges that run beside each other, nearly parallel."""
    if not len(edges):
        return np.zeros((0, 2), np.int64)
    along = edges[:, 2:] - edges[:, :2]
    length = np.hypot(along[:, 0], along[:, 1])
    unit = along / length[:, None]
    parallel = np.abs(unit @ unit.T) > np.cos(np.deg2rad(TURN))
    one, other = np.nonzero(np.triu(parallel, 1))
    middle = (edges[:, :2] + edges[:, 2:]) / 2
    apart = middle[other] - middle[one]
    across = np.abs(apart[:, 1] * unit[one, 0] - apart[:, 0] * unit[one, 1])
    ahead = np.abs(apart[:, 0] * unit[one, 0] + apart[:, 1] * unit[one, 1])
    found = ahead < (length[other] + length[one]) / 2
    found &= (across > NARROW - 0.5) & (across < 1.1 * widest)
    return np.stack([one, other], 1)[found]


def _held(
    mask: BoolArray, start: FloatArray, step: FloatArray, count: int
) -> tuple[int, int] | None:
    """The first of so many steps from a point that is in the mask (H, W), and the one that is out
    of it again, `count` for none; None where it never is in the mask."""
    line = start + np.arange(0.0, count)[:, None] * step
    x, y = np.clip(np.rint(line), 0, np.array(mask.shape[::-1]) - 1).astype(int).T
    inside = mask[y, x]
    first = int(np.argmax(inside))
    if not inside[first]:
        return None
    return first, first + int(np.argmin(np.append(inside[first:], False)))


def _passes_behind(quad: FloatArray, edges: FloatArray, mask: BoolArray) -> bool:
    """Whether an edge of the shaft goes on straight where its line leaves the mask again.

    quad: (4, 2) corners, the first and the last at the mask.
    """
    inward = quad[0] + quad[3] - quad[1] - quad[2]
    inward /= np.linalg.norm(inward)
    start, longest = (quad[0] + quad[3]) / 2, 2 * max(mask.shape)
    # Most lines are out of the mask again soon.
    held = _held(mask, start, inward, min(SOON, longest))
    if held is None or held[1] >= SOON:
        held = _held(mask, start, inward, longest)
    if held is None:
        return False
    out = held[1]
    x0, y0, x1, y1 = edges.T
    for near, far in ((quad[0], quad[1]), (quad[3], quad[2])):
        own = (near - far) / np.linalg.norm(near - far)
        ends = ((x0 - near[0], y0 - near[1]), (x1 - near[0], y1 - near[1]))
        # Along the shaft's middle, and aside of its edge, of both ends of every edge.
        along, aside = (
            [x * way[0] + y * way[1] for x, y in ends] for way in (inward, (-own[1], own[0]))
        )
        first = np.minimum(*along)
        beyond = (first > out - 2) & (first < out + BEYOND)
        if (beyond & (np.maximum(*np.abs(aside)) < IN_LINE)).any():
            return True
    return False
