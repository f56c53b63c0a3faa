"""The list of stored sessions; loads nothing that reconstructs or simulates."""

from __future__ import annotations

from pathlib import Path

from physagent_studio.errors import InputError
from physagent_studio.session import SessionInfo, Store


def list_sessions(workspace: Path | None) -> tuple[SessionInfo, ...]:
    """All sessions of the workspace."""
    store = Store(workspace)
    if store.root.exists() and not store.root.is_dir():
        raise InputError(f"{store.root} is a file; a workspace is a folder")
    return store.list()
