"""One writer, older formats, checks, repairs, and a session as one file."""

from __future__ import annotations

import json
import sqlite3
import subprocess
import sys
import zipfile
from pathlib import Path

import pytest

from physagent_studio.agent.loop import add_round
from physagent_studio.errors import InputError, StorageError
from physagent_studio.program import PhysicalProgram
from physagent_studio.records import Case, LoopState
from physagent_studio.session import Session, Store, archive
from physagent_studio.session.care import audit, check, repair, vacuum


@pytest.fixture
def store(tmp_path: Path) -> Store:
    return Store(tmp_path)


def made(store: Store, rounds: int = 3) -> Session:
    case = Case("bare", None, "", (), (), (), "A ball falls.")
    session = store.create(case, LoopState(), title="bare")
    state = session.load()
    for _ in range(rounds):
        state = add_round(state, PhysicalProgram(), "person", None)
        session.save(state, checkpoint="step")
    return session


def test_a_second_writer_only_reads_and_says_so(store: Store) -> None:
    first = made(store)
    second = store.open(first.id)
    assert "only shown" in second.read_only
    with pytest.raises(StorageError, match="nothing is changed"):
        second.save(second.load(), checkpoint="mine")
    first.close()
    second.close()
    third = store.open(first.id)
    assert third.read_only == ""
    third.close()


HOLDER = """
import sys, time
from pathlib import Path
from physagent_studio.session import Store
Store(Path(sys.argv[1])).open(sys.argv[2])
print("held", flush=True)
time.sleep(60)
"""


def test_a_dead_process_keeps_no_lock(store: Store) -> None:
    session = made(store)
    session.close()
    command = [sys.executable, "-c", HOLDER, str(store.root), session.id]
    with subprocess.Popen(command, stdout=subprocess.PIPE, text=True) as holder:
        assert holder.stdout is not None
        assert holder.stdout.readline() == "held\n"
        shut = store.open(session.id)
        assert str(holder.pid) in shut.read_only
        shut.close()
        holder.kill()
    free = store.open(session.id)
    assert free.read_only == ""
    free.close()


def test_a_session_of_the_first_format_is_brought_up(store: Store) -> None:
    session = made(store)
    before = session.load()
    session.close()
    with sqlite3.connect(session.folder / "session.db") as db:
        db.executescript(
            "DROP TRIGGER log_is_not_changed; DROP TRIGGER log_is_not_cut; DROP TABLE answers;"
            "ALTER TABLE rounds DROP COLUMN parent; ALTER TABLE log DROP COLUMN link;"
            "UPDATE meta SET value = '1' WHERE key = 'schema';"
        )
    db.close()
    seen = store.open(session.id, writing=False)
    assert seen.load() == before
    seen.close()
    again = store.open(session.id)
    assert again.load() == before
    assert again.meta("schema") == "2"
    again.close()
    assert check(session.folder) == []


def test_a_format_of_the_future_is_refused(store: Store) -> None:
    session = made(store)
    session.note("schema", "99")
    session.close()
    with pytest.raises(InputError, match="format 99"):
        store.open(session.id)


def test_the_log_cannot_be_changed_and_a_change_shows(store: Store) -> None:
    session = made(store)
    with pytest.raises(sqlite3.IntegrityError, match="only added to"):
        session._db.execute("DELETE FROM log")
    session._db.execute("DROP TRIGGER log_is_not_changed")
    session._db.execute("UPDATE log SET author = 'somebody' WHERE seq = 2")
    session.close()
    assert any("entry 2 of the log" in one for one in check(session.folder))
    assert [one["kind"] for one in audit(session.folder)] == ["round"] * 3


def test_what_is_damaged_is_found_and_left_out(store: Store) -> None:
    session = made(store)
    session._db.execute("UPDATE rounds SET payload = '{broken' WHERE id = 'r3'")
    session.close()
    assert any("round r3 cannot be read" in one for one in check(session.folder))
    done = repair(session.folder)
    assert "round r3 was left out" in done
    assert check(session.folder) == []
    again = store.open(session.id)
    assert [one.id for one in again.load().rounds] == ["r1", "r2"]
    again.close()
    assert repair(session.folder) == []


def test_what_nothing_refers_to_goes(store: Store) -> None:
    session = made(store)
    key = session.files.put(b"left behind", ".bin")
    session.close()
    count, size = vacuum(session.folder)
    assert (count, key in session.files) == (1, False)
    assert size >= len(b"left behind")


def test_a_quota_is_a_sentence(store: Store, monkeypatch: pytest.MonkeyPatch) -> None:
    session = made(store)
    monkeypatch.setenv("PHYSAGENT_QUOTA", "0.000001")
    with pytest.raises(StorageError, match="more than the"):
        session.files.put(b"x" * 5000, ".bin")
    session.close()


def test_a_session_travels_as_one_file(store: Store, tmp_path: Path) -> None:
    session = made(store)
    path = archive.export(session, tmp_path / "one")
    assert path.suffix == ".physagent"
    copy = store.open(store.import_from(path))
    assert copy.load() == session.load()
    assert [row[1:] for row in copy.log()] == [row[1:] for row in session.log()]
    for one in (session, copy):
        one.close()


@pytest.mark.parametrize(
    "change",
    [
        {"rows.json": b"{"},
        {"rows.json": json.dumps({"rounds": [["r1", 1, "{}", None]]}).encode()},
        {"manifest.json": b'{"format": 9}'},
        {"files/../../../evil": b"x"},
        {"files/" + "0" * 64 + ".png": b"not its hash"},
        {"session.db": b"a database of somebody else's"},
    ],
)
def test_a_strange_archive_leaves_nothing(store: Store, tmp_path: Path, change) -> None:
    session = made(store)
    good, bad = archive.export(session, tmp_path / "good.physagent"), tmp_path / "bad.physagent"
    session.close()
    with zipfile.ZipFile(good) as old, zipfile.ZipFile(bad, "w") as new:
        for name in old.namelist():
            new.writestr(name, change.get(name) or old.read(name))
        for name in set(change) - set(old.namelist()):
            new.writestr(name, change[name])
    with pytest.raises(InputError):
        store.import_from(bad)
    assert [one.id for one in store.list()] == [session.id]
    assert not list((tmp_path / "imports").iterdir())


def test_a_failed_save_writes_the_round_again(store: Store) -> None:
    session = made(store, 1)
    state = add_round(session.load(), PhysicalProgram(), "person", None)
    session._db.execute("PRAGMA max_page_count = 1")
    big = state.model_copy(update={"hints": ("x" * 200_000,)})
    with pytest.raises(StorageError, match="the disk is full"):
        session.save(big, checkpoint="step")
    session._db.execute("PRAGMA max_page_count = 1000000")
    session.save(big, checkpoint="step")
    session.close()
    again = store.open(session.id)
    assert [one.id for one in again.load().rounds] == ["r1", "r2"]
    again.close()
