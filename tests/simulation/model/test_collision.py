"""The outlines that are shown are those that collide."""

from __future__ import annotations

import numpy as np
import pytest

from physagent_studio.errors import SimulationError
from physagent_studio.program.text.document import load_program
from physagent_studio.records import Mesh
from physagent_studio.simulation import Simulator

THINGS = """
scene:
  objects:
    - {name: ball, shape: {kind: sphere, radius: 0.1}, position: [0, 2, 0.1], support: floor}
    - {name: box, shape: {kind: box, size: [0.2, 0.3, 0.4]}, position: [1, 2, 0.2], support: floor}
    - name: can
      shape: {kind: cylinder, radius: 0.05, height: 0.3}
      position: [2, 2, 0.15]
      support: floor
    - name: cone
      shape: {kind: frustum, bottom_radius: 0.1, top_radius: 0.02, height: 0.2}
      position: [3, 2, 0.1]
      support: floor
    - name: sheet
      shape: {kind: box, size: [0.4, 0.4, 0.01]}
      position: [4, 2, 0.5]
      support: air
      body: {kind: cloth}
  supports:
    - {name: floor, shape: {kind: floor}}
    - {name: table, shape: {kind: box, position: [0, 4, 0.25], size: [1, 0.5, 0.5]}}
event: {prompt: Nothing happens.}
"""


def _extent(meshes: tuple[Mesh, ...]) -> np.ndarray:
    points = np.concatenate([mesh.vertices for mesh in meshes])
    return points.max(axis=0) - points.min(axis=0)


def test_outlines_have_the_size_of_the_shapes() -> None:
    found = Simulator().outlines(load_program(THINGS), {})
    assert set(found) == {"ball", "box", "can", "cone", "table"}
    wanted = {
        "ball": (0.2, 0.2, 0.2),
        "box": (0.2, 0.3, 0.4),
        "can": (0.1, 0.1, 0.3),
        "cone": (0.2, 0.2, 0.2),
        "table": (1, 0.5, 0.5),
    }
    for name, size in wanted.items():
        assert _extent(found[name]) == pytest.approx(size, rel=0.03), name
    # Supports stand in the world, objects about their own middle.
    assert found["table"][0].vertices.mean(axis=0) == pytest.approx([0, 4, 0.25], abs=1e-6)
    assert found["box"][0].vertices.mean(axis=0) == pytest.approx([0, 0, 0], abs=1e-6)


def test_what_is_open_has_none() -> None:
    program = load_program(
        "scene:\n  objects:\n    - {name: ball, support: air}\nevent: {prompt: It waits.}\n"
    )
    with pytest.raises(SimulationError, match="is open"):
        Simulator().outlines(program, {})
