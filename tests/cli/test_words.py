"""What the commands say, in this process: whole ids, JSON for machines, errors with a remedy."""

from __future__ import annotations

import json
from pathlib import Path

import pytest
from typer.testing import CliRunner, Result

from physagent_studio.assets import assets_dir
from physagent_studio.cli.app import app
from physagent_studio.cli.run import is_plain
from physagent_studio.exchange import load_case
from physagent_studio.records import LoopState
from physagent_studio.session import Store


def _said(*words: str) -> Result:
    return CliRunner().invoke(app, list(words))


def test_sessions_show_ids_that_can_be_copied(tmp_path: Path) -> None:
    assert "physagent run" in _said("sessions", "--workspace", str(tmp_path)).output
    case = load_case(assets_dir() / "demo", "block_stays_standing")
    session = Store(tmp_path).create(case, LoopState(), title="A long title " * 12)
    session.close()
    result = _said("sessions", "--workspace", str(tmp_path))
    assert result.exit_code == 0
    assert session.id in result.output.split()
    # Three runs of one photo are told apart by their sentences.
    assert case.prompt[:60] in result.output


def test_a_file_is_no_workspace(tmp_path: Path) -> None:
    (tmp_path / "note").write_text("words")
    result = _said("sessions", "--workspace", str(tmp_path / "note"))
    assert result.exit_code == 2
    assert "a workspace is a folder" in result.output


def test_problems_of_a_program_for_machines(tmp_path: Path) -> None:
    path = tmp_path / "p.yaml"
    path.write_text("scene:\n  objects:\n    - {name: a, shape: {kind: ball}}\n")
    result = _said("validate", str(path), "--json")
    assert result.exit_code == 2
    answer = json.loads(result.stdout)
    assert not answer["valid"]
    assert answer["problems"][0]["line"] == 3
    assert "sphere" in answer["problems"][0]["allowed"]


@pytest.mark.parametrize(
    ("words", "remedy"),
    [
        (("run", "{demo}", "--object", "ball@1,2"), "--object goes with an image"),
        (("run", "{demo}", "--prompt", "The ball falls."), "--prompt goes with an image"),
        (("run", "{note}", "--prompt", "The ball falls."), "neither a case folder nor a picture"),
        (("render", "gone", "--out", "x.mp4"), "`physagent sessions` lists them"),
        (("bench", "gone"), "studio"),
        (("studio", "--no-browser", "--workspace", "{note}"), "choose another with --workspace"),
    ],
)
def test_what_cannot_be_comes_with_a_remedy(
    tmp_path: Path, words: tuple[str, ...], remedy: str
) -> None:
    (tmp_path / "note.txt").write_text("words")
    places = {"demo": str(assets_dir() / "demo"), "note": str(tmp_path / "note.txt")}
    result = _said(*(word.format(**places) for word in words))
    assert result.exit_code == 2
    assert remedy in result.output


@pytest.mark.parametrize(
    ("untested", "unread", "whole"),
    [([], [], True), (["with a bang"], [], False), ([], ["out of the picture"], False)],
)
def test_a_sentence_is_done_when_all_of_it_is_tested(
    untested: list[str], unread: list[str], whole: bool
) -> None:
    assert is_plain({"untested": untested, "not_understood": unread, "doubts": []}) is whole
