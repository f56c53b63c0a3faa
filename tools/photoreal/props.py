"""Shapes, surfaces, light and cameras from which scenes for `photoreal.fields` are put together.

NumPy and OpenCV only. Colours are sRGB with parts 0 … 255 unless they are called linear; lengths
are metres and stand in the body frame.
"""

from __future__ import annotations

import math
from collections.abc import Callable

import cv2
import numpy as np
from numpy.typing import NDArray

from photoreal.fields import Array, Body, Eye, Field, Finish, Lamp, Part
from photoreal.noise import layered, smooth, solid_layered
from photoreal.textures import Surface, linear

Colour = tuple[float, float, float]
Triple = tuple[float, float, float]
Rng = np.random.Generator
ORIGIN = (0.0, 0.0, 0.0)


# Signed distances in the body frame.


def ball(radius: float, centre: Triple = ORIGIN) -> Field:
    """A sphere."""
    return lambda p: np.linalg.norm(p - np.array(centre, np.float32), axis=1) - np.float32(radius)


def brick(half: Triple, edge: float = 0.001, centre: Triple = ORIGIN) -> Field:
    """A box of half extents `half` with rounded edges."""

    def distance(p: Array) -> Array:
        q = np.abs(p - np.array(centre, np.float32)) - (
            np.array(half, np.float32) - np.float32(edge)
        )
        outside = np.sqrt(np.square(np.maximum(q, 0)) @ np.ones(3, np.float32))
        return outside + np.minimum(np.maximum.reduce([*q.T]), 0) - np.float32(edge)

    return distance


def rod(
    radius: float, half: float, axis: int = 2, centre: Triple = ORIGIN, *,
    edge: float = 0.001, taper: float = 0.0,
) -> Field:  # fmt: skip
    """A round rod along an axis; `taper` is how much its radius grows per metre."""
    others = [k for k in range(3) if k != axis]

    def distance(p: Array) -> Array:
        q = p - np.array(centre, np.float32)
        wide = np.linalg.norm(q[:, others], axis=1) - np.float32(radius - edge) - taper * q[:, axis]
        high = np.abs(q[:, axis]) - np.float32(half - edge)
        outside = np.hypot(np.maximum(wide, 0), np.maximum(high, 0))
        return (outside + np.minimum(np.maximum(wide, high), 0) - edge).astype(np.float32)

    return distance


def ring(radius: float, thick: float, axis: int = 2, centre: Triple = ORIGIN) -> Field:
    """A torus about an axis."""
    others = [k for k in range(3) if k != axis]

    def distance(p: Array) -> Array:
        q = p - np.array(centre, np.float32)
        away = np.linalg.norm(q[:, others], axis=1) - np.float32(radius)
        return np.hypot(away, q[:, axis]) - np.float32(thick)

    return distance


def joined(*fields: Field) -> Field:
    """All of the given bodies as one."""
    return lambda p: np.min([f(p) for f in fields], axis=0)


def cut(whole: Field, *holes: Field) -> Field:
    """A body with others taken away."""
    return lambda p: np.max([whole(p), *(-hole(p) for hole in holes)], axis=0)


def melted(one: Field, two: Field, soft: float) -> Field:
    """Two bodies as one, with a fillet about `soft` wide."""

    def distance(p: Array) -> Array:
        a, b = one(p), two(p)
        near = np.maximum(soft - np.abs(a - b), 0) / soft
        return (np.minimum(a, b) - near**2 * soft / 4).astype(np.float32)

    return distance


def egg(radii: Triple) -> Field:
    """An ellipsoid; the distance is right to first order."""

    def distance(p: Array) -> Array:
        part = p / np.array(radii, np.float32)
        size, slope = (
            np.linalg.norm(part, axis=1),
            np.linalg.norm(part / np.array(radii, np.float32), axis=1),
        )
        return (size * (size - 1) / np.maximum(slope, 1e-6)).astype(np.float32)

    return distance


