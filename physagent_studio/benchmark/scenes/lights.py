"""Light on a drawn scene: a sun that is a little wide and a sky, with the shadows they cast."""

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from physagent_studio.arrays import FloatArray
from physagent_studio.rendering.raster import Lens, rasterise

IntArray = NDArray[np.int32]
MAP, FAR = 320, 30.0
"""Pixels of a shadow map, and how far away lamps are, metres."""
BIAS = 0.012
"""Metres by which something has to be nearer to a lamp to shade what is behind."""
BRIGHT, EVEN = 1.75, 0.2
"""Strength of all lamps together, and light that reaches every place, over that of white paper."""
SUNS, SKIES = 5, 7
"""Lamps that make up the sun and the sky."""


@dataclass(frozen=True, eq=False, slots=True)
class Lamp:
    """A distant light. way: (3,) unit vector to it. colour: (3,) what it adds to what faces it."""

    way: FloatArray
    colour: FloatArray


def lamps(rng: np.random.Generator) -> list[Lamp]:
    """A sun behind the camera or to a side, hard or soft, and a sky all around."""
    azimuth, height = float(rng.uniform(-2.6, 0.4)), float(rng.uniform(0.5, 1.2))
    width, strength = float(rng.uniform(0.02, 0.2)), float(rng.uniform(0.25, 0.8))
    tint = np.array([1.0, rng.uniform(0.92, 1.0), rng.uniform(0.8, 1.0)])
    out = []
    for _ in range(SUNS):
        a, h = azimuth + rng.normal(0, width), height + rng.normal(0, width)
        out.append(Lamp(_way(float(a), float(h)), tint * strength / SUNS))
    for k in range(SKIES):
        a, h = 2 * math.pi * (k + rng.random()) / SKIES, float(rng.uniform(0.35, 1.3))
        out.append(Lamp(_way(a, h), np.array([0.95, 0.98, 1.05]) * (1.0 - strength) / SKIES))
    return out


def _way(azimuth: float, height: float) -> FloatArray:
    flat = math.cos(height)
    return np.array([flat * math.cos(azimuth), flat * math.sin(azimuth), math.sin(height)])


def shaded(
    lights: list[Lamp], seen: tuple[FloatArray, FloatArray], solid: tuple[FloatArray, IntArray]
) -> FloatArray:
    """(N, 3) light at places with normals, (N, 3) each, among solids: vertices, faces."""
    points, normals = seen
    out = np.full(points.shape, EVEN)
    for lamp in lights:
        facing = np.clip(0.1 + 0.9 * normals @ lamp.way, 0, 1)
        lit = _reached(lamp.way, points + BIAS * normals, *solid)
        out += (BRIGHT * facing * lit)[:, None] * lamp.colour
    return out


def _reached(
    way: FloatArray, points: FloatArray, vertices: FloatArray, faces: IntArray
) -> FloatArray:
    """(N,) 1 where nothing is between a place and a lamp, 0 where something is."""
    if not len(faces):
        return np.ones(len(points))
    right = np.cross(way, (0.0, 1.0, 0.0))
    right /= np.linalg.norm(right)
    axes = np.stack([right, np.cross(way, right), -way])
    middle = (vertices.min(0) + vertices.max(0)) / 2
    reach = float(np.linalg.norm(vertices.max(0) - vertices.min(0))) / 2 + 0.05
    lens = Lens(MAP, MAP, FAR * MAP / (2 * reach), MAP / 2, MAP / 2)
    own = (vertices - middle) @ axes.T + (0, 0, FAR)
    hits = rasterise(own, faces, lens, np.zeros(len(faces), bool))
    depth = np.full(MAP * MAP, np.inf)
    depth[hits.pixel] = hits.depth
    asked = (points - middle) @ axes.T + (0, 0, FAR)
    pixel = np.floor(lens.project(asked)).astype(int)
    held = ((pixel >= 0) & (pixel < MAP)).all(1)
    index = np.where(held, pixel[:, 1] * MAP + pixel[:, 0], 0)
    return np.where(held & (depth[index] < asked[:, 2] - BIAS), 0.0, 1.0)
