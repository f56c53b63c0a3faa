"""The 3D scene itself: poses reach the screen, clicks select, arrows and gizmos edit."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from playwright.sync_api import Frame, expect

from tests.browser.conftest import Desk

pytestmark = pytest.mark.browser

PIXEL = """([x, y, z]) => {
  const m = window.__viserMutable, root = m.nodeRefFromName[''];
  const v = m.camera.position.clone().set(x, y, z);
  root.localToWorld(v); v.project(m.camera);
  const c = m.canvas.getBoundingClientRect();
  return [c.x + (v.x + 1) / 2 * c.width, c.y + (1 - v.y) / 2 * c.height];
}"""
POSE = """name => {
  const node = window.__viserMutable?.nodeRefFromName?.[name];
  return node ? node.position.toArray() : null;
}"""


def _view(desk: Desk) -> Frame:
    """The viewer's own page, once it draws."""

    def found() -> Frame | None:
        for frame in desk.page.frames:
            if "/viewer/" in frame.url and frame.evaluate(
                "() => Boolean(window.__viserMutable?.camera)"
            ):
                return frame
        return None

    return desk.until(found, "a 3D view")


def _pose(view: Frame, name: str) -> list[float] | None:
    return view.evaluate(POSE, f"/objects/{name}")


def _pixel(desk: Desk, view: Frame, point: Any) -> tuple[float, float]:
    """Where a world point is on the page."""
    x, y = view.evaluate(PIXEL, [float(part) for part in point])
    box = desk.page.locator("#viewer").bounding_box()
    assert box is not None
    return box["x"] + x, box["y"] + y


def test_scene_shows_selects_and_edits(drawn: Desk) -> None:
    page, workbench = drawn.page, drawn.workbench
    view = _view(drawn)
    rollout = drawn.snapshot.rollout
    assert rollout is not None
    action = drawn.snapshot.program.event.actions[0]
    name = action.name
    at = rollout.objects.index(name)

    def stands_at(step: int) -> bool:
        pose = _pose(view, name)
        return pose is not None and bool(np.allclose(pose, rollout.positions[step, at], atol=1e-4))

    drawn.until(lambda: stands_at(0), "the object at its place")
    page.keyboard.press("End")
    drawn.until(lambda: stands_at(rollout.steps), "the object at the end")
    page.keyboard.press("Home")
    drawn.until(lambda: stands_at(0), "the object back")

    # The photo's own camera: the object is drawn where the photo has it.
    camera = drawn.snapshot.program.scene.camera
    assert camera is not None
    seen, _ = camera.project(rollout.positions[:1, at])
    width, rows = camera.size
    box = page.locator("#viewer").bounding_box()
    assert box is not None

    def matches() -> bool:
        x, y = _pixel(drawn, view, rollout.positions[0, at])
        scale = min(box["width"] / width, box["height"] / rows)
        want_x = box["x"] + box["width"] / 2 + (seen[0, 0] - width / 2) * scale
        want_y = box["y"] + box["height"] / 2 + (seen[0, 1] - rows / 2) * scale
        return abs(x - want_x) < 4 and abs(y - want_y) < 4

    drawn.until(matches, "the photo's view")

    # A click selects; the inspector follows.
    def select() -> bool:
        page.mouse.click(*_pixel(drawn, view, rollout.positions[0, at]))
        page.wait_for_timeout(400)
        return drawn.studio.view.selection.name == name

    drawn.until(select, "the selection")
    expect(page.locator("#page-inspector .title")).to_have_text(name)

    # Dragging the tip of the action's arrow changes the vector that the next round runs.
    page.locator(f".tl [data-action={action.id}] .body").click()
    grip = f"/marks/tip action {action.id}"
    drawn.until(lambda: view.evaluate(POSE, grip), "the arrow's tip")
    before = drawn.snapshot.program
    tip = np.array(view.evaluate(POSE, grip))

    def drag() -> bool:
        x, y = _pixel(drawn, view, tip)
        page.mouse.move(x, y)
        page.wait_for_timeout(150)
        page.mouse.down()
        page.mouse.move(x + 30, y + 8, steps=6)
        page.mouse.move(x + 40, y + 10, steps=3)
        page.wait_for_timeout(150)
        page.mouse.up()
        page.wait_for_timeout(500)
        return drawn.snapshot.has_draft

    drawn.until(drag, "another vector")
    assert workbench.wait(60)
    changed = drawn.snapshot.program.action(action.id)
    assert changed is not None
    assert changed != before.action(action.id)
    value = getattr(changed, "force", getattr(changed, "velocity", None))
    assert isinstance(value, tuple)
    assert np.isfinite(value).all()
