"""The background plate: the photo with the objects filled in from their surroundings.

An exemplar-based fill (PatchMatch: Barnes et al. 2009; voting as in Wexler et al. 2007) at
reduced size keeps texture and lines; its result is blended into the full picture together with
grain copied from beside the hole.
"""

from __future__ import annotations

import cv2
import numpy as np
from numpy.typing import NDArray
from scipy import sparse
from scipy.sparse.linalg import splu

from physagent_studio.reconstruction.masks import BoolArray, bounds, grow
from physagent_studio.records.case import Image

FloatImage = NDArray[np.float32]
PATCH = 7
ROUNDS = (14, 8, 4)
"""Rounds of search and vote, from the coarsest size to the finest."""
SEED = 7
LEVEL_LINES = 1500.0
"""How dear it is to copy from another height: walls, floors and tables run across pictures."""


def fill(photo: Image, hole: BoolArray, side: int = 256) -> Image:
    """The photo (H, W, 3) with the hole (H, W) filled; the rest is untouched."""
    if not hole.any():
        return photo.copy()
    if hole.all():
        return np.full_like(photo, 128)
    crop = _surroundings(hole)
    part, missing = photo[crop], hole[crop]
    factor = min(1.0, side / max(missing.shape))
    coarse = _patched(part, missing, factor)
    out = photo.copy()
    full = cv2.resize(coarse, (part.shape[1], part.shape[0]), interpolation=cv2.INTER_CUBIC)
    full = full.astype(np.float32)
    full = _seamless(part.astype(np.float32), full, missing)
    if factor < 0.8:
        full = full + _grain(part, missing)
    filled = np.where(missing[..., None], full, part)
    out[crop] = np.clip(np.round(filled), 0, 255).astype(np.uint8)
    return out


def hole_of(masks: list[BoolArray], shape: tuple[int, int]) -> BoolArray:
    """All objects together, widened over their soft outline."""
    union = np.zeros(shape, bool)
    for mask in masks:
        union |= mask
    return grow(union, max(3, round(0.008 * max(shape))))


def _surroundings(hole: BoolArray) -> tuple[slice, slice]:
    """The part of the picture that the fill may copy from."""
    x0, y0, x1, y1 = bounds(hole)
    margin = max(60, round(0.9 * max(x1 - x0, y1 - y0)))
    rows = slice(max(0, y0 - margin), min(hole.shape[0], y1 + margin))
    return rows, slice(max(0, x0 - margin), min(hole.shape[1], x1 + margin))


def membrane(image: FloatImage, hole: BoolArray, side: int = 72) -> FloatImage:
    """A smooth fill from the rim: Laplace's equation solved coarsely, then relaxed."""
    factor = min(1.0, side / max(hole.shape))
    if factor < 1:
        size = (max(4, round(hole.shape[1] * factor)), max(4, round(hole.shape[0] * factor)))
        small = membrane(*_level(image, hole, size), side)
        guess = cv2.resize(small, hole.shape[::-1], interpolation=cv2.INTER_LINEAR)
        out = np.where(hole[..., None], guess, image).astype(np.float32)
        for _ in range(10):
            out[hole] = cv2.blur(out, (3, 3))[hole]
        return out
    return _harmonic(image, hole)


def _harmonic(image: FloatImage, hole: BoolArray) -> FloatImage:
    """Every missing pixel the mean of its neighbours, exactly."""
    count = int(np.count_nonzero(hole))
    index = np.full(np.add(hole.shape, 2), -2)
    index[1:-1, 1:-1] = -1
    index[1:-1, 1:-1][hole] = np.arange(count)
    padded = np.pad(image, ((1, 1), (1, 1), (0, 0)))
    rows, columns = np.nonzero(index >= 0)
    own = index[rows, columns]
    degree, known = np.zeros(count), np.zeros((count, image.shape[2]))
    entries: list[tuple[NDArray, NDArray]] = []
    for dy, dx in ((0, 1), (0, -1), (1, 0), (-1, 0)):
        near = index[rows + dy, columns + dx]
        degree[own] += near > -2
        rim = near == -1
        known[own[rim]] += padded[rows[rim] + dy, columns[rim] + dx]
        entries.append((own[near >= 0], near[near >= 0]))
    r = np.concatenate([own, *(entry[0] for entry in entries)])
    c = np.concatenate([own, *(entry[1] for entry in entries)])
    v = np.concatenate([degree + 1e-9, -np.ones(len(r) - count)])
    solve = splu(sparse.csc_matrix((v, (r, c)), (count, count)))
    out = image.copy()
    out[hole] = solve.solve(known).astype(np.float32)
    return out


