"""A small path tracer for bodies given as signed distances. NumPy only; metres, linear RGB.

World +x right, +y away from the camera, +z up. A point array is (N, 3) float32. Spheres are traced
along rays after J. C. Hart, "Sphere tracing" (1996); light comes from flat lamps and the sky.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.floating]
Field = Callable[[Array], Array]
NEAR = np.float32(1.5e-4)
STEPS = 110
INDEX = np.float32(1.5)
# Additive recurrences of distinct irrationals spread the samples of one pixel evenly.
_STRIDES = np.sqrt(np.array([2, 3, 5, 7, 11, 13, 17, 19, 23, 29])) % 1


@dataclass(frozen=True)
class Finish:
    """How a surface looks. paint: body points → linear RGB (N, 3).

    shine: reflectance seen straight on. rough: spread of the reflection, 0 a mirror. metal: the
    paint is the colour of the reflection. clear: glass. relief: body points → height in metres,
    sampled `grain` metres apart.
    """

    paint: Field
    shine: float = 0.04
    rough: float = 0.4
    metal: bool = False
    clear: bool = False
    relief: Field | None = None
    grain: float = 4e-4


@dataclass(frozen=True)
class Part:
    """Body points → signed distance (N,), or None for all of the body's box."""

    distance: Field | None
    finish: Finish


@dataclass(frozen=True)
class Body:
    """Parts inside a box of half extents `half` about `position`. name: None for surroundings."""

    half: tuple[float, float, float]
    parts: tuple[Part, ...]
    position: tuple[float, float, float] = (0.0, 0.0, 0.0)
    rotation: NDArray[np.floating] = field(default_factory=lambda: np.eye(3))
    name: str | None = None

    @property
    def clear(self) -> bool:
        """Whether light passes through."""
        return self.parts[0].finish.clear

    def local(self, points: Array) -> Array:
        """World points in the body frame."""
        return self.turned(points - np.asarray(self.position, np.float32))

    def turned(self, ways: Array) -> Array:
        """World directions in the body frame."""
        return ways @ self.rotation.astype(np.float32)

    def distances(self, points: Array) -> Array:
        """(parts, N) signed distances at body points."""
        return np.stack([p.distance(points) for p in self.parts if p.distance is not None])


@dataclass(frozen=True)
class Lamp:
    """A parallelogram that shines on both sides: centre, half edges, radiance."""

    centre: tuple[float, float, float]
    along: tuple[float, float, float]
    up: tuple[float, float, float]
    radiance: tuple[float, float, float]


@dataclass(frozen=True)
class Eye:
    """A level camera `height` metres above the origin, pitched down by `pitch` radians.

    focal: pixels. aperture: radius of the lens, 0 is a pinhole. focus: distance, metres.
    """

    size: tuple[int, int]
    focal: float
    height: float
    pitch: float
    aperture: float = 0.0
    focus: float = 1.0

    def scaled(self, factor: float) -> Eye:
        """The same view on `factor` times as many columns and rows."""
        size = (round(self.size[0] * factor), round(self.size[1] * factor))
        return replace(self, size=size, focal=self.focal * factor)

    def rays(self, pixels: Array, lens: Array) -> tuple[Array, Array]:
        """Origins and unit directions through pixels (N, 2) and points (N, 2) of a unit lens."""
        sin, cos = np.sin(self.pitch), np.cos(self.pitch)
        axes = np.array([[1, 0, 0], [0, -sin, -cos], [0, cos, -sin]], np.float32)
        flat = (pixels - np.asarray(self.size) / 2) / self.focal
        aim = np.column_stack([flat, np.ones(len(flat))]) * self.focus
        start = np.column_stack([lens * self.aperture, np.zeros(len(flat))])
        way = (aim - start).astype(np.float32) @ axes
        way /= np.linalg.norm(way, axis=1, keepdims=True)
        origin = start.astype(np.float32) @ axes + np.array([0, 0, self.height], np.float32)
        return origin, way


@dataclass(frozen=True)
class World:
    """Everything that is seen. sky: unit directions (N, 3) → radiance (N, 3)."""

    bodies: Sequence[Body]
    lamps: Sequence[Lamp]
    sky: Field


def _span(body: Body, origin: Array, way: Array) -> tuple[Array, Array]:
    """Where rays in the body frame enter and leave its box."""
    half = np.asarray(body.half, np.float32)
    inverse = 1 / np.where(np.abs(way) < 1e-9, np.float32(1e-9), way)
    middle, reach = -origin * inverse, half * np.abs(inverse)
    near, far = (middle - reach).T, (middle + reach).T
    # Pairs are far quicker than a reduction over an axis of three.
    return (
        np.maximum(np.maximum(near[0], near[1]), near[2]),
        np.minimum(np.minimum(far[0], far[1]), far[2]),
    )


