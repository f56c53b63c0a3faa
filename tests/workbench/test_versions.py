"""Commands know what they were made against; what was cut short is said; the audit replays."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from physagent_studio.benchmark.durability.bench import PROGRAM
from physagent_studio.program import SetField
from physagent_studio.program.text.document import load_program
from physagent_studio.records import Rollout
from physagent_studio.records.rollout_io import rollout_to_bytes
from physagent_studio.session import Store
from physagent_studio.workbench import Workbench, commands, tasks
from physagent_studio.workbench.journal import BEGUN, replayed
from physagent_studio.workbench.versions import Sender, sent_by


@pytest.fixture
def bench(tmp_path: Path) -> Iterator[Workbench]:
    workbench = Workbench(Store(tmp_path), evidence=False)
    workbench.post(commands.OpenProgram(load_program(PROGRAM), "two"))
    assert workbench.wait(60)
    yield workbench
    workbench.close()


def start(value: int) -> commands.ApplyEdits:
    return commands.ApplyEdits((SetField(path="event.actions.go.start_step", value=value),))


def test_a_stale_command_is_refused_with_what_changed(bench: Workbench) -> None:
    seen, said = bench.snapshot().version, list[str]()
    for client, value in ((1, 3), (2, 5), (1, 7)):
        with sent_by(Sender(client, seen, said.append)):
            bench.post(start(value))
    assert bench.wait(60)
    # The second had not seen the first; the third is by the one who made the first.
    assert len(said) == 1
    assert "edited event.actions.go.start_step" in said[0]
    action = bench.snapshot().program.action("go")
    assert action is not None
    assert action.start_step == 7


def test_an_interrupted_command_is_said(bench: Workbench) -> None:
    session_id = bench.snapshot().session_id
    assert session_id is not None
    bench.post(commands.OpenProgram(load_program(PROGRAM), "other"))
    assert bench.wait(60)
    session = bench.store.open(session_id)
    session.record(BEGUN, "person", {"command": {"kind": "Step", "fields": {}}})
    session.close()
    bench.post(commands.OpenSession(session_id))
    assert bench.wait(60)
    assert "Step does it again" in bench.snapshot().notices[-1].text


def test_a_second_workbench_only_shows(bench: Workbench, tmp_path: Path) -> None:
    session_id = bench.snapshot().session_id
    assert session_id is not None
    other = Workbench(Store(tmp_path), evidence=False)
    other.post(commands.OpenSession(session_id))
    other.post(start(9))
    assert other.wait(60)
    shown = other.snapshot()
    assert shown.program.hash == bench.snapshot().program.hash
    assert "nothing is changed" in shown.notices[-1].text
    other.close()


def test_a_session_replays_to_the_same_bits(bench: Workbench, tmp_path: Path) -> None:
    for command in (start(4), commands.Step(), commands.Undo(), commands.Redo()):
        bench.post(command)
    bench.post(commands.Pin("clip.frames"))
    assert bench.wait(60)
    session_id = bench.snapshot().session_id
    assert session_id is not None
    bench.close()
    found = replayed(bench.store, session_id, tmp_path / "scratch", "rules")
    assert (found["commands"], found["same"], found["different"]) == (5, 5, [])


def test_runs_that_differ_are_said_in_millimetres_and_recorded_ones_stay(
    bench: Workbench, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    bench.post(start(4))
    bench.post(commands.Step())
    assert bench.wait(60)
    session_id, before = bench.snapshot().session_id, bench.snapshot().rollout
    assert session_id is not None
    assert before is not None
    bench.close()
    simulated = tasks.simulated

    def elsewhere(*values: Any) -> Rollout:
        run, aside = simulated(*values), np.array((0.003, 0, 0.004))
        return replace(run, positions=run.positions + aside, versions=(("it", "9"),))

    monkeypatch.setattr(tasks, "simulated", elsewhere)
    found = replayed(bench.store, session_id, tmp_path / "scratch", "rules")
    assert "Step" in found["different"]
    assert any("up to 5 mm apart" in one and one.endswith("with it 9") for one in found["said"])
    # What was recorded is what is shown, whatever runs here.
    kept = bench.store.open(session_id, writing=False)
    head = kept.load().current
    assert head is not None
    assert head.rollout is not None
    assert rollout_to_bytes(kept.rollout(head.rollout)) == rollout_to_bytes(before)
    kept.close()
