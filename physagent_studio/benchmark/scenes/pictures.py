"""`scene`: things of one place put together, drawn, and seen through a camera like a photograph."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from physagent_studio.arrays import BoolArray, FloatArray
from physagent_studio.benchmark.scenes.catalogue import Part, Thing, built, names_of, placed, turned
from physagent_studio.benchmark.scenes.lights import Lamp, lamps, shaded
from physagent_studio.benchmark.scenes.paints import painted
from physagent_studio.benchmark.scenes.rooms import PLACES, Room, room
from physagent_studio.program.scene.camera import Camera
from physagent_studio.program.scene.state import Click, Grounding
from physagent_studio.reconstruction.photo.colours import said_of
from physagent_studio.records.case import Image
from physagent_studio.rendering.raster import Lens, rasterise

SIZE = (640, 480)
LEAST = 1500
"""Pixels of a mask below which a thing is not asked for."""
RIM, SMALLER = 14, 0.9
"""Pixels to the picture's rim, and by how much a thing is scaled until it keeps away from it."""
STACKED = 0.1
"""Share of pictures that show a stack of things of one kind."""
WIDER = 0.04
"""By how much of its size a box drawn by hand is wider than the thing, on each side."""


@dataclass(frozen=True, eq=False, slots=True)
class Subject:
    """One thing of a picture: its name, what is visible of it (H, W), a click and a box on it.

    thing: what it is, in its place, metres.
    """

    name: str
    mask: BoolArray
    click: Grounding
    box: Grounding
    thing: Thing


@dataclass(frozen=True, eq=False, slots=True)
class Stage:
    """What a picture is taken of. asked: the things in place; others: those nobody asks for.

    chance: the state of the generator before the picture is taken.
    """

    camera: Camera
    asked: tuple[Thing, ...]
    others: tuple[Thing, ...]
    around: Room
    lights: tuple[Lamp, ...]
    chance: Mapping[str, Any]

    def taken_of(self, things: Sequence[Thing]) -> tuple[Image, NDArray[np.int64]]:
        """The picture of these things in this room and light, and whose each pixel is, or −1."""
        rng = np.random.default_rng()
        rng.bit_generator.state = self.chance
        seen = _looked_at(self.camera, things)
        light = _drawn(self.camera, things, seen, self.around, self.lights)
        return _photographed(rng, light, seen, self.around), seen.thing


@dataclass(frozen=True, eq=False, slots=True)
class Pictured:
    """A picture with the things in it that are asked for, and what it was taken of."""

    image: Image
    subjects: tuple[Subject, ...]
    stage: Stage

    def emptied(self) -> Image:
        """The same picture without the things that are asked for, and without their shadows."""
        return self.stage.taken_of(self.stage.others)[0]


@dataclass(frozen=True, eq=False, slots=True)
class _Seen:
    """What each pixel sees: number of the thing and of its part, −1 for neither; both (H, W).

    colour (K, 3), points (K, 3), normals (K, 3), gloss (K,): at the K flat pixels that see a part.
    """

    thing: NDArray[np.int64]
    part: NDArray[np.int64]
    pixel: NDArray[np.int64]
    colour: FloatArray
    points: FloatArray
    normals: FloatArray
    gloss: FloatArray


def scene(seed: int) -> Pictured:
    """The picture of a seed; the same bits each time."""
    rng = np.random.default_rng(seed)
    group = (
        "stacks"
        if rng.random() < STACKED
        else str(rng.choice([g for g in PLACES if g != "stacks"]))
    )
    camera = _camera(rng)
    asked = _stack(rng) if group == "stacks" else _asked(rng, camera, group)
    things = [*asked, *_others(rng, camera, group, asked)]
    seen = _looked_at(camera, things)
    colours = [part.paint.colour for thing in asked for part in thing.parts]
    around = room(rng, camera, group, colours)
    lights = lamps(rng)
    chance = rng.bit_generator.state
    image = _photographed(rng, _drawn(camera, things, seen, around, lights), seen, around)
    others = tuple(things[len(asked) :])
    stage = Stage(camera, tuple(asked), others, around, tuple(lights), chance)
    return Pictured(image, _subjects(rng, image, asked, seen), stage)


