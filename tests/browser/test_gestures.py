"""What comes in the middle of a gesture: a deletion, another photo, an error, a lost line."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from playwright.sync_api import Browser, WebSocketRoute, expect

from physagent_studio.program.actions import ApplyForce
from physagent_studio.program.edits import AddItem, RemoveItem
from physagent_studio.program.text.document import load_program
from physagent_studio.workbench import commands
from tests.browser.conftest import Desk

pytestmark = [pytest.mark.browser, pytest.mark.usefixtures("shared_scenes")]


def test_a_page_that_was_told_nothing_yet_takes_every_gesture(
    waiting: Desk, browser: Browser
) -> None:
    page = browser.new_page(viewport={"width": 1280, "height": 800})
    errors: list[str] = []
    page.on("pageerror", lambda error: errors.append(str(error)))
    page.route("**/viewer/**", lambda route: route.fulfill(body=""))
    page.route_web_socket("**/socket", lambda _: None)
    page.goto(waiting.studio.address)
    lanes = page.locator(".lanes")
    lanes.focus()
    for key in ("+", "-", "Escape", "Delete", "ArrowRight", " ", "[", "r", "a", "s", "n", "f"):
        page.keyboard.press(key)
    lanes.click()
    page.keyboard.down("Control")
    page.mouse.wheel(0, -100)
    page.keyboard.up("Control")
    page.get_by_role("tab", name="Program").click()
    text = page.get_by_label("Program as YAML")
    text.click()
    for key in ("x", "Tab", "Control+Enter"):
        page.keyboard.press(key)
    expect(text).to_have_value("")
    page.close()
    assert errors == []


def test_a_key_that_comes_before_the_page_is_told_of_a_clip_is_not_lost(
    waiting: Desk, browser: Browser
) -> None:
    page = browser.new_page(viewport={"width": 1280, "height": 800})
    page.route("**/viewer/**", lambda route: route.fulfill(body=""))
    held: list[str | bytes] = []
    lines: list[WebSocketRoute] = []

    def hold(line: WebSocketRoute) -> None:
        line.connect_to_server().on_message(lambda one: held.append(one))
        lines.append(line)

    page.route_web_socket("**/socket", hold)
    page.goto(waiting.studio.address)
    waiting.until(lambda: any('"on":"library"' in str(one) for one in held), "all that is told")
    page.keyboard.press("End")
    for one in held:
        lines[0].send(one)
    clip = waiting.snapshot.program.clip
    waiting.until(lambda: waiting.studio.view.frame(clip) == clip.frames - 1, "the end")
    page.close()


def _drag_begun(desk: Desk) -> tuple[str, float, float]:
    """Presses on the first bar and moves it; its action's id and where the pointer is."""
    bar = desk.page.locator(".tl [data-action]").first
    expect(bar).to_be_visible()
    name = bar.get_attribute("data-action")
    box = desk.box(bar.locator(".body"))
    assert name is not None
    x, y = box["x"] + box["width"] / 2, box["y"] + 8
    mouse = desk.page.mouse
    mouse.move(x, y)
    mouse.down()
    mouse.move(x + 40, y, steps=4)
    return name, x + 40, y


def test_the_program_changes_under_a_bar_that_is_dragged(waiting: Desk) -> None:
    page = waiting.page
    drawn: list[str] = []
    page.on("console", lambda message: drawn.append(message.text))
    name, x, y = _drag_begun(waiting)
    ball = {"name": "late", "shape": {"kind": "sphere", "radius": 0.05}, "position": [0, 1, 0.5]}
    waiting.workbench.post(
        commands.ApplyEdits((AddItem(path="scene.objects", item=ball),), "a lane more")
    )
    waiting.until(lambda: waiting.snapshot.program.scene.object("late"), "a lane more")
    expect(page.locator("[data-lane=late]")).to_be_attached()
    page.mouse.move(x + 20, y, steps=3)
    waiting.workbench.post(
        commands.ApplyEdits((RemoveItem(path=f"event.actions.{name}"),), "deleted")
    )
    expect(page.locator(f"[data-action={name}]")).to_have_count(0)
    page.mouse.move(x + 40, y, steps=3)
    page.mouse.up()
    waiting.idle()
    expect(page.locator(".tl .tip")).to_have_count(0)
    expect(page.locator("#notices .error")).to_have_count(0)
    assert waiting.snapshot.attempt is None
    assert not [text for text in drawn if "NaN" in text]


