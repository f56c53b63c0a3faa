"""The newest question wins, and what takes longer is answered in two steps."""

from __future__ import annotations

import threading
from typing import Any

from physagent_studio.studio.photo_desk import Finder


def _finder() -> tuple[Finder, list[dict[str, Any]], threading.Semaphore]:
    told: list[dict[str, Any]] = []
    heard = threading.Semaphore(0)

    def tell(browser: int, channel: str, found: dict[str, Any]) -> None:
        told.append({"browser": browser, "channel": channel, **found})
        heard.release()

    return Finder(tell), told, heard


def test_more_follows_where_there_is_more() -> None:
    finder, told, heard = _finder()
    try:
        finder.ask(1, "masks", 7, lambda: {"masks": 4, "more": True}, lambda: {"masks": 5})
        assert heard.acquire(timeout=10)
        assert heard.acquire(timeout=10)
        finder.ask(1, "masks", 8, lambda: {"masks": 3, "more": False}, lambda: {"masks": 9})
        finder.ask(2, "masks", 9, lambda: {"masks": 2})
        assert heard.acquire(timeout=10)
        assert heard.acquire(timeout=10)
    finally:
        finder.stop()
    assert [(one["ticket"], one["masks"]) for one in told] == [(7, 4), (7, 5), (8, 3), (9, 2)]


def test_what_was_overtaken_is_not_looked_at_further() -> None:
    finder, told, heard = _finder()

    def first() -> dict[str, Any]:
        finder.ask(1, "masks", 2, lambda: {"masks": "new"})
        return {"masks": "old", "more": True}

    try:
        finder.ask(1, "masks", 1, first, lambda: {"masks": "never"})
        assert heard.acquire(timeout=10)
        assert heard.acquire(timeout=10)
    finally:
        finder.stop()
    assert [one["masks"] for one in told] == ["old", "new"]


def test_a_failure_is_told_and_ends_the_question() -> None:
    finder, told, heard = _finder()

    def fails() -> dict[str, Any]:
        raise ValueError("a bug")

    try:
        finder.ask(1, "masks", 1, fails, lambda: {"masks": "never"})
        assert heard.acquire(timeout=10)
        finder.ask(1, "masks", 2, lambda: {"masks": "next"})
        assert heard.acquire(timeout=10)
    finally:
        finder.stop()
    assert "a bug" in told[0]["problem"]
    assert told[1]["masks"] == "next"


def test_what_is_found_early_is_told_unless_something_newer_was_asked() -> None:
    finder, told, heard = _finder()

    def first() -> dict[str, Any]:
        finder.tell_early(1, "masks", 1, {"masks": "so far", "early": True})
        finder.ask(1, "masks", 2, lambda: {"masks": "new"})
        finder.tell_early(1, "masks", 1, {"masks": "overtaken", "early": True})
        return {"masks": "old"}

    try:
        finder.ask(1, "masks", 1, first)
        assert all(heard.acquire(timeout=10) for _ in range(3))
    finally:
        finder.stop()
    assert [(one["ticket"], one["masks"]) for one in told] == [
        (1, "so far"),
        (1, "old"),
        (2, "new"),
    ]
