"""What is published about the language agrees with the language.

To write the JSON Schema anew after a deliberate change:

    PHYSAGENT_REGENERATE=1 python -m pytest tests/program/test_published.py
"""

import json
import os
import re
from pathlib import Path

import pytest

from physagent_studio.contract import MEASURES
from physagent_studio.contract.words import COMPOSITES
from physagent_studio.program import MATERIALS
from physagent_studio.program.text.document import json_schema, load_program
from physagent_studio.program.text.fuzz import SEED_TEXT

DOCS = Path(__file__).resolve().parents[2] / "docs"
GUIDE = (DOCS / "program-format.md").read_text(encoding="utf-8")


def test_the_schema_is_current():
    path = DOCS / "program.schema.json"
    text = json.dumps(json_schema(), indent=1) + "\n"
    if os.environ.get("PHYSAGENT_REGENERATE"):
        path.write_text(text, encoding="utf-8")
    assert path.read_text(encoding="utf-8") == text


def test_the_example_in_the_guide_is_a_program():
    block = re.search(r"```yaml\n(version.*?)```", GUIDE, re.DOTALL)
    assert block is not None
    program = load_program(block.group(1))
    assert not program.contract.untested


def kinds(name: str) -> list[str]:
    definitions = json_schema()["$defs"]
    return [
        one["properties"][name]["const"]
        for one in definitions.values()
        if "const" in one.get("properties", {}).get(name, {})
    ]


@pytest.mark.parametrize("word", [*kinds("kind"), *kinds("operator"), *MATERIALS])
def test_the_guide_names_everything(word):
    assert f"`{word}`" in GUIDE or f"kind: {word}" in GUIDE


def test_every_statement_has_a_measure():
    definitions = json_schema()["$defs"]
    statements = {
        one["properties"]["kind"]["const"]
        for one in definitions.values()
        if "negated" in one.get("properties", {})
    }
    assert statements == set(MEASURES) | set(COMPOSITES)


def test_the_fuzz_seed_uses_most_of_the_language():
    program = load_program(SEED_TEXT)
    assert len(program.event.actions) == 3
    assert program.scene.is_resolved
