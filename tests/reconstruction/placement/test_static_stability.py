"""What a photograph shows at rest has what it stands on under it; like things are alike."""

import numpy as np
import pytest

from physagent_studio.program.rotations import about_up
from physagent_studio.program.scene.camera import Camera
from physagent_studio.program.scene.state import (
    Box,
    Capsule,
    Ellipsoid,
    SceneObject,
    SceneState,
    Slab,
    Sphere,
    Support,
)
from physagent_studio.reconstruction import mesh_of
from physagent_studio.reconstruction.checks import measure
from physagent_studio.reconstruction.grounding.same_kind import alike, kind_name
from physagent_studio.reconstruction.placement.depenetration import moved_apart
from physagent_studio.reconstruction.placement.static_stability import moved_in, nudged, reaching
from physagent_studio.reconstruction.shapes.flats import balances_on_a_point, with_flats
from physagent_studio.reconstruction.shapes.forms import Form
from physagent_studio.reconstruction.supports.stances import read

CAMERA = Camera.from_horizon((640, 400), 40.0, 1.5)


def _box(name, size, position, yaw=0.0):
    return SceneObject(name=name, shape=Box(size=size), position=position, rotation=about_up(yaw))


def _mesh(item):
    assert item.shape is not None
    return mesh_of(item.shape)


def test_a_box_beyond_the_edge_of_another_is_moved_onto_it():
    below = _box("below", (0.2, 0.3, 0.1), (1.0, 2.0, 0.05), yaw=0.4)
    item = _box("item", (0.2, 0.3, 0.1), (1.3, 2.0, 0.15))
    x, y, z = nudged(item, below, _mesh(below))
    axis = np.array([np.cos(0.4), np.sin(0.4)])
    assert 0 < float((np.array([x, y]) - (1.0, 2.0)) @ axis) < 0.1
    assert z == 0.15


def test_what_lies_well_stays_where_it_is():
    below = _box("below", (0.2, 0.3, 0.1), (1.0, 2.0, 0.05))
    item = _box("item", (0.2, 0.3, 0.1), (1.06, 2.05, 0.15))
    assert nudged(item, below, _mesh(below)) == item.position


@pytest.mark.parametrize(("x", "reaches"), [(0.2, 0.5), (0.52, 0.536), (0.7, 0.5)])
def test_a_table_reaches_under_what_stands_at_its_edge_but_not_far(x, reaches):
    slab = Slab(position=(0.0, 1.0, 0.7), size=(1.0, 1.0, 0.1), yaw=0.0)
    item = _box("cube", (0.2, 0.2, 0.2), (x, 1.0, 0.85))
    out = reaching(slab, [(item, _mesh(item))])
    assert out.position[0] + out.size[0] / 2 == pytest.approx(reaches)
    assert out.position[0] - out.size[0] / 2 == pytest.approx(-0.5)


@pytest.mark.parametrize(("x", "moved"), [(0.3, 0.3), (0.56, 0.484), (0.9, 0.9)])
def test_what_is_seen_beyond_the_edge_of_a_given_table_is_moved_onto_it_or_reported(x, moved):
    turn = 0.3
    axes = np.array([[np.cos(turn), np.sin(turn)], [-np.sin(turn), np.cos(turn)]])
    slab = Slab(position=(0.0, 1.0, 0.7), size=(1.0, 1.0, 0.1), yaw=turn)
    place = np.array([0.0, 1.0]) + np.array([x, 0.0]) @ axes
    item = _box("cube", (0.2, 0.2, 0.2), (float(place[0]), float(place[1]), 0.85), yaw=turn)
    put = moved_in(item, _mesh(item), slab)
    assert (np.array(put[:2]) - (0, 1)) @ axes[0] == pytest.approx(moved)
    table = Support(name="table", shape=slab, source="given")
    there = item.model_copy(update={"position": put, "support": "table"})
    state = SceneState(objects=(there,), supports=(table,), camera=CAMERA)
    found = measure(state, {}, {"cube": _mesh(item)}, {}, None)
    edges = [finding for finding in found if finding.name == "edge"]
    assert [finding.ok for finding in edges] == ([False] if moved > 0.5 else [])
    assert all("beyond the edge of table" in finding.text for finding in edges)


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
    on = {name: stance.on for name, stance in read(masks).items()}
    assert on == {
        "top_book": "second_book",
        "second_book": "third_book",
        "third_book": "bottom_book",
        "bottom_book": None,
    }


