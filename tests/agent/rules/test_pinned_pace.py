"""Where a person has set the clip's pace, or what slow motion would move, both stay as they are."""

from __future__ import annotations

from dataclasses import replace
from types import MappingProxyType
from typing import Any

import pytest

from physagent_studio.agent.roles import Situation, Trial
from physagent_studio.agent.rules.planner.directing import direct
from physagent_studio.agent.rules.planner.factors import relevant_knobs
from physagent_studio.agent.rules.planner.trials import Search
from physagent_studio.contract import Facts, measure
from physagent_studio.contract.view import view_checks
from physagent_studio.program import PhysicalProgram
from physagent_studio.program.scene.camera import Camera
from physagent_studio.program.text.document import load_program
from physagent_studio.program.timing import PACE
from physagent_studio.records import Assessment, Case, Memory, Mismatch, Scene
from physagent_studio.simulation import simulate

PROGRAM = """
scene:
  objects:
    - {name: ball, shape: {kind: sphere, radius: 0.1}, position: [-0.6, 3, 0.1], support: floor}
    - {name: cube, shape: {kind: box, size: [0.2, 0.2, 0.2]}, position: [0.3, 3, 0.1],
       support: floor}
  supports:
    - {name: floor, shape: {kind: floor}}
event:
  actions:
    - {operator: SetVelocity, id: throw, name: ball, start_step: 12,
       velocity: {magnitude: 14, direction: right}}
contract:
  statements:
    - {kind: contacts, id: hit, subject: ball, other: cube}
"""


@pytest.fixture(scope="module")
def situation() -> Situation:
    """A ball that goes to a cube far faster than an eye follows."""
    program = load_program(PROGRAM)
    camera = Camera.from_horizon((832, 480), 200, 0.8)
    program = program.model_copy(
        update={"scene": program.scene.model_copy(update={"camera": camera})}
    )
    rollout = simulate(program, {})
    checks = measure(program, rollout)
    checks = (*checks, *view_checks(Facts.of(program, rollout), checks))
    fast = next(one for one in checks if one.id == "view.pace.ball")
    assert not fast.ok
    told = Mismatch(code="pace", text=fast.text, subject="ball", check=fast.id)
    judged = Assessment(stage="simulation", passed=False, checks=checks, diagnosis=(told,))
    case = Case("bare", None, "", (), (), (), "")

    def never(_program: PhysicalProgram) -> Trial:
        raise AssertionError("nothing is run here")

    nothing: MappingProxyType[str, Any] = MappingProxyType({})
    scene = Scene(program.scene, None, None, nothing, nothing, nothing, nothing, (), "bare")
    return Situation(case, program, scene, rollout, judged, Memory(), never)


def _pinned(situation: Situation, *paths: str) -> Situation:
    return replace(situation, memory=Memory(pinned=paths))


def _paths(situation: Situation) -> set[str]:
    """All that the director's programs and the time knob would change."""
    found = {str(edit.path) for edits in direct(situation) for edit in edits}
    for knob in relevant_knobs(situation, verified=False):
        if knob.factor == "pace":
            found |= {edit.path for edit in knob.edits(knob.low)}
    return found


def test_slow_motion_is_thought_of_where_nobody_minds(situation: Situation) -> None:
    assert _paths(situation) >= set(PACE[1:]) | {"event.actions.throw.start_step"}


@pytest.mark.parametrize("paths", [PACE, PACE[:1], PACE[1:], ("clip",)])
def test_a_pinned_pace_stays_and_the_push_becomes_gentler(
    situation: Situation, paths: tuple[str, ...]
) -> None:
    found = _paths(_pinned(situation, *paths))
    assert not any(path.startswith("clip") for path in found)
    assert "event.actions.throw.velocity.magnitude" in found


def test_slow_motion_does_not_move_a_pinned_step(situation: Situation) -> None:
    pinned = _pinned(situation, "event.actions.throw.start_step")
    knob = next(k for k in relevant_knobs(pinned, verified=False) if k.factor == "pace")
    assert "event.actions.throw.start_step" in {edit.path for edit in knob.edits(0.4)}
    search = Search(pinned)
    assert search.turn([(knob, 0.4)]) is None
    assert search.runs == 0
