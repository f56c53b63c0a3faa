"""Everyday places as bare geometry: a kitchen table, a garden, a pool table, a row of dominoes."""

from __future__ import annotations

from physagent_studio.program.scene.state import Box, Cylinder, Ellipsoid, Ramp, Slab, Sphere
from tests.agent.rules.scenes import RAMP, Spot, Stage, _on_ramp


def _box(x: float, y: float, z: float) -> Box:
    return Box(size=(x, y, z))


def _round(radius: float, height: float) -> Cylinder:
    return Cylinder(radius=radius, height=height)


def _table(top: float, width: float = 1.4, depth: float = 0.8, y: float = 2.5) -> Slab:
    return Slab(position=(0.0, y, top / 2), size=(width, depth, top))


def _on(x: float, y: float, half: float, top: float = 0.75) -> Spot:
    return (x, y, top + half)


EGG = Ellipsoid(radii=(0.028, 0.022, 0.022))
POOL = Sphere(radius=0.028)
BLOCK = _box(0.06, 0.06, 0.06)
HILL: Ramp = RAMP

EVERYDAY: dict[str, Stage] = {
    stage.name: stage
    for stage in (
        Stage("kitchen", {
            "mug": (_round(0.04, 0.1), _on(0.5, 2.5, 0.05), "table"),
            "plate": (_round(0.12, 0.02), _on(0, 2.4, 0.01), "table"),
            "teapot": (_round(0.08, 0.15), _on(-0.4, 2.6, 0.075), "table"),
            "spoon": (_box(0.16, 0.03, 0.01), _on(0.2, 2.3, 0.005), "table"),
            "egg": (EGG, _on(0.3, 2.7, 0.022), "table"),
        }, {"table": _table(0.75)}),
        Stage("living", {
            "tall_vase": (_round(0.06, 0.4), _on(-0.3, 2.8, 0.2, 0.45), "coffee_table"),
            "short_vase": (_round(0.07, 0.2), _on(0.1, 2.8, 0.1, 0.45), "coffee_table"),
            "remote_control": (_box(0.18, 0.05, 0.02), _on(0.4, 2.6, 0.01, 0.45), "coffee_table"),
            "cushion": (_box(0.4, 0.4, 0.12), (-1.2, 2.6, 0.06), "floor"),
            "tennis_ball": (Sphere(radius=0.033), (1.2, 2.4, 0.033), "floor"),
        }, {"coffee_table": _table(0.45, 1.2, 0.6, 2.7)}),
        Stage("office", {
            "stapler": (_box(0.15, 0.04, 0.06), _on(-0.3, 2.5, 0.03), "desk"),
            "pen": (_box(0.14, 0.012, 0.012), _on(0, 2.4, 0.006), "desk"),
            "coffee_cup": (_round(0.04, 0.11), _on(0.35, 2.5, 0.055), "desk"),
            "laptop": (_box(0.32, 0.22, 0.02), _on(0, 2.65, 0.01), "desk"),
            "marble": (Sphere(radius=0.01), _on(0.15, 2.35, 0.01), "desk"),
        }, {"desk": _table(0.75)}),
        Stage("garden", {
            "bucket": (_round(0.15, 0.3), (0.8, 3, 0.15), "floor"),
            "gnome": (_round(0.1, 0.4), (0, 3.5, 0.2), "floor"),
            "watering_can": (_box(0.3, 0.18, 0.25), (-0.8, 3, 0.125), "floor"),
            "flower_pot": (_round(0.12, 0.22), (0.3, 2.6, 0.11), "floor"),
            "rubber_ball": (Sphere(radius=0.1), (-0.4, 2.4, 0.1), "floor"),
        }),
        Stage("playground", {
            "skateboard": (_box(0.8, 0.2, 0.12), (-1.2, 3, 0.06), "floor"),
            "tyre": (_round(0.3, 0.2), (1, 3.4, 0.1), "floor"),
            "big_ball": (Sphere(radius=0.25), (0, 3.2, 0.25), "floor"),
            "small_ball": (Sphere(radius=0.1), (0.5, 2.6, 0.1), "floor"),
            "cone": (_round(0.12, 0.4), (-0.4, 2.5, 0.2), "floor"),
        }),
        Stage("snow", {
            "sled": (_box(0.4, 0.2, 0.12), _on_ramp(0.8, 0.0601), "hill"),
            "snowman": (_round(0.2, 0.9), (1.0, 2.5, 0.45), "floor"),
            "snowball": (Sphere(radius=0.08), (-0.2, 2.0, 0.08), "floor"),
        }, {"hill": HILL}),
        Stage("beach", {
            "beach_ball": (Sphere(radius=0.2), (0, 3, 0.2), "floor"),
            "bucket": (_round(0.1, 0.2), (0.7, 2.8, 0.1), "floor"),
            "sand_castle": (_box(0.4, 0.4, 0.3), (-0.7, 3.2, 0.15), "floor"),
            "umbrella": (_round(0.05, 1.6), (1.4, 4, 0.8), "floor"),
        }, {}, {"water": ("area", ((-3, 5, 0), (3, 5, 0), (3, 8, 0), (-3, 8, 0)))}),
        Stage("workshop", {
            "hammer": (_box(0.3, 0.12, 0.04), _on(-0.3, 2.5, 0.02, 0.9), "workbench"),
            "paint_can": (_round(0.08, 0.18), _on(0.1, 2.5, 0.09, 0.9), "workbench"),
            "toolbox": (_box(0.4, 0.2, 0.2), _on(0.45, 2.6, 0.1, 0.9), "workbench"),
            "wheel": (_round(0.25, 0.08), (-1.2, 3, 0.04), "floor"),
        }, {"workbench": _table(0.9, 1.4, 0.7)}),
        Stage("pool", {
            "white_ball": (POOL, _on(-0.5, 2.5, 0.028, 0.8), "pool_table"),
            "black_ball": (POOL, _on(0.2, 2.5, 0.028, 0.8), "pool_table"),
            "red_ball": (POOL, _on(0.4, 2.7, 0.028, 0.8), "pool_table"),
        }, {"pool_table": _table(0.8, 2.2, 1.1)}, {
            "corner_pocket": ("point", ((1.05, 3.0, 0.8),)),
        }),
        Stage("golf", {"golf_ball": (Sphere(radius=0.021), (-0.5, 2.5, 0.021), "floor")}, {}, {
            "hole": ("area", (
                (0.95, 3.95, 0), (1.05, 3.95, 0), (1.05, 4.05, 0), (0.95, 4.05, 0)
            )),
        }),
        Stage("toys", {
            "red_block": (BLOCK, (-0.5, 2.5, 0.03), "floor"),
            "green_block": (BLOCK, (-0.5, 2.5, 0.09), "red_block"),
            "blue_block": (BLOCK, (-0.5, 2.5, 0.15), "green_block"),
            "toy_truck": (_box(0.2, 0.1, 0.1), (0.4, 2.4, 0.05), "floor"),
            "teddy_bear": (_box(0.2, 0.15, 0.3), (1, 2.8, 0.15), "floor"),
        }),
        Stage("dominoes", {
            **{
                f"domino_{i}": (_box(0.012, 0.05, 0.1), (-0.3 + 0.06 * i, 2.5, 0.05), "floor")
                for i in range(1, 6)
            },
            "marble": (Sphere(radius=0.02), (-0.6, 2.5, 0.02), "floor"),
        }),
        Stage("street", {
            "bicycle": (_box(1.6, 0.3, 1.0), (-0.8, 4, 0.5), "floor"),
            "trash_bin": (_round(0.25, 0.9), (0.9, 4, 0.45), "floor"),
            "can": (_round(0.033, 0.12), (0, 2.4, 0.06), "floor"),
            "traffic_cone": (_round(0.15, 0.5), (0.2, 3.2, 0.25), "floor"),
        }),
        Stage("boxes", {
            "box_a": (_box(0.4, 0.4, 0.4), (-0.5, 2.5, 0.2), "floor"),
            "box_b": (_box(0.2, 0.2, 0.5), (0.5, 2.5, 0.25), "floor"),
        }),
    )
}  # fmt: skip
