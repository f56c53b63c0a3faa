"""A board covers whatever outline it is cut from; what is no foot does not turn a body."""

from __future__ import annotations

import math

import numpy as np

from physagent_studio.knowledge.things import UNKNOWN
from physagent_studio.program.scene.camera import Camera
from physagent_studio.reconstruction.camera.rays import on_plane
from physagent_studio.reconstruction.photo.regions import BoolArray
from physagent_studio.reconstruction.shapes.forms import forms
from physagent_studio.reconstruction.shapes.primitives import Base

ROWS, COLUMNS = np.mgrid[:240, :320]
CAMERA = Camera.from_horizon((320, 240), 120 - 500 * math.tan(math.radians(8)), 1.0, focal=500.0)


def _round_table() -> BoolArray:
    """A top on two legs, the right one of which is seen to end far higher."""
    top = ((ROWS - 100) / 16) ** 2 + ((COLUMNS - 160) / 90) ** 2 < 1
    left = (ROWS > 100) & (ROWS < 210) & (abs(COLUMNS - 110) < 5)
    right = (ROWS > 100) & (ROWS < 165) & (abs(COLUMNS - 225) < 5)
    return np.asarray(top | left | right)


def test_a_board_covers_its_outline() -> None:
    x, y, z = (float(value) for value in on_plane(CAMERA, [(160.0, 210.0)], 0.0)[0])
    for hold in (0.0, 1.0):
        (form,) = forms(CAMERA, _round_table(), Base(x, y, z, hold), UNKNOWN, "board")
        assert form.kind == "board"
        assert form.iou > 0.75
