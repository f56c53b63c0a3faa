"""Tables that a sentence names and nobody clicked: drawn with known edges and found again."""

from __future__ import annotations

import cv2
import numpy as np
import pytest

from physagent_studio.program.scene.camera import Camera
from physagent_studio.program.scene.state import (
    Click,
    Floor,
    Grounding,
    SceneObject,
    SceneState,
    Slab,
    Support,
)
from physagent_studio.reconstruction import reconstruct
from physagent_studio.reconstruction.photo.line_segments import segments
from physagent_studio.reconstruction.photo.regions import bounds, grow, iou
from physagent_studio.reconstruction.supports import stances as layout
from physagent_studio.reconstruction.supports.tabletops import top_around
from physagent_studio.reconstruction.survey.named_tops import with_tops
from physagent_studio.reconstruction.survey.sighting import Look
from physagent_studio.records.case import Case

pytestmark = pytest.mark.usefixtures("unfilled")

SIZE = (480, 300)
TOP = 0.75
CAMERA = Camera.from_horizon(SIZE, 10.0, TOP + 0.4, source="given", confirmed=True)
FULL = ((-3.0, 0.2), (3.0, 0.2), (3.0, 0.9), (-3.0, 0.9))
CORNER = ((-0.22, 0.2), (3.0, 0.2), (3.0, 0.8), (-0.22, 0.8))
"""Places of the corners of a table that goes out of the picture, and of one with a corner in it."""


def _drawn(corners, seed: int = 3):
    """(picture, mask of the table without the box, mask of the box) of a box on a planked table."""
    rng = np.random.default_rng(seed)
    picture = np.full((SIZE[1], SIZE[0], 3), (150, 155, 165), np.uint8)
    flat = np.array([(x, y, TOP) for x, y in corners])
    # What is beside and behind the camera has no picture; the near edge lies below the border.
    pixels = _pixels(flat)
    table = cv2.fillPoly(np.zeros((SIZE[1], SIZE[0]), np.uint8), [pixels], 1) > 0
    picture[table] = (170, 120, 70)
    for y in np.arange(0.25, corners[2][1] - 0.1, 0.09):
        ends = _pixels([(corners[0][0], y, TOP), (corners[1][0], y, TOP)])
        plank = cv2.polylines(np.zeros_like(picture[..., 0]), [ends], False, 1)
        picture[(plank > 0) & table] = (135, 92, 52)
    box = np.zeros_like(table)
    low, high = TOP, TOP + 0.08
    sides = [((-0.04, 0.5), (0.04, 0.5), 1.0), ((-0.04, 0.5), (-0.04, 0.58), 0.7)]
    for (x0, y0), (x1, y1), shade in sides:
        face = [(x0, y0, low), (x1, y1, low), (x1, y1, high), (x0, y0, high)]
        _fill(picture, box, face, shade)
    upper = [(-0.04, 0.5, high), (0.04, 0.5, high), (0.04, 0.58, high), (-0.04, 0.58, high)]
    _fill(picture, box, upper, 1.2)
    noisy = picture + rng.normal(0, 4, picture.shape)
    return np.clip(noisy, 0, 255).astype(np.uint8), table & ~box, box


def _fill(picture, mask, corners, shade: float) -> None:
    pixels = _pixels(corners)
    cv2.fillPoly(picture, [pixels], tuple(int(c * shade) for c in (30, 60, 180)))
    mask |= cv2.fillPoly(np.zeros(mask.shape, np.uint8), [pixels], 1) > 0


def _pixels(places) -> np.ndarray:
    """(N, 2) whole pixels of world points."""
    return np.clip(np.round(CAMERA.project(np.array(places))[0]), -4000, 4000).astype(np.int32)


@pytest.mark.parametrize("corners", [FULL, CORNER])
def test_the_edges_that_end_a_top_are_told_from_joints_between_its_boards(corners):
    picture, table, box = _drawn(corners)
    stance = layout.read({"box": box})["box"]
    base = CAMERA.project(np.array([(0.0, 0.54, TOP)]))[0]
    top = top_around(picture, segments(picture), [stance], base, box)
    assert top is not None
    assert iou(top.region, table) > 0.97


