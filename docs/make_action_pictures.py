"""Draws docs/images/actions/*.png: every operator in a real run, as a strobe picture.

Run: python docs/make_action_pictures.py [FOLDER]
"""

from __future__ import annotations

import sys
from dataclasses import dataclass, field
from pathlib import Path

import cv2
import numpy as np
from numpy.typing import NDArray

from physagent_studio.benchmark.physics.scenes import EARTH, STILL, Vector, ground, program, thing
from physagent_studio.program import Action, Camera, Directed, OnContact, SceneObject
from physagent_studio.program.actions import (
    ApplyAngledForce,
    ApplyDisturbance,
    ApplyForce,
    ApplyTorque,
    FixObject,
    SetAngularVelocity,
    SetOrientation,
    SetPosition,
    SetVelocity,
)
from physagent_studio.program.rotations import about_axis, matrix_of
from physagent_studio.program.scene.state import Box, Sphere
from physagent_studio.records import Rollout
from physagent_studio.simulation import simulate
from physagent_studio.simulation.surfaces import Surface, box_surface, ellipsoid_surface

Picture = NDArray[np.uint8]

SIZE = (640, 300)
SCALE = 2
"""Drawn larger and reduced: smooth edges."""
PAPER, FLOOR, LINE, INK = (250, 248, 245), (226, 224, 220), (200, 198, 194), (70, 66, 60)
BODY, OTHER, PATH, MARK = (196, 92, 46), (110, 122, 140), (222, 160, 120), (34, 110, 200)
CAMERA = Camera.from_horizon(SIZE, 70, 1.6, focal=560)
DISTANCE = 4.6


@dataclass(frozen=True)
class Shot:
    """One picture: what acts on what, and which steps are shown."""

    name: str
    caption: str
    actions: tuple[Action, ...]
    objects: tuple[SceneObject, ...]
    seconds: float = 1.2
    every: int = 12
    gravity: Vector = EARTH
    arrows: tuple[tuple[int, Vector], ...] = field(default=())


def ball(name: str = "ball", at: Vector = (-1.2, DISTANCE, 0.15)) -> SceneObject:
    """A ball of 30 cm."""
    return thing(name, Sphere(radius=0.15), at, friction=0.6, restitution=0.5)


def box(name: str = "box", at: Vector = (-1.2, DISTANCE, 0.15)) -> SceneObject:
    """A box of 40 × 30 × 30 cm."""
    return thing(name, Box(size=(0.4, 0.3, 0.3)), at, friction=0.4)


def shots() -> list[Shot]:
    """All pictures, in the order of docs/actions.md."""
    return [*velocities(), *forces(), *disturbances(), *placings(), *starts()]


def velocities() -> list[Shot]:
    """What sets a velocity or a spin."""
    target = ball("other", (0.9, DISTANCE + 0.4, 0.15))
    return [
        Shot(
            "set-velocity",
            "velocity (2.2, 0, 3) m/s",
            (SetVelocity(id="a", name="ball", velocity=(2.2, 0, 3)),),
            (ball(),),
            seconds=1.0,
            arrows=((0, (0.5, 0, 0.68)),),
        ),
        Shot(
            "set-velocity-toward",
            "2.5 m/s toward the other ball",
            (SetVelocity(id="a", name="ball", velocity=Directed(magnitude=2.5, toward="other")),),
            (ball(), target),
        ),
        Shot(
            "set-angular-velocity",
            "spin 25 rad/s about +y, held for 40 steps: friction drives it off",
            (SetAngularVelocity(id="a", name="ball", angular_velocity=(0, 25, 0), duration=40),),
            (ball(),),
        ),
    ]


def forces() -> list[Shot]:
    """What pushes and turns."""
    high = (-1.2, DISTANCE, 1.0)
    return [
        Shot(
            "apply-force",
            "force on the centre of mass, 30 steps",
            (
                ApplyForce(
                    id="a",
                    name="box",
                    force=Directed(magnitude=3, direction="right", quantity="target_speed"),
                    duration=30,
                ),
            ),
            (box(),),
            arrows=((0, (0.6, 0, 0)),),
        ),
        Shot(
            "apply-force-point",
            "the same push at the top edge tips it over",
            (ApplyForce(id="a", name="box", force=(110, 0, 0), point=(0, 0, 0.25), duration=16),),
            (thing("box", Box(size=(0.2, 0.3, 0.55)), (-0.6, DISTANCE, 0.275), friction=0.9),),
            arrows=((0, (0.5, 0, 0)),),
            every=15,
        ),
        Shot(
            "apply-torque",
            "torque about +y, 10 steps, without gravity",
            (
                SetVelocity(id="v", name="box", velocity=(1.9, 0, 0)),
                ApplyTorque(id="a", name="box", torque=(0, 9, 0), duration=10),
            ),
            (box(at=high),),
            gravity=STILL,
        ),
        Shot(
            "apply-angled-force",
            "force at 90° to the velocity: the path bends, the speed stays",
            (
                SetVelocity(id="v", name="ball", velocity=(2.2, 0, 0)),
                ApplyAngledForce(id="a", name="ball", magnitude=16, angle=90, duration=120),
            ),
            (thing("ball", Sphere(radius=0.15), (-1.4, DISTANCE - 1, 0.5)),),
            gravity=STILL,
        ),
    ]


