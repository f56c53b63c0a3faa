"""Procedural surfaces. Colours are linear RGB in [0, 1], heights metres, lengths metres."""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from photoreal.noise import layered, smooth, solid, solid_layered

Array = NDArray[np.floating]


@dataclass(frozen=True)
class Surface:
    """One texture: colour (H, W, 3), roughness (H, W), height (H, W) in metres."""

    colour: Array
    roughness: Array
    height: Array


def linear(colour: tuple[float, float, float]) -> Array:
    """An sRGB colour with parts 0 … 255 as linear RGB."""
    c = np.asarray(colour, np.float32) / 255
    return np.where(c <= 0.04045, c / 12.92, ((c + 0.055) / 1.055) ** 2.4).astype(np.float32)


def mix(a: Array, b: Array, t: Array) -> Array:
    """Colours a, b (3,) blended in log space by t (...,), which keeps browns saturated."""
    t = np.clip(t, 0, 1)[..., None]
    return np.exp((1 - t) * np.log(a + 1e-4) + t * np.log(b + 1e-4)).astype(np.float32)


def _rings(distance: Array, width: float, rng: np.random.Generator) -> Array:
    """Late wood in [0, 1] for distances from the pith.

    Within a year the wood darkens slowly and then stops at once; years differ in width.
    """
    count = int(float(distance.max()) / width * 1.8) + 8
    edges = np.cumsum(width * np.clip(rng.lognormal(0, 0.28, count), 0.45, 2.2))
    index = np.clip(np.searchsorted(edges, distance), 1, count - 1)
    lower, upper = edges[index - 1], edges[index]
    part = np.clip((distance - lower) / (upper - lower), 0, 1)
    late = part**2.2 * np.clip((1 - part) / 0.10, 0, 1)
    strength = rng.uniform(0.55, 1.0, count)[index]
    return (late * strength).astype(np.float32)


def _pores(rng: np.random.Generator, shape: tuple[int, int], texel: float) -> Array:
    """Short dark dashes along the rows' direction (axis 0), the open vessels of oak, [0, 1]."""
    seeds = (rng.random(shape) < 0.0075).astype(np.float32)
    length = max(3, int(0.006 / texel)) | 1
    dashes = cv2.filter2D(seeds, -1, np.ones((length, 1), np.float32))
    dashes = cv2.GaussianBlur(np.minimum(dashes, 1), (3, 1), 0.45)
    return dashes * np.clip(0.7 + 0.4 * smooth(rng, shape, (length, 3)), 0, 1)


def _board(rng: np.random.Generator, shape: tuple[int, int], texel: float) -> tuple[Array, Array]:
    """Darkness in about [0, 1] and pores of one board (rows along the grain)."""
    rows, columns = shape
    u = (np.arange(rows, dtype=np.float32) * texel)[:, None]
    v = (np.arange(columns, dtype=np.float32) * texel)[None, :]
    width = columns * texel
    # Where the pith runs under the board decides between arches and straight lines.
    flat_sawn = rng.random() < 0.55
    middle = rng.uniform(0.25, 0.75) * width if flat_sawn else rng.choice([-1, 2]) * width * 1.3
    deep = rng.uniform(0.02, 0.055) + rng.uniform(-0.03, 0.03) * u
    wander = 0.004 * smooth(rng, (rows, 1), (0.30 / texel, 1))
    drift = 0.0022 * layered(rng, shape, (0.14 / texel, 0.022 / texel), 3)
    distance = np.hypot(v - middle - wander, deep + 0.6 * wander) + drift
    late = _rings(distance.astype(np.float32), rng.uniform(0.0026, 0.0042), rng)
    fibre = smooth(rng, shape, (0.045 / texel, 0.0007 / texel))
    fine = smooth(rng, shape, (0.012 / texel, 1))
    cloud = layered(rng, shape, (0.25 / texel, 0.035 / texel), 3)
    dark = 0.52 * late + 0.060 * fibre + 0.035 * fine + 0.055 * cloud + 0.22
    early = np.clip(1 - 1.6 * late, 0.15, 1)
    return dark.astype(np.float32), _pores(rng, shape, texel) * early


