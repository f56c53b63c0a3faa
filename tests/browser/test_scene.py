"""The 3D scene itself: poses reach the screen, clicks select, arrows and gizmos edit."""

from __future__ import annotations

import numpy as np
import pytest
from playwright.sync_api import expect

from physagent_studio.assets import assets_dir
from physagent_studio.workbench import commands
from tests.browser.conftest import Desk
from tests.browser.in_scene import POSE, pixel_of, pose_of, pull, view_of

pytestmark = pytest.mark.browser


def test_scene_shows_selects_and_edits(drawn: Desk) -> None:
    page = drawn.page
    view = view_of(drawn)
    rollout = drawn.snapshot.rollout
    assert rollout is not None
    action = drawn.snapshot.program.event.actions[0]
    name = action.name
    at = rollout.objects.index(name)

    def stands_at(step: int) -> bool:
        pose = pose_of(view, name)
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
    box = drawn.box(page.locator("#viewer"))

    def matches() -> bool:
        x, y = pixel_of(drawn, view, rollout.positions[0, at])
        scale = min(box["width"] / width, box["height"] / rows)
        want_x = box["x"] + box["width"] / 2 + (seen[0, 0] - width / 2) * scale
        want_y = box["y"] + box["height"] / 2 + (seen[0, 1] - rows / 2) * scale
        return abs(x - want_x) < 4 and abs(y - want_y) < 4

    drawn.until(matches, "the photo's view")

    # A click selects; the inspector follows.
    def select() -> bool:
        page.mouse.click(*pixel_of(drawn, view, rollout.positions[0, at]))
        page.wait_for_timeout(400)
        return drawn.studio.view.selection.name == name

    drawn.until(select, "the selection")
    expect(page.locator("#page-inspector .title")).to_have_text(name.replace("_", " "))

    # Dragging the tip of the action's arrow changes the vector that the next round runs.
    page.locator(f".tl [data-action={action.id}] .body").click()
    grip = f"/marks/tip action {action.id}"
    drawn.until(lambda: view.evaluate(POSE, grip), "the arrow's tip")
    before = drawn.snapshot.program
    tip = np.array(view.evaluate(POSE, grip))

    pull(drawn, lambda: pixel_of(drawn, view, tip), (40, 10), lambda: drawn.snapshot.has_draft)
    drawn.idle()
    changed = drawn.snapshot.program.action(action.id)
    assert changed is not None
    assert changed != before.action(action.id)
    value = getattr(changed, "force", getattr(changed, "velocity", None))
    assert isinstance(value, tuple)
    assert np.isfinite(value).all()