# --- who stands where --------------------------------------------------------------------------


def _camera(rng: np.random.Generator) -> Camera:
    focal = SIZE[1] / 2 / math.tan(math.radians(rng.uniform(15, 25)))
    pitch = math.radians(rng.uniform(8, 32))
    height = 0.35 + 3.0 * math.tan(pitch)
    roll = math.radians(rng.normal(0, 1.5))
    horizon = SIZE[1] / 2 - focal * math.tan(pitch)
    return Camera.from_horizon(SIZE, horizon, height, focal=focal, roll=roll)


def _asked(rng: np.random.Generator, camera: Camera, group: str) -> list[Thing]:
    """One to three things in the middle of the picture, hardly in front of one another."""
    count = int(rng.integers(1, 4))
    names = names_of(group)
    chosen = rng.choice(len(names), min(count, len(names)), replace=False)
    span = SIZE[0] / camera.focal * 3.0
    out: list[Thing] = []
    for k, number in enumerate(chosen):
        scale = float(rng.uniform(0.75, 1.2)) * span * (0.5, 0.4, 0.32)[count - 1]
        thing = placed(built(names[int(number)], rng), np.zeros(3), scale)
        across = (k - (count - 1) / 2 + rng.uniform(-0.15, 0.15)) * span * 0.85 / count
        at = np.array([across, 3.0 + rng.uniform(-0.35, 0.5), 0.0])
        while not _in_view(camera, placed(thing, at)):
            thing, at = placed(thing, np.zeros(3), SMALLER), at * (SMALLER, 1, 1)
        out.append(placed(thing, at))
    return out


def _in_view(camera: Camera, thing: Thing) -> bool:
    """Whether all of a thing is in the picture, some way from its rim."""
    pixels = camera.project(np.vstack([part.form.vertices for part in thing.parts]))[0]
    return bool((pixels > RIM).all() and (pixels < np.array(SIZE) - RIM).all())


def _stack(rng: np.random.Generator) -> list[Thing]:
    """Three or four things of one kind on one another, from the lowest up."""
    kind = str(rng.choice(names_of("stacks")))
    out: list[Thing] = []
    height, yaw = 0.0, float(rng.uniform(0, 3))
    for number in range(int(rng.integers(3, 5))):
        thing = built(kind, rng)
        thing = placed(thing, np.zeros(3), float(rng.uniform(0.8, 1.0)))
        thing = _faced(thing, yaw + float(rng.normal(0, 0.12)))
        by = np.array([rng.normal(0, 0.03), 3.0 + rng.normal(0, 0.03), height])
        thing = replace(placed(thing, by), name=f"{kind} {number + 1}")
        height = float(thing.bounds[1][2])
        out.append(thing)
    return out


def _faced(thing: Thing, yaw: float) -> Thing:
    """A thing on a stack turned so that its longest flat side has that direction."""
    points = np.vstack([part.form.vertices[:, :2] for part in thing.parts])
    spread = np.linalg.eigh(np.cov((points - points.mean(0)).T))[1][:, 1]
    return turned(thing, yaw - math.atan2(spread[1], spread[0]))


def _others(
    rng: np.random.Generator, camera: Camera, group: str, asked: Sequence[Thing]
) -> list[Thing]:
    """Things that nobody asks for, most of them behind, none through one that is asked for."""
    taken = [thing.bounds for thing in asked]
    out: list[Thing] = []
    for _ in range(int(rng.integers(2, 8))):
        name = str(rng.choice(names_of(group)))
        thing = placed(built(name, rng), np.zeros(3), float(rng.uniform(0.3, 0.9)))
        y = float(rng.uniform(3.3, 4.5) if rng.random() < 0.8 else rng.uniform(2.2, 2.8))
        thing = placed(
            thing, np.array([rng.uniform(-1, 1) * SIZE[0] / camera.focal * y * 0.55, y, 0])
        )
        low, high = thing.bounds
        if all((low > b + 0.03).any() or (high < a - 0.03).any() for a, b in taken):
            taken.append((low, high))
            out.append(thing)
    return out


