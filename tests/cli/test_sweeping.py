"""`physagent sweep` and `attribute` on the command line."""

from __future__ import annotations

from pathlib import Path

import pytest
from typer.testing import CliRunner

from physagent_studio.cli.app import app
from physagent_studio.records import LoopState
from physagent_studio.session import Store
from tests.sweep.programs import SLIDER

GRID = "event.actions.go.velocity.0=0.5:1.5:3"


@pytest.fixture
def program(tmp_path: Path) -> str:
    path = tmp_path / "block.yaml"
    path.write_text(SLIDER.replace("DISTANCE", "0.1"))
    return str(path)


def asked(*words: str) -> tuple[int, str]:
    result = CliRunner().invoke(app, words)
    return result.exit_code, result.output


def test_a_sweep_writes_a_table_and_a_page_and_runs_nothing_again(
    program: str, tmp_path: Path
) -> None:
    words = ("sweep", program, "--executor", "inline", "--out", str(tmp_path / "out"))
    code, said = asked(*words, "--grid", GRID)
    assert code == 0
    assert "3 points, 3 of them run now" in said
    code, said = asked(*words, "--grid", GRID)
    assert "3 points, 0 of them run now" in said
    code, said = asked(*words, "--robustness", "2")
    assert "block holds in " in said
    assert {path.suffix for path in (tmp_path / "out").iterdir()} >= {".html", ".jsonl"}


@pytest.mark.parametrize(
    ("words", "said"),
    [
        ((), "nothing is to be moved"),
        (("--random", "clip.step_seconds=0.01:0.02"), "--seeds"),
        (("--grid", GRID, "--executor", "threads"), "inline, processes, ray"),
        (("--grid", GRID, "--address", "auto"), "of ray alone"),
        (("--grid", "scene.objects.ball.friction=0:1:2"), "items: block"),
    ],
)
def test_what_cannot_be_swept_is_one_sentence(
    program: str, tmp_path: Path, words: tuple[str, ...], said: str
) -> None:
    code, told = asked("sweep", program, "--out", str(tmp_path / "out"), *words)
    assert code == 2
    assert said in told


def test_without_a_round_there_is_nothing_to_attribute(tmp_path: Path) -> None:
    from physagent_studio.records import Case
    from tests.sweep.programs import slider

    case = Case("bare", prompt=slider(0.1).program.event.prompt)
    session = Store(tmp_path).create(case, LoopState())
    session.close()
    code, told = asked("attribute", session.id, "--workspace", str(tmp_path))
    assert code == 2
    assert "no such simulated round" in told
