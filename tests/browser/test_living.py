"""Two browsers, restarts, closed tabs, hostile pages and callbacks that raise."""

from __future__ import annotations

import json
import re
from collections.abc import Iterator
from pathlib import Path

import pytest
from playwright.sync_api import Browser, expect
from websockets.sync.client import connect
from websockets.typing import Origin

from physagent_studio.session import Store
from physagent_studio.studio import serve
from physagent_studio.workbench import Workbench, commands
from tests.browser.conftest import PATIENCE, Desk, running, until_told

pytestmark = [pytest.mark.browser, pytest.mark.usefixtures("shared_scenes")]


def _other_page(desk: Desk, browser: Browser):
    page = browser.new_page(viewport={"width": 1000, "height": 700})
    page.set_default_timeout(1000 * PATIENCE)
    page.add_init_script("localStorage.setItem('studio.toured', 'true')")
    page.route("**/viewer/**", lambda route: route.fulfill(body=""))
    page.goto(desk.studio.address)
    until_told(page)
    return page


def test_a_second_browser_follows(waiting: Desk, browser: Browser) -> None:
    other = _other_page(waiting, browser)
    action = waiting.snapshot.program.event.actions[0]
    waiting.page.locator(f"[data-action={action.id}]").focus()
    waiting.page.keyboard.press("ArrowRight")
    moved = str(action.start_step + waiting.snapshot.program.clip.steps_per_frame)
    expect(other.locator(f"[data-action={action.id}]")).to_have_attribute("data-start", moved)
    other.keyboard.press("End")
    expect(waiting.page.get_by_text(re.compile("frame 80 of 80"))).to_be_visible()
    other.close()


def test_the_tab_comes_back_after_a_restart(waiting: Desk, tmp_path: Path) -> None:
    page = waiting.page
    waiting.proposal()
    port = int(waiting.studio.address.rpartition(":")[2])
    held = waiting.snapshot
    waiting.studio.stop()
    waiting.workbench.close()
    expect(page.get_by_text("The studio does not answer.")).to_be_visible()

    again = Workbench(Store(tmp_path / "workspace"), evidence=False)
    assert held.session_id is not None
    again.post(commands.OpenSession(held.session_id))
    assert again.wait(PATIENCE)
    waiting.studio = serve(again, port=port)
    expect(page.get_by_text("The studio does not answer.")).to_have_count(
        0, timeout=1000 * PATIENCE
    )
    expect(page.get_by_role("group", name="Proposal")).to_be_visible()
    assert waiting.snapshot.state == held.state
    waiting.button("Accept").click()
    waiting.until(lambda: len(waiting.snapshot.state.rounds) == 2, "a second round")


def test_a_tab_closed_in_the_middle_loses_nothing(waiting: Desk, browser: Browser) -> None:
    waiting.proposal()
    other = _other_page(waiting, browser)
    other.get_by_role("button", name="Accept", exact=True).click()
    waiting.until(lambda: waiting.snapshot.busy or len(waiting.snapshot.state.rounds) == 2, "work")
    other.close()
    waiting.until(lambda: len(waiting.snapshot.state.rounds) == 2, "a second round")
    waiting.idle()
    expect(waiting.page.get_by_role("list", name="History").get_by_role("listitem")).to_have_count(
        len(waiting.snapshot.state.rounds)
    )


