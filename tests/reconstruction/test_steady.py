"""What a photograph shows at rest has what it stands on under it; like things are alike."""

import numpy as np
import pytest

from physagent_studio.program.rotations import about_up
from physagent_studio.program.scene import Box, SceneObject, Slab
from physagent_studio.reconstruction import mesh_of
from physagent_studio.reconstruction.layout import read
from physagent_studio.reconstruction.likeness import alike, kind_name
from physagent_studio.reconstruction.steady import nudged, reaching


def _box(name, size, position, yaw=0.0):
    return SceneObject(name=name, shape=Box(size=size), position=position, rotation=about_up(yaw))


def test_a_box_beyond_the_edge_of_another_is_moved_onto_it():
    below = _box("below", (0.2, 0.3, 0.1), (1.0, 2.0, 0.05), yaw=0.4)
    item = _box("item", (0.2, 0.3, 0.1), (1.3, 2.0, 0.15))
    x, y, z = nudged(item, below, mesh_of(below.shape))
    axis = np.array([np.cos(0.4), np.sin(0.4)])
    assert 0 < float((np.array([x, y]) - (1.0, 2.0)) @ axis) < 0.1
    assert z == 0.15


def test_what_lies_well_stays_where_it_is():
    below = _box("below", (0.2, 0.3, 0.1), (1.0, 2.0, 0.05))
    item = _box("item", (0.2, 0.3, 0.1), (1.06, 2.05, 0.15))
    assert nudged(item, below, mesh_of(below.shape)) == item.position


@pytest.mark.parametrize(("x", "reaches"), [(0.2, 0.5), (0.52, 0.536), (0.7, 0.5)])
def test_a_table_reaches_under_what_stands_at_its_edge_but_not_far(x, reaches):
    slab = Slab(position=(0.0, 1.0, 0.7), size=(1.0, 1.0, 0.1), yaw=0.0)
    item = _box("cube", (0.2, 0.2, 0.2), (x, 1.0, 0.85))
    out = reaching(slab, [(item, mesh_of(item.shape))])
    assert out.position[0] + out.size[0] / 2 == pytest.approx(reaches)
    assert out.position[0] - out.size[0] / 2 == pytest.approx(-0.5)


def _bands(**rows):
    """Masks (100, 100) of bands (top row, bottom row, left column, right column)."""
    masks = {}
    for name, (top, bottom, left, right) in rows.items():
        mask = np.zeros((100, 100), bool)
        mask[top:bottom, left:right] = True
        masks[name] = mask
    return masks


def test_names_say_the_order_of_a_stack_that_the_picture_shows():
    # The second book's mask is cut short, and the one below it looks as if it lay lower still.
    masks = _bands(
        bottom_book=(60, 80, 10, 90),
        top_book=(10, 30, 20, 80),
        second_book=(28, 34, 20, 50),
        third_book=(36, 62, 15, 85),
    )
    on = {name: stance.on for name, stance in read(masks, "").items()}
    assert on == {
        "top_book": "second_book",
        "second_book": "third_book",
        "third_book": "bottom_book",
        "bottom_book": None,
    }


def test_things_side_by_side_are_no_stack_whatever_they_are_called():
    masks = _bands(top_book=(10, 30, 0, 40), bottom_book=(20, 40, 50, 100))
    assert {stance.on for stance in read(masks, "").values()} == {None}


def test_like_things_get_the_form_that_suits_them_all():
    offers = {
        "left_pin": {"revolved": 0.95, "inflated": 0.9},
        "right_pin": {"revolved": 0.88, "inflated": 0.89},
        "ball": {"sphere": 0.9},
    }
    assert alike(offers) == {"left_pin": "revolved", "right_pin": "revolved"}
    assert kind_name("left_pin") == kind_name("pin_2") == "pin"
