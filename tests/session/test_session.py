"""A session keeps what it acknowledged: states, rounds, files, undo, kill -9."""

import os
import signal
import subprocess
import sys
import textwrap
from pathlib import Path
from types import MappingProxyType

import numpy as np
import pytest

from physagent_studio.agent.loop import add_round
from physagent_studio.errors import InputError
from physagent_studio.program import Click, Grounding, PhysicalProgram, SceneState
from physagent_studio.records import (
    Candidate,
    Case,
    Decision,
    Finding,
    LoopState,
    Mesh,
    Scene,
    Shading,
    ShapeOffer,
)
from physagent_studio.session import Session, Store
from physagent_studio.session.care import check


def a_case(image: bool = True) -> Case:
    pixels = np.random.default_rng(0).integers(0, 255, (24, 32, 3), dtype=np.uint8)
    return Case(
        name="still_life",
        image=pixels if image else None,
        image_hash="ab" if image else "",
        objects=(("ball", Grounding(points=(Click(x=3, y=4),))),),
        supports=(),
        landmarks=(),
        prompt="The ball falls.",
        event="falls",
        events=(("falls", "The ball falls."),),
    )


def test_a_session_reopens_as_it_was(tmp_path: Path) -> None:
    store = Store(tmp_path)
    session = store.create(a_case(), LoopState(budget=7))
    state = add_round(session.load(), PhysicalProgram(), "generator", None)
    session.save(state, checkpoint="step")
    session.record("decision", "person", {"why": "because"})
    session.close()

    again = store.open(session.id[:-2])
    assert again.load() == state
    assert again.case.prompt == "The ball falls."
    expected = a_case().image
    assert expected is not None
    assert again.case.image is not None
    assert np.array_equal(again.case.image, expected)
    assert [entry[1:] for entry in again.log()] == [
        ("round", "generator", {"round": "r1", "program": PhysicalProgram().hash}),
        ("decision", "person", {"why": "because"}),
    ]


def test_undo_and_redo_walk_checkpoints_and_keep_every_round(tmp_path: Path) -> None:
    session = Store(tmp_path).create(a_case(), LoopState())
    states = [session.load()]
    for number in range(10):
        decision = Decision(kind="override", author="person", at="now", reason=str(number))
        states.append(add_round(states[-1], PhysicalProgram(), "person", decision))
        session.save(states[-1], checkpoint=f"edit {number}")
    for expected in reversed(states[:-1]):
        undone = session.undo()
        assert undone is not None
        assert undone.head == expected.head
        assert len(undone.rounds) == 10
    assert session.undo() is None
    for expected in states[1:]:
        redone = session.redo()
        assert redone is not None
        assert redone.head == expected.head
    assert session.redo() is None


def test_a_new_step_after_undo_drops_what_was_undone(tmp_path: Path) -> None:
    session = Store(tmp_path).create(a_case(), LoopState(budget=1))
    session.save(LoopState(budget=2), checkpoint="two")
    session.undo()
    session.save(LoopState(budget=3), checkpoint="three")
    assert not session.can_redo
    undone = session.undo()
    assert undone is not None
    assert undone.budget == 1


def test_scenes_survive_the_round_trip(tmp_path: Path) -> None:
    case = a_case()
    mask = np.zeros((24, 32), bool)
    mask[4:9, 5:11] = True
    mesh = Mesh(
        vertices=np.eye(3),
        faces=np.array([[0, 1, 2]], np.int32),
        uv=np.eye(3)[:, :2],
        texture=np.full((4, 5, 3), 77, np.uint8),
        shading=Shading(
            terms=((0.1,) * 16, (0.2,) * 16, (0.3,) * 16),
            towards=(0.0, -0.6, 0.8),
            built=(0.6, 0.8, 0.0, 0.0),
            gloss=np.arange(256, dtype=np.uint8).reshape(16, 16),
            shade=np.arange(64, dtype=np.uint8).reshape(8, 8),
        ),
        solid=(2 * np.eye(3), np.array([[2, 1, 0]], np.int32)),
    )
    plain = Mesh(vertices=np.eye(3), faces=np.array([[0, 1, 2]], np.int32), color=(1, 2, 3))
    scene = Scene(
        state=SceneState(),
        photo=case.image,
        plate=case.image,
        masks=MappingProxyType({"ball": mask}),
        meshes=MappingProxyType({"ball": mesh}),
        support_meshes=MappingProxyType({"floor": plain}),
        candidates=MappingProxyType({"ball": (Candidate(mask, 0.5, "grabcut"),)}),
        findings=(Finding("iou", "ball", 0.9, 0.8, "", True, "mask", "fine"),),
        hash="cafe",
        shapes=MappingProxyType({"ball": (ShapeOffer("sphere", 0.99, 0.98),)}),
    )
    store = Store(tmp_path)
    session = store.create(case, LoopState())
    key = session.put_scene(scene)
    session.close()
    back = store.open(session.id).scene(key)
    assert np.array_equal(back.masks["ball"], mask)
    assert np.array_equal(back.candidates["ball"][0].mask, mask)
    assert back.findings == scene.findings
    assert back.shapes == scene.shapes
    texture = back.meshes["ball"].texture
    assert texture is not None
    assert mesh.texture is not None
    assert np.array_equal(texture, mesh.texture)
    assert back.support_meshes["floor"].color == (1, 2, 3)
    assert back.support_meshes["floor"].shading is None
    assert back.support_meshes["floor"].solid is None
    solid = back.meshes["ball"].solid
    assert solid is not None
    assert np.array_equal(solid[0], 2 * np.eye(3))
    assert solid[1].tolist() == [[2, 1, 0]]
    light, given = back.meshes["ball"].shading, mesh.shading
    assert light is not None
    assert given is not None
    assert (light.terms, light.towards, light.built) == (given.terms, given.towards, given.built)
    assert light.gloss is not None
    assert given.gloss is not None
    assert np.array_equal(light.gloss, given.gloss)
    assert light.shade is not None
    assert given.shade is not None
    assert np.array_equal(light.shade, given.shade)
    assert back.plate is not None
    assert case.image is not None
    assert np.array_equal(back.plate, case.image)