# What surfaces look like.


def even(colour: Colour, mottle: float = 0.05, scale: float = 60, seed: int = 1) -> Field:
    """One sRGB colour, slightly uneven; `scale` is blotches per metre."""
    tint = linear(colour)
    return lambda p: np.clip(tint * (1 + mottle * solid_layered(p * scale, seed))[:, None], 0, 1)


def grainy(height: float, scale: float, seed: int = 3) -> Field:
    """Relief of fractal noise, metres high, `scale` bumps per metre."""
    return lambda p: np.float32(height) * solid_layered(p * np.float32(scale), seed)


def picked(image: Array, rows: Array, columns: Array, *, mirror: bool = False) -> Array:
    """Texels of an image that repeats itself, or, `mirror`, is reflected at its borders."""
    index = []
    for values, count in zip((rows, columns), image.shape[:2], strict=True):
        whole = np.floor(values).astype(int) % (2 * count if mirror else count)
        index.append(np.minimum(whole, 2 * count - 1 - whole) if mirror else whole)
    return image[index[0], index[1]]


def _laid(
    surface: Surface, texel: float, places: Callable[[Array], tuple[Array, Array]], mirror: bool
) -> tuple[Field, Field]:
    """Paint and relief of a sheet whose middle lies at the origin of `places`, in metres."""
    height = surface.height.astype(np.float32)
    middle = np.array(height.shape) // 2

    def texels(p: Array) -> tuple[Array, Array]:
        row, column = places(p)
        return row / texel + middle[0], column / texel + middle[1]

    return (
        lambda p: picked(surface.colour, *texels(p), mirror=mirror),
        lambda p: picked(height, *texels(p), mirror=mirror),
    )


def spread(
    surface: Surface, texel: float, half: Triple, *, rough: float | None = None, tiles: bool = False
) -> Finish:
    """A sheet laid over a box: its rows along x, its columns along y, folded down at the sides.

    tiles: it repeats without a seam; any other is reflected at its borders.
    """

    def places(p: Array) -> tuple[Array, Array]:
        down = np.float32(half[2]) - p[:, 2]
        side = np.abs(p[:, 0]) > half[0] - 1e-4
        return p[:, 0] + side * down, p[:, 1] - ~side * down

    paint, relief = _laid(surface, texel, places, not tiles)
    dull = float(surface.roughness.mean()) if rough is None else rough
    return Finish(paint, rough=dull, relief=relief, grain=texel)


def slab(half: Triple, position: Triple, finish: Finish, name: str | None = None) -> Body:
    """A box with sharp faces: floors, walls, tables."""
    return Body(half, (Part(None, finish),), position, name=name)


def flat_wall(
    y: float, surface: Surface, texel: float, base: float = 0.0, *, tiles: bool = False
) -> Body:
    """A wall across the view whose sheet runs along x and up; its foot is at height `base`."""
    paint, relief = _laid(surface, texel, lambda p: (-p[:, 2], p[:, 0]), not tiles)
    finish = Finish(paint, rough=float(surface.roughness.mean()), relief=relief, grain=texel)
    return slab((6, 0.05, 1.5), (0, y + 0.05, base + 1.5), finish)


def skirting(y: float, colour: Colour, high: float = 0.09, base: float = 0.0) -> Body:
    """A painted board at the foot of a wall."""
    return slab((6, 0.008, high / 2), (0, y - 0.008, base + high / 2), Finish(even(colour)))


