"""The bundled demo shows reflection at work: a first program that fails, and its repair."""

from __future__ import annotations

from pathlib import Path

import pytest

from physagent_studio.assets import assets_dir
from physagent_studio.cli.serving import SHOWN_FIRST
from physagent_studio.exchange import load_case
from physagent_studio.records import Assessment, LoopState
from physagent_studio.session import Store
from physagent_studio.workbench.desk import Desk
from physagent_studio.workbench.engine import Control

pytestmark = pytest.mark.usefixtures("shared_scenes")


def rounds_of(folder: Path, event: str) -> list[Assessment]:
    """What every round of an event came to, the proposals accepted."""
    case = load_case(assets_dir() / "demo", event)
    session = Store(folder).create(case, LoopState(policy="auto", budget=10))
    desk = Desk(session, Control(), evidence=False)
    desk.advance(policy="auto")
    return [r.assessment for r in desk.state.path() if r.assessment is not None]


def test_the_first_program_fails_and_is_repaired(tmp_path: Path) -> None:
    rounds = rounds_of(tmp_path, SHOWN_FIRST)
    assert len(rounds) > 1
    assert not rounds[0].passed
    assert rounds[0].diagnosis
    assert rounds[-1].passed


@pytest.mark.parametrize(
    "event",
    [
        "knocks_block_over",
        pytest.param("only_the_cube", marks=pytest.mark.slow),
        pytest.param("topples_onto_cube", marks=pytest.mark.slow),
    ],
)
def test_every_other_event_happens_too(tmp_path: Path, event: str) -> None:
    assert rounds_of(tmp_path, event)[-1].passed
