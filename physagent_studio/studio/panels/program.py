"""Program: the YAML text and what is wrong with it."""

from __future__ import annotations

from functools import lru_cache
from typing import Any

from physagent_studio.program import PhysicalProgram
from physagent_studio.program.document import dump_program
from physagent_studio.workbench import Snapshot


def state_of(snapshot: Snapshot) -> dict[str, Any]:
    """The text, its problems at their lines, and whether it may be applied."""
    return {
        "session": snapshot.session_id,
        "text": _text_of(snapshot.program),
        "problems": [
            {"line": one.line, "path": one.path, "message": one.message, "allowed": one.allowed}
            for one in snapshot.yaml_problems
        ],
        "readOnly": snapshot.read_only,
        "draft": snapshot.has_draft,
        "hash": snapshot.program.hash,
    }


@lru_cache(maxsize=8)
def _text_of(program: PhysicalProgram) -> str:
    """The text of the program itself; what somebody only had checked is not it."""
    return dump_program(program)
