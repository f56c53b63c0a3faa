"""Textbook mechanics: speeds, angles and times that an event needs. SI units."""

import math
from typing import NamedTuple

from physagent_studio.program.scene.state import SceneState

G: float = -SceneState.model_fields["gravity"].default[2]
"""Gravity where a program says nothing of it, m/s²."""


def speed_to_stop(distance: float, friction: float) -> float:
    """Speed with which a sliding body stops after `distance`; 0 where nothing slows it."""
    return math.sqrt(2 * G * friction * max(distance, 0.0))


def rolling_slowing(resistance: float) -> float:
    """Deceleration of a ball that rolls: 5/7 c g, since its spin has to be slowed as well."""
    return 5 / 7 * resistance * G


class Push(NamedTuple):
    """A push that gives a free body `speed`, m/s, within `seconds`."""

    speed: float
    seconds: float


def speed_to_arrive(distance: float, seconds: float, slowing: float = 0.0) -> float:
    """Starting speed that covers `distance` in `seconds` against a constant deceleration.

    What would stand still before then gets there sooner: with the speed that just suffices.
    """
    if 2 * distance < slowing * seconds**2:
        return math.sqrt(2 * slowing * distance)
    return distance / seconds + slowing * seconds / 2


def time_to_fall(height: float) -> float:
    """Time of free fall from rest, s."""
    return math.sqrt(2 * max(height, 0.0) / G)


def launch(distance: float, rise: float, seconds: float, push: float = 0.0) -> tuple[float, float]:
    """Speed and elevation (degrees) of a throw that is `distance` away and `rise` up `seconds`
    after it is let go.

    push: s for which it is pushed before. It goes half as far in them as it does afterwards, and
    gravity, which a push only makes up for along its own line, bends its way down: it is aimed
    higher by as much.
    """
    flown = seconds + push / 2
    across, up = distance / flown, (rise + G * seconds * seconds / 2) / flown
    aim = math.atan2(up + G * push, across)
    return across * math.cos(aim) + up * math.sin(aim), math.degrees(aim)


def speed_to_topple(height: float, half_width: float) -> float:
    """Speed of the top of an upright body that carries its centre over its lower edge.

    Energy: m g (√(h²/4 + w²) − h/2) = ½ I ω² with I ≈ m (h² + w²) / 3 about the edge.
    """
    half = height / 2
    lift = math.hypot(half, half_width) - half
    spin = math.sqrt(2 * G * lift / ((height * height + half_width * half_width) / 3))
    return spin * height


def push_to_topple(height: float, half_width: float, most: float) -> Push:
    """The push that carries an upright body's centre over its lower edge, and hardly more.

    Its speed is that of the centre, square to the line from the edge to it. While it is pushed it
    turns half as far as it would at that speed; with what it has then it has to rise the rest:
    ½ I (v/r)² = m g r (1 - cos(φ - v t / 2r)), φ from where it stands to where it balances.
    most: s, the longest push; what is small falls faster.
    """
    inertia = (height * height + half_width * half_width) / 3
    reach = math.hypot(height / 2, half_width)
    balance = math.atan2(2 * half_width, height)
    seconds = min(most, math.sqrt(inertia / (G * reach)))
    low, high = 0.0, balance * reach / max(seconds / 2, 1e-9)
    for _ in range(40):
        speed = (low + high) / 2
        left = balance - speed * seconds / (2 * reach)
        short = inertia * (speed / reach) ** 2 / 2 < G * reach * (1 - math.cos(left))
        low, high = (speed, high) if short else (low, speed)
    return Push(high, seconds)


def speed_to_knock(
    mass: float, height: float, half_width: float, striker: float, restitution: float, at: float
) -> float:
    """Speed of a striker of mass `striker` that knocks an upright body over at height `at`.

    The blow gives the body the impulse J = (1 + e) v m₁ m' / (m₁ + m') with m' its inertia seen
    at that height, and the spin J · at / I about its lower edge.
    """
    inertia = mass * (height * height + half_width * half_width) / 3
    seen = inertia / max(at * at, 1e-6)
    needed = speed_to_topple(height, half_width) / max(height, 1e-6)
    gained = (1 + restitution) * striker * seen / (striker + seen) * at / max(inertia, 1e-12)
    return needed / max(gained, 1e-9)


def speed_before_hit(after: float, mass: float, other: float, restitution: float) -> float:
    """The speed before that leaves `after`; inf where the body bounces back or stops."""
    share = (mass - restitution * other) / (mass + other)
    return after / share if share > 1e-6 else math.inf


def spin_for_flip(turn: float, seconds: float) -> float:
    """Angular speed (rad/s) of a turn (degrees) in a time of flight."""
    return math.radians(turn) / max(seconds, 1e-3)


def arc_acceleration(speed: float, distance: float, turn: float) -> float:
    """Sideways acceleration that turns the path by `turn` degrees over `distance`."""
    return speed * speed * math.radians(turn) / max(distance, 1e-6)
