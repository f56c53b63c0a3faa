"""The program as text and as forms: errors at their lines, nothing typed is ever lost."""

from __future__ import annotations

import re
import time

import pytest
from playwright.sync_api import expect

from tests.browser.conftest import Desk

pytestmark = pytest.mark.browser


def _editor(desk: Desk):
    desk.tab("Program")
    area = desk.page.get_by_label("Program as YAML")
    expect(area).to_have_value(re.compile("event"))
    return area


def test_an_error_is_shown_at_its_line_and_nothing_is_lost(waiting: Desk) -> None:
    page = waiting.page
    area = _editor(waiting)
    program = waiting.snapshot.program
    text = area.input_value()
    lines = text.split("\n")
    at = next(n for n, line in enumerate(lines) if line.strip().startswith("duration:"))
    lines[at] = lines[at].split(":")[0] + ": -5"
    wrong = "\n".join(lines)
    area.fill(wrong)
    waiting.button("Validate").click()
    expect(page.get_by_role("button", name=re.compile(rf"Line {at + 1}:"))).to_be_visible()
    expect(page.locator(".gutter b")).to_have_text(f"● {at + 1}")
    expect(area).to_have_value(wrong)
    waiting.button("Apply").click()
    waiting.idle()
    assert waiting.snapshot.program == program
    expect(area).to_have_value(wrong)
    waiting.reload()
    waiting.tab("Program")
    expect(area).to_have_value(wrong)

    lines[at] = lines[at].split(":")[0] + ": 31"
    area.fill("\n".join(lines))
    waiting.button("Apply").click()
    waiting.until(lambda: waiting.snapshot.has_draft, "a draft")
    assert any(getattr(one, "duration", 0) == 31 for one in waiting.snapshot.program.event.actions)
    expect(page.locator(".problems button")).to_have_count(0)


def test_typing_is_not_clobbered_by_what_happens_meanwhile(waiting: Desk) -> None:
    area = _editor(waiting)
    area.press("Control+Home")
    area.type("# mine\n")
    waiting.page.evaluate("import('/wire.js').then(wire => wire.send({do: 'budget', rounds: 7}))")
    waiting.until(lambda: waiting.snapshot.state.budget == 7, "the budget")
    waiting.idle()
    assert area.input_value().startswith("# mine\n")


def test_ten_thousand_lines_are_a_sentence_not_a_crash(waiting: Desk) -> None:
    page = waiting.page
    area = _editor(waiting)
    program = waiting.snapshot.program
    text = area.input_value() + "".join(f"\n# line {n}" for n in range(10_000)) + "\nnonsense: ["
    started = time.process_time()
    area.evaluate("(area, text) => { area.value = text; area.oninput(); }", text)
    waiting.button("Apply").click()
    waiting.until(lambda: waiting.snapshot.yaml_problems or waiting.snapshot.notices, "a sentence")
    assert waiting.snapshot.program == program
    assert time.process_time() - started < 60, "of work, not of waiting"
    expect(page.get_by_role("tab", name="Program")).to_be_visible()


def test_the_inspector_changes_a_number_and_refuses_nan(waiting: Desk) -> None:
    page = waiting.page
    action = waiting.snapshot.program.event.actions[0]
    page.locator(f"[data-action={action.id}] .body").click()
    waiting.tab("Inspector")
    field = page.get_by_label("Starts at", exact=True)
    seconds = waiting.snapshot.program.clip.step_seconds
    expect(field).to_have_value(f"{action.start_step * seconds:g}")
    for text in ("NaN", "1e999", "-3", "two"):
        field.fill(text)
        field.press("Enter")
        waiting.idle()
        assert waiting.snapshot.program.event.actions[0] == action
    expect(page.locator(".notice.error").first).to_be_visible()
    field.fill(f"{17 * seconds:g}")
    field.press("Enter")
    waiting.until(lambda: waiting.snapshot.program.event.actions[0].start_step == 17, "the edit")
    expect(field).to_have_value(f"{17 * seconds:g}")


