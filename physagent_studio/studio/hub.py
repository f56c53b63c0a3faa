"""The hub: what all browsers get to know, and what they ask for, over our own socket.

A channel carries one JSON value, and only its newest matters: a browser that is slow gets fewer
of them, never a backlog. A browser that comes (or comes back) gets the newest of every channel,
so a page is always rebuilt from what the server holds.
"""

import asyncio
import itertools
import json
import threading
from collections.abc import Awaitable, Callable
from dataclasses import dataclass, field
from typing import Any

from websockets.asyncio.server import ServerConnection
from websockets.exceptions import ConnectionClosed

from physagent_studio.studio.access import Role

MAX_UNHEARD = 2**20
"""Characters that wait to be dealt with before nothing more is read, but for one message."""
MAX_LETTERS = 8 * 2**20
"""Characters that wait for one browser, besides the newest of every channel."""
AHEAD = 8
"""Updates that a browser may be behind by at least, and by twice as many at most."""

Heard = Callable[[int, str], None]
"""Browser's number and the text that it sent; called on the event loop, must return at once."""


@dataclass(eq=False, slots=True)
class _Browser:
    """One open page: what it still has to be sent."""

    number: int
    role: Role
    waiting: dict[str, str] = field(default_factory=dict)
    letters: list[str] = field(default_factory=list)
    news: asyncio.Event = field(default_factory=asyncio.Event)


class Hub:
    """Newest values out, texts in. All methods but `talk` may be called from any thread."""

    def __init__(
        self,
        heard: Heard,
        counted: Callable[[int], None],
        gone: Callable[[int], None] = lambda number: None,
        full: Callable[[int], bool] = lambda number: False,
    ) -> None:
        """full: whether so much of a browser still waits that it is not read for a while."""
        self._full = full
        self._heard = heard
        self._gone = gone
        self._unheard = 0
        self._counted = counted
        self._lock = threading.Lock()
        self._newest: dict[str, str] = {}
        self._browsers: dict[int, _Browser] = {}
        self._next = 0
        self._loop: asyncio.AbstractEventLoop | None = None

    def publish(self, channel: str, value: Any) -> None:
        """Makes `value` the newest of a channel; nothing is sent when it has not changed."""
        text = json.dumps({"on": channel, "is": value}, separators=(",", ":"), allow_nan=False)
        with self._lock:
            if self._newest.get(channel) == text:
                return
            self._newest[channel] = text
            browsers = list(self._browsers.values())
        self._send(browsers, channel, text)

    def tell(self, number: int | None, channel: str, value: Any) -> None:
        """Sends something once, to one browser or (None) to all that are there now."""
        text = json.dumps({"on": channel, "is": value}, separators=(",", ":"), allow_nan=False)
        with self._lock:
            chosen = [b for b in self._browsers.values() if number in (None, b.number)]
        self._send(chosen, None, text)

    def _send(self, browsers: list[_Browser], channel: str | None, text: str) -> None:
        def put() -> None:
            for browser in browsers:
                if channel is not None:
                    browser.waiting[channel] = text
                elif sum(map(len, browser.letters)) + len(text) < MAX_LETTERS:
                    browser.letters.append(text)
                browser.news.set()

        if browsers and self._loop is not None and not self._loop.is_closed():
            self._loop.call_soon_threadsafe(put)

    def role(self, number: int) -> Role:
        """What the person at a browser may do; somebody who has gone only watches."""
        with self._lock:
            browser = self._browsers.get(number)
        return "viewer" if browser is None else browser.role

    def done_with(self, text: str) -> None:
        """A text that was heard has been dealt with: there is room for another."""
        with self._lock:
            self._unheard -= len(text)

    async def _room(self, number: int) -> None:
        """Waits while more is unheard than may be; so whoever sends too fast is not read."""
        while self._unheard > MAX_UNHEARD or self._full(number):
            await asyncio.sleep(0.01)

    async def talk(self, connection: ServerConnection, role: Role = "editor") -> None:
        """Serves one browser until it goes."""
        self._loop = asyncio.get_running_loop()
        with self._lock:
            browser = _Browser(self._next, role, dict(self._newest))
            self._next += 1
            self._browsers[browser.number] = browser
            count = len(self._browsers)
        browser.news.set()
        self._counted(count)
        speaking = asyncio.create_task(self._speak(connection, browser))
        try:
            async for message in connection:
                if isinstance(message, str):
                    await self._room(browser.number)
                    with self._lock:
                        self._unheard += len(message)
                    self._heard(browser.number, message)
        except ConnectionClosed:
            pass
        finally:
            speaking.cancel()
            await asyncio.gather(speaking, return_exceptions=True)
            with self._lock:
                del self._browsers[browser.number]
                count = len(self._browsers)
            self._gone(browser.number)
            self._counted(count)

    async def _speak(self, connection: ServerConnection, browser: _Browser) -> None:
        hello = {"on": "hello", "is": {"browser": browser.number}}
        await connection.send(json.dumps(hello))
        answered: Awaitable[float] | None = None
        for count in itertools.count():
            if count % AHEAD == 0:
                # Whoever does not even say that something came is sent nothing more.
                if answered is not None:
                    await answered
                answered = await connection.ping()
            await browser.news.wait()
            browser.news.clear()
            waiting, browser.waiting = browser.waiting, {}
            letters, browser.letters = browser.letters, []
            for text in (*waiting.values(), *letters):
                await connection.send(text)
