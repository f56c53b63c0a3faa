"""Noise that moves with the picture: what is still keeps its noise, what moves takes it along.

After "Go-with-the-Flow" (Burgert et al., CVPR 2025, section 3): each pixel's noise goes where the
flow leads it. Where several come together they are summed, where one spreads it is split into
independent parts, so that every frame's noise stays Gaussian, of unit variance and white.
"""

from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from physagent_studio.rendering import Flow

FloatArray = NDArray[np.float32]
FINER = 2
"""How many times finer than the latent grid noise is moved, each way."""


class WarpedNoise:
    """Noise (h, w, C) on a grid, moved frame by frame; the same seed gives the same noise."""

    def __init__(self, size: tuple[int, int], channels: int, seed: int = 0) -> None:
        """size: width and height of the grid."""
        self.size, self._rng = size, np.random.default_rng(seed)
        count = size[0] * size[1]
        self._noise = self._rng.standard_normal((count, channels), np.float32)
        self._room = np.ones(count)

    @property
    def grid(self) -> FloatArray:
        """(h, w, C) on the fine grid."""
        width, height = self.size
        return self._noise.reshape(height, width, -1)

    def latent(self) -> FloatArray:
        """(h / FINER, w / FINER, C) of unit variance: sums over blocks."""
        height, width, channels = self.grid.shape
        blocks = self.grid.reshape(height // FINER, FINER, width // FINER, FINER, channels)
        return np.asarray(blocks.sum((1, 3)) / FINER, np.float32)

    def move(self, forward: Flow, backward: Flow) -> None:
        """One frame on. forward: to the next frame, backward: from it; on this grid, in its
        pixels."""
        source, target = self._edges(forward, backward)
        count = len(self._noise)
        many = np.bincount(source, minlength=count)[source]
        share = (self._room[source] / many)[:, None]
        parts = self._noise[source] * np.sqrt(self._room[source])[:, None] / many[:, None]
        parts += np.sqrt(share) * self._apart(source, many)
        room = np.bincount(target, share[:, 0], count)
        fresh = self._rng.standard_normal(self._noise.shape, np.float32)
        summed = np.stack(
            [np.bincount(target, parts[:, c], count) for c in range(parts.shape[1])], 1
        )
        known = room > 0
        moved = summed / np.sqrt(np.where(known, room, 1))[:, None]
        self._noise = np.where(known[:, None], moved, fresh).astype(np.float32)
        self._room = np.where(known, room, 1.0)

    def _edges(self, forward: Flow, backward: Flow) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
        """(E,) places that noise leaves, (E,) those where it goes; none is led behind another."""
        here = np.arange(len(self._noise))
        goal, inside = self._led(forward)
        one, other = here[inside], goal[inside]
        # Where none arrives, what is seen there comes from where it was.
        left = np.ones(len(here), bool)
        left[other] = False
        origin, known = self._led(backward)
        known &= left
        return np.concatenate([one, origin[known]]), np.concatenate([other, here[known]])

    def _led(self, flow: Flow) -> tuple[NDArray[np.int64], NDArray[np.bool_]]:
        """(N,) the place that each is led to, and (N,) whether it is seen there."""
        width, height = self.size
        y, x = np.divmod(np.arange(width * height), width)
        vectors = flow.vectors.reshape(-1, 2)
        to_x = np.floor(x + 0.5 + vectors[:, 0]).astype(np.int64)
        to_y = np.floor(y + 0.5 + vectors[:, 1]).astype(np.int64)
        inside = (to_x >= 0) & (to_x < width) & (to_y >= 0) & (to_y < height)
        inside &= flow.visible.ravel()
        return np.where(inside, to_y * width + to_x, 0), inside

    def _apart(self, source: NDArray[np.int64], many: NDArray[np.int64]) -> FloatArray:
        """(E, C) what makes the parts of one place independent: noise less its mean over them."""
        drawn = np.zeros((len(source), self._noise.shape[1]), np.float32)
        several = np.flatnonzero(many > 1)
        if not len(several):
            return drawn
        drawn[several] = self._rng.standard_normal((len(several), drawn.shape[1]), np.float32)
        _, group = np.unique(source[several], return_inverse=True)
        size = np.bincount(group)[:, None]
        for channel in range(drawn.shape[1]):
            own = drawn[several, channel]
            drawn[several, channel] = own - (np.bincount(group, own)[:, None] / size)[group, 0]
        return drawn


def warped(
    flows: Iterator[tuple[Flow, Flow]], latent: tuple[int, int], channels: int, seed: int = 0
) -> Iterator[FloatArray]:
    """(h, w, C) noise for the first frame and after each pair of flows, forward and backward.

    latent: width and height of the latent grid. flows: of pictures whose sides are multiples of
    its.
    """
    noise = WarpedNoise((latent[0] * FINER, latent[1] * FINER), channels, seed)
    yield noise.latent()
    for forward, backward in flows:
        noise.move(coarser(forward, noise.size), coarser(backward, noise.size))
        yield noise.latent()


def coarser(flow: Flow, size: tuple[int, int]) -> Flow:
    """The flow in the middle of each cell of a grid (width, height), in its cells."""
    rows, columns = flow.visible.shape
    y = ((np.arange(size[1]) + 0.5) * rows / size[1]).astype(int)
    x = ((np.arange(size[0]) + 0.5) * columns / size[0]).astype(int)
    scale = np.array([size[0] / columns, size[1] / rows], np.float32)
    picked = np.ix_(y, x)
    return Flow(flow.vectors[picked] * scale, flow.visible[picked])
