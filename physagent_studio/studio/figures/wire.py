"""A page and a viewer as a browser has them, over the wire, without a browser."""

from __future__ import annotations

import contextlib
import json
import tempfile
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import viser
import zstandard
from websockets.exceptions import ConnectionClosed
from websockets.sync.client import connect
from websockets.sync.connection import Connection
from websockets.typing import Origin, Subprotocol

from physagent_studio.session import Store
from physagent_studio.studio.access import Access
from physagent_studio.studio.figures.scenes import drifting
from physagent_studio.studio.studio import Studio, serve
from physagent_studio.workbench import Workbench, commands

TOKEN = "00000000000000000000beef"
HEAD = 16
"""Bytes before the compressed part of what viser sends; the second eight are its length."""


def open_page(studio: Studio) -> Connection:
    """The page's own line."""
    port = studio.address.rpartition(":")[2]
    line = connect(f"ws://127.0.0.1:{port}/socket", origin=Origin(studio.address), max_size=None)
    line.send(json.dumps({"do": "viewer", "token": TOKEN}))
    return line


def open_viewer(studio: Studio) -> Connection:
    """The 3D view's line."""
    port = studio.address.rpartition(":")[2]
    return connect(
        f"ws://127.0.0.1:{port}/viewer/{TOKEN}",
        origin=Origin(studio.address),
        subprotocols=[Subprotocol(f"viser-v{viser.__version__}")],
        max_size=None,
    )


def until(page: Connection, channel: str, holds: Callable[[Any], bool] = lambda value: True) -> Any:
    """Reads the page's line until a channel has a value that holds, which is returned."""
    while True:
        letter = json.loads(page.recv(timeout=60))
        if letter["on"] == channel and holds(letter["is"]):
            return letter["is"]


def settle(studio: Studio) -> None:
    """Until everything sent so far has been handled."""
    done = threading.Event()
    studio.later(done.set)
    done.wait(60)
    time.sleep(0.5)


@contextmanager
def running(access: Access | None = None, objects: int = 3) -> Iterator[Studio]:
    """A studio with a program of that many things, and a session of its own."""
    with tempfile.TemporaryDirectory() as folder:
        workbench = Workbench(Store(Path(folder)), evidence=False)
        workbench.post(commands.OpenProgram(drifting(objects), "bench"))
        workbench.wait(120)
        studio = serve(workbench, access, port=0)
        try:
            yield studio
        finally:
            studio.stop()
            workbench.close()


class Wire:
    """Listens to a connection and notes what came."""

    def __init__(self, line: Connection) -> None:
        self.count = 0
        self.came = threading.Condition()
        self._kept: list[bytes | str] = []
        self._line = line
        threading.Thread(target=self._listen, daemon=True).start()

    def _listen(self) -> None:
        with contextlib.suppress(ConnectionClosed):
            for message in self._line:
                with self.came:
                    self.count += 1
                    self._kept = [*self._kept[-63:], message]
                    self.came.notify_all()

    def after(self, act: Callable[[], None], patience: float = 1.0) -> float:
        """Seconds from the act to the next message."""
        with self.came:
            seen = self.count
            started = time.perf_counter()
            act()
            self.came.wait_for(lambda: self.count > seen, patience)
            return time.perf_counter() - started

    def after_naming(self, act: Callable[[], None], name: bytes, patience: float = 10.0) -> float:
        """Seconds from the act to the next message of viser that names a node."""
        with self.came:
            seen = self.count
            started = time.perf_counter()
            act()
            while time.perf_counter() - started < patience:
                self.came.wait_for(lambda seen=seen: self.count > seen, patience)
                arrived = time.perf_counter() - started
                fresh, seen = self._kept[seen - self.count :], self.count
                if any(name in plain(message) for message in fresh):
                    return arrived
        return patience


def plain(message: bytes | str) -> bytes:
    """What viser sent, unpacked as far as names of nodes can be read in it."""
    if isinstance(message, str) or len(message) < HEAD:
        return b""
    length = int.from_bytes(message[8:HEAD], "little")
    return zstandard.ZstdDecompressor().decompress(message[HEAD : HEAD + length])
