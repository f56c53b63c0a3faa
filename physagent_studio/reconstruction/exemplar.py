"""Exemplar-based fill: every patch over a hole is copied from a similar one beside it.

PatchMatch (Barnes et al. 2009) with voting as in Wexler et al. (2007).
"""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from physagent_studio.reconstruction.harmonic import from_steps
from physagent_studio.reconstruction.masks import BoolArray

FloatImage = NDArray[np.float32]
PATCH = 7
LEVEL_LINES = 1500.0
"""How dear it is to copy from another height: walls, floors and tables run across pictures."""
_BESIDE = ((0, 1), (0, -1), (1, 0), (-1, 0))
STRAY = 14.0
"""Difference between fill and photo at the rim from which the rim is not trusted, grey levels."""
SETTLING = 5
ANCHOR = 4e-4
"""How much the copied colours count beside the steps between them."""
COHERENT = 1.15
"""What a neighbour's source may cost more and still be taken: pieces are better than crumbs."""


class Field:
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


@dataclass(frozen=True, eq=False, slots=True)
class Copied:
    """A filled picture (H, W, 3), and for each missing pixel how far away (row, column) the

    pixel lies that it was copied from, (H, W, 2); zero elsewhere.
    """

    picture: FloatImage
    offsets: NDArray[np.int64]


def improve(
    current: FloatImage,
    hole: BoolArray,
    previous: NDArray[np.int64] | None,
    rng: np.random.Generator,
    rounds: int,
) -> Copied | None:
    """A few rounds of search and vote at one size; None where there is nothing to copy from.

    current: (H, W, 3) with a first guess in the hole (H, W). previous: offsets of another size.
    """
    field = Field(hole, rng)
    if len(field.pool) < 60 or not len(field.targets):
        return None
    sources = field.start(previous)
    # The first guess may only change once sources that suit it are found.
    for _ in range(SETTLING if previous is None else 1):
        sources, _ = _search(current, field, sources)
    for _ in range(rounds):
        sources, distance = _search(current, field, sources)
        current = _vote(current, hole, field, sources, distance)
    sources = _in_pieces(current, field, sources)
    offsets = np.zeros((*field.shape, 2), np.int64)
    offsets[tuple(field.targets.T)] = sources - field.targets
    return Copied(current, offsets)


def put_together(image: FloatImage, hole: BoolArray, offsets: NDArray[np.int64]) -> FloatImage:
    """The hole of a picture (H, W, 3) filled with the steps between pixels of what is copied.

    Pieces from places of different brightness then join without seams, and so does the rim.
    """
    rows, columns = np.indices(hole.shape)
    steps, weights = [], []
    copy = np.where(
        hole[..., None], image[rows + offsets[..., 0], columns + offsets[..., 1]], image
    )
    for axis in (1, 0):
        total = np.zeros(image.shape, np.float32)
        count = np.zeros(hole.shape, np.float32)
        for end in (0, 1):
            # The step as seen from its first pixel's source, then from its second pixel's.
            own = np.roll(offsets, -end, axis) if end else offsets
            inside = np.roll(hole, -end, axis) if end else hole
            y, x = rows + own[..., 0], columns + own[..., 1]
            y2, x2 = (y, x + 1) if axis else (y + 1, x)
            fine = inside & (y >= 0) & (x >= 0) & (y2 < hole.shape[0]) & (x2 < hole.shape[1])
            yc, xc = y.clip(0, hole.shape[0] - 1), x.clip(0, hole.shape[1] - 1)
            y2c, x2c = y2.clip(0, hole.shape[0] - 1), x2.clip(0, hole.shape[1] - 1)
            fine &= ~hole[yc, xc] & ~hole[y2c, x2c]
            total += np.where(fine[..., None], image[y2c, x2c] - image[yc, xc], 0)
            count += fine
        step = total / np.maximum(count, 1)[..., None]
        steps.append(step)
        weights.append(_agreement(copy, step, axis))
    return from_steps(copy, hole, (steps[0], steps[1]), (weights[0], weights[1]), ANCHOR)


