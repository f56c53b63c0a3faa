"""What is done to the sessions in the list, open or not."""

from __future__ import annotations

from typing import TYPE_CHECKING

from physagent_studio.errors import InputError
from physagent_studio.studio.intents import shelf as intents
from physagent_studio.workbench import commands

if TYPE_CHECKING:
    from physagent_studio.studio.commands.actions import Studio


def rename(intent: intents.RenameSession, studio: Studio, browser: int) -> None:
    """The open session is the worker's; another is nobody's."""
    name = studio.library.session_of(intent.key)
    title = intent.title.strip()
    if not title:
        raise InputError("a title has 1 to 200 characters")
    if name == studio.snapshot.session_id:
        studio.workbench.post(commands.Rename(title))
    else:
        session = studio.workbench.store.open(name)
        try:
            session.rename(title)
        finally:
            session.close()
    _relist(studio)


def duplicate(intent: intents.DuplicateSession, studio: Studio, browser: int) -> None:
    """The copy stands beside it under the same title with a number behind."""
    store = studio.workbench.store
    name = studio.library.session_of(intent.key)
    titles = {one.title for one in store.list()}
    copy = store.open(store.duplicate(name))
    try:
        copy.rename(_copied(copy.title, titles))
        title = copy.title
    finally:
        copy.close()
    _relist(studio)
    studio.say(browser, "info", f"Copied as “{title}”")


def delete(intent: intents.DeleteSession, studio: Studio, browser: int) -> None:
    """Never the open one: what somebody looks at does not vanish under their hands."""
    name = studio.library.session_of(intent.key)
    if name == studio.snapshot.session_id:
        raise InputError("this session is open; open another one first, then delete it")
    title = next((one.title for one in studio.workbench.store.list() if one.id == name), name)
    studio.workbench.store.discard(name)
    _relist(studio)
    back = {"do": "restore_session", "key": f"session:{name}"}
    studio.say(browser, "info", f"“{title}” was deleted", ("Undo", back))


def restore(intent: intents.RestoreSession, studio: Studio, browser: int) -> None:
    """Undoes a deletion."""
    studio.workbench.store.restore(intent.key.removeprefix("session:"))
    _relist(studio)


def relist(intent: intents.ListSessions, studio: Studio, browser: int) -> None:
    """Tells all pages which sessions there are now."""
    _relist(studio)


def _relist(studio: Studio) -> None:
    studio.library.forget()
    studio.painter.publish_library(studio.library.listing(studio.snapshot))


def _copied(title: str, titles: set[str]) -> str:
    stem, number = title[:190], 2
    while f"{stem} ({number})" in titles:
        number += 1
    return f"{stem} ({number})"
