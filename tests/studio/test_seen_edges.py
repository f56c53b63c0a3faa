"""Edges of supports over the photo."""

from __future__ import annotations

import re

import numpy as np
import pytest

from physagent_studio.program.scene.camera import Camera
from physagent_studio.program.scene.forms import Floor, Ramp, Slab
from physagent_studio.program.scene.state import Support
from physagent_studio.studio.panels.photo import seen_edges

CAMERA = Camera.from_horizon((800, 600), 200, 1.5)
RAMP = Ramp(toe=(-0.5, 3.0, 0.0), yaw=0.0, run=1.0, rise=0.5, width=0.6)


def lines(path: str) -> np.ndarray:
    return np.array(
        [[float(n) for n in re.findall(r"-?[\d.]+", one)] for one in path.split("M")[1:]]
    )


def test_the_edges_of_a_ramp_run_where_its_corners_are_seen() -> None:
    found = seen_edges(Support(name="ramp", shape=RAMP), CAMERA)
    ends = lines(found["path"]).reshape(-1, 2)
    side = RAMP.width / 2
    near = [(-0.5, 3 - side, 0), (0.5, 3 - side, 0.5), (0.5, 3 - side, 0), (0.5, 3 + side, 0.5)]
    for corner in CAMERA.project(np.array(near))[0]:
        assert np.linalg.norm(ends - corner, axis=1).min() < 0.1
    # What lies behind is not seen: the far foot below its upper edge.
    hidden = CAMERA.project(np.array([(0.5, 3 + side, 0)]))[0][0]
    assert np.linalg.norm(ends - hidden, axis=1).min() > 5
    assert found["area"].startswith("M")
    assert found["area"].endswith("Z")


def test_what_reaches_behind_the_camera_is_cut_off() -> None:
    slab = Slab(position=(0.0, 1.0, 0.4), size=(1.0, 4.0, 0.1))
    found = seen_edges(Support(name="table", shape=slab), CAMERA)
    ends = lines(found["path"]).reshape(-1, 2)
    assert np.isfinite(ends).all()
    # The far corners are where they are; the near ones, behind, do not come out above them.
    far = CAMERA.project(np.array([(-0.5, 3, 0.45), (0.5, 3, 0.45)]))[0]
    assert ends[:, 1].min() == pytest.approx(far[:, 1].min(), abs=0.1)


def test_a_floor_and_what_is_open_have_no_edges() -> None:
    for item in (Support(name="floor", shape=Floor()), Support(name="table")):
        assert seen_edges(item, CAMERA) == {"path": "", "area": ""}
    assert seen_edges(Support(name="ramp", shape=RAMP), None)["path"] == ""
