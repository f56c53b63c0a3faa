"""Things of many parts for `photoreal.fields`: a locomotive, blocks, a skateboard, books."""

from __future__ import annotations

import cv2
import numpy as np

from photoreal.fields import Array, Body, Finish, Part
from photoreal.meshes import atlas_points
from photoreal.noise import solid, solid_layered
from photoreal.props import (
    Colour,
    Rng,
    Triple,
    ball,
    brick,
    cubic,
    cut,
    even,
    faces,
    joined,
    printed,
    ring,
    rod,
    written,
)
from photoreal.textures import linear, solid_wood


def wheel(x: float, y: float, radius: float, tone: Colour) -> Part:
    """A spoked toy wheel about the y axis, resting on z = 0."""

    def paint(p: Array) -> Array:
        dx, dz = p[:, 0] - x, p[:, 2] - radius + 0.08
        part, angle = np.hypot(dx, dz) / radius, np.arctan2(dz, dx)
        gap = (np.abs(np.sin(3 * angle)) > 0.4) & (part > 0.28) & (part < 0.72)
        colour = np.where(gap[:, None], linear((58, 26, 22)), linear(tone))
        colour[(part < 0.16) | (part > 0.93)] = linear((70, 66, 62))
        return colour * (1 + 0.05 * solid_layered(p * 200, 9))[:, None]

    def hollow(p: Array) -> Array:
        part = np.hypot(p[:, 0] - x, p[:, 2] - radius + 0.08) / radius
        return (-0.0015 * np.clip((0.85 - part) * 12, 0, 1) * (part > 0.2)).astype(np.float32)

    shape = rod(radius, 0.006, 1, (x, y, radius - 0.08), edge=0.002)
    return Part(shape, Finish(paint, rough=0.3, relief=hollow))


def locomotive() -> tuple[Part, ...]:
    """A steam engine of painted wood and brass, 0.3 m long, heading for -x on eight wheels."""
    green, red = Finish(even((40, 112, 74)), rough=0.25), Finish(even((190, 44, 36)), rough=0.25)
    black, brass = Finish(even((34, 34, 36)), rough=0.3), Finish(even((216, 170, 74)), rough=0.25,
                                                                 metal=True)  # fmt: skip
    blue, steel = Finish(even((44, 84, 156)), rough=0.25), Finish(even((150, 150, 148)), rough=0.4)
    low = -0.08
    cab = cut(
        brick((0.042, 0.04, 0.044), 0.003, (0.085, 0, low + 0.09)),
        brick((0.02, 0.06, 0.018), 0.004, (0.087, 0, low + 0.104)),
        brick((0.06, 0.026, 0.018), 0.004, (0.085, 0, low + 0.104)),
    )
    bands = joined(*(ring(0.0325, 0.002, 0, (x, 0, low + 0.08)) for x in (-0.085, -0.03, 0.02)))
    spots = ((0.082, 0.034), (0.006, 0.034), (-0.066, 0.023), (-0.118, 0.023))
    axles = joined(*(rod(0.004, 0.045, 1, (x, 0, low + z)) for x, z in spots))
    parts = [
        Part(joined(brick((0.138, 0.032, 0.009), 0.002, (0, 0, low + 0.042)),
                    brick((0.006, 0.044, 0.012), 0.002, (-0.142, 0, low + 0.038))), red),
        Part(rod(0.032, 0.082, 0, (-0.036, 0, low + 0.08), edge=0.003), green),
        Part(joined(rod(0.0345, 0.013, 0, (-0.122, 0, low + 0.08), edge=0.004),
                    rod(0.011, 0.024, 2, (-0.112, 0, low + 0.128), taper=0.12)), black),
        Part(joined(bands, ball(0.017, (-0.02, 0, low + 0.112)), rod(0.01, 0.006, 0,
                    (-0.136, 0, low + 0.1)), ring(0.0145, 0.003, 2, (-0.112, 0, low + 0.152)),
                    rod(0.006, 0.012, 2, (-0.064, 0, low + 0.118))), brass),
        Part(cab, blue),
        Part(brick((0.053, 0.049, 0.006), 0.004, (0.085, 0, low + 0.139)), red),
        Part(joined(brick((0.042, 0.003, 0.005), 0.002, (0.044, -0.056, low + 0.034)),
                    rod(0.006, 0.014, 1, (0.082, -0.05, low + 0.034)),
                    rod(0.006, 0.014, 1, (0.006, -0.05, low + 0.034)), axles), steel),
    ]  # fmt: skip
    for side in (-0.045, 0.045):
        for x, radius in spots:
            parts.append(wheel(x, side, radius, (226, 172, 44)))
    return tuple(parts)


