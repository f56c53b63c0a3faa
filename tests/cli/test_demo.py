"""The bundled demo shows reflection at work: a first program that fails, and its repair."""

from __future__ import annotations

from pathlib import Path

import pytest

from physagent_studio.assets import assets_dir
from physagent_studio.cli.studio import SHOWN_FIRST
from physagent_studio.exchange import load_case
from physagent_studio.records import LoopState
from physagent_studio.session import Store
from physagent_studio.workbench.desk import Desk
from physagent_studio.workbench.engine import Control


@pytest.mark.parametrize("event", [SHOWN_FIRST, "topples_onto_cube"])
def test_the_first_program_fails_and_is_repaired(tmp_path: Path, event: str) -> None:
    case = load_case(assets_dir() / "demo", event)
    session = Store(tmp_path).create(case, LoopState(policy="auto", budget=10))
    desk = Desk(session, Control(), evidence=False)
    desk.advance(policy="auto")
    rounds = [r.assessment for r in desk.state.path() if r.assessment is not None]
    assert len(rounds) > 1
    assert not rounds[0].passed
    assert rounds[0].diagnosis
    assert rounds[-1].passed
