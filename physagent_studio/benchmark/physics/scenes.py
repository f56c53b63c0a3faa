"""Small programs with a known answer, for the physics bench and the tests."""

from collections.abc import Iterable
from typing import Any

import numpy as np

from physagent_studio.program import (
    Action,
    Clip,
    EventProgram,
    PhysicalProgram,
    SceneObject,
    SceneState,
    Support,
)
from physagent_studio.program.rotations import Quat
from physagent_studio.program.scene.state import Floor, Shape, SupportShape
from physagent_studio.records import Mesh

Vector = tuple[float, float, float]
STILL: Vector = (0.0, 0.0, 0.0)
EARTH: Vector = (0.0, 0.0, -9.81)
IDENTITY: Quat = (1.0, 0.0, 0.0, 0.0)
TOUCH = {"friction": 0.4, "restitution": 0.0, "rolling": 0.0}
"""How things touch that do not say otherwise."""


def thing(
    name: str,
    shape: Shape,
    position: Vector,
    *,
    rotation: Quat = IDENTITY,
    density: float = 500.0,
    **touch: float,
) -> SceneObject:
    """An object of stated material numbers; touch: those of `TOUCH`."""
    stated: dict[str, Any] = {"rotation": rotation, "density": density} | TOUCH | touch
    return SceneObject(name=name, shape=shape, position=position, **stated)


def ground(name: str = "floor", shape: SupportShape | None = None, **touch: float) -> Support:
    """A support of stated material numbers, see `TOUCH`; a floor at z = 0 by default."""
    stated: dict[str, Any] = TOUCH | touch
    return Support(name=name, shape=shape or Floor(), **stated)


def program(
    objects: Iterable[SceneObject],
    supports: Iterable[Support] = (),
    actions: Iterable[Action] = (),
    *,
    gravity: Vector = EARTH,
    seconds: float = 3.2,
    substeps: int = 10,
) -> PhysicalProgram:
    """A clip of `seconds` at 25 frames/s of simulated time, control step 10 ms."""
    frames = max(round(seconds / 0.04), 1) + 1
    return PhysicalProgram(
        clip=Clip(frames=frames, substeps=substeps),
        scene=SceneState(objects=tuple(objects), supports=tuple(supports), gravity=gravity),
        event=EventProgram(actions=tuple(actions)),
    )


def ring_mesh(radius: float, thickness: float, segments: int = 32, around: int = 12) -> Mesh:
    """A torus about z. radius: of its middle circle; thickness: radius of its cross-section, m."""
    turns = np.arange(segments) * 2 * np.pi / segments
    across = np.arange(around) * 2 * np.pi / around
    u, v = np.meshgrid(turns, across, indexing="ij")
    out = radius + thickness * np.cos(v)
    points = np.stack([out * np.cos(u), out * np.sin(u), thickness * np.sin(v)], -1)
    here = np.arange(segments)[:, None] * around + np.arange(around)
    ahead, above = np.roll(here, -1, 0), np.roll(here, -1, 1)
    both = np.roll(ahead, -1, 1)
    one = np.stack([here, ahead, both], -1).reshape(-1, 3)
    other = np.stack([here, both, above], -1).reshape(-1, 3)
    return Mesh(points.reshape(-1, 3), np.concatenate([one, other]).astype(np.int32))