def placings() -> list[Shot]:
    """What places, turns or holds."""
    return [
        Shot(
            "set-position",
            "placed at step 40, at rest again",
            (
                SetVelocity(id="v", name="ball", velocity=(1.2, 0, 0)),
                SetPosition(id="a", name="ball", position=(0.9, DISTANCE, 1.1), start_step=40),
            ),
            (ball(),),
            seconds=1.0,
            every=8,
        ),
        Shot(
            "set-orientation",
            "turned by 50° at step 40",
            (
                SetVelocity(id="v", name="box", velocity=(1.5, 0, 3.2)),
                SetOrientation(
                    id="a", name="box", rotation=about_axis((0, 1, 0), 0.87), start_step=40
                ),
            ),
            (box(),),
            seconds=0.9,
            every=10,
        ),
        Shot(
            "fix-object",
            "held in the air for steps 25 … 54, then dropped",
            (
                SetVelocity(id="v", name="box", velocity=(2.2, 0, 3)),
                FixObject(id="a", name="box", start_step=25, duration=30),
            ),
            (box(),),
            seconds=1.1,
            every=8,
        ),
        Shot(
            "fix-object-point",
            "held by a point, it swings",
            (FixObject(id="a", name="rod", point=(-0.45, 0, 0), duration=60),),
            (thing("rod", Box(size=(0.9, 0.06, 0.06)), (0.2, DISTANCE, 1.3)),),
            seconds=0.6,
            every=6,
        ),
    ]


def starts() -> list[Shot]:
    """What waits for something to happen."""
    return [
        Shot(
            "on-contact",
            "starts when the two touch",
            (
                SetVelocity(id="v", name="ball", velocity=(2.5, 0, 0)),
                SetVelocity(
                    id="a", name="box", velocity=(0.6, 0, 3), when=OnContact(a="ball", b="box")
                ),
            ),
            (ball(), box(at=(0.2, DISTANCE, 0.15))),
            seconds=1.1,
        ),
    ]


def disturbances() -> list[Shot]:
    """One picture for each model of ApplyDisturbance."""
    found = []
    for model, amplitude, text in (
        ("wind", 9.0, "air of 9 m/s; the ball is light"),
        ("gust", 40.0, "a force that swells and ebbs"),
        ("bump", 260.0, "a short push upwards"),
        ("side", 60.0, "to and fro"),
        ("shake", 90.0, "a sine on each axis"),
        ("jitter", 120.0, "seeded noise on each axis"),
    ):
        light = model == "wind"
        size = 0.25 if light else 0.15
        density = 3.0 if light else 500.0
        start = (-1.2 if model in ("wind", "gust") else 0.0, DISTANCE, size)
        item = thing("ball", Sphere(radius=size), start, density=density, friction=0.6)
        fields = {"id": "a", "name": "ball", "seed": 3, "duration": 20 if model == "bump" else 100}
        action = ApplyDisturbance.model_validate({**fields, "model": model, "amplitude": amplitude})
        found.append(Shot(f"apply-disturbance-{model}", f"{model}: {text}", (action,), (item,)))
    return found


def draw(shot: Shot) -> Picture:
    """The strobe picture of a shot, RGB."""
    clip = program(
        shot.objects,
        [ground(friction=0.6, restitution=0.3)],
        shot.actions,
        gravity=shot.gravity,
        seconds=shot.seconds,
    )
    rollout = simulate(clip)
    width, height = SIZE
    canvas = np.full((height * SCALE, width * SCALE, 3), PAPER, np.uint8)
    _floor(canvas)
    for index in range(len(shot.objects)):
        _path(canvas, rollout, index)
    steps = list(range(0, rollout.steps + 1, shot.every))
    for number, step in enumerate(steps):
        strength = 0.25 + 0.75 * number / max(len(steps) - 1, 1)
        order = np.argsort(-rollout.positions[step, :, 1])
        for index in order.tolist():
            color = BODY if index == 0 else OTHER
            _body(canvas, shot.objects[index], rollout, step, index, color, strength)
    for step, vector in shot.arrows:
        _arrow(canvas, rollout.positions[step, 0], np.array(vector))
    small = cv2.resize(canvas, SIZE, interpolation=cv2.INTER_AREA)
    cv2.putText(
        small, shot.caption, (12, height - 12), cv2.FONT_HERSHEY_SIMPLEX, 0.45, INK, 1, cv2.LINE_AA
    )
    return np.asarray(small, np.uint8)


