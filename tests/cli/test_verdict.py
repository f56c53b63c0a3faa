"""What a run says while it works and in the end, and the pictures that it writes."""

from __future__ import annotations

import json
import re
from pathlib import Path

import cv2
import pytest
from typer.testing import CliRunner, Result

from physagent_studio.assets import assets_dir
from physagent_studio.cli.app import app
from physagent_studio.session import Store

pytestmark = pytest.mark.usefixtures("shared_scenes")

PHOTO = assets_dir() / "demo" / "input.png"
FAILS = "knocks_block_over"
"""An event of the demo whose first program is too short to be seen: one round is not enough."""


def _run(home: Path, *words: str) -> Result:
    place = ("--event", FAILS, "--rounds", "1", "--workspace", str(home))
    return CliRunner().invoke(app, ["run", str(assets_dir() / "demo"), *place, *words])


def test_the_verdict_comes_first_and_then_only_what_fails(tmp_path: Path) -> None:
    result = _run(tmp_path, "--masks", str(tmp_path / "masks.png"))
    lines = result.stdout.splitlines()
    assert lines[0].startswith("session ")
    assert lines[1].startswith("not realised (budget): ")
    # What the verdict says is not said again.
    assert result.stdout.count(lines[1].removeprefix("not realised (budget): ").split(" (")[0]) == 1
    assert "✓" not in result.stdout
    assert "(--verbose lists them)" in result.stdout
    # At what pace it is shown.
    assert "clip: 3.2 s at 25 frames a second, real time" in result.stdout
    picture, photo = (cv2.imread(str(p)) for p in (tmp_path / "masks.png", PHOTO))
    assert picture is not None
    assert photo is not None
    assert picture.shape == photo.shape
    assert (picture != photo).any()

    listed = CliRunner().invoke(app, ["run", *_again(tmp_path), "--verbose"])
    assert listed.stdout.count("✓") > 10


def test_where_nothing_is_left_to_try_it_says_what_a_person_can_do(tmp_path: Path) -> None:
    words = ("--prompt", "The red ball rolls to the right.", "--object", "red ball@10,10,11,11")
    place = ("--yes", "--workspace", str(tmp_path))
    result = CliRunner().invoke(app, ["run", str(PHOTO), *words, *place])
    lines = result.stdout.splitlines()
    assert lines[1].startswith("not realised (stuck): red ball is cut out of the photo, 0 pixels")
    assert "Can you click on what is missing of red ball?" in lines
    assert "1 check holds (--verbose lists them)" in lines


def _again(home: Path) -> list[str]:
    """The words that go on with the one session there is, which has nothing left to do."""
    (one,) = Store(home).list()
    return [one.id, "--workspace", str(home)]


def test_it_tells_of_its_stages_but_not_to_machines(tmp_path: Path) -> None:
    told = _run(tmp_path / "a").stderr.splitlines()
    assert all(re.fullmatch(r" *\d+\.\d s  \S.*", line) for line in told)
    assert any("round 1: simulating" in line for line in told)
    silent = _run(tmp_path / "b", "--json")
    assert silent.stderr == ""
    assert json.loads(silent.stdout)["outcome"] == "budget"


def test_horizon_and_length_on_the_command_line_are_taken_over(tmp_path: Path) -> None:
    result = _run(tmp_path, "--horizon", "200", "--seconds", "2", "--json")
    assert "camera" not in [one["kind"] for one in json.loads(result.stdout)["doubts"]]
    (one,) = Store(tmp_path).list()
    with Store(tmp_path).open(one.id, writing=False) as session:
        assert session.case.horizon == 200
        (first,) = session.load().rounds
        assert first.program.scene.horizon == pytest.approx(200)
        assert first.program.clip.frames == 51
    more = CliRunner().invoke(app, ["run", *_again(tmp_path), "--horizon", "0"])
    assert more.exit_code == 2
    assert "--horizon" in more.stderr


@pytest.mark.parametrize(
    "words",
    [
        ("--out", "clip.gif"),
        ("--masks", "masks.jpg"),
        ("--horizon", "99999"),
        ("--seconds", "1"),
        ("--seconds", "3", "--agent", "vlm"),
    ],
)
def test_what_cannot_be_written_is_said_at_once(tmp_path: Path, words: tuple[str, ...]) -> None:
    result = _run(tmp_path, *words)
    assert result.exit_code == 2
    assert not Store(tmp_path).list()
