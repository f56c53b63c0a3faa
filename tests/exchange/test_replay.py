"""The replay file: data stays data, and nothing in it may connect anywhere."""

from __future__ import annotations

import json
import re

from physagent_studio.exchange import Replay, ReplayCheck, ReplayRound, replay_html

NASTY = "</script><script>alert(1)</script><!-- \u2028 & \"quotes\" 'too' @@DATA@@"


def _replay() -> Replay:
    check = ReplayCheck(ok=False, clause=NASTY, text=NASTY, measured="misses by 0.1 m", frame=3)
    one = ReplayRound(
        number=1, verdict="failed", program=NASTY, checks=(check,), diagnosis=(NASTY,),
        proposal=NASTY, changes=(NASTY,), decided=NASTY, video=b"\x00\x01", recording=b"\x02",
    )  # fmt: skip
    return Replay(
        title=NASTY, prompt=NASTY, outcome="", rounds=(one,), fps=24.0, frames=81,
        viewer=("<html>" + NASTY, NASTY + "</html>"),
    )  # fmt: skip


def _island(page: str, name: str) -> object:
    found = re.search(rf'<script type="application/json" id="{name}">(.*?)</script>', page, re.S)
    assert found is not None
    return json.loads(found[1])


def test_texts_come_back_as_they_were_and_end_nothing() -> None:
    page = replay_html(_replay())
    data = _island(page, "data")
    assert isinstance(data, dict)
    assert data["prompt"] == NASTY
    assert data["rounds"][0]["checks"][0]["text"] == NASTY
    assert data["rounds"][0]["video"] == "AAE="
    assert _island(page, "viewer") == ["<html>" + NASTY, NASTY + "</html>"]
    # Two islands and the page's own script, and no other.
    assert page.count("<script") == 3
    assert page.count("</script") == 3
    assert "<!--" not in page
    assert "alert(1)</script>" not in page.partition("<title>")[2].partition("</title>")[0]


def test_the_file_forbids_every_connection() -> None:
    page = replay_html(_replay())
    policy = re.search(r'Content-Security-Policy" content="([^"]*)"', page)
    assert policy is not None
    rules = dict(rule.strip().split(" ", 1) for rule in policy[1].split(";"))
    assert rules["default-src"] == "'none'"
    assert rules["connect-src"] == "data: blob:"
    assert not re.search(r"https?:|wss?:|\*", policy[1])
    own = page.partition('<script type="application/json"')[0]
    assert not re.search(r"https?://", own)


def test_a_session_without_scenes_or_videos() -> None:
    empty = Replay(title="x", prompt="", outcome="", rounds=(), fps=24.0, frames=81)
    assert _island(replay_html(empty), "viewer") is None
