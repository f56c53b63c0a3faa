"""Sampled frames and faces: made when asked for, from what is stored or rendered now."""

from __future__ import annotations

from pathlib import Path

import cv2
import numpy as np
import pytest

from physagent_studio.assets import assets_dir
from physagent_studio.exchange import load_case
from physagent_studio.program.text.document import load_program
from physagent_studio.records import LoopState
from physagent_studio.session import Store
from physagent_studio.studio.library import Library
from physagent_studio.studio.site import FACE, WIDTH, Pictures, Site, strip_of, tag_of
from physagent_studio.workbench import Snapshot, Workbench, commands


def _ran(root: Path, *, evidence: bool) -> tuple[Snapshot, Store]:
    text = (assets_dir() / "programs" / "domino_program.yaml").read_text(encoding="utf-8")
    store = Store(root)
    workbench = Workbench(store, evidence=evidence)
    workbench.post(commands.OpenProgram(load_program(text), "dominoes"))
    # No repair is searched for.
    workbench.post(commands.TakeRole("planner"))
    workbench.post(commands.Step())
    assert workbench.wait(120)
    snapshot = workbench.snapshot()
    workbench.close()
    return snapshot, store


@pytest.mark.parametrize("evidence", [False, True])
def test_frames_of_a_round(tmp_path: Path, evidence: bool) -> None:
    snapshot, store = _ran(tmp_path, evidence=evidence)
    item = snapshot.state.rounds[0]
    assert bool(item.frames) is evidence
    strip = strip_of(item)
    assert strip is not None
    assert strip["frames"] == list(range(0, 81, 3))
    pictures = Pictures(lambda: snapshot, store)
    first, last = (_decoded(pictures.frame(tag_of(item), number)) for number in (0, 78))
    assert first.shape[1] == last.shape[1] == WIDTH
    assert np.abs(first.astype(int) - last).mean() > 0.5
    assert pictures.frame(tag_of(item), 1) is None
    assert pictures.frame(tag_of(item), 81) is None
    assert pictures.frame("r9-0000000000000000", 0) is None
    # A server that ends draws nothing more; what is made already costs nothing.
    pictures.stop()
    assert pictures.frame(tag_of(item), 78) is not None
    assert (pictures.frame(tag_of(item), 3) is None) is not evidence


def test_a_lost_file_is_no_picture(tmp_path: Path) -> None:
    snapshot, store = _ran(tmp_path, evidence=False)
    item = snapshot.state.rounds[0]
    assert item.rollout is not None
    files = store.root / "sessions" / str(snapshot.session_id) / "files"
    (files / item.rollout).unlink()
    assert Pictures(lambda: snapshot, store).frame(tag_of(item), 0) is None


def test_faces_of_sessions_and_examples(tmp_path: Path) -> None:
    store = Store(tmp_path)
    session = store.create(load_case(assets_dir() / "demo", "only_the_cube"), LoopState())
    snapshot = Snapshot(revision=0, session_id=session.id)
    pictures = Pictures(lambda: snapshot, store)
    assert _decoded(pictures.face(session.id)).shape[1] == FACE
    assert _decoded(pictures.example(assets_dir() / "demo" / "input.png")).shape[1] == FACE
    assert pictures.face("nobody") is None
    assert pictures.face("../../etc") is None
    assert pictures.example(tmp_path / "nothing.png") is None
    session.close()


def test_a_session_without_a_photo_shows_its_scene(tmp_path: Path) -> None:
    snapshot, store = _ran(tmp_path, evidence=False)
    pictures = Pictures(lambda: snapshot, store)
    name = str(snapshot.session_id)
    assert pictures.face(name) is None
    face = _decoded(pictures.scene(name, "1"))
    assert face.shape[1] == FACE
    assert face.std() > 5, "more than a wall"
    assert pictures.scene("nobody", "1") is None
    ((listed,),) = [Library(store).listing(snapshot)["sessions"]]
    assert listed["face"].startswith(f"face/scene/{name}/")
    assert Site(lambda: snapshot, store, Library(store)).page("/" + listed["face"]) is not None


def _decoded(data: bytes | None) -> np.ndarray:
    assert data is not None
    picture = cv2.imdecode(np.frombuffer(data, np.uint8), cv2.IMREAD_COLOR)
    assert picture is not None
    return picture
