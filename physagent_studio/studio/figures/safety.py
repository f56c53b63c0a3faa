"""What strangers can do to a studio: `physagent bench safety` prints one row for every attack."""

import contextlib
import http.client
import json
import random
import socket
import statistics
import struct
import time
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

import msgspec
from websockets.exceptions import ConnectionClosed, InvalidHandshake
from websockets.sync.client import connect
from websockets.sync.connection import Connection
from websockets.typing import Origin

from physagent_studio.errors import StudioError
from physagent_studio.studio.access import Access
from physagent_studio.studio.commands import read_letter
from physagent_studio.studio.figures.measure import soaked
from physagent_studio.studio.figures.wire import (
    TOKEN,
    Figure,
    Wire,
    drifting,
    memory,
    open_page,
    open_viewer,
    p95,
    running,
    settle,
)
from physagent_studio.studio.studio import Studio
from physagent_studio.workbench import commands

EDIT = {"op": "set", "path": "event.actions.go_ball_0.start_step", "value": 3}
LETTERS: tuple[dict[str, Any], ...] = (
    {"do": "edit", "edits": [EDIT], "reason": "bench", "ticket": 1},
    {"do": "pin", "path": "clip.frames", "on": True},
    {"do": "budget", "rounds": 12},
    {"do": "policy", "policy": "ask"},
    {"do": "rename", "title": "bench"},
    {"do": "undo", "forward": False},
    {"do": "scrub", "frame": 12},
    {"do": "select", "kind": "object", "name": "ball_0"},
    {"do": "show", "what": "labels", "on": False},
    {"do": "round", "id": None},
    {"do": "look", "view": "top"},
    {"do": "play", "on": True},
    {"do": "speed", "factor": 2.0},
    {"do": "loop", "on": True, "start": 3, "end": 9},
    {"do": "try", "edits": [EDIT]},
    {"do": "retime", "factor": 2.0, "ticket": 2},
    {"do": "text", "text": "scene: {}", "apply": True},
    {"do": "discard"},
    {"do": "names", "prompt": "The ball rolls.", "ticket": 3},
    {"do": "new", "photo": "bm90IGEgcGhvdG8=", "prompt": "The ball rolls.", "objects": []},
    {"do": "delete_session", "id": "../.."},
)
"""Real messages of a page, from which hostile ones are made."""
AT_ONCE = 500
"""Messages that are sent without a pause: whoever floods is not read, and dropped in the end."""
TURNS = 3
"""How often somebody scrubs alone, and then beside a crowd."""
UNFELT_MS = 5.0
"""Milliseconds below which nobody feels that a scrub takes longer than another."""
VIEWERS: tuple[dict[str, Any], ...] = (
    {"type": "TransformControlsUpdateMessage", "name": "/objects/ball_0",
     "wxyz": [1.0, 0.0, 0.0, 0.0], "position": [1.0, 2.0, 3.0], "owner": ""},
    {"type": "GuiUpdateMessage", "uuid": "x", "updates": {"value": float("nan")}},
    {"type": "SceneNodeUpdateMessage", "name": "/objects/ball_0", "updates": {"visible": False}},
    {"type": "ShareUrlRequest"},
    {"type": "FileTransferStartUpload", "source_component_uuid": "x", "transfer_uuid": "y",
     "filename": "z", "mime_type": "a", "part_count": 9, "size_bytes": 2**40},
)  # fmt: skip
"""What a 3D view could send to set something."""
STRANGE = (
    None,
    float("inf"),
    10**30,
    -1,
    "",
    "x" * 5000,
    [],
    {},
    [[[]]],
    True,
    "__class__",
    "\u0000",
)


def measure_safety(*, messages: int = 4000, soak: float = 60.0, full: bool = False) -> list[Figure]:
    """All rows; messages: hostile ones. soak: seconds of scrubbing at 30 Hz."""
    messages, soak = (100_000, 3600.0) if full else (messages, soak)
    return [*_messages(messages), *_logins(), *_crowd(), *soaked(soak)]


# --- raw messages ------------------------------------------------------------------------------


