"""Render the small scenes that reconstruction is tested on: tests/data/synthetic/<name>/.

Each holds input.jpg, ids.png (0, else the object's or support's `id`), truth.json and
case.yaml. Four scenes scatter a sphere, a box, a cylinder and an ellipsoid before a wall; one
has a ramp with a car on it, one a table with a cube on it. Run as `make_demo_image.py`.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from photoreal import meshes, textures
from photoreal.meshes import Mesh
from photoreal.shoot import Film, command, shoot
from photoreal.stage import Item, Lens, Room, panel, turn
from photoreal.textures import Surface

SIZE = (416, 240)
# Edges are rounded by less than half a pixel, so that the masks are those of the plain shapes.
EDGE = 0.0008
OUT = Path(__file__).resolve().parent.parent / "tests" / "data" / "synthetic"
COLOURS = {
    "red": (186, 38, 34),
    "blue": (40, 76, 150),
    "yellow": (222, 176, 48),
    "white": (225, 222, 214),
    "green": (52, 120, 66),
    "orange": (214, 110, 36),
    "purple": (104, 62, 128),
    "grey": (88, 90, 94),
}
FILM = Film((1.05, 1.0, 0.94), quality=92)
Rng = np.random.Generator


@dataclass(frozen=True)
class Scene:
    """A scene ready to be rendered."""

    lens: Lens
    wall: float
    items: list[Item]
    events: dict[str, str]


def paint(rng: Rng, colour: str) -> Surface:
    """Painted wood or plastic of a named colour."""
    gloss = float(rng.uniform(0.16, 0.55))
    return textures.plain(
        rng, (300, 450), (60, 60), COLOURS[colour], roughness=gloss, mottle=0.02, bump=4e-6
    )


def sphere(rng: Rng) -> tuple[Mesh, dict[str, Any], float]:
    """A ball: mesh, shape and the height of its centre."""
    radius = round(float(rng.uniform(0.032, 0.055)), 4)
    return meshes.sphere(radius), {"kind": "sphere", "radius": radius}, radius


def brick(rng: Rng) -> tuple[Mesh, dict[str, Any], float]:
    """A box with its longest side anywhere."""
    x, y, z = (round(float(v), 4) for v in rng.uniform(0.05, 0.12, 3))
    return meshes.box((x, y, z), EDGE), {"kind": "box", "size": [x, y, z]}, z / 2


def can(rng: Rng) -> tuple[Mesh, dict[str, Any], float]:
    """An upright cylinder."""
    radius = round(float(rng.uniform(0.026, 0.042)), 4)
    height = round(float(rng.uniform(0.07, 0.14)), 4)
    shape = {"kind": "cylinder", "radius": radius, "height": height}
    return meshes.cylinder(radius, height, EDGE), shape, height / 2


def egg(rng: Rng) -> tuple[Mesh, dict[str, Any], float]:
    """An ellipsoid lying on its flattest side."""
    radii = sorted((round(float(v), 4) for v in rng.uniform(0.028, 0.065, 3)), reverse=True)
    mesh = meshes.ellipsoid((radii[0], radii[1], radii[2]))
    return mesh, {"kind": "ellipsoid", "radii": radii}, radii[2]


KINDS: dict[str, Callable[[Rng], tuple[Mesh, dict[str, Any], float]]] = {
    "ball": sphere, "box": brick, "can": can, "egg": egg,
}  # fmt: skip


def lens_at(fov: float, height: float, pitch: float) -> Lens:
    """fov: vertical, degrees. height: metres above the floor. pitch: degrees downwards."""
    focal = SIZE[1] / 2 / math.tan(math.radians(fov / 2))
    return Lens(SIZE, focal, (0.0, 0.0, height), math.radians(pitch))


def bounds(lens: Lens, item: Item) -> NDArray[np.floating]:
    """Pixel bounds (x0, y0, x1, y1) of an item."""
    pixels = lens.project(item.mesh.posed(item.rotation, np.array(item.position)).points)
    return np.concatenate([pixels.min(0), pixels.max(0)])


def _overlap(a: NDArray[np.floating], b: NDArray[np.floating]) -> float:
    """Shared area of two pixel boxes as a part of the smaller one."""
    shared = np.prod(np.clip(np.minimum(a[2:], b[2:]) - np.maximum(a[:2], b[:2]), 0, None))
    return float(shared / min(np.prod(a[2:] - a[:2]), np.prod(b[2:] - b[:2])))


def _fits(lens: Lens, item: Item, others: list[Item], overlap: float) -> bool:
    box = bounds(lens, item)
    if (box[:2] < 6).any() or (box[2:] > np.array(SIZE) - 6).any():
        return False
    if (box[2:] - box[:2]).min() < 26:
        return False
    for other in others:
        reach = [np.hypot(*np.ptp(i.mesh.points[:, :2], axis=0)) / 2 for i in (item, other)]
        apart = math.dist(item.position[:2], other.position[:2]) - sum(reach)
        if apart < 0.01 or _overlap(box, bounds(lens, other)) > overlap:
            return False
    return True


def scattered(rng: Rng, kinds: list[str], overlap: float) -> Scene:
    """The given kinds of bodies at random places; pixel boxes share at most `overlap`."""
    fov, height, pitch = rng.uniform(36, 50), rng.uniform(0.24, 0.42), rng.uniform(14, 24)
    lens = lens_at(float(fov), round(float(height), 3), float(pitch))
    wall = round(float(rng.uniform(0.95, 1.5)), 3)
    names = rng.permutation(list(COLOURS))[: len(kinds)]
    items: list[Item] = []
    for number, (kind, colour) in enumerate(zip(kinds, names, strict=True), start=1):
        mesh, shape, centre = KINDS[kind](rng)
        truth = {
            "name": f"{colour}_{kind}", "id": number, "role": "object", "support": "floor",
            "material": "plastic", "colour": str(colour), "shape": shape,
        }  # fmt: skip
        surface = paint(rng, str(colour))
        for _ in range(2000):
            x, y, yaw = rng.uniform(-0.4, 0.4), rng.uniform(0.4, 0.9), rng.uniform(-1, 1)
            place = (round(float(x), 4), round(float(y), 4), centre)
            item = Item(mesh, surface, place, turn(round(float(yaw), 4)), truth)
            if _fits(lens, item, items, overlap):
                items.append(item)
                break
        else:
            raise RuntimeError(f"no free place for the {kind}; try another seed")
    first = str(items[0].truth["name"]).replace("_", " ") if items[0].truth else ""
    return Scene(lens, wall, items, {"rolls": f"The {first} is pushed to the right and stops."})


def _body(
    number: int, name: str, colour: str, support: str, shape: dict[str, Any]
) -> dict[str, Any]:
    return {
        "name": name, "id": number, "role": "object", "support": support, "material": "wood",
        "colour": colour, "shape": shape,
    }  # fmt: skip


def ramp(rng: Rng) -> Scene:
    """A wedge that climbs to the left with a box car on it and a block before its toe."""
    run, rise, width = 0.34, 0.15, 0.13
    toe, yaw = (0.07, 0.66, 0.0), math.radians(168)
    slope = math.atan2(rise, run)
    support = {
        "name": "ramp", "id": 3, "role": "support",
        "shape": {"kind": "ramp", "toe": list(toe), "yaw": yaw, "run": run, "rise": rise,
                  "width": width},
    }  # fmt: skip
    wedge = Item(meshes.wedge(run, rise, width), paint(rng, "white"), toe, turn(yaw), support)
    size = (0.075, 0.042, 0.032)
    tilt = turn(yaw, -slope)
    place = np.array(toe) + tilt @ np.array([0.26, 0.0, size[2] / 2])
    car = Item(
        meshes.box(size, EDGE),
        paint(rng, "red"),
        (float(place[0]), float(place[1]), float(place[2])),
        tilt,
        _body(1, "red_car", "red", "ramp", {"kind": "box", "size": list(size)}),
    )
    cube = (0.05, 0.05, 0.05)
    block = Item(
        meshes.box(cube, EDGE),
        paint(rng, "blue"),
        (0.24, 0.63, 0.025),
        turn(0.2),
        _body(2, "blue_block", "blue", "floor", {"kind": "box", "size": list(cube)}),
    )
    events = {"hits_block": "The red car rolls down the ramp and hits the blue block."}
    return Scene(lens_at(42, 0.30, 17), 1.15, [car, block, wedge], events)


def table(rng: Rng) -> Scene:
    """A solid table with a cube near its right edge, and a ball on the floor."""
    size = (0.36, 0.24, 0.13)
    centre, yaw = (-0.10, 0.74, size[2] / 2), math.radians(9)
    support = {
        "name": "table", "id": 3, "role": "support",
        "shape": {"kind": "box", "position": list(centre), "size": list(size), "yaw": yaw},
    }  # fmt: skip
    rotation = turn(yaw)
    wood, dark = textures.solid_wood(meshes.atlas_points(size, 300), rng)
    grain = Surface(wood, (0.45 + 0.1 * dark).astype(np.float32), -1e-5 * dark)
    top = Item(meshes.box(size, EDGE), grain, centre, rotation, support)
    side = 0.055
    place = np.array(centre) + rotation @ np.array([0.13, -0.02, size[2] / 2 + side / 2])
    cube = Item(
        meshes.cube(side, EDGE),
        paint(rng, "yellow"),
        (float(place[0]), float(place[1]), float(place[2])),
        turn(0.4),
        _body(1, "yellow_cube", "yellow", "table", {"kind": "box", "size": [side] * 3}),
    )
    ball = Item(
        meshes.sphere(0.045),
        paint(rng, "blue"),
        (0.26, 0.66, 0.045),
        turn(0),
        _body(2, "blue_ball", "blue", "floor", {"kind": "sphere", "radius": 0.045}),
    )
    events = {"pushed_off": "The yellow cube is pushed to the right and falls off the table."}
    return Scene(lens_at(45, 0.38, 19), 1.25, [cube, ball, top], events)


SCENES: dict[str, tuple[int, Callable[[Rng], Scene]]] = {
    "shapes_1": (11, lambda rng: scattered(rng, ["ball", "box"], 0.0)),
    "shapes_2": (12, lambda rng: scattered(rng, ["can", "egg"], 0.0)),
    "shapes_3": (13, lambda rng: scattered(rng, ["egg", "box", "can", "ball"], 0.02)),
    "shapes_4": (49, lambda rng: scattered(rng, ["ball", "can", "box", "egg"], 0.30)),
    "ramp": (15, ramp),
    "table": (16, table),
}


def surroundings(rng: Rng, wall: float) -> list[Item]:
    """A floor of boards, stone or cloth, and a plaster wall in a random pale tint."""
    size, thick = (2.4, wall + 0.5), 0.03
    cells = (round(size[1] / 0.001), round(size[0] / 0.001))
    kind = rng.choice(["boards", "stone", "cloth"])
    if kind == "boards":
        floor = textures.boards(
            rng, (size[1], size[0]), 0.001, board=float(rng.uniform(0.09, 0.16))
        )
    elif kind == "stone":
        floor = textures.plain(rng, cells, (90, 90), (150, 146, 140), roughness=0.5, mottle=0.05)
    else:
        floor = textures.plain(
            rng, cells, (40, 200), (196, 188, 172), roughness=0.9, mottle=0.03, bump=6e-5
        )
    grey = rng.uniform(188, 226)
    tint = tuple(float(grey + d) for d in rng.uniform(-5, 5, 3))
    plaster = textures.plaster(rng, (900, 1500), 0.0027, (tint[0], tint[1], tint[2]))
    back = panel((-1.75, wall, -0.03), (4.05, 0, 0), (0, 0, 2.0))
    return [
        Item(
            meshes.box((*size, thick), 0.003, planar=True),
            floor,
            (0, wall - size[1] / 2, -thick / 2),
        ),
        Item(back, plaster, gloss={"specular": 0.2}),
    ]


def write(name: str, folder: Path, samples: int) -> None:
    """Render one scene into `folder`/`name`."""
    seed, make = SCENES[name]
    rng = np.random.default_rng(seed)
    scene = make(rng)
    items = [*scene.items, *surroundings(rng, scene.wall)]
    low, high = (-1.75, -2.3, -0.031), (2.3, scene.wall, 1.9)
    room = Room(low, high, (float(rng.uniform(-0.1, 0.5)), 0.95), (0.95, 1.2))
    shoot(
        folder / name, items, scene.lens, room, FILM, scene.events,
        wall=scene.wall, samples=samples, seed=seed,
    )  # fmt: skip


if __name__ == "__main__":
    command("Render the synthetic scenes.", SCENES, OUT, 196, write)
