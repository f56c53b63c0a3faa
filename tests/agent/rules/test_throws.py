"""Throws come down where they are aimed at, though a push takes its time and gravity pulls."""

from __future__ import annotations

import numpy as np
import pytest

from physagent_studio.agent.rules.scene import mechanics as mech
from physagent_studio.simulation import simulate
from tests.agent.rules.filmed import BALL, filmed, push


@pytest.mark.parametrize(("distance", "rise", "seconds"), [(0.4, 0.1, 0.4), (1.5, -0.05, 0.6)])
def test_a_throw_is_there_when_it_shall_be(distance: float, rise: float, seconds: float) -> None:
    duration, start, step = 4, 4, 0.01
    speed, elevation = mech.launch(distance, rise, seconds, duration * step)
    program = filmed([BALL], [push(speed, duration=duration, elevation=elevation)])
    way = simulate(program, {}).positions[:, 0]
    there = start + duration + round(seconds / step)
    off = way[there] - way[0] - (distance, 0.0, rise)
    assert np.linalg.norm(off) < 0.1 * distance
