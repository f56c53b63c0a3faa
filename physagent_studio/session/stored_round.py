"""Rounds that are read from the database when something of them is looked at.

A session of ten thousand rounds opens at once: of each only id, number and parent are read.
"""

import sqlite3
import threading
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from physagent_studio.errors import InputError
from physagent_studio.records import Round
from physagent_studio.session.schema import connect


class RoundReader:
    """Reads single rounds, from any thread, also after the session was closed."""

    def __init__(self, path: Path) -> None:
        self._path = path
        self._lock = threading.Lock()
        self._db: sqlite3.Connection | None = None

    def stub(self, key: str, number: int, parent: str | None) -> Round:
        """A round of which the rest is read when it is needed."""
        stub = _StoredRound.model_construct(
            {"id", "number", "parent"}, id=key, number=number, parent=parent
        )
        for name in _LATE:
            vars(stub).pop(name, None)
        vars(stub)[_READER] = self
        return stub

    def read(self, key: str) -> Round:
        """The whole round."""
        with self._lock:
            if self._db is None:
                self._db = connect(self._path, writing=False)
            row = self._db.execute("SELECT payload FROM rounds WHERE id = ?", (key,)).fetchone()
        if row is None:
            raise InputError(f"round {key} is not in the session any more")
        return Round.model_validate_json(row[0])

    def close(self) -> None:
        """Lets go of the file; a later reading opens it again."""
        with self._lock:
            if self._db is not None:
                self._db.close()
                self._db = None


_READER = "_reader"
_LATE = frozenset(Round.model_fields) - {"id", "number", "parent"}


class _StoredRound(Round):
    """A round until it is looked at; then it turns into a plain one."""

    def _whole(self) -> Round:
        own = vars(self)
        if _READER in own:
            found = own[_READER].read(own["id"])
            own.pop(_READER, None)
            own.update(vars(found))
            object.__setattr__(self, "__pydantic_fields_set__", found.model_fields_set)
            object.__setattr__(self, "__class__", Round)
        return self

    def __getattr__(self, name: str) -> Any:
        if name in _LATE and _READER in vars(self):
            return getattr(self._whole(), name)
        raise AttributeError(name)

    def __eq__(self, other: object) -> bool:
        return self is other or Round.__eq__(self._whole(), other)

    __hash__ = Round.__hash__

    def model_copy(self, *, update: Mapping[str, Any] | None = None, deep: bool = False) -> Any:
        return Round.model_copy(self._whole(), update=update, deep=deep)

    def model_dump(self, **options: Any) -> dict[str, Any]:
        return Round.model_dump(self._whole(), **options)

    def model_dump_json(self, **options: Any) -> str:
        return Round.model_dump_json(self._whole(), **options)
