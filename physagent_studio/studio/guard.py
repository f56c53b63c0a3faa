"""The one place that reaches into viser: its listener gets a guard, our pages and our socket.

viser 1.1.1 calls `websockets.asyncio.server.serve` from its own thread and keeps nothing of it to
hook into, so `listen` stands in for that function while the server starts. What comes in is then
checked before viser sees it, and one port serves our page, our socket and viser's client.
`tests/studio/test_guard.py` holds this against a change of viser.
"""

import asyncio
import contextlib
import io
import logging
import math
import os
import socket
import threading
from collections.abc import Awaitable, Callable, Collection, Iterator
from dataclasses import MISSING, fields
from functools import lru_cache
from typing import Any, get_type_hints

import msgspec
import viser
import websockets.asyncio.server as listener
from viser import _messages
from viser.infra import WebsockMessageHandler
from websockets.asyncio.server import ServerConnection
from websockets.http11 import Request, Response

from physagent_studio.arrays import FloatArray
from physagent_studio.studio.access import Access, Role, listening
from physagent_studio.studio.door import (
    SLOW_PATHS,
    SOCKET_PATH,
    VIEWER_PATH,
    Arriving,
    Pages,
    answer,
    cookies_of,
    path_of,
)

ANSWERED_SECONDS = 60.0
"""How long a request may take from its first byte to its answer: websockets drops one after ten,
and the first pictures of a scene take longer where the machine is busy."""
MAX_MESSAGE = 24 * 2**20
"""Largest message that a browser may send, bytes: a photo of 16 MB in base64."""

# What a browser has no business to ask for, since our page has no widgets of viser.
CLOSED_MESSAGES = (
    _messages.ShareUrlRequest,
    _messages.ShareUrlDisconnect,
    _messages.GuiUpdateMessage,
    _messages.GuiButtonHoldMessage,
    _messages.GuiFormSubmitMessage,
    _messages.GuiFormDirtyMessage,
    _messages.FileTransferStartUpload,
    _messages.FileTransferPart,
    _messages.CommandTriggerMessage,
)


FROM_VIEWER = {"ViewerCameraMessage"}
"""What the 3D view of somebody who only watches may send."""
FROM_EDITOR = FROM_VIEWER | {
    "ScenePointerMessage", "SceneNodeClickMessage", "SceneNodeDragMessage",
    "TransformControlsUpdateMessage", "TransformControlsDragStartMessage",
    "TransformControlsDragEndMessage", "GetRenderResponseMessage",
}  # fmt: skip
"""What any 3D view may send: where its camera is, and what a hand does in the scene."""
MAX_VIEWER_MESSAGE = 64 * 2**10
"""Bytes of a message of a 3D view; the longest, of a drag, has some five hundred."""
FARTHEST = 1e6
"""Largest number in a message of a 3D view: metres or pixels."""

Talk = Callable[[ServerConnection, Role], Awaitable[None]]
"""Speaks with one browser, an editor's or a viewer's, until it goes."""

_starting = threading.Lock()

# Browsers open connections in advance and drop them; each would be a traceback on the terminal.
_SILENT = logging.getLogger("physagent_studio.studio.listener")
_SILENT.setLevel(logging.CRITICAL + 1)


def open_server(
    port: int | socket.socket | None, pages: Pages, talk: Talk, access: Access | None = None
) -> viser.ViserServer:
    """A viser server behind the guard, on 127.0.0.1 unless `access` says another address.

    port: a socket that listens already, or what `doorway.listening` takes.

    Raises:
        InputError: the port that was asked for is busy, or not a port; there is no such address.
    """
    access = access or Access()
    door = port if isinstance(port, socket.socket) else listening(access.host, port)
    number = int(door.getsockname()[1])
    with _starting, _guarded(pages, talk, access, door), _quiet(), _without("_VISER_PORT_OVERRIDE"):
        server = viser.ViserServer(host=access.host, port=number, verbose=False)
    _close(server._websock_server)
    return server


def close_client(client: viser.ClientHandle) -> None:
    """Takes viser's widget handlers from one browser's connection too."""
    _close(client._websock_connection)


def _close(interface: WebsockMessageHandler) -> None:
    for message in CLOSED_MESSAGES:
        if message in interface._incoming_handlers:
            interface.unregister_handler(message)


def token_of(server: viser.ViserServer, client: viser.ClientHandle) -> str:
    """The word in the path that a viewer's connection came over; "" when it has gone."""
    connection = server._websock_server._live_connections.get(client.client_id)
    if connection is None or connection.request is None:
        return ""
    match = VIEWER_PATH.fullmatch(path_of(connection.request))
    return match.group(1) if match else ""


