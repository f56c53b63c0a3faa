"""Newest values reach every browser, old ones never queue up."""

from __future__ import annotations

import asyncio
import json
import threading
import time
from collections.abc import Callable, Iterator
from concurrent.futures import ThreadPoolExecutor
from typing import Any

import pytest
from websockets.asyncio.server import serve
from websockets.sync.client import connect

from physagent_studio.studio.hub import AHEAD, Hub


@pytest.fixture
def hub() -> Iterator[tuple[Hub, str, list[tuple[int, str]]]]:
    heard: list[tuple[int, str]] = []
    hub = Hub(lambda number, text: heard.append((number, text)), lambda count: None)
    loop = asyncio.new_event_loop()
    ready, address = threading.Event(), [""]
    stop = asyncio.Event()

    async def run() -> None:
        async with serve(hub.talk, "127.0.0.1", 0) as server:
            address[0] = f"ws://127.0.0.1:{server.sockets[0].getsockname()[1]}"
            ready.set()
            await stop.wait()

    thread = threading.Thread(target=lambda: loop.run_until_complete(run()), daemon=True)
    thread.start()
    assert ready.wait(5)
    yield hub, address[0], heard
    loop.call_soon_threadsafe(stop.set)
    thread.join(5)


def _until(line: Any, wanted: Callable[[dict[str, Any]], bool]) -> dict[str, Any]:
    while True:
        message = json.loads(line.recv(timeout=5))
        if wanted(message):
            return message


def test_a_late_browser_gets_the_newest_of_every_channel(hub: Any) -> None:
    board, address, _ = hub
    for number in range(50):
        board.publish("run", {"n": number})
    board.publish("rounds", {"r": 1})
    with connect(address) as line:
        got = {}
        while not {"run", "rounds"} <= set(got):
            message = json.loads(line.recv(timeout=5))
            got[message["on"]] = message["is"]
        assert got["run"] == {"n": 49}
        assert got["rounds"] == {"r": 1}


def test_unchanged_values_are_not_sent_again(hub: Any) -> None:
    board, address, _ = hub
    with connect(address) as line:
        _until(line, lambda m: m["on"] == "hello")
        board.publish("run", {"n": 1})
        board.publish("run", {"n": 1})
        board.publish("last", True)
        seen = [json.loads(line.recv(timeout=5))["on"] for _ in range(2)]
        assert seen == ["run", "last"]


def test_letters_reach_one_browser_only(hub: Any) -> None:
    board, address, _ = hub
    with connect(address) as first, connect(address) as second:
        mine = _until(first, lambda m: m["on"] == "hello")["is"]["browser"]
        _until(second, lambda m: m["on"] == "hello")
        board.tell(mine, "say", {"text": "for you"})
        board.publish("end", 1)
        assert _until(first, lambda m: m["on"] == "say")["is"]["text"] == "for you"
        assert _until(second, lambda m: m["on"] in ("say", "end"))["on"] == "end"


def test_what_is_heard_carries_the_browser(hub: Any) -> None:
    board, address, heard = hub
    with connect(address) as line:
        number = _until(line, lambda m: m["on"] == "hello")["is"]["browser"]
        line.send('{"do":"play"}')
        board.publish("x", 1)
        _until(line, lambda m: m["on"] == "x")
        for _ in range(200):
            if heard:
                break
            threading.Event().wait(0.01)
        assert heard == [(number, '{"do":"play"}')]


def test_who_asks_for_more_than_is_carried_out_is_not_read(hub: Any) -> None:
    board, address, heard = hub
    full: set[int] = set()
    board._full = lambda number: number in full
    with connect(address) as first, connect(address) as second:
        mine = _until(first, lambda m: m["on"] == "hello")["is"]["browser"]
        _until(second, lambda m: m["on"] == "hello")
        full.add(mine)
        first.send("waits")
        second.send("is heard")
        _met(lambda: len(heard) == 1)
        assert heard[0][1] == "is heard"
        full.clear()
        _met(lambda: len(heard) == 2)
        assert heard[1] == (mine, "waits")


def _met(holds: Callable[[], bool]) -> None:
    until = time.monotonic() + 5
    while not holds():
        assert time.monotonic() < until
        time.sleep(0.01)


class _Deaf:
    """A connection that takes everything and never says that it came."""

    def __init__(self) -> None:
        self.sent = 0

    async def send(self, _text: str) -> None:
        self.sent += 1

    async def ping(self) -> asyncio.Future[float]:
        return asyncio.get_running_loop().create_future()

    def __aiter__(self) -> _Deaf:
        return self

    async def __anext__(self) -> str:
        await asyncio.Event().wait()
        raise AssertionError("it never speaks")


def test_whoever_never_answers_is_sent_a_few_updates_and_no_more() -> None:
    board, line = Hub(lambda *_: None, lambda _count: None), _Deaf()

    async def run() -> None:
        talking = asyncio.create_task(board.talk(line))  # type: ignore[arg-type]
        for number in range(10 * AHEAD):
            board.publish("run", number)
            await asyncio.sleep(0.001)
        talking.cancel()
        await asyncio.gather(talking, return_exceptions=True)

    # In a thread of its own: a browser's test before it may have left its loop in this one.
    with ThreadPoolExecutor(1) as pool:
        pool.submit(asyncio.run, run()).result()
    assert AHEAD < line.sent <= 2 * AHEAD + 1