def test_things_side_by_side_are_no_stack_whatever_they_are_called():
    masks = _bands(top_book=(10, 30, 0, 40), bottom_book=(20, 40, 50, 100))
    assert {stance.on for stance in read(masks).values()} == {None}


def test_like_things_get_the_form_that_suits_them_all():
    offers = {
        "left_pin": {"revolved": 0.95, "inflated": 0.9},
        "right_pin": {"revolved": 0.88, "inflated": 0.89},
        "ball": {"sphere": 0.9},
    }
    assert alike(offers) == {"left_pin": "revolved", "right_pin": "revolved"}
    assert kind_name("left_pin") == kind_name("pin_2") == "pin"


@pytest.mark.parametrize(
    "shape", [Capsule(radius=0.1, height=0.5), Ellipsoid(radii=(0.1, 0.1, 0.2)), Sphere(radius=0.2)]
)
def test_flats_keep_height_and_width_and_give_a_base(shape):
    form = Form(shape.kind, shape, mesh_of(shape), (0, 0, 0), (1, 0, 0, 0), 1.0, 1.0)
    flat = with_flats(form)
    before, after = np.ptp(form.mesh.vertices, axis=0), np.ptp(flat.mesh.vertices, axis=0)
    assert after == pytest.approx(before, rel=0.02)
    low = flat.mesh.vertices[:, 2].min()
    base = flat.mesh.vertices[flat.mesh.vertices[:, 2] < low + 1e-6]
    assert np.ptp(base[:, 0]) > 0.3 * before[0]
    assert balances_on_a_point(form) == (shape.kind != "sphere")


def test_what_stands_in_another_is_moved_out_with_what_it_carries():
    near = _box("near", (0.3, 0.3, 0.3), (0.0, 2.0, 0.15))
    far = _box("far", (0.3, 0.3, 0.3), (0.05, 2.2, 0.15))
    cup = _box("cup", (0.1, 0.1, 0.1), (0.05, 2.2, 0.35)).model_copy(update={"support": "far"})
    items = {item.name: item for item in (near, far, cup)}
    meshes = {name: _mesh(item) for name, item in items.items()}
    shifts = moved_apart(items, meshes, frozenset(items))
    assert set(shifts) == {"far", "cup"}
    assert shifts["far"] == shifts["cup"] == pytest.approx((0.0, 0.101), abs=1e-4)
    assert set(moved_apart(items, meshes, frozenset({"near"}))) == {"near"}
    assert moved_apart(items, meshes, frozenset()) == {}
    beside = far.model_copy(update={"position": (0.0, 2.301, 0.15)})
    assert moved_apart({"near": near, "far": beside}, meshes, frozenset(items)) == {}


def test_what_stands_on_two_things_stays_between_them():
    cans = [_box(name, (0.06, 0.06, 0.1), (x, 1.0, 0.05)) for name, x in (("a", 0.0), ("b", 0.07))]
    top = _box("top", (0.06, 0.06, 0.1), (0.035, 1.0, 0.15))
    beside = [(cans[1], _mesh(cans[1]))]
    assert nudged(top, cans[0], _mesh(cans[0]), beside) == top.position
    assert nudged(top, cans[0], _mesh(cans[0]))[0] < 0.03


def test_what_stands_on_a_plate_is_told_from_what_is_behind_it():
    y, x = np.indices((200, 300))
    orange = np.hypot(x - 150, y - 90) < 25
    plate = (((x - 140) / 90) ** 2 + ((y - 105) / 40) ** 2 < 1) & ~orange
    found = read({"orange": orange, "plate": plate})
    assert found["orange"].on == "plate"
    assert found["plate"].on is None
    box = (abs(x - 150) < 60) & (abs(y - 140) < 45)
    behind = (abs(x - 150) < 25) & (y > 20) & (y < 130) & ~box
    found = read({"bottle": behind & (y < 96), "box": box})
    assert found["box"].on is None
