"""A session as one HTML file that opens anywhere, without a network and without this package."""

import base64
import html
import json
import re
from collections.abc import Mapping
from dataclasses import asdict, dataclass, field
from importlib.resources import files
from typing import Any


@dataclass(frozen=True, slots=True)
class ReplayCheck:
    """A line of the checklist. frame: where it was decided, None without. group: "demand",
    "physics" or "view", what a viewer sees."""

    ok: bool
    clause: str
    text: str
    measured: str
    frame: int | None
    always: bool = False
    group: str = "demand"


@dataclass(frozen=True, slots=True)
class ReplayRound:
    """A round. verdict: "ok", "failed" or "open". video: MP4. recording: of viser, zstd.

    decided: what became of its proposal, in words. program: YAML. gentler: its proposal repairs
    nothing. pace: how fast its video shows the event, in words; timing: the same in figures.
    """

    number: int
    verdict: str
    program: str
    checks: tuple[ReplayCheck, ...] = ()
    diagnosis: tuple[str, ...] = ()
    proposal: str = ""
    changes: tuple[str, ...] = ()
    decided: str = ""
    video: bytes = b""
    recording: bytes = b""
    gentler: bool = False
    pace: str = ""
    timing: Mapping[str, float] = field(default_factory=dict)


@dataclass(frozen=True, slots=True)
class Replay:
    """All that the file shows. photo: JPEG, b"" without. fps: of the videos.

    viewer: a page that shows a recording, cut where the recording goes in as base64; None
    where there are no recordings. size: of the pictures, pixels.
    """

    title: str
    prompt: str
    outcome: str
    rounds: tuple[ReplayRound, ...]
    fps: float
    frames: int
    size: tuple[int, int] = (832, 480)
    photo: bytes = b""
    viewer: tuple[str, str] | None = None
    version: str = ""


def replay_html(replay: Replay) -> str:
    """The file's text. Everything that a person or a model wrote goes in as data, never as markup.

    A content-security policy in the file forbids every connection.
    """
    page = (files("physagent_studio.exchange") / "pages" / "replay.html").read_text("utf-8")
    data = {key: value for key, value in asdict(replay).items() if key != "viewer"}
    parts = {
        "TITLE": html.escape(replay.title),
        "DATA": _embedded(data),
        "VIEWER": _embedded(list(replay.viewer) if replay.viewer else None),
    }
    # In one pass, so that a mark in what somebody wrote stays what it is.
    return re.sub("@@(TITLE|DATA|VIEWER)@@", lambda mark: parts[mark[1]], page)


def _base64(data: bytes) -> str:
    return base64.b64encode(data).decode("ascii")


def _embedded(value: Any) -> str:
    """JSON that cannot end the script element around it."""
    text = json.dumps(
        value, ensure_ascii=False, separators=(",", ":"), allow_nan=False, default=_base64
    )
    return text.replace("<", "\\u003c").replace("\u2028", "\\u2028").replace("\u2029", "\\u2029")
