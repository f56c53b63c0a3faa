"""What lies is looked at from above, what stands from before it, where the picture says nothing."""

from __future__ import annotations

import math

import numpy as np
import pytest

from physagent_studio.reconstruction.camera.estimate import Horizon, Standing, estimate
from physagent_studio.reconstruction.photo.line_segments import segments

SIZE = (640, 480)


def looked_at(*lies: bool) -> Horizon:
    plain = np.full((SIZE[1], SIZE[0], 3), 128, np.uint8)
    things = [Standing(360.0, 200.0, 0.2, 0.3, "floor", one) for one in lies]
    return estimate(SIZE, segments(plain), things)


def pitch(horizon: Horizon) -> float:
    return math.degrees(math.atan2(SIZE[1] / 2 - horizon.row, horizon.focal))


@pytest.mark.parametrize("lies", [(True,), (True, True)])
def test_things_that_lie_are_looked_at_from_above(lies) -> None:
    assert pitch(looked_at(*lies)) > 35


@pytest.mark.parametrize("lies", [(False,), (True, False)])
def test_what_stands_says_that_the_camera_is_level(lies) -> None:
    assert pitch(looked_at(*lies)) < 30