def test_a_program_built_by_hand_without_a_photo(waiting: Desk) -> None:
    page = waiting.page
    waiting.empty_scene()
    waiting.button("Ball").click()
    waiting.until(lambda: waiting.snapshot.program.scene.object("ball"), "a ball")
    page.keyboard.press("Control+k")
    page.keyboard.type("add box")
    page.keyboard.press("Enter")
    waiting.until(lambda: waiting.snapshot.program.scene.object("box"), "a box")
    # The menu names what the page knows of when it is opened.
    expect(page.locator("[data-lane=box]")).to_be_attached()
    page.get_by_role("button", name="Add an action").click()
    page.get_by_role("menuitem", name="Push box").click()
    waiting.until(lambda: waiting.snapshot.program.event.actions, "an action")
    waiting.button("+ Demand something").click()
    page.get_by_label("Who", exact=True).select_option("box")
    page.get_by_label("Does what").select_option("moves")
    waiting.button("Add to the checklist").click()
    waiting.until(lambda: waiting.snapshot.program.contract.statements, "a statement")
    waiting.idle()
    rollout = waiting.snapshot.rollout
    assert rollout is not None
    assert set(rollout.objects) == {"ball", "box"}
    assert [one.kind for one in waiting.snapshot.checks if not one.always_on] == ["moves"]
    waiting.button("Run my edits").click()
    waiting.until(lambda: waiting.snapshot.state.rounds, "a round")
    waiting.idle()
    # Quick clicks come before the scene that the first of them makes: each is a thing of its own.
    waiting.tab("Scene")
    waiting.button("Cone").evaluate("button => { for (let i = 0; i < 3; i += 1) button.click(); }")
    scene = waiting.until(
        lambda: waiting.snapshot.program.scene.object("cone_3") and waiting.snapshot.program.scene,
        "three cones",
    )
    places = {item.position for item in scene.objects if item.name.startswith("cone")}
    assert len(places) == 3
    assert not waiting.snapshot.notices


def test_the_inspector_changes_a_shape_and_lets_an_action_wait(waiting: Desk) -> None:
    page = waiting.page
    before = waiting.snapshot.program
    action = before.event.actions[0]
    page.locator(f"[data-action={action.id}] .body").click()
    waiting.tab("Inspector")
    starts = page.get_by_label("Starts: kind")
    starts.select_option("when two things touch")
    waiting.until(lambda: waiting.snapshot.program.event.actions[0].when, "a condition")
    waiting.idle()
    expect(page.get_by_label("The other", exact=True)).to_be_visible()
    starts.select_option("at that moment")
    waiting.until(lambda: waiting.snapshot.program.event.actions[0].when is None, "its own step")
    waiting.idle()

    name = action.name
    page.evaluate(
        "name => import('/wire.js').then(w => w.send({do: 'select', kind: 'object', name}))", name
    )
    shape = page.get_by_label("Shape: kind")
    shape.select_option("box")

    def kind() -> str:
        item = waiting.snapshot.program.scene.object(name)
        return "" if item is None or item.shape is None else item.shape.kind

    waiting.until(lambda: kind() == "box", "a box")
    waiting.idle()
    size = page.get_by_label("Size x", exact=True)
    size.fill("0.05")
    size.press("Enter")

    def width() -> float:
        item = waiting.snapshot.program.scene.object(name)
        return item.shape.size[0] if item and item.shape and item.shape.kind == "box" else 0.0

    waiting.until(lambda: width() == 0.05, "another width")
    waiting.idle()
    assert waiting.snapshot.rollout is not None
    for _ in range(4):
        waiting.button("Undo (Ctrl+Z)").click()
        waiting.idle()
    assert waiting.snapshot.program == before


def test_deleting_a_thing_takes_its_actions_along_and_can_be_undone(waiting: Desk) -> None:
    page = waiting.page
    before = waiting.snapshot.program
    name = before.event.actions[0].name
    page.evaluate(
        "name => import('/wire.js').then(w => w.send({do: 'select', kind: 'object', name}))", name
    )
    page.locator("#page-inspector").get_by_role("button", name="Delete", exact=True).click()
    waiting.until(lambda: waiting.snapshot.program.scene.object(name) is None, "it is gone")
    after = waiting.snapshot.program
    assert name not in {one.name for one in after.event.actions}
    assert name not in {getattr(one, "subject", "") for one in after.contract.statements}
    notice = page.locator(".notice").filter(has_text="what spoke of it")
    notice.get_by_role("button", name="Undo").click()
    waiting.until(lambda: waiting.snapshot.program == before, "everything is back")