def test_two_edges_before_a_wall_of_the_colour_of_the_tops_shade_end_it_together():
    """Each goes on over the wall, which looks like the shade at the feet on both sides of it."""
    picture, table, box = _drawn(CORNER)
    rows, columns = np.indices(table.shape)
    wall = (150, 155, 165)
    shade = table & (np.abs(rows - 262) < 14) & (columns > 240) & (columns < 290)
    picture[~table & ~box] = wall
    picture[shade] = wall
    stance = layout.read({"box": box})["box"]
    base = CAMERA.project(np.array([(0.0, 0.54, TOP)]))[0]
    top = top_around(picture, segments(picture), [stance], base, box)
    assert top is not None
    assert iou(top.region, table) > 0.95


def test_a_marked_top_of_which_hardly_more_than_a_rim_is_seen_is_not_found():
    """Not the whole picture then, nor an error: what grew from the mark stays."""
    picture, _, box = _drawn(CORNER)
    stance = layout.read({"box": box})["box"]
    picture[~grow(box, 8)] = (20, 200, 40)
    base = CAMERA.project(np.array([(0.0, 0.54, TOP)]))[0]
    frame = (0.0, 0.0, float(SIZE[0]), float(SIZE[1]))
    assert top_around(picture, segments(picture), [stance], base, box, box=frame) is None


def test_without_ground_around_its_feet_nothing_is_said():
    picture, _, box = _drawn(FULL)
    stance = layout.read({"box": box})["box"]
    everything = np.ones_like(box)
    assert top_around(picture, segments(picture), [stance], np.zeros((1, 2)), everything) is None


def _seen(picture, box, part, mark):
    """What is made of a click on a table whose mask is a part of it."""
    state = SceneState(
        camera=CAMERA,
        objects=(SceneObject(name="box", support="table"),),
        supports=(Support(name="table", grounding=mark),),
    )
    look = Look(
        image=picture,
        stances={"box": layout.read({"box": box})["box"]},
        masks={"box": box},
        regions={"table": part},
        found=segments(picture),
        covered=box,
        offers={"table": [part]},
    )
    return with_tops(Case("x", picture, "x", (), (), (), "The box falls."), state, look)


@pytest.mark.parametrize("share", [0.65, 0.2, 0.02])
def test_a_click_gets_the_whole_top_however_little_of_it_its_mask_is(share: float):
    picture, table, box = _drawn(CORNER)
    part = table & (np.arange(SIZE[0]) > SIZE[0] * (1 - share))
    seen, tops = _seen(picture, box, part, Grounding(points=(Click(x=450, y=280),)))
    assert "table" in tops
    assert iou(seen.regions["table"], table) > 0.97


def test_a_mask_that_a_person_has_chosen_stays():
    picture, table, box = _drawn(CORNER)
    part = table & (np.arange(SIZE[0]) > SIZE[0] * 0.8)
    mark = Grounding(points=(Click(x=450, y=280),), settled=True)
    seen, tops = _seen(picture, box, part, mark)
    assert not tops
    assert np.array_equal(seen.regions["table"], part)


def test_a_mask_of_which_the_colour_clicked_is_only_a_part_stays():
    """A table of two colours, whose mask holds both."""
    picture, table, box = _drawn(CORNER)
    left = table & (np.arange(SIZE[0]) < SIZE[0] * 0.55)
    picture[left & ~box] = np.clip(picture[left & ~box] * (0.4, 0.8, 1.6), 0, 255).astype(np.uint8)
    whole = table & (np.arange(SIZE[0]) > SIZE[0] * 0.1)
    seen, tops = _seen(picture, box, whole, Grounding(points=(Click(x=200, y=200),)))
    assert not tops
    assert np.array_equal(seen.regions["table"], whole)


def _with_front():
    """(picture, top, front, box) of a table whose dark front is seen below its near edge."""
    near, far = 0.48, 0.9
    corners = ((-0.3, near), (0.3, near), (0.3, far), (-0.3, far))
    picture, top, box = _drawn(corners)
    low = [(-0.3, near, TOP), (0.3, near, TOP), (0.3, near, TOP - 0.03), (-0.3, near, TOP - 0.03)]
    front = cv2.fillPoly(np.zeros(top.shape, np.uint8), [_pixels(low)], 1) > 0
    front &= ~top & ~box
    picture[front] = (45, 32, 24)
    return picture, top, front, box


def _clicked_front(front) -> Grounding:
    rows, columns = np.nonzero(front)
    return Grounding(points=(Click(x=float(np.median(columns)), y=float(np.median(rows))),))


def test_a_click_on_the_front_gets_the_whole_top_of_which_a_part_has_grown_with_it():
    picture, top, front, box = _with_front()
    grown = (top | front) & (np.arange(SIZE[0]) < SIZE[0] * 0.88)
    seen, tops = _seen(picture, box, grown, _clicked_front(front))
    assert "table" in tops
    assert iou(seen.regions["table"], top) > 0.9


