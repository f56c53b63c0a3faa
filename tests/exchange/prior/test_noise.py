"""Noise that moves with the picture stays white, Gaussian, of unit variance, and goes along."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.stats import kstest

from physagent_studio.exchange.prior.noise import WarpedNoise, coarser
from physagent_studio.rendering import Flow

SIZE = (96, 64)


def flow_of(vectors: np.ndarray, visible: np.ndarray | None = None) -> Flow:
    seen = np.ones(vectors.shape[:2], bool) if visible is None else visible
    return Flow(vectors.astype(np.float32), seen)


def grid() -> tuple[np.ndarray, np.ndarray]:
    y, x = np.indices(SIZE[::-1]) + 0.5
    return x - SIZE[0] / 2, y - SIZE[1] / 2


def zoom(factor: float) -> tuple[Flow, Flow]:
    x, y = grid()
    ahead = np.stack([x, y], -1) * (factor - 1)
    back = np.stack([x, y], -1) * (1 / factor - 1)
    return flow_of(ahead), flow_of(back)


def turn(angle: float) -> tuple[Flow, Flow]:
    x, y = grid()

    def by(a: float) -> Flow:
        c, s = np.cos(a), np.sin(a)
        return flow_of(np.stack([c * x - s * y - x, s * x + c * y - y], -1))

    return by(angle), by(-angle)


@pytest.mark.parametrize("motion", [zoom(1.04), zoom(0.97), turn(0.05)], ids=["in", "out", "turn"])
def test_it_stays_white_and_of_unit_variance(motion):
    noise = WarpedNoise(SIZE, 24, seed=3)
    for _ in range(20):
        noise.move(*motion)
    found = noise.grid
    assert found.mean() == pytest.approx(0, abs=0.02)
    assert found.var() == pytest.approx(1, abs=0.03)
    assert kstest(found.ravel()[::7], "norm").pvalue > 1e-3
    # Neighbours know nothing of one another.
    beside = (found[:, 1:] * found[:, :-1]).mean(), (found[1:] * found[:-1]).mean()
    assert np.abs(beside).max() < 0.02
    latent = noise.latent()
    assert latent.shape == (SIZE[1] // 2, SIZE[0] // 2, 24)
    assert latent.var() == pytest.approx(1, abs=0.05)
    assert abs((latent[:, 1:] * latent[:, :-1]).mean()) < 0.03


def test_what_is_still_keeps_its_noise_and_what_moves_takes_it_along():
    noise = WarpedNoise(SIZE, 8, seed=1)
    before = noise.grid.copy()
    own = np.zeros(SIZE[::-1], bool)
    own[20:40, 30:50] = True
    vectors = np.where(own[..., None], (6.0, 2.0), 0.0)
    # The ground that the thing covers next is hidden there.
    after = np.roll(own, (2, 6), (0, 1))
    ahead = flow_of(vectors, own | ~after)
    back = flow_of(np.where(after[..., None], (-6.0, -2.0), 0.0), after | ~own)
    noise.move(ahead, back)
    now = noise.grid
    assert np.allclose(now[after], before[own], atol=1e-6)
    still = ~own & ~after
    assert np.array_equal(now[still], before[still])
    fresh = own & ~after
    assert abs((now[fresh] * before[fresh]).mean()) < 0.15


def test_the_same_seed_gives_the_same_noise():
    one, other = (WarpedNoise(SIZE, 4, seed=5) for _ in range(2))
    for noise in (one, other):
        noise.move(*zoom(1.1))
    assert np.array_equal(one.grid, other.grid)


def test_flow_on_a_coarser_grid_is_in_its_cells():
    flow = flow_of(np.full((480, 832, 2), (8.0, 4.0)))
    found = coarser(flow, (208, 120))
    assert found.vectors.shape == (120, 208, 2)
    assert np.allclose(found.vectors, (2.0, 1.0))
