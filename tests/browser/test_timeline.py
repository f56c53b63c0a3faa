"""The timeline under the pointer and the keyboard: what is dropped is what runs."""

from __future__ import annotations

import re
from typing import Any

import numpy as np
import pytest
from playwright.sync_api import expect

from physagent_studio.program import AddItem, RemoveItem
from physagent_studio.program.text.document import load_program
from physagent_studio.program.timing import PACE
from physagent_studio.workbench import commands
from tests.browser.conftest import Desk

pytestmark = pytest.mark.browser


def _bar(desk: Desk) -> Any:
    expect(desk.page.locator(".tl [data-action]").first).to_be_visible()
    return desk.page.locator(".tl [data-action]").first


def _positions(desk: Desk) -> Any:
    rollout = desk.snapshot.rollout
    assert rollout is not None
    return rollout.positions


def _per_frame(desk: Desk) -> float:
    """Pixels of one frame in the timeline."""
    ends = [
        float(desk.page.locator(".tl line.grid").nth(n).get_attribute("x1") or 0) for n in (0, 1)
    ]
    ticks = desk.page.locator(".tl line.grid + text")
    seconds = [float(str(ticks.nth(n).text_content()).split()[0]) for n in (0, 1)]
    clip = desk.snapshot.program.clip
    frame = clip.steps_per_frame * clip.step_seconds
    return frame * (ends[1] - ends[0]) / (seconds[1] - seconds[0])


def _drag(desk: Desk, x: float, y: float, by: float) -> None:
    mouse = desk.page.mouse
    mouse.move(x, y)
    mouse.down()
    mouse.move(x + by, y, steps=8)
    mouse.up()


def test_bars_too_short_for_their_words_share_some(waiting: Desk) -> None:
    action = waiting.snapshot.program.event.actions[0]
    push = {"operator": "ApplyForce", "name": action.name, "force": [1.0, 0.0, 0.0], "duration": 2}
    add = [
        AddItem(path="event.actions", item=push | {"id": f"short_{at}", "start_step": at})
        for at in (200, 212, 224)
    ]
    waiting.workbench.post(commands.ApplyEdits(tuple(add), "short ones"))
    last = waiting.page.locator(".tl [data-action=short_224]")
    expect(last).to_be_visible()
    expect(last.locator("text")).to_have_text("3 × Push")
    expect(waiting.page.locator(".tl [data-action=short_200] text")).to_have_text("")


def test_words_beside_a_bar_make_room_for_where_the_thing_leaves_the_picture(
    waiting: Desk,
) -> None:
    actions = waiting.snapshot.program.event.actions
    shot = {
        "operator": "SetVelocity", "name": actions[0].name, "velocity": [9.0, 0.0, 0.0],
        "id": "shot", "start_step": 100,
    }  # fmt: skip
    away = [RemoveItem(path=f"event.actions.{one.id}") for one in actions]
    edits = (*away, AddItem(path="event.actions", item=shot))
    waiting.workbench.post(commands.ApplyEdits(edits, "out of the picture"))
    mark = waiting.page.locator(".tl g.out .badge")
    expect(mark).to_be_visible(timeout=20_000)
    words = waiting.page.locator(".tl [data-action=shot] text")
    expect(words).not_to_be_empty()
    there, said = mark.bounding_box(), words.bounding_box()
    assert there is not None
    assert said is not None
    assert abs(there["y"] - said["y"]) < 10
    assert said["x"] >= there["x"] + there["width"]


def test_what_can_be_selected_is_listed_where_nothing_is(waiting: Desk) -> None:
    page, name = waiting.page, waiting.snapshot.program.scene.objects[0].name
    listed = page.locator("#page-inspector").get_by_role("button").first
    expect(listed).to_contain_text(name.replace("_", " "))
    listed.focus()
    page.keyboard.press("Enter")
    waiting.until(lambda: waiting.studio.view.selection.name == name, "the selection")
    expect(page.locator("#page-inspector .title")).to_have_text(name.replace("_", " "))