def _mutated(rng: random.Random) -> str:
    """A real message with something in it broken; now and then it stays whole."""
    letter: Any = json.loads(json.dumps(rng.choice(LETTERS)))
    for _ in range(rng.randrange(3)):
        edits = letter.get("edits")
        first = edits[0] if isinstance(edits, list) and edits else None
        inner = first if isinstance(first, dict) and rng.random() < 0.5 else letter
        key = rng.choice([*inner, "seen", "__dict__"])
        inner[key] = rng.choice((*STRANGE, rng.randrange(100)))
    text = json.dumps(letter)
    if rng.random() < 0.2:
        at = rng.randrange(len(text))
        text = text[:at] + rng.choice(("", "\\", "}", "[[", "\ud800", "NaN")) + text[at + 1 :]
    return text.encode("utf-8", "replace").decode()


def _messages(count: int) -> list[Figure]:
    """Hostile messages to one studio, and of these the valid ones alone to a second one."""
    rng = random.Random(0)
    texts = [_mutated(rng) for _ in range(count)]
    with running() as studio, running() as twin:
        settle(studio)
        before, alive = memory(), 0
        with open_page(studio) as page, open_viewer(studio) as view:
            Wire(page)
            Wire(view)
            for number, text in enumerate(texts):
                page.send(text)
                if number % AT_ONCE == AT_ONCE - 1:
                    studio.workbench.wait(600)
                if number % 4 == 0:
                    with contextlib.suppress(ConnectionClosed):
                        view.send(_broken(rng))
            settle(studio)
            studio.workbench.wait(600)
        with open_page(twin) as page:
            Wire(page)
            for number, text in enumerate(filter(_valid, texts)):
                page.send(text)
                if number % AT_ONCE == AT_ONCE - 1:
                    twin.workbench.wait(600)
            settle(twin)
            twin.workbench.wait(600)
        grown = memory() - before
        with open_page(studio) as page:
            alive = int(bool(page.recv(timeout=10)))
        same = _kept(studio) == _kept(twin)
        moved = studio._server.scene._handle_from_node_name.get("/objects/ball_0")
        still = moved is None or tuple(moved.position) != (1.0, 2.0, 3.0)
    return [
        Figure(
            f"document after {count} hostile messages is that of the valid ones", same, "", 1, True
        ),
        Figure("server alive after them", alive, "", 1, True),
        Figure("nothing set through a 3D view", still, "", 1, True),
        Figure(f"memory grown over {count} hostile messages, two studios", grown, "MB", 200),
    ]


def _kept(studio: Studio) -> object:
    shown = studio.workbench.snapshot()
    return shown.program.hash, shown.state.model_dump(exclude={"rounds"}), shown.title


def _valid(text: str) -> bool:
    try:
        read_letter(text)
    except StudioError:
        return False
    return True


def _broken(rng: random.Random) -> bytes:
    message = dict(rng.choice(VIEWERS))
    if rng.random() < 0.7:
        message[rng.choice([*message])] = rng.choice((None, 1e308, float("nan"), "x" * 99, []))
    raw = msgspec.msgpack.encode(message)
    return raw if rng.random() < 0.9 else raw[: rng.randrange(len(raw))]


# --- who may come in ---------------------------------------------------------------------------


def _logins() -> list[Figure]:
    """The matrix of tokens, origins, hosts and roles; each row is 1 where it went as it has to."""
    public = "https://demo.example/studio"
    with running(access=Access.to("127.0.0.1", public)) as studio:
        port, tokens = studio._server.get_port(), studio.access.tokens
        own = {"Host": f"127.0.0.1:{port}"}

        def status(path: str, **headers: str) -> tuple[int, str]:
            line = http.client.HTTPConnection("127.0.0.1", port, timeout=10)
            line.request("GET", path, headers=own | headers)
            answer = line.getresponse()
            answer.read()
            return answer.status, answer.headers.get("Set-Cookie", "")

        editor = status(f"/?token={tokens['editor']}")[1]
        viewer = status(f"/?token={tokens['viewer']}")[1]
        cookie, watching = (one.partition(";")[0] for one in (editor, viewer))
        strict = all(
            one in editor for one in ("HttpOnly", "SameSite=Strict", "Secure", "Path=/studio")
        )
        evil = "http://evil.example"
        rows = {
            "no token is refused": status("/")[0] == 403,
            "a wrong token is refused": status("/?token=wrong")[0] == 403,
            "a wrong cookie is refused": status("/", Cookie=cookie[:-3] + "xxx")[0] == 403,
            "the token becomes a strict cookie": strict and status("/", Cookie=cookie)[0] == 200,
            "a foreign origin is refused": status("/", Cookie=cookie, Origin=evil)[0] == 403,
            "a foreign host is refused": status("/", Cookie=cookie, Host="evil.example")[0] == 403,
            "another server for the 3D view is refused": status(
                f"/viewer/{TOKEN}/?websocket=ws://evil", Cookie=cookie)[0] == 403,
            "the proxy's host and origin are let in": status(
                "/", Cookie=cookie, Host="demo.example", Origin="https://demo.example")[0] == 200,
            "a socket without a cookie is refused": not _opens(port, ""),
            "a socket of a foreign origin is refused": not _opens(port, cookie, evil),
            "an editor edits": _edits(studio, port, cookie),
            "a viewer does not": not _edits(studio, port, watching),
        }  # fmt: skip
    return [Figure(f"login: {name}", float(held), "", 1, above=True) for name, held in rows.items()]