def _patched(part: Image, missing: BoolArray, factor: float) -> FloatImage:
    """The crop at reduced size with its hole filled patch by patch, coarse to fine."""
    rng = np.random.default_rng(SEED)
    size = (max(8, round(part.shape[1] * factor)), max(8, round(part.shape[0] * factor)))
    levels = [_level(part.astype(np.float32), missing, size)]
    while min(levels[-1][1].shape) > 36 and levels[-1][1].any():
        image, hole = levels[-1]
        half = (max(8, hole.shape[1] // 2), max(8, hole.shape[0] // 2))
        levels.append(_level(image, hole, half))
    current = membrane(*levels[-1])
    field: NDArray[np.int64] | None = None
    for step, (image, hole) in enumerate(reversed(levels)):
        rows, columns = hole.shape
        if current.shape[:2] != hole.shape:
            current = cv2.resize(current, (columns, rows), interpolation=cv2.INTER_CUBIC)
        current = np.where(hole[..., None], current, image).astype(np.float32)
        rounds = ROUNDS[min(step, len(ROUNDS) - 1)]
        current, field = _improve(current, hole, field, rng, rounds)
    return current


def _level(
    image: FloatImage, hole: BoolArray, size: tuple[int, int]
) -> tuple[FloatImage, BoolArray]:
    """Image and hole at another size; background colours alone, none of the objects'."""
    weight = (~hole).astype(np.float32)
    colour = cv2.resize(image * weight[..., None], size, interpolation=cv2.INTER_AREA)
    some = cv2.resize(weight, size, interpolation=cv2.INTER_AREA)
    return (colour / np.maximum(some, 1e-3)[..., None]).astype(np.float32), np.asarray(some < 0.99)


class _Field:
    """Where each patch over the hole is copied from: targets (N, 2) and sources (N, 2)."""

    def __init__(self, hole: BoolArray, rng: np.random.Generator) -> None:
        reach = PATCH // 2
        rows, columns = hole.shape
        touched = cv2.dilate(hole.astype(np.uint8), np.ones((PATCH, PATCH), np.uint8)) > 0
        inner = np.zeros_like(hole)
        inner[reach : rows - reach, reach : columns - reach] = True
        self.whole = ~touched & inner
        self.targets = np.argwhere(touched & inner)
        self.pool = np.argwhere(self.whole)
        self.shape = (rows, columns)
        self.low = np.array([reach, reach])
        self.high = np.array([rows - reach - 1, columns - reach - 1])
        self.index = np.full((rows, columns), -1)
        self.index[tuple(self.targets.T)] = np.arange(len(self.targets))
        self.rng = rng
        step = np.arange(-reach, reach + 1)
        self.offsets = np.stack(np.meshgrid(step, step, indexing="ij"), -1).reshape(-1, 2)
        depth = cv2.distanceTransform(hole.astype(np.uint8), cv2.DIST_L2, 5)
        # What is deep inside the hole is a guess, so it counts for less.
        self.trust = (1.25**-depth).astype(np.float32)
        around = self.trust[
            self.targets[:, 0, None] + self.offsets[:, 0],
            self.targets[:, 1, None] + self.offsets[:, 1],
        ]
        self.weight = around / np.maximum(around.sum(1, keepdims=True), 1e-9)

    def random(self, count: int) -> NDArray[np.int64]:
        return self.pool[self.rng.integers(len(self.pool), size=count)]

    def allowed(self, sources: NDArray[np.int64]) -> BoolArray:
        return self.whole[sources[:, 0], sources[:, 1]]

    def start(self, previous: NDArray[np.int64] | None) -> NDArray[np.int64]:
        if previous is None:
            return self.random(len(self.targets))
        rows, columns = self.shape
        grid = cv2.resize(
            previous.astype(np.float32), (columns, rows), interpolation=cv2.INTER_NEAREST
        )
        ratio = np.array(self.shape) / np.array(previous.shape[:2])
        moved = np.round(grid[tuple(self.targets.T)] * ratio).astype(np.int64)
        sources = np.clip(self.targets + moved, self.low, self.high)
        bad = ~self.allowed(sources)
        sources[bad] = self.random(int(bad.sum()))
        return sources


def _improve(
    current: FloatImage,
    hole: BoolArray,
    previous: NDArray[np.int64] | None,
    rng: np.random.Generator,
    rounds: int,
) -> tuple[FloatImage, NDArray[np.int64] | None]:
    """A few rounds of search and vote at one size; also the offsets (H, W, 2) found."""
    field = _Field(hole, rng)
    if len(field.pool) < 60 or not len(field.targets):
        return current, None
    sources = field.start(previous)
    for _ in range(rounds):
        sources, distance = _search(current, field, sources)
        current = _vote(current, hole, field, sources, distance)
    offsets = np.zeros((*field.shape, 2), np.int64)
    offsets[tuple(field.targets.T)] = sources - field.targets
    return current, offsets


def _patches(image: FloatImage, field: _Field, at: NDArray[np.int64]) -> FloatImage:
    rows = at[:, 0, None] + field.offsets[:, 0]
    columns = at[:, 1, None] + field.offsets[:, 1]
    return image[rows, columns]


def _search(
    image: FloatImage, field: _Field, sources: NDArray[np.int64]
) -> tuple[NDArray[np.int64], FloatImage]:
    """Propagation from the four neighbours, then random search at shrinking reach."""
    wanted = _patches(image, field, field.targets)

    level = LEVEL_LINES / field.shape[0] ** 2

    def distance(candidates: NDArray[np.int64]) -> FloatImage:
        colour = ((_patches(image, field, candidates) - wanted) ** 2).sum(2)
        shift = candidates[:, 0] - field.targets[:, 0]
        return (colour * field.weight).sum(1) + level * shift.astype(np.float32) ** 2

    best = distance(sources)

    def offer(candidates: NDArray[np.int64]) -> None:
        candidates = np.clip(candidates, field.low, field.high)
        changed = field.allowed(candidates) & (candidates != sources).any(1)
        trial = np.where(changed[:, None], candidates, sources)
        value = np.where(changed, distance(trial), np.inf)
        better = value < best
        sources[better] = trial[better]
        best[better] = value[better]

    for step in ((0, 1), (0, -1), (1, 0), (-1, 0)):
        beside = np.clip(field.targets + step, 0, np.array(field.shape) - 1)
        neighbour = field.index[tuple(beside.T)]
        candidates = sources.copy()
        known = neighbour >= 0
        candidates[known] = sources[neighbour[known]] - step
        offer(candidates)
    reach = max(field.shape)
    while reach >= 1:
        offer(sources + field.rng.integers(-reach, reach + 1, sources.shape))
        reach //= 3
    return sources, best


def _vote(
    image: FloatImage,
    hole: BoolArray,
    field: _Field,
    sources: NDArray[np.int64],
    distance: FloatImage,
) -> FloatImage:
    """Every missing pixel becomes the weighted mean of what its patches say."""
    weight = np.exp(-distance / (0.6 * np.percentile(distance, 60) + 1e-6)) + 1e-6
    weight = weight * field.trust[tuple(field.targets.T)]
    rows, columns = field.shape
    total = np.zeros((rows * columns, 3))
    share = np.zeros(rows * columns)
    for offset in field.offsets:
        at = (field.targets[:, 0] + offset[0]) * columns + field.targets[:, 1] + offset[1]
        colour = image[sources[:, 0] + offset[0], sources[:, 1] + offset[1]]
        share += np.bincount(at, weight, rows * columns)
        for channel in range(3):
            total[:, channel] += np.bincount(at, weight * colour[:, channel], rows * columns)
    mean = (total / np.maximum(share, 1e-9)[:, None]).reshape(rows, columns, 3)
    known = hole & (share > 0).reshape(rows, columns)
    return np.where(known[..., None], mean, image).astype(np.float32)


def _seamless(part: FloatImage, filled: FloatImage, hole: BoolArray) -> FloatImage:
    """The fill shifted smoothly in colour, so that it meets the photo at the rim."""
    rim = grow(hole, 3) & ~hole
    error = np.where(rim[..., None], part - filled, 0).astype(np.float32)
    spread = membrane(cv2.GaussianBlur(error, (0, 0), 1.0).astype(np.float32), hole)
    return filled + np.clip(spread, -25, 25)


def _grain(part: Image, hole: BoolArray) -> FloatImage:
    """Fine noise like that beside the hole, copied with an offset that avoids the hole."""
    values = part.astype(np.float32)
    fine = values - cv2.GaussianBlur(values, (0, 0), 1.2)
    x0, _, x1, _ = bounds(hole)
    out = np.zeros_like(fine)
    best = (1.0, 0)
    for shift in (x1 - x0 + 4, -(x1 - x0 + 4), (x1 - x0) // 2 + 9, -(x1 - x0) // 2 - 9):
        moved = np.roll(hole, -shift, axis=1)
        overlap = float((moved & hole).sum()) / max(int(hole.sum()), 1)
        if overlap < best[0]:
            best = (overlap, shift)
    rolled = np.roll(fine, -best[1], axis=1)
    usable = hole & ~np.roll(grow(hole, 2), -best[1], axis=1)
    out[usable] = np.clip(rolled[usable], -12, 12) * 0.7
    return out