def _pixels(points: NDArray[np.float64]) -> NDArray[np.int32]:
    return np.round(CAMERA.project(points)[0] * SCALE).astype(np.int32)


def _floor(canvas: Picture) -> None:
    corners = np.array([[-9, 2.2, 0], [9, 2.2, 0], [9, 40, 0], [-9, 40, 0]], float)
    cv2.fillPoly(canvas, [_pixels(corners)], FLOOR)
    for x in np.arange(-8, 8.5, 0.5).tolist():
        ends = _pixels(np.array([[x, 2.2, 0], [x, 40, 0]]))
        cv2.line(canvas, ends[0].tolist(), ends[1].tolist(), LINE, 1, cv2.LINE_AA)
    for y in np.arange(2.5, 12, 0.5).tolist():
        ends = _pixels(np.array([[-9, y, 0], [9, y, 0]]))
        cv2.line(canvas, ends[0].tolist(), ends[1].tolist(), LINE, 1, cv2.LINE_AA)


def _path(canvas: Picture, rollout: Rollout, index: int) -> None:
    points = _pixels(rollout.positions[:, index])
    cv2.polylines(canvas, [points], False, PATH, 2 * SCALE, cv2.LINE_AA)


def _body(
    canvas: Picture,
    item: SceneObject,
    rollout: Rollout,
    step: int,
    index: int,
    color: tuple[int, int, int],
    strength: float,
) -> None:
    """One faded, shaded body with its shadow on the floor."""
    vertices, faces = _surface(item)
    turn = matrix_of(rollout.rotations[step, index].tolist())
    points = vertices @ turn.T + rollout.positions[step, index]
    layer = canvas.copy()
    shadow = cv2.convexHull(_pixels(points * [1, 1, 0]))
    cv2.fillPoly(layer, [shadow], (170, 168, 165))
    canvas[:] = cv2.addWeighted(layer, 0.4 * strength, canvas, 1 - 0.4 * strength, 0)
    layer = canvas.copy()
    a, b, c = (points[faces[:, corner]] for corner in range(3))
    normal = np.cross(b - a, c - a)
    normal /= np.maximum(np.linalg.norm(normal, axis=1, keepdims=True), 1e-12)
    light = np.clip(normal @ np.array([-0.4, -0.5, 0.77]), 0, 1)
    seen = np.einsum("ij,ij->i", normal, a - np.array(CAMERA.position)) < 0
    for face in np.flatnonzero(seen):
        shade = np.array(color) * (0.55 + 0.45 * light[face])
        cv2.fillConvexPoly(layer, _pixels(points[faces[face]]), shade.tolist(), cv2.LINE_AA)
    canvas[:] = cv2.addWeighted(layer, strength, canvas, 1 - strength, 0)


def _surface(item: SceneObject) -> Surface:
    if isinstance(item.shape, Box):
        return box_surface(item.shape.size)
    assert isinstance(item.shape, Sphere)
    radius = item.shape.radius
    return ellipsoid_surface((radius, radius, radius))


def _arrow(canvas: Picture, start: NDArray[np.float64], vector: NDArray[np.float64]) -> None:
    ends = _pixels(np.stack([start, start + vector]))
    cv2.arrowedLine(
        canvas, ends[0].tolist(), ends[1].tolist(), MARK, 3 * SCALE, cv2.LINE_AA, tipLength=0.2
    )


def main() -> None:
    """Draws all pictures into a folder."""
    here = Path(__file__).parent / "images" / "actions"
    folder = Path(sys.argv[1]) if len(sys.argv) > 1 else here
    folder.mkdir(parents=True, exist_ok=True)
    for shot in shots():
        picture = cv2.cvtColor(draw(shot), cv2.COLOR_RGB2BGR)
        cv2.imwrite(str(folder / f"{shot.name}.png"), picture, [cv2.IMWRITE_PNG_COMPRESSION, 9])


if __name__ == "__main__":
    main()