def _march(body: Body, origin: Array, way: Array, near: Array, far: Array, sign: int) -> Array:
    """Distance along each ray to the surface, infinite where it is missed."""
    found = np.full(len(origin), np.inf, np.float32)
    index, t = np.arange(len(origin)), near.copy()
    for _ in range(STEPS):
        if not index.size:
            break
        gap = sign * body.distances(origin[index] + t[:, None] * way[index]).min(0)
        met = gap < NEAR
        found[index[met]] = t[met]
        t = t + np.maximum(gap, NEAR) * np.float32(0.9)
        going = ~met & (t < far[index])
        index, t = index[going], t[going]
    return found


def _reach(body: Body, origin: Array, way: Array, limit: Array, inside: NDArray[np.bool_]) -> Array:
    """Distance to one body for world rays, infinite beyond `limit`. inside: rays within glass."""
    start, aim = body.local(origin), body.turned(way)
    near, far = _span(body, start, aim)
    found = np.full(len(origin), np.inf, np.float32)
    if body.parts[0].distance is None:
        found = np.where((near > NEAR) & (near < far), near, found)
    else:
        crossed = (far > np.maximum(near, 0)) & (near < limit)
        for state in (False, True) if body.clear else (False,):
            k = np.flatnonzero(crossed & (inside == state))
            begin = np.maximum(near[k], 0)
            found[k] = _march(body, start[k], aim[k], begin, far[k] + 0.01, -1 if state else 1)
    return np.where(found < limit, found, np.float32(np.inf))


def first(
    world: World, origin: Array, way: Array, inside: NDArray[np.bool_]
) -> tuple[Array, NDArray[np.intp]]:
    """Distance to the first body on each ray and its number, -1 for the sky."""
    best = np.full(len(origin), np.inf, np.float32)
    which = np.full(len(origin), -1)
    for number, body in enumerate(world.bodies):
        reach = _reach(body, origin, way, best, inside)
        which[reach < best] = number
        best = np.minimum(best, reach)
    return best, which


def _open(world: World, origin: Array, way: Array, limit: Array) -> Array:
    """How much light passes along each ray: 0 behind a body, 0.75 through glass."""
    passed = np.ones(len(origin), np.float32)
    outside = np.zeros(len(origin), bool)
    for body in world.bodies:
        k = np.flatnonzero(passed > 0)
        blocked = np.isfinite(_reach(body, origin[k], way[k], limit[k], outside[k]))
        passed[k[blocked]] *= 0.75 if body.clear else 0.0
    return passed


def _gradient(function: Field, points: Array, step: float) -> Array:
    columns = []
    for axis in range(3):
        shift = np.zeros(3, np.float32)
        shift[axis] = step
        columns.append((function(points + shift) - function(points - shift)) / (2 * step))
    return np.stack(columns, 1)


def _normals(body: Body, part: Part, points: Array) -> Array:
    """Outward unit normals at body points; boxes get a bevel of two millimetres."""
    if part.distance is None:
        half = np.asarray(body.half, np.float32)
        depth = np.clip((np.abs(points) - half) / 0.002 + 1, 0, 1)
        normal = np.sign(points) * depth**2
    else:
        normal = _gradient(part.distance, points, 2e-4)
    if part.finish.relief is not None:
        slope = _gradient(part.finish.relief, points, part.finish.grain)
        along = (slope * normal).sum(1, keepdims=True) * normal
        normal = normal - (slope - along)
    return normal / np.maximum(np.linalg.norm(normal, axis=1, keepdims=True), 1e-9)


@dataclass(frozen=True)
class _Surface:
    """What rays met: normals and colours (N, 3), the rest (N,)."""

    normal: Array
    colour: Array
    shine: Array
    rough: Array
    metal: NDArray[np.bool_]
    clear: NDArray[np.bool_]


