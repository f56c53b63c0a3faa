"""Short makers of actions, so that a script reads as what it does."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from physagent_studio.agent.rules.scene import mechanics as mech
from physagent_studio.agent.rules.scene.measures import UP, FloatArray, Layout
from physagent_studio.program.actions import (
    Action,
    After,
    ApplyAngledForce,
    ApplyDisturbance,
    ApplyForce,
    Condition,
    Directed,
    Direction,
    FixObject,
    OnContact,
    SetAngularVelocity,
)
from physagent_studio.program.base import Position
from physagent_studio.program.program import Clip
from physagent_studio.program.rotations import matrix_of


@dataclass(frozen=True, slots=True)
class StepSettings:
    """How long what scripts do takes."""

    push_steps: int = 12  # 4..40: of a push by hand
    kick_steps: int = 4  # 1..10: of a blow
    rise_steps: int = 80  # 40..160: in which a thing is raised that the photo shows on the ground
    hang_steps: int = 20  # 5..60: for which what falls is first seen where it hung
    first_step: int = 4  # steps, 0..20: one frame in, so that it is seen how things stood


STEPS = StepSettings()


def toward_or_along(
    magnitude: float,
    *,
    toward: str | None = None,
    way: Direction | None = None,
    vector: FloatArray | None = None,
    elevation: float = 0.0,
    azimuth: float = 0.0,
    quantity: str = "target_speed",
) -> Directed:
    """A semantic vector: to a thing, along a named direction, or along a world direction."""
    fields = {
        "magnitude": round(float(magnitude), 4),
        "elevation": round(float(elevation), 3),
        "quantity": quantity,
    }
    if toward is not None:
        return Directed.model_validate({**fields, "toward": toward, "azimuth": round(azimuth, 3)})
    if way is not None:
        return Directed.model_validate({**fields, "direction": way, "azimuth": round(azimuth, 3)})
    assert vector is not None
    turn = float(np.degrees(np.arctan2(vector[1], vector[0])))
    fields["azimuth"] = round(turn + azimuth, 3)
    return Directed.model_validate({**fields, "direction": "right"})


def against(deceleration: float) -> Directed:
    """A brake: so many m/s² against whichever way it goes."""
    return Directed(
        magnitude=round(deceleration, 4), along="against_velocity", quantity="acceleration"
    )


def push(
    name: str,
    force: Directed,
    *,
    start: int = STEPS.first_step,
    duration: int = STEPS.push_steps,
    when: Condition | None = None,
    point: Position | None = None,
    label: str = "push",
) -> ApplyForce:
    """A force for some steps."""
    return ApplyForce(
        id=f"{label}_{name}"[:64],
        name=name,
        start_step=start,
        when=when,
        force=force,
        point=point,
        duration=duration,
    )


def spin(
    name: str,
    axis: FloatArray,
    speed: float,
    *,
    start: int = STEPS.first_step,
    duration: int = 2,
    when: Condition | None = None,
    label: str = "spin",
) -> SetAngularVelocity:
    """A turn about a world axis (unit), rad/s."""
    x, y, z = (round(float(part * speed), 4) for part in axis)
    return SetAngularVelocity(
        id=f"{label}_{name}"[:64],
        name=name,
        start_step=start,
        when=when,
        angular_velocity=(x, y, z),
        duration=duration,
    )


def bend(name: str, force: float, angle: float, *, start: int, duration: int) -> ApplyAngledForce:
    """A force across the path."""
    return ApplyAngledForce(
        id=f"bend_{name}"[:64],
        name=name,
        start_step=start,
        magnitude=round(force, 4),
        angle=angle,
        duration=duration,
    )


def blow(
    name: str,
    model: str,
    amplitude: float,
    way: Direction,
    *,
    frequency: float | None,
    duration: int,
) -> ApplyDisturbance:
    """Wind on one object."""
    return ApplyDisturbance.model_validate(
        {
            "id": f"wind_{name}"[:64],
            "name": name,
            "model": model,
            "amplitude": round(amplitude, 3),
            "direction": way,
            "frequency": frequency,
            "duration": duration,
        }
    )


def hold(name: str, steps: int) -> FixObject:
    """Keeps it where it is for the first steps."""
    return FixObject(id=f"hold_{name}"[:64], name=name, start_step=0, duration=steps)


def raised(name: str, height: float) -> list[Action]:
    """Lifted from where it stands and at rest again after a while, so many m higher.

    Half of the time it gains speed, half of the time it loses it.
    """
    half = STEPS.rise_steps // 2
    gain = height / (half * Clip().step_seconds) ** 2
    return [
        push(
            name,
            toward_or_along(mech.G + share, way="up", quantity="acceleration"),
            start=STEPS.first_step + late,
            duration=half,
            label=label,
        )
        for share, late, label in ((gain, 0, "raise"), (-gain, half, "slow"))
    ]


def top_point(layout: Layout, name: str) -> Position:
    """The point on top of an object, above its centre, in its body frame."""
    return _in_body(layout, name, UP * 0.9 * layout.extent(name, UP))


def rear_top_point(layout: Layout, name: str, way: FloatArray) -> Position:
    """The point on top of an object at its edge opposite to a level way (3,), in its body frame."""
    behind = -way * 0.9 * layout.extent(name, -way)
    return _in_body(layout, name, behind + UP * 0.9 * layout.extent(name, UP))


def foot_point(layout: Layout, name: str) -> Position:
    """The point at an object's foot, below its centre, in its body frame: pushed there, it does
    not trip over what holds its foot back."""
    return _in_body(layout, name, -UP * layout.extent(name, -UP))


def _in_body(layout: Layout, name: str, offset: FloatArray) -> Position:
    """An offset from an object's centre (3,), world, m, as a point in its body frame."""
    item = layout.state.object(name)
    assert item is not None
    x, y, z = (round(float(part), 4) for part in matrix_of(item.rotation).T @ offset)
    return (x, y, z)


def on_contact(a: str, b: str, delay: int = 0) -> OnContact:
    """Starts when two bodies first touch."""
    return OnContact(a=a, b=b, delay=delay)


def after(action: Action, delay: int = 0) -> After:
    """Starts when another action has ended."""
    return After(action=action.id, delay=delay)


def later(action: Action, steps: int) -> Action:
    """The action so many steps later, where it waits for nothing else."""
    if not steps or action.when is not None:
        return action
    return action.model_copy(update={"start_step": action.start_step + steps})
