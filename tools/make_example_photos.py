"""Render the further bundled examples: assets/<name>/{input.jpg, ids.png, case.yaml, truth.json}.

`ramp`: an orange ball at the top of a wooden ramp, and a blue can below, by a grey morning window.
`table`: a yellow cube near the edge of a low wooden table and a white ball on the carpet, in the
afternoon. `cans`: a yellow ball and two cans. Run as `make_demo_image.py`.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import yaml
from photoreal import meshes, textures
from photoreal.shoot import Film, command, shoot
from photoreal.stage import Item, Lens, Room, panel, turn
from photoreal.textures import Surface

SIZE = (832, 480)
OUT = Path(__file__).resolve().parent.parent / "assets"
Rng = np.random.Generator
Colour = tuple[float, float, float]


@dataclass(frozen=True)
class Photo:
    """A scene ready to be rendered."""

    lens: Lens
    wall: float
    items: list[Item]
    floor: Surface
    tint: Colour
    room: Room
    film: Film
    events: dict[str, str]


def lens_at(fov: float, height: float, pitch: float, focus: float) -> Lens:
    """fov: vertical, degrees. height: metres above the floor. pitch: degrees downwards."""
    focal = SIZE[1] / 2 / math.tan(math.radians(fov / 2))
    return Lens(SIZE, focal, (0.0, 0.0, height), math.radians(pitch), 0.0016, focus)


def body(
    number: int, name: str, support: str, material: str, shape: dict[str, Any]
) -> dict[str, Any]:
    """An object's entry in the truth file; its colour is the first word of its name."""
    return {
        "name": name, "id": number, "role": "object", "support": support, "material": material,
        "colour": name.partition("_")[0], "shape": shape,
    }  # fmt: skip


def wood(rng: Rng, size: tuple[float, float, float], light: Colour, dark: Colour) -> Surface:
    """Solid wood for a box of that size."""
    colour, depth = textures.solid_wood(
        meshes.atlas_points(size, 520), rng, light=light, dark=dark, ring=0.009
    )
    return Surface(colour, (0.42 + 0.1 * depth).astype(np.float32), -2e-5 * depth)


def painted(rng: Rng, tint: Colour, gloss: float) -> Surface:
    """Paint, plastic or rubber with a little unevenness."""
    return textures.plain(
        rng, (700, 1400), (130, 130), tint, roughness=gloss, mottle=0.03, bump=8e-6
    )


def ramp(rng: Rng) -> Photo:
    """A plywood ramp that climbs to the left, a ball near its top, a can before its toe."""
    run, rise, width = 0.40, 0.17, 0.15
    toe, yaw = (0.05, 0.70, 0.0), math.radians(170)
    support = {
        "name": "ramp", "id": 3, "role": "support",
        "shape": {"kind": "ramp", "toe": list(toe), "yaw": yaw, "run": run, "rise": rise,
                  "width": width},
    }  # fmt: skip
    plywood = textures.boards(
        rng, (run * 1.2, width * 1.3), 0.0004, board=0.4, light=(222, 190, 146), dark=(168, 120, 74)
    )
    wedge = Item(meshes.wedge(run, rise, width), plywood, toe, turn(yaw), support)
    radius = 0.036
    tilt = turn(yaw, -math.atan2(rise, run))
    place = np.array(toe) + tilt @ np.array([0.34, 0.0, radius])
    ball = Item(
        meshes.sphere(radius),
        painted(rng, (226, 108, 28), 0.34),
        (float(place[0]), float(place[1]), float(place[2])),
        turn(0.4),
        body(1, "orange_ball", "ramp", "rubber", {"kind": "sphere", "radius": radius}),
    )
    tall, wide = 0.115, 0.031
    can = Item(
        meshes.cylinder(wide, tall, 0.002),
        painted(rng, (38, 84, 158), 0.24),
        (0.27, 0.655, tall / 2),
        turn(0.2),
        body(2, "blue_can", "floor", "plastic",
             {"kind": "cylinder", "radius": wide, "height": tall}),
        {"specular": 0.6},
    )  # fmt: skip
    stone = textures.plain(
        rng, (1700, 2400), (150, 150), (158, 154, 148), roughness=0.42, mottle=0.06, bump=1e-5
    )
    events = {
        "hits_can": "The orange ball rolls down the ramp and hits the blue can.",
        "stops_before_can": "The orange ball rolls down the ramp and stops before it reaches the "
        "blue can.",
    }
    room = Room((-1.8, -2.3, -0.04), (2.3, 1.25, 2.0), (0.15, 0.95), (1.1, 1.25), (12, 12.6, 13.4))
    lens = lens_at(40, 0.31, 16, 0.72)
    return Photo(
        lens, 1.25, [ball, can, wedge], stone, (196, 204, 206), room, Film((1.0, 1.0, 0.99)), events
    )


