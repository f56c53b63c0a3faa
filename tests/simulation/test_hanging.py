"""What hangs stays until its action begins, what floats has no weight, what nothing holds falls."""

from __future__ import annotations

import numpy as np
import pytest

from physagent_studio.contract.always import always_on
from physagent_studio.contract.facts import Facts
from physagent_studio.program import AddItem, apply
from physagent_studio.program.text.document import load_program
from physagent_studio.simulation.simulator import Simulator

PROGRAM = """
scene:
  objects:
    - {name: lamp, shape: {kind: sphere, radius: 0.1}, position: [0, 2, 1.1], support: air, aloft: hangs}
    - {name: balloon, shape: {kind: sphere, radius: 0.1}, position: [1, 2, 1.1], support: air, aloft: floats}
    - {name: stone, shape: {kind: sphere, radius: 0.1}, position: [2, 2, 1.1], support: air}
    - {name: apple, shape: {kind: sphere, radius: 0.1}, position: [3, 2, 1.1], support: air, aloft: hangs}
    - {name: bell, shape: {kind: sphere, radius: 0.1}, position: [-0.5, 2, 1.1], support: air, aloft: hangs}
    - {name: dart, shape: {kind: sphere, radius: 0.05}, position: [-1, 2, 1.1], support: air, aloft: floats}
  supports: [{name: floor, shape: {kind: floor}}]
event:
  actions:
    - {operator: FixObject, id: hold, name: apple, start_step: 0, duration: 60}
    - {operator: SetVelocity, id: throw, name: dart, velocity: [1, 0, 0], start_step: 10}
"""  # noqa: E501


@pytest.fixture(scope="module")
def run():
    program = load_program(PROGRAM)
    return program, Simulator().simulate(program)


def height(rollout, name: str, step: int) -> float:
    return float(rollout.positions[step, rollout.index(name), 2])


def test_each_is_held_as_it_says(run) -> None:
    program, rollout = run
    last = rollout.steps
    assert height(rollout, "lamp", last) == pytest.approx(1.1, abs=1e-3)
    assert height(rollout, "balloon", last) == pytest.approx(1.1, abs=1e-6)
    assert height(rollout, "stone", last) == pytest.approx(0.1, abs=5e-3)
    assert height(rollout, "apple", 60) == pytest.approx(1.1, abs=1e-3)
    assert height(rollout, "apple", last) == pytest.approx(0.1, abs=5e-3)
    assert all(check.margin >= 0 for check in always_on(Facts(program, rollout, last)))


def test_what_hangs_swings_where_it_is_struck(run) -> None:
    _, rollout = run
    swing = rollout.positions[:, rollout.index("bell"), 0]
    assert np.ptp(swing) > 5e-3
    assert np.abs(swing + 0.5).max() < 0.1
    assert height(rollout, "bell", rollout.steps) == pytest.approx(1.1, abs=0.02)


def test_what_hangs_by_a_thread_swings_about_the_end_of_that() -> None:
    place = "position: [-0.5, 2, 1.1]"
    program = load_program(PROGRAM.replace(place, f"{place}, tether: 0.4"))
    bell = program.scene.object("bell")
    assert bell is not None
    assert bell.tether == 0.4
    rollout = Simulator().simulate(program)
    path = rollout.positions[:, rollout.index("bell")]
    assert np.ptp(path[:, 0]) > 5e-3
    away = np.linalg.norm(path - np.array([-0.5, 2, 1.5]), axis=1)
    assert away == pytest.approx(0.4, abs=5e-3)


def test_a_push_ends_the_hanging_and_goes_on_from_a_snapshot(run) -> None:
    program, before = run
    push = {"operator": "SetVelocity", "id": "push", "name": "lamp", "velocity": [0.5, 0, 0],
            "start_step": 100}  # fmt: skip
    pushed = apply(program, (AddItem(path="event.actions", item=push),))
    simulator = Simulator()
    whole = simulator.simulate(pushed)
    assert height(whole, "lamp", 99) == pytest.approx(1.1, abs=1e-3)
    assert height(whole, "lamp", whole.steps) == pytest.approx(0.1, abs=5e-3)
    for first in (80, 100):
        again = simulator.resimulate(pushed, {}, before, first)
        assert np.array_equal(again.positions, whole.positions)
    later = simulator.resimulate(pushed, {}, whole, 200)
    assert np.array_equal(later.positions, whole.positions)
