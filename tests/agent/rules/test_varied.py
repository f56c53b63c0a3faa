"""Sentences that were once misread without a word, and what each demands.

Relative clauses, companions, counts of counts, order without "then", what something comes to rest
against. Nothing is simulated here; what nothing can test is `untold`.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest
import yaml

from physagent_studio.agent.rules import RuleGenerator
from physagent_studio.contract.words import claim
from physagent_studio.program import PhysicalProgram
from tests.agent.rules.everyday_scenes import EVERYDAY
from tests.agent.rules.scenes import STAGES
from tests.agent.rules.varied_scenes import VARIED

ROWS = yaml.safe_load((Path(__file__).parent / "varied.yaml").read_text(encoding="utf-8"))
PLACES = {**STAGES, **EVERYDAY, **VARIED}


def program_of(stage_name: str, prompt: str) -> PhysicalProgram:
    """The first program of a sentence over a place."""
    stage = PLACES[stage_name]
    return RuleGenerator().first(stage.case(prompt), stage.reconstruct)


@pytest.mark.parametrize("row", ROWS, ids=[f"{row['stage']}-{n}" for n, row in enumerate(ROWS)])
def test_what_a_sentence_demands(row: dict[str, Any]) -> None:
    program = program_of(row["stage"], row["prompt"])
    contract = program.contract
    found = {claim(s, program) for s in contract.statements if s.id not in contract.serving}
    assert found == set(row["demands"]), row["prompt"]
    told = [*contract.not_understood, *(clause.text for clause in contract.untested)]
    assert told == row.get("untold", []), row["prompt"]
