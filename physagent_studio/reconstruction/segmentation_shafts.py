"""Shafts beside a mask: poles, trunks, necks and handles between two straight edges.

Patches of one colour cut a shaft to pieces wherever its shine or what is behind it changes. Its two
edges, sought in lightness and in both tints (LSD, Grompone von Gioi et al. 2012), stay parallel.
"""

from __future__ import annotations

from collections.abc import Iterator

import cv2
import numpy as np
from numpy.typing import NDArray

from physagent_studio.reconstruction.masks import BoolArray, disc, grow, shrink
from physagent_studio.reconstruction.segmentation_evidence import Patch

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
BEYOND, IN_LINE = 15.0, 2.5
"""Pixels within which an edge goes on behind the mask, and that it may be out of line."""
SMOOTH = 0.70
"""Share of a small disc at an end of the contact that is covered where the outline runs on."""


def edges_of(lab: NDArray[np.float32]) -> FloatArray:
    """(N, 4) x0, y0, x1, y1 of straight edges of lightness or tint; lab (H, W, 3), 0 … 255."""
    detector = cv2.createLineSegmentDetector()
    found = [np.zeros((0, 4))]
    for channel, enhanced in CHANNELS:
        plane = (
            lab[..., channel] if channel == 0 else cv2.GaussianBlur(lab[..., channel], (0, 0), 0.7)
        )
        grey = np.clip((plane - 128) * enhanced + 128, 0, 255).astype(np.uint8)
        large = cv2.resize(grey, None, fx=ENLARGED, fy=ENLARGED, interpolation=cv2.INTER_LINEAR)
        lines = detector.detect(large)[0]
        if lines is not None:
            found.append(np.asarray(lines, float).reshape(-1, 4) / ENLARGED)
    edges = np.concatenate(found)
    return edges[np.hypot(edges[:, 2] - edges[:, 0], edges[:, 3] - edges[:, 1]) > SHORTEST]


def shafts_beside(edges: FloatArray, mask: BoolArray, barred: BoolArray) -> Iterator[Patch]:
    """What lies between two edges (N, 4) of the picture that start at the mask (H, W).

    Nothing that reaches the rim of the picture or holds what is barred (H, W).
    """
    away = cv2.distanceTransform((~mask).astype(np.uint8), cv2.DIST_L2, 3)
    reach = np.asarray(away, np.float32)
    size = float(np.sqrt(np.count_nonzero(mask)))
    for first, second in _pairs(edges, WIDE * size):
        quad = _between(edges[first], edges[second], reach, WIDE * size)
        if quad is None or quad.min() < 1 or (quad > np.array(mask.shape[::-1]) - 2).any():
            continue
        if _passes_behind(quad, edges, mask):
            continue
        region = np.zeros(mask.shape, np.uint8)
        cv2.fillPoly(region, [np.rint(quad * 16).astype(np.int32)], 1, shift=4)
        free = region.astype(bool) & ~mask
        if free.any() and not (free & barred).any():
            rows, columns = np.nonzero(free)
            yield Patch.at(rows, columns, mask.shape)


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
    middle = (edges[:, :2] + edges[:, 2:]) / 2
    apart = middle[None] - middle[:, None]
    across = np.abs(apart[..., 1] * unit[:, None, 0] - apart[..., 0] * unit[:, None, 1])
    beside = np.abs((apart * unit[:, None]).sum(2)) < (length[None] + length[:, None]) / 2
    parallel = np.abs(unit @ unit.T) > np.cos(np.deg2rad(TURN))
    found = parallel & beside & (across > NARROW - 0.5) & (across < 1.1 * widest)
    return np.argwhere(np.triu(found, 1))


def _between(
    one: FloatArray, other: FloatArray, reach: NDArray[np.float32], widest: float
) -> FloatArray | None:
    """(4, 2) corners of what lies between two edges where they run side by side, on to the mask.

    The first and the last are at the mask. reach: (H, W) pixels to it. None where that
    is no shaft, or does not come to the mask.
    """
    axis = _axis(one, other)
    across = np.array([-axis[1], axis[0]])
    # Each edge as places along the axis, and how far across it lies there.
    points = np.stack([one.reshape(2, 2), other.reshape(2, 2)]) - one[:2]
    along, aside = points @ axis, points @ across
    low, high = along.min(1).max(), along.max(1).min()
    slope = (aside[:, 1] - aside[:, 0]) / (along[:, 1] - along[:, 0])

    def side(k: int, t: float) -> FloatArray:
        return one[:2] + axis * t + across * (aside[k, 0] + slope[k] * (t - along[k, 0]))

    width = [float(np.linalg.norm(side(0, t) - side(1, t))) for t in (low, high)]
    mean = sum(width) / 2
    if not NARROW < mean < widest or abs(width[0] - width[1]) > TAPER * mean:
        return None
    if high - low < LONG * mean:
        return None
    far = [_at(reach, (side(0, t) + side(1, t)) / 2) for t in (low, high)]
    if min(far) > max(GAP, 1.5 * mean, PART * (high - low)):
        return None
    near, end = (low - far[0] - 2, high) if far[0] <= far[1] else (high + far[1] + 2, low)
    return np.array([side(0, near), side(0, end), side(1, end), side(1, near)])


def _passes_behind(quad: FloatArray, edges: FloatArray, mask: BoolArray) -> bool:
    """Whether an edge of the shaft goes on straight where its line leaves the mask again.

    quad: (4, 2) corners, the first and the last at the mask.
    """
    inward = quad[0] + quad[3] - quad[1] - quad[2]
    inward /= np.linalg.norm(inward)
    steps = np.arange(0.0, 2 * max(mask.shape))
    line = (quad[0] + quad[3]) / 2 + steps[:, None] * inward
    x, y = np.clip(np.rint(line), 0, np.array(mask.shape[::-1]) - 1).astype(int).T
    held = np.flatnonzero(mask[y, x])
    if not len(held):
        return False
    out = held[0] + int(np.argmin(np.append(mask[y, x][held[0] :], False)))
    for near, far in ((quad[0], quad[1]), (quad[3], quad[2])):
        own = (near - far) / np.linalg.norm(near - far)
        aside = np.array([-own[1], own[0]])
        ends = edges.reshape(-1, 2, 2) - near
        along = ends @ inward
        beyond = (along.min(1) > out - 2) & (along.min(1) < out + BEYOND)
        if (beyond & (np.abs(ends @ aside).max(1) < IN_LINE)).any():
            return True
    return False


def _axis(one: FloatArray, other: FloatArray) -> FloatArray:
    """(2,) unit direction of two nearly parallel edges together, the longer counting more."""
    first, second = one[2:] - one[:2], other[2:] - other[:2]
    both = first + second * (1 if first @ second >= 0 else -1)
    return both / np.linalg.norm(both)


def _at(values: NDArray[np.float32], point: FloatArray) -> float:
    """The value (H, W) at a point (x, y), or at the nearest place in the picture."""
    x, y = np.clip(np.rint(point), 0, np.array(values.shape[::-1]) - 1).astype(int)
    return float(values[y, x])
