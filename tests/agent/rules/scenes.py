"""A dozen small scenes without photographs: geometry by hand, the same roles as a real case."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from types import MappingProxyType

import numpy as np

from physagent_studio.program import Camera, Click, Grounding, SceneState
from physagent_studio.program.rotations import about_up
from physagent_studio.program.scene.state import (
    Box,
    Cylinder,
    Ellipsoid,
    Floor,
    Landmark,
    Ramp,
    SceneObject,
    Shape,
    Slab,
    Sphere,
    Support,
    SupportShape,
)
from physagent_studio.records import Case, Scene

Spot = tuple[float, float, float]
CAMERA = Camera.from_horizon((832, 480), 120.0, 1.2, source="given", confirmed=True)


@dataclass(frozen=True)
class Stage:
    """objects: shape, position, what it stands on. landmarks: kind and world points.

    turns: rotations of the objects that are turned.
    """

    name: str
    objects: Mapping[str, tuple[Shape, Spot, str]]
    supports: Mapping[str, SupportShape] = field(default_factory=dict)
    landmarks: Mapping[str, tuple[str, tuple[Spot, ...]]] = field(default_factory=dict)
    turns: Mapping[str, tuple[float, float, float, float]] = field(default_factory=dict)

    def case(self, prompt: str) -> Case:
        """The case: names, clicks where the things are seen, and the prompt."""
        pixels, _ = CAMERA.project(np.array([spot for _, spot, _ in self.objects.values()]))
        objects = tuple(
            (name, Grounding(points=(Click(x=float(x), y=float(y)),)))
            for name, (x, y) in zip(self.objects, pixels, strict=True)
        )
        supports = tuple(
            Support(name=name, grounding=self._click(shape))
            for name, shape in self.supports.items()
        )
        marks = tuple(
            Landmark.model_validate(
                {"name": name, "kind": kind, "points": points, "source": "given"}
            )
            for name, (kind, points) in self.landmarks.items()
        )
        return Case(self.name, None, "", objects, supports, marks, prompt)

    def _click(self, shape: SupportShape) -> Grounding:
        if isinstance(shape, Slab):
            spot = np.array(shape.position)
        elif isinstance(shape, Ramp):
            ahead = np.array([np.cos(shape.yaw), np.sin(shape.yaw), 0.0]) * shape.run / 2
            spot = np.array(shape.toe) + ahead + [0, 0, shape.rise / 2]
        else:
            return Grounding()
        pixel, _ = CAMERA.project(spot[None])
        return Grounding(points=(Click(x=float(pixel[0, 0]), y=float(pixel[0, 1])),))

    def reconstruct(self, state: SceneState) -> Scene:
        """What reconstruction would give: every open field filled with the true geometry."""
        objects = tuple(self._object(item) for item in state.objects)
        supports = tuple(
            s.model_copy(update={"shape": self.supports.get(s.name, Floor())})
            for s in state.supports
        )
        full = state.model_copy(
            update={"camera": CAMERA, "horizon": 120.0, "objects": objects, "supports": supports}
        )
        empty: MappingProxyType = MappingProxyType({})
        return Scene(full, None, None, empty, empty, empty, empty, (), "synthetic")

    def _object(self, item: SceneObject) -> SceneObject:
        shape, spot, below = self.objects[item.name]
        update: dict[str, object] = {"shape": shape, "position": spot}
        update |= {"support": item.support or below}
        if item.name in self.turns:
            update["rotation"] = self.turns[item.name]
        return item.model_copy(update=update)


def _box(x: float, y: float, z: float) -> Box:
    return Box(size=(x, y, z))


TABLE = Slab(position=(0.0, 2.5, 0.375), size=(1.2, 0.8, 0.75))
RAMP = Ramp(toe=(0.3, 2.5, 0.0), yaw=float(np.pi), run=1.0, rise=0.3, width=0.5)
SLOPE = float(np.arctan2(0.3, 1.0))


def _on_ramp(ahead: float, lift: float) -> Spot:
    """A spot on the ramp `ahead` m before its toe, `lift` m off its surface along its normal."""
    z = 0.3 * ahead
    return (0.3 - ahead + np.sin(SLOPE) * lift, 2.5, z + np.cos(SLOPE) * lift)


STAGES: dict[str, Stage] = {
    stage.name: stage
    for stage in (
        Stage("field", {"ball": (Sphere(radius=0.11), (0.0, 2.5, 0.11), "floor")}, {}, {
            "goal": ("opening", ((-1.5, 7, 0), (1.5, 7, 0), (1.5, 7, 2), (-1.5, 7, 2))),
            "goal_line": ("line", ((-4, 6.5, 0), (4, 6.5, 0))),
        }),
        Stage("lane", {
            "bowling_ball": (Sphere(radius=0.108), (0.0, 2.0, 0.108), "floor"),
            "left_pin": (Cylinder(radius=0.05, height=0.38), (-0.45, 4.5, 0.19), "floor"),
            "middle_pin": (Cylinder(radius=0.05, height=0.38), (0.0, 4.5, 0.19), "floor"),
            "right_pin": (Cylinder(radius=0.05, height=0.38), (0.45, 4.5, 0.19), "floor"),
        }),
        Stage("desk", {
            "red_cube": (_box(0.08, 0.08, 0.08), (0.45, 2.5, 0.79), "table"),
            "blue_cup": (Cylinder(radius=0.04, height=0.1), (-0.1, 2.5, 0.8), "table"),
        }, {"table": TABLE}),
        Stage("stack", {
            "top_box": (_box(0.2, 0.2, 0.12), (0.0, 2.5, 0.30), "middle_box"),
            "middle_box": (_box(0.2, 0.2, 0.12), (0.0, 2.5, 0.18), "bottom_box"),
            "bottom_box": (_box(0.24, 0.24, 0.12), (0.0, 2.5, 0.06), "floor"),
        }),
        Stage("slope", {
            "toy_car": (_box(0.12, 0.06, 0.05), _on_ramp(0.8, 0.0251), "ramp"),
        }, {"ramp": RAMP}),
        Stage("ice", {
            "red_stone": (Cylinder(radius=0.14, height=0.12), (0.0, 2.0, 0.06), "floor"),
            "yellow_stone": (Cylinder(radius=0.14, height=0.12), (0.0, 4.0, 0.06), "floor"),
        }, {}, {"target": ("point", ((0.0, 4.6, 0.0),))}),
        Stage("air", {
            "melon": (Sphere(radius=0.12), (0.0, 2.5, 1.2), "air"),
            "stool": (_box(0.35, 0.35, 0.4), (0.0, 2.5, 0.2), "floor"),
        }),
        Stage("yard", {
            "scooter": (_box(0.9, 0.12, 0.8), (-1.2, 3.5, 0.4), "floor"),
            "trash_can": (Cylinder(radius=0.2, height=0.7), (0.8, 3.5, 0.35), "floor"),
        }),
        Stage("shelf", {
            "green_ball": (Sphere(radius=0.06), (-0.3, 2.5, 0.81), "table"),
            "domino": (_box(0.03, 0.1, 0.2), (0.2, 2.5, 0.85), "table"),
        }, {"table": TABLE}),
        Stage("court", {
            "basketball": (Sphere(radius=0.12), (-0.5, 3.0, 0.12), "floor"),
            "crate": (_box(0.4, 0.4, 0.4), (1.0, 3.0, 0.2), "floor"),
        }, {}, {"hoop": ("opening", ((0.6, 5, 2.0), (1.2, 5, 2.0), (1.2, 5, 2.6), (0.6, 5, 2.6)))}),
        Stage("fruit", {
            "left_apple": (Ellipsoid(radii=(0.04, 0.04, 0.038)), (-0.3, 2.5, 0.788), "table"),
            "right_apple": (Ellipsoid(radii=(0.04, 0.04, 0.038)), (0.1, 2.5, 0.788), "table"),
            "knife": (_box(0.2, 0.03, 0.01), (-0.1, 2.35, 0.755), "table"),
        }, {"table": TABLE}),
        Stage("wind", {
            "balloon": (Sphere(radius=0.15), (0.0, 3.0, 0.15), "floor"),
            "paper_cup": (Cylinder(radius=0.04, height=0.1), (0.5, 3.0, 0.05), "floor"),
        }),
    )
}  # fmt: skip


def reconstructor(stage: Stage) -> Callable[[SceneState], Scene]:
    """The `reconstruct` that a generator gets."""
    return stage.reconstruct


__all__ = ["CAMERA", "STAGES", "Stage", "about_up", "reconstructor"]
