"""Statements about how things move and turn, on paths written by hand."""

import numpy as np
import pytest


def test_moves_along_a_direction_only(stage, time):
    stage.path("ball", x=0.3 * time)
    right = stage.check("moves", subject="ball", distance=0.2, direction="right")
    assert right.ok
    assert right.measured == pytest.approx(0.3)
    assert right.step == 67  # 0.201 m
    assert not stage.check("moves", subject="ball", distance=0.2, direction="left").ok
    assert not stage.check("moves", subject="ball", distance=0.2, direction="up").ok
    assert stage.check("moves", subject="ball", distance=0.2).ok


def test_moves_towards_a_place_means_closer_to_where_it_was(stage, time):
    stage.path("cube", x=1 - 0.5 * time)  # the cube comes; the ball does nothing
    assert not stage.check("moves", subject="ball", toward="cube", distance=0.1).ok
    stage.path("ball", x=0.5 * time)
    assert stage.check("moves", subject="ball", toward="cube", distance=0.1).ok
    assert stage.check("moves", subject="ball", toward="line", distance=0.1).ok
    assert not stage.check("moves", subject="ball", toward="goal", distance=0.1).ok


def test_moves_and_comes_back_has_moved(stage, time):
    stage.path("ball", x=np.sin(np.pi * time))
    assert stage.check("moves", subject="ball", distance=0.9).ok


def test_falls_counts_from_the_highest_point(stage, time):
    stage.path("ball", z=0.1 + time * (1 - time))  # thrown up by 0.25 and down again
    check = stage.check("falls", subject="ball", drop=0.2)
    assert check.ok
    assert check.measured == pytest.approx(0.25, abs=1e-3)
    stage.path("ball", z=0.1 + time)
    assert not stage.check("falls", subject="ball").ok


def test_topples_is_judged_at_the_end(stage, time):
    stage.turn("can", (0, 1, 0), np.minimum(120 * time, 90))
    check = stage.check("topples", subject="can")
    assert check.ok
    assert check.step == 38  # 45.6°
    stage.turn("can", (0, 1, 0), 50 * np.sin(np.pi * time))  # tips and comes back
    back = stage.check("topples", subject="can")
    assert not back.ok
    assert "came back" in back.text


@pytest.mark.parametrize(("angle", "lies"), [(90, True), (120, True), (149, False), (180, False)])
def test_what_lies_on_a_side_is_not_upside_down(stage, time, angle, lies):
    for thing in ("can", "cube"):
        stage.turn(thing, (0, 1, 0), angle * time)
        assert stage.check("topples", subject=thing, tilt=60).ok
        assert stage.check("topples", subject=thing, tilt=60, most=125).ok is lies


def test_what_lies_on_its_back_has_that_side_down(stage, time):
    stage.turn("cube", (0, 1, 0), 90 * time)  # to the right
    onto = stage.check("topples", subject="cube", onto="right")
    assert onto.ok
    for side in ("left", "away", "up"):
        assert not stage.check("topples", subject="cube", onto=side).ok
    assert "faced to the left" in stage.check("topples", subject="cube", onto="left").text


def test_a_rolling_ball_neither_topples_nor_stands(stage, time):
    stage.path("ball", x=time).turn("ball", (0, 1, 0), 573 * time)
    assert not stage.check("topples", subject="ball").ok
    assert stage.check("upright", subject="ball").ok
    assert not stage.check("flips", subject="ball").ok
    assert not stage.check("stays", subject="ball").ok
    assert stage.check("rotates", subject="ball", angle=500).ok


def test_a_ball_spinning_on_the_spot_stays(stage, time):
    stage.turn("ball", (1, 0, 0), 300 * time)
    assert stage.check("stays", subject="ball").ok


