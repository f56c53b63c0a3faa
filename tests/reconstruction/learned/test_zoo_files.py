"""Fetching files from a server on loopback: whole, resumed, slow, broken, wrong."""

import hashlib
import http.server
import json
import threading
from dataclasses import replace
from typing import ClassVar

import pytest
from typer.testing import CliRunner

from physagent_studio.cli.app import app
from physagent_studio.errors import InputError
from physagent_studio.reconstruction.backends import zoo_files
from physagent_studio.reconstruction.backends.zoo_files import fetch, remove, take
from physagent_studio.reconstruction.learned import zoo
from physagent_studio.reconstruction.learned.zoo import condition, part_of, path_of

DATA = bytes(range(256)) * 3000


class Server(http.server.BaseHTTPRequestHandler):
    """Gives DATA; `manners` say how badly."""

    manners: ClassVar[dict] = {}
    asked: ClassVar[list] = []

    def do_GET(self):
        manners, ranged = self.manners, self.headers.get("Range")
        self.asked.append(ranged)
        if "moved" in manners:
            self.send_response(302)
            self.send_header("Location", manners["moved"])
            self.end_headers()
            return
        if "status" in manners:
            self.send_error(manners["status"])
            return
        start = int(ranged[6:-1]) if ranged and manners.get("ranges", True) else 0
        data = manners.get("data", DATA)
        self.send_response(206 if start else 200)
        self.send_header("Content-Length", str(len(data) - start))
        if start:
            at = start + manners.get("shift", 0)
            self.send_header("Content-Range", f"bytes {at}-{len(data) - 1}/{len(data)}")
        self.end_headers()
        self.wfile.write(data[start : start + manners.get("breaks", len(data))])
        self.wfile.flush()
        if "silent" in manners:
            manners["silent"].wait(20)

    def log_message(self, format, *args):
        pass


@pytest.fixture
def server(monkeypatch):
    """The server's manners, with a model whose home it is as `lama`."""
    monkeypatch.setattr(Server, "manners", {})
    monkeypatch.setattr(Server, "asked", [])
    for name in ("http_proxy", "HTTP_PROXY", "all_proxy", "ALL_PROXY"):
        monkeypatch.delenv(name, raising=False)
    running = http.server.ThreadingHTTPServer(("127.0.0.1", 0), Server)
    running.daemon_threads = True
    thread = threading.Thread(target=running.serve_forever, kwargs={"poll_interval": 0.01})
    thread.start()
    url = f"http://127.0.0.1:{running.server_address[1]}/lama.onnx"
    known = replace(
        zoo.ZOO["lama"], size=len(DATA), sha256=hashlib.sha256(DATA).hexdigest(), url=url
    )
    monkeypatch.setitem(zoo.ZOO, "lama", known)
    yield Server
    running.shutdown()
    running.server_close()
    thread.join(10)


def test_a_file_is_fetched_once(server):
    told, model = [], zoo.ZOO["lama"]
    assert condition(model) == "absent"
    path = fetch(model, progress=lambda have, whole: told.append((have, whole)))
    assert path == path_of(model)
    assert path.read_bytes() == DATA
    assert told[-1] == (len(DATA), len(DATA))
    assert [have for have, _ in told] == sorted(have for have, _ in told)
    assert condition(model) == "ready"
    assert not part_of(path).exists()
    fetch(model)
    assert server.asked == [None]


def test_what_broke_off_goes_on_where_it_was(server):
    server.manners["breaks"] = 300_000
    assert fetch(zoo.ZOO["lama"]).read_bytes() == DATA
    assert server.asked == [None, "bytes=300000-", "bytes=600000-"]


@pytest.mark.parametrize("manners", [{"ranges": False}, {"shift": 5}])
def test_a_server_that_cannot_go_on_begins_anew(server, manners):
    """What says to begin elsewhere is not believed."""
    part = part_of(path_of(zoo.ZOO["lama"]))
    part.parent.mkdir(parents=True)
    part.write_bytes(DATA[:1000])
    assert condition(zoo.ZOO["lama"]) == "partial"
    server.manners.update(manners)
    assert fetch(zoo.ZOO["lama"]).read_bytes() == DATA
    assert server.asked == ["bytes=1000-", *([None] if "shift" in manners else [])]


