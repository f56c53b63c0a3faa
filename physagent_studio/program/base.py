"""Building blocks of every program model: immutable, closed and bounded.

SI units. World frame right-handed, +x right in the image, +y away from the camera, +z up;
quaternions (w, x, y, z). No value is NaN or infinite, none is unbounded.
"""

import math
from collections.abc import Collection
from itertools import chain, count
from typing import Annotated, Any, Literal

from pydantic import AfterValidator, BaseModel, ConfigDict, Discriminator, Field, StringConstraints


class Frozen(BaseModel):
    """Base of all program values: frozen, no unknown fields, finite numbers."""

    model_config = ConfigDict(
        frozen=True, extra="forbid", allow_inf_nan=False, validate_default=True
    )


Name = Annotated[str, StringConstraints(pattern=r"^[A-Za-z0-9_][A-Za-z0-9_\-]{0,63}$")]
Text = Annotated[str, StringConstraints(max_length=4000)]

Metres = Annotated[float, Field(ge=-1e4, le=1e4)]
Length = Annotated[float, Field(gt=0, le=1e4)]
Speed = Annotated[float, Field(ge=-500, le=500)]
AngularSpeed = Annotated[float, Field(ge=-1000, le=1000)]
Newtons = Annotated[float, Field(ge=-1e7, le=1e7)]
NewtonMetres = Annotated[float, Field(ge=-1e7, le=1e7)]
Degrees = Annotated[float, Field(ge=-360, le=360)]
Tilt = Annotated[float, Field(ge=-45, le=45)]
Pixels = Annotated[float, Field(ge=-1e5, le=1e5)]

Step = Annotated[int, Field(ge=0, le=100_000)]
Direction = Literal["left", "right", "up", "down", "away", "toward_camera"]
DIRECTIONS: dict[Direction, tuple[float, float, float]] = {
    "left": (-1.0, 0.0, 0.0), "right": (1.0, 0.0, 0.0), "up": (0.0, 0.0, 1.0),
    "down": (0.0, 0.0, -1.0), "away": (0.0, 1.0, 0.0), "toward_camera": (0.0, -1.0, 0.0),
}  # fmt: skip
"""What the words mean in the world."""

Position = tuple[Metres, Metres, Metres]
Velocity = tuple[Speed, Speed, Speed]
AngularVelocity = tuple[AngularSpeed, AngularSpeed, AngularSpeed]
Force = tuple[Newtons, Newtons, Newtons]
Torque = tuple[NewtonMetres, NewtonMetres, NewtonMetres]
Size = tuple[Length, Length, Length]
Pixel = tuple[Pixels, Pixels]

Source = Literal["given", "estimated", "assumed", "person"]
"""Where a number came from: stated by the case, measured in the picture, a default, a person."""


def free_name(wanted: str, taken: Collection[str]) -> str:
    """The name that was wanted, with the first number behind it that makes it a new one."""
    numbered = (f"{wanted[:57]}_{number}" for number in count(2))
    return next(name for name in chain([wanted[:60]], numbered) if name not in taken)


def overlap(path: str, other: str) -> bool:
    """Whether one path of a program is the other, or lies in it."""
    return f"{path}.".startswith(f"{other}.") or f"{other}.".startswith(f"{path}.")


def _unit(value: tuple[float, float, float, float]) -> tuple[float, float, float, float]:
    norm = math.sqrt(sum(part * part for part in value))
    if norm < 1e-6:
        raise ValueError("a rotation needs a quaternion (w, x, y, z) that is not zero")
    if abs(norm - 1) < 1e-12:
        return value
    w, x, y, z = (part / norm for part in value)
    return (w, x, y, z)


_Unit = Annotated[float, Field(ge=-1e6, le=1e6)]
Quaternion = Annotated[tuple[_Unit, _Unit, _Unit, _Unit], AfterValidator(_unit)]
IDENTITY: tuple[float, float, float, float] = (1.0, 0.0, 0.0, 0.0)


def _form(value: Any) -> str | None:
    """Which form a value is written in: "word", "list" or "mapping"."""
    if isinstance(value, str):
        return "word"
    if isinstance(value, list | tuple):
        return "list"
    return "mapping" if isinstance(value, dict | BaseModel) else None


def by_form(allowed: str) -> Discriminator:
    """Chooses the branch of a union by the form in which its value is written.

    The branches carry `Tag("word")`, `Tag("list")` or `Tag("mapping")`; an error is then told
    for the branch that was meant, and `allowed` where none was.
    """
    return Discriminator(
        _form,
        custom_error_type="form",
        custom_error_message=f"must be {allowed}",
    )
