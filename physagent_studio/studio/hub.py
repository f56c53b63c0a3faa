"""The hub: what all browsers get to know, and what they ask for, over our own socket.

A channel carries one JSON value, and only its newest matters: a browser that is slow gets fewer
of them, never a backlog. A browser that comes (or comes back) gets the newest of every channel,
so a page is always rebuilt from what the server holds.
"""

from __future__ import annotations

import asyncio
import json
import threading
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

from websockets.asyncio.server import ServerConnection
from websockets.exceptions import ConnectionClosed

Heard = Callable[[int, str], None]
"""Browser's number and the text that it sent; called on the event loop, must return at once."""


@dataclass(eq=False, slots=True)
class _Browser:
    """One open page: what it still has to be sent."""

    number: int
    waiting: dict[str, str] = field(default_factory=dict)
    letters: list[str] = field(default_factory=list)
    news: asyncio.Event = field(default_factory=asyncio.Event)


class Hub:
    """Newest values out, texts in. All methods but `talk` may be called from any thread."""

    def __init__(self, heard: Heard, counted: Callable[[int], None]) -> None:
        self._heard = heard
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
            browsers = tuple(self._browsers.values())
        for browser in browsers:
            self._send(browser, channel, text)

    def tell(self, number: int | None, channel: str, value: Any) -> None:
        """Sends something once, to one browser or (None) to all that are there now."""
        text = json.dumps({"on": channel, "is": value}, separators=(",", ":"), allow_nan=False)
        with self._lock:
            chosen = [b for b in self._browsers.values() if number in (None, b.number)]
        for browser in chosen:
            self._send(browser, None, text)

    def _send(self, browser: _Browser, channel: str | None, text: str) -> None:
        def put() -> None:
            if channel is not None:
                browser.waiting[channel] = text
            elif len(browser.letters) < 200:
                browser.letters.append(text)
            browser.news.set()

        if self._loop is not None and not self._loop.is_closed():
            self._loop.call_soon_threadsafe(put)

    async def talk(self, connection: ServerConnection) -> None:
        """Serves one browser until it goes."""
        self._loop = asyncio.get_running_loop()
        with self._lock:
            browser = _Browser(self._next, dict(self._newest))
            self._next += 1
            self._browsers[browser.number] = browser
            count = len(self._browsers)
        browser.news.set()
        self._counted(count)
        speaking = asyncio.create_task(self._speak(connection, browser))
        try:
            async for message in connection:
                if isinstance(message, str):
                    self._heard(browser.number, message)
        except ConnectionClosed:
            pass
        finally:
            speaking.cancel()
            await asyncio.gather(speaking, return_exceptions=True)
            with self._lock:
                del self._browsers[browser.number]
                count = len(self._browsers)
            self._counted(count)

    async def _speak(self, connection: ServerConnection, browser: _Browser) -> None:
        hello = {"on": "hello", "is": {"browser": browser.number}}
        await connection.send(json.dumps(hello))
        while True:
            await browser.news.wait()
            browser.news.clear()
            waiting, browser.waiting = browser.waiting, {}
            letters, browser.letters = browser.letters, []
            for text in (*waiting.values(), *letters):
                await connection.send(text)