# --- how it looks ------------------------------------------------------------------------------


def _mesh(parts: Sequence[Part]) -> tuple[FloatArray, NDArray[np.int32], NDArray[np.int64]]:
    """Vertices (V, 3) and faces (F, 3) of all parts, and the part (F,) of each face."""
    sizes = np.cumsum([0, *(len(part.form.vertices) for part in parts)])
    vertices = np.vstack([np.zeros((0, 3)), *(part.form.vertices for part in parts)])
    faces = [p.form.faces + s for p, s in zip(parts, sizes, strict=False)]
    faces = np.vstack([np.zeros((0, 3), np.int32), *faces])
    owner = np.repeat(np.arange(len(parts)), [len(part.form.faces) for part in parts])
    return vertices, faces.astype(np.int32), owner


def _looked_at(camera: Camera, things: Sequence[Thing]) -> _Seen:
    parts = [part for thing in things for part in thing.parts]
    vertices, faces, owner = _mesh(parts)
    own = (vertices - np.asarray(camera.position)) @ camera.matrix
    lens = Lens(*camera.size, camera.focal, *camera.principal)
    hits = rasterise(own, faces, lens, np.zeros(len(faces), bool))
    corners, weights = faces[hits.face], hits.weights[..., None]
    points = (vertices[corners] * weights).sum(1)
    normals = (_normals(vertices, faces)[corners] * weights).sum(1)
    normals /= np.maximum(np.linalg.norm(normals, axis=1, keepdims=True), 1e-9)
    # What is seen of an open form from within faces the camera all the same.
    away = ((points - np.asarray(camera.position)) * normals).sum(1) > 0
    normals[away] *= -1
    local = np.vstack([np.zeros((0, 3)), *(part.form.local for part in parts)])
    at = (local[corners] * weights).sum(1)
    number = owner[hits.face]
    colour = np.zeros((len(number), 3))
    for k in np.unique(number):
        colour[number == k] = painted(parts[int(k)].paint, at[number == k])
    gloss = np.array([part.paint.gloss for part in parts])[number]
    thing_of = np.repeat(np.arange(len(things)), [len(thing.parts) for thing in things])
    thing, part = (np.full(SIZE[0] * SIZE[1], -1) for _ in range(2))
    part[hits.pixel], thing[hits.pixel] = number, thing_of[number]
    shape = SIZE[::-1]
    return _Seen(
        thing.reshape(shape), part.reshape(shape), hits.pixel, colour, points, normals, gloss
    )


def _normals(vertices: FloatArray, faces: NDArray[np.int32]) -> FloatArray:
    """(V, 3) normals smooth over the faces at each vertex, longer for larger faces."""
    a, b, c = (vertices[faces[:, k]] for k in range(3))
    normal = np.cross(b - a, c - a)
    out = np.zeros_like(vertices)
    for k in range(3):
        np.add.at(out, faces[:, k], normal)
    return out / np.maximum(np.linalg.norm(out, axis=1, keepdims=True), 1e-12)


def _drawn(
    camera: Camera, things: Sequence[Thing], seen: _Seen, around: Room, lights: Sequence[Lamp]
) -> FloatArray:
    """(H, W, 3) the scene in its light, 0 … 255 and beyond."""
    flat = [field.reshape(-1, 3).copy() for field in (around.points, around.normals, around.colour)]
    for field, own in zip(flat, (seen.points, seen.normals, seen.colour), strict=True):
        field[seen.pixel] = own
    points, normals, colour = flat
    vertices, faces, _ = _mesh([part for thing in things for part in thing.parts])
    out = colour * shaded(list(lights), (points, normals), (vertices, faces))
    sun = np.mean([lamp.way for lamp in lights[:3]], axis=0)
    view = np.asarray(camera.position) - seen.points
    half = sun + view / np.linalg.norm(view, axis=1, keepdims=True)
    half /= np.linalg.norm(half, axis=1, keepdims=True)
    shine = np.clip((half * seen.normals).sum(1), 0, 1) ** 40 * seen.gloss
    out[seen.pixel] += 190 * shine[:, None]
    return out.reshape(*SIZE[::-1], 3)


