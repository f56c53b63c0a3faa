"""The list of sessions and the strip of sampled frames."""

from __future__ import annotations

import re
import shutil
import urllib.error
import urllib.request
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from playwright.sync_api import Browser, expect

from physagent_studio.records import Assessment
from physagent_studio.records.judgement import Criterion
from physagent_studio.session import Store
from tests.browser.conftest import PATIENCE, Desk, running

pytestmark = [pytest.mark.browser, pytest.mark.usefixtures("shared_scenes")]

LOADED = "image => image.complete && image.naturalWidth > 0"


def _list(desk: Desk) -> Any:
    desk.button("Open…").click()
    return desk.page.get_by_role("dialog", name="Open")


def _entry(desk: Desk, title: str) -> Any:
    """The button that opens the session of that title."""
    return desk.page.locator(".entry-row .entry").filter(has_text=title)


def test_sessions_are_renamed_copied_deleted_and_brought_back(waiting: Desk) -> None:
    page, store = waiting.page, waiting.workbench.store
    opened = waiting.snapshot.session_id
    (first,) = store.list()
    # A session that comes from elsewhere, such as the command line, is there when one looks.
    elsewhere = store.duplicate(first.id)
    _list(waiting)
    expect(page.locator(".entry-row")).to_have_count(2)
    store.discard(elsewhere)
    page.keyboard.press("Escape")
    _list(waiting)
    expect(page.locator(".entry-row")).to_have_count(1)
    waiting.until(lambda: page.locator(".entry-row .face img").first.evaluate(LOADED), "a face")
    assert waiting.button(f"Duplicate “{first.title}”").is_enabled()
    waiting.button(f"Duplicate “{first.title}”").click()
    copy = f"{first.title} (2)"
    expect(_entry(waiting, copy)).to_be_visible()

    waiting.button(f"Rename “{copy}”").click()
    field = page.get_by_label("Title of the session")
    field.fill("The <i>other</i> one")
    field.press("Enter")
    expect(_entry(waiting, "The <i>other</i> one")).to_be_visible()
    waiting.button(f"Rename “{first.title}”").click()
    page.get_by_label("Title of the session").fill("Mine")
    waiting.button("Rename").click()
    waiting.until(lambda: waiting.snapshot.title == "Mine", "the open session's title")

    waiting.button("Delete “The <i>other</i> one”").click()
    waiting.button("Keep").click()
    assert len(store.list()) == 2
    waiting.button("Delete “The <i>other</i> one”").click()
    waiting.button("Delete").click()
    waiting.until(lambda: len(store.list()) == 1, "a deletion")
    expect(_entry(waiting, "other")).to_have_count(0)
    waiting.button("Undo").click()
    waiting.until(lambda: len(store.list()) == 2, "the session again")
    expect(_entry(waiting, "The <i>other</i> one")).to_be_visible()
    assert waiting.snapshot.session_id == opened


def test_the_open_session_is_not_deleted(waiting: Desk) -> None:
    page = waiting.page
    _list(waiting)
    delete = page.get_by_role("button", name=re.compile("cannot be deleted"))
    expect(delete).to_be_disabled()
    key = f"session:{waiting.snapshot.session_id}"
    page.evaluate(
        "key => import('/wire.js').then(wire => wire.send({do: 'delete_session', key}))", key
    )
    expect(page.get_by_text("this session is open")).to_be_visible()
    assert waiting.workbench.store.list()[0].id == waiting.snapshot.session_id


@pytest.fixture
def with_frames(tmp_path: Path, browser: Browser, decided_once: Path) -> Iterator[Desk]:
    """The waiting session with the frames of its strip."""
    root = tmp_path / "workspace"
    shutil.copytree(decided_once, root)
    yield from running(root, browser, Store(root).list()[0].id, pictures=True)