def put(
    handle: viser.SceneNodeHandle,
    position: FloatArray | None,
    rotation: FloatArray | None,
) -> None:
    """Sets position, m, or rotation, wxyz, of a node that is known to have moved.

    viser compares every new pose with the old one, which costs more than sending it; who moves
    many nodes on every frame has compared them all at once.
    """
    inner = handle._impl
    if position is not None:
        x, y, z = position.tolist()
        inner.position[:] = position
        inner.api._queue_scene_message(_messages.SetPositionMessage(inner.name, (x, y, z)))
    if rotation is not None:
        w, x, y, z = rotation.tolist()
        inner.wxyz[:] = rotation
        inner.api._queue_scene_message(_messages.SetOrientationMessage(inner.name, (w, x, y, z)))


def stop_server(server: viser.ViserServer) -> None:
    """Stops it without viser's own line on the terminal."""
    with _quiet():
        server.stop()


@contextlib.contextmanager
def _without(variable: str) -> Iterator[None]:
    """viser lets this variable override the port that the person asked for."""
    kept = os.environ.pop(variable, None)
    try:
        yield
    finally:
        if kept is not None:
            os.environ[variable] = kept


@contextlib.contextmanager
def _quiet() -> Iterator[None]:
    """viser prints a banner whatever `verbose` says; the command line prints the address."""
    with contextlib.redirect_stdout(io.StringIO()):
        yield


@contextlib.contextmanager
def _guarded(pages: Pages, talk: Talk, access: Access, door: socket.socket) -> Iterator[None]:
    """While this lasts, the listener that viser opens is ours, on a socket that is open."""
    real = listener.serve
    arriving = Arriving()

    def serve(handler: Any, _host: str, _port: int, **options: Any) -> Any:
        client = options.pop("process_request")

        async def route(connection: ServerConnection) -> None:
            assert connection.request is not None
            role = access.role_of(cookies_of(connection.request)) or "viewer"
            with arriving.room_for(connection):
                if path_of(connection.request) == SOCKET_PATH:
                    await talk(connection, role)
                else:
                    await handler(_Sieve(connection, role))

        async def process(connection: ServerConnection, request: Request) -> Response | None:
            if path_of(request).startswith(SLOW_PATHS):
                return await asyncio.to_thread(
                    answer, connection, request, pages, client, access, arriving
                )
            return answer(connection, request, pages, client, access, arriving)

        options["open_timeout"] = ANSWERED_SECONDS
        options["max_size"] = MAX_MESSAGE
        options["max_queue"] = 2
        options["logger"] = _SILENT
        options["create_connection"] = arriving.connection
        return real(route, sock=door, process_request=process, **options)

    listener.serve = serve  # type: ignore[assignment]
    try:
        yield
    finally:
        listener.serve = real


class _Sieve:
    """A connection of a 3D view from which only what it may send is heard."""

    def __init__(self, connection: ServerConnection, role: Role) -> None:
        self._connection = connection
        self._allowed = FROM_EDITOR if role == "editor" else FROM_VIEWER

    def __getattr__(self, name: str) -> Any:
        return getattr(self._connection, name)

    async def recv(self) -> bytes:
        """The next message that is allowed."""
        while True:
            raw = await self._connection.recv()
            if isinstance(raw, bytes) and is_harmless(raw, self._allowed):
                return raw


def is_harmless(raw: bytes, allowed: Collection[str]) -> bool:
    """Whether a message of a 3D view is of an allowed kind and form, its numbers finite."""
    if len(raw) > MAX_VIEWER_MESSAGE:
        return False
    try:
        data = msgspec.msgpack.decode(raw)
        if not isinstance(data, dict) or data.get("type") not in allowed:
            return False
        kind = getattr(_messages, data["type"])
        # Whatever viser would stumble over, its types say first.
        hints = {name: hint for name, hint in get_type_hints(kind).items() if name in data}
        msgspec.convert({name: data[name] for name in hints}, _form_of(kind), strict=False)
    except (msgspec.MsgspecError, RecursionError, TypeError, ValueError):
        return False
    return _is_bounded(data) and {*data} - {"type"} <= {one.name for one in fields(kind)}


@lru_cache(maxsize=32)
def _form_of(kind: type) -> type:
    """The fields of one of viser's messages as a form that plain data can be held against."""
    hints = get_type_hints(kind)
    required = [
        (one.name, hints[one.name])
        if one.default is MISSING and one.default_factory is MISSING
        else (one.name, hints[one.name], None)
        for one in fields(kind)
        if one.init
    ]
    return msgspec.defstruct(kind.__name__, sorted(required, key=len), kw_only=True)


def _is_bounded(value: Any) -> bool:
    if isinstance(value, int | float):
        return math.isfinite(value) and abs(value) <= FARTHEST
    if isinstance(value, dict):
        return all(_is_bounded(one) for one in value.values())
    return all(_is_bounded(one) for one in value) if isinstance(value, list) else True