def _agreement(copy: FloatImage, step: FloatImage, axis: int) -> FloatImage:
    """(H, W) how much a step counts: little where two pieces, or fill and photo, are far apart.

    There is an edge then, or a shadow that ends at the rim: neither shall bleed.
    """
    miss = np.abs(np.roll(copy, -1, axis) - copy - step).mean(-1)
    return (1 / (1 + (miss / STRAY) ** 4)).astype(np.float32)


def _patches(image: FloatImage, field: Field, at: NDArray[np.int64]) -> FloatImage:
    """Colours (N, P, 3) of the patches around places (N, 2)."""
    columns = field.shape[1]
    corner = at[:, 0] * columns + at[:, 1]
    around = field.offsets[:, 0] * columns + field.offsets[:, 1]
    return image.reshape(-1, 3)[corner[:, None] + around]


def _apart(
    image: FloatImage, field: Field, at: NDArray[np.int64], wanted: FloatImage, chosen: BoolArray
) -> FloatImage:
    """How far (K,) the patches at places (K, 2) are from the wanted ones of the chosen targets."""
    off = _patches(image, field, at) - wanted[chosen]
    return np.einsum("npc,npc,np->n", off, off, field.weight[chosen], optimize=False)


def _search(
    image: FloatImage, field: Field, sources: NDArray[np.int64]
) -> tuple[NDArray[np.int64], FloatImage]:
    """Propagation from the four neighbours, then random search at shrinking reach."""
    wanted = _patches(image, field, field.targets)

    level = LEVEL_LINES / field.shape[0] ** 2

    def distance(candidates: NDArray[np.int64], chosen: BoolArray) -> FloatImage:
        shift = (candidates[:, 0] - field.targets[chosen, 0]).astype(np.float32)
        return _apart(image, field, candidates, wanted, chosen) + level * shift**2

    best = distance(sources, np.ones(len(sources), bool))

    def offer(candidates: NDArray[np.int64]) -> None:
        candidates = np.clip(candidates, field.low, field.high)
        changed = field.allowed(candidates) & (candidates != sources).any(1)
        value = distance(candidates[changed], changed)
        won = value < best[changed]
        better = np.flatnonzero(changed)[won]
        sources[better] = candidates[better]
        best[better] = value[won]

    for step in _BESIDE:
        offer(_from_beside(field, sources, step))
    reach = max(field.shape)
    while reach >= 1:
        offer(sources + field.rng.integers(-reach, reach + 1, sources.shape))
        reach //= 3
    return sources, best


def _from_beside(
    field: Field, sources: NDArray[np.int64], step: tuple[int, int]
) -> NDArray[np.int64]:
    """The source (N, 2) that continues that of the neighbour at `step`, else the own one."""
    beside = np.clip(field.targets + step, 0, np.array(field.shape) - 1)
    neighbour = field.index[tuple(beside.T)]
    candidates = sources.copy()
    known = neighbour >= 0
    candidates[known] = sources[neighbour[known]] - step
    return candidates


def _in_pieces(image: FloatImage, field: Field, sources: NDArray[np.int64]) -> NDArray[np.int64]:
    """Sources in larger pieces: a neighbour's is taken where it is about as good."""
    wanted = _patches(image, field, field.targets)
    best = _apart(image, field, sources, wanted, np.ones(len(sources), bool))
    limit = COHERENT * best + 0.3 * float(np.median(best)) + 1.0
    for _ in range(3):
        for step in _BESIDE:
            candidates = np.clip(_from_beside(field, sources, step), field.low, field.high)
            take = field.allowed(candidates) & (candidates != sources).any(1)
            # What already lies in the neighbour's piece on the other side stays there.
            other = _from_beside(field, sources, (-step[0], -step[1]))
            take &= (other != sources).any(1)
            near = _apart(image, field, candidates[take], wanted, take) < limit[take]
            taken = np.flatnonzero(take)[near]
            sources[taken] = candidates[taken]
    return sources


def _vote(
    image: FloatImage,
    hole: BoolArray,
    field: Field,
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
