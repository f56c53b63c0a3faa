"""What the list says of a session whose loop has not ended."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest

from physagent_studio.records import Case, LoopState
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
