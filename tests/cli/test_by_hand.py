"""A person in a role, on the command line."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import pytest

from physagent_studio.assets import assets_dir
from physagent_studio.cli.clips import _showing
from physagent_studio.cli.early import RunRequest
from physagent_studio.cli.guard import WAITING
from physagent_studio.cli.run import run_loop
from physagent_studio.errors import InputError

pytestmark = pytest.mark.usefixtures("shared_scenes")

REQUEST = RunRequest(
    target=str(assets_dir() / "demo"),
    event="knocks_block_over",
    prompt="",
    objects=(),
    rounds=10,
    policy="auto",
    by_hand=("verifier",),
    frames=False,
    agent="rules",
)


def test_a_run_waits_where_i_play_a_role(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert run_loop(REQUEST, tmp_path, as_json=False) == WAITING
    assert "waiting for your verdict: physagent studio " in capsys.readouterr().out


def test_the_first_program_is_laid_out_for_me(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    request = replace(REQUEST, by_hand=("generator",))
    assert run_loop(request, tmp_path, as_json=False) == WAITING
    assert "waiting for your first program" in capsys.readouterr().out


def test_a_role_that_there_is_not(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="generator, verifier, planner"):
        run_loop(replace(REQUEST, by_hand=("judge",)), tmp_path, as_json=False)


def test_a_session_that_goes_on_takes_no_other_event(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    run_loop(replace(REQUEST, by_hand=("generator",)), tmp_path, as_json=False)
    session = capsys.readouterr().out.split()[1]
    again = replace(REQUEST, target=session, event=None)
    for said, option in (
        (replace(again, annotation=tmp_path / "clicks.yaml"), "--annotation"),
        (replace(again, prompt="The block falls over."), "--prompt"),
    ):
        with pytest.raises(InputError, match=f"leave {option} out"):
            run_loop(said, tmp_path, as_json=False)
    assert run_loop(again, tmp_path, as_json=False) == WAITING


def test_a_clip_of_a_session_without_a_round_says_how_it_goes_on(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    run_loop(replace(REQUEST, by_hand=("generator",)), tmp_path, as_json=False)
    session = capsys.readouterr().out.split()[1]
    with (
        pytest.raises(InputError, match=f"no round that ran; `physagent run {session}`"),
        _showing(session, None, tmp_path),
    ):
        pass
