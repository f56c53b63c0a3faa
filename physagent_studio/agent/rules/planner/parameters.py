"""What can be turned in a program: one number each, with the factor it belongs to.

A knob reads its value from a program and makes the edits that set another one. Magnitudes and
material constants are searched by ratio, angles and steps by difference.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from functools import partial
from typing import Any

from physagent_studio.agent.rules.scene import mechanics as mech
from physagent_studio.program.actions import (
    Action,
    ApplyAngledForce,
    ApplyDisturbance,
    ApplyForce,
    Directed,
    SetVelocity,
    duration_of,
)
from physagent_studio.program.edits import Edit, SetField
from physagent_studio.program.preflight.mechanics import friction_between
from physagent_studio.program.program import PhysicalProgram
from physagent_studio.program.scene.materials import MATERIALS, density_of, touch_of
from physagent_studio.program.scene.state import SceneObject
from physagent_studio.program.timing import SLOWEST, retimed

VECTORS = {
    "SetVelocity": "velocity", "SetAngularVelocity": "angular_velocity", "ApplyForce": "force",
    "ApplyTorque": "torque",
}  # fmt: skip


@dataclass(frozen=True)
class Knob:
    """path: the field. target: the object it is about. by_ratio: whether it is scaled.

    low, high: bounds of the value. stride: first change tried (a ratio − 1, or a difference).
    write: the edits that set it, where its field does not hold the value as it is.
    """

    path: str
    factor: str
    target: str
    value: float
    low: float
    high: float
    stride: float
    by_ratio: bool = True
    write: Callable[[float], tuple[Edit, ...]] | None = None
    whole: bool = False

    def shifted(self, steps: float) -> float:
        """The value `steps` strides away, inside its bounds."""
        if self.by_ratio:
            value = self.value * math.exp(steps * math.log1p(self.stride))
        else:
            value = self.value + steps * self.stride
        value = min(max(value, self.low), self.high)
        return float(round(value)) if self.whole else value

    def distance(self, value: float) -> float:
        """How far a value is from the present one, in strides."""
        if self.by_ratio and self.value > 0 and value > 0:
            return abs(math.log(value / self.value)) / math.log1p(self.stride)
        return abs(value - self.value) / self.stride

    def edits(self, value: float) -> tuple[Edit, ...]:
        """The edits that set the value, rounded so that it can be read."""
        value = _readable(value, self.whole)
        return self.write(value) if self.write else (SetField(path=self.path, value=value),)


def _readable(value: float, whole: bool) -> float:
    if whole:
        return round(value)
    return float(f"{value:.5g}")


def action_knobs(program: PhysicalProgram) -> list[Knob]:
    """All knobs of the schedule."""
    found: list[Knob] = []
    # Wheels go along their axis, wherever they are pushed.
    wheeled = {item.name for item in program.scene.objects if item.wheels is not None}
    for action in program.event.actions:
        if not action.muted:
            aim = () if action.name in wheeled else _aim(action)
            found += [*_strength(action), *aim, *_timing(action, program)]
    return found


def time_knobs(program: PhysicalProgram) -> list[Knob]:
    """The clip's time factor, where something falls or is struck: slow motion, never faster."""
    now = program.clip.time_factor
    return [
        Knob(
            "clip.step_seconds", "pace", "", now, SLOWEST, max(now, 1.0), 0.4,
            write=lambda value: retimed(program, value),
        )
    ]  # fmt: skip


def _strength(action: Action) -> Iterable[Knob]:
    base = f"event.actions.{action.id}"
    if isinstance(action, ApplyAngledForce):
        yield _ratio(f"{base}.magnitude", "magnitude", action.name, action.magnitude)
        yield _angle(f"{base}.angle", "direction", action.name, action.angle)
    elif isinstance(action, ApplyDisturbance):
        yield _ratio(f"{base}.amplitude", "magnitude", action.name, action.amplitude)
    elif (vector := _vector(action)) is not None:
        path = f"{base}.{VECTORS[action.operator]}"
        if isinstance(vector, Directed):
            if _carries_weight(vector):
                return
            fastest = RANGE.max_speed_mps if vector.quantity == "target_speed" else math.inf
            yield _ratio(f"{path}.magnitude", "magnitude", action.name, vector.magnitude, fastest)
        else:
            yield _scaled_vector(path, action.name, vector)


def _carries_weight(vector: Directed) -> bool:
    """Whether it only balances gravity, as a hand does that holds a thing: that has no strength."""
    upward = vector.direction == "up" and vector.quantity == "acceleration"
    return upward and math.isclose(vector.magnitude, mech.G)


