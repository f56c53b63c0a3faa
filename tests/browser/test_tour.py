"""The first-run tour, and presenting: both by keyboard alone."""

from __future__ import annotations

import json
import re
import shutil
from collections.abc import Iterator
from pathlib import Path

import pytest
from playwright.sync_api import Browser, expect
from websockets.sync.client import connect
from websockets.typing import Origin

from physagent_studio.session import Store
from tests.browser.conftest import PATIENCE, Desk, running

pytestmark = pytest.mark.browser


@pytest.fixture
def first(tmp_path: Path, browser: Browser, decided_once: Path) -> Iterator[Desk]:
    """The waiting session, in a browser that was never here."""
    root = tmp_path / "workspace"
    shutil.copytree(decided_once, root)
    yield from running(root, browser, Store(root).list()[0].id, tour=True)


def test_five_steps_by_keyboard_and_never_again(first: Desk) -> None:
    page = first.page
    for step in range(1, 6):
        expect(page.get_by_role("dialog", name=f"Tour, step {step} of 5")).to_be_visible()
        page.keyboard.press("Enter")
    card = page.get_by_role("dialog", name=re.compile("^Tour"))
    expect(card).to_have_count(0)
    first.reload()
    expect(page.get_by_role("group", name="Proposal")).to_be_visible()
    expect(card).to_have_count(0)
    # Again from the palette, back a step, and out by Escape.
    page.keyboard.press("Control+k")
    page.keyboard.type("take the tour")
    page.keyboard.press("Enter")
    expect(card).to_be_visible()
    page.keyboard.press("ArrowRight")
    page.keyboard.press("ArrowLeft")
    expect(page.get_by_role("dialog", name="Tour, step 1 of 5")).to_be_visible()
    page.keyboard.press("Escape")
    expect(card).to_have_count(0)


def test_no_step_lies_over_what_tells_of_the_work(first: Desk) -> None:
    page, run = first.page, first.box(first.page.locator("#run"))
    for step in range(1, 6):
        card = first.box(page.get_by_role("dialog", name=f"Tour, step {step} of 5"))
        beside = card["x"] + card["width"] <= run["x"] or run["x"] + run["width"] <= card["x"]
        above = card["y"] + card["height"] <= run["y"] or run["y"] + run["height"] <= card["y"]
        assert beside or above
        page.keyboard.press("ArrowRight")


def test_the_tour_stands_in_nobody_s_way(first: Desk) -> None:
    page = first.page
    card = page.get_by_role("dialog", name=re.compile("^Tour"))
    expect(card).to_be_visible()
    page.get_by_role("tab", name="Plots").click()
    expect(page.get_by_role("tab", name="Plots")).to_have_attribute("aria-selected", "true")
    expect(card).to_be_visible()
    card.get_by_role("button", name="Skip", exact=True).click()
    expect(card).to_have_count(0)
    first.reload()
    expect(page.get_by_role("tab", name="Plots")).to_be_visible()
    expect(card).to_have_count(0)


def test_presenting_steps_through_rounds_and_changes_nothing(waiting: Desk) -> None:
    page = waiting.page
    waiting.proposal()
    waiting.button("Accept").click()
    waiting.until(lambda: len(waiting.snapshot.state.rounds) == 2, "a second round")
    waiting.idle()
    before = waiting.snapshot
    page.keyboard.press("Shift+P")
    label = page.locator("#presenter")
    expect(label).to_contain_text("Presenting")
    expect(label).to_contain_text("Round 2 of 2")
    expect(page.get_by_role("group", name="How it happens")).to_be_hidden()
    for name in ("Accept", "I disagree", "Run to the end", "Open…", "+ Action"):
        expect(waiting.button(name)).to_have_count(0)
    page.keyboard.press("p")
    expect(label).to_contain_text("Round 1 of 2")
    page.keyboard.press("PageDown")
    expect(label).to_contain_text("Round 2 of 2")
    page.keyboard.press("End")
    waiting.until(lambda: waiting.studio.view.step > 0, "the end of the clip")
    # Neither a key nor a message of the page changes anything.
    for key in ("a", "r", "Shift+R", "Control+z"):
        page.keyboard.press(key)
    page.evaluate("import('/wire.js').then(wire => wire.send({do: 'budget', rounds: 3}))")
    expect(page.get_by_text("Presenting: nothing is changed here.")).to_be_visible()
    waiting.idle()
    assert waiting.snapshot.state == before.state
    page.keyboard.press("Escape")
    expect(label).not_to_be_visible()
    page.evaluate("import('/wire.js').then(wire => wire.send({do: 'budget', rounds: 3}))")
    waiting.until(lambda: waiting.snapshot.state.budget == 3, "an edit, after presenting")


def test_the_server_refuses_what_a_presenting_page_sends(waiting: Desk) -> None:
    port = waiting.studio.address.rpartition(":")[2]
    origin = Origin(waiting.studio.address)
    with connect(f"ws://127.0.0.1:{port}/socket", origin=origin, max_size=None) as line:
        line.send(json.dumps({"do": "present", "on": True}))
        line.send(json.dumps({"do": "budget", "rounds": 3}))
        said = {}
        while said.get("on") != "say":
            said = json.loads(line.recv(timeout=PATIENCE))
        assert "presents" in said["is"]["text"]
        line.send(json.dumps({"do": "scrub", "frame": 7}))
        clip = waiting.snapshot.program.clip
        waiting.until(lambda: waiting.studio.view.frame(clip) == 7, "looking is allowed")
    assert waiting.snapshot.state.budget != 3


def test_a_dialog_lies_over_the_tour(first: Desk) -> None:
    page = first.page
    expect(page.get_by_role("dialog", name="Tour, step 1 of 5")).to_be_visible()
    first.button("Open…").click()
    first.button("New from a photo…").click()
    dialog = page.get_by_role("dialog", name="New session from a photo")
    expect(dialog).to_be_visible()
    # What is hit in the middle of the tour's card belongs to the dialog now.
    box = first.box(page.locator(".tour-card"))
    spot = [box["x"] + box["width"] / 2, box["y"] + box["height"] / 2]
    hit = "([x, y]) => !!document.elementFromPoint(x, y).closest('.shade')"
    assert page.evaluate(hit, spot)