def painted_block(rng: Rng, side: float, stain: Colour, letter: str) -> Finish:
    """Solid wood under a thin stain, with a letter on every face."""
    _, dark = solid_wood(atlas_points(cubic(side), 260), rng)
    atlas = linear(stain) * (1.12 - 0.55 * np.clip(dark, 0, 1))[..., None]
    sheet = written(letter, (260, 260), 5.5, 16, (70, 190))
    cv2.rectangle(sheet, (22, 22), (238, 238), 0.9, 7, cv2.LINE_AA)
    atlas = printed(atlas, sheet, (240, 232, 208), 0.85, "012345")
    return Finish(faces(cubic(side / 2), atlas), rough=0.38)


def board() -> tuple[Part, ...]:
    """A skateboard along x: a deck of coloured plies under grip tape, trucks, four wheels."""

    def bent(p: Array) -> Array:
        end = np.clip(np.abs(p[:, 0]) - 0.255, 0, None)
        q = p.copy()
        q[:, 2] -= 0.035 + 2.6 * end**2 / (1 + 6 * end)
        round_ = np.hypot(np.clip(np.abs(q[:, 0]) - 0.3, 0, None), q[:, 1]) - 0.1
        return (0.8 * np.maximum(np.abs(q[:, 2]) - 0.006, round_)).astype(np.float32)

    def deck(p: Array) -> Array:
        end = np.clip(np.abs(p[:, 0]) - 0.255, 0, None)
        high = p[:, 2] - 0.035 - 2.6 * end**2 / (1 + 6 * end)
        plies = np.floor((high + 0.006) / 0.0024).astype(int)
        colour = np.stack([linear(c) for c in ((206, 166, 112), (40, 150, 160))])[plies % 2]
        colour[high > 0.0045] = linear((44, 44, 46))
        fine = 1 + 0.25 * solid(p * 900, 3) * (high > 0.0045)
        return (colour * fine[:, None]).astype(np.float32)

    def tread(p: Array) -> Array:
        part = np.hypot(np.abs(p[:, 0]) - 0.215, p[:, 2] + 0.044)
        colour = np.where(part[:, None] < 0.0115, linear((130, 130, 134)), linear((238, 122, 40)))
        return (colour * (1 + 0.06 * solid_layered(p * 150, 5))[:, None]).astype(np.float32)

    spots = [(x, y) for x in (-0.215, 0.215) for y in (-0.082, 0.082)]
    wheels = joined(*(rod(0.029, 0.017, 1, (x, y, -0.044), edge=0.006) for x, y in spots))
    trucks = joined(*(joined(rod(0.007, 0.1, 1, (x, 0, -0.044)), brick((0.03, 0.025, 0.006), 0.002,
                      (x, 0, 0.02)), rod(0.016, 0.03, 2, (x, 0, -0.012), taper=0.2),
                      brick((0.011, 0.055, 0.01), 0.004, (x, 0, -0.04)))
                      for x in (-0.215, 0.215)))  # fmt: skip
    metal = Finish(even((170, 170, 172)), rough=0.35, metal=True)
    look = Finish(tread, 0.05, 0.3)
    return Part(bent, Finish(deck, rough=0.6)), Part(trucks, metal), Part(wheels, look)


def bookcase(rng: Rng, half: Triple, position: Triple) -> Body:
    """A case of books for the background; their spines are painted on its front."""
    count, row = 400, 0.29
    edges = np.cumsum(rng.uniform(0.018, 0.05, count))
    tints = (
        linear((120, 110, 100))
        * rng.uniform(0.25, 1.7, (count, 1))
        * rng.uniform(0.6, 1.3, (count, 3))
    )
    tops = rng.uniform(0.66, 0.9, count)

    def paint(p: Array) -> Array:
        high = (p[:, 2] + half[2]) / row
        shelf = np.floor(high)
        index = np.searchsorted(edges, p[:, 0] + half[0] + 0.9 * shelf + 0.1) % count
        inside = (high - shelf > 0.07) & (high - shelf < tops[index]) & (p[:, 1] < 0)
        inside &= np.abs(p[:, 0]) < half[0] - 0.025
        band = np.abs(high - shelf - 0.55) < 0.03
        colour = tints[index] * np.where(band, 1.8, 1)[:, None]
        wall = (high - shelf < 0.07) | (np.abs(p[:, 0]) >= half[0] - 0.025) | (p[:, 1] >= half[1])
        frame = np.where(wall[:, None], linear((142, 104, 70)), linear((40, 30, 24)))
        return np.clip(np.where(inside[:, None], colour, frame), 0, 1).astype(np.float32)

    return Body(half, (Part(None, Finish(paint, rough=0.6)),), position)
