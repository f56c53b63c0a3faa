"""The server answers only this machine's own page, and viser still works the way it is wrapped."""

from __future__ import annotations

import http.client
import json
import socket
import threading
from collections.abc import Iterator

import numpy as np
import pytest
import viser
from viser import _messages
from websockets.asyncio.server import ServerConnection
from websockets.exceptions import InvalidStatus
from websockets.sync.client import connect
from websockets.typing import Origin, Subprotocol

from physagent_studio.errors import InputError
from physagent_studio.studio import guard
from physagent_studio.studio.door import VIEWER_SCRIPTS, Page
from physagent_studio.studio.guard import open_server, stop_server

TOKEN = "0123456789abcdef"
PROTOCOL = [Subprotocol(f"viser-v{viser.__version__}")]


async def _echo(connection: ServerConnection, _role: object) -> None:
    async for message in connection:
        await connection.send(message)


def _pages(path: str) -> Page | None:
    known = {
        "/": Page("text/html", b"<p>ours</p>"),
        VIEWER_SCRIPTS[-1]: Page("text/javascript", b"window.ours = 1;"),
    }
    return known.get(path)


@pytest.fixture(scope="module")
def server() -> Iterator[viser.ViserServer]:
    running = open_server(0, _pages, _echo)
    yield running
    stop_server(running)


def _get(
    server: viser.ViserServer, path: str, headers: dict[str, str] | None = None
) -> http.client.HTTPResponse:
    line = http.client.HTTPConnection("127.0.0.1", server.get_port(), timeout=10)
    line.request("GET", path, headers=headers or {})
    return line.getresponse()


def test_our_page_comes_with_a_strict_policy(server: viser.ViserServer) -> None:
    answer = _get(server, "/")
    assert (answer.status, answer.read()) == (200, b"<p>ours</p>")
    policy = answer.headers["Content-Security-Policy"]
    assert "default-src 'self'" in policy
    assert "unsafe-eval" not in policy
    assert f"connect-src 'self' ws://127.0.0.1:{server.get_port()}" in policy


def test_viewer_may_connect_nowhere_else_and_hides_its_panel(server: viser.ViserServer) -> None:
    assert _get(server, f"/viewer/{TOKEN}/?websocket=ws://evil.example:1").status == 403
    answer = _get(server, f"/viewer/{TOKEN}/?darkMode")
    policy = answer.headers["Content-Security-Policy"]
    connect_part = next(part for part in policy.split(";") if "connect-src" in part)
    assert connect_part.split()[1:] == [
        "'self'",
        f"ws://127.0.0.1:{server.get_port()}",
        "blob:",
        "data:",
    ]
    body = answer.read()
    assert b".mantine-Paper-root" in body
    # Ours has to run before anything of viser's.
    assert body.index(b"<script>window.ours = 1;</script>") < body.index(b"<script data-p=")


@pytest.mark.parametrize(
    "host", ["evil.example", "127.0.0.1.evil.example", "evil.example:8080", ""]
)
@pytest.mark.parametrize("path", ["/", f"/viewer/{TOKEN}/"])
def test_other_host_names_are_refused(server: viser.ViserServer, host: str, path: str) -> None:
    assert _get(server, path, {"Host": host}).status == 403


@pytest.mark.parametrize("host", ["localhost:9000", "127.0.0.1", "[::1]:8080"])
def test_a_tunnel_may_change_the_port(server: viser.ViserServer, host: str) -> None:
    assert _get(server, "/", {"Host": host}).status == 200


@pytest.mark.parametrize("path", ["/socket", f"/viewer/{TOKEN}"])
@pytest.mark.parametrize("origin", ["http://evil.example", "https://127.0.0.1:1", "null"])
def test_other_sites_get_no_socket(server: viser.ViserServer, path: str, origin: str) -> None:
    address = f"ws://127.0.0.1:{server.get_port()}{path}"
    with (
        pytest.raises(InvalidStatus) as refused,
        connect(address, origin=Origin(origin), subprotocols=PROTOCOL),
    ):
        pass
    assert refused.value.response.status_code == 403