def table(rng: Rng) -> Photo:
    """A low solid table with a cube near its right edge, and a ball on the carpet beside it."""
    size = (0.42, 0.26, 0.16)
    centre, yaw = (-0.12, 0.80, size[2] / 2), math.radians(8)
    support = {
        "name": "table", "id": 3, "role": "support",
        "shape": {"kind": "box", "position": list(centre), "size": list(size), "yaw": yaw},
    }  # fmt: skip
    rotation = turn(yaw)
    top = Item(
        meshes.box(size, 0.002), wood(rng, size, (150, 96, 58), (74, 42, 24)), centre, rotation,
        support,
    )  # fmt: skip
    side = 0.062
    place = np.array(centre) + rotation @ np.array([0.10, -0.02, (size[2] + side) / 2])
    cube = Item(
        meshes.cube(side, 0.003),
        painted(rng, (230, 182, 40), 0.36),
        (float(place[0]), float(place[1]), float(place[2])),
        turn(0.42),
        body(1, "yellow_cube", "table", "wood", {"kind": "box", "size": [side] * 3}),
    )
    ball = Item(
        meshes.sphere(0.047),
        painted(rng, (226, 222, 212), 0.30),
        (0.34, 0.74, 0.047),
        turn(0.1),
        body(2, "white_ball", "floor", "plastic", {"kind": "sphere", "radius": 0.047}),
    )
    carpet = textures.plain(
        rng, (1700, 2400), (9, 60), (112, 122, 104), roughness=0.95, mottle=0.07, bump=1.6e-4
    )
    events = {
        "falls_off": "The yellow cube is pushed to the right and falls off the table.",
        "stays_on_table": "The yellow cube slides to the right and stops before the edge of the "
        "table, without falling.",
    }
    room = Room((-1.7, -2.3, -0.04), (2.3, 1.35, 2.0), (0.40, 1.0), (0.9, 1.2), (15, 12.6, 9.4))
    lens = lens_at(44, 0.40, 18, 0.82)
    return Photo(
        lens, 1.35, [cube, ball, top], carpet, (214, 202, 184), room, Film((1.0, 1.0, 1.06)), events
    )


def cans(rng: Rng) -> Photo:
    """A yellow ball and two cans on a pale board, in the light of a cloudy noon."""

    def can(number: int, name: str, tint: Colour, place: tuple[float, float]) -> Item:
        tall, wide = 0.120, 0.030
        shape = {"kind": "cylinder", "radius": wide, "height": tall}
        item = body(number, name, "floor", "plastic", shape)
        mesh = meshes.cylinder(wide, tall, 0.002)
        return Item(
            mesh, painted(rng, tint, 0.26), (*place, tall / 2), turn(0.3 * number), item,
            {"specular": 0.6},
        )  # fmt: skip

    radius = 0.046
    ball = Item(
        meshes.sphere(radius),
        painted(rng, (228, 176, 30), 0.3),
        (-0.25, 0.62, radius),
        turn(0.3),
        body(1, "yellow_ball", "floor", "rubber", {"kind": "sphere", "radius": radius}),
    )
    items = [
        ball,
        can(2, "red_can", (178, 34, 36), (0.13, 0.70)),
        can(3, "blue_can", (36, 78, 150), (0.255, 0.655)),
    ]
    maple = textures.boards(
        rng, (1.9, 3.4), 0.0009, board=0.085, light=(226, 200, 162), dark=(176, 136, 94)
    )
    events = {
        "knocks_red_over": "The yellow ball rolls to the right and knocks over the red can.",
        "only_blue": "The yellow ball rolls to the right, passes the red can without touching it "
        "and hits the blue can.",
    }
    room = Room((-1.8, -2.3, -0.04), (2.3, 1.25, 2.0), (0.25, 0.95), (1.1, 1.25), (12, 12.4, 12.9))
    lens = lens_at(41, 0.33, 18, 0.68)
    return Photo(
        lens, 1.25, items, maple, (188, 204, 198), room, Film((1.0, 1.0, 0.98), 0.40), events
    )


