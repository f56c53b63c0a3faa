"""Render the bundled demo: assets/demo/{input.png, ids.png, case.yaml, truth.json}.

A red rubber ball, a standing wooden block and a green cube on a table by a window. Pushed
straight at the cube, the ball clips the block on its way; pushed slowly at the block, it only
nudges it. Both are for reflection to find.

    python -m venv /tmp/tools && /tmp/tools/bin/pip install -r tools/requirements.txt
    /tmp/tools/bin/python tools/make_demo_image.py

The shipped picture was made with the variant `llvm_ad_rgb`, which needs libLLVM 16 or newer
(`DRJIT_LIBLLVM_PATH` names it). `scalar_rgb` needs nothing, takes four times as long and
differs in its grain alone.
"""

from __future__ import annotations

import argparse
import math
import time
from pathlib import Path

import cv2
import mitsuba as mi
import numpy as np
from photoreal import meshes, textures
from photoreal.develop import develop
from photoreal.noise import solid, solid_layered
from photoreal.stage import Item, Lens, Room, identities, panel, radiance, turn
from photoreal.textures import Surface, linear
from photoreal.truth import planes, truth_of, write_case

SEED = 20250
OUT = Path(__file__).resolve().parent.parent / "assets" / "demo"
EVENTS = {
    "only_the_cube": "The red ball rolls to the right, passes the wooden block and hits only the "
    "green cube, leaving the wooden block standing.",
    "block_stays_standing": "The red ball rolls to the right, hits the wooden block and stops "
    "before reaching the green cube, while the block stays standing.",
    "knocks_block_over": "The red ball rolls to the right, hits the wooden block and knocks it "
    "over.",
    "topples_onto_cube": "The red ball hits the wooden block, which falls over and touches the "
    "green cube.",
}
BALL_RADIUS = 0.040
BALL = (-0.21, 0.50)
BLOCK_SIZE, BLOCK, BLOCK_YAW = (0.070, 0.040, 0.150), (0.10, 0.693), math.radians(10)
CUBE_SIZE, CUBE, CUBE_YAW = 0.060, (0.28, 0.735), math.radians(-24)
TABLE_END, WALL = 1.16, 1.20


def lens_of(size: tuple[int, int]) -> Lens:
    """42° vertical field of view, 30 cm above the table, pitched 17° down, about f/7."""
    focal = size[1] / 2 / math.tan(math.radians(21))
    return Lens(size, focal, (0.0, 0.0, 0.30), math.radians(17), aperture=0.0022, focus=0.66)


def room() -> Room:
    """A living room with a window on the left, a little behind the table's middle."""
    return Room((-1.75, -2.3, -0.74), (2.3, WALL, 1.85), (0.30, 0.86), (0.95, 1.25))


def table(rng: np.random.Generator, texel: float) -> Item:
    """Oak boards running away from the camera, the far edge just short of the wall."""
    size = (2.1, 1.36, 0.032)
    surface = textures.boards(rng, (size[1], size[0]), texel)
    body = meshes.box(size, 0.004, planar=True)
    return Item(body, surface, (0.0, TABLE_END - size[1] / 2, -size[2] / 2))


def wall(rng: np.random.Generator, texel: float) -> Item:
    """The plaster wall behind the table."""
    x0, x1, z0, z1 = -1.75, 2.3, -0.74, 1.85
    shape = (round((z1 - z0) / texel), round((x1 - x0) / texel))
    body = panel((x0, WALL, z0), (x1 - x0, 0, 0), (0, 0, z1 - z0))
    return Item(body, textures.plaster(rng, shape, texel), gloss={"specular": 0.2})


