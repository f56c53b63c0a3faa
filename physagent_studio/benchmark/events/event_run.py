"""One event of a case, run to the end; also as a process of its own, so that a crash is a row."""

import subprocess
import sys
import tempfile
import time
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import cv2
import numpy as np
from pydantic import TypeAdapter

from physagent_studio.benchmark.events.plain_vectors import plain_crew
from physagent_studio.benchmark.events.references import judge, load_reference
from physagent_studio.errors import StudioError
from physagent_studio.exchange import annotated, load_case
from physagent_studio.program.contract import Contract
from physagent_studio.records import Image, LoopState, Rollout, Round, Scene
from physagent_studio.rendering import Compositor, frame_of
from physagent_studio.rendering.sheets import contact_sheet
from physagent_studio.session import Session, Store
from physagent_studio.simulation import simulate
from physagent_studio.workbench.desk import Desk
from physagent_studio.workbench.engine import Control
from physagent_studio.workbench.report import figures_of, report_of

ROUNDS = 10
"""Most rounds of a run."""
PATIENCE = 900.0
"""Seconds after which a process is given up."""


@dataclass(frozen=True, slots=True)
class EventTask:
    """What to run. folder: of the case. annotation, reference: files, or None.

    variant: `full`, `no_semantics` for plain vectors instead of the semantic actions, or `model`
    for a model behind an endpoint in all roles. sheet: where a contact sheet of the final rollout
    is written.
    """

    folder: Path
    event: str
    annotation: Path | None = None
    reference: Path | None = None
    variant: str = "full"
    sheet: Path | None = None

    @property
    def label(self) -> str:
        """`case/event`."""
        return f"{self.folder.name}/{self.event}"


@dataclass(frozen=True, slots=True)
class EventResult:
    """What came of an event.

    report: of the run, with `cpu_seconds`; its outcome is `error` where it could not end, with
    the reason in `problem`. reference: statements (text, ok, measured, …) of the reference on
    the final rollout; `reference_holds` is None without a reference or a rollout. assumed:
    landmarks whose place nobody clicked and the agent took for granted. by_itself: whether the
    reference also holds on the final scene when nothing is done, as where a thing hangs in the
    air and falls; elsewhere it shows a scene that does not stand. passed_in: number of the first
    round that the agent passed, None where it passed none. at_once: whether the event was
    realised in the first round, as without reflection.
    """

    label: str
    prompt: str
    annotated: bool
    variant: str
    report: dict[str, Any]
    own_holds: bool | None = None
    reference_holds: bool | None = None
    reference: tuple[dict[str, Any], ...] = ()
    failing: tuple[str, ...] = ()
    assumed: tuple[str, ...] = ()
    by_itself: bool | None = None
    problem: str = ""
    passed_in: int | None = None
    at_once: bool = False

    @property
    def claimed(self) -> bool:
        """Whether the agent says that the event happened, every clause tested."""
        return bool(self.report.get("realised")) and not self.report.get("untested")

    @property
    def realised(self) -> bool:
        """Whether the agent says so and the reference, where there is one, agrees."""
        return self.claimed and self.reference_holds is not False

    @property
    def denied(self) -> bool:
        """Whether the agent says so and the reference does not."""
        return bool(self.report.get("realised")) and self.reference_holds is False


def run_event(task: EventTask) -> EventResult:
    """Runs the event by policy `auto`, without rendering, in a workspace that is thrown away.

    Raises StudioError where the case or the annotation is bad.
    """
    case = load_case(task.folder, task.event)
    if task.annotation is not None:
        case = annotated(case, task.annotation)
    agent = "vlm" if task.variant == "model" else "rules"
    with tempfile.TemporaryDirectory() as home:
        session = Store(Path(home)).create(case, LoopState(policy="auto", budget=ROUNDS))
        # The embedded verifier reads numbers; a model looks at frames.
        desk = Desk(session, Control(), evidence=agent == "vlm", agent=agent)
        started, worked = time.perf_counter(), time.process_time()
        if task.variant == "no_semantics":
            desk.engine.members = plain_crew()
        problem = ""
        try:
            desk.advance(policy="auto")
        except StudioError as error:
            problem = str(error)
        report = report_of(desk.state, session, time.perf_counter() - started)
        report["cpu_seconds"] = round(time.process_time() - worked, 3)
        if problem:
            report["outcome"] = "error"
        result = EventResult(
            task.label, case.prompt, task.annotation is not None, task.variant, report
        )
        result = replace(_judged(result, task, desk.state, session), problem=problem)
        if task.sheet is not None:
            _draw(task.sheet, desk.state, session)
        session.close()
    return result


def _draw(path: Path, state: LoopState, session: Session) -> None:
    best = state.best or state.current
    if best is not None and best.rollout is not None and best.scene is not None:
        scene, rollout = session.scene(best.scene), session.rollout(best.rollout)
        write_sheet(path, scene, rollout, best.program.event.prompt)


