"""What a check says is what an English reader reads."""

import numpy as np
import pytest

from physagent_studio.contract import describe
from physagent_studio.contract.words import number


def test_a_contact_names_its_frame(stage, time):
    stage.path("ball", x=time).touch("ball", "cube", [70, 71], normal=(1, 0, 0))
    check = stage.check("contacts", subject="ball", other="cube")
    assert check.text == "ball touches cube: yes, frame 17"
    assert check.step == 70


def test_a_miss_says_by_how_much_and_when(stage, time):
    stage.path("ball", x=time, y=-0.31 - 0.2)
    check = stage.check("contacts", subject="ball", other="cube")
    assert check.text.startswith("ball touches cube: no, comes within 0.31 m at frame 2")


def test_a_figure_is_compared_with_its_threshold(stage, time):
    stage.turn("can", (1, 0, 0), 2 * time)
    assert stage.check("upright", subject="can").text == "can tilts 2° ≤ 20°: yes"
    stage.turn("can", (1, 0, 0), 25 * time)
    assert stage.check("upright", subject="can").text == "can tilts 25° ≤ 20°: no"
    negated = stage.check("upright", subject="can", negated=True)
    assert negated.text == "can tilts 25° > 20°: yes"


def test_a_bound_is_said_the_way_it_is_demanded(stage):
    program = stage.program(
        {"id": "a", "kind": "topples", "subject": "can", "tilt": 135, "negated": True},
        {"id": "b", "kind": "stays", "subject": "can", "negated": True},
        {"id": "c", "kind": "upright", "subject": "can", "negated": True},
        {"id": "d", "kind": "topples", "subject": "can", "most": 125, "onto": "away"},
    )
    assert [describe(one, program) for one in program.contract.statements] == [
        "can does not topple (tilts less than 135°)",
        "can does not stay in place (moves more than 0.03 m or tilts more than 15°)",
        "can does not stand upright at the end (tilts more than 20°)",
        "can topples onto the side that faced away from the camera (tilts at least 45°, at most "
        "125°)",
    ]


def test_describe_needs_no_rollout(stage):
    program = stage.program(
        {"id": "a", "kind": "contacts", "subject": "ball", "other": "cube", "negated": True},
        {"id": "b", "kind": "stays", "subject": "can", "from_step": 40},
        {"id": "c", "kind": "before", "first": "a", "second": "b"},
    )
    lines = [describe(one, program) for one in program.contract.statements]
    assert lines == [
        "ball does not touch cube",
        "can stays in place (moves at most 0.03 m, tilts at most 15°), from frame 10 on",
        "ball does not touch cube, before can stays in place",
    ]


def test_what_alternatives_share_is_said_once(stage):
    touches = {"kind": "contacts", "subject": "ball"}
    program = stage.program(
        {"id": "can", **touches, "other": "can"},
        {"id": "cube", **touches, "other": "cube"},
        {"id": "by_can", "kind": "contacts", "subject": "can", "other": "cube"},
        {"id": "not_cube", **touches, "other": "cube", "negated": True},
        {"id": "same_start", "kind": "any_of", "of": ["can", "cube"]},
        {"id": "same_end", "kind": "any_of", "of": ["cube", "by_can"]},
        {"id": "denied", "kind": "all_of", "of": ["can", "not_cube"]},
        {"id": "unlike", "kind": "all_of", "of": ["can", "by_can"]},
        {"id": "one", "kind": "all_of", "of": ["same_start"]},
    )
    assert [describe(one, program) for one in program.contract.statements[4:]] == [
        "ball touches can or cube",
        "ball or can touches cube",
        "ball touches can and ball does not touch cube",
        "ball touches can and can touches cube",
        "ball touches can or cube",
    ]


def test_a_bound_on_one_side_is_said_as_one(stage):
    fast, slow, both = (
        {"kind": "speed_between", "subject": "ball", **bounds}
        for bounds in ({"low": 0.7}, {"high": 1}, {"low": 0.02, "high": 1})
    )
    first = {"kind": "contacts", "subject": "ball", "other": "cube", "to_step": 1}
    rows = [{"id": f"s{n}", **row} for n, row in enumerate((fast, slow, both, first))]
    program = stage.program(*rows)
    assert [describe(one, program) for one in program.contract.statements] == [
        "ball gets fast enough (at least 0.7 m/s)",
        "ball stays slow enough (at most 1 m/s)",
        "ball has the right top speed (0.02 to 1 m/s)",
        "ball touches cube, to begin with",
    ]


def test_a_measured_number_is_in_every_text(stage, time):
    stage.path("ball", z=1 - np.minimum(time, 0.5))
    assert stage.check("falls", subject="ball").text == "ball falls 0.5 m ≥ 0.02 m: yes, frame 0"


def test_figures_that_differ_look_different(stage, time):
    stage.turn("can", (1, 0, 0), 20.04 * time)
    assert stage.check("upright", subject="can").text == "can tilts 20.04° ≤ 20°: no"


@pytest.mark.parametrize(
    ("metres", "text"),
    [(0.31, "0.31 m"), (0.0012, "0.001 m"), (0.0004, "0.4 mm"), (-0.0001, "-0.1 mm"), (0.0, "0 m")],
)
def test_less_than_a_millimetre_is_said_in_millimetres(metres: float, text: str) -> None:
    assert number(metres, "m") == text