def test_a_lying_can_rolls_without_tilting(stage, time):
    from physagent_studio.program.rotations import about_axis, multiply

    lying = about_axis((1, 0, 0), np.pi / 2)  # its axis along y
    rolled = [multiply(about_axis((0, 1, 0), float(a)), lying) for a in np.radians(400 * time)]
    stage.path("can", x=0.35 * time)
    stage.turns["can"] = np.array(rolled)
    stage.turns["can.rate"] = np.tile([0, np.radians(400), 0], (len(time), 1))
    assert stage.check("upright", subject="can").measured == pytest.approx(0, abs=1e-6)
    assert not stage.check("topples", subject="can").ok
    assert not stage.check("flips", subject="can").ok


def test_a_box_turned_about_the_vertical_does_not_tilt(stage, time):
    stage.turn("cube", (0, 0, 1), 180 * time)
    assert stage.check("upright", subject="cube").measured == pytest.approx(0, abs=1e-6)
    assert stage.check("stays", subject="cube").ok


def test_stays_is_broken_by_a_tilt_or_a_shift(stage, time):
    assert stage.check("stays", subject="cube").ok
    stage.turn("cube", (1, 0, 0), 16 * np.sin(np.pi * time))
    tilted = stage.check("stays", subject="cube")
    assert not tilted.ok
    assert tilted.unit == "°"
    stage.turn("cube", (1, 0, 0), 0).path("cube", x=1 + 0.04 * time)
    shifted = stage.check("stays", subject="cube")
    assert not shifted.ok
    assert shifted.unit == "m"
    assert shifted.step in (75, 76)


def test_a_window_moves_the_reference(stage, time):
    stage.path("cube", x=np.where(time < 0.3, 1 + time, 1.3))
    assert not stage.check("stays", subject="cube").ok
    assert stage.check("stays", subject="cube", from_step=40).ok
    assert stage.check("moves", subject="cube", distance=0.2, to_step=30).ok
    assert not stage.check("moves", subject="cube", distance=0.2, to_step=10).ok


def test_flips_to_a_side(stage, time):
    stage.turn("cube", (0, -1, 0), 120 * time)  # the top goes left
    assert stage.check("flips", subject="cube", direction="left").ok
    assert not stage.check("flips", subject="cube", direction="right").ok
    assert stage.check("flips", subject="cube").ok
    stage.turn("cube", (0, 0, 1), 400 * time)
    assert not stage.check("flips", subject="cube").ok


def test_rocking_does_not_add_up_to_a_flip_or_a_turn(stage, time):
    stage.turn("cube", (0, 1, 0), 10 * np.sin(20 * np.pi * time))
    assert not stage.check("flips", subject="cube").ok
    assert not stage.check("rotates", subject="cube", angle=45, axis=(0, 1, 0)).ok


def test_rotates_about_an_axis_either_way(stage, time):
    stage.turn("cube", (0, 0, 1), -100 * time)
    assert stage.check("rotates", subject="cube", angle=90, axis=(0, 0, 1)).ok
    assert not stage.check("rotates", subject="cube", angle=90, axis=(1, 0, 0)).ok


def test_trembling_is_no_rotation(stage, time):
    stage.turn("cube", (0, 1, 0), 0.2 * np.sin(300 * time))
    assert not stage.check("rotates", subject="cube", angle=5).ok


def test_airborne_needs_clear_air(stage, time):
    stage.path("ball", z=0.1 + np.maximum(0, time * (0.6 - time)))
    stage.touch("ball", "floor", range(60, 101))
    check = stage.check("airborne", subject="ball", seconds=0.4)
    assert check.ok
    assert check.measured == pytest.approx(0.58, abs=0.03)
    stage.path("ball", z=0.1 + 0.0005 * np.sin(np.pi * time))  # half a millimetre is no flight
    assert not stage.check("airborne", subject="ball").ok


def test_what_is_held_does_not_fly(stage):
    from physagent_studio.records import ActionSpan

    stage.path("ball", z=1.0)
    assert stage.check("airborne", subject="ball").ok
    stage.actions = [{"id": "hold", "name": "ball", "operator": "FixObject", "duration": 100}]
    stage.spans = [ActionSpan("hold", 0, 100, 0.0)]
    assert not stage.check("airborne", subject="ball").ok


