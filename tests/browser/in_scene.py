"""Hands in the 3D scene: where a world point is on the page, and drags that take hold."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from playwright.sync_api import Frame

from tests.browser.conftest import DRAWN, Desk

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


def view_of(desk: Desk) -> Frame:
    """The viewer's own page, once it draws."""

    def found() -> Frame | None:
        for frame in desk.page.frames:
            if "/viewer/" in frame.url and frame.evaluate(
                "() => Boolean(window.__viserMutable?.camera)"
            ):
                return frame
        return None

    return desk.until(found, "a 3D view")


def pose_of(view: Frame, name: str) -> list[float] | None:
    return view.evaluate(POSE, f"/objects/{name}")


def pixel_of(desk: Desk, view: Frame, point: Any) -> tuple[float, float]:
    """Where a world point is on the page."""
    x, y = view.evaluate(PIXEL, [float(part) for part in point])
    box = desk.box(desk.page.locator("#viewer"))
    return box["x"] + x, box["y"] + y


def looked(desk: Desk) -> None:
    """Until the viewer has drawn, and so looked where the pointer is."""
    desk.page.wait_for_timeout(150)
    view_of(desk).evaluate(DRAWN)


def pull(desk: Desk, start: Callable[[], Any], by: tuple[float, float], done: Callable) -> Any:
    """Drags as a hand does, slowly, from where `start` is on the page, until it has an effect.

    The viewer looks once a frame where the pointer is, and a frame takes long when drawn in
    software, so a first try may miss the handle.
    """
    mouse, page = desk.page.mouse, desk.page
    for _ in range(8):
        x, y = start()
        mouse.move(x, y)
        looked(desk)
        mouse.down()
        mouse.move(x + by[0] * 0.7, y + by[1] * 0.7, steps=3)
        mouse.move(x + by[0], y + by[1], steps=2)
        looked(desk)
        mouse.up()
        looked(desk)
        for _ in range(100):
            if found := done():
                return found
            page.wait_for_timeout(25)
        desk.idle()
        if found := done():
            return found
    raise AssertionError(f"no drag by {by} had an effect")
