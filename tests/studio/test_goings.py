"""The arrows of a thing over the photo: where it faces on its wheels."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any, cast

import pytest

from physagent_studio.program import Camera, SceneObject
from physagent_studio.program.scene.state import Wheels
from physagent_studio.studio.panels.photo import ways_of


@pytest.mark.parametrize(("heading", "sign"), [(0.0, 1), (180.0, -1)])
def test_the_front_of_what_drives_points_the_way_it_faces(heading: float, sign: int) -> None:
    camera = Camera.from_horizon((320, 200), 80.0, 1.2, focal=300.0)
    car = SceneObject(name="car", position=(0.0, 4.0, 0.2), wheels=Wheels(heading=heading))
    scene = SimpleNamespace(camera=camera, objects=(car,))
    program = SimpleNamespace(scene=scene, event=SimpleNamespace(actions=()))
    ways = ways_of(car, cast(Any, SimpleNamespace(program=program)))
    assert ways is not None
    assert ways["goes"] is None
    assert sign * (ways["front"][0] - ways["at"][0]) > 10