def test_what_raises_is_shown_and_the_studio_lives(
    waiting: Desk, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(waiting.studio.library, "opening", lambda *_: 1 / 0)
    waiting.page.evaluate(
        "import('/wire.js').then(wire => wire.send({do: 'open', key: 'case:demo', event: ''}))"
    )
    expect(waiting.page.get_by_text(re.compile("went wrong on our side"))).to_be_visible()
    waiting.page.keyboard.press("End")
    waiting.until(lambda: waiting.studio.view.step > 0, "life")


HOSTILE = [
    "",
    "{",
    "[]",
    '{"do":"scrub","frame":NaN}',
    '{"do":"scrub","frame":-7}',
    '{"do":"speed","factor":"fast"}',
    '{"do":"select","kind":"object","name":"<img src=x onerror=alert(1)>"}',
    '{"do":"open","key":"../../../etc/passwd"}',
    '{"do":"decide","kind":"accept","proposal":"not this one"}',
    '{"do":"edit","edits":[{"op":"set","path":"event.actions","value":[{"id":"a b"}]}]}',
    '{"do":"new","photo":"AAAA","prompt":"x","objects":[["a",[]]]}',
    '{"do":"budget","rounds":1e300}',
    '{"do":"text","text":"&a [*a]","apply":true}',
    '{"do":"pin","path":"__class__.__init__","on":true}',
    json.dumps({"do": "viewer", "token": "x" * 10_000}),
]


def test_hostile_messages_change_nothing(waiting: Desk) -> None:
    port = waiting.studio.address.rpartition(":")[2]
    before = waiting.snapshot
    with connect(
        f"ws://127.0.0.1:{port}/socket", origin=Origin(waiting.studio.address), max_size=None
    ) as line:
        for text in HOSTILE:
            line.send(text)
        line.send(b"\x00\x01")
    waiting.idle()
    assert waiting.snapshot.state == before.state
    assert waiting.snapshot.program == before.program
    waiting.page.keyboard.press("End")
    waiting.until(lambda: waiting.studio.view.step > 0, "life")
    assert waiting.page.locator("img[src=x]").count() == 0


def test_a_new_session_from_a_photo_by_clicks_alone(waiting: Desk, repository: Path) -> None:
    page = waiting.page
    waiting.button("Open…").click()
    waiting.button("New from a photo…").click()
    page.locator("input[type=file]").set_input_files(
        str(repository / "assets" / "demo" / "input.png")
    )
    picture = page.locator("[data-photo]")
    expect(picture).to_be_visible()
    box = waiting.box(picture)
    scale = box["width"] / 832
    picture.click(position={"x": 180 * scale, "y": 354 * scale})
    page.get_by_label("Name 1").fill("red ball")
    waiting.button("Another thing").click()
    picture.click(position={"x": 503 * scale, "y": 222 * scale})
    page.get_by_label("Sentence").fill("The red ball rolls to the right and hits the wooden block.")
    expect(page.get_by_text("Call thing 2 what the sentence calls it")).to_be_visible()
    page.get_by_label("Name 2").fill("bälle")
    expect(page.get_by_text("“bälle” cannot be a name")).to_be_visible()
    page.get_by_label("Name 2").fill("wooden_block")
    old, store = waiting.snapshot.session_id, waiting.workbench.store
    count = len(store.list())
    start = page.get_by_role("dialog").get_by_role("button", name="Make the scene", exact=True)
    start.evaluate("button => { button.click(); button.click(); }")
    waiting.until(lambda: waiting.snapshot.session_id != old, "a new session")
    waiting.idle()
    assert len(store.list()) == count + 1, "a double click is one session"
    assert waiting.snapshot.title == "The red ball rolls to the right and hits the…"
    expect(page.get_by_text("The scene matches the photo", exact=True)).to_be_visible()
    waiting.button("Start").click()
    waiting.until(lambda: waiting.snapshot.rollout is not None, "a rollout")
    names = {one.name for one in waiting.snapshot.program.scene.objects}
    assert names == {"red_ball", "wooden_block"}


def test_sessions_are_listed_and_opened(waiting: Desk) -> None:
    page = waiting.page
    first = waiting.snapshot.session_id
    waiting.button("Open…").click()
    page.get_by_role("dialog").get_by_role(
        "button", name=re.compile("knocks block over")
    ).first.click()
    waiting.until(lambda: waiting.snapshot.session_id != first, "another session")
    waiting.idle()  # its scene may have to be made first
    waiting.button("Open…").click()
    page.get_by_role("dialog").locator(f"[data-key='session:{first}']").click()
    waiting.until(lambda: waiting.snapshot.session_id == first, "the first session")
    waiting.proposal()


@pytest.fixture
def nothing(tmp_path: Path, browser: Browser) -> Iterator[Desk]:
    """A studio in which nothing was opened yet."""
    yield from running(tmp_path, browser)


def test_who_comes_first_is_told_where_to_begin(nothing: Desk) -> None:
    page = nothing.page
    page.keyboard.press("r")
    expect(page.get_by_text("begin with an example, a photo or an empty scene")).to_be_visible()
    nothing.button("New from a photo").click()
    expect(page.get_by_role("dialog", name="New session from a photo")).to_be_visible()
    page.keyboard.press("Escape")
    nothing.button("An empty scene").click()
    nothing.until(lambda: nothing.snapshot.session_id, "a session")
    expect(nothing.button("An empty scene")).to_have_count(0)


def test_the_layout_is_moved_by_keys_and_remembered(waiting: Desk) -> None:
    page = waiting.page

    def width() -> float:
        return waiting.box(page.locator("#left"))["width"]

    before, step = width(), waiting.studio.view.step
    page.locator("#split-left").focus()
    for _ in range(3):
        page.keyboard.press("ArrowRight")
    waiting.until(lambda: width() > before + 30, "a wider dock")
    assert waiting.studio.view.step == step, "the playhead stays"
    wider = width()
    waiting.reload()
    expect(page.get_by_role("tab", name="Rounds")).to_be_visible()
    waiting.until(lambda: width() == wider, "the same after a reload")
    page.locator("#split-left").dblclick()
    waiting.until(lambda: width() == before, "as it was")


def test_the_scene_shows_that_the_keys_go_to_it(waiting: Desk) -> None:
    """A page within a page is never told to be the one in focus: its edge says so instead."""
    page = waiting.page
    edge = "() => getComputedStyle(document.getElementById('viewer')).outlineStyle"
    assert page.evaluate(edge) == "none"
    for _ in range(60):
        page.keyboard.press("Tab")
        if page.evaluate("() => document.activeElement.id") == "viewer":
            break
    waiting.until(lambda: page.evaluate(edge) == "solid", "an edge around the scene")
    page.locator("#split-left").focus()
    waiting.until(lambda: page.evaluate(edge) == "none", "no edge any more")