TURNED = """
scene:
  objects:
    - {name: cube, shape: {kind: box, size: [0.2, 0.2, 0.2]}, position: [1, 2, 0.1], support: floor}
  supports:
    - {name: floor, shape: {kind: floor}}
event:
  prompt: The cube is pushed.
  actions:
    - {operator: ApplyForce, id: shove, name: cube, force: [2, 0, 0], duration: 20}
    - operator: ApplyForce
      id: aimed
      name: cube
      force: {magnitude: 2, direction: right}
      duration: 20
"""


def test_a_dial_turns_by_a_hand_that_holds_it_alone(waiting: Desk) -> None:
    page = waiting.page
    waiting.workbench.post(commands.OpenProgram(load_program(TURNED), "turned"))
    waiting.tab("Inspector")

    def force(name: str) -> Any:
        action = waiting.snapshot.program.action(name)
        assert isinstance(action, ApplyForce)
        return action.force

    page.locator("[data-action=shove] .body").click()
    dial = page.get_by_label("seen from above")
    expect(dial).to_be_visible()
    box = waiting.box(dial)
    x, y = box["x"] + 32, box["y"] + 32
    # What goes down elsewhere and up here turns nothing.
    page.mouse.move(x, y - 60)
    page.mouse.down()
    page.mouse.move(x, y - 20)
    page.mouse.up()
    waiting.idle()
    assert force("shove") == (2, 0, 0)
    page.mouse.move(x + 20, y)
    page.mouse.down()
    page.mouse.move(x, y - 20, steps=3)
    waiting.until(lambda: waiting.snapshot.attempt, "a run while it turns")
    other = AddItem(path="scene.flags", item="something else")
    waiting.workbench.post(commands.ApplyEdits((other,), "by another browser"))
    waiting.until(lambda: waiting.snapshot.program.scene.flags, "another program")
    waiting.shown()  # what is turned before the page knows of it would be refused as stale
    page.mouse.move(x - 20, y, steps=3)
    page.mouse.up()
    waiting.until(lambda: np.allclose(force("shove"), (-2, 0, 0), atol=0.1), "a turned force")
    page.locator("[data-action=aimed] .body").click()
    aside = page.get_by_label("Aside: dial seen from above")
    box = waiting.box(aside)
    page.mouse.click(box["x"] + 12, box["y"] + 32)
    waiting.until(lambda: np.isclose(force("aimed").azimuth, 90, atol=1), "straight to the left")


def _marking(desk: Desk, tool: str) -> None:
    desk.tab("Photo")
    button = desk.button(tool)
    button.click()
    expect(button).to_have_attribute("aria-pressed", "true")


def test_what_is_marked_stays_with_its_photo_and_waits_for_its_own_answer(waiting: Desk) -> None:
    page = waiting.page
    _marking(waiting, "Ramp")
    page.get_by_role("button", name="Zoom in").click()
    page.get_by_role("button", name="Whole photo").click()
    expect(page.locator(".ph-live .ph-dot")).to_have_count(0)
    # A photo that is replaced takes along what was being marked on it.
    first = waiting.snapshot.session_id
    assert first is not None
    masks = page.locator(".photo-masks button")
    page.get_by_label("Name of a new thing").fill("thing")
    page.keyboard.press("Enter")
    stage = page.locator(".photo-stage > svg")
    stage.click(position={"x": 60, "y": 40})
    expect(masks.first).to_be_visible()
    waiting.workbench.post(commands.OpenProgram(load_program(TURNED), "turned"))
    expect(page.get_by_text("This program has no photo.")).to_be_visible()
    for session in (first, "none of these", "nor of these"):
        waiting.workbench.post(commands.OpenSession(session))
    expect(stage).to_be_visible()
    expect(masks).to_have_count(0)
    # An error from before is no answer to a mask that is taken after it.
    errors = page.locator("#notices .error")
    expect(errors).to_have_count(2)
    page.locator(".photo-things").get_by_role("button").first.click()
    _marking(waiting, "Mask")
    stage.click(position={"x": 90, "y": 60})
    masks.first.click()
    errors.first.get_by_label("Dismiss").click()
    expect(errors).to_have_count(1)
    waiting.drawn()
    assert page.get_by_text("to use one.").count() == 0
    waiting.workbench.cancel()


def test_words_for_one_verdict_are_not_those_for_the_next(waiting: Desk) -> None:
    page = waiting.page
    waiting.proposal()
    page.get_by_role("button", name="I disagree").click()
    page.get_by_label("Your reason").fill("it slid")
    waiting.button("Accept").click()
    waiting.until(lambda: len(waiting.snapshot.state.rounds) == 2, "a second round")
    waiting.idle()
    expect(page.get_by_role("button", name="I disagree")).to_be_visible()
    expect(page.get_by_label("Your reason")).to_have_count(0)
