"""What comes in before anybody speaks: hosts, origins, cookies, paths, and how much at once.

Knows nothing of viser; `guard` puts it in front of viser's listener.
"""

import contextlib
import http
import re
import time
import urllib.parse
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from typing import Any

from websockets import Headers
from websockets.asyncio.server import ServerConnection
from websockets.http11 import Request, Response

from physagent_studio.studio.access import Access

# viser's client is one packed page that unpacks itself, so it needs inline and eval. Our own
# pages need neither. Nothing may connect anywhere but to the server that the page came from.
VIEWER_POLICY = (
    "default-src 'self' 'unsafe-inline' 'unsafe-eval' blob: data:; "
    "connect-src 'self' {sockets} blob: data:; worker-src blob: data:; frame-ancestors 'self'"
)
PAGE_POLICY = (
    "default-src 'self'; style-src 'self' 'unsafe-inline'; img-src 'self' blob: data:; "
    "connect-src 'self' {sockets}; object-src 'none'; base-uri 'none'; frame-ancestors 'self'"
)
# viser's own panel and toasts: the page around it has both.
VIEWER_STYLE = (
    b"<style>.mantine-Paper-root,.mantine-Notifications-root{display:none!important}"
    b"html,body{background:transparent}</style></head>"
)
ENTER = (
    b'<!doctype html><meta charset="utf-8"><meta http-equiv="refresh" content="0;url=./">'
    b"<title>physagent</title>"
)
"""Goes on to the studio from a page of the studio itself: a cookie that is sent to nobody else's
pages is not sent along a redirect that another site has begun."""
PLAIN = "text/plain; charset=utf-8"


@dataclass(frozen=True, slots=True)
class Page:
    """A file to serve: its type and its bytes."""

    mime: str
    body: bytes
    cache: bool = False
    download: str = ""


def refusal(why: str, status: http.HTTPStatus = http.HTTPStatus.FORBIDDEN) -> Response:
    """Says no, and why."""
    body = f"{why}\n".encode()
    headers = _headers(PLAIN, body, "default-src 'none'")
    return Response(status.value, status.phrase, headers, body)


def page_response(page: Page | None, sockets: str, *, cookie: str = "") -> Response:
    """A page of ours, or that there is none."""
    status = http.HTTPStatus.NOT_FOUND if page is None else http.HTTPStatus.OK
    page = page or Page(PLAIN, b"Not found")
    headers = _headers(page.mime, page.body, PAGE_POLICY.format(sockets=sockets))
    if page.cache:
        headers["Cache-Control"] = "private, max-age=86400, immutable"
    else:
        headers["Cache-Control"] = "no-cache"
    if page.download:
        quoted = urllib.parse.quote(page.download)
        headers["Content-Disposition"] = f"attachment; filename*=UTF-8''{quoted}"
    if cookie:
        headers["Set-Cookie"] = cookie
    return Response(status.value, status.phrase, headers, page.body)


def viewer_response(body: bytes, scripts: Sequence[Page | None], sockets: str) -> Response:
    """viser's client, our scripts before it, no panel, forbidden to speak with another server."""
    body = body.replace(b"</head>", VIEWER_STYLE, 1)
    ours = b"".join(b"<script>" + one.body + b"</script>" for one in scripts if one is not None)
    body = body.replace(b"<head>", b"<head>" + ours, 1)
    headers = _headers("text/html; charset=utf-8", body, VIEWER_POLICY.format(sockets=sockets))
    headers["Cache-Control"] = "no-cache"
    return Response(http.HTTPStatus.OK.value, "OK", headers, body)


def _headers(mime: str, body: bytes, policy: str) -> Headers:
    return Headers(
        {
            "Content-Type": mime,
            "Content-Length": str(len(body)),
            "Content-Security-Policy": policy,
            "X-Content-Type-Options": "nosniff",
            "Referrer-Policy": "no-referrer",
            "Connection": "close",
        }
    )


SOCKET_PATH = "/socket"
VIEWER_PATH = re.compile(r"/viewer/([0-9a-f]{8,64})/?")
"""Every page has a viewer of its own; the word in the path tells which one is whose."""
VIEWER_SCRIPTS = ("/dressing.js", "/viewer.js")
"""What is put into viser's page, at the front of it: it has to run before viser does."""

