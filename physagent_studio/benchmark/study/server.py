"""The page of a study on loopback: it asks one trial after the other and keeps every answer.

A rater's page never learns which method made a clip: clips are asked for by trial and side.
"""

from __future__ import annotations

import json
import re
import threading
from collections.abc import Mapping
from http import HTTPStatus
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from pathlib import Path
from typing import Any
from urllib.parse import parse_qs, urlsplit

from pydantic import BaseModel, ConfigDict, Field, ValidationError

from physagent_studio.benchmark.study.answers import Answer, keep, read_answers
from physagent_studio.benchmark.study.trials import BLANK, MEDIA, Study

QUESTION = "In which clip does what the sentence says happen more as it would in the real world?"
LOOPBACK = "127.0.0.1"
_PAGES = {
    "/": ("page.html", "text/html; charset=utf-8"),
    "/page.css": ("page.css", "text/css; charset=utf-8"),
    "/page.js": ("page.js", "text/javascript; charset=utf-8"),
}
_POLICY = "default-src 'self'; base-uri 'none'; form-action 'none'; frame-ancestors 'none'"
LONGEST_BODY = 10_000
"""Bytes of a request's body; an answer has less than a hundredth of them."""
_RATER = r"^[A-Za-z0-9_.-]{1,40}$"


class Given(BaseModel):
    """What the page sends for an answer."""

    model_config = ConfigDict(extra="forbid")

    rater: str = Field(pattern=_RATER)
    trial: int = Field(ge=0)
    choice: str = Field(pattern="^(left|right)$")
    seconds: float = Field(ge=0, le=1e6)


class StudyServer(ThreadingHTTPServer):
    """Serves a study on a free or given port of loopback; `serve_forever` until `shutdown`."""

    daemon_threads = True

    def __init__(self, study: Study, port: int = 0, question: str = QUESTION) -> None:
        super().__init__((LOOPBACK, port), _Handler)
        self.study, self.question = study, question
        self.kept = {(a.rater, a.trial): a for a in read_answers(study.folder)}
        self.lock = threading.Lock()

    @property
    def address(self) -> str:
        """Where the page is."""
        return f"http://{LOOPBACK}:{self.server_address[1]}/"

    def asked(self, rater: str) -> dict[str, Any]:
        """The first trial that a rater has not answered, or that there is none."""
        trials = self.study.trials(rater)
        with self.lock:
            done = [k for k in range(len(trials)) if (rater, k) in self.kept]
        open_ = next((k for k in range(len(trials)) if k not in set(done)), None)
        told: dict[str, Any] = {"done": len(done), "of": len(trials), "question": self.question}
        if open_ is None:
            return told | {"trial": None}
        trial = trials[open_]
        sides = {side: self._kind(trial.clip, trial.method(side)) for side in ("left", "right")}
        return told | {
            "trial": open_,
            "sentence": self.study.sentences.get(trial.clip, ""),
            **sides,
        }

    def _kind(self, clip: str, method: str) -> str:
        """What is shown on a side: `video`, `image` or `blank`."""
        return "blank" if method == BLANK else media_of(self.study.files[method][clip])[:5]

    def answer(self, given: Given) -> bool:
        """Keeps an answer once; whether there is such a trial."""
        trials = self.study.trials(given.rater)
        if given.trial >= len(trials):
            return False
        trial, key = trials[given.trial], (given.rater, given.trial)
        with self.lock:
            if key not in self.kept:
                where = (trial.clip, trial.left, trial.right)
                made = Answer(*key, *where, given.choice, round(given.seconds, 2))
                keep(self.study.folder, made)
                self.kept[key] = made
        return True

    def clip(self, rater: str, number: int, side: str) -> Path | None:
        """The file on a side of a rater's trial; None where there is none."""
        trials = self.study.trials(rater)
        if number >= len(trials) or (method := trials[number].method(side)) == BLANK:
            return None
        return self.study.files[method][trials[number].clip]


def media_of(path: Path) -> str:
    """The media type of a clip's file."""
    return MEDIA[path.suffix.lower()]


