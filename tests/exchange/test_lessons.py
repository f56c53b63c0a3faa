"""Lessons leave a session as a file, come back the same, and a bad file says where."""

from __future__ import annotations

from pathlib import Path

import pytest

from physagent_studio.errors import InputError
from physagent_studio.exchange import read_lessons, write_lessons
from physagent_studio.records import Lesson

LESSONS = (
    Lesson(
        mismatch="misses", factor="direction", decided="accept", failing_before=2, failing_after=0
    ),
    Lesson(
        mismatch="misses",
        factor="magnitude",
        decided="reject",
        failing_before=2,
        reason="it is a gentle push",
    ),
)


def test_lessons_come_back_as_they_were(tmp_path: Path) -> None:
    path = write_lessons(tmp_path / "lessons.yaml", LESSONS)
    assert read_lessons(path) == LESSONS
    assert [lesson.helped for lesson in LESSONS] == [True, False]


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("lessons: 3", "must hold a list `lessons`"),
        ("[]", "must hold a list `lessons`"),
        ("lessons:\n- {mismatch: misses, factor: aim, decided: accept}", "failing_before"),
        ("lessons:\n- {mismatch: m, factor: f, decided: perhaps, failing_before: 1}", "line 2"),
        ("lessons:\n- {mismatch: m, factor: f, decided: skip, failing_before: .nan}", "line 2"),
        ("lessons: [", "line"),
    ],
)
def test_a_bad_file_says_where(tmp_path: Path, text: str, said: str) -> None:
    path = tmp_path / "lessons.yaml"
    path.write_text(text)
    with pytest.raises(InputError, match=said):
        read_lessons(path)


def test_a_missing_file_is_one_sentence(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="cannot be read"):
        read_lessons(tmp_path / "none.yaml")
