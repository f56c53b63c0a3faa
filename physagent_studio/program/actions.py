"""The nine operators of an event program, with the paper's names and arguments.

A step is the program's control step (`Clip.step_seconds`). An action with `start_step` s and
`duration` n acts on the steps s, …, s + n − 1. Vectors are plain world-frame triples or a
`Directed` description that is resolved when the action acts.
"""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import Field, Tag, model_validator

from physagent_studio.program.base import (
    AngularVelocity,
    Degrees,
    Direction,
    Force,
    Frozen,
    Name,
    Newtons,
    Position,
    Quaternion,
    Step,
    Torque,
    Velocity,
    by_form,
)
from physagent_studio.program.contract import Leaf

Duration = Annotated[int, Field(ge=1, le=100_000)]
Magnitude = Annotated[float, Field(ge=-1e7, le=1e7)]

Aim = Annotated[
    Annotated[Name, Tag("word")] | Annotated[Position, Tag("list")],
    by_form("a name, or a point [x, y, z]"),
]
Side = Annotated[
    Annotated[Direction, Tag("word")] | Annotated[Position, Tag("list")],
    by_form("left, right, up, down, away, toward_camera, or a vector [x, y, z]"),
]
_VECTOR = by_form("three numbers [x, y, z], or {magnitude: …, direction | toward | along: …}")


class Directed(Frozen):
    """A vector by meaning: a magnitude and where it points.

    Exactly one of: `toward` (an object, support or landmark by name, or a world point),
    `direction` (a named world direction), `along` (the target's current velocity, or against).
    `horizontal` drops the vertical part of `toward`. `elevation` raises it above the horizon,
    `azimuth` turns it about +z (counter-clockwise from above); both in degrees.
    `quantity`: the magnitude is the quantity itself (N, m/s, …), or for forces an acceleration in
    m/s² (times the mass), or the target speed in m/s that the whole duration shall give.
    """

    magnitude: Magnitude
    toward: Aim | None = None
    direction: Direction | None = None
    along: Literal["velocity", "against_velocity"] | None = None
    horizontal: bool = True
    elevation: Degrees = 0.0
    azimuth: Degrees = 0.0
    quantity: Literal["value", "acceleration", "target_speed"] = "value"

    @model_validator(mode="after")
    def _one_meaning(self) -> Directed:
        if sum(part is not None for part in (self.toward, self.direction, self.along)) != 1:
            raise ValueError("give exactly one of toward, direction, along")
        return self


_Described = Annotated[Directed, Tag("mapping")]
VelocityVector = Annotated[Annotated[Velocity, Tag("list")] | _Described, _VECTOR]
AngularVelocityVector = Annotated[Annotated[AngularVelocity, Tag("list")] | _Described, _VECTOR]
ForceVector = Annotated[Annotated[Force, Tag("list")] | _Described, _VECTOR]
TorqueVector = Annotated[Annotated[Torque, Tag("list")] | _Described, _VECTOR]


class OnContact(Frozen):
    """Starts `delay` steps after a and b first touch; at `timeout` at the latest never starts."""

    kind: Literal["on_contact"] = "on_contact"
    a: Name
    b: Name
    delay: Step = 0
    timeout: Step | None = None


class After(Frozen):
    """Starts `delay` steps after the action of that id has ended."""

    kind: Literal["after"] = "after"
    action: Name
    delay: Step = 0
    timeout: Step | None = None


class When(Frozen):
    """Starts `delay` steps after `statement` first holds of what has happened so far.

    The statement is measured as in a contract, with "at the end" meaning now; it is looked at
    once a frame. Its window and `negated` count as everywhere.
    """

    kind: Literal["when"] = "when"
    statement: Leaf
    delay: Step = 0
    timeout: Step | None = None


Condition = Annotated[OnContact | After | When, Field(discriminator="kind")]


class _Action(Frozen):
    """What all operators share. `name` is the target object; `when` replaces `start_step`."""

    id: Name
    name: Name
    start_step: Step = 0
    when: Condition | None = None
    muted: bool = False


class SetVelocity(_Action):
    """Assigns the linear velocity of the centre of mass, m/s, once."""

    operator: Literal["SetVelocity"] = "SetVelocity"
    velocity: VelocityVector


class SetAngularVelocity(_Action):
    """Sets the angular velocity, world frame, rad/s, and holds it for the duration."""

    operator: Literal["SetAngularVelocity"] = "SetAngularVelocity"
    angular_velocity: AngularVelocityVector
    duration: Duration = 1


class ApplyForce(_Action):
    """A force in N at the centre of mass, or at `point`, in `point_frame`, m."""

    operator: Literal["ApplyForce"] = "ApplyForce"
    force: ForceVector
    point: Position | None = None
    point_frame: Literal["body", "world"] = "body"
    duration: Duration


class ApplyTorque(_Action):
    """A torque in N·m, world frame."""

    operator: Literal["ApplyTorque"] = "ApplyTorque"
    torque: TorqueVector
    duration: Duration


class ApplyAngledForce(_Action):
    """A horizontal force at `angle` degrees (counter-clockwise from above) to the velocity.

    At rest the direction is +x, as in the peers. The direction follows the velocity each step.
    """

    operator: Literal["ApplyAngledForce"] = "ApplyAngledForce"
    magnitude: Newtons
    angle: Degrees
    duration: Duration


class ApplyDisturbance(_Action):
    """A perturbation with a closed form of time and seed.

    amplitude: N for gust, bump, side, shake, jitter; m/s of air for wind. frequency: Hz.
    """

    operator: Literal["ApplyDisturbance"] = "ApplyDisturbance"
    model: Literal["wind", "gust", "bump", "side", "shake", "jitter"]
    amplitude: Annotated[float, Field(ge=0, le=1e6)]
    direction: Side | None = None
    frequency: Annotated[float, Field(gt=0, le=50)] | None = None
    seed: Annotated[int, Field(ge=0, le=2**31 - 1)] = 0
    duration: Duration


class SetPosition(_Action):
    """Places the centre of mass, world frame, m; the velocity becomes zero."""

    operator: Literal["SetPosition"] = "SetPosition"
    position: Position


class SetOrientation(_Action):
    """Turns the object to R_world_body (wxyz); the velocity becomes zero."""

    operator: Literal["SetOrientation"] = "SetOrientation"
    rotation: Quaternion


class FixObject(_Action):
    """Holds the object in the pose it has when the action begins.

    With `point`, in `point_frame`, m, it holds only that point: the object may turn about it
    and hangs or swings from it.
    """

    operator: Literal["FixObject"] = "FixObject"
    point: Position | None = None
    point_frame: Literal["body", "world"] = "body"
    duration: Duration


Action = Annotated[
    SetVelocity
    | SetAngularVelocity
    | ApplyForce
    | ApplyTorque
    | ApplyAngledForce
    | ApplyDisturbance
    | SetPosition
    | SetOrientation
    | FixObject,
    Field(discriminator="operator"),
]


def duration_of(action: Action) -> int:
    """Steps on which the action acts; operators that act once have 1."""
    return getattr(action, "duration", 1)
