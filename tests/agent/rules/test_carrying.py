"""What a hand takes up is brought where the sentence has it, and stands there when it is over."""

from __future__ import annotations

import numpy as np
import pytest

from physagent_studio.agent.rules import RuleGenerator
from physagent_studio.agent.rules.planner.parameters import action_knobs
from physagent_studio.arrays import FloatArray
from physagent_studio.contract.measure import measure
from physagent_studio.language import inventory, read
from physagent_studio.program import PhysicalProgram
from physagent_studio.program.scene.state import Box, Cylinder, Grounding, Sphere
from physagent_studio.simulation import simulate
from tests.agent.rules.scenes import Stage

CUP, BOOK, BALL = (-0.25, 3.0, 0.05), (0.1, 3.0, 0.02), (0.4, 2.9, 0.035)
DESK = Stage(
    "desk",
    {
        "cup": (Cylinder(radius=0.04, height=0.1), CUP, "floor"),
        "book": (Box(size=(0.2, 0.15, 0.04)), BOOK, "floor"),
        "ball": (Sphere(radius=0.035), BALL, "floor"),
    },
)


def _run(prompt: str) -> tuple[PhysicalProgram, FloatArray]:
    """The first program, whose demands hold, and the way of the cup (T, 3)."""
    program = RuleGenerator().first(DESK.case(prompt), DESK.reconstruct)
    assert not program.contract.untested
    rollout = simulate(program, {})
    missed = [c for c in measure(program, rollout) if c.demanded and c.kind != "view" and not c.ok]
    assert not missed, [check.text for check in missed]
    return program, np.asarray(rollout.positions[:, rollout.index("cup")])


@pytest.mark.parametrize(
    ("prompt", "end"),
    [
        ("Someone picks up the cup and puts it on the book.", (0.1, 3.0, 0.09)),
        ("The cup is taken off the floor and placed on the book.", (0.1, 3.0, 0.09)),
        ("The cup is lifted over the book and put down to the right of the book.", (0.3, 3, 0.05)),
        ("Someone puts the cup next to the ball.", (0.29, 2.92, 0.05)),
        ("The cup is lifted, held in the air for a moment and gently put back down.", CUP),
        ("The cup is raised and then lowered gently.", CUP),
    ],
)
def test_it_ends_where_it_is_put(prompt: str, end: tuple[float, float, float]) -> None:
    _, path = _run(prompt)
    np.testing.assert_allclose(path[-1], end, atol=0.04)
    np.testing.assert_allclose(path[-1, 2], end[2], atol=0.005)
    assert path[:, 2].max() > max(end[2], CUP[2]) + 0.03
    assert np.ptp(path[-20:], axis=0).max() < 1e-3


@pytest.mark.parametrize(
    "prompt",
    [
        "The cup is lifted up by someone and carried off to the left.",
        "The cup is picked up and moved to the left.",
    ],
)
def test_what_is_carried_off_stays_in_the_hand(prompt: str) -> None:
    _, path = _run(prompt)
    assert path[-1, 0] < CUP[0] - 0.05
    assert path[-1, 2] > path[0, 2] + 0.05


def test_what_is_dropped_onto_a_thing_is_let_go_over_it() -> None:
    program, path = _run("Someone picks up the cup and drops it onto the book.")
    assert "lower_cup" not in {action.id for action in program.event.actions}
    assert path[:, 2].max() > BOOK[2] * 2 + 0.07
    np.testing.assert_allclose(path[-1, :2], BOOK[:2], atol=0.1)


def test_it_is_not_lifted_through_what_stands_between() -> None:
    _, path = _run("The cup is picked up and put down to the right of the ball.")
    over = np.abs(path[:, 0] - BOOK[0]) < 0.14
    assert over.any()
    assert (path[over, 2] > 0.09).all()


def test_after_is_what_was_done_to_it_is_told_on_without_another_is() -> None:
    stock = inventory([(n, Grounding()) for n in ("ball", "cup")], [("table", Grounding())], [])
    up, down = read("The ball is picked up and put into the cup.", stock).frames
    assert (up.sense, up.patient) == ("rise", ("ball",))
    assert (down.sense, down.patient, down.agent) == ("set_down", ("ball",), ())
    assert [place.name for _, place in down.places] == ["cup"]


def test_who_lifts_it_carries_it_after_a_comma_too() -> None:
    stock = inventory([("cup", Grounding())], [("table", Grounding())], [])
    found = read("Someone picks up the cup, carries it to the left and puts it down.", stock)
    assert not found.not_understood
    assert [(f.sense, f.patient, f.cause) for f in found.frames] == [
        (sense, ("cup",), "person") for sense in ("rise", "push", "set_down")
    ]


@pytest.mark.parametrize(
    ("prompt", "least", "most"),
    [
        ("The cup is lifted and tilted to the left.", 40.0, 60.0),
        ("The cup is picked up and turned upside down.", 170.0, 180.0),
        ("Someone lifts the cup, turns it upside down and puts it back down.", 170.0, 180.0),
        ("The cup is picked up, tilted and put down again.", 0.0, 5.0),
    ],
)
def test_what_is_turned_in_the_hand_stays_turned_there(
    prompt: str, least: float, most: float
) -> None:
    program = RuleGenerator().first(DESK.case(prompt), DESK.reconstruct)
    rollout = simulate(program, {})
    missed = [c for c in measure(program, rollout) if c.demanded and c.kind != "view" and not c.ok]
    assert not missed, [check.text for check in missed]
    _, x, y, _ = rollout.rotations[-1, rollout.index("cup")]
    up = 1 - 2 * (x * x + y * y)
    assert least <= np.degrees(np.arccos(np.clip(up, -1, 1))) <= most
    assert np.ptp(rollout.positions[:, rollout.index("cup"), :2], axis=0).max() < 0.03


def test_what_carries_the_weight_is_no_strength_to_be_tried() -> None:
    program = RuleGenerator().first(
        DESK.case("Someone picks up the cup and puts it on the book."), DESK.reconstruct
    )
    strengths = {k.path for k in action_knobs(program) if k.factor == "magnitude"}
    assert "event.actions.lift_cup.force.magnitude" in strengths
    assert "event.actions.hold_cup.force.magnitude" not in strengths
