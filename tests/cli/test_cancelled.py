"""A run that is ended by Ctrl+C says so, on the command line and in the list of sessions."""

from __future__ import annotations

import json
from pathlib import Path

import pytest
from typer.testing import CliRunner

from physagent_studio.assets import assets_dir
from physagent_studio.cli.app import app
from physagent_studio.cli.guard import CANCELLED
from physagent_studio.session import Store
from physagent_studio.workbench.desk import Desk

RUN = ["run", str(assets_dir() / "demo"), "--event", "knocks_block_over"]


def ended(*_: object, **__: object) -> None:
    raise KeyboardInterrupt


@pytest.mark.parametrize("as_json", [False, True])
def test_a_cancelled_run_is_listed_as_cancelled(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, as_json: bool
) -> None:
    monkeypatch.setattr(Desk, "advance", ended)
    words = [*RUN, "--workspace", str(tmp_path), *["--json"] * as_json]
    result = CliRunner().invoke(app, words)
    assert result.exit_code == CANCELLED
    assert "cancelled; everything up to here is kept" in result.stderr
    (one,) = Store(tmp_path).list()
    assert one.outcome == "cancelled"
    if as_json:
        report = json.loads(result.stdout)
        assert (report["outcome"], report["realised"]) == ("cancelled", False)
        assert report["session"] == one.id
    else:
        assert result.stdout.strip() == f"session {one.id}"


def test_a_run_cancelled_before_it_has_a_session_says_so_too(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("physagent_studio.cli.run.case_of", ended)
    result = CliRunner().invoke(app, [*RUN, "--workspace", str(tmp_path), "--json"])
    assert result.exit_code == CANCELLED
    assert json.loads(result.stdout) == {"outcome": "cancelled"}