def test_drag_a_bar_and_resize_it(waiting: Desk) -> None:
    bar = _bar(waiting)
    name = bar.get_attribute("data-action")
    action = waiting.snapshot.program.action(name)
    assert action is not None
    before = _positions(waiting)
    box = waiting.box(bar.locator(".body"))
    frame = _per_frame(waiting)
    _drag(waiting, box["x"] + box["width"] / 2, box["y"] + 8, 10 * frame)
    waiting.until(lambda: waiting.snapshot.has_draft, "a draft")
    waiting.idle()
    moved = waiting.snapshot.program.action(name)
    assert moved is not None
    assert moved.start_step == action.start_step + 40
    assert not np.array_equal(before, _positions(waiting))
    expect(bar).to_have_attribute("data-start", str(moved.start_step))

    before = _positions(waiting)
    edge = waiting.box(bar.locator("[data-edge=end]"))
    _drag(waiting, edge["x"] + edge["width"] - 2, edge["y"] + 8, 6 * frame)
    waiting.until(
        lambda: waiting.snapshot.program.action(name).duration != action.duration,  # type: ignore[union-attr]
        "another duration",
    )
    waiting.idle()
    assert not np.array_equal(before, _positions(waiting))


def test_a_drag_is_run_while_it_goes_on_and_is_one_step_to_undo(waiting: Desk) -> None:
    page = waiting.page
    bar = _bar(waiting)
    name = bar.get_attribute("data-action")
    before = waiting.snapshot
    box = waiting.box(bar.locator(".body"))
    frame = _per_frame(waiting)
    x, y = box["x"] + box["width"] / 2, box["y"] + 8
    page.mouse.move(x, y)
    page.mouse.down()
    page.mouse.move(x + 6 * frame, y, steps=4)
    tried = waiting.until(
        lambda: waiting.snapshot.attempt and waiting.snapshot.attempt.rollout, "a run in the drag"
    )
    expect(page.locator(".tl .tip")).to_contain_text("hold")
    page.mouse.move(x + 12 * frame, y, steps=4)
    waiting.until(
        lambda: waiting.snapshot.attempt and waiting.snapshot.attempt.rollout is not tried,
        "another run in the drag",
    )
    assert not waiting.snapshot.has_draft
    page.mouse.up()
    waiting.until(lambda: waiting.snapshot.has_draft, "a draft")
    waiting.idle()
    assert waiting.snapshot.attempt is None
    assert waiting.snapshot.program.action(name) != before.program.action(name)
    page.keyboard.press("Control+z")
    waiting.until(lambda: waiting.snapshot.program == before.program, "one step back")
    start = str(before.program.action(name).start_step)  # type: ignore[union-attr]
    expect(bar).to_have_attribute("data-start", start)

    # Escape lets go: nothing has happened.
    page.mouse.move(x, y)
    page.mouse.down()
    page.mouse.move(x + 6 * frame, y, steps=4)
    waiting.until(lambda: waiting.snapshot.attempt, "a run in the drag")
    page.keyboard.press("Escape")
    waiting.until(lambda: waiting.snapshot.attempt is None, "its end")
    page.mouse.up()
    waiting.idle()
    assert waiting.snapshot.program == before.program


