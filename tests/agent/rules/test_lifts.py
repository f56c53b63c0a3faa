"""What is lifted goes up without haste, and what is then dropped comes down, in one round."""

from __future__ import annotations

import pytest

from physagent_studio.agent.rules import RuleGenerator, RulePlanner
from physagent_studio.contract import measure
from physagent_studio.program import apply
from physagent_studio.simulation import simulate
from tests.agent.rules.planner.test_planner import outcome, situation_of
from tests.agent.rules.scenes import STAGES


@pytest.mark.parametrize(
    ("stage", "prompt", "kinds"),
    [
        ("desk", "The red cube is lifted up and then drops.", ["moves", "falls"]),
        ("yard", "The trash can rises into the air and falls back down.", ["moves", "falls"]),
        ("wind", "The paper cup is lifted.", ["moves", "falls"]),
        ("wind", "The balloon takes off and rises.", ["moves", "falls", "moves", "falls"]),
        ("lane", "The middle pin is picked up, then dropped.", ["moves", "falls"]),
    ],
)
def test_up_and_down(stage: str, prompt: str, kinds: list[str]) -> None:
    program = RuleGenerator().first(STAGES[stage].case(prompt), STAGES[stage].reconstruct)
    assert [s.kind for s in program.contract.statements] == kinds
    checks = measure(program, simulate(program, {}))
    # How well a viewer follows it is the planner's to mend.
    done = [check for check in checks if check.kind != "view"]
    assert all(check.ok for check in done), [c.text for c in done if not c.ok]


@pytest.mark.parametrize(
    ("stage", "prompt"),
    [
        ("desk", "The red cube is lifted up and then drops."),
        ("lane", "The middle pin is picked up, then dropped."),
    ],
)
def test_one_proposal_makes_it_last(stage: str, prompt: str) -> None:
    """A lift that is over at once is shown more slowly."""
    situation = situation_of(stage, prompt)
    assert {m.check for m in situation.assessment.diagnosis} == {"view.fills"}
    proposal = RulePlanner(limit=20).propose(situation)
    assert outcome(situation, proposal) == []
    assert apply(situation.program, proposal.edits).clip.time_factor < 1.0


@pytest.mark.parametrize(
    "prompt", ["The balloon lifts off.", "The balloon takes off and rises straight up."]
)
def test_what_rises_stays_up_and_in_the_picture(prompt: str) -> None:
    program = RuleGenerator().first(STAGES["wind"].case(prompt), STAGES["wind"].reconstruct)
    rollout = simulate(program, {})
    heights = rollout.positions[:, rollout.objects.index("balloon"), 2]
    assert heights[-1] > heights.max() - 0.01 > heights[0] + 0.3
    assert all(check.ok for check in measure(program, rollout))


def test_what_takes_off_along_the_ground_does_not_rise() -> None:
    prompt = "The basketball takes off to the right."
    program = RuleGenerator().first(STAGES["court"].case(prompt), STAGES["court"].reconstruct)
    assert {s.kind for s in program.contract.statements} == {"moves"}
    assert all(getattr(s, "direction", None) != "up" for s in program.contract.statements)
