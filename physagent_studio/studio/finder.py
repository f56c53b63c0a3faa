"""What takes a moment and changes nothing: found beside the worker, the newest question wins.

A question that was overtaken by another of the same browser on the same channel is dropped, so
that fast clicks never queue up. What takes longer is answered twice: first what is found at once.
"""

from __future__ import annotations

import threading
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

from physagent_studio.workbench.boundary import guarded

Tell = Callable[[int, str, dict[str, Any]], None]
"""Browser, channel, what was found; called on the finder's thread."""


@dataclass(frozen=True, eq=False, slots=True)
class _Question:
    ticket: int
    finds: tuple[Callable[[], dict[str, Any]], ...]


class Finder:
    """One thread that answers browsers; every answer carries the ticket of its question."""

    def __init__(self, tell: Tell) -> None:
        self._tell = tell
        self._news = threading.Condition()
        self._asked: dict[tuple[int, str], _Question] = {}
        self._open = True
        self._thread = threading.Thread(target=self._work, name="finder", daemon=True)
        self._thread.start()

    def ask(self, browser: int, channel: str, ticket: int, *finds: Callable[[], Any]) -> None:
        """Has `finds` called soon, one after the other, unless something newer is asked before.

        Each one's answer is sent at once; the next is only called where it says that there is
        `more`.
        """
        with self._news:
            self._asked.pop((browser, channel), None)
            self._asked[browser, channel] = _Question(ticket, finds)
            self._news.notify()

    def tell_early(self, browser: int, channel: str, ticket: int, found: dict[str, Any]) -> None:
        """Sends what there is of an answer while its question is looked into; from any thread."""
        if not self.overtaken(browser, channel):
            self._tell(browser, channel, {"ticket": ticket, **found})

    def stop(self) -> None:
        """Ends the thread once the question at hand is answered."""
        with self._news:
            self._open = False
            self._news.notify()
        self._thread.join(timeout=10)

    def _work(self) -> None:
        while True:
            with self._news:
                self._news.wait_for(lambda: self._asked or not self._open)
                if not self._open:
                    return
                browser, channel = next(iter(self._asked))
                question = self._asked.pop((browser, channel))
            for find in question.finds:
                found = guarded(find, lambda text: {"problem": text}, "a search")
                self._tell(browser, channel, {"ticket": question.ticket, **found})
                if not found.get("more") or self.overtaken(browser, channel):
                    break

    def overtaken(self, browser: int, channel: str) -> bool:
        """Whether nobody waits for what is being looked for any more."""
        with self._news:
            return not self._open or (browser, channel) in self._asked
