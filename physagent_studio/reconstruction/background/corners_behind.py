"""Edges that run into what is taken out of a picture and meet behind it in a corner."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from physagent_studio.reconstruction.photo.line_segments import Segments
from physagent_studio.reconstruction.photo.regions import BoolArray
from physagent_studio.records.case import Image

FloatArray = NDArray[np.float64]


@dataclass(frozen=True, slots=True)
class CornerSettings:
    """Which edges meet, and what they part."""

    # 0..1: of a difference in lightness: one surface is lit unlike at two edges
    dim_factor: float = 0.5
    # 0.005..0.1: over the longer side, to an edge that goes on where another ends
    joined_ratio: float = 0.02
    # 0.02..1.2: by which an outline that is round turns from one edge to the next
    bent_rad: tuple[float, float] = (math.radians(3.0), math.radians(50.0))


CORNER = CornerSettings()


def corners(
    photo: Image,
    ends: FloatArray,
    ways: FloatArray,
    free: Sequence[int],
    hole: BoolArray,
    found: Segments,
) -> FloatArray:
    """Lines (N, 2, 2), pixels, from where edges that part surfaces end to where they meet.

    Two for each corner. ends, ways: (E, 2) where edges run into the hole (H, W) and the unit
    directions in which they do. free: those that may meet. found: the picture's edges.
    """
    longer = max(hole.shape)
    parts = _parted(photo, hole, ends, ways)
    broad = _foremost([_of(end, found, found.length) for end in ends], parts)
    found = found.only(_beside(hole, found))
    curved_rad = 0.15  # 0.05..0.4: from which an edge is curved itself, and has no corner
    # What bends before it is hidden is round, and goes on to no corner.
    sharp = [
        k
        for k in free
        if k in broad
        and _of(ends[k], found, found.bend) < curved_rad
        and not _goes_on(ends[k], ways[k], found, longer)
        and not _bends_before(ends[k], ways[k], found, longer)
    ]
    met = _meetings(ends, ways, sharp, hole, parts)
    lines = [line for i, j, spot in met for line in ((ends[i], spot), (spot, ends[j]))]
    return np.array(lines).reshape(-1, 2, 2)


def _meetings(
    ends: FloatArray,
    ways: FloatArray,
    free: Sequence[int],
    hole: BoolArray,
    parts: FloatArray,
) -> list[tuple[int, int, FloatArray]]:
    """Pairs of edges that meet, and where (2,); each edge once, the likest and nearest first.

    parts: (E, 2, 3) what they part.
    """
    if not hole.any():
        return []
    rows, columns = np.nonzero(hole)
    far_ratio = 1.6  # 0.5..4: extents of the hole that an edge may run to its corner
    reach = far_ratio * max(np.ptp(rows), np.ptp(columns), 1)
    meetings = []
    for n, i in enumerate(free):
        for j in free[n + 1 :]:
            met = _meeting(ends[i], ways[i], ends[j], ways[j])
            if met is None or max(met[1:]) > reach:
                continue
            # Seen from the corner the left of one edge is the right of the other.
            unlike = _apart(parts[i], parts[j, ::-1])
            if unlike < 1 and all(_hidden(hole, ends[k], met[0]) for k in (i, j)):
                meetings.append((sum(met[1:]) / reach + unlike, i, j, met[0]))
    used: set[int] = set()
    out = []
    for _, i, j, spot in sorted(meetings, key=lambda meeting: meeting[:3]):
        if i not in used and j not in used:
            used |= {i, j}
            out.append((i, j, spot))
    return out


def _foremost(lengths: Sequence[float], parts: FloatArray) -> list[int]:
    """Edges that part surfaces, and do so long and clearly; none where they are a pattern.

    lengths: of E edges. parts: (E, 2, 3) what they part.
    """
    clear = np.array([_clear(one) for one in parts])
    weight = clear * np.array(lengths)
    parted_lab = 8.0  # 3..30: 0 … 255, between two surfaces at an edge
    # 0.05..0.8: length times clearness of an edge that is counted, of the foremost's
    minor_share = 0.25
    kept = np.flatnonzero((weight > minor_share * weight.max(initial=0.0)) & (clear > parted_lab))
    max_edges = 8  # count, 3..20: beyond which they are a pattern and no outlines
    return kept.tolist() if len(kept) <= max_edges else []


def _beside(hole: BoolArray, found: Segments) -> BoolArray:
    """(N,) which edges are not those of what is taken out itself."""
    x, y = found.ends.astype(int).transpose(2, 0, 1)
    covered = hole[y.clip(0, hole.shape[0] - 1), x.clip(0, hole.shape[1] - 1)]
    return np.asarray(~covered.all(1))


def _parted(photo: Image, hole: BoolArray, ends: FloatArray, ways: FloatArray) -> FloatArray:
    """(E, 2, 3) the L*a*b* of what lies to the left and the right of edges before their ends.

    Not a number where the hole (H, W) hides it.
    """
    soft = cv2.GaussianBlur(photo, (0, 0), 1.5)
    lab = cv2.cvtColor(soft, cv2.COLOR_RGB2LAB).astype(float)
    lab[hole] = np.nan
    normal = np.stack([-ways[:, 1], ways[:, 0]], 1)[:, None, None]
    before_px = (5, 9, 13, 20, 28)  # 2..60: before its end
    before = ends[:, None] - np.array(before_px)[:, None] * ways[:, None]
    out = np.full((len(ends), 2, 3), np.nan)
    least_spots = 4  # count, 1..10: on which a side has to be seen
    # 2..40: off an edge, where its sides are compared: wider than joints and stripes
    broad_px = (5, 9, 13, 17)
    for side, sign in enumerate((1, -1)):
        spots = before[:, :, None] + sign * np.array(broad_px)[:, None] * normal
        x, y = spots.reshape(len(ends), -1, 2).astype(int).transpose(2, 0, 1)
        colours = lab[y.clip(0, hole.shape[0] - 1), x.clip(0, hole.shape[1] - 1)]
        seen = np.isfinite(colours[..., 0]).sum(1) >= least_spots
        out[seen, side] = np.nanmedian(colours[seen], axis=1)
    return out


def _clear(parts: FloatArray) -> float:
    """How unlike the two sides (2, 3) of an edge are; 0 where one of them is hidden."""
    step = (parts[0] - parts[1]) * (CORNER.dim_factor, 1, 1)
    return float(np.nan_to_num(np.linalg.norm(step)))


def _apart(one: FloatArray, other: FloatArray) -> float:
    """How unlike the surfaces (2, 3) that two edges part are, 1 for too much."""
    steps = [(sides[0] - sides[1]) * (CORNER.dim_factor, 1, 1) for sides in (one, other)]
    size = float(np.linalg.norm(steps[0]) * np.linalg.norm(steps[1]))
    same_cosine = 0.5  # cosine, 0..1: between what two edges part
    if steps[0] @ steps[1] < same_cosine * size:
        return 1.0
    hue = float(np.linalg.norm((one - other)[:, 1:], axis=1).max())
    lit_lab = 60.0  # 20..120: the same in L* (0 … 255)
    hued_lab = 16.0  # 5..40: a*, b*, between two edges' surfaces
    return max(hue / hued_lab, float(np.abs(one - other)[:, 0].max()) / lit_lab)


def _of(end: FloatArray, found: Segments, values: FloatArray) -> float:
    """The value (N,) of the edge with this end (2,), the greatest where it is that of several."""
    return float(values[(found.ends == end).all(2).any(1)].max())


def _bends_before(end: FloatArray, way: FloatArray, found: Segments, longer: int) -> bool:
    """Whether another edge leads to the one that ends here, at some bend."""
    own = np.argwhere((found.ends == end).all(2))[0]
    step = _joined(found.ends[own[0], 1 - own[1]], own[0], found, longer)
    if step is None:
        return False
    turn = float(step[1] * way[0] - step[0] * way[1])
    return bool(
        -step @ way > math.cos(CORNER.bent_rad[1]) and abs(turn) > math.sin(CORNER.bent_rad[0])
    )


def _goes_on(end: FloatArray, way: FloatArray, found: Segments, longer: int) -> bool:
    """Whether another edge goes on where this one ends: it is no end at all."""
    # From its end ahead, not beside it: edges of one bar run side by side.
    ahead = found.ends - end
    along = ahead @ way
    aside = np.abs(ahead[..., 0] * way[1] - ahead[..., 1] * way[0])
    begins = (along > 0.5) & (along < CORNER.joined_ratio * longer) & (aside < 2 + 0.3 * along)
    for index, side in np.argwhere(begins):
        step = found.ends[index, 1 - side] - found.ends[index, side]
        if step @ way > math.cos(CORNER.bent_rad[1]) * float(np.linalg.norm(step)):
            return True
    return False


def _joined(spot: FloatArray, own: int, found: Segments, longer: int) -> FloatArray | None:
    """The unit direction away from a spot of the edge that begins there, None for none."""
    away = np.linalg.norm(found.ends - spot, axis=2)
    away[own] = np.inf
    index, side = np.unravel_index(int(away.argmin()), away.shape)
    if away[index, side] > CORNER.joined_ratio * longer:
        return None
    step = found.ends[index, 1 - side] - found.ends[index, side]
    return step / max(float(np.linalg.norm(step)), 1e-9)


def _meeting(
    p: FloatArray, u: FloatArray, q: FloatArray, v: FloatArray
) -> tuple[FloatArray, float, float] | None:
    """Where two rays meet, and how far along each; None where they run beside or away."""
    turn = float(u[0] * v[1] - u[1] * v[0])
    straight_rad = math.radians(8.0)  # 0.03..0.4: edges that bend less where they meet are one line
    if abs(turn) < math.sin(straight_rad):
        return None
    gap = q - p
    first = float(gap[0] * v[1] - gap[1] * v[0]) / turn
    second = float(gap[0] * u[1] - gap[1] * u[0]) / turn
    return (p + first * u, first, second) if min(first, second) > 3 else None


def _hidden(hole: BoolArray, end: FloatArray, spot: FloatArray) -> bool:
    """Whether the way to the corner, and the corner, lie in the hole."""
    x, y = (end + np.linspace(0, 1, 30)[:, None] * (spot - end)).astype(int).T
    inside = (x >= 0) & (y >= 0) & (x < hole.shape[1]) & (y < hole.shape[0])
    x, y = x.clip(0, hole.shape[1] - 1), y.clip(0, hole.shape[0] - 1)
    covered = hole[y, x] & inside
    inside_share = 0.75  # 0.4..1: of the way from an edge's end to the corner that is hidden
    return bool(covered[-1] and covered.mean() > inside_share)