def test_slow_motion_is_chosen_by_keyboard_is_one_step_and_stays(waiting: Desk) -> None:
    page = waiting.page
    before = waiting.snapshot.program
    pace = page.locator(".tl .pace")
    expect(pace).to_have_attribute("aria-label", re.compile("^Pace: "))
    expect(page.locator(".tl .motion")).to_have_attribute("aria-label", re.compile("moves|move"))
    pace.focus()
    page.keyboard.press("Enter")
    choice = page.get_by_label("Pace of the clip")
    choice.select_option(label="1/4 of real time")
    waiting.until(lambda: waiting.snapshot.program.clip.time_factor == 0.25, "slow motion")
    waiting.idle()
    assert waiting.snapshot.state.pinned == PACE
    expect(pace).to_contain_text("0.25 ×")
    expect(waiting.button("Unpin: the planner may choose the pace")).to_be_visible()
    page.get_by_label("Time factor").fill("9")
    page.get_by_label("Time factor").press("Enter")
    expect(page.get_by_label("Time factor")).to_have_class("wrong")
    page.get_by_role("button", name="Undo (Ctrl+Z)").click()
    waiting.until(lambda: waiting.snapshot.program == before, "the pace before")
    waiting.idle()
    assert waiting.snapshot.state.pinned == ()


@pytest.mark.slow
def test_undo_and_redo_ten_steps_back_to_the_same_program(waiting: Desk) -> None:
    page = waiting.page
    bar = _bar(waiting)
    bar.locator(".body").click()
    bar.focus()
    first = waiting.snapshot.program.hash
    hashes = [first]
    for _ in range(10):
        page.keyboard.press("ArrowRight")
        waiting.until(lambda: waiting.snapshot.program.hash != hashes[-1], "a move")
        hashes.append(waiting.snapshot.program.hash)
    page.keyboard.press("Escape")
    for wanted in reversed(hashes[:-1]):
        page.keyboard.press("Control+z")
        waiting.until(lambda wanted=wanted: waiting.snapshot.program.hash == wanted, "undone")
    for wanted in hashes[1:]:
        page.keyboard.press("Control+Shift+z")
        waiting.until(lambda wanted=wanted: waiting.snapshot.program.hash == wanted, "redone")


def test_add_mute_and_delete_by_menu(waiting: Desk) -> None:
    page = waiting.page
    _bar(waiting)
    count = len(waiting.snapshot.program.event.actions)
    page.get_by_role("button", name="Add an action").click()
    page.get_by_role("menuitem").nth(4).click()
    waiting.until(lambda: len(waiting.snapshot.program.event.actions) == count + 1, "an action")
    added = waiting.snapshot.program.event.actions[-1]
    bar = page.locator(f"[data-action={added.id}]")
    bar.click(button="right")
    page.get_by_role("menuitem", name="Mute").click()
    waiting.until(lambda: waiting.snapshot.program.event.actions[-1].muted, "muted")
    bar.focus()
    page.keyboard.press("Delete")
    waiting.until(lambda: len(waiting.snapshot.program.event.actions) == count, "deleted")


def test_a_refused_edit_snaps_back_with_the_reason(waiting: Desk) -> None:
    """Round one is read-only once another round exists and the first is opened."""
    page = waiting.page
    bar = _bar(waiting)
    name = bar.get_attribute("data-action")
    start = bar.get_attribute("data-start")
    page.evaluate(
        """async name => {
            const wire = await import('/wire.js');
            const refused = () => { document.body.dataset.refused = 'yes'; };
            wire.setField(`event.actions.${name}.duration`, 100000, refused);
        }""",
        name,
    )
    expect(page.get_by_text("run past the end of the clip")).to_be_visible()
    expect(page.locator("body")).to_have_attribute("data-refused", "yes")
    expect(bar).to_have_attribute("data-start", start)
    assert not waiting.snapshot.has_draft


def test_playing_moves_the_playhead_and_a_scrub_stops_it(waiting: Desk) -> None:
    page = waiting.page
    _bar(waiting)
    line = page.locator(".tl .head-line")
    x = float(line.get_attribute("x1") or 0)
    page.keyboard.press("Space")
    waiting.until(lambda: waiting.studio.view.step > 20, "playing")
    waiting.until(lambda: float(line.get_attribute("x1") or 0) != x, "a moved playhead")
    box = waiting.box(page.locator("svg.tl"))
    page.mouse.click(box["x"] + box["width"] * 0.6, box["y"] + 5)
    waiting.until(lambda: not waiting.studio.view.playing, "a stop")
    page.keyboard.press("Home")
    waiting.until(lambda: waiting.studio.view.step == 0, "the start")