def _vector(action: Action) -> Directed | tuple[float, float, float] | None:
    return getattr(action, VECTORS.get(action.operator, ""), None)


def _aim(action: Action) -> Iterable[Knob]:
    vector = _vector(action)
    if vector is None:
        return
    path = f"event.actions.{action.id}.{VECTORS[action.operator]}"
    if not isinstance(vector, Directed):
        if isinstance(action, ApplyForce | SetVelocity) and math.hypot(vector[0], vector[1]) > 1e-9:
            yield _turned_vector(path, action.name, vector)
        return
    if vector.along is None and vector.direction not in ("up", "down"):
        yield _turned(f"{path}.azimuth", action.name, vector.azimuth)
        yield _angle(f"{path}.elevation", "elevation", action.name, vector.elevation, 85.0)


def way_knobs(program: PhysicalProgram, way: str) -> Iterable[tuple[Action, Any, Knob]]:
    """Actions that point another way than this level one: each with its own named one, "" where it
    has none, and a knob whose only value is to point that way."""
    wheeled = {item.name for item in program.scene.objects if item.wheels is not None}
    for action in program.event.actions:
        value: Any
        path, vector = f"event.actions.{action.id}", _vector(action)
        if isinstance(action, ApplyDisturbance):
            path, aside, value = f"{path}.direction", 0.0, way
            now = action.direction or "right"
        elif isinstance(vector, Directed) and vector.along is None and action.name not in wheeled:
            path, aside = f"{path}.{VECTORS[action.operator]}", vector.azimuth
            now = vector.direction or ""
            value = vector.model_dump(mode="json") | {
                "direction": way, "toward": None, "azimuth": 0.0,
            }  # fmt: skip
        else:
            continue
        if not action.muted and (now != way or aside):
            edits = (SetField(path=path, value=value),)
            yield (
                action,
                now,
                Knob(
                    path,
                    "direction",
                    action.name,
                    0.0,
                    1.0,
                    1.0,
                    1.0,
                    False,
                    partial(_always, edits),
                ),
            )


def _always(edits: tuple[Edit, ...], _: float) -> tuple[Edit, ...]:
    return edits


def _timing(action: Action, program: PhysicalProgram) -> Iterable[Knob]:
    base, steps = f"event.actions.{action.id}", program.clip.steps
    length = duration_of(action)
    if hasattr(action, "duration"):
        room = max(steps - action.start_step if action.when is None else steps, 1)
        path = f"{base}.duration"
        yield Knob(path, "duration", action.name, length, 1, room, 0.4, whole=True)
    if action.when is None:
        path, at, stride, latest = "start_step", action.start_step, 12.0, max(steps - length, 0)
    else:
        path, at, stride, latest = "when.delay", action.when.delay, 8.0, steps
    path = f"{base}.{path}"
    yield Knob(path, "timing", action.name, at, 0, latest, stride, by_ratio=False, whole=True)


@dataclass(frozen=True, slots=True)
class ParameterSettings:
    """How far a search may go and a viewer still believe it."""

    max_speed_mps: float = 12.0  # 5..40: with which a thing is sent off, unless it is so already
    max_aside_deg: float = 35.0  # 10..60: of a push, from where the sentence has it point
    # 2..20: by which a thing may be rougher or smoother than its material
    friction_factor: float = 6.0
    min_friction: float = 0.01  # ratio, 0..0.05: on ice: of runners, and of stones that are swept
    slick_friction: float = 0.1  # ratio, 0.02..0.2: up to which a support is as slippery as ice
    density_factor: float = 4.0  # 1.5..10: by which it may be denser or lighter: filled, or hollow
    max_askew_deg: float = 12.0  # 3..30: of a front that is not known, elsewhere
    min_rolling: float = 0.005  # ratio, 0.001..0.02: resistance of wheels on a smooth track
    max_rolling: float = 0.4  # ratio, 0.2..1: of wheels that are held back
    rough_rolling: float = 0.12  # ratio, 0.05..0.3: of long grass or sand, the roughest there is


RANGE = ParameterSettings()


def _ratio(path: str, factor: str, target: str, value: float, most: float = math.inf) -> Knob:
    size = abs(value) or 0.1
    sign = -1.0 if value < 0 else 1.0
    return Knob(
        path, factor, target, size, size * 0.02, min(size * 40, 9e6, max(most, size)), 0.25,
        write=lambda v: (SetField(path=path, value=sign * v),),
    )  # fmt: skip


def _angle(path: str, factor: str, target: str, value: float, limit: float = 360.0) -> Knob:
    low, high = max(value - 180.0, -limit), min(value + 180.0, limit)
    return Knob(path, factor, target, value, low, high, 4.0, by_ratio=False)


