"""Standing, hanging and the ground line: what the photo shows of a thing stays where it is."""

from __future__ import annotations

import numpy as np
import pytest

from physagent_studio.errors import InputError
from physagent_studio.program import PhysicalProgram, SetField, apply
from physagent_studio.program.scene.aloft import carriage_of
from physagent_studio.program.scene.camera import Camera
from physagent_studio.program.scene.shapes import lowest, place_object
from physagent_studio.program.text.document import load_program
from physagent_studio.workbench.aloft_edits import (
    carriage_edits,
    foot_of,
    ground_edits,
    height_edits,
)

PROGRAM = """
scene:
  objects:
    - {name: apple, shape: {kind: sphere, radius: 0.2}, position: [0.4, 4, 0.2], support: floor}
    - {name: cup, shape: {kind: box, size: [0.1, 0.1, 0.1]}, position: [-1, 3, 1.5], support: air}
  supports:
    - {name: floor, shape: {kind: floor}}
    - {name: table, shape: {kind: box, size: [1, 1, 0.5], position: [-1, 3, 0.25]}}
"""


@pytest.fixture
def program() -> PhysicalProgram:
    plain = load_program(PROGRAM)
    camera = Camera.from_horizon((640, 480), 200.0, 1.2, focal=500.0)
    scene = plain.scene.model_copy(update={"camera": camera})
    return plain.model_copy(update={"scene": scene})


def seen(program: PhysicalProgram, name: str) -> tuple[np.ndarray, float]:
    """Pixel of the middle and the size in pixels."""
    item, camera = program.scene.object(name), program.scene.camera
    assert item is not None
    assert camera is not None
    assert item.shape is not None
    pixel, depth = camera.project(np.array([item.position], float))
    return pixel[0], float(getattr(item.shape, "radius", 0.0) / depth[0])


def test_raising_keeps_the_place_in_the_photo(program: PhysicalProgram) -> None:
    after = apply(program, height_edits(program, "apple", 0.6))
    item = after.scene.object("apple")
    assert item is not None
    assert item.shape is not None
    assert item.position is not None
    foot = lowest(place_object(item.shape, [item.position], [item.rotation]))[0]
    assert foot == pytest.approx(0.6, abs=1e-3)
    assert carriage_of(item) == "hangs"
    for now, before in zip(seen(after, "apple"), seen(program, "apple"), strict=True):
        assert now == pytest.approx(before, rel=1e-3)


def test_the_ground_line_says_how_far_it_is(program: PhysicalProgram) -> None:
    camera = program.scene.camera
    assert camera is not None
    pixel, _ = camera.project(np.array([[0.2, 2.0, 0.0]]))
    column = seen(program, "apple")[0][0]
    after = apply(program, ground_edits(program, "apple", (float(column), float(pixel[0][1]))))
    item = after.scene.object("apple")
    assert item is not None
    foot = foot_of(after.scene, item)
    assert foot is not None
    assert foot[0][1] == pytest.approx(2.0, abs=0.05)
    assert seen(after, "apple")[0] == pytest.approx(seen(program, "apple")[0], abs=0.1)
    with pytest.raises(InputError, match="below the horizon"):
        ground_edits(program, "apple", (300.0, 100.0))


def test_what_stands_is_put_on_what_is_below_it(program: PhysicalProgram) -> None:
    after = apply(program, carriage_edits(program, (), "cup", "stands"))
    item = after.scene.object("cup")
    assert item is not None
    assert item.support == "table"
    assert item.position == pytest.approx((-1, 3, 0.55), abs=1e-3)
    for how in ("hangs", "floats", "falls"):
        held = apply(program, carriage_edits(program, (), "cup", how)).scene.object("cup")
        assert held is not None
        assert (carriage_of(held), held.position) == (how, (-1, 3, 1.5))


def test_the_thread_goes_with_what_hangs_by_it(program: PhysicalProgram) -> None:
    hung = apply(
        program,
        (
            SetField(path="scene.objects.cup.aloft", value="hangs"),
            SetField(path="scene.objects.cup.tether", value=0.4),
        ),
    )
    before = hung.scene.object("cup")
    pixel = seen(hung, "cup")[0]
    after = apply(hung, ground_edits(hung, "cup", (float(pixel[0]), 320.0)))
    item, camera = after.scene.object("cup"), program.scene.camera
    assert camera is not None
    assert item is not None
    assert before is not None
    assert item.tether is not None
    assert item.tether != pytest.approx(0.4, rel=0.1)
    # As long on the picture as it was.
    spots = np.array([before.position, item.position], float)
    far = camera.project(spots)[1]
    assert item.tether / far[1] == pytest.approx(0.4 / far[0], rel=1e-3)
    down = apply(after, carriage_edits(after, (), "cup", "stands")).scene.object("cup")
    assert down is not None
    assert down.tether is None
