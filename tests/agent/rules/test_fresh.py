"""Sentences that nothing was written for: how many of the demands that a person insists on are
found in the contract of the first program.

`fresh.yaml` holds them by place. Neither sentences nor demands were fitted to what is read.
"""

from __future__ import annotations

from pathlib import Path

import pytest
import yaml

from physagent_studio.agent.rules import RuleGenerator
from physagent_studio.contract.words import claim
from tests.agent.rules.everyday_scenes import EVERYDAY
from tests.agent.rules.scenes import STAGES
from tests.agent.rules.varied_scenes import VARIED

PLACES = {**STAGES, **EVERYDAY, **VARIED}
SENTENCES = yaml.safe_load((Path(__file__).parent / "fresh.yaml").read_text(encoding="utf-8"))
READ = 0.75
"""Share of the demands that have to be found."""


@pytest.mark.slow
def test_most_of_what_a_person_insists_on_is_demanded() -> None:
    asked = found = 0
    for place, rows in SENTENCES.items():
        stage = PLACES[place]
        for prompt, demands in rows.items():
            program = RuleGenerator().first(stage.case(prompt), stage.reconstruct)
            claims = {claim(one, program) for one in program.contract.statements}
            asked, found = asked + len(demands), found + len(claims & set(demands))
    assert asked >= 300
    assert found >= READ * asked