def test_speed_between_has_two_sides(stage, time):
    stage.path("ball", x=2 * time)
    assert stage.check("speed_between", subject="ball", low=1, high=3).ok
    slow = stage.check("speed_between", subject="ball", low=3)
    fast = stage.check("speed_between", subject="ball", high=1)
    assert not slow.ok
    assert not fast.ok
    assert "≤ 1 m/s" in fast.text


def test_descends_slowly_is_about_the_way_down(stage, time):
    stage.path("cube", x=1 + 3 * time, z=2 - 0.3 * time)
    assert stage.check("descends_slowly", subject="cube", drop=0.2, speed=0.5).ok
    stage.path("cube", z=2 - time)
    assert not stage.check("descends_slowly", subject="cube", drop=0.2, speed=0.5).ok
    stage.path("cube", z=2 - 0.1 * time)
    assert not stage.check("descends_slowly", subject="cube", drop=0.2, speed=0.5).ok


@pytest.mark.parametrize(("sign", "side", "other"), [(1, "right", "left"), (-1, "left", "right")])
def test_path_bends_as_the_mover_sees_it(stage, time, sign, side, other):
    angle = np.radians(40) * time * sign
    stage.path("ball", x=2 * np.cumsum(np.sin(angle)) * 0.01, y=2 * np.cumsum(np.cos(angle)) * 0.01)
    assert stage.check("path_bends", subject="ball", side=side, angle=30).ok
    assert not stage.check("path_bends", subject="ball", side=other, angle=5).ok
    assert stage.check("path_bends", subject="ball", side="either", angle=30).ok


def test_path_bends_as_the_picture_shows_what_comes_closer(stage, time):
    angle = np.radians(40) * time
    stage.path(
        "ball", x=2 * np.cumsum(np.sin(angle)) * 0.01, y=5 - 2 * np.cumsum(np.cos(angle)) * 0.01
    )
    assert stage.check("path_bends", subject="ball", side="right", angle=30).ok


def test_an_impact_is_no_bend_but_may_be_a_reversal(stage, time):
    stage.path("ball", x=np.where(time < 0.5, time, 1 - time))
    assert not stage.check("path_bends", subject="ball").ok
    check = stage.check("reverses", subject="ball")
    assert check.ok
    assert check.measured == pytest.approx(180, abs=1)


def test_a_u_turn_reverses_and_a_straight_path_does_not(stage, time):
    angle = np.pi * time
    stage.path("ball", x=np.sin(angle), y=1 - np.cos(angle))
    assert stage.check("reverses", subject="ball", angle=150).ok
    stage.path("ball", x=time)
    assert not stage.check("reverses", subject="ball", angle=10).ok
    stage.path("ball", x=0.0)
    assert not stage.check("reverses", subject="ball").ok


def test_a_short_rebound_is_no_way_from_which_a_ball_turns_back(stage, time):
    shape = ([0, 0.3, 0.4, 1], [0.9, 0, 0.01, -0.4])
    stage.path("ball", x=np.interp(time, *shape))
    assert not stage.check("reverses", subject="ball", angle=90).ok
    stage.path("ball", x=np.interp(time, [0, 0.3, 1], [0.9, 0, 0.4]))
    assert stage.check("reverses", subject="ball", angle=90).ok


def test_a_level_speed_leaves_a_fall_out(stage, time):
    stage.path("ball", x=0.5 * time, z=20 - 4.9 * time**2)
    assert not stage.check("speed_between", subject="ball", high=1).ok
    level = stage.check("speed_between", subject="ball", high=1, level=True)
    assert level.ok
    assert "top level speed of 0.5 m/s" in level.text
    stage.path("ball", x=2 * time)
    assert not stage.check("speed_between", subject="ball", high=1, level=True).ok
