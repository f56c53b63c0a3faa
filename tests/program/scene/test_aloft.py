"""Stands, hangs, floats, falls: one field, and programs that came before it."""

from __future__ import annotations

import pytest

from physagent_studio.errors import ProgramError
from physagent_studio.program.scene.aloft import carriage_of
from physagent_studio.program.text.document import dump_program, load_program

PLAIN = """
scene:
  objects:
    - {name: ball, shape: {kind: sphere, radius: 0.1}, position: [0, 2, 1.1], support: SUPPORT}
  supports: [{name: floor, shape: {kind: floor}}]
"""


def program(support: str):
    return load_program(PLAIN.replace("SUPPORT", support))


@pytest.mark.parametrize(
    ("support", "how"),
    [
        ("floor", "stands"),
        ("air", "falls"),
        ("air, aloft: hangs", "hangs"),
        ("air, aloft: floats", "floats"),
    ],
)
def test_how_a_thing_is_held_survives_its_text(support: str, how: str) -> None:
    first = program(support)
    again = load_program(dump_program(first))
    assert again == first
    assert again.hash == first.hash
    assert carriage_of(again.scene.objects[0]) == how


def test_programs_of_before_keep_their_hash() -> None:
    # As version 1 had them, before there was the field.
    assert program("air").hash == (
        "f7334d9ba3d829fffa755bfef09d53389e08dcd2a046361651f763be05d6e466"
    )
    assert program("air").hash != program("air, aloft: hangs").hash


@pytest.mark.parametrize(
    "support", ["floor, aloft: hangs", "air, aloft: floats, body: {kind: cloth}", "air, aloft: x"]
)
def test_what_contradicts_itself_is_refused(support: str) -> None:
    with pytest.raises(ProgramError, match="aloft"):
        program(support)
