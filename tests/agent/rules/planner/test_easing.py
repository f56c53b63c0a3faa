"""Easing: the gentlest program that still holds everything, and nothing else changed."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from physagent_studio.agent.rules import Easing
from physagent_studio.agent.rules.planner.easing import EASING
from physagent_studio.agent.rules.planner.trials import TRIAL
from physagent_studio.contract import Facts
from physagent_studio.contract.track import Window
from physagent_studio.program import PhysicalProgram, SetField, apply, value_at
from physagent_studio.records import Memory, Proposal
from physagent_studio.simulation import simulate
from tests.agent.rules.filmed import BALL, failing, filmed, push, rolling, situation_of, try_out

SPEED = "event.actions.push_ball.force.magnitude"


def speed_of(program: PhysicalProgram) -> float:
    value = value_at(program, SPEED)
    assert isinstance(value, float)
    return value


def knocking(speed: float) -> PhysicalProgram:
    """A ball that strikes a post, which has to fall over for it."""
    post = {
        "name": "post", "shape": {"kind": "box", "size": [0.06, 0.06, 0.4]},
        "position": [0.2, 4.0, 0.2], "support": "floor", "density": 100,
    }  # fmt: skip
    hit = {"id": "hit", "kind": "contacts", "subject": "ball", "other": "post"}
    over = {"id": "over", "kind": "topples", "subject": "post"}
    return filmed([BALL | {"rolling": 0.03}, post], [push(speed)], hit, over)


def margins(program: PhysicalProgram) -> dict[str, float]:
    return {c.id: c.margin for c in try_out(program).checks if c.demanded}


@pytest.fixture(scope="module")
def hard() -> PhysicalProgram:
    program = knocking(1.5)
    assert failing(program) == []
    return program


@pytest.fixture(scope="module")
def eased(hard: PhysicalProgram) -> Proposal:
    return Easing().ease(situation_of(hard))


def test_the_speeds_are_lowered_and_everything_still_holds(
    hard: PhysicalProgram, eased: Proposal
) -> None:
    gentle = apply(hard, eased.edits)
    assert eased.factor == "easing"
    assert EASING.min_ratio * speed_of(hard) <= speed_of(gentle) < 0.95 * speed_of(hard)
    assert failing(gentle) == []


def test_margins_that_were_sturdy_stay_sturdy(hard: PhysicalProgram, eased: Proposal) -> None:
    before, after = margins(hard), margins(apply(hard, eased.edits))
    assert before.keys() == after.keys()
    for check, margin in before.items():
        assert after[check] >= min(TRIAL.sturdy_margin, margin), check


def test_each_goes_nearly_as_far(hard: PhysicalProgram, eased: Proposal) -> None:
    runs = [try_out(one).rollout for one in (hard, apply(hard, eased.edits))]
    for index in range(len(runs[0].objects)):
        before, after = (abs(r.positions[:, index] - r.positions[0, index]).max() for r in runs)
        assert after >= 0.9 * EASING.min_way_share * before


def test_what_is_met_is_not_met_more_gently_than_is_seen() -> None:
    """A ball rolls to the right and meets another, of which nothing else is told."""
    other = BALL | {"name": "other", "position": [0.5, 4.0, 0.1]}
    hit = {"id": "hit", "kind": "contacts", "subject": "ball", "other": "other"}
    hard = filmed([BALL | {"rolling": 0.03}, other | {"rolling": 0.03}], [push(1.2)], hit)
    gentle = apply(hard, Easing().ease(situation_of(hard)).edits)
    far = [try_out(one).rollout.positions[:, 1, 0].max() - 0.5 for one in (hard, gentle)]
    assert far[1] >= 0.9 * EASING.min_way_share * far[0] > 0.05


@pytest.mark.parametrize(("place", "speed"), [(0.05, 0.5), (0.08, 0.7)])
def test_nothing_is_pushed_through_what_it_meets(place: float, speed: float) -> None:
    other = BALL | {"name": "other", "position": [place, 4.0, 0.1], "rolling": 0.03}
    hit = {"id": "hit", "kind": "contacts", "subject": "ball", "other": "other"}
    ball = BALL | {"position": [-0.2, 4.0, 0.1], "rolling": 0.03}
    hard = filmed([ball, other], [push(speed)], hit)
    gentle = apply(hard, Easing().ease(situation_of(hard)).edits)
    rollout = try_out(gentle).rollout
    between = (rollout.contacts["a"] == 0) & (rollout.contacts["b"] == 1)
    met = int(rollout.contacts["step"][between].min())
    assert all(span.end is not None and span.end <= met for span in rollout.spans)


def test_only_how_hard_it_is_pushed_is_changed(hard: PhysicalProgram, eased: Proposal) -> None:
    assert [edit.path for edit in eased.edits if isinstance(edit, SetField)] == [SPEED]
    gentle = apply(hard, eased.edits)
    assert gentle.scene == hard.scene
    assert gentle.contract == hard.contract
    assert gentle.clip == hard.clip


def test_it_costs_few_runs(eased: Proposal) -> None:
    assert 0 < eased.simulations <= EASING.max_runs


def test_the_same_program_is_eased_alike(hard: PhysicalProgram, eased: Proposal) -> None:
    assert Easing().ease(situation_of(hard)) == eased


def test_what_is_pinned_is_not_eased(hard: PhysicalProgram) -> None:
    situation = replace(situation_of(hard), memory=Memory(pinned=(SPEED,)))
    proposal = Easing().ease(situation)
    assert proposal.hunks == ()
    assert proposal.simulations == 0


def test_the_gentlest_is_left_as_it_is() -> None:
    """A ball that just rolls for as long as it has to: any slower and it goes less far."""
    program = rolling(0.27)
    assert failing(program) == []
    proposal = Easing().ease(situation_of(program))
    assert proposal.hunks == ()
    assert "nothing gentler" in proposal.rationale


def test_where_nothing_is_pushed_the_clip_keeps_its_frames() -> None:
    falls = filmed(
        [BALL | {"position": [0.0, 4.0, 1.2], "support": "air"}],
        [],
        {"id": "falls", "kind": "falls", "subject": "ball"},
    )
    assert Easing().ease(situation_of(falls)).hunks == ()


def test_what_topples_is_not_left_on_its_edge() -> None:
    """The gentlest push that suffices would have it hang there."""
    post = {
        "name": "post", "shape": {"kind": "box", "size": [0.25, 0.25, 0.4]},
        "position": [0.0, 4.0, 0.2], "support": "floor", "density": 100,
    }  # fmt: skip
    tipped = push(1.0) | {"id": "tip_post", "name": "post", "point": [-0.125, 0.0, 0.18]}
    tipped |= {"duration": 15, "force": tipped["force"] | {"elevation": 35}}
    program = filmed([post], [tipped], {"id": "over", "kind": "topples", "subject": "post"})
    slow = program.clip.model_copy(update={"steps_per_frame": 1})
    program = program.model_copy(update={"clip": slow})
    assert failing(program) == []
    found = Easing().ease(situation_of(program))
    gentle = apply(program, found.edits) if found.hunks else program
    tilt = Facts.of(gentle, simulate(gentle, {})).track("post", Window(0, gentle.clip.steps)).tilt()
    low, high = EASING.balance_deg
    between = np.count_nonzero((tilt > low) & (tilt < high)) * gentle.clip.step_seconds
    assert found.hunks
    assert between <= EASING.max_balance_s


def downhill(held: int) -> PhysicalProgram:
    """A ball on a slope that is brought to a slow speed, and held at it for so many steps."""
    slope = {
        "kind": "ramp", "toe": [0.9, 4.0, 0.0], "yaw": np.pi, "run": 1.8, "rise": 0.5, "width": 0.6,
    }  # fmt: skip
    place = [-0.6, 4.0, 0.5 * (0.9 + 0.6) / 1.8 + 0.11 * np.hypot(0.5, 1.8) / 1.8]
    moves = {"id": "moves", "kind": "moves", "subject": "ball", "distance": 0.5}
    state = filmed(
        [BALL | {"position": place, "rolling": 0.1}], [push(0.3, duration=held)], moves
    ).model_dump()
    state["scene"]["supports"] += ({"name": "ramp", "shape": slope},)
    state["scene"]["objects"][0]["support"] = "ramp"
    slow = PhysicalProgram.model_validate(state)
    return slow.model_copy(update={"clip": slow.clip.model_copy(update={"steps_per_frame": 4})})


def creeps(program: PhysicalProgram) -> float:
    """After how much of its time the ball has gone a fifth of its way."""
    steps = np.linalg.norm(np.diff(simulate(program, {}).positions[:, 0], axis=0), axis=1)
    steps = steps[steps > 0.02 * steps.max()]
    return float(np.argmax(np.cumsum(steps) > 0.2 * steps.sum()) / len(steps))


def test_what_goes_down_a_slope_is_not_held_back_for_most_of_its_time() -> None:
    """A push to a lower speed, for longer, holds it back there: it creeps, and then it rushes."""
    program = downhill(130)
    assert failing(program) == []
    found = Easing().ease(situation_of(program))
    gentle = apply(program, found.edits) if found.hunks else program
    assert found.hunks
    assert creeps(gentle) < max(creeps(program), EASING.max_start_share) + 0.03
