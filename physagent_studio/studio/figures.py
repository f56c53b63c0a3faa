"""How fast the studio is: what `physagent bench studio` prints.

Nothing is drawn here: what is timed is the way from an intent to the wire, which is the server's
part, and the page's files. The browser's part is timed by `tests/browser`.
"""

from __future__ import annotations

import contextlib
import json
import resource
import statistics
import sys
import tempfile
import threading
import time
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import viser
from websockets.exceptions import ConnectionClosed
from websockets.sync.client import connect
from websockets.sync.connection import Connection
from websockets.typing import Origin, Subprotocol

from physagent_studio.program import EventProgram, PhysicalProgram, SceneObject, SceneState, Support
from physagent_studio.program import scene as shapes
from physagent_studio.program.actions import SetVelocity
from physagent_studio.session import Store
from physagent_studio.studio.studio import Studio, serve
from physagent_studio.workbench import Workbench, commands

OBJECTS = 50
TOKEN = "00000000000000000000beef"


@dataclass(frozen=True, slots=True)
class Figure:
    """A measured value with the bound that it has to keep: below it, or (`above`) not below."""

    name: str
    value: float
    unit: str
    bound: float
    above: bool = False

    @property
    def ok(self) -> bool:
        """Whether the bound is kept."""
        return self.value >= self.bound if self.above else self.value <= self.bound


def measure_studio(*, scrubs: int = 1000) -> list[Figure]:
    """Measures a studio on a scene of 50 objects."""
    with tempfile.TemporaryDirectory() as folder:
        workbench = Workbench(Store(Path(folder)), evidence=False)
        workbench.post(commands.OpenProgram(_many(OBJECTS), "bench"))
        workbench.wait(120)
        studio = serve(workbench, port=0)
        try:
            return _measure(studio, scrubs)
        finally:
            studio.stop()
            workbench.close()


def _measure(studio: Studio, scrubs: int) -> list[Figure]:
    opened = time.perf_counter()
    with _page(studio) as page, _viewer(studio) as viewer:
        _until(page, "timeline")
        usable = time.perf_counter() - opened
        _Wire(page)  # a page that is not read would be closed
        wire = _Wire(viewer)
        _settle(studio)
        delays = [_scrub(page, wire, frame % 81) for frame in range(1, 101)]
        before = _memory()
        for frame in range(scrubs):
            page.send(json.dumps({"do": "scrub", "frame": frame % 81}))
        _settle(studio)
        grown = _memory() - before
        rate, share = _play(page, wire)
    p95 = statistics.quantiles(delays, n=20)[-1] * 1000
    return [
        Figure(f"scrub to pose on the wire, {OBJECTS} objects, p95", p95, "ms", 10),
        Figure("page's values after opening", usable * 1000, "ms", 3000),
        Figure(f"playback frames a second, {OBJECTS} objects", rate, "1/s", 30, above=True),
        Figure(f"share of a core while playing, {OBJECTS} objects", share * 100, "%", 25),
        Figure(f"memory grown over {scrubs} scrubs", grown, "MB", 20),
    ]


class _Wire:
    """Listens to the viewer's connection and notes when something came."""

    def __init__(self, line: Connection) -> None:
        self.count = 0
        self.came = threading.Condition()
        self._line = line
        threading.Thread(target=self._listen, daemon=True).start()

    def _listen(self) -> None:
        with contextlib.suppress(ConnectionClosed):
            for _ in self._line:
                with self.came:
                    self.count += 1
                    self.came.notify_all()

    def after(self, act: Callable[[], None], patience: float = 1.0) -> float:
        """Seconds from the act to the next message."""
        with self.came:
            seen = self.count
            started = time.perf_counter()
            act()
            self.came.wait_for(lambda: self.count > seen, patience)
            return time.perf_counter() - started


def _scrub(page: Connection, wire: _Wire, frame: int) -> float:
    delay = wire.after(lambda: page.send(json.dumps({"do": "scrub", "frame": frame})))
    time.sleep(0.03)  # a hand moves on; the next one is measured by itself
    return delay


def _play(page: Connection, wire: _Wire, seconds: float = 4.0) -> tuple[float, float]:
    """Frames a second on the wire, and the share of one core, while playing."""
    page.send(json.dumps({"do": "play", "on": True}))
    time.sleep(0.3)
    count, used, started = wire.count, time.process_time(), time.perf_counter()
    time.sleep(seconds)
    passed = time.perf_counter() - started
    share = (time.process_time() - used) / passed
    rate = (wire.count - count) / passed
    page.send(json.dumps({"do": "play", "on": False}))
    return rate, share


def _settle(studio: Studio) -> None:
    """Until everything sent so far has been handled."""
    done = threading.Event()
    studio.later(done.set)
    done.wait(60)
    time.sleep(0.5)


def _page(studio: Studio) -> Connection:
    port = studio.address.rpartition(":")[2]
    line = connect(f"ws://127.0.0.1:{port}/socket", origin=Origin(studio.address), max_size=None)
    line.send(json.dumps({"do": "viewer", "token": TOKEN}))
    return line


def _viewer(studio: Studio) -> Connection:
    port = studio.address.rpartition(":")[2]
    return connect(
        f"ws://127.0.0.1:{port}/viewer/{TOKEN}",
        origin=Origin(studio.address),
        subprotocols=[Subprotocol(f"viser-v{viser.__version__}")],
        max_size=None,
    )


def _until(page: Connection, channel: str) -> None:
    while json.loads(page.recv(timeout=30))["on"] != channel:
        pass


def _memory() -> float:
    """Resident memory at its highest, MB."""
    peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    return peak / (2**20 if sys.platform == "darwin" else 2**10)


def _many(count: int) -> PhysicalProgram:
    """Balls that drift without weight, so that every one has another pose on every frame."""
    names = [f"ball_{n}" for n in range(count)]
    objects = tuple(
        SceneObject(
            name=name,
            shape=shapes.Sphere(radius=0.05),
            position=((n % 10) * 0.2 - 0.9, 1.5 + (n // 10) * 0.2, 1.0),
            support="air",
            material="rubber",
        )
        for n, name in enumerate(names)
    )
    drift = tuple(SetVelocity(id=f"go_{name}", name=name, velocity=(0.3, 0, 0)) for name in names)
    floor = Support(name="floor", shape=shapes.Floor(), material="wood")
    return PhysicalProgram(
        scene=SceneState(objects=objects, supports=(floor,), gravity=(0.0, 0.0, 0.0)),
        event=EventProgram(prompt="Balls drift to the right.", actions=drift),
    )