def _photographed(rng: np.random.Generator, light: FloatArray, seen: _Seen, around: Room) -> Image:
    """As a camera keeps it: out of focus behind, a little soft, with noise, packed as JPEG."""
    light = light * rng.uniform(0.85, 1.15) * rng.uniform(0.94, 1.06, 3)
    if rng.random() < 0.4:
        far = (seen.thing < 0) & (around.points[..., 1] > 4.2)
        spread = float(rng.uniform(1.5, 4.0))
        share = cv2.GaussianBlur(far.astype(np.float64), (0, 0), 1.5)[..., None]
        light = light * (1 - share) + cv2.GaussianBlur(light, (0, 0), spread) * share
    rows, columns = np.indices(light.shape[:2])
    out_of_middle = np.hypot(rows - SIZE[1] / 2, columns - SIZE[0] / 2) / SIZE[0]
    light = light * (1 - 0.35 * out_of_middle**2)[..., None]
    soft = cv2.GaussianBlur(light, (0, 0), float(rng.uniform(0.55, 1.1)))
    # Light beyond white is rolled off rather than cut.
    soft = np.where(soft > 200, 255 - 55 * np.exp(-(soft - 200) / 55), soft)
    soft = soft + rng.normal(0, rng.uniform(1.5, 5.0), soft.shape)
    image = np.clip(soft, 0, 255).astype(np.uint8)
    quality = int(rng.integers(78, 95))
    _, packed = cv2.imencode(".jpg", image[..., ::-1], [cv2.IMWRITE_JPEG_QUALITY, quality])
    shown = cv2.imdecode(packed, cv2.IMREAD_COLOR)
    assert shown is not None
    return np.ascontiguousarray(shown[..., ::-1], np.uint8)


# --- what is asked -----------------------------------------------------------------------------


def _subjects(
    rng: np.random.Generator, image: Image, asked: Sequence[Thing], seen: _Seen
) -> tuple[Subject, ...]:
    out: list[Subject] = []
    for index, thing in enumerate(asked):
        mask = np.asarray(seen.thing == index)
        spot = _click(rng, mask, seen.part)
        if np.count_nonzero(mask) < LEAST or spot is None:
            continue
        name = thing.name
        if rng.random() < 0.25:
            clicked = mask & (seen.part == seen.part[int(spot.y), int(spot.x)])
            name = f"{said_of(image, clicked)} {name}"
        out.append(
            Subject(
                name.strip().replace(" ", "_"), mask, Grounding(points=(spot,)), boxed(mask), thing
            )
        )
    return tuple(out)


def _click(rng: np.random.Generator, mask: BoolArray, part: NDArray[np.int64]) -> Click | None:
    """A click near the middle of a mask (H, W), well inside of the part that is nearest to it."""
    if not mask.any():
        return None
    rows, columns = mask.nonzero()
    size = math.sqrt(len(rows))
    y, x = np.array([rows.mean(), columns.mean()]) + rng.normal(0, 0.1 * size, 2)
    near = int(np.hypot(rows - y, columns - x).argmin())
    own = mask & (part == part[rows[near], columns[near]])
    depth = cv2.distanceTransform(np.pad(own, 1).astype(np.uint8), cv2.DIST_L2, 5)[1:-1, 1:-1]
    inside = depth >= min(5.0, 0.6 * float(depth.max()))
    rows, columns = inside.nonzero()
    near = int(np.hypot(rows - y, columns - x).argmin())
    return Click(x=float(columns[near]), y=float(rows[near]))


def boxed(mask: BoolArray) -> Grounding:
    """A box as a hand draws it around a mask, a little wide."""
    rows, columns = mask.nonzero()
    pad_x, pad_y = WIDER * np.ptp(columns) + 1, WIDER * np.ptp(rows) + 1
    low = (float(columns.min() - pad_x), float(rows.min() - pad_y))
    high = (float(columns.max() + pad_x), float(rows.max() + pad_y))
    return Grounding(box=(*low, *high))
