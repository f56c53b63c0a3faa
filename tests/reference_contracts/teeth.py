"""Programs that do not make an event: what a reference contract has to reject."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from physagent_studio.program import PhysicalProgram
from physagent_studio.program.actions import (
    Action,
    ApplyForce,
    Directed,
    FixObject,
    SetVelocity,
)
from physagent_studio.simulation import simulate

MIRROR = {
    "left": "right", "right": "left", "away": "toward_camera", "toward_camera": "away",
    "up": "up", "down": "down",
}  # fmt: skip


def acting(program: PhysicalProgram, actions: tuple[Action, ...]) -> PhysicalProgram:
    event = program.event.model_copy(update={"actions": actions})
    return PhysicalProgram.model_validate({**program.model_dump(), "event": event.model_dump()})


def undone(program: PhysicalProgram) -> PhysicalProgram:
    """No action; where things then move all the same, they are held as they stood."""
    empty = acting(program, ())
    run = simulate(empty, {})
    if np.abs(run.positions - run.positions[0]).max() < 0.02:
        return empty
    held = tuple(
        FixObject(id=f"hold_{o.name}"[:64], name=o.name, duration=program.clip.steps)
        for o in program.scene.objects
    )
    return acting(program, held)


def mirrored(program: PhysicalProgram) -> PhysicalProgram | None:
    """Every horizontal direction turned round; None where none is given."""
    found = [_mirrored(action) for action in program.event.actions]
    changed = any(new is not old for new, old in zip(found, program.event.actions, strict=True))
    return acting(program, tuple(found)) if changed else None


def _mirrored(action: Action) -> Action:
    for field in ("force", "velocity"):
        vector = getattr(action, field, None)
        if isinstance(vector, Directed) and vector.direction not in ("up", "down"):
            if vector.toward is not None:
                turned = vector.model_copy(update={"azimuth": (vector.azimuth + 360) % 360 - 180})
            elif vector.direction is not None:
                turned = vector.model_copy(update={"direction": MIRROR[vector.direction]})
            else:
                continue
            return action.model_copy(update={field: turned})
    return action


def misplaced(program: PhysicalProgram) -> Iterator[PhysicalProgram]:
    """The same motions of each object that they do not move; what is held at first is held."""
    actions = program.event.actions
    driven = {action.name for action in actions if not isinstance(action, FixObject)}
    for item in program.scene.objects:
        if driven and item.name not in driven:
            moved = tuple(
                a if isinstance(a, FixObject) else a.model_copy(update={"name": item.name})
                for a in actions
            )
            yield acting(program, moved)


def random_program(program: PhysicalProgram, seed: int) -> PhysicalProgram:
    """One to three actions of random kind, target, direction, strength and time."""
    rng = np.random.default_rng(seed)
    names = [item.name for item in program.scene.objects]
    actions: list[Action] = []
    for number in range(int(rng.integers(1, 4))):
        way = str(rng.choice(["left", "right", "up", "away", "toward_camera"]))
        start, length = int(rng.integers(0, 200)), int(rng.integers(2, 60))
        name = str(rng.choice(names))
        speed = float(rng.uniform(0.2, 6.0))
        vector = Directed.model_validate(
            {"magnitude": speed, "direction": way, "quantity": "target_speed"}
        )
        if rng.random() < 0.5:
            action: Action = ApplyForce(
                id=f"a{number}", name=name, start_step=start, duration=length, force=vector
            )
        else:
            plain = vector.model_copy(update={"quantity": "value"})
            action = SetVelocity(id=f"a{number}", name=name, start_step=start, velocity=plain)
        actions.append(action)
    return acting(program, tuple(actions))


def way_of(action: Action) -> str | None:
    vector = getattr(action, "force", None) or getattr(action, "velocity", None)
    return vector.direction if isinstance(vector, Directed) else None


def held_until_pushed(program: PhysicalProgram) -> PhysicalProgram:
    """Everything stays as it stood until an action is on it; what hangs, hangs."""
    actions = program.event.actions
    holds = []
    for item in program.scene.objects:
        mine = [a.start_step for a in actions if a.name == item.name]
        steps = min(mine, default=program.clip.steps)
        if steps > 0:
            holds.append(FixObject(id=f"hold_{item.name}"[:64], name=item.name, duration=steps))
    return acting(program, (*actions, *holds))
