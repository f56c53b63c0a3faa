"""Generators behind the Protocol: our own composite, and a server that speaks ComfyUI's HTTP."""

from __future__ import annotations

import json
import threading
from collections.abc import Iterator
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from pathlib import Path

import av
import pytest

from physagent_studio.errors import BackendMissing, Cancelled, InputError
from physagent_studio.exchange import Prior, export_motion_prior
from physagent_studio.exchange.generators import ComfyUI, Composite, VideoGenerator
from physagent_studio.exchange.generators.comfyui import filled
from tests.exchange.prior.conftest import FRAMES, Parts

WORKFLOW = {
    "1": {"class_type": "LoadVideo", "inputs": {"file": "{physagent:control_video}"}},
    "2": {"class_type": "LoadImage", "inputs": {"image": "{physagent:start_image}"}},
    "3": {
        "class_type": "Text",
        "inputs": {"text": "{physagent:prompt}", "seed": "{physagent:seed}"},
    },
    "4": {"class_type": "Save", "inputs": {"video": ["1", 0], "length": "{physagent:length}"}},
}


@pytest.fixture
def prior(parts: Parts, tmp_path: Path) -> Prior:
    return Prior.open(export_motion_prior(tmp_path / "prior", *parts, 16))


class Server(ThreadingHTTPServer):
    """Keeps what it is sent; gives a finished prompt from the second time that it is asked."""

    def __init__(self, answer: str = "made") -> None:
        super().__init__(("127.0.0.1", 0), Handler)
        self.answer, self.uploads, self.prompts, self.asked, self.stopped = answer, {}, [], 0, 0
        threading.Thread(target=self.serve_forever, daemon=True).start()

    @property
    def address(self) -> str:
        return f"http://127.0.0.1:{self.server_port}"


class Handler(BaseHTTPRequestHandler):
    def log_message(self, format: str, *args: object) -> None:
        pass

    @property
    def ours(self) -> Server:
        assert isinstance(self.server, Server)
        return self.server

    def reply(self, data: bytes, code: int = 200) -> None:
        self.send_response(code)
        self.send_header("Content-Length", str(len(data)))
        self.end_headers()
        self.wfile.write(data)

    def do_POST(self) -> None:
        body = self.rfile.read(int(self.headers["Content-Length"]))
        if self.path == "/upload/image":
            head, _, rest = body.partition(b"\r\n\r\n")
            name = head.split(b'filename="')[1].split(b'"')[0].decode()
            self.ours.uploads[name] = rest.rpartition(b"\r\n--")[0]
            self.reply(json.dumps({"name": name, "subfolder": "in", "type": "input"}).encode())
        elif self.path == "/interrupt":
            self.ours.stopped += 1
            self.reply(b"")
        elif self.ours.answer == "refused":
            self.reply(b'{"error": "no such node"}', 400)
        else:
            self.ours.prompts.append(json.loads(body)["prompt"])
            self.reply(b'{"prompt_id": "p1", "number": 1, "node_errors": {}}')

    def do_GET(self) -> None:
        if self.path.startswith("/view"):
            assert "filename=a.mp4" in self.path
            self.reply(b"a video")
            return
        self.ours.asked += 1
        files = [{"filename": "a.mp4", "subfolder": "", "type": "output"}]
        if self.ours.answer == "pictures":
            files[0]["filename"] = "a.png"
        failed = {"status_str": "error", "messages": ["out of memory"]}
        entry = {"outputs": {"4": {"gifs": files}}, "status": {"status_str": "success"}}
        if self.ours.answer == "failed":
            entry["status"] = failed
        done = self.ours.asked > 1 and self.ours.answer != "never"
        self.reply(json.dumps({"p1": entry} if done else {}).encode())


@pytest.fixture
def server() -> Iterator[Server]:
    one = Server()
    yield one
    one.shutdown()


def test_the_composite_is_the_clip_in_the_size_that_is_asked_for(prior: Prior, tmp_path: Path):
    told: list[float] = []
    made: VideoGenerator = Composite((480, 832), "letterbox", 24)
    path = made.generate(
        prior, tmp_path / "a.mp4", cancelled=None, progress=lambda step, share: told.append(share)
    )
    with av.open(str(path)) as container:
        stream = container.streams.video[0]
        assert (stream.width, stream.height, stream.average_rate) == (480, 832, 24)
        assert sum(1 for _ in container.decode(video=0)) == FRAMES
    assert told[-1] == 1
    with pytest.raises(Cancelled):
        Composite().generate(prior, tmp_path / "b.mp4", cancelled=lambda: True)
    assert not (tmp_path / "b.mp4").exists()


def test_a_server_is_given_our_files_and_values(prior: Prior, server: Server, tmp_path: Path):
    made = ComfyUI(server.address, WORKFLOW, seed=7, pause=0.01)
    path = made.generate(prior, tmp_path / "a.mp4")
    assert path.read_bytes() == b"a video"
    control = (prior.folder / "wan-fun/control_depth.mp4").read_bytes()
    assert server.uploads["control_depth.mp4"] == control
    (sent,) = server.prompts
    assert sent["1"]["inputs"]["file"] == "in/control_depth.mp4"
    assert sent["2"]["inputs"]["image"] == "in/start_image.png"
    assert sent["3"]["inputs"] == {"text": prior.meta["prompt"], "seed": 7}
    assert sent["4"]["inputs"] == {"video": ["1", 0], "length": 81}


@pytest.mark.parametrize(
    ("answer", "told"),
    [("refused", "no such node"), ("failed", "out of memory"), ("pictures", "no video")],
)
def test_what_goes_wrong_there_is_said(prior: Prior, tmp_path: Path, answer: str, told: str):
    server = Server(answer)
    with pytest.raises(InputError, match=told):
        ComfyUI(server.address, WORKFLOW, pause=0.01).generate(prior, tmp_path / "a.mp4")
    server.shutdown()
    assert not (tmp_path / "a.mp4").exists()


def test_it_is_interrupted_or_given_up(prior: Prior, tmp_path: Path):
    server = Server("never")
    with pytest.raises(Cancelled):
        ComfyUI(server.address, WORKFLOW, pause=0.01).generate(
            prior, tmp_path / "a.mp4", cancelled=lambda: server.asked > 2
        )
    assert server.stopped == 1
    with pytest.raises(InputError, match="within"):
        ComfyUI(server.address, WORKFLOW, patience=0.05, pause=0.01).generate(
            prior, tmp_path / "a.mp4"
        )
    server.shutdown()
    server.server_close()
    with pytest.raises(BackendMissing, match="no ComfyUI answers"):
        ComfyUI(server.address, WORKFLOW).generate(prior, tmp_path / "a.mp4")


def test_workflows_that_cannot_be_filled_are_refused():
    with pytest.raises(InputError, match="no place for the control video"):
        filled({"1": {"inputs": {"text": "{physagent:prompt}"}}}, {"prompt": "x"})
    with pytest.raises(InputError, match=r"asks for \{physagent:mood\}"):
        filled({"1": {"inputs": {"text": "{physagent:mood}"}}}, {"prompt": "x"})