def test_a_front_alone_tells_no_top():
    """Though the box stands right above it, no more than a part of the top has grown with it."""
    picture, top, front, box = _with_front()
    rim = grow(front, 6) & (top | front)
    seen, tops = _seen(picture, box, rim, _clicked_front(front))
    assert not tops
    assert np.array_equal(seen.regions["table"], rim)


@pytest.mark.parametrize("place", [(40, 250), (440, 200)])
def test_a_click_on_a_table_does_not_shrink_it_to_the_mat_on_which_a_thing_stands(place):
    picture, table, box = _drawn(FULL)
    ends = [(-0.3, 0.42, TOP), (0.3, 0.42, TOP), (0.3, 0.7, TOP), (-0.3, 0.7, TOP)]
    mat = cv2.fillPoly(np.zeros(table.shape, np.uint8), [_pixels(ends)], 1) > 0
    picture[mat & table] = (60, 120, 60)
    x, y = place
    seen, tops = _seen(picture, box, table, Grounding(points=(Click(x=x, y=y),)))
    assert not tops
    assert np.array_equal(seen.regions["table"], table)


@pytest.mark.parametrize("place", [(420, 200), (420, 280), (350, 230)])
def test_a_click_on_one_colour_of_a_table_keeps_the_mask_of_both(place):
    picture, table, box = _drawn(CORNER)
    left = table & (np.arange(SIZE[0]) < SIZE[0] * 0.55)
    picture[left & ~box] = np.clip(picture[left & ~box] * (0.4, 0.8, 1.6), 0, 255).astype(np.uint8)
    x, y = place
    seen, tops = _seen(picture, box, table, Grounding(points=(Click(x=x, y=y),)))
    assert not tops
    assert np.array_equal(seen.regions["table"], table)


def test_a_speck_of_a_boxed_table_gives_way_to_the_top_in_its_box():
    picture, table, box = _drawn(CORNER)
    speck = table & (np.hypot(*(np.indices(table.shape) - [[[180]], [[250]]])) < 8)
    x0, y0, x1, y1 = bounds(table)
    mark = Grounding(points=(Click(x=250, y=180),), box=(x0, y0, x1 - 40, y1))
    seen, tops = _seen(picture, box, speck, mark)
    inside = table & (np.arange(SIZE[0]) < x1 - 40)
    assert "table" in tops
    assert iou(seen.regions["table"], inside) > 0.97


@pytest.fixture(scope="module")
def scene():
    picture, _, _ = _drawn(CORNER)
    x, y = CAMERA.project(np.array([(0.0, 0.5, TOP + 0.04)]))[0][0]
    mark = Grounding(points=(Click(x=float(x), y=float(y)),))
    state = SceneState(
        camera=CAMERA,
        horizon=CAMERA.horizon,
        objects=(SceneObject(name="box", grounding=mark),),
        supports=(Support(name="table"),),
    )
    case = Case("x", picture, "x", (("box", mark),), (), (), "The box is pushed off the table.")
    return reconstruct(case, state)


def test_the_table_is_a_slab_over_a_floor_that_is_not_seen(scene):
    table, floor = scene.state.support("table").shape, scene.state.support("floor").shape
    assert isinstance(table, Slab)
    assert isinstance(floor, Floor)
    assert table.position[2] + table.size[2] / 2 == pytest.approx(TOP, abs=1e-6)
    assert scene.state.object("box").support == "table"
    assert any("known by the sentence alone" in flag for flag in scene.state.flags)


def test_its_edges_are_where_the_picture_shows_them(scene):
    table = scene.state.support("table").shape
    x, y, _ = table.position
    assert table.yaw == pytest.approx(0.0, abs=0.03)
    assert x - table.size[0] / 2 == pytest.approx(-0.22, abs=0.02)
    assert y + table.size[1] / 2 == pytest.approx(0.8, abs=0.05)
    # To the right it goes on to where the picture ends, and a bit further.
    right = CAMERA.project(np.array([(x + table.size[0] / 2, y, TOP)]))[0][0, 0]
    assert right > SIZE[0]


def test_a_second_look_keeps_it(scene):
    case = Case("x", scene.photo, "x", (), (), (), "The box is pushed off the table.")
    again = reconstruct(case, scene.state, previous=scene)
    assert again.state.support("table") == scene.state.support("table")
