"""What is inflated or a mesh ends where its hull does, wherever its centre of mass is."""

from __future__ import annotations

import numpy as np
import pytest

from physagent_studio.program.preflight.scaling import shape_scaled, shape_thickened
from physagent_studio.program.scene.forms import Inflated, Meshed
from physagent_studio.program.scene.shapes import lowest, outline_of, place_object

CORNERS = tuple((x, y, z) for x in (-0.2, 0.4) for y in (-0.05, 0.05) for z in (-0.9, 0.3))
SHAPES = (
    Inflated(size=(0.6, 0.1, 1.2), flat=True, straight=True, turn=30.0, hull=CORNERS),
    Meshed(asset="0" * 16, size=(0.6, 0.1, 1.2), hull=CORNERS),
)


@pytest.mark.parametrize("shape", SHAPES)
def test_it_reaches_as_far_as_its_corners(shape) -> None:
    outline = outline_of(shape)
    assert outline.bounds == pytest.approx(np.array([[-0.2, -0.05, -0.9], [0.4, 0.05, 0.3]]))
    body = place_object(shape, [0.0, 0.0, 0.9], [1.0, 0.0, 0.0, 0.0])
    assert float(lowest(body)[0]) == pytest.approx(0.0)


@pytest.mark.parametrize("shape", SHAPES)
def test_it_grows_with_its_shape(shape) -> None:
    twice = shape_scaled(shape, 2.0)
    assert outline_of(twice).size == pytest.approx(2 * outline_of(shape).size)
    thick = shape_thickened(shape, 0.1, 0.2)
    assert outline_of(thick).size == pytest.approx([0.6, 0.2, 1.2])
    if isinstance(twice, Inflated):
        assert (twice.flat, twice.straight, twice.turn) == (True, True, 30.0)


def test_without_a_hull_it_is_an_ellipsoid_or_a_box_about_its_centre() -> None:
    size = (0.6, 0.1, 1.2)
    for shape in (Inflated(size=size), Meshed(asset="0" * 16, size=size)):
        assert outline_of(shape).bounds == pytest.approx(np.array([size, size]) / [[-2], [2]])


def test_a_hull_without_thickness_stays_where_it_is() -> None:
    level = tuple((x, y, 0.02) for x in (-0.2, 0.4) for y in (-0.05, 0.05))
    outline = outline_of(Inflated(size=(0.6, 0.1, 1.2), hull=level))
    assert outline.bounds[:, 2] == pytest.approx([0.02, 0.02])
