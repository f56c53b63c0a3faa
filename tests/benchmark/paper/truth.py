"""The true scenes behind the pictures of the paper's benchmark, as bare geometry in metres."""

from __future__ import annotations

import math
from functools import cache
from typing import Any

import numpy as np

from physagent_studio.agent.rules import RuleGenerator
from physagent_studio.benchmark.paper.listing import Event
from physagent_studio.benchmark.paper.pictures import Prop, props_of, said_of_scenes, seed_of
from physagent_studio.program import PhysicalProgram
from physagent_studio.program.rotations import about_up
from physagent_studio.program.scene.state import Box, Cylinder, Ramp, Shape, Slab, Sphere
from tests.agent.rules.scenes import Stage

LYING = (0.7071, 0.7071, 0.0, 0.0)
"""The axis of a cylinder turned away from the camera."""


@cache
def stage_of(scene: str) -> Stage:
    """The scene with a simple solid for each thing."""
    said = said_of_scenes()["scenes"][scene]
    props = {p.name: p for p in props_of(scene, np.random.default_rng(seed_of(scene)))}
    metres = float(said["metres"])
    asked = {name: prop for name, prop in props.items() if prop.asked}
    objects = {
        name: (_solid(p, metres), _middle(p, metres), _below(p)) for name, p in asked.items()
    }
    supports = {n: _support(p, metres) for n, p in props.items() if "support" in p.said}
    lines = {n: ("line", _ends(p, metres)) for n, p in props.items() if "landmark" in p.said}
    turns = {name: _turn(prop, props) for name, prop in asked.items()}
    return Stage(scene, objects, supports, lines, turns)


def first_program(event: Event) -> PhysicalProgram:
    """The embedded agent's first program over the true scene."""
    stage = stage_of(event.scene)

    return RuleGenerator().first(stage.case(event.prompt), stage.reconstruct)


def _row(prop: Prop) -> dict[str, Any]:
    return said_of_scenes()["kinds"].get(prop.said["kind"], {})


def _solid(prop: Prop, metres: float) -> Shape:
    x, y, z = (float(side) * metres for side in prop.size)
    if "lies" in _row(prop):
        return Cylinder(radius=x / 2, height=y)
    kind = _row(prop).get("solid", "box")
    if kind == "sphere":
        return Sphere(radius=x / 2)
    return Cylinder(radius=max(x, y) / 2, height=z) if kind == "cylinder" else Box(size=(x, y, z))


def _middle(prop: Prop, metres: float) -> tuple[float, float, float]:
    low, high = prop.thing.bounds
    x, y, z = (low + high) / 2 * metres
    return float(x), float(y), float(z)


def _below(prop: Prop) -> str:
    said = prop.said
    return said.get("upon") or said.get("slope") or ("air" if "up" in said else "floor")


def _turn(prop: Prop, props: dict[str, Prop]) -> tuple[float, float, float, float]:
    if "lies" in _row(prop):
        return LYING
    if "slope" in prop.said:
        wide, _, tall = props[prop.said["slope"]].size
        lean = math.atan2(tall, wide) / 2
        return math.cos(lean), 0.0, math.sin(lean), 0.0
    return about_up(math.radians(prop.said.get("turn", 0.0)))


def _support(prop: Prop, metres: float) -> Slab | Ramp:
    low, high = (corner * metres for corner in prop.thing.bounds)
    x, y, z = (float(side) for side in high - low)
    middle = tuple(float(value) for value in (low + high) / 2)
    if prop.said["kind"] == "table":
        return Slab(position=(middle[0], middle[1], middle[2]), size=(x, y, z))
    steps = 3 if prop.said["kind"] == "steps" else 0
    toe = (float(high[0]), middle[1], 0.0)
    run = x - x / 3 if steps else x
    return Ramp(toe=toe, yaw=math.pi, run=run, rise=z, width=y, steps=steps)


def _ends(prop: Prop, metres: float) -> tuple[tuple[float, float, float], ...]:
    low, high = (corner * metres for corner in prop.thing.bounds)
    x = float(low[0] + high[0]) / 2
    return (x, float(low[1]), 0.0), (x, float(high[1]), 0.0)
