"""Fixtures of the rendering tests."""

from __future__ import annotations

import pytest

from physagent_studio.records.scene import Scene
from tests.rendering.scenes import FLOOR, ball, crate, scene_of


@pytest.fixture
def two_things() -> Scene:
    """A ball and a crate on a floor, without a photo."""
    first, first_mesh = ball()
    second, second_mesh = crate()
    return scene_of([first, second], {"ball": first_mesh, "crate": second_mesh}, [FLOOR])