def test_sampled_frames_load_as_they_come_into_view_and_go_there(with_frames: Desk) -> None:
    waiting, page = with_frames, with_frames.page
    waiting.proposal()
    strip = page.get_by_role("group", name="Sampled frames")
    frames = strip.get_by_role("button")
    expect(frames).to_have_count(27)
    waiting.until(lambda: frames.first.locator("img").evaluate(LOADED), "the first frame")
    strip.get_by_role("button", name="Frame 30", exact=True).click()
    clip = waiting.snapshot.program.clip
    waiting.until(lambda: waiting.studio.view.frame(clip) == 30, "frame 30")
    expect(strip.locator("[aria-current=true]")).to_have_text("1.20 s")
    # The playhead and the arrow keys move along the strip.
    strip.get_by_role("button", name="Frame 30", exact=True).press("ArrowRight")
    waiting.until(lambda: waiting.studio.view.frame(clip) == 33, "frame 33")
    page.locator("body").press("End")
    expect(strip.locator("[aria-current=true]")).to_have_text("3.12 s")
    last = strip.get_by_role("button", name="Frame 78", exact=True).locator("img")
    waiting.until(lambda: last.evaluate(LOADED), "the last frame, brought into view")


def test_pictures_are_for_this_page_only(waiting: Desk) -> None:
    waiting.proposal()
    source = waiting.page.locator(".evidence img").first.get_attribute("src")
    address = f"{waiting.studio.address}/{source}"
    with urllib.request.urlopen(address, timeout=PATIENCE) as answer:
        assert answer.read(3) == b"\xff\xd8\xff"
    foreign = urllib.request.Request(address, headers={"Origin": "http://example.org"})
    for request in (foreign, f"{waiting.studio.address}/frame/../../etc/passwd/1.jpg"):
        with pytest.raises(urllib.error.HTTPError):
            urllib.request.urlopen(request, timeout=PATIENCE)


def test_a_model_s_question_reasons_and_contradiction_are_shown(waiting: Desk) -> None:
    """What a model says beyond a verdict, put into the stored round."""
    page, desk = waiting.page, waiting
    proposal = desk.proposal()
    state = desk.snapshot.state
    head = state.current
    assert head is not None
    assert head.assessment is not None
    assessment: Assessment = head.assessment.model_copy(
        update={
            "author": "vlm",
            "contradiction": "the model passes, but the ball was measured on the block",
            "clauses": (Criterion(name="hits the cube", ok=False, reason="it stops <b>short</b>"),),
        }
    )
    asked = proposal.model_copy(update={"hunks": (), "question": "How heavy is the ball?"})
    changed = head.model_copy(update={"assessment": assessment, "proposal": asked})
    store, name = desk.workbench.store, str(desk.snapshot.session_id)
    desk.button("Open…").click()
    desk.button("Empty scene").click()
    desk.until(lambda: desk.snapshot.session_id != name, "another session")
    session = store.open(name)
    rounds = tuple(changed if one.id == head.id else one for one in state.rounds)
    session.save(state.model_copy(update={"rounds": rounds}), checkpoint="test")
    session.close()
    _list(desk).locator(f"[data-key='session:{name}']").click()
    expect(page.get_by_text("the ball was measured on the block")).to_be_visible()
    expect(page.get_by_role("list", name="Clause by clause")).to_contain_text("it stops <b>short")
    expect(page.get_by_text("How heavy is the ball?")).to_be_visible()
    # No repair: nothing to accept or to see, and what a person can do.
    expect(desk.button("Accept")).to_have_count(0)
    expect(page.get_by_text("See the proposed repair")).to_have_count(0)
    expect(page.get_by_role("group", name="What you can do").get_by_role("button")).to_have_text(
        ["Draw a mask anew", "Demand less", "Write another sentence"]
    )
    expect(desk.button("Give a hint")).to_be_enabled()
    page.get_by_label("Your answer").fill("80 grams")
    desk.button("Answer").click()
    desk.until(lambda: desk.snapshot.state.hints == ("80 grams",), "the answer")


def test_the_video_of_a_round_is_linked_when_it_is_done(waiting: Desk) -> None:
    page = waiting.page
    waiting.proposal()
    page.keyboard.press("Control+k")
    page.keyboard.type("save the clip as a video")
    page.keyboard.press("Enter")
    link = page.get_by_role("link", name="Video of this round")
    expect(link).to_be_visible(timeout=1000 * PATIENCE)
    address = f"{waiting.studio.address}/{link.get_attribute('href')}"
    with urllib.request.urlopen(address, timeout=PATIENCE) as answer:
        assert answer.headers["Content-Type"] == "video/mp4"
        assert answer.read(12)[4:8] == b"ftyp"