def test_a_silent_server_is_given_up_and_what_came_is_kept(server, monkeypatch):
    monkeypatch.setattr(zoo_files, "FETCH", zoo_files.FetchSettings(silence_s=0.2, max_attempts=2))
    server.manners.update(breaks=0, silent=threading.Event())
    part = part_of(path_of(zoo.ZOO["lama"]))
    part.parent.mkdir(parents=True)
    part.write_bytes(DATA[:1000])
    with pytest.raises(InputError, match=r"silent for 0\.2 s.*goes on from there"):
        fetch(zoo.ZOO["lama"])
    server.manners["silent"].set()
    assert part.read_bytes() == DATA[:1000]
    assert len(server.asked) == 2


@pytest.mark.parametrize(
    ("manners", "why"),
    [
        ({"status": 404}, "says 404"),
        ({"status": 503}, "says 503"),
        ({"data": DATA[:-9] + b"elsewhat!"}, "SHA-256"),
        ({"data": DATA + b"more"}, "SHA-256"),
        ({"data": DATA[:-5]}, "could not be fetched"),
        ({"moved": "http://models.invalid/lama.onnx"}, "not encrypted"),
        ({"moved": "ftp://127.0.0.1/lama.onnx"}, "not encrypted"),
    ],
)
def test_what_is_not_the_file_never_takes_its_place(server, manners, why):
    server.manners.update(manners)
    with pytest.raises(InputError, match=why):
        fetch(zoo.ZOO["lama"])
    assert condition(zoo.ZOO["lama"]) in ("absent", "partial")


def test_without_a_network_the_sentence_names_a_way(server):
    nowhere = replace(zoo.ZOO["lama"], url="http://127.0.0.1:9/lama.onnx")
    with pytest.raises(InputError, match="--from FILE"):
        fetch(nowhere)
    with pytest.raises(InputError, match="not encrypted"):
        fetch(replace(nowhere, url="http://models.invalid/lama.onnx"))


def test_a_copy_from_elsewhere(server, tmp_path):
    model, source = zoo.ZOO["lama"], tmp_path / "copy.onnx"
    for data in (DATA[:-1], DATA[:-1] + b"!"):
        source.write_bytes(data)
        with pytest.raises(InputError, match=r"is not inpainting_lama_2025jan\.onnx"):
            take(model, source)
    with pytest.raises(InputError, match="cannot be copied"):
        take(model, tmp_path / "gone.onnx")
    assert condition(model) == "absent"
    source.write_bytes(DATA)
    assert take(model, source).read_bytes() == DATA
    assert not server.asked
    assert remove(model)
    assert not remove(model)


def test_the_zoo_is_asked_over_https_alone():
    for model in zoo.ZOO.values():
        assert model.url.startswith(f"{zoo.HOME}/")
        assert model.url.endswith(model.file)
        assert len(model.sha256) == 64
    assert zoo.HOME.startswith("https://")


def _said(*words):
    return CliRunner().invoke(app, ["models", *words])


def test_the_commands(server, tmp_path):
    listed = json.loads(_said("list", "--json").stdout)
    assert [one["condition"] for one in listed] == ["absent", "absent"]
    assert _said("verify").exit_code == 0
    assert _said("verify", "lama").exit_code == 3
    assert _said("path", "lama").stdout.strip().endswith("inpainting_lama_2025jan.onnx")
    assert _said("fetch", "lama").exit_code == 0
    assert "ready" in _said("verify", "lama").stdout
    path_of(zoo.ZOO["lama"]).write_bytes(b"something else")
    assert _said("verify").exit_code == 3
    assert "damaged" in _said("list").stdout
    assert "removed" in _said("remove", "lama").stdout
    for words, why in (
        (("fetch", "sam9"), "known: efficientsam"),
        (("fetch", "--from", "x"), "name"),
    ):
        refused = _said(*words)
        assert refused.exit_code == 2
        assert why in refused.output
