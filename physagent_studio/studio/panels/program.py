"""Program: the YAML text and what is wrong with it."""

from __future__ import annotations

from typing import Any

from physagent_studio.program.text.document import dump_program
from physagent_studio.workbench import Snapshot


def state_of(snapshot: Snapshot) -> dict[str, Any]:
    """The text, its problems at their lines, and whether it may be applied."""
    return {
        "session": snapshot.session_id,
        # Of the program itself; a text that somebody only had checked is not it.
        "text": dump_program(snapshot.program),
        "problems": [
            {"line": one.line, "path": one.path, "message": one.message, "allowed": one.allowed}
            for one in snapshot.yaml_problems
        ],
        "readOnly": snapshot.read_only,
        "draft": snapshot.has_draft,
        "hash": snapshot.program.hash,
    }