def _surface(world: World, points: Array, which: NDArray[np.intp]) -> _Surface:
    normal, colour = np.zeros_like(points), np.zeros_like(points)
    shine, rough = np.zeros(len(points), np.float32), np.zeros(len(points), np.float32)
    metal, clear = np.zeros(len(points), bool), np.zeros(len(points), bool)
    for number in np.unique(which):
        body, k = world.bodies[number], np.flatnonzero(which == number)
        place = body.local(points[k])
        flat = body.parts[0].distance is None
        owner = np.zeros(len(k), int) if flat else body.distances(place).argmin(0)
        for index, part in enumerate(body.parts):
            own, look = owner == index, part.finish
            if not own.any():
                continue
            at = k[own]
            normal[at] = _normals(body, part, place[own]) @ body.rotation.T.astype(np.float32)
            colour[at] = look.paint(place[own])
            shine[at], rough[at], metal[at] = look.shine, look.rough, look.metal
            clear[at] = look.clear
    return _Surface(normal, colour, shine, rough, metal, clear)


def _dot(a: Array, b: Array) -> Array:
    return np.einsum("ij,ij->i", a, b)


def _lit(world: World, points: Array, normal: Array, dice: Array) -> Array:
    """Light of the lamps that falls on points, divided by π. dice: (N, 2) in [0, 1)."""
    total = np.zeros_like(points)
    for lamp in world.lamps:
        along, up = (np.asarray(v, np.float32) for v in (lamp.along, lamp.up))
        spot = dice * 2 - 1
        to = np.asarray(lamp.centre, np.float32) + spot[:, :1] * along + spot[:, 1:] * up - points
        far = np.linalg.norm(to, axis=1)
        to /= far[:, None]
        area = 4 * np.cross(along, up)
        weight = np.maximum(_dot(to, normal), 0) * np.abs(to @ area) / (far**2 * np.pi)
        k = np.flatnonzero(weight > 1e-7)
        weight[k] *= _open(world, points[k] + normal[k] * 6 * NEAR, to[k], far[k])
        total += weight[:, None] * np.asarray(lamp.radiance, np.float32)
    return total


def _beyond(world: World, origin: Array, way: Array, mirrored: NDArray[np.bool_]) -> Array:
    """Light from the sky, and on mirrored paths from the lamps as well."""
    light = world.sky(way).astype(np.float32)
    for lamp in world.lamps:
        along, up = (np.asarray(v, np.float32) for v in (lamp.along, lamp.up))
        face = np.cross(along, up)
        span = way @ face
        away = (np.asarray(lamp.centre, np.float32) - origin) @ face
        t = away / np.where(np.abs(span) < 1e-9, np.float32(1e-9), span)
        spot = origin + t[:, None] * way - np.asarray(lamp.centre, np.float32)
        inside = (np.abs(spot @ along) < along @ along) & (np.abs(spot @ up) < up @ up)
        light[mirrored & (t > 0) & inside] = np.asarray(lamp.radiance, np.float32)
    return light


def _scattered(normal: Array, dice: Array) -> Array:
    """Directions about normals, in proportion to the cosine."""
    z, angle = 1 - 2 * dice[:, 0], 2 * np.pi * dice[:, 1]
    ring = np.sqrt(np.maximum(1 - z * z, 0))
    way = normal + np.stack([ring * np.cos(angle), ring * np.sin(angle), z], 1).astype(np.float32)
    return way / np.maximum(np.linalg.norm(way, axis=1, keepdims=True), 1e-6)


def _mirrored(way: Array, normal: Array, rough: Array, dice: Array) -> Array:
    """Reflections, spread by the square of the roughness."""
    straight = way - 2 * _dot(way, normal)[:, None] * normal
    ball = _scattered(np.zeros_like(way), dice)
    spread = straight + (rough**2)[:, None] * ball * np.sqrt(dice[:, 1:])
    return spread / np.linalg.norm(spread, axis=1, keepdims=True)


def _through(way: Array, normal: Array, inside: NDArray[np.bool_]) -> tuple[Array, Array]:
    """Refracted directions at glass and the part of the light that is reflected instead."""
    ratio = np.where(inside, INDEX, 1 / INDEX)
    cosine = np.clip(-_dot(way, normal), 0, 1)
    rest = 1 - ratio**2 * (1 - cosine**2)
    bent = ratio[:, None] * way + (ratio * cosine - np.sqrt(np.maximum(rest, 0)))[:, None] * normal
    part = 0.04 + 0.96 * (1 - np.where(inside, np.sqrt(np.maximum(rest, 0)), cosine)) ** 5
    return bent.astype(np.float32), np.where(rest <= 0, 1.0, part).astype(np.float32)


