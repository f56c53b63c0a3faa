"""Distances that are kept are those of the bodies where they are now."""

from __future__ import annotations

import pytest

from physagent_studio.agent.rules.scene.measures import Layout
from physagent_studio.program import SceneState
from physagent_studio.program.scene.state import Floor, SceneObject, Slab, Sphere, Support


def layout_of(x: float, z: float, radius: float = 0.1) -> Layout:
    balls = (
        SceneObject(name="one", shape=Sphere(radius=radius), position=(x, 4.0, z)),
        SceneObject(name="other", shape=Sphere(radius=0.1), position=(0.0, 4.0, 0.7)),
    )
    table = Support(name="table", shape=Slab(position=(0.0, 4.0, 0.3), size=(1.0, 1.0, 0.6)))
    supports = (Support(name="floor", shape=Floor()), table)
    return Layout(SceneState(objects=balls, supports=supports))


def test_what_is_moved_or_grown_is_measured_anew() -> None:
    for _ in range(2):
        assert layout_of(0.4, 0.7).gap("one", "other") == pytest.approx(0.2)
        assert layout_of(0.3, 0.7).gap("one", "other") == pytest.approx(0.1)
        assert layout_of(0.3, 0.7, 0.2).gap("one", "other") == pytest.approx(0.0)
        assert layout_of(0.4, 0.7).carrier("one") == "table"
        assert layout_of(0.4, 1.0).carrier("one") is None
        assert layout_of(2.0, 0.1).carrier("one") == "floor"