def _socket(port: int, cookie: str, origin: str = "") -> Connection:
    return connect(
        f"ws://127.0.0.1:{port}/socket",
        origin=Origin(origin or f"http://127.0.0.1:{port}"),
        additional_headers={"Cookie": cookie} if cookie else None,
        max_size=None,
    )


def _opens(port: int, cookie: str, origin: str = "") -> bool:
    try:
        _socket(port, cookie, origin).close()
    except InvalidHandshake:
        return False
    return True


def _edits(studio: Studio, port: int, cookie: str) -> bool:
    before = studio.workbench.snapshot().version
    with _socket(port, cookie) as page:
        page.send(json.dumps({"do": "budget", "rounds": 10 + before}))
        settle(studio)
        studio.workbench.wait(30)
    return studio.workbench.snapshot().version > before


# --- crowds and long runs ----------------------------------------------------------------------


def _crowd() -> list[Figure]:
    """Unfinished uploads, a hundred connections that never read, and somebody at work beside.

    Alone and beside them in turns, since what else the machine does changes both.
    """
    alone, beside, shares, grown = list[float](), list[float](), list[float](), 0.0
    drift = commands.OpenProgram(drifting(20), "bench")
    with running(drift) as studio, open_page(studio) as page:
        wire, port = Wire(page), studio._server.get_port()
        settle(studio)
        _scrubs(page, wire)
        before = memory()
        for _ in range(TURNS):
            calm = _timed(page, wire, alone)
            with _hundred(port):
                shares.append(_timed(page, wire, beside) / calm)
                grown = max(grown, memory() - before)
            settle(studio)
    slower = p95(beside) / max(p95(alone), UNFELT_MS)
    return [
        Figure("memory grown under 100 connections and unfinished uploads", grown, "MB", 200),
        Figure("a scrub beside them, p95, times what it takes alone", slower, "×", 2),
        Figure("processor time of it, times that alone", statistics.median(shares), "×", 2),
    ]


@contextmanager
def _hundred(port: int) -> Iterator[None]:
    """A hundred connections of which each that is let in begins an upload, and reads nothing."""
    crowd = [one for _ in range(100) if (one := _raw(port)) is not None]
    frame = struct.pack(">BBQ4s", 0x81, 0xFF, 20 * 2**20, b"\0\0\0\0")
    for one in crowd[1:]:
        one.settimeout(0.2)
        with contextlib.suppress(OSError):
            one.sendall(frame + b" " * 2**20)
    try:
        yield
    finally:
        for one in crowd:
            one.close()


def _timed(page: Connection, wire: Wire, into: list[float]) -> float:
    """Adds what some scrubs take; returns the seconds of processor time of all of them."""
    busy = time.process_time()
    into += _scrubs(page, wire)
    return time.process_time() - busy


def _raw(port: int) -> socket.socket | None:
    """A socket after its handshake, from which nothing is ever read; None where it is refused."""
    line = socket.create_connection(("127.0.0.1", port), timeout=10)
    host = f"127.0.0.1:{port}"
    head = ("GET /socket HTTP/1.1", f"Host: {host}", f"Origin: http://{host}", "Upgrade: websocket",
            "Connection: Upgrade", "Sec-WebSocket-Version: 13",
            "Sec-WebSocket-Key: AAAAAAAAAAAAAAAAAAAAAA==", "", "")  # fmt: skip
    line.sendall("\r\n".join(head).encode())
    if b" 101 " in line.recv(64):
        return line
    line.close()
    return None


def _scrubs(page: Connection, wire: Wire, count: int = 60) -> list[float]:
    taken = []
    for frame in range(count):
        letter = json.dumps({"do": "scrub", "frame": 1 + frame % 80})
        taken.append(wire.after(lambda letter=letter: page.send(letter)))
        time.sleep(0.02)
    return taken