def tiled(
    rng: Rng, cell: tuple[int, int], colours: list[Colour], grout: Colour, *,
    count: int = 8, joint: int = 3, shift: float = 0.0, cloud: float = 0.07,
) -> Surface:  # fmt: skip
    """`count`² tiles of `cell` texels (rows, columns), each its own tone; rows may be shifted."""
    shape = (cell[0] * count, cell[1] * count)
    row = np.arange(shape[0])[:, None] * np.ones(shape[1], int)
    number = row // cell[0]
    column = np.arange(shape[1])[None, :] + (number * shift * cell[1]).astype(int)
    index = rng.integers(len(colours), size=(count, 2 * count))
    which = (number, column // cell[1] % count)
    tone = rng.normal(1, 0.06, (count, 2 * count))[which]
    tone = tone + cloud * layered(rng, shape, (cell[0] / 2, cell[1] / 3), 5)
    colour = np.stack([linear(c) for c in colours])[index][which] * tone[..., None]
    edge = np.minimum(row % cell[0], column % cell[1]) < joint
    soft = cv2.GaussianBlur(edge.astype(np.float32), (0, 0), joint / 3)
    dirty = linear(grout) * (1 + 0.15 * layered(rng, shape, (6, 6)))[..., None]
    colour = colour * (1 - soft[..., None]) + dirty * soft[..., None]
    rough = np.full(shape, 0.22, np.float32)
    return Surface(np.clip(colour, 0, 1).astype(np.float32), rough, -8e-4 * soft)


def grit(rng: Rng, colours: list[Colour], grains: float, size: int = 1400) -> Surface:
    """Asphalt or granite: grains of several colours, `grains` texels large."""
    base = linear(colours[0]) * (1 + 0.10 * layered(rng, (size, size), (200, 200)))[..., None]
    colour, height = base, layered(rng, (size, size), (grains, grains), 2)
    for k, tint in enumerate(colours[1:]):
        noise = layered(rng, (size, size), (grains * (1 + 0.5 * k), grains * (1 + 0.5 * k)), 3)
        part = np.clip((noise - 1.0) * 1.6, 0, 0.8)[..., None]
        colour = colour * (1 - part) + linear(tint) * part
    colour = colour * (1 + 0.10 * smooth(rng, (size, size), (2, 2)))[..., None]
    rough = np.full((size, size), 0.8, np.float32)
    return Surface(np.clip(colour, 0, 1).astype(np.float32), rough, 3e-4 * height)


def cloth(rng: Rng, pattern: Array, weave: float, relief: float) -> Surface:
    """A woven or tufted sheet; pattern: linear RGB (H, W, 3). weave: texels per thread."""
    shape = (pattern.shape[0], pattern.shape[1])
    tuft = layered(rng, shape, (weave, weave), 2, 0.7)
    worn = layered(rng, shape, (160, 160), 4)
    colour = pattern * (1 + 0.16 * tuft + 0.05 * worn)[..., None]
    rough = np.full(shape, 0.95, np.float32)
    return Surface(np.clip(colour, 0.002, 1).astype(np.float32), rough, relief * tuft)


def stripes(widths: list[int], colours: list[Colour], size: int) -> Array:
    """Linear RGB (size, size, 3): stripes of the given widths in texels, along the columns."""
    order = np.repeat(np.arange(len(widths)), widths)
    line = np.stack([linear(c) for c in colours])[order][np.arange(size) % len(order)]
    return np.broadcast_to(line[:, None], (size, size, 3)).astype(np.float32)


def written(
    text: str, size: tuple[int, int], scale: float, thick: int, at: tuple[int, int]
) -> Array:
    """Coverage (H, W) of a line of print on a sheet of `size` = (width, height)."""
    sheet = np.zeros((size[1], size[0]), np.uint8)
    cv2.putText(sheet, text, at, cv2.FONT_HERSHEY_DUPLEX, scale, 255, thick, cv2.LINE_AA)
    return cv2.GaussianBlur(sheet, (0, 0), 1).astype(np.float32) / 255


def faces(half: Triple, atlas: Array) -> Field:
    """Paint of a box from its 3 × 2 atlas, see `photoreal.meshes.box`."""
    cell = atlas.shape[0] // 2
    spans = ((1, 2), (1, 2), (0, 2), (0, 2), (0, 1), (0, 1))

    def paint(p: Array) -> Array:
        part = p / np.array(half, np.float32)
        axis = np.abs(part).argmax(1)
        number = 2 * axis + (part[np.arange(len(p)), axis] < 0)
        uv = np.take_along_axis(part, np.array(spans)[number], 1).clip(-1, 1) * 0.49 + 0.5
        rows = (uv[:, 1] + number // 3) * cell
        return picked(atlas, np.minimum(rows, 2 * cell - 1), (uv[:, 0] + number % 3) * cell)

    return paint


def printed(atlas: Array, print_: Array, colour: Colour, strength: float, cells: str) -> Array:
    """An atlas with a square print on some of its cells, upright and readable on the side faces.

    cells: numbers 0 to 5 of the faces +x, -x, +y, -y, +z, -z.
    """
    cell, result = atlas.shape[0] // 2, atlas.copy()
    for number in map(int, cells):
        row, column = divmod(number, 3)
        part = print_[::-1, ::-1] if number in (1, 2, 5) else print_[::-1]
        spot = result[row * cell : (row + 1) * cell, column * cell : (column + 1) * cell]
        spot += (linear(colour) - spot) * strength * part[..., None]
    return result.astype(np.float32)


# Light and camera.


def cubic(half: float) -> Triple:
    """Three times the same length."""
    return half, half, half


def triple(values: NDArray[np.floating]) -> Triple:
    """Three numbers as a tuple."""
    x, y, z = (float(v) for v in values)
    return x, y, z


def indoors(level: float = 0.5, warm: float = 1.0) -> Field:
    """Light of a room: a bright ceiling, dim walls, a darker floor."""

    def sky(way: Array) -> Array:
        up = way[:, 2:]
        tone = level * np.where(up > 0, 0.55 + 0.6 * up, 0.55 + 0.25 * up)
        side = 1 - 0.35 * way[:, :1]
        return tone * side * np.array([1.0 * warm, 0.97, 0.94 / warm], np.float32)

    return sky


def outdoors(way: Array) -> Array:
    """A hazy blue sky over a grey horizon."""
    up = np.clip(way[:, 2:], 0, 1) ** 0.5
    return 1.1 * (
        (1 - up) * np.array([0.86, 0.9, 0.95], np.float32)
        + up * np.array([0.34, 0.55, 0.95], np.float32)
    )


def window(side: float, y: float, z: float, power: float, size: float = 0.55) -> Lamp:
    """A window `side` metres to the right (or left, negative), facing across the scene."""
    tone = (power, power * 0.97, power * 0.92)
    return Lamp((side, y, z), (0, size, 0), (0.25 * size * np.sign(side), 0, size), tone)


def sun(x: float, y: float, z: float, power: float) -> Lamp:
    """A far, small, warm light in direction (x, y, z)."""
    way = np.array([x, y, z]) / math.hypot(x, y, z) * 60
    along = np.cross(way, (0, 0, 1.0))
    along = along / np.linalg.norm(along) * 0.9
    up = np.cross(along, way) / 60
    tone = (power, power * 0.93, power * 0.82)
    return Lamp(triple(way), triple(along), triple(up), tone)


def eye_at(
    size: tuple[int, int], fov: float, height: float, pitch: float, focus: float,
    aperture: float = 0.003,
) -> Eye:  # fmt: skip
    """fov: vertical, degrees. pitch: degrees downwards. focus, height: metres."""
    focal = size[1] / 2 / math.tan(math.radians(fov / 2))
    return Eye(size, focal, height, math.radians(pitch), aperture, focus)


def turned(yaw: float, pitch: float = 0.0, roll: float = 0.0) -> NDArray[np.float64]:
    """Rotation matrix Rz(yaw) Ry(pitch) Rx(roll), degrees."""
    rotation = np.eye(3)
    for axis, angle in ((2, yaw), (1, pitch), (0, roll)):
        turn = cv2.Rodrigues(np.eye(3)[axis] * math.radians(angle))[0]
        rotation = rotation @ turn
    return rotation
