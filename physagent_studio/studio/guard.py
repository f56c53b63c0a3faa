"""The one place that reaches into viser: its listener gets a guard, our pages and our socket.

viser 1.1.1 calls `websockets.asyncio.server.serve` from its own thread and keeps nothing of it to
hook into, so `listen` stands in for that function while the server starts. What comes in is then
checked before viser sees it, and one port serves our page, our socket and viser's client.
`tests/studio/test_guard.py` holds this against a change of viser.
"""

from __future__ import annotations

import asyncio
import contextlib
import http
import io
import logging
import os
import re
import socket
import threading
import urllib.parse
from collections.abc import Awaitable, Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import viser
import websockets.asyncio.server as listener
from numpy.typing import NDArray
from viser import _messages
from viser.infra import WebsockMessageHandler
from websockets import Headers
from websockets.asyncio.server import ServerConnection
from websockets.http11 import Request, Response

from physagent_studio.errors import InputError

LOOPBACK_NAMES = ("127.0.0.1", "localhost", "[::1]")
SOCKET_PATH = "/socket"
VIEWER_PATH = re.compile(r"/viewer/([0-9a-f]{8,64})/?")
"""Every page has a viewer of its own; the word in the path tells which one is whose."""
FIRST_PORT = 8080
MAX_MESSAGE = 24 * 2**20
"""Largest message that a browser may send, bytes: a photo of 16 MB in base64."""

# viser's client is one packed page that unpacks itself, so it needs inline and eval. Our own
# pages need neither. Nothing may connect anywhere but to the server that the page came from.
VIEWER_POLICY = (
    "default-src 'self' 'unsafe-inline' 'unsafe-eval' blob: data:; "
    "connect-src 'self' ws://{host} blob: data:; worker-src blob: data:; frame-ancestors 'self'"
)
PAGE_POLICY = (
    "default-src 'self'; style-src 'self' 'unsafe-inline'; img-src 'self' blob: data:; "
    "connect-src 'self' ws://{host}; object-src 'none'; base-uri 'none'; frame-ancestors 'self'"
)
# viser's own panel and toasts: the page around it has both.
VIEWER_STYLE = (
    b"<style>.mantine-Paper-root,.mantine-Notifications-root{display:none!important}"
    b"html,body{background:transparent}</style></head>"
)

VIEWER_SCRIPTS = ("/dressing.js", "/viewer.js")
"""What is put into viser's page, at the front of it: it has to run before viser does."""

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


@dataclass(frozen=True, slots=True)
class Page:
    """A file to serve: its type and its bytes."""

    mime: str
    body: bytes
    cache: bool = False
    download: str = ""


Pages = Callable[[str], Page | None]
"""Path, without the query → the page; None where there is none.

Called on viser's loop, for `SLOW_PATHS` on a thread of its pool.
"""

SLOW_PATHS = ("/frame/", "/face/", "/file/")
"""Below these lies what has to be made or read first."""

Talk = Callable[[ServerConnection], Awaitable[None]]
"""Speaks with one browser until it goes."""

_starting = threading.Lock()

# Browsers open connections in advance and drop them; each would be a traceback on the terminal.
_SILENT = logging.getLogger("physagent_studio.studio.listener")
_SILENT.setLevel(logging.CRITICAL + 1)


def open_server(port: int | None, pages: Pages, talk: Talk) -> viser.ViserServer:
    """A viser server on 127.0.0.1 behind the guard; port None takes the next free from 8080.

    Raises:
        InputError: the port that was asked for is busy, or not a port.
    """
    if port is not None:
        _must_be_free(port)
    with _starting, _guarded(pages, talk), _quiet(), _without("_VISER_PORT_OVERRIDE"):
        server = viser.ViserServer(
            host="127.0.0.1", port=FIRST_PORT if port is None else port, verbose=False
        )
    if port and server.get_port() != port:
        server.stop()
        raise InputError(f"port {port} is in use; choose another with --port, or none")
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
    match = VIEWER_PATH.fullmatch(_path_of(connection.request))
    return match.group(1) if match else ""


