"""What the list says of a session whose loop has not ended."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path
from types import MappingProxyType

import pytest

from physagent_studio.program import Contract, PhysicalProgram, SceneState
from physagent_studio.records import Case, LoopState, Round, Scene
from physagent_studio.session import Store
from physagent_studio.session.files import Lock, is_held
from physagent_studio.session.standing import BEGUN, CANCELLED, DONE, FAILED

CASE = Case("still_life", None, "", (), (), (), "The ball falls.", "falls", ())
STEP = {"command": {"kind": "Step", "fields": {}}}
KILLED = """
import os, sys
from pathlib import Path
from physagent_studio.session import Store
session = Store(Path(sys.argv[1])).open(sys.argv[2])
session.record("begun", "person", {"command": {"kind": "Step", "fields": {}}})
os.kill(os.getpid(), 9)
"""


def listed(root: Path) -> str:
    return Store(root).list()[0].outcome


@pytest.mark.parametrize(
    ("entry", "said"),
    [
        ((DONE, {}), "open"),
        ((FAILED, {"kind": "InputError"}), "open"),
        ((FAILED, {"kind": CANCELLED}), "cancelled"),
    ],
)
def test_what_nobody_carries_out_is_not_running(
    tmp_path: Path, entry: tuple[str, dict[str, str]], said: str
) -> None:
    session = Store(tmp_path).create(CASE, LoopState())
    assert listed(tmp_path) == "open"
    session.record(BEGUN, "person", STEP)
    assert listed(tmp_path) == "running"
    session.record(entry[0], "person", entry[1])
    assert listed(tmp_path) == said
    session.close()
    assert listed(tmp_path) == said


def test_a_session_whose_process_was_killed_is_interrupted(tmp_path: Path) -> None:
    session = Store(tmp_path).create(CASE, LoopState())
    session.close()
    told = [sys.executable, "-c", KILLED, str(tmp_path), session.id]
    assert subprocess.run(told, check=False).returncode == -9
    assert listed(tmp_path) == "interrupted"


def test_an_ended_loop_is_what_it_ended_as(tmp_path: Path) -> None:
    session = Store(tmp_path).create(CASE, LoopState(phase="done", outcome="stuck"))
    session.record(BEGUN, "person", STEP)
    session.close()
    assert listed(tmp_path) == "stuck"


def test_a_known_list_sees_that_a_session_was_let_go(tmp_path: Path) -> None:
    store = Store(tmp_path)
    session = store.create(CASE, LoopState())
    session.record(BEGUN, "person", STEP)
    assert store.list()[0].outcome == "running"
    session.close()
    assert store.list()[0].outcome == "interrupted"


def test_whether_a_lock_is_held(tmp_path: Path) -> None:
    path = tmp_path / "session.lock"
    assert not is_held(path)
    lock = Lock(path)
    assert is_held(path)
    assert not Lock(path).taken
    lock.release()
    assert not is_held(path)
    assert Lock(path).taken


@pytest.mark.parametrize("strange", [(), ("glimmers",)])
def test_what_is_realised_with_a_word_not_understood_is_so_in_doubt(
    tmp_path: Path, strange: tuple[str, ...]
) -> None:
    program = PhysicalProgram(contract=Contract(not_understood=strange))
    only = Round(id="r1", number=1, parent=None, program=program, author="generator")
    state = LoopState(rounds=(only,), head="r1", phase="done", outcome="realised")
    Store(tmp_path).create(CASE, state).close()
    (info,) = Store(tmp_path).list()
    assert (info.outcome, info.in_doubt) == ("realised", bool(strange))


@pytest.mark.parametrize(("sure", "doubted"), [(0.9, False), (0.2, True)])
def test_a_doubted_mask_of_a_stored_scene_is_told(
    tmp_path: Path, sure: float, doubted: bool
) -> None:
    none, told = MappingProxyType({}), MappingProxyType({"ball": sure})
    scene = Scene(SceneState(), None, None, none, none, none, none, (), "", sureness=told)
    with Store(tmp_path).create(CASE, LoopState()) as session:
        key = session.put_scene(scene)
        assert session.is_doubted(key) == doubted
