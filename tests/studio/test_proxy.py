"""The studio below a prefix of a reverse proxy: page, login, sockets, pictures and downloads."""

from __future__ import annotations

import http.client
import json
import re
from collections.abc import Iterator
from contextlib import closing

import pytest
import viser
from websockets.exceptions import InvalidHandshake
from websockets.sync.client import connect
from websockets.sync.connection import Connection
from websockets.typing import Origin, Subprotocol

from physagent_studio.assets import assets_dir
from physagent_studio.session import Store
from physagent_studio.studio import Studio, serve
from physagent_studio.studio.access import Access
from physagent_studio.studio.figures.wire import TOKEN, settle, until
from physagent_studio.workbench import Workbench, commands
from tests.studio.proxy import Proxy

PREFIX = "/demo/studio"


class Visitor:
    """Somebody on the other side of the proxy, with the cookies of a browser."""

    def __init__(self, proxy: Proxy, studio: Studio) -> None:
        self.proxy, self.studio, self.cookie = proxy, studio, ""

    def get(self, path: str) -> tuple[int, http.client.HTTPMessage, bytes]:
        headers = {"Cookie": self.cookie} if self.cookie else {}
        with closing(http.client.HTTPConnection("127.0.0.1", self.proxy.port, timeout=60)) as line:
            line.request("GET", path, headers=headers)
            answer = line.getresponse()
            return answer.status, answer.headers, answer.read()

    def enter(self, role: str) -> str:
        """Comes in with the token of a role; what the cookie says besides its value."""
        port = self.studio._server.get_port()
        address = self.studio.access.link(port, "editor" if role == "editor" else "viewer")
        status, headers, _ = self.get(address.partition(str(self.proxy.port))[2])
        assert status == 200
        self.cookie, _, rest = (headers["Set-Cookie"] or "").partition(";")
        return rest

    def socket(self, path: str, *protocols: str, origin: str = "") -> Connection:
        base = f"127.0.0.1:{self.proxy.port}"
        return connect(
            f"ws://{base}{PREFIX}{path}",
            origin=Origin(origin or f"http://{base}"),
            subprotocols=[Subprotocol(one) for one in protocols] or None,
            additional_headers={"Cookie": self.cookie} if self.cookie else None,
            max_size=None,
        )


@pytest.fixture(scope="module")
def visitor(tmp_path_factory: pytest.TempPathFactory, shared_scenes: None) -> Iterator[Visitor]:
    workbench = Workbench(Store(tmp_path_factory.mktemp("proxied")), evidence=False)
    workbench.post(commands.OpenCase(assets_dir() / "demo", "only_the_cube"))
    # No repair is searched for.
    workbench.post(commands.TakeRole("planner"))
    workbench.post(commands.Step())
    assert workbench.wait(300)
    with Proxy(PREFIX) as proxy:
        access = Access.to("127.0.0.1", f"http://127.0.0.1:{proxy.port}{PREFIX}")
        studio = serve(workbench, access, port=0)
        proxy.behind = studio._server.get_port()
        yield Visitor(proxy, studio)
        studio.stop()
    workbench.close()


def test_only_the_token_lets_in(visitor: Visitor) -> None:
    stranger = Visitor(visitor.proxy, visitor.studio)
    assert stranger.get(f"{PREFIX}/")[0] == 403
    with pytest.raises(InvalidHandshake):
        stranger.socket("/socket")
    said = stranger.enter("editor")
    assert f"Path={PREFIX}" in said
    assert "HttpOnly" in said
    assert stranger.get(f"{PREFIX}/")[0] == 200
    with pytest.raises(InvalidHandshake):
        stranger.socket("/socket", origin="http://evil.example")


def test_everything_that_the_page_names_is_there(visitor: Visitor) -> None:
    visitor.enter("editor")
    _, _, page = visitor.get(f"{PREFIX}/")
    named = re.findall(r'(?:src|href)="([^"#:]+)"', page.decode())
    scripts = [one for one in named if one.endswith(".js")]
    for one in scripts:
        _, _, text = visitor.get(f"{PREFIX}/{one}")
        named += re.findall(r'from "\./([\w.]+)"', text.decode())
    assert len(set(named)) > 5
    assert {one: visitor.get(f"{PREFIX}/{one}")[0] for one in named} == dict.fromkeys(named, 200)


def test_a_page_edits_and_a_viewer_does_not(visitor: Visitor) -> None:
    workbench = visitor.studio.workbench
    for role, budget in (("viewer", 7), ("editor", 8)):
        visitor.enter(role)
        with visitor.socket("/socket") as page:
            page.send(json.dumps({"do": "budget", "rounds": budget}))
            settle(visitor.studio)
            assert workbench.wait(60)
        assert (workbench.snapshot().state.budget == budget) == (role == "editor")


def test_the_3d_view_opens(visitor: Visitor) -> None:
    visitor.enter("editor")
    status, _, page = visitor.get(f"{PREFIX}/viewer/{TOKEN}/")
    assert (status, b"viser" in page.lower()) == (200, True)
    with visitor.socket(f"/viewer/{TOKEN}", f"viser-v{viser.__version__}") as view:
        assert len(view.recv(timeout=30)) > 0


def test_a_video_is_downloaded(visitor: Visitor) -> None:
    visitor.enter("editor")
    with visitor.socket("/socket") as page:
        page.send(json.dumps({"do": "video"}))
        made = until(page, "run", lambda run: run["outputs"])["outputs"][0]
    status, headers, data = visitor.get(f"{PREFIX}/{made['url']}")
    assert (status, headers["Content-Type"]) == (200, "video/mp4")
    assert data[4:8] == b"ftyp"
