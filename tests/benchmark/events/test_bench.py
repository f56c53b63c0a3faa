"""The bench of events: what counts as realised, and that no single event can stop it."""

from __future__ import annotations

import sys
from dataclasses import replace
from pathlib import Path

import cv2
import numpy as np
import pytest

from physagent_studio.benchmark import run_bench
from physagent_studio.benchmark.events import event_run
from physagent_studio.benchmark.events.bench import events_below, figures, tasks_below
from physagent_studio.benchmark.events.event_run import EventResult, EventTask, run_apart
from physagent_studio.benchmark.events.references import judge, load_reference
from physagent_studio.benchmark.rows import Row
from physagent_studio.errors import InputError
from physagent_studio.program.contract import Contract
from physagent_studio.program.program import Clip, PhysicalProgram
from physagent_studio.program.scene.state import Floor, SceneObject, SceneState, Sphere, Support
from physagent_studio.simulation import simulate

REPORT = {
    "realised": True, "outcome": "realised", "rounds": 2, "simulations": 7, "seconds": 4.0,
    "cpu_seconds": 3.0, "contract": [], "diagnosis": [], "untested": [], "not_understood": [],
}  # fmt: skip


def result(label: str = "a/b", *, note: bool = False, **more: object) -> EventResult:
    """A result; `report` fields and fields of the result by name."""
    report = {**REPORT, **{k: v for k, v in more.items() if k in REPORT}}
    fields = {k: v for k, v in more.items() if k not in REPORT}
    known = {"own_holds": True, "reference_holds": True, **fields}
    return EventResult(label, "It falls.", note, "full", report, **known)  # type: ignore[arg-type]


def row(rows: list[Row], name: str) -> Row:
    (found,) = [item for item in rows if item.name.startswith(name)]
    return found


def write_case(folder: Path, events: str) -> Path:
    folder.mkdir(parents=True)
    cv2.imwrite(str(folder / "input.png"), np.full((48, 64, 3), 90, np.uint8))
    text = f"image: input.png\nobjects:\n  ball: {{points: [[20, 20, 1]]}}\nevents:\n{events}"
    (folder / "case.yaml").write_text(text)
    return folder


# --- what counts -------------------------------------------------------------------------------


def test_the_agent_and_the_reference_have_to_agree():
    assert result().realised
    assert not result(reference_holds=False).realised
    assert result(reference_holds=False).denied
    assert not result(realised=False, outcome="budget").realised
    assert not result(realised=False, outcome="budget").denied


def test_an_untested_clause_is_no_realisation():
    assert not result(untested=["and sings"]).realised


def test_a_denied_claim_fails_the_bench():
    rows = figures([result("a/b"), result("a/c", reference_holds=False)])
    assert not row(rows, "events claimed that the reference denies").ok
    assert row(rows, "own contract agrees").value == 0.5
    assert not row(rows, "own contract agrees").ok


def test_the_mean_of_rounds_is_over_what_was_realised():
    seen = {"view": [{"check": "framing", "statement": "in view", "ok": True}]}
    good, bad = result("a/b", rounds=2), result("a/c", rounds=10, realised=False)
    rows = figures([replace(one, report={**one.report, **seen}) for one in (good, bad)])
    assert row(rows, "clicks alone: rounds, mean").value == 2
    assert row(rows, "clicks alone: realised with every view check of 2").value == 1


# --- references --------------------------------------------------------------------------------

FALLS = Contract.model_validate(
    {
        "clauses": [{"id": "c1", "text": "The ball falls into the goal"}],
        "statements": [
            {"id": "s", "kind": "falls", "clause": "c1", "subject": "ball", "drop": 0.1}
        ],
    }
)
IN_GOAL = Contract.model_validate(
    {
        "clauses": [{"id": "c1", "text": "The ball falls into the goal"}],
        "statements": [
            {"id": "s", "kind": "lands_in", "clause": "c1", "subject": "ball", "landmark": "goal"}
        ],
    }
)


def falling(height: float) -> PhysicalProgram:
    ball = SceneObject(
        name="ball", shape=Sphere(radius=0.1), position=(0, 2, height), support="air"
    )
    floor = Support(name="floor", shape=Floor())
    return PhysicalProgram(
        clip=Clip(), scene=SceneState(objects=(ball,), supports=(floor,)), contract=Contract()
    )


