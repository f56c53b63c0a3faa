"""Lessons of a session as a file: what helped against which mismatch, for the next session."""

from collections.abc import Sequence
from pathlib import Path

import yaml
from pydantic import ValidationError

from physagent_studio.errors import InputError
from physagent_studio.exchange.plain_yaml import MAX_BYTES, read_yaml
from physagent_studio.records import Lesson

MOST = 1000
"""Most lessons that a file may hold."""


def write_lessons(path: Path, lessons: Sequence[Lesson]) -> Path:
    """Writes lessons as YAML, one mapping each; returns the path."""
    rows = [lesson.model_dump(mode="json", exclude_none=True) for lesson in lessons]
    path.write_text(yaml.safe_dump({"lessons": rows}, sort_keys=False, allow_unicode=True))
    return path


def read_lessons(path: Path | str) -> tuple[Lesson, ...]:
    """The lessons of a file; raises InputError with the line of what is wrong."""
    path = Path(path)
    try:
        if path.stat().st_size > MAX_BYTES:
            raise InputError(f"{path.name} is larger than {MAX_BYTES // 1000} kB")
        document = read_yaml(path.read_text(encoding="utf-8"), path.name)
    except OSError as error:
        raise InputError(f"{path} cannot be read: {error.strerror}") from error
    except UnicodeDecodeError as error:
        raise InputError(f"{path.name} is not UTF-8 text") from error
    rows = document.data.get("lessons") if isinstance(document.data, dict) else None
    if not isinstance(rows, list) or len(rows) > MOST:
        raise InputError(f"{path.name} must hold a list `lessons` of at most {MOST} entries")
    found: list[Lesson] = []
    for number, row in enumerate(rows):
        try:
            found.append(Lesson.model_validate(row))
        except ValidationError as error:
            first = error.errors()[0]
            field = ".".join(str(part) for part in first["loc"])
            line = document.line(("lessons", number, *first["loc"][:1]))
            raise InputError(
                f"{path.name}, line {line}: lesson {number + 1}, {field or 'entry'}: {first['msg']}"
            ) from error
    return tuple(found)
