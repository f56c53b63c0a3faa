"""What a person marks although other things stand on it becomes a support."""

import numpy as np
import pytest

from physagent_studio.program.scene.state import Click, Grounding
from physagent_studio.records import Case
from physagent_studio.workbench.bearers import with_supports


def _case(prompt, **boxes):
    marks = tuple((name, Grounding(box=box)) for name, box in boxes.items())
    picture = np.zeros((480, 832, 3), np.uint8)
    return Case("photo", picture, "", marks, (), (), prompt)


def _names(case):
    return [name for name, _ in case.objects], [one.name for one in case.supports]


PLANK = {"ball": (69, 100, 138, 170), "plank": (1, 128, 548, 327), "box": (660, 226, 748, 324)}


def test_a_plank_that_a_ball_rolls_down_is_a_ramp_that_is_clicked_under_the_ball():
    case = with_supports(_case("The ball rolls down the plank and hits the box.", **PLANK))
    assert _names(case) == (["ball", "box"], ["plank_ramp"])
    grounding = case.supports[0].grounding
    assert grounding.box == PLANK["plank"]
    assert grounding.points == (Click(x=103.5, y=173.5),)


def test_what_props_a_slope_is_part_of_the_picture_unless_it_is_spoken_of():
    boxes = {**PLANK, "blue_block": (55, 190, 150, 322)}
    case = with_supports(_case("The ball rolls down the plank.", **boxes))
    assert _names(case) == (["ball", "box"], ["plank_ramp"])
    told = with_supports(_case("The ball rolls down the plank past the blue block.", **boxes))
    assert "blue_block" in _names(told)[0]


TABLE = {"bottle": (572, 61, 620, 221), "table": (60, 165, 775, 470)}


@pytest.mark.parametrize(
    ("prompt", "bears"),
    [
        ("The bottle tips over.", True),
        ("The bottle rolls off the table.", True),
        ("The table tips over.", False),
        ("The bottle falls as the table is pushed to the left.", False),
    ],
)
def test_a_table_carries_what_stands_on_it_unless_the_sentence_moves_it(prompt, bears):
    objects, supports = _names(with_supports(_case(prompt, **TABLE)))
    assert (objects, supports) == ((["bottle"], ["table"]) if bears else (["bottle", "table"], []))


@pytest.mark.parametrize("name", ["console", "chest_of_drawers", "hearthstone"])
def test_wide_furniture_of_any_name_carries_what_stands_on_it(name):
    boxes = {"bottle": TABLE["bottle"], name: TABLE["table"]}
    assert _names(with_supports(_case("The bottle slides to the left.", **boxes)))[1] == [name]
    moved = with_supports(_case(f"The bottle falls as the {name} is pushed to the left.", **boxes))
    assert not _names(moved)[1]


def test_what_stands_in_front_of_a_table_does_not_make_it_a_support():
    boxes = {**TABLE, "bottle": (300, 350, 340, 460)}
    assert _names(with_supports(_case("The bottle tips over.", **boxes)))[1] == []


def test_what_is_told_to_fall_off_a_table_stands_on_it_in_any_part_of_its_box():
    boxes = {"desk": (0, 0, 800, 300), "mug": (500, 200, 550, 250)}
    assert _names(with_supports(_case("The mug tips over.", **boxes)))[1] == []
    case = with_supports(_case("The mug slides to the right and falls off the desk.", **boxes))
    assert case.supports[0].grounding.points == (Click(x=525, y=252.5),)


@pytest.mark.parametrize(("width", "bears"), [(30, True), (120, False)])
def test_a_block_is_the_ground_of_what_is_decidedly_narrower(width, bears):
    boxes = {"cube": (100, 60, 100 + width, 100), "big_block": (20, 70, 232, 186)}
    case = with_supports(_case("The cube slides off the big block.", **boxes))
    assert _names(case)[1] == (["big_block"] if bears else [])


def test_a_surface_alone_stays_a_thing():
    assert (
        _names(with_supports(_case("The tray slides to the left.", tray=(1, 1, 99, 99))))[1] == []
    )
    said = "The ball rolls down the ramp."
    assert _names(with_supports(_case(said, ramp=(1, 1, 99, 99)))) == (["ramp"], [])


TINS = {"left_tin": (277, 93, 349, 190), "right_tin": (353, 94, 426, 190)}


@pytest.mark.parametrize("bottom", [500, 190])
def test_things_on_a_wall_stand_on_its_top_whether_its_front_is_marked_too(bottom):
    said = "The left tin falls off the wall."
    case = with_supports(_case(said, **TINS, wall=(0, 157, 900, bottom)))
    assert _names(case) == (["left_tin", "right_tin"], ["wall_ledge"])
    rows = [mark.y for mark in case.supports[0].grounding.marks]
    assert rows[2:] == [157, 157]
    assert 190 < rows[0] == rows[1] < 200


def test_what_stands_before_a_wall_does_not_stand_on_it():
    boxes = {"tin": (277, 393, 349, 490), "wall": (0, 157, 900, 420)}
    assert _names(with_supports(_case("The tin falls over.", **boxes)))[1] == []


SEAT = {"cup": (300, 100, 400, 170), "armrest": (250, 160, 460, 400)}


@pytest.mark.parametrize(
    ("prompt", "bears"),
    [
        ("The cup slides off the armrest and falls.", True),
        ("The cup on the armrest tips over and rolls down from it.", True),
        ("The cup slides to the left.", False),
        ("The cup bounces off the armrest.", False),
        ("The cup jumps onto the armrest and off it again.", False),
        ("The armrest slides to the left and the cup falls off the armrest.", False),
    ],
)
def test_what_a_thing_is_told_to_leave_bears_it_whatever_it_is_called(prompt, bears):
    case = with_supports(_case(prompt, **SEAT))
    assert _names(case)[1] == (["armrest"] if bears else [])


@pytest.mark.parametrize(("bottom", "feet"), [(400, 1), (480, 0)])
def test_the_top_of_what_is_seen_from_the_side_ends_before_the_feet_on_it(bottom, feet):
    boxes = {**SEAT, "armrest": (250, 160, 460, bottom)}
    (found,) = with_supports(_case("The cup slides off the armrest.", **boxes)).supports
    rows = [y for _, y in found.grounding.marked("top")]
    assert rows[2:] == [160, 160]
    assert 170 < rows[0] == rows[1] < 180
    assert len(found.grounding.marked("foot")) == feet


def test_what_is_seen_elsewhere_does_not_stand_on_what_it_is_told_to_leave():
    boxes = {**SEAT, "cup": (600, 100, 660, 170)}
    assert _names(with_supports(_case("The cup slides off the armrest.", **boxes)))[1] == []


@pytest.mark.parametrize(("name", "bears"), [("tree", False), ("stool", True), ("barrel", False)])
def test_of_known_things_those_without_a_plain_form_bear_what_is_seen_above_them(name, bears):
    rows = (100, 170) if name != "tree" else (180, 220)
    boxes = {"toy": (300, rows[0], 400, rows[1]), name: (250, 160, 460, 400)}
    assert _names(with_supports(_case(f"The toy falls off the {name}.", **boxes)))[1] == (
        [name] if bears else []
    )
