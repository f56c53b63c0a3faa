"""Versions of the document: who made which, and whether a command was made against an older one."""

import re
import threading
from collections import Counter, deque
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from contextvars import ContextVar
from dataclasses import dataclass

from physagent_studio.errors import InputError
from physagent_studio.workbench import commands

REMEMBERED = 1000
"""Changes that are remembered; a command that is older than all of them counts as stale."""
COMMAND_SIZE = 4096
"""What a waiting command counts at least, in characters."""
MAX_WAITING = 2**22
"""Characters of commands of one client that may wait: a thousand small ones."""
NAMED = 3
"""Changes that a refusal names."""


class Stale(InputError):
    """A command that was made before somebody else changed what it speaks of."""


@dataclass(frozen=True, slots=True)
class Sender:
    """Who asks, having seen which version. refused: told why nothing was done; else all are.

    size: characters of what was asked, which are kept until it is carried out.
    """

    client: int | None = None
    seen: int | None = None
    refused: Callable[[str], None] | None = None
    size: int = 0

    @property
    def author(self) -> str:
        """How the audit names it."""
        return "person" if self.client is None else f"person at page {self.client}"


_SENDER: ContextVar[Sender | None] = ContextVar("sender", default=None)


@contextmanager
def sent_by(sender: Sender) -> Iterator[None]:
    """While this lasts, what is posted from this thread comes from that sender."""
    token = _SENDER.set(sender)
    try:
        yield
    finally:
        _SENDER.reset(token)


def present_sender() -> Sender:
    """Who asks at the moment."""
    return _SENDER.get() or Sender()


class Backlog:
    """What each client has asked for that is not carried out yet; any thread may ask."""

    def __init__(self) -> None:
        self._lock = threading.Lock()
        self._waiting: Counter[int | None] = Counter()

    def add(self, sender: Sender, sign: int = 1) -> None:
        """Counts a command that comes, or (sign −1) one that is done."""
        with self._lock:
            self._waiting[sender.client] += sign * max(sender.size, COMMAND_SIZE)
            if not self._waiting[sender.client]:
                del self._waiting[sender.client]

    def full(self, client: int) -> bool:
        """Whether nothing more should be taken from a client until some of it is done."""
        with self._lock:
            return self._waiting[client] > MAX_WAITING


class Versions:
    """Counts the changes of the document; any thread may ask."""

    def __init__(self) -> None:
        self._lock = threading.Lock()
        self._changes: deque[tuple[int, int | None, str]] = deque(maxlen=REMEMBERED)
        self.number = 0

    def changed(self, sender: Sender, command: commands.Command) -> None:
        """Notes that this command has changed the document."""
        with self._lock:
            self.number += 1
            self._changes.append((self.number, sender.client, words_of(command)))

    def check(self, sender: Sender) -> None:
        """Raises `Stale` where somebody else has changed the document since the sender saw it."""
        if sender.seen is None:
            return
        with self._lock:
            if self._changes and sender.seen < self._changes[0][0] - 1:
                raise Stale("this page was away for too long; look at it again, then ask again")
            others = [
                words
                for number, client, words in self._changes
                if number > sender.seen and client != sender.client
            ]
        if others:
            said = ", ".join(dict.fromkeys(reversed(others[-NAMED:])))
            raise Stale(f"not done, somebody else was faster: {said}. Look, then ask again")


def words_of(command: commands.Command) -> str:
    """What a command changes, in a few words."""
    if isinstance(command, commands.ApplyEdits):
        paths = ", ".join(dict.fromkeys(one.path for one in command.edits[:NAMED]))
        return f"edited {paths}"
    if isinstance(command, commands.Pin | commands.Unpin):
        return f"{type(command).__name__.lower()}ned {command.path}"
    name = re.sub(r"(?<=[a-z])(?=[A-Z])", " ", type(command).__name__).lower()
    return f"“{name}”"