def put(
    handle: viser.SceneNodeHandle,
    position: NDArray[np.float64] | None,
    rotation: NDArray[np.float64] | None,
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


def _must_be_free(port: int) -> None:
    if not 0 <= port <= 65535:
        raise InputError(f"--port {port} is not a port; allowed: 0 … 65535")
    with socket.socket(socket.AF_INET, socket.SOCK_STREAM) as probe:
        probe.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        try:
            probe.bind(("127.0.0.1", port))
        except OSError as error:
            why = "is in use" if error.errno in (48, 98) else f"cannot be used ({error.strerror})"
            raise InputError(f"port {port} {why}; choose another with --port, or none") from error


@contextlib.contextmanager
def _guarded(pages: Pages, talk: Talk) -> Iterator[None]:
    """While this lasts, the listener that viser opens is ours."""
    real = listener.serve

    def serve(handler: Talk, host: str, port: int, **options: Any) -> Any:
        client = options.pop("process_request")

        async def route(connection: ServerConnection) -> None:
            assert connection.request is not None
            mine = _path_of(connection.request) == SOCKET_PATH
            await (talk if mine else handler)(connection)

        async def process(connection: ServerConnection, request: Request) -> Response | None:
            if _path_of(request).startswith(SLOW_PATHS):
                return await asyncio.to_thread(answer, connection, request, pages, client)
            return answer(connection, request, pages, client)

        options["max_size"] = MAX_MESSAGE
        options["logger"] = _SILENT
        return real(route, host, port, process_request=process, **options)

    listener.serve = serve  # type: ignore[assignment]
    try:
        yield
    finally:
        listener.serve = real


def answer(
    connection: ServerConnection,
    request: Request,
    pages: Pages,
    client: Callable[[ServerConnection, Request], Response | None],
) -> Response | None:
    """What an HTTP request gets; None lets a WebSocket handshake go on."""
    hosts = request.headers.get_all("Host")
    host = hosts[0] if len(hosts) == 1 else ""
    if not is_loopback(host):
        return _refuse("this server answers only to 127.0.0.1 and localhost")
    origins = request.headers.get_all("Origin")
    if origins and origins != [f"http://{host}"]:
        return _refuse("another site may not use this server")
    path = _path_of(request)
    if request.headers.get("Upgrade", "").lower() == "websocket":
        # viser looks at the exact spelling.
        known = path == SOCKET_PATH or VIEWER_PATH.fullmatch(path)
        return None if known else _refuse("there is no such socket")
    if VIEWER_PATH.fullmatch(path):
        plain = replace(request, path="/index.html", headers=Headers())
        return _viewer(client(connection, plain), [pages(one) for one in VIEWER_SCRIPTS], host)
    page = pages(path)
    if page is None:
        return _response(http.HTTPStatus.NOT_FOUND, Page("text/plain", b"Not found"), host)
    return _response(http.HTTPStatus.OK, page, host)


def is_loopback(host: str) -> bool:
    """Whether a Host header names this machine; any port, since a tunnel may change it."""
    name, _, port = host.rpartition(":") if not host.endswith("]") else (host, "", "")
    if not name:
        name, port = port, ""
    return name in LOOPBACK_NAMES and (port == "" or port.isdecimal())


def _path_of(request: Request) -> str:
    return urllib.parse.unquote(request.path.partition("?")[0])


def _refuse(why: str) -> Response:
    body = f"{why}\n".encode()
    headers = Headers({"Content-Type": "text/plain", "Content-Length": str(len(body))})
    return Response(http.HTTPStatus.FORBIDDEN.value, "Forbidden", headers, body)


def _response(status: http.HTTPStatus, page: Page, host: str) -> Response:
    headers = Headers(
        {
            "Content-Type": page.mime,
            "Content-Length": str(len(page.body)),
            "Cache-Control": "max-age=86400, immutable" if page.cache else "no-cache",
            "Content-Security-Policy": PAGE_POLICY.format(host=host),
            "X-Content-Type-Options": "nosniff",
            "Referrer-Policy": "no-referrer",
            "Connection": "close",
        }
    )
    if page.download:
        quoted = urllib.parse.quote(page.download)
        headers["Content-Disposition"] = f"attachment; filename*=UTF-8''{quoted}"
    return Response(status.value, status.phrase, headers, page.body)


def _viewer(response: Response | None, scripts: Sequence[Page | None], host: str) -> Response:
    """viser's client, our scripts before it, no panel, forbidden to speak with another server."""
    assert response is not None
    body = (response.body or b"").replace(b"</head>", VIEWER_STYLE, 1)
    ours = b"".join(b"<script>" + one.body + b"</script>" for one in scripts if one is not None)
    body = body.replace(b"<head>", b"<head>" + ours, 1)
    headers = Headers(
        {
            "Content-Type": "text/html; charset=utf-8",
            "Content-Length": str(len(body)),
            "Cache-Control": "no-cache",
            "Content-Security-Policy": VIEWER_POLICY.format(host=host),
            "X-Content-Type-Options": "nosniff",
            "Connection": "close",
        }
    )
    return Response(http.HTTPStatus.OK.value, "OK", headers, body)
