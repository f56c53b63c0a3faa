"""Statements about what touches, carries, lets go and comes to rest."""

import numpy as np
import pytest

from physagent_studio.program.scene.bodies import Soft
from physagent_studio.program.scene.state import Box, SceneObject

SIDE = (1, 0, 0)


def test_touching_from_the_start_says_so(stage):
    stage.touch("cube", "floor")
    check = stage.check("contacts", subject="cube", other="floor")
    assert check.ok
    assert check.text == "cube touches floor: yes, from the start"


def test_contact_is_the_same_from_either_side(stage):
    stage.touch("cube", "ball", [30])
    assert stage.check("contacts", subject="ball", other="cube").ok
    assert stage.check("contacts", subject="cube", other="ball").ok
    assert not stage.check("contacts", subject="can", other="cube").ok


def test_a_contact_outside_the_window_does_not_count(stage):
    stage.touch("ball", "cube", [30])
    assert not stage.check("contacts", subject="ball", other="cube", to_step=29).ok
    assert stage.check("contacts", subject="ball", other="cube", to_step=29, negated=True).ok
    assert not stage.check("contacts", subject="ball", other="cube", from_step=31).ok


def test_a_miss_gets_better_as_it_gets_nearer(new_stage, time):
    margins = []
    for beside in (1.0, 0.7, 0.4, 0.25):
        stage = new_stage().path("ball", x=time, y=-beside)
        margins.append(stage.check("contacts", subject="ball", other="cube").margin)
    assert margins == sorted(margins)
    assert margins[-1] < 0


def test_touching_a_landmark_means_that_a_part_comes_to_it(stage, time):
    stage.path("ball", x=0.45 * time)  # its front passes 0.5, its centre does not
    assert stage.check("contacts", subject="ball", other="line").ok
    assert not stage.check("passes_over", subject="ball", landmark="line").ok


def test_rests_on_needs_rest_and_a_push_from_below(stage, time):
    stage.touch("cube", "floor")
    assert stage.check("rests_on", subject="cube", other="floor").ok
    stage.path("cube", x=1 + time)
    moving = stage.check("rests_on", subject="cube", other="floor")
    assert not moving.ok
    assert "still moving" in moving.text
    assert stage.check("reaches", subject="cube", other="floor").ok


def test_leaning_on_something_is_not_resting_on_it(stage):
    stage.touch("can", "cube", normal=SIDE).touch("can", "floor")
    leaning = stage.check("rests_on", subject="can", other="cube")
    assert not leaning.ok
    assert "from the side" in leaning.text
    assert not stage.check("reaches", subject="can", other="cube").ok


def test_a_stack_rests_on_what_is_directly_below(stage):
    stage.objects["book"] = SceneObject(
        name="book", shape=Box(size=(0.2, 0.2, 0.1)), position=(1, 0, 0.25)
    )
    stage.touch("book", "cube").touch("cube", "floor")
    assert stage.check("rests_on", subject="book", other="cube").ok
    assert stage.check("rests_on", subject="cube", other="floor").ok
    assert not stage.check("rests_on", subject="book", other="floor").ok
    assert not stage.check("rests_on", subject="cube", other="book").ok  # it is pushed down


def test_the_normal_points_from_a_to_b_whoever_is_a(stage):
    stage.touch("floor", "cube", normal=(0, 0, 1))
    assert stage.check("rests_on", subject="cube", other="floor").ok


def test_bouncing_between_two_touches_still_reaches(stage):
    stage.touch("ball", "floor", [40, 60, 75, 85, 92, 97])
    check = stage.check("reaches", subject="ball", other="floor")
    assert check.ok
    assert check.step == 75  # from then on the bounces are shorter than a tenth of a second


def test_leaves_is_for_good(stage, time):
    stage.path("cube", z=0.1 + np.maximum(0, time - 0.3)).touch("cube", "floor", range(31))
    check = stage.check("leaves", subject="cube", other="floor")
    assert check.ok
    assert check.step == 31
    stage.touch("cube", "floor", range(90, 101))
    assert not stage.check("leaves", subject="cube", other="floor").ok


def test_what_is_held_leaves_nothing(stage, time):
    stage.path("cube", z=0.1 + np.maximum(0, time - 0.3)).touch("cube", "floor", range(31))
    assert stage.check("leaves", subject="cube", other="floor").ok
    held = Soft(young=2e4, pinned="bottom")
    stage.objects["cube"] = stage.objects["cube"].model_copy(update={"body": held})
    check = stage.check("leaves", subject="cube", other="floor")
    assert not check.ok
    assert "held where it stands" in check.text


def test_leaves_needs_to_have_touched(stage):
    stage.path("ball", z=1.0)
    check = stage.check("leaves", subject="ball", other="floor")
    assert not check.ok
    assert "never touches" in check.text


def test_leaving_gets_better_as_it_nears_the_edge(new_stage, time):
    margins = []
    for way in (0.0, 0.2, 0.4):
        stage = new_stage()
        stage.path("cube", x=3 + way * time, z=1.1).touch("cube", "table")
        margins.append(stage.check("leaves", subject="cube", other="table").margin)
    assert margins == sorted(margins)
    assert margins[0] < margins[-1] < 0


def test_stops_needs_a_motion_before(stage, time):
    stage.path("ball", x=np.minimum(time, 0.5))
    assert stage.check("stops", subject="ball").ok
    still = stage.check("stops", subject="can")
    assert not still.ok
    assert "before it stops, moves" in still.text
    stage.path("ball", x=time)
    assert not stage.check("stops", subject="ball").ok


def test_a_spinning_ball_has_not_stopped(stage, time):
    stage.path("ball", x=np.minimum(time, 0.5)).turn("ball", (0, 0, 1), 400 * time)
    assert not stage.check("stops", subject="ball").ok


def test_stops_near_a_place(stage, time):
    stage.path("ball", x=np.minimum(2 * time, 0.9))
    assert stage.check("stops", subject="ball", near="spot", distance=0.2).ok
    far = stage.check("stops", subject="ball", near="goal", distance=0.2)
    assert not far.ok
    assert "ends away from goal by" in far.text


@pytest.mark.parametrize(("end", "ok"), [(0.3, True), (0.42, False), (0.6, False)])
def test_stops_before_a_line_with_its_front(stage, time, end, ok):
    stage.path("ball", x=np.minimum(2 * time, end))  # radius 0.1, line at 0.5
    assert stage.check("stops_before", subject="ball", before="line").ok is ok


def test_stops_before_a_body(stage, time):
    stage.path("ball", x=np.minimum(2 * time, 0.5))
    assert stage.check("stops_before", subject="ball", before="cube").ok
    stage.touch("ball", "cube", [40], normal=SIDE)
    assert not stage.check("stops_before", subject="ball", before="cube").ok


def test_what_never_moves_does_not_stop_before_anything(stage):
    assert not stage.check("stops_before", subject="ball", before="cube").ok


def test_overshooting_less_is_better(new_stage, time):
    margins = []
    for end in (1.0, 0.8, 0.6, 0.5):
        stage = new_stage().path("ball", x=np.minimum(2 * time, end))
        margins.append(stage.check("stops_before", subject="ball", before="line").margin)
    assert margins == sorted(margins)