def test_a_changed_file_is_refused(tmp_path: Path) -> None:
    session = Store(tmp_path).create(a_case(), LoopState())
    key = session.files.put(b"some bytes", ".bin")
    (session.folder / "files" / key).write_bytes(b"other bytes")
    with pytest.raises(InputError, match="was changed"):
        session.files.get(key)


def test_an_unwritable_workspace_is_one_sentence(tmp_path: Path) -> None:
    blocked = tmp_path / "file"
    blocked.write_text("not a folder")
    with pytest.raises(InputError, match="cannot be written"):
        Store(blocked).create(a_case(), LoopState())


def test_unknown_and_ambiguous_ids_are_refused(tmp_path: Path) -> None:
    store = Store(tmp_path)
    store.create(a_case(), LoopState()).close()
    store.create(a_case(), LoopState()).close()
    with pytest.raises(InputError, match="no session 'nothing'"):
        store.open("nothing")
    with pytest.raises(InputError, match="no session 'still-life'"):
        store.open("still-life")
    with pytest.raises(InputError, match="not a session id"):
        store.open("../../etc")


def test_duplicate_and_rename(tmp_path: Path) -> None:
    store = Store(tmp_path)
    session = store.create(a_case(), LoopState(budget=4))
    copy = store.duplicate(session.id)
    session.rename("Another title")
    session.close()
    titles = {item.id: item.title for item in store.list()}
    assert titles[session.id] == "Another title"
    assert titles[copy] == "still life: falls"
    assert store.open(copy).load().budget == 4


def test_discard_and_restore(tmp_path: Path) -> None:
    store = Store(tmp_path)
    session = store.create(a_case(), LoopState(budget=4))
    session.close()
    assert store.discard(session.id) == session.id
    assert store.list() == ()
    assert session.id not in store
    store.restore(session.id)
    assert store.open(session.id).load().budget == 4
    with pytest.raises(InputError, match="gone for good"):
        store.restore("nothing")
    with pytest.raises(InputError, match="gone for good"):
        store.restore("../sessions")


def test_what_was_discarded_long_ago_is_gone(tmp_path: Path) -> None:
    store = Store(tmp_path)
    old, new = (store.create(a_case(), LoopState()) for _ in range(2))
    for one in (old, new):
        one.close()
    store.discard(old.id)
    os.utime(tmp_path / "trash" / old.id, (0, 0))
    store.discard(new.id)
    with pytest.raises(InputError, match="gone for good"):
        store.restore(old.id)
    store.restore(new.id)


def test_a_session_that_is_only_being_made_is_not_listed_yet(tmp_path: Path) -> None:
    store = Store(tmp_path)
    there = store.create(a_case(), LoopState(), title="There, behind…")
    assert there.id.startswith("there-behind-")  # what a person types on the command line
    there.close()
    (tmp_path / "sessions" / "begun").mkdir()
    (tmp_path / "sessions" / "begun" / "session.db").touch()
    assert [one.title for one in store.list()] == ["There, behind…"]


def test_the_list_is_read_again_only_where_something_changed(tmp_path: Path) -> None:
    store = Store(tmp_path)
    session = store.create(a_case(), LoopState())
    (before,) = store.list()
    assert before.rounds == 0
    assert store.list()[0] is before
    session.rename("Another title")
    (after,) = store.list()
    assert after.title == "Another title"
    session.close()


WRITER = """
import sys
from pathlib import Path
from physagent_studio.agent.loop import add_round
from physagent_studio.program import PhysicalProgram
from physagent_studio.session import Store
session = Store(Path(sys.argv[1])).open(sys.argv[2])
state = session.load()
while True:
    state = add_round(state, PhysicalProgram(), "person", None)
    session.save(state, checkpoint="step")
    print(state.head, flush=True)
"""


def test_kill_9_loses_nothing_that_was_acknowledged(tmp_path: Path) -> None:
    store = Store(tmp_path)
    session = store.create(a_case(), LoopState())
    session.close()
    command = [sys.executable, "-c", textwrap.dedent(WRITER), str(tmp_path), session.id]
    for kill_after in (1, 4, 9):
        writer = subprocess.Popen(command, stdout=subprocess.PIPE, text=True)
        assert writer.stdout is not None
        acknowledged = [writer.stdout.readline().strip() for _ in range(kill_after)]
        os.kill(writer.pid, signal.SIGKILL)
        rest = writer.stdout.read().split()
        writer.wait()
        writer.stdout.close()
        again = store.open(session.id)
        ids = [item.id for item in again.load().rounds]
        again.close()
        for head in (*acknowledged, *rest):
            assert head in ids


def test_a_kill_while_a_session_is_made_leaves_none_or_a_whole_one(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The moment after the first transaction: what is there then opens, with its first state."""

    def killed(self: Session, folder: Path) -> None:
        raise KeyboardInterrupt

    case = Case("made", None, "", (), (), (), "nothing")
    with monkeypatch.context() as moment:
        moment.setattr(Session, "__init__", killed)
        with pytest.raises(KeyboardInterrupt):
            Session.create(tmp_path / "made", case, "made", LoopState(budget=3))
    assert check(tmp_path / "made") == []
    session = Session(tmp_path / "made")
    assert session.load().budget == 3
    session.close()