def test_a_reference_is_measured_on_the_rollout():
    high, low = falling(1.0), falling(0.1)
    assert judge(FALLS, high, simulate(high)).holds
    verdict = judge(FALLS, low, simulate(low))
    assert not verdict.holds
    assert "falls" in verdict.failing[0]


def test_a_reference_on_a_missing_place_is_untestable():
    program = falling(1.0)
    verdict = judge(IN_GOAL, program, simulate(program))
    assert verdict.missing == ("goal",)
    assert not verdict.holds
    assert verdict.failing == ("the scene has no 'goal'",)


def test_what_is_no_reference_is_said(tmp_path: Path):
    path = tmp_path / "a__b.yaml"
    path.write_text("contract: {statements: [{kind: dances}]}\n")
    with pytest.raises(InputError, match="is no reference contract"):
        load_reference(path)


# --- finding and running -----------------------------------------------------------------------


def test_events_are_found_and_chosen(tmp_path: Path):
    write_case(tmp_path / "one", "  falls: The ball falls.\n  rolls: The ball rolls.\n")
    write_case(tmp_path / "two", "  jumps: The ball jumps.\n")
    assert [e for _, e in events_below(tmp_path)] == ["falls", "rolls", "jumps"]
    assert [e for _, e in events_below(tmp_path, ("one/rolls", "two"))] == ["rolls", "jumps"]


def test_each_event_runs_as_it_is_and_annotated(tmp_path: Path):
    write_case(tmp_path / "cases" / "one", "  falls: The ball falls.\n")
    notes = tmp_path / "notes"
    notes.mkdir()
    (notes / "one.yaml").write_text("horizon: 10\n")
    tasks = tasks_below(tmp_path / "cases", notes, None)
    assert [task.annotation for task in tasks] == [None, notes / "one.yaml"]
    assert [task.label for task in tasks] == ["one/falls", "one/falls"]


def test_without_cases_one_sentence(tmp_path: Path):
    with pytest.raises(InputError, match="--cases"):
        run_bench("events", cases=None, out=None)
    with pytest.raises(InputError, match="no event that is called x below"):
        run_bench("events", cases=tmp_path, out=None, only=["x"])
    with pytest.raises(InputError, match="are for the benches events and view"):
        run_bench("physics", cases=None, out=None, only=["x"])
    with pytest.raises(InputError, match="there is no folder"):
        run_bench("events", cases=tmp_path, out=None, annotations=tmp_path / "none")


def test_a_bad_case_is_a_row(tmp_path: Path):
    folder = write_case(tmp_path / "one", "  falls: The ball falls.\n")
    note = tmp_path / "note.yaml"
    note.write_text("horizon: [[1, 1], [900, 1]]\n")
    (outcome,) = run_apart(EventTask(folder, "falls", note))
    assert outcome.report["outcome"] == "error"
    assert "outside the picture" in outcome.problem
    rows = figures([outcome])
    assert not row(rows, "annotated: events that ended by an error").ok


def test_a_crash_is_a_row(tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    broken = tmp_path / "python"
    broken.write_text("#!/bin/sh\necho 'Segmentation fault' >&2\nexit 139\n")
    broken.chmod(0o755)
    monkeypatch.setattr(sys, "executable", str(broken))
    (outcome,) = run_apart(EventTask(tmp_path, "falls"))
    assert outcome.problem == "it crashed with exit code 139: Segmentation fault"
    assert not outcome.realised


def test_an_endless_event_is_a_row(tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    slow = tmp_path / "python"
    slow.write_text("#!/bin/sh\nexec sleep 60\n")
    slow.chmod(0o755)
    monkeypatch.setattr(sys, "executable", str(slow))
    monkeypatch.setattr(event_run, "PATIENCE", 0.2)
    (outcome,) = run_apart(EventTask(tmp_path, "falls"))
    assert "had not ended" in outcome.problem


@pytest.mark.slow
def test_one_real_event_in_both_modes(cases_dir: Path, tmp_path: Path):
    out = tmp_path / "results.md"
    rows = run_bench("events", cases=cases_dir, out=out, only=["soccer_ball/rolls_over_line"])
    assert row(rows, "clicks alone: events that ended by an error").value == 0
    assert row(rows, "annotated: events that ended by an error").value == 0
    assert row(rows, "events claimed that the reference denies").value == 0
    text = out.read_text()
    assert "| soccer_ball/rolls_over_line | annotated |" in text
