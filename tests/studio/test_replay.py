"""Replays and recordings of a session, made by the desk and by the worker."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from physagent_studio.assets import assets_dir
from physagent_studio.cli.clips import export_session
from physagent_studio.errors import Cancelled, InputError
from physagent_studio.jobs import Processes
from physagent_studio.program import PhysicalProgram
from physagent_studio.program.text.document import load_program
from physagent_studio.session import Store
from physagent_studio.studio.replay import record, recorded, replay_of
from physagent_studio.workbench import Snapshot, Workbench, commands, tasks


def _ran(root: Path) -> tuple[Snapshot, Workbench]:
    text = (assets_dir() / "programs" / "domino_program.yaml").read_text(encoding="utf-8")
    workbench = Workbench(Store(root), evidence=False)
    workbench.post(commands.OpenProgram(load_program(text), "dominoes"))
    # No repair is searched for.
    workbench.post(commands.TakeRole("planner"))
    workbench.post(commands.Step())
    assert workbench.wait(120)
    return workbench.snapshot(), workbench


def test_a_recording_is_the_same_twice_and_can_be_cancelled(tmp_path: Path) -> None:
    snapshot, workbench = _ran(tmp_path)
    workbench.close()
    first = record(snapshot)
    assert len(first.data) > 1000
    assert first.data == record(snapshot).data
    before, after = first.page
    assert before.lstrip().lower().startswith("<!doctype html>")
    assert "</html>" in after
    with pytest.raises(Cancelled):
        record(snapshot, lambda: True)
    with pytest.raises(InputError, match="nothing was simulated"):
        record(Snapshot(revision=0))


def test_recordings_and_frames_are_the_same_from_a_process(tmp_path: Path) -> None:
    snapshot, workbench = _ran(tmp_path)
    workbench.close()
    scene, rollout = snapshot.scene, snapshot.rollout
    assert snapshot.case is not None
    assert scene is not None
    assert rollout is not None
    values = (snapshot.case, snapshot.program, scene, rollout, False)
    apart, limits = Processes(1, keeping=True), tasks.RENDERING
    try:
        assert apart.submit(recorded, *values, limits=limits) == record(snapshot)
        for number in (0, 40):
            frame = apart.submit(tasks.framed, scene, rollout, number, limits=limits)
            assert np.array_equal(frame, tasks.framed(scene, rollout, number))
    finally:
        apart.close()


def test_the_worker_writes_and_says_where(tmp_path: Path) -> None:
    snapshot, workbench = _ran(tmp_path)
    path = tmp_path / "out" / "replay.html"
    workbench.post(commands.Write(path, "The replay", replay_of))
    assert workbench.wait(120)
    assert path.read_text(encoding="utf-8").startswith("<!doctype html>")
    assert f"The replay was written to {path}" in [n.text for n in workbench.snapshot().notices]
    # By the command line too, chosen by the ending.
    workbench.close()
    out = tmp_path / "scene.viser"
    export_session(str(snapshot.session_id), None, out, tmp_path)
    assert out.read_bytes() == record(snapshot).data


def test_nothing_ran_nothing_is_written(tmp_path: Path) -> None:
    workbench = Workbench(Store(tmp_path), evidence=False)
    workbench.post(commands.OpenProgram(PhysicalProgram(), "empty"))
    path = tmp_path / "replay.html"
    workbench.post(commands.Write(path, "The replay", replay_of))
    assert workbench.wait(60)
    assert [n.level for n in workbench.snapshot().notices] == ["error"]
    assert "no round has run yet" in workbench.snapshot().notices[0].text
    assert list(tmp_path.glob("*replay*")) == []
    workbench.close()
