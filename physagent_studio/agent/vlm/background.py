"""Runs one coroutine beside the caller, who can cancel it at any moment."""

from __future__ import annotations

import asyncio
import concurrent.futures
import threading
from collections.abc import Callable, Coroutine
from typing import Any, TypeVar

from physagent_studio.errors import Cancelled

T = TypeVar("T")
POLL_SECONDS = 0.05


def run_cancellable(
    work: Callable[[], Coroutine[Any, Any, T]], timeout: float, cancelled: Callable[[], bool]
) -> T:
    """The coroutine's result.

    It runs in an event loop of its own in a daemon thread, so that cancelling it closes its
    sockets even while a server drips one byte at a time.

    Raises:
        TimeoutError: it took longer than `timeout` seconds in all.
        Cancelled: `cancelled()` became true; the caller is free within `POLL_SECONDS`.
    """
    loop = asyncio.new_event_loop()
    thread = threading.Thread(target=_serve, args=(loop,), name="vlm-call", daemon=True)
    thread.start()
    future = asyncio.run_coroutine_threadsafe(asyncio.wait_for(work(), timeout), loop)
    try:
        while not future.done():
            if cancelled():
                raise Cancelled("cancelled")
            concurrent.futures.wait([future], POLL_SECONDS)
        return future.result()
    finally:
        # Also where the caller is interrupted: nothing goes on behind its back.
        future.cancel()
        loop.call_soon_threadsafe(loop.stop)


def _serve(loop: asyncio.AbstractEventLoop) -> None:
    asyncio.set_event_loop(loop)
    loop.run_forever()
    left = asyncio.all_tasks(loop)
    for task in left:
        task.cancel()
    loop.run_until_complete(asyncio.gather(*left, return_exceptions=True))
    loop.run_until_complete(loop.shutdown_asyncgens())
    loop.close()


def wait(seconds: float, cancelled: Callable[[], bool]) -> None:
    """Sleeps, or raises `Cancelled` as soon as `cancelled()` is true."""
    quiet = threading.Event()
    left = seconds
    while True:
        if cancelled():
            raise Cancelled("cancelled")
        if left <= 0:
            return
        quiet.wait(min(left, POLL_SECONDS))
        left -= POLL_SECONDS
