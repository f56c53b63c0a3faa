"""Where a camera sees the horizon, level and tilted."""

import math

import numpy as np
import pytest

from physagent_studio.program.scene.camera import Camera


@pytest.mark.parametrize("roll", [-40.0, -3.0, 0.0, 7.5])
@pytest.mark.parametrize("row", [-900.0, 130.0, 520.0])
def test_the_horizon_is_where_it_was_said_to_be(roll: float, row: float) -> None:
    camera = Camera.from_horizon((640, 400), row, 1.3, focal=500.0, roll=math.radians(roll))
    assert camera.horizon == pytest.approx(row)
    assert math.degrees(camera.roll) == pytest.approx(roll)
    # What is level and far away is seen on it, in every column; turned clockwise, it rises.
    columns = np.array([0.0, 320.0, 640.0])
    rows = np.array([camera.horizon_at(column) for column in columns])
    rays = camera.rays(np.column_stack([columns, rows]))
    assert np.abs(rays[:, 2]).max() < 1e-9
    assert np.sign(rows[0] - rows[2]) == np.sign(roll)