def ball(rng: np.random.Generator) -> Item:
    """Moulded red rubber with its seam, faint scuffs and a little dust."""
    rows, columns = 700, 1400
    latitude = (np.linspace(-np.pi / 2, np.pi / 2, rows))[:, None]
    longitude = np.linspace(0, 2 * np.pi, columns, endpoint=False)[None, :]
    points = np.stack(
        [
            np.cos(latitude) * np.cos(longitude),
            np.cos(latitude) * np.sin(longitude),
            np.broadcast_to(np.sin(latitude), (rows, columns)),
        ],
        -1,
    )
    seed = int(rng.integers(1 << 20))
    cloud = solid_layered(points * 3, seed, 4)
    grain = solid(points * 90, seed + 9)
    scuff = np.clip(solid_layered(points * [4, 9, 30], seed + 20, 4) - 0.55, 0, 1)
    arc = latitude * BALL_RADIUS + np.zeros_like(longitude)
    seam = np.exp(-((arc / 0.0010) ** 2)).astype(np.float32)
    colour = linear((196, 30, 28)) * (1 + 0.05 * cloud + 0.02 * grain)[..., None]
    dusty = np.clip(0.10 * scuff + 0.16 * seam, 0, 1)[..., None]
    colour = colour * (1 - dusty) + linear((214, 120, 110)) * dusty
    rough = 0.13 + 0.03 * cloud + 0.30 * scuff + 0.10 * seam
    height = 1.6e-4 * seam + 6e-6 * grain + 3e-5 * cloud
    truth = {
        "name": "red_ball", "id": 1, "role": "object", "support": "floor", "material": "rubber",
        "colour": "red", "shape": {"kind": "sphere", "radius": BALL_RADIUS},
    }  # fmt: skip
    return Item(
        meshes.sphere(BALL_RADIUS),
        Surface(colour.astype(np.float32), np.clip(rough, 0.08, 0.8), height.astype(np.float32)),
        (*BALL, BALL_RADIUS),
        turn(0.5, 0.6, -0.12),
        truth,
    )


def block(rng: np.random.Generator) -> Item:
    """Pale pine with its grain upright and the year rings on top."""
    points = meshes.atlas_points(BLOCK_SIZE, 640)
    colour, dark = textures.solid_wood(points, rng)
    truth = {
        "name": "wooden_block", "id": 2, "role": "object", "support": "floor", "material": "wood",
        "colour": "light brown", "shape": {"kind": "box", "size": list(BLOCK_SIZE)},
    }  # fmt: skip
    return Item(
        meshes.box(BLOCK_SIZE, 0.0022),
        Surface(colour, (0.46 + 0.08 * dark).astype(np.float32), -2.5e-5 * dark),
        (*BLOCK, BLOCK_SIZE[2] / 2),
        turn(BLOCK_YAW),
        truth,
    )


def cube(rng: np.random.Generator) -> Item:
    """A painted toy cube with soft edges."""
    surface = textures.plain(
        rng, (1000, 1500), (160, 160), (42, 128, 66), roughness=0.36, mottle=0.025, bump=8e-6
    )
    truth = {
        "name": "green_cube", "id": 3, "role": "object", "support": "floor", "material": "wood",
        "colour": "green", "shape": {"kind": "box", "size": [CUBE_SIZE] * 3},
    }  # fmt: skip
    body = meshes.cube(CUBE_SIZE, 0.0035)
    return Item(body, surface, (*CUBE, CUBE_SIZE / 2), turn(CUBE_YAW), truth)


def main() -> None:
    """Render and write everything."""
    parser = argparse.ArgumentParser(description="Render the bundled demo.")
    parser.add_argument("--out", type=Path, default=OUT)
    parser.add_argument("--samples", type=int, default=400, help="paths per pixel")
    parser.add_argument("--variant", default="llvm_ad_rgb", help="or scalar_rgb, slower")
    parser.add_argument("--scale", type=float, default=1.0, help="size of a preview")
    args = parser.parse_args()
    mi.set_variant(args.variant)
    start = time.monotonic()
    rng = np.random.default_rng(SEED)
    items = [table(rng, 0.0004), wall(rng, 0.0012), ball(rng), block(rng), cube(rng)]
    print(f"textures {time.monotonic() - start:.0f} s", flush=True)
    lens = lens_of((round(832 * args.scale), round(480 * args.scale)))
    light = radiance(items, room(), lens, samples=args.samples, seed=SEED)
    picture = develop(light, exposure=1.45, balance=(1.06, 1.0, 0.93), seed=SEED)
    ids = identities(items, lens)
    truth = truth_of(items, lens, ids, planes(WALL), seed=SEED, table_end=TABLE_END)
    args.out.mkdir(parents=True, exist_ok=True)
    cv2.imwrite(str(args.out / "input.png"), picture[..., ::-1], [cv2.IMWRITE_PNG_COMPRESSION, 9])
    # The block's lit side is as unlike its front as another object would be.
    x, y = lens.project(turn(BLOCK_YAW) @ [-BLOCK_SIZE[0] / 2, 0, 0] + items[3].position)[0]
    second = {"wooden_block": (int(x), int(y))}
    write_case(args.out, "input.png", truth, ids, EVENTS, second)
    size = (args.out / "input.png").stat().st_size
    print(f"{args.out}: {size / 1024:.0f} KB, {time.monotonic() - start:.0f} s in all")


if __name__ == "__main__":
    main()
