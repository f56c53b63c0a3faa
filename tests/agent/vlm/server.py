"""A server on the loopback that speaks OpenAI's chat protocol for real, with a scripted model."""

from __future__ import annotations

import json
import threading
import time
from collections.abc import Callable
from dataclasses import dataclass, field
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from typing import Any


@dataclass(frozen=True)
class Asked:
    """A request as the server saw it. number: how many came before it."""

    number: int
    path: str
    headers: dict[str, str]
    body: dict[str, Any]

    @property
    def format(self) -> str:
        return self.body.get("response_format", {}).get("type", "text")

    @property
    def form(self) -> str:
        """Which reply is wanted, told from the schema or, without one, from the task."""
        wanted = self.body.get("response_format", {}).get("json_schema", {}).get("name")
        if wanted:
            return wanted
        system = self.text("system")
        for words, name in (
            ("say what the photograph shows", "SceneReply"),
            ("turn the sentence into a contract", "EventReply"),
            ("judge whether a reconstruction", "StageOneReply"),
            ("judge whether the event", "StageTwoReply"),
            ("failure of the reconstruction", "ScenePlan"),
        ):
            if words in system:
                return name
        return "EventPlan"

    @property
    def again(self) -> int:
        """How often the model was already asked to correct itself."""
        return sum(item["role"] == "assistant" for item in self.body["messages"])

    def text(self, role: str) -> str:
        return "\n".join(
            part if isinstance(part, str) else part.get("text", "")
            for item in self.body["messages"]
            if item["role"] == role
            for part in ([item["content"]] if isinstance(item["content"], str) else item["content"])
        )

    @property
    def pictures(self) -> list[str]:
        return [
            part["image_url"]["url"]
            for item in self.body["messages"]
            if not isinstance(item["content"], str)
            for part in item["content"]
            if part["type"] == "image_url"
        ]


@dataclass(frozen=True)
class Reply:
    """What the server sends. drip: seconds between single bytes. short: closes half way."""

    status: int = 200
    body: bytes = b""
    headers: dict[str, str] = field(default_factory=dict)
    wait: float = 0.0
    drip: float = 0.0
    short: bool = False
    slam: bool = False


Usage = tuple[int, int] | None


def completion(
    content: Any,
    *,
    usage: Any = (100, 20),
    finish: str = "stop",
    refusal: str | None = None,
    model: str = "scripted",
) -> bytes:
    """The body of a chat completion whose message is `content` (a string, or JSON of it)."""
    text = content if isinstance(content, str) else json.dumps(content)
    message: dict[str, Any] = {"role": "assistant", "content": text}
    if refusal is not None:
        message = {"role": "assistant", "content": None, "refusal": refusal}
    data: dict[str, Any] = {
        "id": "chatcmpl-1",
        "object": "chat.completion",
        "created": 0,
        "model": model,
        "choices": [{"index": 0, "message": message, "finish_reason": finish}],
    }
    if isinstance(usage, tuple):
        sent, came = usage
        data["usage"] = {
            "prompt_tokens": sent,
            "completion_tokens": came,
            "total_tokens": sent + came,
        }
    elif usage is not None:
        data["usage"] = usage
    return json.dumps(data).encode()


def says(content: Any, **options: Any) -> Reply:
    """A reply with a chat completion."""
    return Reply(body=completion(content, **options))


def failing(status: int, message: str = "something is wrong", **headers: str) -> Reply:
    """An error in OpenAI's form."""
    body = json.dumps({"error": {"message": message, "type": "error", "code": None}}).encode()
    return Reply(status, body, {name.replace("_", "-"): value for name, value in headers.items()})


Model = Callable[[Asked], Reply]


class ModelServer:
    """Runs a scripted model on a free port while the `with` block lasts."""

    def __init__(self, model: Model) -> None:
        self.model = model
        self.asked: list[Asked] = []
        self._stopping = threading.Event()
        outer = self

        class Handler(BaseHTTPRequestHandler):
            protocol_version = "HTTP/1.1"

            def do_POST(self) -> None:
                length = int(self.headers.get("content-length", 0))
                body = json.loads(self.rfile.read(length))
                headers = {name.lower(): value for name, value in self.headers.items()}
                asked = Asked(len(outer.asked), self.path, headers, body)
                outer.asked.append(asked)
                self._answer(outer.model(asked))

            def _answer(self, reply: Reply) -> None:
                self.close_connection = True
                if outer._stopping.wait(reply.wait) or reply.slam:
                    return
                try:
                    self.send_response(reply.status)
                    self.send_header("Content-Type", "application/json")
                    self.send_header("Connection", "close")
                    for name, value in reply.headers.items():
                        self.send_header(name, value)
                    self.send_header("Content-Length", str(len(reply.body)))
                    self.end_headers()
                    self._write(reply)
                except OSError:
                    pass  # the other side gave up, as it may

            def _write(self, reply: Reply) -> None:
                body = reply.body[: len(reply.body) // 2] if reply.short else reply.body
                if not reply.drip:
                    self.wfile.write(body)
                    return
                for index in range(len(body)):
                    self.wfile.write(body[index : index + 1])
                    self.wfile.flush()
                    if outer._stopping.wait(reply.drip):
                        return

            def log_message(self, format: str, *args: Any) -> None:
                pass

        self._server = ThreadingHTTPServer(("127.0.0.1", 0), Handler)
        self._server.daemon_threads = True
        self._thread = threading.Thread(
            target=self._server.serve_forever, kwargs={"poll_interval": 0.05}, daemon=True
        )

    @property
    def url(self) -> str:
        host, port = self._server.server_address[:2]
        return f"http://{host!s}:{port}/v1"

    def __enter__(self) -> ModelServer:
        self._thread.start()
        return self

    def __exit__(self, *error: object) -> None:
        self._stopping.set()
        self._server.shutdown()
        self._server.server_close()

    def wait_for(self, count: int, seconds: float = 5.0) -> None:
        """Returns as soon as that many requests have come."""
        end = time.monotonic() + seconds
        while len(self.asked) < count:
            assert time.monotonic() < end, f"only {len(self.asked)} requests came"
            time.sleep(0.01)