def _paths(
    world: World, origin: Array, way: Array, dice: Array, rng: np.random.Generator, depth: int
) -> Array:
    """Radiance (N, 3) along rays. dice: (N, 6), the first surface's share of chance."""
    light, weight = np.zeros_like(origin), np.ones_like(origin)
    live, inside = np.arange(len(origin)), np.zeros(len(origin), bool)
    mirrored, spent = np.ones(len(origin), bool), np.zeros(len(origin), int)
    for bounce in range(depth + 5):
        t, which = first(world, origin, way, inside)
        lost = which < 0
        out = _beyond(world, origin[lost], way[lost], mirrored[lost])
        light[live[lost]] += weight[lost] * out
        k = np.flatnonzero(~lost & (spent < depth))
        if not k.size:
            break
        live, weight, way, inside = live[k], weight[k], way[k], inside[k]
        mirrored, spent, which = mirrored[k], spent[k], which[k]
        point = origin[k] + t[k, None] * way
        roll = dice[live] if bounce == 0 else rng.random((len(k), 6), np.float32)
        seen = _surface(world, point, which)
        facing = _dot(seen.normal, way) < 0
        normal = np.where(facing[:, None], seen.normal, -seen.normal)
        bent, part = _through(way, normal, inside)
        edge = np.clip(1 + _dot(way, normal), 0, 1) ** 5
        fresnel = seen.shine + (np.maximum(1 - seen.rough, seen.shine) - seen.shine) * edge
        solid = np.flatnonzero(~seen.clear & ~seen.metal)
        share = np.zeros_like(weight)
        share[solid] = seen.colour[solid] * (1 - fresnel[solid, None])
        glow = _lit(world, point[solid], normal[solid], roll[solid, :2])
        light[live[solid]] += weight[solid] * share[solid] * glow
        # One way onward by chance, weighted so that the mean stays what it is.
        chance = np.where(seen.metal, 1, np.clip(3 * fresnel, 0, 0.6))
        chance = np.where(seen.clear, part, chance).astype(np.float32)
        shiny = roll[:, 2] < chance
        gain = np.where(seen.metal[:, None], seen.colour, (fresnel / chance)[:, None])
        rest = share / np.maximum(1 - chance, 1e-3)[:, None]
        weight = weight * np.where(seen.clear[:, None], 1, np.where(shiny[:, None], gain, rest))
        back = _mirrored(way, normal, seen.rough, roll[:, 3:5])
        on = np.where(seen.clear[:, None], bent, _scattered(normal, roll[:, 3:5]))
        way = np.where(shiny[:, None], back, on).astype(np.float32)
        crossing = seen.clear & ~shiny
        inside = inside ^ crossing
        # A dull reflection rarely finds a lamp, and then it is a speck of dust.
        mirrored = mirrored & (shiny & (seen.rough < 0.45) | seen.clear)
        spent = spent + ~seen.clear
        origin = point + normal * np.where(crossing, -6, 6)[:, None].astype(np.float32) * NEAR
    return light


def radiance(world: World, eye: Eye, *, samples: int, seed: int, depth: int = 3) -> Array:
    """Linear RGB (H, W, 3). samples: paths per pixel. depth: bounces off what is not glass."""
    width, height = eye.size
    rng = np.random.default_rng(seed)
    corner = np.stack(np.meshgrid(np.arange(width), np.arange(height)), -1).reshape(-1, 2)
    offset = rng.random((len(corner), len(_STRIDES)), np.float32)
    total = np.zeros((len(corner), 3), np.float32)
    for k in range(samples):
        dice = ((offset + k * _STRIDES) % 1).astype(np.float32)
        turn, radius = 2 * np.pi * dice[:, 2], np.sqrt(dice[:, 3])
        lens = np.stack([radius * np.cos(turn), radius * np.sin(turn)], 1)
        origin, way = eye.rays(corner + dice[:, :2], lens)
        # A lid on single paths: what is left of lone bright ones would look like dust.
        total += np.minimum(_paths(world, origin, way, dice[:, 4:], rng, depth), 4)
    return (total / samples).reshape(height, width, 3)


def identities(world: World, eye: Eye) -> NDArray[np.intp]:
    """(H, W) number of the body that most of each pixel shows through a pinhole, -1 the sky."""
    width, height = eye.size
    corner = np.stack(np.meshgrid(np.arange(width), np.arange(height)), -1).reshape(-1, 2)
    votes = []
    for shift in ((0.17, 0.33), (0.83, 0.17), (0.5, 0.5), (0.17, 0.83), (0.83, 0.67)):
        origin, way = eye.rays((corner + shift).astype(np.float32), np.zeros(corner.shape))
        votes.append(first(world, origin, way, np.zeros(len(corner), bool))[1])
    counts = [(np.stack(votes) == n).sum(0) for n in range(-1, len(world.bodies))]
    return np.argmax(counts, axis=0).reshape(height, width) - 1
