"""`ApplyDisturbance`: every model a closed form of time, seed and (for wind) velocity."""

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from physagent_studio.program.actions import ApplyDisturbance
from physagent_studio.program.base import DIRECTIONS
from physagent_studio.simulation.surfaces import FloatArray

AIR_DENSITY = 1.204
"""kg/m³ at 20 °C and sea level."""

LEAVES = (5.0, -0.7)
"""m/s from which on leaves and twigs lie down in the wind, and the power of its speed with which
the drag coefficient falls then (Vogel's exponent; de Langre et al. 2012, J. theor. Biol. 297, 1).
With a coefficient of 0.8 in light air it is 0.49 at 9 m/s and 0.23 at 30 m/s: pines in the wind
tunnel had 0.2 to 0.35 at 30 m/s (Mayhead 1973, Agric. Meteorol. 12, 123), broadleaves .1 to .3 at
20 m/s (Vollsinger et al. 2005, Can. J. For. Res. 35, 1238)."""

DEFAULT_FREQUENCY = {"side": 2.0, "shake": 4.0, "jitter": 12.0}
"""Hz."""


@dataclass(frozen=True, eq=False, slots=True)
class Drag:
    """How a body catches the wind: drag coefficient, and R_world_body with silhouette areas.

    leafy: whether leaves and twigs turn with the wind, see `LEAVES`.
    """

    coefficient: float
    rotation: FloatArray
    shadows: FloatArray
    leafy: bool = False

    def force(self, wind: FloatArray) -> FloatArray:
        """½ ρ C A |u| u for air that passes with u = `wind` (3,) m/s."""
        speed = float(np.linalg.norm(wind))
        if speed < 1e-9:
            return np.zeros(3)
        along = self.rotation.T @ (wind / speed)
        # The silhouette of an ellipsoid with these axis silhouettes.
        area = float(np.linalg.norm(along * self.shadows))
        coefficient = self.coefficient
        if self.leafy:
            calm, power = LEAVES
            coefficient *= (1 + (speed / calm) ** 2) ** (power / 2)
        return 0.5 * AIR_DENSITY * coefficient * area * speed * wind


def disturbance(
    action: ApplyDisturbance, time: float, total: float, velocity: FloatArray, drag: Drag
) -> FloatArray:
    """Force (3,) in N at `time` s after the start of a window of `total` s."""
    if action.model == "wind":
        return drag.force(_air(action, time) * axis_of(action) - velocity)
    return action.amplitude * _SHAPES[action.model](action, time, total)


def _air(action: ApplyDisturbance, time: float) -> float:
    """Speed of the air, m/s: steady, or in gusts that swell to the amplitude and ebb to calm."""
    if action.frequency is None:
        return action.amplitude
    return action.amplitude * (1 - math.cos(2 * math.pi * action.frequency * time)) / 2


def axis_of(action: ApplyDisturbance) -> FloatArray:
    """Unit vector of the disturbance; bump goes up by default, the others go to +x."""
    given = action.direction
    if given is None:
        given = "up" if action.model == "bump" else "right"
    raw = np.array(DIRECTIONS[given] if isinstance(given, str) else given, float)
    length = float(np.linalg.norm(raw))
    return raw / length if length > 1e-12 else np.array([1.0, 0.0, 0.0])


def _gust(action: ApplyDisturbance, time: float, total: float) -> FloatArray:
    """Swells and dies: sin²; its impulse is amplitude · total / 2."""
    return axis_of(action) * math.sin(math.pi * time / total) ** 2


def _bump(action: ApplyDisturbance, time: float, total: float) -> FloatArray:
    """One knock: half a sine; its impulse is amplitude · total · 2/π."""
    return axis_of(action) * math.sin(math.pi * time / total)


def _side(action: ApplyDisturbance, time: float, total: float) -> FloatArray:
    """To and fro along the axis; over full periods its impulse is zero."""
    return axis_of(action) * math.sin(2 * math.pi * _frequency(action) * time)


def _shake(action: ApplyDisturbance, time: float, total: float) -> FloatArray:
    """A sine on each axis, frequency apart by small ratios, phases from the seed."""
    phases = np.random.default_rng(action.seed).uniform(0, 2 * math.pi, 3)
    rates = _frequency(action) * np.array([1.0, 1.13, 0.87])
    return np.sin(2 * math.pi * rates * time + phases) / math.sqrt(3)


def _jitter(action: ApplyDisturbance, time: float, total: float) -> FloatArray:
    """Band-limited noise: eight sines per axis around the frequency, drawn from the seed."""
    draw = np.random.default_rng(action.seed)
    rates = _frequency(action) * draw.uniform(0.3, 1.7, (3, 8))
    phases = draw.uniform(0, 2 * math.pi, (3, 8))
    return np.sin(2 * math.pi * rates * time + phases).sum(1) / math.sqrt(24)


def _frequency(action: ApplyDisturbance) -> float:
    return action.frequency or DEFAULT_FREQUENCY[action.model]


_SHAPES: dict[str, Callable[[ApplyDisturbance, float, float], FloatArray]] = {
    "gust": _gust,
    "bump": _bump,
    "side": _side,
    "shake": _shake,
    "jitter": _jitter,
}
