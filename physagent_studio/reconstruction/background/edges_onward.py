"""Edges that run into what is taken out of a picture, found again where they come out of it.

An edge that goes on straight is looked for where it has to be, at a place and a direction that
are only a little off: there a faint one is told from none, for it steps as this one does.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from physagent_studio.arrays import BoolArray, FloatArray
from physagent_studio.reconstruction.photo.regions import grow
from physagent_studio.records.case import Image


@dataclass(frozen=True, slots=True)
class OnwardSettings:
    """When an edge is seen again behind a hole."""

    max_edges: int = 12  # count, 4..40: that are followed, the longest and clearest
    # 5..150: over which it is looked for: half of what is seen before, within these
    followed_px: tuple[float, float] = (14.0, 60.0)
    before_likeness: float = 0.7  # likeness, 0.3..1: of the steps along it before it is hidden
    again_likeness: float = 0.6  # likeness, 0.2..1: of those behind to that
    parallel_rad: float = math.radians(4.0)  # 0.02..0.2: of two such
    clear_levels: float = 16.0  # 5..60: of three colours together, of its step
    parts_levels: float = 40.0  # 20..120: of its step where only the colours beside say it goes on
    parted_share: float = 0.85  # 0.6..1: of what is around the hole that is like its own side
    around_px: int = 6  # 2..15: outside the hole, where that is looked at


ONWARD = OnwardSettings()


def onward(
    photo: Image, ends: FloatArray, ways: FloatArray, long: FloatArray, hole: BoolArray
) -> FloatArray:
    """Lines (N, 2, 2), pixels, from where edges run into the hole (H, W) to where they come out.

    ends, ways: (E, 2) where edges run into the hole and the unit directions in which they do.
    long: (E,) their lengths, pixels.
    """
    soft = cv2.GaussianBlur(photo, (0, 0), 1.0).astype(np.float32)
    heading = []
    for k in range(len(ends)):
        length = float(np.clip(0.5 * long[k], *ONWARD.followed_px))
        spot = _comes_out(hole, ends[k], ways[k])
        before, seen = _steps(soft, hole, ends[k][None], -ways[k][None], length)
        if spot is None or not seen[0].sum() > max(6, 0.66 * length):
            continue
        step = np.median(before[0, seen[0]], axis=0)
        size = float(np.linalg.norm(step))
        if size > ONWARD.clear_levels and _alike(before, seen, step)[0] > ONWARD.before_likeness:
            # Seen the other way, what is left of it is right.
            heading.append((-size * length, k, -step, spot, length))
    again = []
    for _, k, step, spot, length in sorted(heading, key=lambda item: item[:2])[: ONWARD.max_edges]:
        found = _seen_again(soft, hole, (ends[k], ways[k]), step, spot, length)
        if found is not None:
            again.append((k, *found))
    sure = [ways[k] for k, _, alike in again if alike > ONWARD.again_likeness]
    return np.array(
        [
            (ends[k], spot)
            for k, spot, alike in again
            if alike > ONWARD.again_likeness
            or any(abs(float(ways[k] @ w)) > math.cos(ONWARD.parallel_rad) for w in sure)
        ]
    ).reshape(-1, 2, 2)


def to_border(
    photo: Image, ends: FloatArray, ways: FloatArray, long: FloatArray, hole: BoolArray
) -> FloatArray:
    """Lines (N, 2, 2), pixels, of edges that do not come out of a hole (H, W) cut by the picture.

    Such an edge is not seen again, but parts what is around the hole: to its left all is like what
    is left of it, to its right like what is right of it. ends, ways, long: as for `onward`.
    """
    soft = cv2.GaussianBlur(photo, (0, 0), 1.0).astype(np.float32)
    rows, columns = np.nonzero(grow(hole, ONWARD.around_px) & ~grow(hole, 1))
    out = []
    for end, way, length in zip(ends, ways, long, strict=True):
        border = _leaves(hole, end, way)
        if border is None or any(_same_line(line, end, way) for line in out):
            continue
        sides = _beside(soft, hole, end, way, float(np.clip(0.5 * length, *ONWARD.followed_px)))
        if sides is None or np.linalg.norm(sides[0] - sides[1]) < ONWARD.parts_levels:
            continue
        off = np.stack([columns, rows], 1) - end
        ahead, left = off @ way > 0, off @ np.array([-way[1], way[0]]) > 0
        apart = np.linalg.norm(soft[rows, columns][:, None] - sides, axis=2)
        like_left = apart[:, 0] < apart[:, 1]
        shares = [
            float((like_left == side)[ahead & (left == side)].mean())
            for side in (True, False)
            if np.count_nonzero(ahead & (left == side)) > 4 * ONWARD.around_px
        ]
        if len(shares) == 2 and min(shares) >= ONWARD.parted_share:
            out.append(np.array([end, border]))
    return np.array(out).reshape(-1, 2, 2)


def _same_line(line: FloatArray, end: FloatArray, way: FloatArray) -> bool:
    """Whether a ray goes along a line (2, 2): edges are found in pieces."""
    off = line[0] - end
    along = (line[1] - line[0]) / max(float(np.linalg.norm(line[1] - line[0])), 1e-9)
    near_px = 3.0  # 1..10: aside
    return abs(float(off[0] * way[1] - off[1] * way[0])) < near_px and float(along @ way) > 0.99


def _beside(
    soft: NDArray[np.float32], hole: BoolArray, end: FloatArray, way: FloatArray, length: float
) -> FloatArray | None:
    """(2, 3) colours left and right of an edge before it is hidden; None where little is seen."""
    back = end - np.arange(1.0, length)[:, None] * way
    normal = np.array([-way[1], way[0]])
    off_px = (3.0, 6.0, 10.0)  # 1..15: beside it, where its sides are looked at
    sides = []
    for sign in (1, -1):
        spots = (back[:, None] + sign * np.array(off_px)[:, None] * normal).reshape(-1, 2)
        x, y = spots.astype(int).T
        seen = (x >= 0) & (y >= 0) & (x < hole.shape[1]) & (y < hole.shape[0])
        seen[seen] = ~hole[y[seen], x[seen]]
        if seen.mean() < 0.5:
            return None
        sides.append(np.median(soft[y[seen], x[seen]], axis=0))
    return np.array(sides)


def _leaves(hole: BoolArray, end: FloatArray, way: FloatArray) -> FloatArray | None:
    """Where (2,) a ray leaves the picture inside the hole; None where it comes out before."""
    along = _ray(hole, end, way)
    if len(along) < ONWARD.followed_px[0]:
        return None
    x, y = along.astype(int).T
    covered = hole[y, x]
    return along[-1] if covered[-3:].all() and covered.mean() > 0.8 else None


def _ray(hole: BoolArray, end: FloatArray, way: FloatArray) -> FloatArray:
    """(N, 2) spots from an end on, a pixel apart, as far as the picture goes."""
    along = end + np.arange(2.0, 2 * max(hole.shape))[:, None] * way
    inside = (along >= 0).all(1) & (along < (hole.shape[1], hole.shape[0])).all(1)
    return along if inside.all() else along[: int(np.argmin(inside))]


def _comes_out(hole: BoolArray, end: FloatArray, way: FloatArray) -> FloatArray | None:
    """The first spot (2,) behind the hole on the way that stays out of it; None for none."""
    along = _ray(hole, end, way)
    x, y = along.astype(int).T
    covered = np.flatnonzero(hole[y, x])
    if not len(covered):
        return None
    # Of several holes in line only the first one is crossed.
    gaps = np.flatnonzero(np.diff(covered) > ONWARD.followed_px[0])
    last = int(covered[gaps[0]] if len(gaps) else covered[-1])
    return along[last + 1] if last + ONWARD.followed_px[0] < len(along) else None


def _seen_again(
    soft: NDArray[np.float32],
    hole: BoolArray,
    ray: tuple[FloatArray, FloatArray],
    step: FloatArray,
    spot: FloatArray,
    length: float,
) -> tuple[FloatArray, float] | None:
    """Where (2,) the edge that ends with this step begins again near a spot, and how like it.

    None where nothing like it is seen, or as much of it beside.

    ray: (2,) where it ends and (2,) the way that it goes on.
    """
    end, way = ray
    normal = np.array([-way[1], way[0]])
    # pixels and share, 0..10: of the gap, by which one may come out beside the line
    aside_reach = (2.0, 0.03)
    reach = aside_reach[0] + aside_reach[1] * float(np.linalg.norm(spot - end))
    widely_factor = 4.0  # 2..10: of that, where lines are looked at for comparison
    across = np.arange(-np.ceil(widely_factor * reach), np.ceil(widely_factor * reach) + 1)
    turned_rad = math.radians(2.5)  # 0.01..0.15: by which its direction may be off
    turns = np.linspace(-turned_rad, turned_rad, 5)
    ways = np.cos(turns)[:, None] * way + np.sin(turns)[:, None] * normal
    spots = spot + across[:, None] * normal
    every = np.repeat(spots, len(turns), 0), np.tile(ways, (len(spots), 1))
    steps, seen = _steps(soft, hole, *every, length)
    alike = np.where(seen.sum(1) > max(6, 0.66 * length), _alike(steps, seen, step), 0.0)
    best = alike.reshape(len(spots), len(turns)).max(1)
    near = np.abs(across) <= reach
    usual = float(np.median(best[~near]))
    most = float(best[near].max())
    better_factor = 2.5  # 1.2..6: of likeness along usual lines beside it
    twin_likeness = 0.38  # likeness, 0.2..1: beside another that goes on: bars have two edges
    only_ratio = 0.9  # 0.5..1: over the likest of all
    if most < max(twin_likeness, better_factor * usual, only_ratio * best.max()):
        return None
    return spots[near & (best == most)][0], most


def _steps(
    soft: NDArray[np.float32],
    hole: BoolArray,
    spots: FloatArray,
    ways: FloatArray,
    length: float,
) -> tuple[FloatArray, BoolArray]:
    """(M, K, 3) by how much colours left and right of M ways from spots differ; (M, K) if seen.

    spots: (M, 2) pixels. ways: (M, 2) unit directions.
    """
    normal = np.stack([-ways[:, 1], ways[:, 0]], 1)
    along = spots[:, None] + np.arange(1.0, length)[:, None] * ways[:, None]
    off_px = (2.0, 4.0, 7.0)  # 1..15: beside it, where its sides are looked at
    sides = np.array(
        [[along + sign * off * normal[:, None] for off in off_px] for sign in (1, -1)]
    ).astype(int)
    x, y = sides[..., 0], sides[..., 1]
    inside = (x >= 0) & (y >= 0) & (x < hole.shape[1]) & (y < hole.shape[0])
    x, y = x.clip(0, hole.shape[1] - 1), y.clip(0, hole.shape[0] - 1)
    seen = (inside & ~hole[y, x]).all((0, 1))
    colours = soft[y, x].mean(1)
    return (colours[0] - colours[1]).astype(float), seen


def _alike(steps: FloatArray, seen: BoolArray, step: FloatArray) -> FloatArray:
    """(M,) how like one step (3,) those along M lines (M, K, 3) are where they are seen, 0 … 1."""
    along = steps @ step / float(step @ step)
    across = np.linalg.norm(steps - along[..., None] * step, axis=-1) / np.linalg.norm(step)
    like = np.clip(along, 0, 1) * (across < 1.0)
    return (like * seen).sum(-1) / np.maximum(seen.sum(-1), 1)
