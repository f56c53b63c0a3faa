"""The replay opens from the disk, in a browser without a network, and plays."""

from __future__ import annotations

import re
import shutil
from pathlib import Path
from typing import Any

import pytest
from playwright.sync_api import Browser, expect

from physagent_studio.cli.clips import export_session
from physagent_studio.session import Store
from tests.browser.conftest import PATIENCE, Desk

pytestmark = [pytest.mark.browser, pytest.mark.usefixtures("shared_scenes")]


def test_a_replay_opens_offline_from_a_file(
    tmp_path: Path, browser: Browser, decided_once: Path
) -> None:
    root = tmp_path / "workspace"
    shutil.copytree(decided_once, root)
    name = Store(root).list()[0].id
    session = Store(root).open(name)
    head = session.load().rounds[0]
    session.close()
    path = tmp_path / "replay.html"
    export_session(name, None, path, root)

    context = browser.new_context(offline=True, viewport={"width": 1000, "height": 700})
    page = context.new_page()
    asked: list[str] = []
    problems: list[str] = []
    page.on("request", lambda request: asked.append(request.url))
    page.on("pageerror", lambda error: problems.append(str(error)))
    page.goto(path.as_uri())
    expect(page.get_by_role("heading", level=1)).to_contain_text(head.program.event.prompt)
    film = page.locator("video")
    page.wait_for_function("() => document.querySelector('video').readyState >= 2")
    page.get_by_role("button", name="frame ").first.click()
    page.wait_for_function("() => document.querySelector('video').currentTime > 0")
    at = film.evaluate("film => film.currentTime")
    page.keyboard.press("ArrowRight")
    page.wait_for_function("at => document.querySelector('video').currentTime > at", arg=at)

    # How fast it is shown is said with the frames, and in full.
    expect(page.locator("#at")).to_contain_text("real time")
    expect(page.get_by_text(re.compile("^Shown for .* frames a second"))).to_be_visible()

    page.get_by_role("button", name="3D").click()
    ball = head.program.scene.objects[0].name
    page.wait_for_function(
        "name => Boolean(document.querySelector('iframe')?.contentWindow.__viserMutable"
        "?.nodeRefFromName?.[`/objects/${name}`])",
        arg=ball,
        timeout=1000 * PATIENCE,
    )
    outside = [url for url in asked if not url.startswith(("file:", "data:", "blob:", "about:"))]
    assert outside == []
    assert problems == []
    context.close()


def test_a_replay_from_the_palette(waiting: Desk) -> None:
    page = waiting.page
    waiting.proposal()
    page.keyboard.press("Control+k")
    page.keyboard.type("replay html")
    page.keyboard.press("Enter")
    link: Any = page.get_by_role("link", name="Replay (HTML)")
    expect(link).to_be_visible(timeout=1000 * PATIENCE)
    with page.expect_download() as download:
        link.click()
    text = Path(download.value.path()).read_text(encoding="utf-8")
    assert waiting.snapshot.program.event.prompt in text
