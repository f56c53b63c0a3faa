"""The page of a study on loopback: it asks one trial after the other and keeps every answer.

A rater's page never learns which method made a clip: clips are asked for by trial and side.
"""

import json
import re
import threading
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from pathlib import Path
from typing import Any
from urllib.parse import parse_qs, urlsplit

from pydantic import BaseModel, ConfigDict, Field, ValidationError

from physagent_studio.benchmark.study.trials import BLANK, MEDIA, Answer, Study, keep, read_answers

QUESTION = "In which clip does what the sentence says happen more as it would in the real world?"
LOOPBACK = "127.0.0.1"
_PAGES = {"/": "page.html", "/page.css": "page.css", "/page.js": "page.js"}
_KINDS = {".html": "text/html", ".css": "text/css", ".js": "text/javascript"}
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
        self.kept = {(a.rater, a.trial) for a in read_answers(study.folder)}
        self.lock = threading.Lock()

    @property
    def address(self) -> str:
        """Where the page is."""
        return f"http://{LOOPBACK}:{self.server_address[1]}/"

    def asked(self, rater: str) -> dict[str, Any]:
        """The first trial that a rater has not answered; its number is None after the last."""
        trials = self.study.trials(rater)
        with self.lock:
            missing = [k for k in range(len(trials)) if (rater, k) not in self.kept]
        told: dict[str, Any] = {"done": len(trials) - len(missing), "of": len(trials)}
        if not missing:
            return told | {"trial": None}
        clip = trials[missing[0]].clip
        told |= {"trial": missing[0], "question": self.question}
        told["sentence"] = self.study.sentences.get(clip, "")
        for side in ("left", "right"):
            path = self.clip(rater, missing[0], side)
            told[side] = "blank" if path is None else MEDIA[path.suffix.lower()][:5]
        return told

    def answer(self, given: Given) -> bool:
        """Keeps an answer once; whether there is such a trial."""
        trials = self.study.trials(given.rater)
        if given.trial >= len(trials):
            return False
        trial, key = trials[given.trial], (given.rater, given.trial)
        with self.lock:
            if key not in self.kept:
                sides = (trial.clip, trial.left, trial.right)
                made = Answer(*key, *sides, given.choice, round(given.seconds, 2))
                keep(self.study.folder / "answers.csv", made)
                self.kept.add(key)
        return True

    def clip(self, rater: str, number: int, side: str) -> Path | None:
        """The file on a side of a rater's trial; None where there is none."""
        trials = self.study.trials(rater)
        if number >= len(trials) or (method := trials[number].method(side)) == BLANK:
            return None
        return self.study.files[method][trials[number].clip]


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
        known = re.match(_RATER, rater)
        wanted = re.match(r"^/clip/(\d{1,6})/(left|right)$", parts.path)
        path = self.host.clip(rater, int(wanted[1]), wanted[2]) if known and wanted else None
        if parts.path in _PAGES:
            page = Path(__file__).with_name(_PAGES[parts.path])
            self._send(page.read_bytes(), f"{_KINDS[page.suffix]}; charset=utf-8")
        elif known and parts.path == "/next":
            self._send(json.dumps(self.host.asked(rater)).encode(), "application/json")
        elif path is not None:
            self._send(path.read_bytes(), MEDIA[path.suffix.lower()])
        else:
            self._say(404, "there is no such page")

    def do_POST(self) -> None:
        """An answer; what comes back is the next trial."""
        length = self.headers.get("Content-Length", "")
        if not self._is_ours():
            return
        if not length.isdigit() or int(length) > LONGEST_BODY:
            self.close_connection = True
            self._say(413, "an answer is shorter")
            return
        try:
            given = Given.model_validate_json(self.rfile.read(int(length)))
        except ValidationError:
            given = None
        ours = self.path == "/answer" and self.headers.get("Content-Type") == "application/json"
        if given is None or not ours or not self.host.answer(given):
            self._say(400, "this is no answer to a trial")
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
            self._say(403, "this page answers to its own address alone")
        return ours

    def _say(self, status: int, text: str) -> None:
        self._send(text.encode(), "text/plain; charset=utf-8", status)

    def _send(self, body: bytes, kind: str, status: int = 200) -> None:
        """All of a body, or the bytes that a player asks for: without them it cannot go back."""
        asked = re.match(r"^bytes=(\d+)-(\d*)$", self.headers.get("Range", ""))
        told = {"Content-Type": kind, "Content-Security-Policy": _POLICY, "Accept-Ranges": "bytes"}
        told |= {"X-Content-Type-Options": "nosniff", "Cache-Control": "no-store"}
        if status == 200 and asked and int(asked[1]) < len(body):
            first, last = int(asked[1]), min(int(asked[2] or len(body)), len(body) - 1)
            told["Content-Range"] = f"bytes {first}-{last}/{len(body)}"
            status, body = 206, body[first : last + 1]
        self.send_response(status)
        for name, value in {**told, "Content-Length": str(len(body))}.items():
            self.send_header(name, value)
        self.end_headers()
        self.wfile.write(body)

    def log_message(self, format: str, *args: Any) -> None:
        """Nothing: the terminal is for the address and the figures."""
