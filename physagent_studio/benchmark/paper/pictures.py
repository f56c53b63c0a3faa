"""Pictures of the scenes of `scenes.yaml`: the things put together, drawn, clicked and boxed."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import yaml
from numpy.typing import NDArray

from physagent_studio.arrays import BoolArray, FloatArray
from physagent_studio.benchmark.scenes.catalogue import (
    Thing,
    built,
    listed,
    placed,
    reshaped,
    turned,
)
from physagent_studio.benchmark.scenes.lights import lamps
from physagent_studio.benchmark.scenes.pictures import SIZE, Stage
from physagent_studio.benchmark.scenes.rooms import room
from physagent_studio.program.scene.camera import Camera
from physagent_studio.records import Image

SCENES = Path(__file__).with_name("scenes.yaml")
FIRST_SEED = 3000
"""Seed of the first picture; those from 2000 on are for measuring alone."""
PITCH = (11.0, 20.0)
"""Degrees between which the camera looks down: as one who stands or sits before the things."""
HALF_VIEW = 21.0
"""Degrees from the middle of the picture to its upper rim."""
AWAY, MIDDLE = 3.0, 0.35
"""Where things stand and how high the camera looks there, units."""
INNER = 0.7
"""Part of the greatest depth inside a mask from which on a place is well inside of it."""
WIDER = 0.04
"""By how much of its size a box drawn by hand is wider than the thing, on each side."""


@dataclass(frozen=True, eq=False, slots=True)
class Prop:
    """One thing of a scene. said: its row. size: x, y, z before it was turned; units."""

    name: str
    said: Mapping[str, Any]
    thing: Thing
    size: FloatArray

    @property
    def asked(self) -> bool:
        """Whether it is an object of the case."""
        return not {"support", "landmark"} & set(self.said) and self.said.get("asked", True)


@dataclass(frozen=True, eq=False, slots=True)
class Taken:
    """A picture (H, W, 3) and the mask (H, W) of what is seen of each prop, by name."""

    image: Image
    masks: Mapping[str, BoolArray]
    props: tuple[Prop, ...]
    camera: Camera


@cache
def said_of_scenes() -> Mapping[str, Any]:
    """What `scenes.yaml` says."""
    return yaml.safe_load(SCENES.read_text(encoding="utf-8"))


def seed_of(scene: str) -> int:
    """The seed of a scene's picture."""
    return FIRST_SEED + list(said_of_scenes()["scenes"]).index(scene)


def taken(scene: str) -> Taken:
    """The picture of a scene; the same bits each time."""
    rng = np.random.default_rng(seed_of(scene))
    said = said_of_scenes()["scenes"][scene]
    camera = _camera(rng)
    props = props_of(scene, rng)
    things = tuple(prop.thing for prop in props)
    colours = [part.paint.colour for thing in things for part in thing.parts]
    around = room(rng, camera, said["room"], colours)
    lights = tuple(lamps(rng))
    stage = Stage(camera, things, (), around, lights, rng.bit_generator.state)
    image, owner = stage.taken_of(things)
    masks = {prop.name: np.asarray(owner == k) for k, prop in enumerate(props)}
    return Taken(image, masks, props, camera)


def _camera(rng: np.random.Generator) -> Camera:
    focal = SIZE[1] / 2 / math.tan(math.radians(HALF_VIEW))
    pitch = math.radians(float(rng.uniform(*PITCH)))
    height = MIDDLE + AWAY * math.tan(pitch)
    horizon = SIZE[1] / 2 - focal * math.tan(pitch)
    return Camera.from_horizon(SIZE, horizon, height, focal=focal)


def props_of(scene: str, rng: np.random.Generator) -> tuple[Prop, ...]:
    """The things of a scene in their places."""
    props: dict[str, Prop] = {}
    for name, said in said_of_scenes()["scenes"][scene]["things"].items():
        made = _scaled(_plain(said, rng), said["size"])
        size = made.bounds[1] - made.bounds[0]
        made = turned(made, math.radians(said.get("turn", 0.0)))
        props[name] = Prop(name, said, _stood(made, said, props), size)
    return tuple(props.values())


def _plain(said: Mapping[str, Any], rng: np.random.Generator) -> Thing:
    """The thing of a row, its foot in the origin, its largest side one."""
    every = said_of_scenes()
    row = dict(every["kinds"].get(said["kind"]) or listed()[said["kind"]])
    paints = dict(zip(("a", "b", "trunk"), said.get("paint", ()), strict=False))
    roles = {"steel": "steel"} | dict(row.get("colours", {})) | paints | said.get("colours", {})
    row["colours"] = {role: every["colours"].get(kind, kind) for role, kind in roles.items()}
    return built(said["kind"], rng, row, exact=True)


def _scaled(thing: Thing, size: float | Sequence[float]) -> Thing:
    """Scaled so that its largest side is `size`, or its sides are those."""
    low, high = thing.bounds
    factor = np.asarray(size, float) / (high - low if isinstance(size, Sequence) else 1.0)
    return reshaped(thing, lambda points: points * factor)


def _stood(thing: Thing, said: Mapping[str, Any], props: Mapping[str, Prop]) -> Thing:
    """The thing where its row has it: on the ground, on another, on a slope or in the air."""
    x, y = said["at"]
    up = float(said.get("up", 0.0))
    if "upon" in said:
        up = float(props[said["upon"]].thing.bounds[1][2])
    if "slope" in said:
        low, high = props[said["slope"]].thing.bounds
        wide, _, tall = high - low
        up, lean = tall * (high[0] - x) / wide, math.atan2(tall, wide)
        cos, sin = math.cos(lean), math.sin(lean)
        about_y = np.array([[cos, 0, sin], [0, 1, 0], [-sin, 0, cos]])
        thing = reshaped(thing, lambda points: points @ about_y.T)
    return placed(thing, np.array([x, y, up]))


# --- clicks ------------------------------------------------------------------------------------


def click_on(mask: BoolArray) -> tuple[int, int]:
    """The pixel (x, y) nearest to the middle of a mask (H, W) of those well inside it."""
    depth = cv2.distanceTransform(np.pad(mask, 1).astype(np.uint8), cv2.DIST_L2, 5)[1:-1, 1:-1]
    rows, columns = mask.nonzero()
    inner, across = (depth >= INNER * depth.max()).nonzero()
    near = int(np.hypot(inner - rows.mean(), across - columns.mean()).argmin())
    return int(across[near]), int(inner[near])


def box_around(mask: BoolArray) -> list[float]:
    """Left, top, right, bottom of a box as a hand draws it around a mask, a little wide."""
    rows, columns = mask.nonzero()
    low = np.array([columns.min(), rows.min()], float)
    high = np.array([columns.max() + 1, rows.max() + 1], float)
    pad = WIDER * (high - low) + 1
    low, high = np.maximum(low - pad, 0), np.minimum(high + pad, mask.shape[::-1])
    return [round(float(value), 1) for value in (*low, *high)]


def ends_of(camera: Camera, prop: Prop) -> NDArray[np.float64]:
    """(2, 2) pixels of the two ends of a line on the ground."""
    low, high = prop.thing.bounds
    middle = (low + high) / 2
    along = np.array([0, 1, 0]) if high[1] - low[1] > high[0] - low[0] else np.array([1, 0, 0])
    half = (high - low) / 2 * along
    return camera.project(np.array([middle - half, middle + half]))[0]
