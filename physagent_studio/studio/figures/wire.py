"""What is measured with: values with bounds, many balls that drift, a session of many rounds, and a
page and a viewer as a browser has them, over the wire, without a browser."""

import contextlib
import json
import resource
import statistics
import sys
import tempfile
import threading
import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import viser
import zstandard
from websockets.exceptions import ConnectionClosed
from websockets.sync.client import connect
from websockets.sync.connection import Connection
from websockets.typing import Origin, Subprotocol

from physagent_studio.program import EventProgram, PhysicalProgram, SceneObject, SceneState, Support
from physagent_studio.program.actions import SetVelocity
from physagent_studio.program.scene import state as shapes
from physagent_studio.program.scene.aloft import AIR
from physagent_studio.records import LoopState
from physagent_studio.session import Store
from physagent_studio.studio.access import Access
from physagent_studio.studio.studio import Studio, serve
from physagent_studio.workbench import Workbench, commands


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


def p95(seconds: Sequence[float]) -> float:
    """The 95th percentile, ms."""
    return statistics.quantiles(seconds, n=20)[-1] * 1000


def memory() -> float:
    """Memory in use by this process, MB; its peak where the system tells nothing else."""
    status = Path("/proc/self/statm")
    if status.exists():
        return int(status.read_text().split()[1]) * resource.getpagesize() / 2**20
    peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    return peak / (2**20 if sys.platform == "darwin" else 2**10)


def drifting(count: int) -> PhysicalProgram:
    """Balls that drift without weight, so that every one has another pose on every frame."""
    names = [f"ball_{n}" for n in range(count)]
    objects = tuple(
        SceneObject(
            name=name,
            shape=shapes.Sphere(radius=0.05),
            position=((n % 10) * 0.2 - 0.9, 1.5 + (n // 10) * 0.2, 1.0),
            support=AIR,
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


def lengthen(store: Store, session_id: str, rounds: int) -> None:
    """Makes a session of one round into one of many: a chain of rounds with its programs."""
    session = store.open(session_id)
    state: LoopState = session.load()
    first = state.rounds[0]
    chain = [first]
    for number in range(2, rounds + 1):
        prompt = f"{first.program.event.prompt} ({number})"
        event = first.program.event.model_copy(update={"prompt": prompt})
        program = first.program.model_copy(update={"event": event})
        update = {
            "id": f"r{number}",
            "number": number,
            "parent": chain[-1].id,
            "program": program,
        }
        chain.append(first.model_copy(update=update))
    longer = state.model_copy(update={"rounds": tuple(chain), "head": chain[-1].id})
    session.save(longer, checkpoint="many rounds")
    session.close()


TOKEN = "00000000000000000000beef"
PATIENCE = 600.0
"""Seconds for a scene to be made, or run, on a machine that is not idle."""
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
def running(
    command: commands.Command | None = None, *, access: Access | None = None
) -> Iterator[Studio]:
    """A studio in which that was opened, else three things that drift; a workspace of its own."""
    with tempfile.TemporaryDirectory() as folder:
        workbench = Workbench(Store(Path(folder)), evidence=False)
        workbench.post(command or commands.OpenProgram(drifting(3), "bench"))
        workbench.wait(PATIENCE)
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
