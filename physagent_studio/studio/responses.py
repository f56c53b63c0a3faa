"""What goes out over HTTP: our pages under a strict policy, viser's client under a wider one."""

from __future__ import annotations

import http
import urllib.parse
from collections.abc import Sequence
from dataclasses import dataclass

from websockets import Headers
from websockets.http11 import Response

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
