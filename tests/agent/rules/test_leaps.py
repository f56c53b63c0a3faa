"""Leaps over a thing: the first program is high and far enough, whatever stands in the way."""

from __future__ import annotations

import pytest

from physagent_studio.agent.rules import RuleGenerator
from physagent_studio.contract import measure
from physagent_studio.program.scene.state import Box
from physagent_studio.simulation import simulate
from tests.agent.rules.scenes import STAGES, Stage


@pytest.mark.parametrize(
    ("stage", "prompt", "hurdle"),
    [
        ("shelf", "The green ball jumps over the domino.", "domino"),
        ("court", "The basketball leaps over the crate.", "crate"),
        ("desk", "The red cube hops over the blue cup.", "blue_cup"),
    ],
)
def test_it_clears_what_it_leaps_over(stage: str, prompt: str, hurdle: str) -> None:
    program = RuleGenerator().first(STAGES[stage].case(prompt), STAGES[stage].reconstruct)
    rollout = simulate(program, {})
    checks = measure(program, rollout)
    # How well a viewer follows it is the planner's to mend.
    done = [check for check in checks if check.kind != "view"]
    assert all(check.ok for check in done), [c.text for c in done if not c.ok]
    leaper = program.event.actions[0].name
    touching = {rollout.bodies.index(leaper), rollout.bodies.index(hurdle)}
    early = [row for row in rollout.contacts if row["step"] < 40]
    assert all({int(row["a"]), int(row["b"])} != touching for row in early)


@pytest.mark.parametrize(
    ("sentence", "stands"),
    [
        ("The frog hops up.", True),
        ("The box hops up.", True),
        ("The box hops twice to the left.", True),
        ("The box hops up and falls over.", False),
    ],
)
def test_what_leaps_comes_down_as_it_stood(sentence: str, stands: bool) -> None:
    name = sentence.split()[1]
    meadow = Stage("meadow", {name: (Box(size=(0.1, 0.1, 0.08)), (0.0, 2.0, 0.04), "floor")})
    program = RuleGenerator().first(meadow.case(sentence), meadow.reconstruct)
    demands = [s for s in program.contract.statements if s.kind == "topples" and s.negated]
    assert bool(demands) == stands


def test_what_hops_twice_to_a_side_gets_there() -> None:
    meadow = Stage("meadow", {"box": (Box(size=(0.1, 0.1, 0.08)), (-0.3, 2.0, 0.04), "floor")})
    prompt = "The box hops twice to the right."
    program = RuleGenerator().first(meadow.case(prompt), meadow.reconstruct)
    path = simulate(program).positions[:, 0]
    assert path[-1, 0] - path[0, 0] > 0.1
    assert abs(path[-1, 1] - path[0, 1]) < 0.05
