"""Programs of before and of later."""

from __future__ import annotations

from pathlib import Path

import pytest

from physagent_studio.errors import ProgramError
from physagent_studio.program.scene.state import Sphere
from physagent_studio.program.text import document
from physagent_studio.program.text.document import load_program

FIRST_DAY = Path(__file__).parents[1] / "data" / "program_of_the_first_day.yaml"
"""As the first version of this program read it."""


def test_a_program_of_the_first_day_opens_with_all_that_it_says() -> None:
    program = load_program(FIRST_DAY.read_text(encoding="utf-8"))
    ball = program.scene.object("ball")
    assert ball is not None
    assert isinstance(ball.shape, Sphere)
    assert (ball.density, ball.friction, ball.restitution) == (900, 0.5, 0.6)
    assert [action.id for action in program.event.actions] == ["push", "wind", "kick"]
    assert (program.clip.frames, program.clip.substeps) == (41, 5)
    assert program.version == document.VERSION


def test_older_data_is_brought_up_a_version_at_a_time(monkeypatch: pytest.MonkeyPatch) -> None:
    def from_before(data: dict) -> dict:
        rest = {key: value for key, value in data.items() if key != "sentence"}
        return rest | {"event": {"prompt": data["sentence"]}}

    monkeypatch.setitem(document.FROM, 0, from_before)
    program = load_program("version: 0\nsentence: it falls\n")
    assert (program.version, program.event.prompt) == (1, "it falls")


def test_what_a_newer_physagent_has_written_is_refused_with_its_line() -> None:
    with pytest.raises(ProgramError, match=r"line 2, version: .* of version 2, .*newer physagent"):
        load_program("clip: {}\nversion: 2\n")
