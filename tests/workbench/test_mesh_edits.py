"""Meshes from files set down in a session: placed, run, scaled, undone, kept."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
import trimesh

from physagent_studio.errors import InputError
from physagent_studio.program import SetField, value_at
from physagent_studio.program.text.document import load_program
from physagent_studio.session import Store
from physagent_studio.workbench import Workbench, commands
from physagent_studio.workbench.mesh_edits import name_for, read_form
from tests.workbench.test_workbench import PROGRAM, after, bench, opened

__all__ = ["bench"]


def wedge(file: str, height: float = 0.3) -> bytes:
    """A wedge whose file says y is up: 0.6 × `height` × 0.2, lowest at y = 0."""
    points = [(0, 0), (0.6, 0), (0, height)]
    corners = np.array([[x, y, z] for z in (-0.1, 0.1) for x, y in points])
    made = trimesh.Trimesh(corners).convex_hull.export(file_type=file[-3:])
    return made.encode() if isinstance(made, str) else made


def added(workbench: Workbench, longest: float = 0.6) -> commands.AddMesh:
    form = read_form(wedge("my wedge.glb"), "my wedge.glb")
    body = form.body("wedge", longest, form.up)
    return commands.AddMesh("wedge", body, (3.0, 2.0, 0.0), "floor")


def test_it_stands_on_its_foot_runs_and_is_undone(bench: Workbench) -> None:
    before = opened(bench).program
    shown = after(bench, added(bench))
    item = shown.program.scene.object("wedge")
    assert item is not None
    assert item.shape is not None
    assert item.shape.kind == "mesh"
    assert item.shape.size == pytest.approx((0.6, 0.2, 0.3))
    assert item.position is not None
    assert shown.scene is not None
    mesh = shown.scene.meshes["wedge"]
    assert mesh.vertices[:, 2].min() + item.position[2] == pytest.approx(0.0, abs=1e-9)
    assert item.position[2] == pytest.approx(0.1, abs=1e-6)  # a third of its height
    assert shown.rollout is not None
    at = shown.rollout.objects.index("wedge")
    # A wedge on its base rests; a box of its size would weigh twice as much.
    assert np.abs(shown.rollout.positions[:, at] - item.position).max() < 0.005
    assert shown.rollout.masses[at] == pytest.approx(0.5 * 0.6 * 0.2 * 0.3 * 1050, rel=0.15)
    assert after(bench, commands.Undo()).program == before
    assert after(bench, commands.Redo()).program.scene.object("wedge") == item


def test_another_size_stretches_what_is_kept(bench: Workbench) -> None:
    opened(bench)
    after(bench, added(bench))
    edit = SetField(path="scene.objects.wedge.shape.size", value=[1.2, 0.2, 0.3])
    shown = after(bench, commands.ApplyEdits((edit,)))
    assert shown.scene is not None
    assert np.ptp(shown.scene.meshes["wedge"].vertices, axis=0) == pytest.approx([1.2, 0.2, 0.3])


def test_it_is_there_after_a_restart_and_in_a_copy(bench: Workbench, tmp_path: Path) -> None:
    opened(bench)
    held = after(bench, added(bench))
    assert held.session_id is not None
    bench.close()
    store = Store(tmp_path)
    for name in (held.session_id, store.duplicate(held.session_id)):
        again = Workbench(store, evidence=False)
        shown = after(again, commands.OpenSession(name))
        again.close()
        assert shown.program == held.program
        assert shown.scene is not None
        assert held.scene is not None
        kept, first = shown.scene.meshes["wedge"], held.scene.meshes["wedge"]
        assert np.array_equal(kept.vertices, first.vertices)


def test_a_mesh_from_elsewhere_is_refused_in_a_sentence(bench: Workbench) -> None:
    before = opened(bench)
    program = load_program(PROGRAM)
    ball = "scene.objects.ball.shape"
    assert value_at(program, ball)
    shape = {"kind": "mesh", "asset": "ab" * 32, "size": [0.2, 0.2, 0.2]}
    shown = after(bench, commands.ApplyEdits((SetField(path=ball, value=shape),)))
    assert shown.program == before.program
    assert "add its file to the scene again" in shown.notices[-1].text


def test_forms_know_their_up_and_a_size_to_believe() -> None:
    data = wedge("a.stl", height=300.0)  # as if in millimetres
    form = read_form(data, "a.stl")
    assert (form.up, form.extent) == ("z", pytest.approx(300.0))
    assert form.believed(0.2) == 0.2
    assert read_form(wedge("a.glb"), "a.glb").believed(0.2) == 0.6
    with pytest.raises(InputError, match="is flat"):
        read_form(b"v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n", "a.obj")


@pytest.mark.parametrize(
    ("wanted", "name"), [("ball", "ball_2"), ("My tea pot!", "My_tea_pot"), ("é", "mesh")]
)
def test_names_are_tidy_and_free(wanted: str, name: str) -> None:
    assert name_for(load_program(PROGRAM), wanted) == name
