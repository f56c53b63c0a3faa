"""What hangs in the air is above the ground that is seen at its foot."""

from types import SimpleNamespace
from typing import Any

import pytest

from physagent_studio.program import Camera
from physagent_studio.program.scene.aloft import AIR
from physagent_studio.reconstruction.camera.rays import on_plane
from physagent_studio.reconstruction.placement.bases import base_of


@pytest.mark.parametrize(("metres", "hangs"), [(0.05, True), (0.5, False)])
def test_it_is_no_farther_than_the_ground_at_its_foot(metres, hangs):
    camera = Camera.from_horizon((640, 480), 200.0, 0.3)
    stance: Any = SimpleNamespace(name="balloon", foot=(300.0, 300.0), extent=60.0)
    read: Any = SimpleNamespace(
        on={"balloon": AIR},
        under={},
        usual={"balloon": SimpleNamespace(metres=metres)},
        camera=camera,
    )
    base = base_of(stance, read, (), {})
    ground = on_plane(camera, [stance.foot], 0.0)[0]
    assert base.z >= -1e-6
    assert (base.z > 0.01) == hangs
    assert base.y <= ground[1] + 1e-6