def test_sockets_go_where_they_belong(server: viser.ViserServer) -> None:
    port = server.get_port()
    origin = f"http://127.0.0.1:{port}"
    with connect(f"ws://127.0.0.1:{port}/socket", origin=Origin(origin)) as ours:
        ours.send(json.dumps({"hello": 1}))
        assert ours.recv(timeout=5) == '{"hello": 1}'
    with connect(
        f"ws://127.0.0.1:{port}/viewer/{TOKEN}",
        origin=Origin(origin),
        subprotocols=PROTOCOL,
    ) as visers:
        assert isinstance(visers.recv(timeout=5), bytes)
    with (
        pytest.raises(InvalidStatus),
        connect(f"ws://127.0.0.1:{port}/other", origin=Origin(origin)),
    ):
        pass


def test_paths_that_nobody_serves(server: viser.ViserServer) -> None:
    for path in ("/nothing", "/index.html", "/viewer/", "/viewer/../guard.py", "/%2e%2e/guard.py"):
        assert _get(server, path).status == 404, path


def test_a_picture_that_takes_long_is_waited_for(monkeypatch: pytest.MonkeyPatch) -> None:
    made = threading.Event()

    def slow(_path: str) -> Page:
        made.wait(5)
        return Page("image/jpeg", b"a picture")

    for seconds, dropped in ((0.5, True), (guard.ANSWERED_SECONDS, False)):
        monkeypatch.setattr(guard, "ANSWERED_SECONDS", seconds)
        running = open_server(0, slow, _echo)
        try:
            if dropped:
                with pytest.raises(http.client.RemoteDisconnected):
                    _get(running, "/frame/1.jpg")
                made.set()
            else:
                assert _get(running, "/frame/1.jpg").read() == b"a picture"
        finally:
            stop_server(running)


def test_a_connection_that_is_dropped_says_nothing_on_the_terminal(
    server: viser.ViserServer, caplog: pytest.LogCaptureFixture
) -> None:
    with socket.create_connection(("127.0.0.1", server.get_port())) as line:
        line.sendall(b"GET / HT")
    assert _get(server, "/").status == 200
    assert [one for one in caplog.records if "handshake" in one.getMessage()] == []


def test_share_and_widget_messages_are_closed(server: viser.ViserServer) -> None:
    open_to = server._websock_server._incoming_handlers
    assert not set(guard.CLOSED_MESSAGES) & set(open_to)
    assert _messages.ShareUrlRequest in guard.CLOSED_MESSAGES


def test_a_busy_port_is_one_sentence() -> None:
    with socket.socket() as taken:
        taken.bind(("127.0.0.1", 0))
        taken.listen()
        port = taken.getsockname()[1]
        with pytest.raises(InputError, match=f"port {port} is in use"):
            open_server(port, _pages, _echo)


@pytest.mark.parametrize("port", [-1, 70_000])
def test_a_port_that_is_none(port: int) -> None:
    with pytest.raises(InputError, match="is not a port"):
        open_server(port, _pages, _echo)


def test_the_listener_is_given_back() -> None:
    import websockets.asyncio.server as listener

    before = listener.serve
    stop_server(open_server(0, _pages, _echo))
    assert listener.serve is before


def test_a_pose_that_is_put_is_the_node_s_own(server: viser.ViserServer) -> None:
    """`put` goes round viser's setter, so it must leave the node as the setter would."""
    scene = server.scene
    one, other = scene.add_frame("/one"), scene.add_frame("/other")
    place, turn = np.array([1.0, 2.0, 3.0]), np.array([0.0, 1.0, 0.0, 0.0])
    guard.put(one, place, turn)
    other.position, other.wxyz = place, turn
    assert np.array_equal(one.position, other.position)
    assert np.array_equal(one.wxyz, other.wxyz)
    buffer = server._websock_server.get_message_buffer().message_from_id.values()
    sent = {(type(m).__name__, getattr(m, "name", "")) for m in buffer}
    for kind in ("SetPositionMessage", "SetOrientationMessage"):
        assert {(kind, "/one"), (kind, "/other")} <= sent
