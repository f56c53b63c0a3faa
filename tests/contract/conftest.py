"""Hand-made rollouts: every number in them is written by the test, none by an engine."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from physagent_studio.contract import measure
from physagent_studio.program import Clip, Contract, EventProgram, PhysicalProgram, SceneState
from physagent_studio.program.rotations import about_axis
from physagent_studio.program.scene.state import (
    Box,
    Cylinder,
    Floor,
    Landmark,
    SceneObject,
    Slab,
    Sphere,
    Support,
)
from physagent_studio.records import CONTACT_DTYPE, ActionSpan, Alarm, Check, Release, Rollout

STEPS = 100
DT = 0.01
TIME = np.arange(STEPS + 1) * DT


class Stage:
    """A ball, a cube, a can, a floor and a table; paths and contacts are set by hand."""

    def __init__(self) -> None:
        self.objects: dict[str, SceneObject] = {
            "ball": SceneObject(name="ball", shape=Sphere(radius=0.1), position=(0, 0, 0.1)),
            "cube": SceneObject(name="cube", shape=Box(size=(0.2, 0.2, 0.2)), position=(1, 0, 0.1)),
            "can": SceneObject(
                name="can", shape=Cylinder(radius=0.05, height=0.2), position=(0, 1, 0.1)
            ),
        }
        self.supports = [
            Support(name="floor", shape=Floor()),
            Support(name="table", shape=Slab(position=(3, 0, 0.5), size=(1, 1, 1))),
        ]
        self.landmarks = [
            Landmark(name="line", kind="line", points=((0.5, -1, 0), (0.5, 1, 0))),
            Landmark(
                name="circle",
                kind="area",
                points=((0.8, -0.2, 0), (1.2, -0.2, 0), (1.2, 0.2, 0), (0.8, 0.2, 0)),
            ),
            Landmark(
                name="goal",
                kind="opening",
                points=((-0.5, 2, 0), (0.5, 2, 0), (0.5, 2, 1), (-0.5, 2, 1)),
            ),
            Landmark(name="spot", kind="point", points=((1, 0, 0),)),
            Landmark(name="nowhere", kind="line"),
        ]
        self.paths: dict[str, np.ndarray] = {}
        self.turns: dict[str, np.ndarray] = {}
        self.rows: list[tuple[Any, ...]] = []
        self.spans: list[ActionSpan] = []
        self.actions: list[dict[str, Any]] = []
        self.warnings: list[Alarm] = []
        self.vertices: dict[str, np.ndarray] = {}
        self.releases: list[Release] = []
        self.masses = 1.0

    def path(self, name: str, x: Any = None, y: Any = None, z: Any = None) -> "Stage":
        """Coordinates over time; what is not given stays."""
        start = np.array(self.objects[name].position, float)
        columns = [
            np.broadcast_to(start[i] if value is None else value, STEPS + 1)
            for i, value in enumerate((x, y, z))
        ]
        self.paths[name] = np.stack(columns, axis=-1).astype(float)
        return self

    def turn(self, name: str, axis: Sequence[float], degrees: Any) -> "Stage":
        """Rotation about a fixed world axis over time."""
        angles = np.broadcast_to(np.radians(degrees), STEPS + 1)
        self.turns[name] = np.array([about_axis(axis, float(a)) for a in angles])
        unit = np.asarray(axis, float) / np.linalg.norm(axis)
        self.turns[name + ".rate"] = np.gradient(angles, DT)[:, None] * unit
        return self

    def touch(
        self,
        a: str,
        b: str,
        steps: range | Sequence[int] = range(STEPS + 1),
        normal: Sequence[float] = (0, 0, -1),
        impulse: float = 0.1,
        depth: float = 0.0,
    ) -> "Stage":
        """A contact whose normal points from a to b; the default is a lying on b."""
        for step in steps:
            self.rows.append((step, a, b, (0, 0, 0), tuple(normal), impulse, depth))
        return self

    def program(self, *statements: Mapping[str, Any]) -> PhysicalProgram:
        scene = SceneState(
            objects=tuple(self.objects.values()),
            supports=tuple(self.supports),
            landmarks=tuple(self.landmarks),
        )
        return PhysicalProgram(
            clip=Clip(frames=26, step_seconds=DT),
            scene=scene,
            event=EventProgram.model_validate({"actions": self.actions}),
            contract=Contract.model_validate({"statements": statements}),
        )

    def rollout(self) -> Rollout:
        names = tuple(self.objects)
        bodies = names + tuple(one.name for one in self.supports)
        for name in names:
            if name not in self.paths:
                self.path(name)
        still = np.tile([1.0, 0, 0, 0], (STEPS + 1, 1))
        positions = np.stack([self.paths[name] for name in names], axis=1)
        velocities = np.gradient(positions, DT, axis=0)
        angular = np.stack(
            [self.turns.get(name + ".rate", np.zeros((STEPS + 1, 3))) for name in names], axis=1
        )
        rows = sorted(
            (step, bodies.index(a), bodies.index(b), *rest) for step, a, b, *rest in self.rows
        )
        kinetic = 0.5 * self.masses * np.sum(velocities**2, axis=-1)
        return Rollout(
            program_hash="",
            objects=names,
            bodies=bodies,
            step_seconds=DT,
            steps_per_frame=4,
            frames=26,
            positions=positions,
            rotations=np.stack([self.turns.get(name, still) for name in names], axis=1),
            velocities=velocities,
            angular=angular,
            contacts=np.array(rows, CONTACT_DTYPE),
            kinetic=kinetic,
            potential=self.masses * 9.81 * positions[..., 2],
            masses=np.full(len(names), self.masses),
            penetration=np.zeros(STEPS + 1),
            spans=tuple(self.spans),
            warnings=tuple(self.warnings),
            versions=(),
            vertices=tuple(self.vertices.items()),
            releases=tuple(self.releases),
        )

    def check(self, kind: str, **fields: Any) -> Check:
        """One statement measured."""
        return self.checks({"id": "s", "kind": kind, **fields})[0]

    def checks(self, *statements: Mapping[str, Any]) -> tuple[Check, ...]:
        return measure(self.program(*statements), self.rollout())

    def always(self, name: str) -> Check:
        """One of the always-on checks."""
        return next(one for one in self.checks() if one.id == f"physics.{name}")

    def blow_up(self, step: int) -> "Stage":
        self.warnings.append(Alarm(step, "blow_up", "the numbers left all bounds"))
        return self


@pytest.fixture
def stage() -> Stage:
    return Stage()


@pytest.fixture
def new_stage() -> Callable[[], Stage]:
    return Stage


@pytest.fixture
def time() -> np.ndarray:
    """(S + 1,) seconds."""
    return TIME


__all__ = ["Stage", "replace"]
