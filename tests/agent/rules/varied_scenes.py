"""More places as bare geometry: a shelf over a box, a bar, three cups, a row of bottles."""

from __future__ import annotations

from physagent_studio.program.scene.state import Cylinder, Slab, Sphere
from tests.agent.rules.everyday_scenes import _box, _on, _round, _table
from tests.agent.rules.scenes import RAMP, Stage, _on_ramp

BOOK = _box(0.22, 0.16, 0.03)
MARBLE = Sphere(radius=0.015)
LYING = (0.7071, 0.7071, 0.0, 0.0)
"""The axis of a cylinder turned away from the camera."""

VARIED: dict[str, Stage] = {
    stage.name: stage
    for stage in (
        Stage("shelf_room", {
            "candle": (_round(0.03, 0.2), (-0.5, 3, 1.32), "shelf"),
            "clock": (_box(0.2, 0.08, 0.2), (0, 3, 1.32), "shelf"),
            "small_jar": (_round(0.04, 0.1), (0.4, 3, 1.27), "shelf"),
            "cardboard_box": (_box(0.4, 0.4, 0.3), (0.5, 2.6, 0.15), "floor"),
            "basketball": (Sphere(radius=0.12), (-0.8, 2.6, 0.12), "floor"),
        }, {"shelf": Slab(position=(0, 3, 1.2), size=(1.6, 0.3, 0.04))}),
        Stage("bar", {
            "wine_bottle": (_round(0.04, 0.3), _on(-0.3, 2.5, 0.15), "table"),
            "wine_glass": (_round(0.035, 0.2), _on(0.1, 2.5, 0.1), "table"),
            "coaster": (_round(0.05, 0.006), _on(0.45, 2.45, 0.003), "table"),
            "lemon": (Sphere(radius=0.03), _on(-0.55, 2.4, 0.03), "table"),
        }, {"table": _table(0.75)}),
        Stage("cups", {
            "left_cup": (_round(0.04, 0.1), _on(-0.3, 2.5, 0.05), "table"),
            "middle_cup": (_round(0.04, 0.1), _on(0, 2.5, 0.05), "table"),
            "right_cup": (_round(0.04, 0.1), _on(0.3, 2.5, 0.05), "table"),
            "ping_pong_ball": (Sphere(radius=0.02), _on(-0.55, 2.3, 0.02), "table"),
        }, {"table": _table(0.75)}),
        Stage("parking", {
            "red_car": (_box(0.2, 0.1, 0.08), (-0.8, 3, 0.04), "floor"),
            "blue_car": (_box(0.2, 0.1, 0.08), (-0.3, 3, 0.04), "floor"),
            "van": (_box(0.3, 0.14, 0.16), (0.6, 3, 0.08), "floor"),
        }),
        Stage("barrels", {
            "barrel": (_round(0.12, 0.3), _on_ramp(0.8, 0.1201), "ramp"),
            "crate": (_box(0.3, 0.3, 0.3), (1.2, 2.5, 0.15), "floor"),
            "bucket": (_round(0.12, 0.25), (0.8, 3.3, 0.125), "floor"),
        }, {"ramp": RAMP}, {}, {"barrel": LYING}),
        Stage("rink", {
            "puck": (_round(0.04, 0.025), (-0.4, 2.5, 0.0125), "floor"),
            "goalkeeper": (_box(0.3, 0.2, 0.6), (0, 5.5, 0.3), "floor"),
        }, {}, {"net": ("opening", ((-0.9, 6, 0), (0.9, 6, 0), (0.9, 6, 1.2), (-0.9, 6, 1.2)))}),
        Stage("cake", {
            "cherry": (Sphere(radius=0.012), _on(0, 2.5, 0.162), "cake"),
            "cake": (_round(0.12, 0.15), _on(0, 2.5, 0.075), "table"),
            "candle": (_round(0.006, 0.08), _on(0.05, 2.5, 0.19), "cake"),
        }, {"table": _table(0.75)}),
        Stage("fruit_bowl", {
            "bowl": (_round(0.14, 0.09), _on(0.3, 2.5, 0.045), "table"),
            "apple": (Sphere(radius=0.04), _on(-0.3, 2.5, 0.04), "table"),
            "pear": (Sphere(radius=0.045), _on(-0.1, 2.6, 0.045), "table"),
            "plum": (Sphere(radius=0.025), _on(-0.5, 2.4, 0.025), "table"),
        }, {"table": _table(0.75)}),
        Stage("wheels", {
            "hoop": (Cylinder(radius=0.3, height=0.03), (-0.9, 3, 0.3), "floor"),
            "rock": (Sphere(radius=0.12), (0.3, 3.6, 0.12), "floor"),
        }, {}, {}, {"hoop": LYING}),
        Stage("lamp", {
            "lamp": (_round(0.12, 0.15), (0, 2.8, 1.5), "air"),
            "picture": (_box(0.4, 0.03, 0.3), (-0.8, 3.5, 1.4), "air"),
            "vase": (_round(0.06, 0.25), (0.05, 2.8, 0.875), "table"),
        }, {"table": _table(0.75, y=2.8)}),
        Stage("eraser", {
            "red_book": (BOOK, _on(-0.2, 2.5, 0.015), "table"),
            "blue_book": (BOOK, _on(-0.2, 2.5, 0.045), "red_book"),
            "green_book": (BOOK, _on(-0.2, 2.5, 0.075), "blue_book"),
            "eraser": (_box(0.05, 0.02, 0.012), _on(-0.2, 2.5, 0.096), "green_book"),
            "ruler": (_box(0.3, 0.03, 0.004), _on(0.3, 2.4, 0.002), "table"),
        }, {"table": _table(0.75)}),
        Stage("marbles", {
            "green_marble": (MARBLE, (-0.5, 2.2, 0.015), "floor"),
            "yellow_marble": (MARBLE, (-0.1, 2.25, 0.015), "floor"),
            "black_marble": (MARBLE, (0.3, 2.15, 0.015), "floor"),
        }),
        Stage("bottles", {
            **{
                f"bottle_{i}": (_round(0.035, 0.28), (-0.75 + 0.3 * i, 3, 0.14), "floor")
                for i in range(1, 5)
            },
            "ball": (Sphere(radius=0.06), (0, 2, 0.06), "floor"),
        }),
    )
}  # fmt: skip