class _Handler(BaseHTTPRequestHandler):
    protocol_version = "HTTP/1.1"

    @property
    def host(self) -> StudyServer:
        """What it answers for."""
        assert isinstance(self.server, StudyServer)
        return self.server

    def do_GET(self) -> None:
        """Pages, the next trial, and clips."""
        if not self._is_ours():
            return
        parts = urlsplit(self.path)
        rater = parse_qs(parts.query).get("rater", [""])[0]
        if parts.path in _PAGES:
            name, kind = _PAGES[parts.path]
            self._send(Path(__file__).with_name(name).read_bytes(), kind)
        elif not re.match(_RATER, rater):
            self._say(HTTPStatus.NOT_FOUND, "there is no such page")
        elif parts.path == "/next":
            self._send(json.dumps(self.host.asked(rater)).encode(), "application/json")
        elif found := re.match(r"^/clip/(\d{1,6})/(left|right)$", parts.path):
            path = self.host.clip(rater, int(found[1]), found[2])
            if path is None:
                self._say(HTTPStatus.NOT_FOUND, "there is no such clip")
            else:
                self._send_part(path.read_bytes(), media_of(path))
        else:
            self._say(HTTPStatus.NOT_FOUND, "there is no such page")

    def do_POST(self) -> None:
        """An answer; what comes back is the next trial."""
        length = self.headers.get("Content-Length", "")
        if not self._is_ours():
            return
        if not length.isdigit() or int(length) > LONGEST_BODY:
            self.close_connection = True
            self._say(HTTPStatus.REQUEST_ENTITY_TOO_LARGE, "an answer is shorter")
            return
        body = self.rfile.read(int(length))
        kind = self.headers.get("Content-Type", "")
        try:
            given = Given.model_validate_json(body)
        except ValidationError:
            given = None
        if self.path != "/answer" or kind != "application/json" or given is None:
            self._say(HTTPStatus.BAD_REQUEST, "this is no answer")
        elif not self.host.answer(given):
            self._say(HTTPStatus.BAD_REQUEST, "there is no such trial")
        else:
            self._send(json.dumps(self.host.asked(given.rater)).encode(), "application/json")

    def _is_ours(self) -> bool:
        """Whether a request comes from the page itself: no other site may read or answer."""
        port = self.host.server_address[1]
        hosts = (f"{LOOPBACK}:{port}", f"localhost:{port}")
        origin = self.headers.get("Origin")
        ours = self.headers.get("Host") in hosts
        ours = ours and (origin is None or urlsplit(origin).netloc in hosts)
        if not ours:
            self.close_connection = True
            self._say(HTTPStatus.FORBIDDEN, "this page answers to its own address alone")
        return ours

    def _say(self, status: HTTPStatus, text: str) -> None:
        self._send(text.encode(), "text/plain; charset=utf-8", status)

    def _send_part(self, body: bytes, kind: str) -> None:
        """A clip, or the bytes of it that a player asks for: without them it cannot go back."""
        asked = re.match(r"^bytes=(\d+)-(\d*)$", self.headers.get("Range", ""))
        if asked is None or int(asked[1]) >= len(body):
            self._send(body, kind)
            return
        first, last = int(asked[1]), min(int(asked[2] or len(body)), len(body) - 1)
        told = {"Content-Range": f"bytes {first}-{last}/{len(body)}"}
        self._send(body[first : last + 1], kind, HTTPStatus.PARTIAL_CONTENT, told)

    def _send(
        self,
        body: bytes,
        kind: str,
        status: HTTPStatus = HTTPStatus.OK,
        more: Mapping[str, str] | None = None,
    ) -> None:
        self.send_response(status)
        told = {
            "Content-Type": kind,
            "Content-Length": str(len(body)),
            "Content-Security-Policy": _POLICY,
            "X-Content-Type-Options": "nosniff",
            "Cache-Control": "no-store",
            "Accept-Ranges": "bytes",
            **(more or {}),
        }
        for name, value in told.items():
            self.send_header(name, value)
        self.end_headers()
        self.wfile.write(body)

    def log_message(self, format: str, *args: Any) -> None:
        """Nothing: the terminal is for the address and the figures."""