def test_the_pointer_moves_on_before_a_drop_is_answered(waiting: Desk) -> None:
    """All in one turn of the page's loop, so no answer can come in between."""
    page = waiting.page
    bar = _bar(waiting)
    name = bar.get_attribute("data-action")
    action = waiting.snapshot.program.action(name)
    assert action is not None
    box = waiting.box(bar.locator(".body"))
    x, y = box["x"] + box["width"] / 2, box["y"] + 8
    page.mouse.move(x, y)
    page.mouse.down()
    page.evaluate(
        """([x, y, by]) => {
            const svg = document.querySelector('svg.tl');
            const at = (kind, x) => svg.dispatchEvent(
                new PointerEvent(kind, { clientX: x, clientY: y, pointerId: 1, bubbles: true }));
            at('pointermove', x + by);
            at('pointerup', x + by);
            at('pointermove', x + 3 * by);
            at('pointerup', x + 3 * by);
        }""",
        [x, y, 10 * _per_frame(waiting)],
    )
    page.mouse.up()
    waiting.until(lambda: waiting.snapshot.has_draft, "a draft")
    waiting.idle()
    moved = waiting.snapshot.program.action(name)
    assert moved is not None
    assert moved.start_step == action.start_step + 40


CONDITIONAL = """
scene:
  objects:
    - {name: ball, shape: {kind: sphere, radius: 0.1}, position: [0, 2, 0.5], support: air}
    - {name: cube, shape: {kind: box, size: [0.2, 0.2, 0.2]}, position: [1, 2, 0.1], support: floor}
  supports:
    - {name: floor, shape: {kind: floor}}
event:
  prompt: The ball falls, then the cube is pushed.
  actions:
    - operator: ApplyForce
      id: shove
      name: cube
      force: {magnitude: 2, direction: right, quantity: target_speed}
      duration: 20
      when: {kind: on_contact, a: ball, b: floor, delay: 8}
    - operator: ApplyTorque
      id: twist
      name: cube
      torque: [0, 0, 0.1]
      start_step: 40
      duration: 20
"""


def test_a_conditional_start_shows_its_cause_and_moves_by_its_delay(waiting: Desk) -> None:
    page = waiting.page
    waiting.workbench.post(commands.OpenProgram(load_program(CONDITIONAL), "conditional"))
    link = page.locator("[data-link=shove] .link-line")
    expect(link).to_be_attached()
    waiting.idle()  # what is dragged before the page knows of the opening is refused as stale
    # What overlaps in one lane stands in rows of its own.
    shove, twist = (page.locator(f"[data-action={name}] .body") for name in ("shove", "twist"))
    one, other = waiting.box(shove), waiting.box(twist)
    assert abs(one["y"] - other["y"]) >= one["height"]
    box, frame = one, _per_frame(waiting)
    _drag(waiting, box["x"] + box["width"] / 2, box["y"] + 8, 3 * frame)

    def delay() -> int:
        action = waiting.snapshot.program.action("shove")
        assert action is not None
        assert action.when is not None
        return action.when.delay

    waiting.until(lambda: delay() > 8, "a longer delay")
    assert 8 < delay() <= 8 + 16
    # A right-click on a lane adds something to that object, there.
    count = len(waiting.snapshot.program.event.actions)
    lane = waiting.box(page.locator("svg.tl rect.lane").first)
    page.mouse.click(lane["x"] + lane["width"] * 0.6, lane["y"] + 8, button="right")
    page.get_by_role("menuitem", name="Push ball").click()
    waiting.until(lambda: len(waiting.snapshot.program.event.actions) == count + 1, "an action")
    assert waiting.snapshot.program.event.actions[-1].start_step > 100