PHOTOS: dict[str, tuple[int, Callable[[Rng], Photo]]] = {
    "ramp": (31, ramp),
    "table": (32, table),
    "cans": (33, cans),
}


def surroundings(rng: Rng, photo: Photo) -> list[Item]:
    """The ground and the wall behind."""
    size, thick = (3.4, photo.wall + 0.6), 0.03
    ground = meshes.box((*size, thick), 0.003, planar=True)
    plaster = textures.plaster(rng, (1500, 3000), 0.0014, photo.tint)
    back = panel((-1.8, photo.wall, -0.03), (4.1, 0, 0), (0, 0, 2.05))
    return [
        Item(ground, photo.floor, (0, photo.wall - size[1] / 2, -thick / 2)),
        Item(back, plaster, gloss={"specular": 0.2}),
    ]


def parts_of(item: Item, lens: Lens) -> dict[str, list[Any]]:
    """Where a person would click on the parts of a support, as in docs/case-format.md."""
    assert item.truth is not None
    shape = item.truth["shape"]
    half = np.array([shape.get("width", 0.0), *shape.get("size", ())]) / 2
    if shape["kind"] == "ramp":
        ends = {"toe": (0.0, 0.0), "top": (shape["run"], shape["rise"]), "foot": (shape["run"], 0)}
        body = {name: [(x, side * half[0], z) for side in (-1, 1)] for name, (x, z) in ends.items()}
    else:
        _, x, y, z = half
        corners = [(-x, -y, z), (x, -y, z), (x, y, z), (-x, y, z)]
        body = {"top": corners, "foot": [(-x, -y, -z)]}
    clicks = {}
    for name, points in body.items():
        world = np.array(points, float) @ item.rotation.T + item.position
        # The near side is the one that is seen; of the toe both corners are.
        near = sorted(world, key=lambda point: point[1]) if shape["kind"] == "ramp" else world
        seen = near[:1] if name in ("foot", "top") and shape["kind"] == "ramp" else near
        clicks[name] = [[round(float(v), 1) for v in row] for row in lens.project(np.array(seen))]
    return clicks


def add_clicks(path: Path, photo: Photo, truth: dict[str, Any]) -> None:
    """Adds to a case what a person can see besides: parts of supports, the horizon, one size."""
    case = yaml.safe_load(path.read_text(encoding="utf-8"))
    for item in photo.items:
        if item.truth and item.truth["role"] == "support":
            case["supports"][item.truth["name"]] |= parts_of(item, photo.lens)
    first = truth["objects"][0]
    shape = first["shape"]
    size = 2 * shape["radius"] if "radius" in shape else max(shape["size"])
    case["horizon"] = round(truth["horizon"])
    case["scale"] = {"reference": first["name"], "metres": size}
    case["events"] = case.pop("events")
    text = yaml.safe_dump(case, sort_keys=False, allow_unicode=True, width=10_000)
    path.write_text(text, encoding="utf-8")


def write(name: str, folder: Path, samples: int) -> None:
    """Render one photograph into `folder`/`name`."""
    seed, make = PHOTOS[name]
    rng = np.random.default_rng(seed)
    photo = make(rng)
    items = [*photo.items, *surroundings(rng, photo)]
    out = folder / name
    truth = shoot(
        out, items, photo.lens, photo.room, photo.film, photo.events,
        wall=photo.wall, samples=samples, seed=seed,
    )  # fmt: skip
    add_clicks(out / "case.yaml", photo, truth)


if __name__ == "__main__":
    command("Render the further examples.", PHOTOS, OUT, 256, write)
