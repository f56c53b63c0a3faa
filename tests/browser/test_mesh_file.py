"""An object from a mesh file, by clicks alone: chosen, sized, set down, run, undone."""

from __future__ import annotations

import numpy as np
import pytest
import trimesh
from playwright.sync_api import FilePayload, expect

from tests.browser.conftest import Desk

pytestmark = pytest.mark.browser


def _glb(made: trimesh.Trimesh) -> bytes:
    data = made.export(file_type="glb")
    assert isinstance(data, bytes)
    return data


def _choose(desk: Desk, name: str, data: bytes) -> None:
    file: FilePayload = {"name": name, "mimeType": "model/gltf-binary", "buffer": data}
    desk.page.get_by_label("Mesh file", exact=True).set_input_files([file])


def test_an_object_from_a_mesh_file(waiting: Desk) -> None:
    page = waiting.page
    before = waiting.snapshot.program
    waiting.tab("Scene")
    waiting.button("Mesh file…").click()
    dialog = page.get_by_role("dialog", name="Object from a mesh file")
    expect(dialog.get_by_role("button", name="Add to the scene")).to_be_disabled()

    # What is no mesh is refused with a sentence, and the next file may follow.
    _choose(waiting, "notes.glb", b"glTF but not really")
    expect(dialog.get_by_role("alert")).to_contain_text("notes.glb is no GLB file")
    _choose(waiting, "bomb.stl", b"PK\x03\x04" + b"\0" * 200)
    expect(dialog.get_by_role("alert")).to_contain_text("compressed archive")
    holed = b"v 0 0 0\nv 1 0 0\nv nan 1 0\nf 1 2 3\n"
    _choose(waiting, "nan.obj", holed)
    expect(dialog.get_by_role("alert")).to_contain_text("not finite")

    # A cone, y up, larger than anything here: the file's own size is not believed.
    cone = trimesh.creation.cone(radius=40, height=100, sections=24)
    cone.apply_transform(trimesh.transformations.rotation_matrix(-np.pi / 2, [1, 0, 0]))
    _choose(waiting, "traffic cone.glb", _glb(cone))
    expect(dialog.get_by_text("faces")).to_be_visible()
    expect(dialog.get_by_role("alert")).to_have_count(0)
    expect(dialog.get_by_label("Name", exact=True)).to_have_value("traffic_cone")
    edge = dialog.get_by_label("Longest edge")
    edge.fill("much")
    expect(dialog.get_by_role("button", name="Add to the scene")).to_be_disabled()
    edge.fill("0.12")
    expect(dialog.get_by_text("It will be 0.096 × 0.096 × 0.12 m")).to_be_visible()
    dialog.get_by_role("button", name="Add to the scene").click()

    waiting.until(lambda: waiting.snapshot.program.scene.object("traffic_cone"), "the cone")
    waiting.idle()
    expect(page.locator("#page-inspector .title")).to_have_text("traffic cone")
    shown = waiting.snapshot
    item = shown.program.scene.object("traffic_cone")
    assert item is not None
    assert item.shape is not None
    assert item.shape.kind == "mesh"
    assert item.shape.size == pytest.approx((0.096, 0.096, 0.12), rel=0.02)
    assert item.support is not None
    assert item.position is not None
    assert shown.rollout is not None
    at = shown.rollout.objects.index("traffic_cone")
    heights = shown.rollout.positions[:, at, 2]
    assert np.abs(heights - item.position[2]).max() < 0.005, "it stands"
    assert shown.scene is not None
    assert len(shown.scene.meshes["traffic_cone"].faces) >= 24

    waiting.button("Run my edits").click()
    waiting.until(lambda: len(waiting.snapshot.state.rounds) == 2, "a round with it")
    waiting.idle()
    waiting.button("Undo (Ctrl+Z)").click()
    waiting.button("Undo (Ctrl+Z)").click()
    waiting.until(lambda: waiting.snapshot.program == before, "the program before")


def test_on_the_table_that_is_selected(waiting: Desk) -> None:
    page = waiting.page
    waiting.empty_scene()
    waiting.button("Table").click()
    waiting.until(lambda: waiting.snapshot.program.scene.support("table"), "a table")
    expect(page.locator("#page-inspector .title")).to_have_text("table")
    waiting.tab("Scene")
    waiting.button("Mesh file…").click()
    _choose(waiting, "die.glb", _glb(trimesh.creation.box((0.1, 0.1, 0.1))))
    dialog = page.get_by_role("dialog")
    expect(dialog.get_by_text("standing on table")).to_be_visible()
    dialog.get_by_label("Longest edge").press("Enter")
    waiting.until(lambda: waiting.snapshot.program.scene.object("die"), "a die")
    waiting.idle()
    table = waiting.snapshot.program.scene.support("table")
    die = waiting.snapshot.program.scene.object("die")
    assert table is not None
    assert table.shape is not None
    assert table.shape.kind == "box"
    assert die is not None
    assert die.position is not None
    assert die.support == "table"
    top = table.shape.position[2] + table.shape.size[2] / 2
    assert die.position[2] == pytest.approx(top + 0.05, abs=1e-3)
    rollout = waiting.snapshot.rollout
    assert rollout is not None
    assert rollout.positions[-1, rollout.objects.index("die"), 2] == pytest.approx(
        top + 0.05, abs=5e-3
    )
