"""A wish becomes a proposal: found by running, told in centimetres, honest where it fails."""

from __future__ import annotations

import numpy as np
import pytest

from physagent_studio.agent.rules.planner.goal_search import Wish, missed, proposal_for, turned
from physagent_studio.program import PhysicalProgram, apply
from physagent_studio.program.text.document import load_program
from physagent_studio.records import Rollout
from physagent_studio.simulation import Simulator

BALLS = """
scene:
  objects:
    - {name: ball, shape: {kind: sphere, radius: 0.1}, position: [0, 2, 0.1], support: floor}
    - {name: other, shape: {kind: sphere, radius: 0.1}, position: [0.6, 2, 0.1], support: floor}
    - name: still
      shape: {kind: box, size: [0.2, 0.2, 0.2]}
      position: [0, 3, 0.1]
      support: floor
  supports:
    - {name: floor, shape: {kind: floor}}
event:
  prompt: The ball rolls to the right.
  actions:
    - {operator: SetVelocity, id: go, name: ball, velocity: [0.5, 0, 0], start_step: 4}
clip: {frames: 26}
"""


@pytest.fixture(scope="module")
def simulator() -> Simulator:
    return Simulator()


@pytest.fixture(scope="module")
def program() -> PhysicalProgram:
    return load_program(BALLS)


@pytest.fixture(scope="module")
def rollout(simulator: Simulator, program: PhysicalProgram) -> Rollout:
    return simulator.simulate(program)


def after(simulator: Simulator, program: PhysicalProgram, wish: Wish, **more: object) -> float:
    first = simulator.simulate(program)
    made = proposal_for(program, first, wish, simulator.simulate, **more)  # type: ignore[arg-type]
    there = missed(simulator.simulate(apply(program, made.edits)), wish)
    assert there is not None
    return float(np.linalg.norm(there))


def test_the_push_is_turned_until_it_is_there(
    simulator: Simulator, program: PhysicalProgram, rollout: Rollout
) -> None:
    wish = Wish("ball", (0.35, 2.15, 0.1), 80)
    made = proposal_for(program, rollout, wish, simulator.simulate)
    there = missed(simulator.simulate(apply(program, made.edits)), wish)
    assert there is not None
    assert float(np.linalg.norm(there)) < 0.02
    assert {edit.path for edit in made.edits} == {"event.actions.go.velocity"}  # type: ignore[union-attr]
    assert "cm from there" in made.rationale
    assert 0 < made.simulations <= 48


def test_what_is_hit_is_moved_by_what_hits_it(
    simulator: Simulator, program: PhysicalProgram
) -> None:
    assert after(simulator, program, Wish("other", (0.75, 2.03, 0.1), 100)) < 0.05


def test_what_nothing_moves_is_pushed(simulator: Simulator, program: PhysicalProgram) -> None:
    wish = Wish("still", (0.3, 3.0, 0.1), 60)
    first = simulator.simulate(program)
    made = proposal_for(program, first, wish, simulator.simulate)
    assert [edit.op for edit in made.edits] == ["add"]
    assert after(simulator, program, wish) < 0.05


def test_what_is_pinned_stays(
    simulator: Simulator, program: PhysicalProgram, rollout: Rollout
) -> None:
    wish = Wish("ball", (0.35, 2.15, 0.1), 80)
    made = proposal_for(program, rollout, wish, simulator.simulate, ["event.actions.go.velocity"])
    assert all(not getattr(edit, "path", "").startswith("event.actions.go") for edit in made.edits)


def test_what_cannot_be_is_said(
    simulator: Simulator, program: PhysicalProgram, rollout: Rollout
) -> None:
    made = proposal_for(program, rollout, Wish("ball", (0, 2, 40.0), 90), simulator.simulate)
    assert made.hunks == ()
    assert made.question
    assert made.confidence == 0


def test_strides_scale_turn_and_raise() -> None:
    assert turned((1, 0, 0), np.zeros(3)) == [1, 0, 0]
    left = turned((1, 0, 0), np.array([0.0, 15.0, 0.0]))
    assert left == pytest.approx([0, 1, 0], abs=1e-9)
    assert np.linalg.norm(np.array(turned((1, 1, 0), np.array([4.0, 1.0, 1.0])), float)) == (
        pytest.approx(np.e * 2**0.5, rel=1e-3)
    )
