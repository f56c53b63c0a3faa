"""What rolls or slides and then falls over does one after the other, and lies still."""

from __future__ import annotations

import pytest

from physagent_studio.agent.rules import RuleGenerator
from physagent_studio.contract.measure import measure
from physagent_studio.program import PhysicalProgram
from physagent_studio.program.actions import SetAngularVelocity
from physagent_studio.program.rotations import matrix_of
from physagent_studio.program.scene.state import Box, Cylinder, Sphere
from physagent_studio.simulation import simulate
from tests.agent.rules.scenes import STAGES, Stage


def _first(prompt: str) -> PhysicalProgram:
    return RuleGenerator().first(STAGES["shelf"].case(prompt), STAGES["shelf"].reconstruct)


@pytest.mark.parametrize(
    "prompt",
    [
        "The domino slides to the left, slows down and falls over.",
        "The domino moves to the left, loses speed and topples.",
    ],
)
def test_it_is_tipped_when_it_has_gone(prompt: str) -> None:
    program = _first(prompt)
    push, *_, tip = program.event.actions
    assert (push.id, tip.id) == ("push_domino", "tip_domino")
    assert tip.start_step >= push.start_step + getattr(push, "duration", 0)
    kinds = {statement.kind for statement in program.contract.statements}
    assert {"topples", "stops"} <= kinds
    assert not program.contract.untested


def test_what_slows_down_and_goes_on_is_not_told() -> None:
    assert _first("The domino slides to the left and slows down.").contract.untested


@pytest.mark.parametrize("ratio", [0.4, 1.0, 1.7])
@pytest.mark.parametrize("round_", [True, False])
def test_the_wide_are_lifted_at_the_rear_and_tip_over_as_the_slender_do(ratio, round_) -> None:
    high, wide = 0.3, 0.3 * ratio
    body = Cylinder(radius=wide / 2, height=high) if round_ else Box(size=(wide, wide, high))
    yard = Stage("yard", {"crate": (body, (0.0, 3.0, high / 2), "floor")})
    program = RuleGenerator().first(yard.case("The crate tips over to the left."), yard.reconstruct)
    demanded = [c for c in measure(program, simulate(program, {})) if c.demanded]
    assert all(check.ok for check in demanded if not check.always_on), demanded


@pytest.mark.parametrize(
    ("prompt", "way"),
    [
        ("The tin tips over and rolls into the crate.", 1),
        ("The tin falls over and rolls away to the left.", -1),
    ],
)
def test_what_is_round_rolls_on_when_it_lies(prompt: str, way: int) -> None:
    things = {
        "tin": (Cylinder(radius=0.04, height=0.11), (0.0, 3.0, 0.055), "floor"),
        "crate": (Box(size=(0.2, 0.4, 0.2)), (0.7, 2.95, 0.1), "floor"),
    }
    yard = Stage("kitchen", things)
    program = RuleGenerator().first(yard.case(prompt), yard.reconstruct)
    rollout = simulate(program, {})
    demanded = [c for c in measure(program, rollout) if c.demanded and not c.always_on]
    assert all(check.ok for check in demanded), demanded
    tin, early = rollout.index("tin"), len(rollout.positions) // 3
    upright = matrix_of(rollout.rotations[early, tin])[2, 2]
    assert abs(upright) < 0.3
    assert abs(rollout.positions[early, tin, 0]) < 0.06
    assert way * rollout.positions[-1, tin, 0] > 0.2


@pytest.mark.parametrize(
    "prompt",
    [
        "The domino falls over to the right and knocks the ball away.",
        "The domino topples to the right and pushes the ball away.",
    ],
)
def test_what_falls_over_and_knocks_a_near_thing_away_falls_onto_it(prompt: str) -> None:
    things = {
        "domino": (Box(size=(0.05, 0.1, 0.24)), (-0.1, 3.0, 0.12), "floor"),
        "ball": (Sphere(radius=0.04), (0.06, 3.0, 0.04), "floor"),
    }
    yard = Stage("yard", things)
    program = RuleGenerator().first(yard.case(prompt), yard.reconstruct)
    (tip,) = program.event.actions
    assert tip.id == "tip_domino"
    kinds = {statement.kind for statement in program.contract.statements}
    assert {"topples", "contacts", "moves"} <= kinds


def test_what_is_wide_is_tilted_slowly_over_its_edge() -> None:
    """Thrown over by a push it would turn on, or fly: it comes to lie on its side beside itself."""
    court = STAGES["court"]
    program = RuleGenerator().first(
        court.case("The crate tips over to the left."), court.reconstruct
    )
    (tip,) = program.event.actions
    assert isinstance(tip, SetAngularVelocity)
    rollout = simulate(program, {})
    places = rollout.positions[:, rollout.index("crate")]
    item = program.scene.object("crate")
    assert item is not None
    checks = {check.id: check for check in measure(program, rollout)}
    assert all(check.ok for name, check in checks.items() if "tossed" in name or "place" in name)
    assert checks["crate_topples"].ok
    assert checks["crate_topples"].measured == pytest.approx(90, abs=15)
    assert places[-1, 0] < places[0, 0]


@pytest.mark.parametrize(
    "prompt",
    [
        "A gust of wind knocks over the blue cup; it falls to the right and comes to rest on the "
        "table.",
        "The blue cup falls to the right and lies on the table.",
        "The blue cup tips over and falls to the right.",
    ],
)
def test_the_fall_of_what_goes_over_is_the_same_and_off_nothing(prompt: str) -> None:
    desk = STAGES["desk"]
    program = RuleGenerator().first(desk.case(prompt), desk.reconstruct)
    assert {s.kind for s in program.contract.statements} <= {
        "topples", "moves", "stops", "rests_on",
    }  # fmt: skip
    assert [action.id for action in program.event.actions] == ["tip_blue_cup"]
    demanded = [c for c in measure(program, simulate(program, {})) if c.demanded]
    assert all(check.ok for check in demanded if not check.always_on), demanded


@pytest.mark.parametrize(
    "prompt",
    [
        "The blue cup tips over and falls off the table.",
        "The blue cup tips over and falls to the floor.",
        "The blue cup tips over, falls to the right and comes to rest on the floor.",
        "The blue cup falls to the right.",
    ],
)
def test_what_falls_to_another_place_leaves_what_it_stood_on(prompt: str) -> None:
    desk = STAGES["desk"]
    program = RuleGenerator().first(desk.case(prompt), desk.reconstruct)
    assert "falls" in {s.kind for s in program.contract.statements}


def test_what_falls_to_a_told_side_rolls_across_it() -> None:
    """No way is told in which it rolls: it lies along the side to which it fell."""
    tin = {"tin": (Cylinder(radius=0.04, height=0.11), (0.0, 3.0, 0.055), "floor")}
    yard = Stage("kitchen", tin)
    words = "The tin tips over to the right and rolls a little on the floor."
    program = RuleGenerator().first(yard.case(words), yard.reconstruct)
    rollout = simulate(program, {})
    checks = {check.id: check for check in measure(program, rollout)}
    assert checks["tin_topples"].ok
    assert checks["view.lean.tin"].ok
    away = rollout.positions[-1, 0] - rollout.positions[len(rollout.positions) // 3, 0]
    assert abs(away[1]) > abs(away[0])