MAX_CONNECTIONS = 32
"""Sockets that are open at once; a page has two, and everybody at work waits for all of them."""
MAX_UNFINISHED = 64 * 2**20
"""Bytes of messages that have begun and not ended, over all connections."""
UPLOAD_SECONDS = 60.0
"""How long a message may take to arrive."""

Pages = Callable[[str], Page | None]
"""Path, without the query → the page; None where there is none.

Called on viser's loop, for `SLOW_PATHS` on a thread of its pool.
"""

SLOW_PATHS = ("/frame/", "/face/", "/file/")
"""Below these lies what has to be made or read first."""


class Arriving:
    """What has come of messages that are not whole yet, and how many connections there are."""

    def __init__(self) -> None:
        self.open: dict[ServerConnection, float] = {}

    @contextlib.contextmanager
    def room_for(self, connection: ServerConnection) -> Iterator[None]:
        """Counts a connection as long as this lasts."""
        self.open[connection] = 0.0
        try:
            yield
        finally:
            del self.open[connection]

    def connection(self, *given: Any, **options: Any) -> ServerConnection:
        """A connection that is dropped where it sends a message too slowly or too much at once."""
        arriving = self

        class Bounded(ServerConnection):
            def data_received(self, data: bytes) -> None:
                super().data_received(data)
                arriving.look_at(self)

        return Bounded(*given, **options)

    def look_at(self, connection: ServerConnection) -> None:
        """Called on the loop after every piece of a message; drops what has stood about longest."""
        now = time.monotonic()
        if connection not in self.open:
            return
        if not _unfinished(connection):
            self.open[connection] = 0.0
            return
        self.open[connection] = self.open[connection] or now
        begun = {one: since for one, since in self.open.items() if since}
        oldest = min(begun, key=begun.__getitem__)
        full = sum(_unfinished(one) for one in begun) > MAX_UNFINISHED
        if full or now - begun[oldest] > UPLOAD_SECONDS:
            self.open[oldest] = 0.0
            oldest.transport.abort()


def _unfinished(connection: ServerConnection) -> int:
    """Bytes of a message that has begun: of its present frame, and of the frames before it."""
    frames = getattr(connection.recv_messages.frames, "queue", ())
    return len(connection.protocol.reader.buffer) + sum(len(one.data) for one in frames)


def answer(
    connection: ServerConnection,
    request: Request,
    pages: Pages,
    client: Callable[[ServerConnection, Request], Response | None],
    access: Access,
    arriving: Arriving,
) -> Response | None:
    """What an HTTP request gets; None lets a WebSocket handshake go on."""
    hosts = request.headers.get_all("Host")
    host = hosts[0] if len(hosts) == 1 else ""
    if not access.allows_host(host):
        return refusal("this server does not answer to that name, only to its own address")
    origins = request.headers.get_all("Origin")
    if origins and (len(origins) > 1 or not access.allows_origin(origins[0], host)):
        return refusal("another site may not use this server")
    path, query = path_of(request), urllib.parse.urlsplit(request.path).query
    token = urllib.parse.parse_qs(query).get("token", [""])[0]
    sockets = access.sockets(host)
    if token and path == "/" and (cookie := access.exchange(token)):
        return page_response(Page("text/html; charset=utf-8", ENTER), sockets, cookie=cookie)
    if access.role_of(cookies_of(request)) is None:
        return refusal("open the address that the terminal shows, with its token")
    if request.headers.get("Upgrade", "").lower() == "websocket":
        # viser looks at the exact spelling.
        if path != SOCKET_PATH and not VIEWER_PATH.fullmatch(path):
            return refusal("there is no such socket")
        if len(arriving.open) >= MAX_CONNECTIONS:
            return refusal("too many pages are open", http.HTTPStatus.SERVICE_UNAVAILABLE)
        return None
    if VIEWER_PATH.fullmatch(path):
        if "websocket" in urllib.parse.parse_qs(query, keep_blank_values=True):
            return refusal("this page speaks with no other server")
        plain = replace(request, path="/index.html", headers=Headers())
        response = client(connection, plain)
        assert response is not None
        return viewer_response(
            bytes(response.body or b""), [pages(p) for p in VIEWER_SCRIPTS], sockets
        )
    return page_response(pages(path), sockets)


def cookies_of(request: Request) -> str:
    """All cookies of a request, as one header."""
    return "; ".join(request.headers.get_all("Cookie"))


def path_of(request: Request) -> str:
    """The path that is asked for, without what stands behind it."""
    return urllib.parse.unquote(request.path.partition("?")[0])
