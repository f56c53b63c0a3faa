"""Hands in a scene without a photo: a thing is turned, arrows are pulled by their tips."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest
from playwright.sync_api import Browser

from physagent_studio.program.text.document import load_program
from physagent_studio.session import Store
from physagent_studio.workbench import Workbench, commands
from tests.browser.conftest import PATIENCE, Desk, running
from tests.browser.in_scene import POSE, pixel_of, pull, view_of

pytestmark = pytest.mark.browser

PROGRAM = """
scene:
  objects:
    - {name: ball, shape: {kind: sphere, radius: 0.1}, position: [-0.6, 2, 0.1], support: floor}
    - {name: box, shape: {kind: box, size: [0.3, 0.2, 0.2]}, position: [0.4, 2, 0.1]}
  supports: [{name: floor, shape: {kind: floor}}]
event:
  prompt: The ball rolls.
  actions:
    - {operator: SetVelocity, id: roll, name: ball, velocity: [0.6, 0, 0], start_step: 0}
    - {operator: ApplyForce, id: push, name: box, force: [15, 0, 0], start_step: 0, duration: 60}
"""


@pytest.fixture
def built(tmp_path: Path, browser: Browser) -> Iterator[Desk]:
    """A program of two things, opened without a photo, its scene drawn."""
    workbench = Workbench(Store(tmp_path), evidence=False)
    workbench.post(commands.OpenProgram(load_program(PROGRAM), "two things"))
    assert workbench.wait(PATIENCE)
    workbench.close()
    yield from running(tmp_path, browser, Store(tmp_path).list()[0].id, scene=True)


def test_a_thing_is_turned_by_its_handle(built: Desk) -> None:
    page, view = built.page, view_of(built)
    first = built.snapshot.program
    page.evaluate(
        """import('/wire.js').then(wire => {
            wire.send({do: 'select', kind: 'object', name: 'box'});
            wire.send({do: 'show', what: 'gizmo', on: true});
            wire.send({do: 'look', view: 'top'});
        })"""
    )
    built.until(lambda: view.evaluate(POSE, "/selection/gizmo"), "a gizmo")
    # The arc about z lies between the arms along x and y; its radius is part of their length.
    half = np.array([0.15, 0.1, 0.1])
    radius = 0.65 * 2.2 * float(np.linalg.norm(half))
    middle = np.array([0.4, 2.0, 0.1])
    arc = middle + radius * np.array([np.sqrt(0.5), np.sqrt(0.5), 0])

    def turned() -> bool:
        item = built.snapshot.program.scene.object("box")
        return item is not None and abs(item.rotation[3]) > 0.05

    pull(built, lambda: pixel_of(built, view, arc), (-30, -8), turned)
    built.idle()
    item = built.snapshot.program.scene.object("box")
    assert item is not None
    w, x, y, z = item.rotation
    assert (x, y) == pytest.approx((0, 0), abs=1e-4), "about the upright axis alone"
    assert w * w + z * z == pytest.approx(1, abs=1e-4)
    assert z > 0, "against the clock, as the hand went"
    assert item.position == pytest.approx(tuple(middle), abs=1e-4)
    rollout = built.snapshot.rollout
    assert rollout is not None
    assert rollout.rotations[0, rollout.objects.index("box")] == pytest.approx(item.rotation)
    built.button("Undo (Ctrl+Z)").click()
    built.until(lambda: built.snapshot.program == first, "one step back")


@pytest.mark.parametrize(("action", "field"), [("roll", "velocity"), ("push", "force")])
def test_the_tip_of_an_arrow_is_pulled(built: Desk, action: str, field: str) -> None:
    page, view = built.page, view_of(built)
    before = built.snapshot.program.action(action)
    page.locator(f".tl [data-action={action}] .body").click()
    grip = f"/marks/tip action {action}"
    built.until(lambda: view.evaluate(POSE, grip), "the arrow's tip")

    def changed() -> bool:
        return built.snapshot.program.action(action) != before

    tip = np.array(view.evaluate(POSE, grip))
    pull(built, lambda: pixel_of(built, view, tip), (45, 0), changed)
    built.idle()
    after = built.snapshot.program.action(action)
    old, new = np.array(getattr(before, field)), np.array(getattr(after, field))
    assert new[0] > old[0] * 1.1, "longer to the right"
    assert np.abs(new[1:]).max() < 0.4 * new[0], "and about along the ground"
    assert built.snapshot.attempt is None
    first = built.snapshot.rollout
    built.button("Undo (Ctrl+Z)").click()
    built.until(lambda: built.snapshot.program.action(action) == before, "one step back")
    built.idle()
    at = {"roll": 0, "push": 1}[action]
    assert first is not None
    assert built.snapshot.rollout is not None
    assert first.positions[60, at, 0] > built.snapshot.rollout.positions[60, at, 0]
