"""What a browser may ask of the list of sessions, of presenting and of files to take away."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import Field

from physagent_studio.program import Frozen

Key = Annotated[str, Field(min_length=1, max_length=200)]


class _OfSession(Frozen):
    """What is asked about one session of the list."""

    key: Key


class RenameSession(_OfSession):
    """Gives a listed session another title."""

    do: Literal["rename_session"] = "rename_session"
    title: Annotated[str, Field(min_length=1, max_length=200)]


class DuplicateSession(_OfSession):
    """Copies a listed session."""

    do: Literal["duplicate_session"] = "duplicate_session"


class DeleteSession(_OfSession):
    """Takes a session off the list; it can be brought back for a week."""

    do: Literal["delete_session"] = "delete_session"


class RestoreSession(_OfSession):
    """Brings a deleted session back."""

    do: Literal["restore_session"] = "restore_session"


class ListSessions(Frozen):
    """Looks which sessions there are now; the command line makes some too."""

    do: Literal["list_sessions"] = "list_sessions"


class Present(Frozen):
    """From now on this page only looks, or (`on` false) may change things again."""

    do: Literal["present"] = "present"
    on: bool


class Export(Frozen):
    """Writes the session as one HTML file, or the scene as a recording for viser."""

    do: Literal["export"] = "export"
    kind: Literal["html", "viser"]


ShelfIntent = (
    RenameSession | DuplicateSession | DeleteSession | RestoreSession | ListSessions | Present
    | Export
)  # fmt: skip
