"""A small world for the loop: one ball on a floor, exact motion in closed form, tiny pictures.

Nothing here knows of language models; it is the `Bench` that the loop asks for, light enough to
run hundreds of rounds.
"""

from __future__ import annotations

from types import MappingProxyType

import numpy as np

from physagent_studio.agent.crew import Bench
from physagent_studio.contract import measure
from physagent_studio.errors import SimulationError
from physagent_studio.program import (
    Camera,
    Click,
    Grounding,
    PhysicalProgram,
    SceneState,
)
from physagent_studio.program.scene.state import Floor, Sphere
from physagent_studio.records import CONTACT_DTYPE, ActionSpan, Case, Image, Rollout, Scene

SENTENCE = "The red ball rolls two metres to the right."
RADIUS = 0.1
DECELERATION = 1.0
PHOTO = np.full((48, 64, 3), 120, np.uint8)

CASE = Case(
    name="ball",
    image=PHOTO,
    image_hash="0" * 64,
    objects=(("ball", Grounding(points=(Click(x=20, y=30),))),),
    supports=(),
    landmarks=(),
    prompt=SENTENCE,
)
CAMERA = Camera.from_horizon((64, 48), 10.0, 0.5)


def reconstruct(state: SceneState, previous: Scene | None = None) -> Scene:
    """Fills what is open: every ball is a sphere on the floor, a metre to the right of the last.

    The first stands far enough left that two metres to the right are in the picture.
    """
    objects = tuple(
        item.model_copy(
            update={
                "shape": item.shape or Sphere(radius=RADIUS),
                "position": item.position or (index - 1.0, 3.0, RADIUS),
                "support": item.support or "floor",
            }
        )
        for index, item in enumerate(state.objects)
    )
    supports = tuple(
        item.model_copy(update={"shape": item.shape or Floor()}) for item in state.supports
    )
    done = state.model_copy(
        update={"objects": objects, "supports": supports, "camera": state.camera or CAMERA}
    )
    empty = MappingProxyType({})
    return Scene(done, PHOTO, PHOTO, empty, empty, empty, empty, (), "hash")


def simulate(program: PhysicalProgram, scene: Scene) -> Rollout:
    """The first action's horizontal speed along x, slowed evenly until it rests."""
    clip, objects = program.clip, program.scene.objects
    if not objects:
        raise SimulationError("there is nothing to simulate")
    rows, count = clip.steps + 1, len(objects)
    seconds = np.arange(rows) * clip.step_seconds
    positions = np.array([[item.position for item in objects]] * rows, float)
    velocities = np.zeros((rows, count, 3))
    spans = []
    for action in program.event.actions:
        speed = _speed(action)
        index = [item.name for item in objects].index(action.name)
        begin = action.start_step * clip.step_seconds
        time = np.clip(seconds - begin, 0, abs(speed) / DECELERATION)
        sign = np.sign(speed)
        positions[:, index, 0] += speed * time - sign * DECELERATION * time**2 / 2
        velocities[:, index, 0] = (speed - sign * DECELERATION * time) * (seconds >= begin)
        spans.append(ActionSpan(action.id, action.start_step, action.start_step + 1, 1.0))
    rotations = np.zeros((rows, count, 4))
    rotations[..., 0] = 1
    names = tuple(item.name for item in objects)
    contacts = np.zeros(rows * count, CONTACT_DTYPE)
    contacts["step"] = np.repeat(np.arange(rows), count)
    contacts["a"] = np.tile(np.arange(count), rows)
    contacts["b"] = count
    contacts["normal"] = (0, 0, -1)
    contacts["impulse"] = 0.1
    contacts["point"] = positions.reshape(-1, 3) - (0, 0, RADIUS)
    return Rollout(
        program_hash=program.hash,
        objects=names,
        bodies=(*names, *(item.name for item in program.scene.supports)),
        step_seconds=clip.step_seconds,
        steps_per_frame=clip.steps_per_frame,
        frames=clip.frames,
        positions=positions,
        rotations=rotations,
        velocities=velocities,
        angular=np.zeros((rows, count, 3)),
        contacts=contacts,
        kinetic=(velocities**2).sum(-1) / 2,
        potential=np.zeros((rows, count)),
        masses=np.ones(count),
        penetration=np.zeros(rows),
        spans=tuple(spans),
        warnings=(),
        versions=(),
    )


def _speed(action: object) -> float:
    velocity = getattr(action, "velocity", None)
    if velocity is None:
        return 0.0
    if isinstance(velocity, tuple):
        return float(velocity[0])
    return float(velocity.magnitude) * (-1 if velocity.direction == "left" else 1)


def bench() -> Bench:
    """A bench that keeps everything in memory."""
    scenes: dict[str, Scene] = {}
    rollouts: dict[str, Rollout] = {}

    def put_scene(scene: Scene) -> str:
        scenes[f"s{len(scenes)}"] = scene
        return f"s{len(scenes) - 1}"

    def put_rollout(rollout: Rollout) -> str:
        rollouts[f"x{len(rollouts)}"] = rollout
        return f"x{len(rollouts) - 1}"

    def frames(scene: Scene, rollout: Rollout) -> tuple[Image, ...]:
        return tuple(PHOTO for _ in range(0, rollout.frames, 3))

    return Bench(
        case=CASE,
        reconstruct=reconstruct,
        simulate=simulate,
        measure=lambda program, rollout, scene: measure(program, rollout),
        view=lambda scene: PHOTO,
        evidence=frames,
        put_scene=put_scene,
        get_scene=scenes.__getitem__,
        put_rollout=put_rollout,
        get_rollout=rollouts.__getitem__,
        put_frames=lambda pictures: "f",
    )