def _turned(path: str, target: str, value: float) -> Knob:
    """A turn away from a named way or an aim, as far as nobody would call it another way."""
    low, high = min(value, 0.0) - RANGE.max_aside_deg, max(value, 0.0) + RANGE.max_aside_deg
    return Knob(path, "direction", target, value, low, high, 4.0, by_ratio=False)


def _scaled_vector(path: str, target: str, vector: tuple[float, float, float]) -> Knob:
    length = math.sqrt(sum(part * part for part in vector))
    unit = [part / length for part in vector] if length > 1e-9 else [0.0, 0.0, 1.0]
    size = length or 0.1
    return Knob(
        path, "magnitude", target, size, size * 0.02, size * 40, 0.25,
        write=lambda v: (SetField(path=path, value=[_readable(u * v, False) for u in unit]),),
    )  # fmt: skip


def _turned_vector(path: str, target: str, vector: tuple[float, float, float]) -> Knob:
    x, y, z = vector
    flat, heading = math.hypot(x, y), math.degrees(math.atan2(y, x))

    def write(angle: float) -> tuple[Edit, ...]:
        turned = math.radians(angle)
        value = [flat * math.cos(turned), flat * math.sin(turned), z]
        return (SetField(path=path, value=[_readable(part, False) for part in value]),)

    return Knob(path, "direction", target, heading, heading - 180, heading + 180, 4.0, False, write)


def _least_friction(program: PhysicalProgram, item: SceneObject, usual: float) -> float:
    if item.wheels is not None:
        return usual
    below = program.scene.support(item.support or "")
    slick = below is not None and friction_between(below, below) <= RANGE.slick_friction
    return RANGE.min_friction if slick else usual / RANGE.friction_factor


def material_knobs(program: PhysicalProgram) -> list[Knob]:
    """Friction, restitution and density of objects, and what bodies give way to."""
    found: list[Knob] = []
    for item in program.scene.objects:
        base = f"scene.objects.{item.name}"
        row, touch, density = MATERIALS[item.material], touch_of(item), density_of(item)
        friction = touch.friction
        found += [
            Knob(f"{base}.friction", "friction", item.name, max(friction, 0.005),
                 min(_least_friction(program, item, row.friction), max(friction, 0.005)),
                 min(max(row.friction * RANGE.friction_factor, friction), 5.0), 0.3),
            Knob(f"{base}.density", "density", item.name, density,
                 min(row.density / RANGE.density_factor, density),
                 max(row.density * RANGE.density_factor, density), 0.4),
            Knob(f"{base}.restitution", "restitution", item.name, touch.restitution, 0.0, 0.95,
                 0.15, by_ratio=False),
        ]  # fmt: skip
        found += _rolling_knobs(item)
        for field, low, high in _BODY_FIELDS:
            value = getattr(item.body, field, None)
            if isinstance(value, float) and value > 0:
                path = f"{base}.body.{field}"
                found.append(Knob(path, "material", item.name, value, low, high, 1.0))
    return found


def _rolling_knobs(item: SceneObject) -> Iterable[Knob]:
    """Resistance of what rolls by itself or on wheels; of these also where the front points, as
    far as that may be wrong."""
    base = f"scene.objects.{item.name}"
    if item.wheels is None:
        own = touch_of(item).rolling
        low, high, path = (
            max(0.1 * own, 0.0005),
            max(10 * own, RANGE.rough_rolling),
            f"{base}.rolling",
        )
    else:
        own, path = item.wheels.rolling, f"{base}.wheels.rolling"
        low, high = min(RANGE.min_rolling, max(own, 0.001)), max(4 * own, RANGE.max_rolling)
    if item.wheels is not None or is_round(item):
        own = max(own, 0.001)
        yield Knob(path, "rolling", item.name, own, low, high, 0.6)
    if item.wheels is not None and not item.wheels.known:
        at, path = item.wheels.heading, f"{base}.wheels.heading"
        low, high = at - RANGE.max_askew_deg, at + RANGE.max_askew_deg
        yield Knob(path, "direction", item.name, at, low, high, 4.0, by_ratio=False)


def is_round(item: SceneObject) -> bool:
    """Whether it can roll, so that its resistance to rolling matters."""
    return item.shape is not None and item.shape.kind in _ROUND


_ROUND = ("sphere", "ellipsoid", "cylinder", "capsule", "torus", "frustum", "revolved")
_BODY_FIELDS = (("release_impulse", 1e-5, 1e5), ("young", 1e3, 1e9), ("cohesion", 0.01, 1.0))
