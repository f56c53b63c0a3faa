"""People and animals act with their limbs from where they stand, and keep their balance."""

from __future__ import annotations

import numpy as np
import pytest

from physagent_studio.agent.rules import RuleGenerator
from physagent_studio.contract import measure
from physagent_studio.program import PhysicalProgram
from physagent_studio.program.actions import When
from physagent_studio.program.rotations import matrix_of
from physagent_studio.program.scene.state import Box, Sphere
from physagent_studio.records import Rollout
from physagent_studio.simulation import simulate
from tests.agent.rules.scenes import Stage


def field(doer: str, gap: float, other: str = "ball") -> Stage:
    """Somebody 1.4 m high, and something so far to the left of that."""
    shape = Sphere(radius=0.11) if other == "ball" else Box(size=(0.22, 0.22, 0.22))
    return Stage(
        "field",
        {
            doer: (Box(size=(0.4, 0.25, 1.4)), (0.5, 5.0, 0.7), "floor"),
            other: (shape, (0.5 - 0.2 - gap - 0.11, 5.0, 0.11), "floor"),
        },
    )


def program_of(stage: Stage, prompt: str) -> PhysicalProgram:
    return RuleGenerator().first(stage.case(prompt), stage.reconstruct)


def moved(rollout: Rollout, name: str) -> np.ndarray:
    """(T,) m from where it began."""
    path = rollout.positions[:, rollout.objects.index(name)]
    return np.linalg.norm(path - path[0], axis=1)


def tilted(rollout: Rollout, name: str) -> float:
    """Degrees, the most that it leans."""
    turns = rollout.rotations[:, rollout.objects.index(name)]
    least = min(matrix_of(turn.tolist())[2, 2] for turn in turns)
    return float(np.degrees(np.arccos(min(least, 1.0))))


def failing(program: PhysicalProgram, rollout: Rollout) -> list[str]:
    checks = [c for c in measure(program, rollout) if c.kind != "view"]
    return [check.text for check in checks if not check.ok]


@pytest.mark.parametrize(
    ("doer", "other", "prompt"),
    [
        ("boy", "ball", "The boy kicks the ball hard and it flies off to the left."),
        ("dog", "ball", "The dog pushes the ball."),
        ("woman", "ball", "The woman throws the ball to the left."),
        ("girl", "box", "The girl hits the box."),
    ],
)
def test_who_is_within_reach_stays_where_it_is(doer: str, other: str, prompt: str) -> None:
    program = program_of(field(doer, 0.25, other), prompt)
    assert {action.name for action in program.event.actions} == {other}
    told = [s.model_dump() for s in program.contract.statements]
    assert all(doer not in row.values() for row in told)
    rollout = simulate(program, {})
    assert not failing(program, rollout)
    assert moved(rollout, doer).max() < 0.02
    path = rollout.positions[:, rollout.objects.index(other)]
    # Away from who does it, where nothing else is told.
    assert path[-1, 0] < path[0, 0] - 0.1


@pytest.mark.parametrize(
    "prompt", ["The boy kicks the ball to the left.", "The boy runs to the ball and kicks it left."]
)
def test_who_is_farther_away_goes_there_first(prompt: str) -> None:
    program = program_of(field("boy", 1.8), prompt)
    rollout = simulate(program, {})
    assert not failing(program, rollout)
    assert any(s.kind == "before" for s in program.contract.statements)
    kick = next(a for a in program.event.actions if a.name == "ball")
    assert isinstance(kick.when, When)
    ball, boy = moved(rollout, "ball"), moved(rollout, "boy")
    first = int(np.argmax(ball > 0.01))
    assert boy[first] > 1.8 - 0.7
    # It stops before it, upright, and within the clip.
    assert boy.max() < 1.8
    assert tilted(rollout, "boy") < 2.0
    assert np.ptp(boy[-20:]) < 0.02


def test_what_runs_into_a_thing_does_so_with_its_body() -> None:
    stage = field("dog", 1.0, "box")
    program = program_of(stage, "The dog runs into the box and pushes it.")
    assert {a.name for a in program.event.actions} == {"dog"}
    rollout = simulate(program, {})
    assert tilted(rollout, "dog") < 2.0
    assert moved(rollout, "box").max() > 0.05


@pytest.mark.parametrize(
    ("prompt", "keeps"),
    [
        ("The boy slides to the left.", True),
        ("The boy kicks the ball.", True),
        ("The boy jumps up.", True),
        ("The ball rolls to the right.", True),
        ("The boy falls over.", None),
        ("The boy topples to the right.", None),
        ("The ball hits the boy.", None),
        ("The ball knocks over the boy.", None),
        ("The ball rolls into the boy.", None),
    ],
)
def test_it_keeps_its_balance_unless_it_is_told_to_lose_it(prompt: str, keeps: bool | None) -> None:
    scene = program_of(field("boy", 0.25), prompt).scene
    assert [item.balances for item in scene.objects] == [keeps, None]


def test_what_bumps_into_a_thing_does_so_with_its_body() -> None:
    told = "The boy bumps into the box.", "The boy hits the box."
    whose = [{a.name for a in program_of(field("boy", 0.25, "box"), p).event.actions} for p in told]
    assert whose == [{"boy"}, {"box"}]


@pytest.mark.parametrize("prompt", ["The boy picks up the box.", "The boy picks the box up."])
def test_what_is_picked_up_goes_up_and_who_does_it_stays(prompt: str) -> None:
    program = program_of(field("boy", 0.25, "box"), prompt)
    assert {a.name for a in program.event.actions} == {"box"}
    rollout = simulate(program, {})
    assert not failing(program, rollout)
    assert rollout.positions[-1, rollout.objects.index("box"), 2] > 0.2


def test_what_is_no_living_thing_acts_with_its_body() -> None:
    program = program_of(field("robot", 0.25), "The robot hits the ball.")
    assert {a.name for a in program.event.actions} == {"robot"}
    assert all(item.balances is None for item in program.scene.objects)


def test_it_walks_up_to_a_thing_and_not_into_it() -> None:
    program = program_of(field("horse", 1.8, "box"), "The horse walks up to the box and stops.")
    rollout = simulate(program, {})
    assert not failing(program, rollout)
    assert moved(rollout, "box").max() < 0.01
    assert 1.0 < moved(rollout, "horse").max() < 1.7