@pytest.mark.slow
def test_handles_move_scale_and_wish(drawn: Desk) -> None:
    """What is dragged at the start is one edit each; later it is a wish, then a proposal."""
    page = drawn.page
    view = view_of(drawn)
    name = drawn.snapshot.program.event.actions[0].name
    item = drawn.snapshot.program.scene.object(name)
    assert item is not None
    assert item.position is not None
    first, place = drawn.snapshot.program, np.array(item.position)
    page.evaluate(
        """name => import('/wire.js').then(wire => {
            wire.send({do: 'select', kind: 'object', name});
            wire.send({do: 'show', what: 'gizmo', on: true});
        })""",
        name,
    )
    drawn.until(lambda: view.evaluate(POSE, "/selection/gizmo"), "a gizmo")
    radius: float = item.shape.radius  # type: ignore[union-attr]
    arm = np.array([radius * 2.2 * 0.75, 0, 0])  # on the gizmo's arm to the right

    def drafted() -> bool:
        return drawn.snapshot.has_draft

    def at_place(node: str) -> bool:
        return bool(np.allclose(view.evaluate(POSE, node) or np.inf, place, atol=1e-4))

    def undone() -> None:
        drawn.button("Undo (Ctrl+Z)").click()
        drawn.until(lambda: drawn.snapshot.program == first, "one step back")
        # Until the page shows it, the handles of where the object was lie under the pointer.
        for node in ("/selection/gizmo", "/selection/frame"):
            drawn.until(lambda node=node: at_place(node), f"{node} back at its place")

    pull(drawn, lambda: pixel_of(drawn, view, place + arm), (40, 0), drafted)
    drawn.idle()
    moved = drawn.snapshot.program.scene.object(name)
    assert moved is not None
    assert moved.position is not None
    assert moved.position[0] > item.position[0] + 0.005
    assert moved.position[1:] == pytest.approx(item.position[1:], abs=1e-4)
    assert drawn.snapshot.attempt is None
    undone()

    # The corner of the frame makes it larger, and it keeps standing on the floor.
    grip = "/selection/frame/all"
    drawn.until(lambda: view.evaluate(POSE, grip), "a corner to pull")
    corner = place + np.array(view.evaluate(POSE, grip))
    pull(drawn, lambda: pixel_of(drawn, view, corner), (22, -18), drafted)
    drawn.idle()
    larger = drawn.snapshot.program.scene.object(name)
    assert larger is not None
    assert larger.position is not None
    old, new = item.shape.radius, larger.shape.radius  # type: ignore[union-attr]
    assert new > old * 1.1
    assert larger.position[2] - item.position[2] == pytest.approx(new - old, abs=1e-3)
    undone()

    # Later in the clip the same handle says where it should be.
    old_proposal = drawn.proposal()
    rollout = drawn.snapshot.rollout
    assert rollout is not None
    page.evaluate("import('/wire.js').then(wire => wire.scrub(6))")
    then = rollout.positions[24, rollout.objects.index(name)]
    drawn.until(
        lambda: np.allclose(view.evaluate(POSE, "/selection/gizmo") or 0, then, atol=1e-4),
        "the gizmo where the ball is",
    )

    def answered() -> bool:
        busy, current = drawn.snapshot.busy, drawn.snapshot.state.current
        return bool(busy or (current and current.proposal and current.proposal != old_proposal))

    pull(drawn, lambda: pixel_of(drawn, view, then + arm), (25, 0), answered)
    drawn.idle()
    assert not drawn.snapshot.has_draft
    words = f"You put {name.replace('_', ' ')}"
    expect(page.get_by_role("group", name="Proposal")).to_contain_text(words)


GLASS = """name => {
  let found = false;
  window.__viserMutable.nodeRefFromName[name]?.traverse((one) => {
    found ||= one.isMesh && one.material.transparent && one.material.opacity < 0.5;
  });
  return found;
}"""
EYE = "() => window.__viserMutable.camera.position.toArray()"


def _steady(eyes: list[list[float]], eye: list[float]) -> bool:
    """Whether the eye, noted with those before, has been where it is for half a second."""
    eyes.append(eye)
    return len(eyes) > 20 and np.allclose(eyes[-20:], eye, atol=1e-4)


@pytest.mark.slow
def test_things_are_seen_through_and_the_camera_is_reset_with_a_session(drawn: Desk) -> None:
    page, view = drawn.page, view_of(drawn)
    thing = f"/objects/{drawn.snapshot.program.scene.objects[0].name}"
    drawn.tab("Scene")
    for on in (True, False):
        page.get_by_label("See-through things").set_checked(on)
        drawn.until(lambda on=on: view.evaluate(GLASS, thing) == on, f"glass: {on}")
    page.keyboard.press("0")
    eyes: list[list[float]] = []
    drawn.until(lambda: _steady(eyes, view.evaluate(EYE)), "the photo's camera, at rest")
    first, session = eyes[-1], drawn.snapshot.session_id
    page.keyboard.press("t")
    drawn.until(lambda: not np.allclose(view.evaluate(EYE), first, atol=0.1), "the view from above")
    # The same event in another session begins at the photo's own camera again.
    drawn.workbench.post(commands.OpenCase(assets_dir() / "demo", "only_the_cube"))
    drawn.until(lambda: drawn.snapshot.session_id != session, "another session")
    drawn.idle()
    drawn.until(lambda: np.allclose(view.evaluate(EYE), first, atol=1e-2), "the photo's camera")
