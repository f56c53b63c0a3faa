"""The physics that has to hold whatever the prompt says."""

import numpy as np
import pytest

from physagent_studio.records import ActionSpan

NAMES = ("blow_up", "penetration", "energy", "cause", "sink")


def test_a_quiet_scene_passes_all_and_they_come_last(stage):
    stage.touch("cube", "floor").touch("can", "floor").touch("ball", "floor")
    checks = stage.checks({"id": "s", "kind": "stays", "subject": "can"})
    assert [check.id for check in checks] == ["s", *(f"physics.{name}" for name in NAMES)]
    assert all(check.ok for check in checks)
    assert [check.always_on for check in checks] == [False] + [True] * len(NAMES)


def test_a_blow_up_fails_with_its_reason(stage):
    stage.blow_up(50)
    check = stage.always("blow_up")
    assert not check.ok
    assert check.step == 50
    assert "left all bounds" in check.text


def test_a_deep_overlap_fails_and_a_short_one_is_a_blow(stage):
    stage.touch("ball", "cube", range(20, 40), depth=0.03)
    lasting = stage.always("penetration")
    assert not lasting.ok
    assert "ball and cube overlap by 30 mm" in lasting.text


def test_the_moment_of_a_blow_may_be_deeper(stage):
    stage.touch("ball", "cube", [20], depth=0.03)
    assert stage.always("penetration").ok


def test_what_overlapped_in_frame_0_is_ignored_and_said(stage):
    stage.touch("ball", "cube", depth=0.03)
    check = stage.always("penetration")
    assert check.ok
    assert "30 mm from the start" in check.text


def test_the_tolerance_grows_with_the_object(stage):
    from physagent_studio.program.scene.state import Box

    stage.touch("cube", "floor", range(20, 40), depth=0.03)
    assert not stage.always("penetration").ok
    stage.objects["cube"] = stage.objects["cube"].model_copy(
        update={"shape": Box(size=(2.0, 2.0, 2.0))}
    )
    assert stage.always("penetration").ok


def test_energy_from_nowhere_fails(stage, time):
    stage.path("ball", x=np.maximum(0, time - 0.5) * 3)
    check = stage.always("energy")
    assert not check.ok
    assert check.measured == pytest.approx(4.5, rel=0.05)


def test_energy_from_an_action_is_fine_up_to_its_work(stage, time):
    stage.actions = [
        {"id": "push", "name": "ball", "operator": "ApplyForce", "force": [3, 0, 0], "duration": 90}
    ]
    stage.path("ball", x=1.5 * time**2)
    stage.spans = [ActionSpan("push", 0, 100, 4.5)]
    assert stage.always("energy").ok
    stage.spans = [ActionSpan("push", 0, 100, 0.5)]
    assert not stage.always("energy").ok


def test_holding_something_is_no_excuse_for_energy(stage, time):
    stage.actions = [{"id": "hold", "name": "can", "operator": "FixObject", "duration": 90}]
    stage.spans = [ActionSpan("hold", 0, 100, 0.0)]
    stage.path("ball", x=np.maximum(0, time - 0.5) * 3)
    assert not stage.always("energy").ok


def test_a_bounce_may_store_energy_for_a_moment(stage, time):
    height = np.abs(np.cos(6 * np.pi * time)) * (1 - 0.5 * time)
    stage.path("ball", z=0.1 + height)
    stage.touch("ball", "floor", [8, 25, 41, 58, 75, 91])
    rollout = stage.rollout()
    rollout.kinetic[:, 0] = 0.0
    rollout.potential[:, 0] = 9.81 * (2 - time)  # what a bounce loses, step by step
    rollout.potential[[8, 25, 41, 58, 75, 91], 0] -= 5  # and what sits in the contact
    from physagent_studio.contract import measure

    check = next(c for c in measure(stage.program(), rollout) if c.id == "physics.energy")
    assert check.ok, check.text


def test_what_lies_still_does_not_start_by_itself(stage, time):
    stage.path("cube", x=1 + np.maximum(0, time - 0.5)).touch("cube", "floor")
    check = stage.always("cause")
    assert not check.ok
    assert "cube starts to move" in check.text
    assert check.step == pytest.approx(50, abs=3)


@pytest.mark.parametrize("cause", ["action", "contact", "no support"])
def test_a_cause_excuses_the_start(stage, time, cause):
    stage.path("cube", x=1 + np.maximum(0, time - 0.5))
    if cause == "action":
        stage.touch("cube", "floor")
        stage.actions = [
            {"id": "p", "name": "cube", "operator": "ApplyForce", "force": [3, 0, 0], "duration": 9}
        ]
        stage.spans = [ActionSpan("p", 48, 57, 0.5)]
    elif cause == "contact":
        stage.touch("cube", "floor").touch("ball", "cube", [49])
    assert stage.always("cause").ok


def test_sliding_down_is_paid_by_height(stage, time):
    slid = 0.5 * 2 * np.maximum(0, time - 0.3) ** 2
    stage.path("cube", x=1 + slid, z=1 - 0.3 * slid).touch("cube", "table")
    assert stage.always("cause").ok


@pytest.mark.parametrize("later", ["action", "body", "nothing"])
def test_what_an_action_adds_later_is_not_asked_of_the_height(stage, time, later):
    slid = 0.5 * 2 * np.maximum(0, time - 0.3) ** 2
    raised = 3 * np.maximum(0, time - 0.55) ** 2
    stage.path("cube", x=1 + slid, z=1 - 0.3 * slid + raised).touch("cube", "table")
    if later == "action":
        stage.actions = [
            {"id": "p", "name": "cube", "operator": "ApplyForce", "force": [0, 0, 9],
             "start_step": 54, "duration": 20}
        ]  # fmt: skip
        stage.spans = [ActionSpan("p", 54, 74, 2.0)]
    elif later == "body":
        stage.touch("ball", "cube", list(range(54, 90)))
    assert stage.always("cause").ok == (later != "nothing")


def test_sinking_through_the_floor_fails_even_without_a_contact(stage, time):
    stage.path("ball", z=0.1 - 0.5 * time)
    check = stage.always("sink")
    assert not check.ok
    assert "ball sinks into floor" in check.text


def test_inside_a_table_fails_and_starting_there_does_not(stage, time):
    stage.path("ball", x=3 * time, z=0.5)
    assert not stage.always("sink").ok
    stage.path("ball", x=3.0, z=0.5)
    assert stage.always("sink").ok


def test_what_stands_on_level_ground_does_not_fall_over_by_itself(stage, time):
    stage.turn("can", (0, 1, 0), np.clip(200 * (time - 0.3), 0, 90)).touch("can", "floor")
    check = stage.always("cause")
    assert not check.ok
    assert "can falls over by itself at frame 10" in check.text
    stage.touch("ball", "can", [25])
    assert stage.always("cause").ok


def test_what_hangs_over_an_edge_may_fall(stage, time):
    stage.path("can", x=3.52, y=0.0, z=1.1)
    stage.turn("can", (0, 1, 0), 90 * time).touch("can", "table", range(60))
    assert stage.always("cause").ok
    stage.path("can", x=3.2, y=0.0, z=1.1)
    assert not stage.always("cause").ok