def boards(
    rng: np.random.Generator,
    size: tuple[float, float],
    texel: float,
    *,
    board: float = 0.105,
    light: tuple[float, float, float] = (184, 138, 94),
    dark: tuple[float, float, float] = (94, 57, 33),
) -> Surface:
    """A table top of edge-glued boards, `size` = (along the grain, across) in metres.

    Rows of the arrays run along the grain.
    """
    rows, columns = (round(s / texel) for s in size)
    darkness = np.zeros((rows, columns), np.float32)
    pores, seam = np.zeros_like(darkness), np.zeros_like(darkness)
    start = -int(rng.uniform(0.2, 0.8) * board / texel)
    while start < columns:
        wide = int(board * rng.uniform(0.85, 1.15) / texel)
        one, holes = _board(rng, (rows, wide), texel)
        one = one + rng.normal(0, 0.055)
        first, last = max(start, 0), min(start + wide, columns)
        darkness[:, first:last] = one[:, first - start : last - start]
        pores[:, first:last] = holes[:, first - start : last - start]
        seam[:, max(last - 1, 0) : last + 1] = 1
        start += wide
    seam = seam * np.clip(0.55 + 0.35 * smooth(rng, (rows, 1), (0.05 / texel, 1)), 0.1, 1)
    colour = mix(linear(light), linear(dark), darkness)
    colour *= (1 - 0.40 * pores - 0.45 * seam)[..., None]
    warm = 0.03 * smooth(rng, (rows, columns), (0.3 / texel, 0.08 / texel))
    colour *= np.stack([1 + warm, np.ones_like(warm), 1 - warm], -1)
    use = layered(rng, (rows, columns), (0.12 / texel, 0.10 / texel), 4)
    roughness = 0.40 + 0.035 * use + 0.10 * pores - 0.05 * np.clip(darkness, 0, 1)
    height = -6e-5 * pores - 1.2e-4 * seam - 1.5e-5 * darkness
    return Surface(np.clip(colour, 0, 1), np.clip(roughness, 0.2, 0.8), height)


def solid_wood(
    points: NDArray[np.floating],
    rng: np.random.Generator,
    *,
    light: tuple[float, float, float] = (232, 203, 160),
    dark: tuple[float, float, float] = (160, 104, 56),
    ring: float = 0.0056,
) -> tuple[Array, Array]:
    """Colour (..., 3) and darkness (...) of solid wood at body points (..., 3), grain along z."""
    seed = int(rng.integers(1 << 20))
    pith = np.array([-0.055, -0.042]) + rng.normal(0, 0.008, 2)
    lean = rng.normal(0, 0.09, 2)
    x, y, z = (points[..., k] for k in range(3))
    slow = solid_layered(points * [22, 22, 7], seed) * 0.0026
    distance = np.hypot(x - pith[0] - lean[0] * z, y - pith[1] - lean[1] * z) + slow
    late = _rings(distance.astype(np.float32), ring, rng)
    fibre = solid(points * [1900, 1900, 45], seed + 10) + 0.7 * solid(
        points * [3600, 3600, 110], seed + 11
    )
    flecks = np.clip(solid(points * [2600, 1500, 230], seed + 12) - 0.62, 0, 1) * 1.6
    cloud = solid_layered(points * [30, 30, 9], seed + 20)
    darkness = 0.15 + 0.72 * late + 0.055 * fibre + 0.28 * flecks + 0.10 * cloud
    return mix(linear(light), linear(dark), darkness), darkness.astype(np.float32)


def plaster(
    rng: np.random.Generator,
    shape: tuple[int, int],
    texel: float,
    tint: tuple[float, float, float] = (226, 221, 211),
) -> Surface:
    """A hand-finished, painted wall: faint clouds of tone, trowel marks, fine grain."""
    cloud = layered(rng, shape, (0.30 / texel, 0.36 / texel), 4, 0.55)
    stain = layered(rng, shape, (0.05 / texel, 0.07 / texel), 3)
    grain = layered(rng, shape, (0.004 / texel, 0.004 / texel), 2, 0.6)
    trowel = layered(rng, shape, (0.035 / texel, 0.16 / texel), 3)
    tone = 1 + 0.018 * cloud + 0.006 * stain + 0.004 * grain
    warm = 0.006 * layered(rng, shape, (0.4 / texel, 0.5 / texel), 2)
    colour = linear(tint) * tone[..., None] * np.stack([1 + warm, np.ones_like(warm), 1 - warm], -1)
    pits = np.clip(smooth(rng, shape, (0.003 / texel, 0.004 / texel)) - 2.3, 0, 1)
    height = 2.2e-4 * trowel + 1.2e-5 * grain - 1.5e-4 * pits
    rough = np.full(shape, 0.85, np.float32)
    return Surface(np.clip(colour, 0, 1).astype(np.float32), rough, height.astype(np.float32))


def plain(
    rng: np.random.Generator,
    shape: tuple[int, int],
    cell: tuple[float, float],
    tint: tuple[float, float, float],
    *,
    roughness: float,
    mottle: float = 0.02,
    bump: float = 1e-5,
) -> Surface:
    """Paint, plastic, card or cloth: one colour, slightly uneven in tone, gloss and height."""
    cloud = layered(rng, shape, cell, 4)
    fine = smooth(rng, shape, (2, 2))
    colour = linear(tint) * (1 + mottle * cloud + 0.1 * mottle * fine)[..., None]
    rough = roughness * (1 + 0.08 * layered(rng, shape, cell, 5, 0.7))
    return Surface(
        np.clip(colour, 0, 1).astype(np.float32),
        np.clip(rough, 0.05, 1).astype(np.float32),
        (bump * (cloud + 0.2 * fine)).astype(np.float32),
    )