def _judged(
    result: EventResult, task: EventTask, state: LoopState, session: Session
) -> EventResult:
    best = state.best or state.current
    if best is None or best.rollout is None or best.assessment is None:
        return result
    demanded = [c for c in best.assessment.checks if c.demanded and not c.always_on]
    marks = best.program.scene.landmarks
    result = replace(
        result,
        own_holds=all(check.ok for check in demanded),
        assumed=tuple(mark.name for mark in marks if mark.source == "assumed"),
    )
    reference = None if task.reference is None else load_reference(task.reference)
    passed = [number for number, item in enumerate(state.path(), 1) if _passed(item)]
    result = replace(
        result,
        passed_in=passed[0] if passed else None,
        at_once=1 in passed and _holds(reference, state.path()[0], session),
    )
    if reference is None:
        return result
    verdict = judge(reference, best.program, session.rollout(best.rollout))
    demanded = [check for check in verdict.checks if check.demanded]
    rows = tuple({"statement": check.text} | figures_of(check) for check in demanded)
    return replace(
        result,
        reference_holds=verdict.holds,
        reference=rows,
        failing=verdict.failing,
        by_itself=_by_itself(reference, best, session) if verdict.holds else None,
    )


def _passed(item: Round) -> bool:
    """Whether the agent says of a round that the event happened, every clause tested."""
    verdict = item.assessment
    if verdict is None or verdict.stage != "simulation" or not verdict.passed:
        return False
    return not item.program.contract.untested


def _holds(reference: Contract | None, item: Round, session: Session) -> bool:
    if reference is None or item.rollout is None:
        return reference is None
    return judge(reference, item.program, session.rollout(item.rollout)).holds


def _by_itself(reference: Contract, best: Round, session: Session) -> bool:
    event = best.program.event.model_copy(update={"actions": ()})
    idle = best.program.model_copy(update={"event": event, "contract": Contract()})
    scene = session.scene(best.scene) if best.scene else None
    return judge(reference, idle, simulate(idle, scene.meshes if scene else {})).holds


# --- as a process ------------------------------------------------------------------------------

_TASKS = TypeAdapter(list[EventTask])
_RESULTS = TypeAdapter(list[EventResult])


def run_apart(*tasks: EventTask) -> list[EventResult]:
    """`run_event` of each in one fresh process; whatever happens there ends as results."""
    with tempfile.TemporaryDirectory() as folder:
        out = Path(folder) / "result.json"
        words = [sys.executable, "-m", "physagent_studio.benchmark.events.event_run", str(out)]
        text = _TASKS.dump_json(list(tasks)).decode()
        try:
            done = subprocess.run(
                words, input=text, text=True, capture_output=True, timeout=PATIENCE, check=False
            )
        except subprocess.TimeoutExpired:
            return [_failed(task, f"it had not ended after {PATIENCE:.0f} s") for task in tasks]
        if not out.is_file():
            lines = done.stderr.strip().splitlines()
            last = lines[-1] if lines else "no word"
            problem = f"it crashed with exit code {done.returncode}: {last}"
            return [_failed(task, problem) for task in tasks]
        return _RESULTS.validate_json(out.read_bytes())


def _failed(task: EventTask, problem: str) -> EventResult:
    report = {"realised": False, "outcome": "error", "rounds": 0, "simulations": 0, "seconds": 0.0}
    report |= {"cpu_seconds": 0.0, "contract": [], "diagnosis": [], "untested": []}
    report |= {"not_understood": [], "doubts": [], "program": None}
    return EventResult(
        task.label, "", task.annotation is not None, task.variant, report, problem=problem
    )


def _main() -> None:
    results = [_safely(task) for task in _TASKS.validate_json(sys.stdin.read())]
    Path(sys.argv[1]).write_bytes(_RESULTS.dump_json(results))


def _safely(task: EventTask) -> EventResult:
    try:
        return run_event(task)
    except StudioError as error:
        return _failed(task, str(error))


FRAMES = 8
"""Frames of a sheet, evenly spread from the first to the last."""
COLUMNS, WIDTH = 4, 480
"""Pictures in a row, and their width in pixels."""


def sheet_of(scene: Scene, rollout: Rollout) -> Image:
    """Eight frames of a clip with their numbers."""
    compositor = Compositor(scene)
    numbers = np.linspace(0, rollout.frames - 1, FRAMES).round().astype(int)
    frames = [frame_of(compositor, rollout, int(number)).rgb for number in numbers]
    labels = [f"frame {number} of {rollout.frames - 1}" for number in numbers]
    return contact_sheet(frames, labels, COLUMNS, WIDTH)


def write_sheet(path: Path, scene: Scene, rollout: Rollout, sentence: str) -> None:
    """Writes the sheet as PNG, and the sentence beside it as text."""
    path.parent.mkdir(parents=True, exist_ok=True)
    cv2.imwrite(str(path), sheet_of(scene, rollout)[:, :, ::-1])
    path.with_suffix(".txt").write_text(sentence + "\n", encoding="utf-8")


if __name__ == "__main__":
    _main()
