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
from physagent_studio.program.statements import Leaf

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
    """Starts `delay` steps after the step on which a and b first touch.

    If it has not started by step `timeout` it never does. What happens during a step is answered
    on the next, so the earliest start is one step after the contact.
    """

    kind: Literal["on_contact"] = "on_contact"
    a: Name
    b: Name
    delay: Step = 0
    timeout: Step | None = None


class After(Frozen):
    """Starts `delay` steps after the action of that id has ended; never where that never starts.

    If it has not started by step `timeout` it never does.
    """

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
    """What all operators share. `name` is the target object; `when` replaces `start_step`.

    A muted action does nothing. A plain window must lie inside the clip; one that a condition
    opens late is cut off at the clip's end.
    """

    id: Name
    name: Name
    start_step: Step = 0
    when: Condition | None = None
    muted: bool = False


class SetVelocity(_Action):
    """Assigns the linear velocity of the centre of mass, world frame, m/s, once.

    It replaces the velocity, all three parts of it, at the beginning of its step; the angular
    velocity stays.
    """

    operator: Literal["SetVelocity"] = "SetVelocity"
    velocity: VelocityVector


class SetAngularVelocity(_Action):
    """Sets the angular velocity, world frame, rad/s, and holds it for the duration.

    The linear velocity stays free. Afterwards the body turns on freely. The peers set it once,
    whatever the duration.
    """

    operator: Literal["SetAngularVelocity"] = "SetAngularVelocity"
    angular_velocity: AngularVelocityVector
    duration: Duration = 1


class ApplyForce(_Action):
    """A force in N, world frame, at the centre of mass or at `point`, m.

    A point in the body frame travels and turns with the body; one in the world frame stays where
    it is given. A force off the centre of mass also turns the body. It acts on each of its steps
    and ends with the last.
    """

    operator: Literal["ApplyForce"] = "ApplyForce"
    force: ForceVector
    point: Position | None = None
    point_frame: Literal["body", "world"] = "body"
    duration: Duration


class ApplyTorque(_Action):
    """A torque in N·m about the centre of mass, world frame, on each of its steps."""

    operator: Literal["ApplyTorque"] = "ApplyTorque"
    torque: TorqueVector
    duration: Duration


class ApplyAngledForce(_Action):
    """A horizontal force in N at `angle` degrees (counter-clockwise from above) to the velocity.

    0 speeds up, 180 brakes, 90 bends the path to the left, −90 to the right. At rest the
    direction is +x, as in the peers. The direction follows the velocity within every step, so at
    90 the speed stays what it is.
    """

    operator: Literal["ApplyAngledForce"] = "ApplyAngledForce"
    magnitude: Newtons
    angle: Degrees
    duration: Duration


class ApplyDisturbance(_Action):
    """A perturbation at the centre of mass with a closed form of time and seed.

    wind: drag of air that moves with `amplitude` m/s along `direction`, by the body's silhouette;
    with a `frequency` it comes in gusts, from calm to `amplitude` and back.
    gust: a force that swells and ebbs once over the duration. bump: a short push, up by default.
    side: to and fro along `direction`. shake: a sine on each axis. jitter: seeded noise on each
    axis. amplitude: N but for wind. frequency: Hz, for wind, side, shake and jitter. The
    direction is right, +x, if none is given.
    """

    operator: Literal["ApplyDisturbance"] = "ApplyDisturbance"
    model: Literal["wind", "gust", "bump", "side", "shake", "jitter"]
    amplitude: Annotated[float, Field(ge=0, le=1e6)]
    direction: Side | None = None
    frequency: Annotated[float, Field(gt=0, le=50)] | None = None
    seed: Annotated[int, Field(ge=0, le=2**31 - 1)] = 0
    duration: Duration


class SetPosition(_Action):
    """Places the centre of mass, world frame, m; linear and angular velocity become zero.

    Placed inside another body it is pushed out; preflight does not see that.
    """

    operator: Literal["SetPosition"] = "SetPosition"
    position: Position


class SetOrientation(_Action):
    """Turns the object about its centre of mass to R_world_body (wxyz).

    Linear and angular velocity become zero.
    """

    operator: Literal["SetOrientation"] = "SetOrientation"
    rotation: Quaternion


class FixObject(_Action):
    """Holds the object in the pose, orientation too, that it has when the action begins.

    Nothing moves it meanwhile; released, it starts from rest. The peers put it back to where the
    clip began. With `point`, in `point_frame`, m, it holds only that point: the object may turn
    about it and hangs or swings from it.
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
