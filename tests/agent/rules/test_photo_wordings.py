"""Sentences that a stranger might type over the photographs, and what each demands.

The scenes are those that were reconstructed once from the photographs (tests/reference_contracts/
states: numbers only), so that these tests need no photograph. Nothing is simulated here.
"""

from __future__ import annotations

from functools import cache
from pathlib import Path
from typing import Any

import pytest
import yaml

from physagent_studio.agent.rules import RuleGenerator
from physagent_studio.agent.rules.generator import stock_of
from physagent_studio.contract.words import claim
from physagent_studio.language import read
from physagent_studio.program import PhysicalProgram, SceneState
from physagent_studio.program.scene.state import Box, Inflated, SceneObject
from physagent_studio.program.text.document import load_program
from physagent_studio.records import Case

HERE = Path(__file__).parent
STATES = HERE.parents[1] / "reference_contracts" / "states"
ROWS = yaml.safe_load((HERE / "photo_wordings.yaml").read_text(encoding="utf-8"))


def _boxed(item: SceneObject) -> SceneObject:
    """Without its photograph an outline has no mesh: a box of its size stands for it."""
    if not isinstance(item.shape, Inflated):
        return item
    return item.model_copy(update={"shape": Box(size=item.shape.size)})


@cache
def scene_of(case: str) -> SceneState:
    """The stored scene of a photograph."""
    path = sorted(STATES.glob(f"{case}__*.yaml"))[0]
    scene = load_program(path.read_text(encoding="utf-8")).scene
    return scene.model_copy(update={"objects": tuple(_boxed(item) for item in scene.objects)})


def program_of(case: str, prompt: str) -> PhysicalProgram:
    """The first program of a sentence over a photograph's scene."""
    state = scene_of(case)
    objects = tuple((item.name, item.grounding) for item in state.objects)
    supports = tuple(s for s in state.supports if s.grounding.points)
    asked = Case(case, None, "", objects, supports, state.landmarks, prompt)
    return RuleGenerator().program(asked, read(prompt, stock_of(asked)), state)


@pytest.mark.parametrize("row", ROWS, ids=[f"{row['case']}-{n}" for n, row in enumerate(ROWS)])
def test_what_a_sentence_demands(row: dict[str, Any]) -> None:
    program = program_of(row["case"], row["prompt"])
    contract = program.contract
    found = {claim(s, program) for s in contract.statements if s.id not in contract.serving}
    assert found == set(row["demands"]), row["prompt"]
    told = [*contract.not_understood, *(clause.text for clause in contract.untested)]
    assert told == row.get("untold", []), row["prompt"]
