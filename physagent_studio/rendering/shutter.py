"""Motion blur: the light that falls in while a shutter is open, averaged over moments of it."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from physagent_studio.records.rollout import Rollout
from physagent_studio.rendering.compositor import Compositor
from physagent_studio.rendering.frame import Frame

FloatArray = NDArray[np.float64]
MOMENTS = 8
"""Moments that a frame is the mean of."""
GAMMA = 2.2
"""Exponent from what is stored to light; light is what adds up."""


def exposed(
    compositor: Compositor, rollout: Rollout, at_rest: Frame, number: int, shutter: float
) -> Frame:
    """Frame `number` with the shutter open from it on, a share of the time to the next frame.

    at_rest: the same frame without blur, whose ids and depth are kept.
    """
    times = number + shutter * (np.arange(MOMENTS) + 0.5) / MOMENTS
    states = [_state(rollout, float(time)) for time in (number, *times)]
    if all(_alike(states[0], one) for one in states[1:]):
        return at_rest
    light = np.zeros(at_rest.rgb.shape, np.float64)
    for positions, rotations, vertices in states[1:]:
        rgb = compositor.frame(positions, rotations, vertices).rgb
        light += (rgb / 255.0) ** GAMMA
    mean = 255.0 * (light / MOMENTS) ** (1 / GAMMA)
    return replace(at_rest, rgb=np.clip(np.rint(mean), 0, 255).astype(np.uint8))


def _state(rollout: Rollout, time: float) -> tuple[FloatArray, FloatArray, dict[str, FloatArray]]:
    """Positions (N, 3), rotations (N, 4) and deformed vertices (V, 3) between two steps.

    time: in frames. Rotations go straight from one to the next, which are near.
    """
    before, after, share = _between(time * rollout.steps_per_frame, len(rollout.positions))
    positions = _mixed(rollout.positions, before, after, share)
    first, second = rollout.rotations[before], rollout.rotations[after]
    second = np.where((first * second).sum(1, keepdims=True) < 0, -second, second)
    rotations = (1 - share) * first + share * second
    rotations /= np.maximum(np.linalg.norm(rotations, axis=1, keepdims=True), 1e-12)
    bent = {name: _mixed(rows, *_between(time, len(rows))) for name, rows in rollout.vertices}
    return positions, rotations, bent


def _between(at: float, count: int) -> tuple[int, int, float]:
    """The entries before and after a place in a row of so many, and how far it is between them."""
    before = min(int(at), count - 1)
    return before, min(before + 1, count - 1), at - int(at)


def _mixed(rows: FloatArray, before: int, after: int, share: float) -> FloatArray:
    return (1 - share) * rows[before] + share * rows[after]


def _alike(
    one: tuple[FloatArray, FloatArray, dict[str, FloatArray]],
    other: tuple[FloatArray, FloatArray, dict[str, FloatArray]],
) -> bool:
    poses = all(np.array_equal(a, b) for a, b in zip(one[:2], other[:2], strict=True))
    return poses and all(np.array_equal(rows, other[2][name]) for name, rows in one[2].items())
