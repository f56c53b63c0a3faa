"""What is on wheels drives along its axis and is steered to where the prompt has it go."""

from __future__ import annotations

import math

import numpy as np
import pytest

from physagent_studio.agent.rules import RuleGenerator
from physagent_studio.program import PhysicalProgram
from physagent_studio.program.actions import OnContact, duration_of
from physagent_studio.program.rotations import about_up, matrix_of
from physagent_studio.program.scene.state import Box, Cylinder
from physagent_studio.simulation import simulate
from tests.agent.rules.scenes import STAGES, Stage

CAR = (0.2, 0.1, 0.08)
CONE = (Cylinder(radius=0.05, height=0.16), (0.75, 2.5, 0.08), "floor")


def driven(prompt: str, *, turn: float = 0.0, cone: bool = False):
    """The path (steps, 2) of a car of 20 cm that lies along a direction, and its headings, deg."""
    things = {"toy_car": (Box(size=CAR), (0.0, 2.5, CAR[2] / 2), "floor")}
    things |= {"traffic_cone": CONE} if cone else {}
    stage = Stage("yard", things, turns={"toy_car": about_up(math.radians(turn))})
    program: PhysicalProgram = RuleGenerator().first(stage.case(prompt), stage.reconstruct)
    item = program.scene.object("toy_car")
    assert item is not None
    assert item.wheels is not None
    rollout = simulate(program)
    index = [one.name for one in program.scene.objects].index("toy_car")
    turns = [matrix_of(one.tolist()) for one in rollout.rotations[:, index]]
    angles = np.unwrap([math.atan2(m[1, 0], m[0, 0]) for m in turns])
    return rollout.positions[:, index, :2], np.degrees(angles - angles[0])


@pytest.mark.parametrize(
    ("prompt", "low", "high"),
    [
        ("The toy car drives to the right and turns left.", 60, 100),
        ("The toy car drives to the right and turns right.", -100, -60),
        ("The toy car drives to the right, then turns away from the camera.", 60, 100),
        ("The toy car drives to the left, then turns toward the camera.", 60, 100),
    ],
)
def test_it_turns_to_the_side_that_is_said(prompt, low, high):
    path, headings = driven(prompt)
    assert low < headings[-1] < high
    # It goes where it faces: the last of its way is turned as it is.
    first, last = path[40] - path[10], path[-1] - path[-60]
    bent = math.degrees(math.atan2(first[0] * last[1] - first[1] * last[0], first @ last))
    assert bent == pytest.approx(headings[-1], abs=12)


def test_it_turns_around_and_drives_back():
    path, headings = driven("The toy car drives to the right, turns around and drives back.")
    assert abs(headings[-1]) == pytest.approx(180, abs=12)
    assert path[:, 0].max() > path[-1, 0] + 0.05


def test_it_drives_in_a_circle():
    _, headings = driven("The toy car drives in a circle.")
    assert abs(headings[-1]) > 270


def test_it_drives_around_what_stands_in_its_way_and_does_not_touch_it():
    path, headings = driven("The toy car drives around the traffic cone.", cone=True)
    gap = np.linalg.norm(path - CONE[1][:2], axis=1).min()
    assert gap > 0.05 + CAR[1] / 2
    assert path[-1, 0] > CONE[1][0]
    assert np.ptp(headings) > 30


def test_at_the_foot_of_a_ramp_it_is_driven_back_while_it_turns():
    """What it has from the ramp would take it out of the picture before it has turned."""
    stage = STAGES["slope"]
    prompt = "The toy car rolls down the ramp and turns around after reaching the bottom."
    program = RuleGenerator().first(stage.case(prompt), stage.reconstruct)
    acts = {action.id: action for action in program.event.actions}
    turn, back = acts["turn_toy_car"], acts["back_toy_car"]
    assert isinstance(turn.when, OnContact)
    assert isinstance(back.when, OnContact)
    assert turn.when.delay < back.when.delay < turn.when.delay + duration_of(turn)
