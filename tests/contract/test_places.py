"""Statements about landmarks: lines, areas, openings, points."""

import numpy as np
import pytest

from physagent_studio.contract.track import inside_depth
from physagent_studio.program.scene.state import Landmark


def test_a_line_counts_between_its_ends_only(stage, time):
    stage.path("ball", x=time)
    assert stage.check("passes_over", subject="ball", landmark="line").ok
    stage.path("ball", x=time, y=1.5)
    beside = stage.check("passes_over", subject="ball", landmark="line")
    assert not beside.ok
    assert "0.5 m beside it" in beside.text


def test_a_line_is_crossed_from_either_side(stage, time):
    stage.path("cube", x=1 - time)
    assert stage.check("passes_over", subject="cube", landmark="line").ok
    stage.path("cube", x=1 - 0.4 * time)
    short = stage.check("passes_over", subject="cube", landmark="line")
    assert not short.ok
    assert "0.1 m short" in short.text


@pytest.mark.parametrize("over", [-0.02, 0.02])
def test_what_overhangs_the_edge_of_its_table_passes_it_outward(stage, time, over):
    stage.landmarks.append(
        Landmark(name="brink", kind="line", on="table", points=((2.5, -0.5, 1), (2.5, 0.5, 1)))
    )
    stage.path("cube", x=2.5 - over - 0.5 * time, z=1.1)
    assert stage.check("passes_over", subject="cube", landmark="brink").ok
    stage.path("cube", x=2.5 - over + 0.2 * time, z=1.1)
    inward = stage.check("passes_over", subject="cube", landmark="brink")
    assert inward.ok == (over > 0)


def test_a_line_across_a_table_is_no_edge_of_it(stage, time):
    stage.landmarks.append(
        Landmark(name="stripe", kind="line", on="table", points=((2.8, -0.5, 1), (2.8, 0.5, 1)))
    )
    for way in (-0.2, 0.2):
        stage.path("cube", x=2.78 + way * time, z=1.1)
        crossed = stage.check("passes_over", subject="cube", landmark="stripe")
        assert crossed.ok == (way > 0)


def test_passing_a_point_is_going_further_along(stage, time):
    stage.path("ball", x=1.2 * time, y=0.1)
    assert stage.check("passes_over", subject="ball", landmark="spot").ok
    stage.path("ball", x=0.8 * time)
    assert not stage.check("passes_over", subject="ball", landmark="spot").ok


def test_lands_in_an_area_is_judged_at_the_end(stage, time):
    stage.path("ball", x=np.minimum(2 * time, 1.0))
    assert stage.check("lands_in", subject="ball", landmark="circle").ok
    stage.path("ball", x=2 * time)  # through and out again
    through = stage.check("lands_in", subject="ball", landmark="circle")
    assert not through.ok
    assert through.margin < 0


def test_above_an_area_is_not_in_it(stage, time):
    stage.path("ball", x=np.minimum(2 * time, 1.0), z=1.0)
    assert not stage.check("lands_in", subject="ball", landmark="circle").ok


def test_an_opening_wants_the_way_through(stage, time):
    stage.path("ball", y=3 * time, z=0.5)
    assert stage.check("lands_in", subject="ball", landmark="goal").ok
    assert stage.check("passes_over", subject="ball", landmark="goal").ok
    stage.path("ball", x=0.8, y=3 * time, z=0.5)  # past the post
    past = stage.check("lands_in", subject="ball", landmark="goal")
    assert not past.ok
    assert "misses it by 0.3 m" in past.text
    stage.path("ball", y=3 * time, z=1.4)  # over the bar
    assert not stage.check("lands_in", subject="ball", landmark="goal").ok
    stage.path("ball", y=1.5 * time, z=0.5)  # not there yet
    short = stage.check("lands_in", subject="ball", landmark="goal")
    assert "within 0.5 m" in short.text


def test_out_of_the_goal_again_is_not_in_it(stage, time):
    stage.path("ball", y=2.5 * np.sin(np.pi * time), z=0.5)
    assert stage.check("passes_over", subject="ball", landmark="goal").ok
    assert not stage.check("lands_in", subject="ball", landmark="goal").ok


def test_corners_may_be_clicked_crosswise(stage, time):
    corners = stage.landmarks[2].points
    crossed = (corners[0], corners[2], corners[1], corners[3])
    stage.landmarks[2] = stage.landmarks[2].model_copy(update={"points": crossed})
    stage.path("ball", y=3 * time, z=0.5)
    assert stage.check("lands_in", subject="ball", landmark="goal").ok


def test_two_posts_make_an_opening(stage, time):
    posts = ((-0.5, 2, 0), (0.5, 2, 0))
    stage.landmarks[2] = stage.landmarks[2].model_copy(update={"points": posts})
    stage.path("ball", y=3 * time, z=0.5)
    assert stage.check("lands_in", subject="ball", landmark="goal").ok
    stage.path("ball", x=0.8, y=3 * time, z=0.5)
    assert not stage.check("lands_in", subject="ball", landmark="goal").ok


def test_landing_on_a_table(stage, time):
    stage.path("ball", x=3.0, z=2 - np.minimum(time, 0.9))
    assert stage.check("lands_in", subject="ball", landmark="table").ok
    stage.path("ball", x=3.8, z=2 - np.minimum(time, 0.9))
    assert not stage.check("lands_in", subject="ball", landmark="table").ok
    stage.path("ball", x=3.0, z=0.1)  # below the top
    assert not stage.check("lands_in", subject="ball", landmark="table").ok


def test_passing_over_the_edge_of_a_table(stage, time):
    stage.path("ball", x=3 + time, z=1.1)
    assert stage.check("passes_over", subject="ball", landmark="table").ok
    stage.path("ball", x=3 + 0.4 * time, z=1.1)
    assert not stage.check("passes_over", subject="ball", landmark="table").ok


def test_the_floor_has_no_edge(stage, time):
    stage.path("ball", x=time)
    check = stage.check("passes_over", subject="ball", landmark="floor")
    assert not check.ok
    assert check.measured is None
    assert not stage.check("passes_over", subject="ball", landmark="floor", negated=True).ok


def test_an_unplaced_landmark_fails_both_ways(stage, time):
    stage.path("ball", x=time)
    for negated in (False, True):
        check = stage.check("passes_over", subject="ball", landmark="nowhere", negated=negated)
        assert not check.ok
        assert "has not been found" in check.text


def test_nearer_to_the_goal_is_better(new_stage, time):
    margins = []
    for beside in (2.0, 1.2, 0.8, 0.6, 0.3):
        stage = new_stage().path("ball", x=beside, y=3 * time, z=0.5)
        margins.append(stage.check("lands_in", subject="ball", landmark="goal").margin)
    assert margins == sorted(margins)
    assert margins[-2] < 0 < margins[-1]


def test_going_further_is_better(new_stage, time):
    margins = []
    for way in (0.1, 0.3, 0.45, 0.55):
        stage = new_stage().path("ball", x=way * time)
        margins.append(stage.check("passes_over", subject="ball", landmark="line").margin)
    assert margins == sorted(margins)
    assert margins[-2] < 0 < margins[-1]


def test_inside_depth_of_a_concave_outline():
    outline = np.array([[0, 0], [4, 0], [4, 4], [2, 1], [0, 4]], float)
    points = np.array([[2, 0.5], [2, 3], [0.5, 1], [-1, 0]])
    depth = inside_depth(points, outline)
    assert depth[0] == pytest.approx(0.41, abs=0.1)
    assert depth[1] < 0
    assert depth[2] > 0
    assert depth[3] == pytest.approx(-1)
