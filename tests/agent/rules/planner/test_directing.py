"""The director: the same event within the picture and slow enough, by closed forms."""

from __future__ import annotations

import numpy as np
import pytest

from physagent_studio.agent.rules import RulePlanner
from physagent_studio.agent.rules.planner.directing import (
    DIRECTING,
    direct,
    is_sudden,
    replanned,
    shown_of,
)
from physagent_studio.program import PhysicalProgram, apply, value_at
from physagent_studio.program.actions import ApplyForce, Directed
from physagent_studio.records import Memory, Rollout
from physagent_studio.simulation import simulate
from tests.agent.rules.filmed import BALL, failing, filmed, push, rolling, situation_of

SPEED = "event.actions.push_ball.force.magnitude"


def speed_of(program: PhysicalProgram) -> float:
    value = value_at(program, SPEED)
    assert isinstance(value, float)
    return value


def run_of(program: PhysicalProgram) -> Rollout:
    return simulate(program, {})


@pytest.mark.parametrize("seed", [1, 2, 3])
def test_what_was_pushed_out_of_the_picture_is_brought_back_and_slowed(seed: int) -> None:
    speed = float(np.random.default_rng(seed).uniform(2.5, 9.0))
    program = rolling(speed)
    assert "view.inside.ball" in failing(program)
    proposal = RulePlanner(limit=40).propose(situation_of(program))
    mended = apply(program, proposal.edits)
    assert failing(mended) == []
    assert speed_of(mended) < speed


def test_the_mildest_change_comes_first() -> None:
    plans = list(direct(situation_of(rolling(6.0))))
    speeds = [speed_of(apply(rolling(6.0), edits)) for edits in plans]
    assert len(plans) == len({repr(one) for one in plans})
    assert speeds[0] == max(speeds)
    assert max(speeds) < 6.0


def test_what_can_be_followed_is_left_alone() -> None:
    program = rolling(0.6)
    assert failing(program) == []
    assert list(direct(situation_of(program))) == []


def test_what_fails_of_the_event_alone_is_not_the_directors() -> None:
    far = rolling(0.6).contract.statements[0].model_copy(update={"distance": 30.0})
    program = rolling(0.6)
    program = program.model_copy(
        update={"contract": program.contract.model_copy(update={"statements": (far,)})}
    )
    assert failing(program) == ["moves"]
    assert list(direct(situation_of(program))) == []


def test_nothing_that_is_pinned_is_touched() -> None:
    pinned = Memory(pinned=(SPEED,))
    program = rolling(4.0)
    proposal = RulePlanner(limit=12).propose(situation_of(program, pinned))
    assert speed_of(apply(program, proposal.edits)) == speed_of(program)
    free = RulePlanner(limit=12).propose(situation_of(program))
    assert speed_of(apply(program, free.edits)) < speed_of(program)


def test_the_faster_the_more_haste() -> None:
    found = []
    for speed in (0.6, 2.0, 4.0, 6.0):
        program = rolling(speed)
        situation = situation_of(program)
        assert situation.rollout is not None
        found.append(shown_of(situation, situation.rollout))
    hastes = [shown.haste for shown in found]
    assert hastes == sorted(hastes)
    assert hastes[0] < 0.5 * hastes[-1]
    # What stays in the picture keeps its way; what goes farther keeps less of it.
    kept = [shown.kept for shown in found]
    assert kept[0] == 1.0
    assert kept == sorted(kept, reverse=True)


# --- slow motion -----------------------------------------------------------------------------


FALLS = filmed(
    [BALL | {"position": [0.0, 4.0, 1.2], "support": "air"}],
    [],
    {"id": "falls", "kind": "falls", "subject": "ball"},
)


def struck() -> PhysicalProgram:
    box = {
        "name": "box", "shape": {"kind": "box", "size": [0.1, 0.1, 0.3]},
        "position": [0.0, 4.0, 0.15], "support": "floor",
    }  # fmt: skip
    hit = {"id": "hit", "kind": "contacts", "subject": "ball", "other": "box"}
    return filmed([BALL, box], [push(6.0)], hit)


def test_slow_motion_is_for_what_falls_or_is_struck() -> None:
    assert is_sudden(FALLS, run_of(FALLS))
    assert is_sudden(struck(), run_of(struck()))
    assert not is_sudden(rolling(6.0), run_of(rolling(6.0)))


def factors_of(program: PhysicalProgram) -> set[float]:
    return {apply(program, edits).clip.time_factor for edits in direct(situation_of(program))}


def test_what_only_rolls_is_never_shown_in_slow_motion() -> None:
    assert factors_of(rolling(6.0)) == {1.0}


def test_what_falls_is_shown_in_one_of_the_usual_slow_motions() -> None:
    factors = factors_of(FALLS)
    assert min(factors) < 1.0
    assert all(any(abs(f - usual) < 1e-3 for usual in DIRECTING.time_factors) for f in factors)
    assert min(factors_of(struck())) < 1.0


def test_a_fall_is_made_one_that_can_be_followed() -> None:
    assert failing(FALLS)
    proposal = RulePlanner(limit=40).propose(situation_of(FALLS))
    mended = apply(FALLS, proposal.edits)
    assert failing(mended) == []
    assert mended.clip.time_factor < 1.0
    # Gravity is as it is: the scene is the same.
    assert mended.scene == FALLS.scene


# --- edits -----------------------------------------------------------------------------------


@pytest.mark.parametrize("seed", [1, 2, 3])
def test_speeds_durations_and_time_are_scaled_as_asked(seed: int) -> None:
    rng = np.random.default_rng(seed)
    gentler, longer, slower = rng.uniform(0.3, 0.9), rng.uniform(1.5, 4.0), 0.5
    program = rolling(3.0)
    (action,) = apply(program, replanned(program, gentler, longer, 1.0)).event.actions
    assert isinstance(action, ApplyForce)
    assert isinstance(action.force, Directed)
    assert action.force.magnitude == pytest.approx(3.0 * gentler, rel=1e-4)
    assert action.duration == round(12 * longer)
    slow = apply(program, replanned(program, gentler, longer, slower))
    assert slow.clip.time_factor == pytest.approx(slower)
    assert speed_of(slow) == pytest.approx(3.0 * gentler, rel=1e-4)
    (late,) = slow.event.actions
    assert isinstance(late, ApplyForce)
    step, before = slow.clip.step_seconds, program.clip.step_seconds
    assert late.duration * step == pytest.approx(round(12 * longer) * before, abs=step)


def test_no_push_lasts_beyond_the_clip() -> None:
    program = rolling(3.0)
    (action,) = apply(program, replanned(program, 1.0, 1000.0, 1.0)).event.actions
    assert isinstance(action, ApplyForce)
    assert action.start_step + action.duration == program.clip.steps


def test_a_force_in_newtons_is_left_as_it_is() -> None:
    program = filmed([BALL], [push(20.0, quantity="value")])
    assert replanned(program, 0.5, 2.0, 1.0) == ()


def test_nothing_to_change_makes_no_edits() -> None:
    assert replanned(rolling(3.0), 1.0, 1.0, 1.0) == ()


def test_a_brake_is_gentler_by_the_square() -> None:
    brake = push(0.8, duration=100, quantity="acceleration", direction=None)
    brake |= {"id": "brake", "force": brake["force"] | {"along": "against_velocity"}}
    program = filmed([BALL], [push(0.4), brake])
    slower = apply(program, replanned(program, 0.5, 2.0, 1.0))
    assert value_at(slower, "event.actions.brake.force.magnitude") == pytest.approx(0.2)
    assert value_at(slower, "event.actions.brake.duration") == 100
