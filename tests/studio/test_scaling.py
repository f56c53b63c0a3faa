"""Pulling at a handle of the frame: how far it goes, and what becomes of the shape."""

from __future__ import annotations

import numpy as np
import pytest

from physagent_studio.program import EventProgram, PhysicalProgram, SceneObject, SceneState, apply
from physagent_studio.program.scene import state as shapes
from physagent_studio.records import Mesh
from physagent_studio.studio.scene.handles import factors_of, pulled, scaled, scaling
from physagent_studio.studio.scene.primitives import mesh_of_object


def test_the_end_of_the_line_follows_the_pointer() -> None:
    centre, end = np.zeros(3), np.array([1.0, 0, 0])
    eye = np.array([0.5, -5.0, 0])
    # A pointer that stays at the end pulls nothing; one twice as far out doubles.
    assert pulled(end, centre, eye, end) == pytest.approx(1.0)
    assert pulled(end, centre, eye, np.array([2.0, 0, 0])) == pytest.approx(2.0)
    # Off the line, the nearest point of it counts.
    assert pulled(end, centre, eye, np.array([2.0, 0, 0.7])) == pytest.approx(2.0, abs=0.05)


def test_it_keeps_its_bounds_and_survives_nonsense() -> None:
    centre, end, eye = np.zeros(3), np.array([1.0, 0, 0]), np.array([0, -5.0, 0])
    assert pulled(end, centre, eye, np.array([500.0, 0, 0])) == 10.0
    assert pulled(end, centre, eye, np.array([-3.0, 0, 0])) == 0.1
    assert pulled(end, centre, eye, np.full(3, np.nan)) == 1.0
    # Looking along the line says nothing about its length.
    assert pulled(end, centre, np.array([-4.0, 0, 0]), np.array([3.0, 0, 0])) == 1.0


@pytest.mark.parametrize(
    ("shape", "axis", "wanted"),
    [
        (shapes.Sphere(radius=0.1), 2, shapes.Sphere(radius=0.2)),
        (shapes.Box(size=(0.1, 0.2, 0.3)), 1, shapes.Box(size=(0.1, 0.4, 0.3))),
        (shapes.Box(size=(0.1, 0.2, 0.3)), None, shapes.Box(size=(0.2, 0.4, 0.6))),
        (shapes.Cylinder(radius=0.1, height=1), 0, shapes.Cylinder(radius=0.2, height=1)),
        (shapes.Cylinder(radius=0.1, height=1), 2, shapes.Cylinder(radius=0.1, height=2)),
        (shapes.Ellipsoid(radii=(0.1, 0.2, 0.3)), 2, shapes.Ellipsoid(radii=(0.1, 0.2, 0.6))),
    ],
)
def test_a_shape_grows_where_it_is_pulled(
    shape: shapes.Shape, axis: int | None, wanted: shapes.Shape
) -> None:
    assert scaled(shape, factors_of(shape, axis, 2.0)) == wanted


def test_what_stands_keeps_standing() -> None:
    item = SceneObject(
        name="box",
        shape=shapes.Box(size=(0.2, 0.2, 0.2)),
        position=(0, 1, 0.1),
        support="floor",
        material="wood",
    )
    floor = {"name": "floor", "shape": {"kind": "floor"}, "material": "wood"}
    program = PhysicalProgram.model_validate(
        {"scene": {"supports": [floor], "objects": [item.model_dump()]}, "event": {"prompt": "x"}}
    )
    mesh = mesh_of_object(item)
    assert mesh is not None
    edits = scaling(item, mesh, np.array([1.0, 1.0, 2.0]))
    made = apply(program, edits).scene.object("box")
    assert made is not None
    assert made.position == (0, 1, 0.2)
    assert made.shape == shapes.Box(size=(0.2, 0.2, 0.4))


def test_nothing_pulled_is_no_edit() -> None:
    item = SceneObject(
        name="ball", shape=shapes.Sphere(radius=0.1), position=(0, 1, 1), support="air"
    )
    mesh = Mesh(np.eye(3), np.array([[0, 1, 2]], np.int32))
    assert scaling(item, mesh, np.ones(3)) == ()
    assert PhysicalProgram(scene=SceneState(objects=(item,)), event=EventProgram()).scene.objects
