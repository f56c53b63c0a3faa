"""The action reference names every operator and model and shows pictures that exist."""

import re
from pathlib import Path

import pytest

from physagent_studio.simulation.actions.disturbance import DEFAULT_FREQUENCY
from physagent_studio.simulation.actions.effects import EFFECTS

DOCS = Path(__file__).parents[2] / "docs"


@pytest.fixture
def text():
    path = DOCS / "actions.md"
    if not path.is_file():
        pytest.skip("the documentation is not beside the tests")
    return path.read_text(encoding="utf-8")


def test_every_operator_has_its_chapter(text):
    for operator in EFFECTS:
        assert f"## {operator.__name__}\n" in text
    for model in ("wind", "gust", "bump", *DEFAULT_FREQUENCY):
        assert f"| `{model}` |" in text


def test_every_picture_exists_and_is_used(text):
    used = set(re.findall(r"images/actions/([\w-]+\.png)", text))
    assert used == {path.name for path in (DOCS / "images" / "actions").iterdir()}
