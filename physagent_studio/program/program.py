"""`PhysicalProgram`, P = (S, E): the executable hypothesis, and the only thing that is edited."""

from __future__ import annotations

import hashlib
import json
from typing import Annotated, Any

from pydantic import Field, model_validator

from physagent_studio.program.actions import Action, After, Directed, OnContact, When, duration_of
from physagent_studio.program.base import Frozen, Text
from physagent_studio.program.contract import Contract, spoken_of
from physagent_studio.program.scene.aloft import AIR, problem_of
from physagent_studio.program.scene.materials import MATERIALS
from physagent_studio.program.scene.state import SceneState


class Clip(Frozen):
    """Time: `frames` frames of `steps_per_frame` control steps of `step_seconds`.

    The engine divides a step into `substeps`; `playback_fps` is how fast the clip is shown.
    Frame 0 is the initial state, so 81 frames have 80 intervals and the last step is 319.
    """

    frames: Annotated[int, Field(ge=2, le=2000)] = 81
    step_seconds: Annotated[float, Field(ge=1e-4, le=0.1)] = 0.01
    steps_per_frame: Annotated[int, Field(ge=1, le=100)] = 4
    substeps: Annotated[int, Field(ge=1, le=1000)] = 10
    playback_fps: Annotated[float, Field(ge=1, le=120)] = 25.0

    @property
    def steps(self) -> int:
        """Number of control steps in the clip."""
        return (self.frames - 1) * self.steps_per_frame

    @property
    def seconds(self) -> float:
        """Simulated time of the clip."""
        return self.steps * self.step_seconds

    @property
    def time_factor(self) -> float:
        """Simulated seconds for each second that is shown: less than 1 is slow motion, more than
        1 time lapse."""
        return round(self.steps_per_frame * self.step_seconds * self.playback_fps, 6)


class EventProgram(Frozen):
    """E: the prompt it serves and the schedule of actions."""

    prompt: Text = ""
    actions: tuple[Action, ...] = Field(default=(), max_length=500)


class PhysicalProgram(Frozen):
    """P = (S, E) with its clip and its contract; immutable data, no code."""

    version: Annotated[int, Field(ge=1, le=1)] = 1
    clip: Clip = Clip()
    scene: SceneState = SceneState()
    event: EventProgram = EventProgram()
    contract: Contract = Contract()

    @model_validator(mode="after")
    def _consistent(self) -> PhysicalProgram:
        problems = [*_duplicates(self), *_unknown_names(self), *_windows(self)]
        if problems:
            raise ValueError("\n".join(problems))
        return self

    @property
    def hash(self) -> str:
        """SHA-256 of the canonical JSON form."""
        unused: dict[str, Any] = {"scene": self.scene.without}
        # Told later than version 1: a program without them keeps the hash that it always had.
        later = ("paces", "leaving", "partly", "backwards")
        unused["contract"] = {name for name in later if not getattr(self.contract, name)}
        data = self.model_dump(mode="json", exclude=unused)
        data |= {room: _as_it_was(data[room]) for room in ("event", "contract")}
        text = _canonical(data)
        if "-0.0" in text:
            text = _canonical(unsigned_zeros(data))
        return hashlib.sha256(text.encode()).hexdigest()

    def action(self, action_id: str) -> Action | None:
        """The action of that id, or None."""
        return next((item for item in self.event.actions if item.id == action_id), None)


_canonical = json.JSONEncoder(sort_keys=True, separators=(",", ":")).encode


def _as_it_was(data: Any) -> Any:
    """Plain data without what statements of version 1 did not have, where it is not told."""
    if isinstance(data, list):
        return [_as_it_was(value) for value in data]
    if not isinstance(data, dict):
        return data
    later = ("most", "onto") if data.get("kind") == "topples" else ()
    kept = {k: v for k, v in data.items() if k not in later or v is not None}
    return {key: _as_it_was(value) for key, value in kept.items()}


def unsigned_zeros(data: Any) -> Any:
    """Plain data in which −0.0 is 0.0, which it is equal to."""
    if isinstance(data, dict):
        return {key: unsigned_zeros(value) for key, value in data.items()}
    if isinstance(data, list):
        return [unsigned_zeros(value) for value in data]
    return data + 0.0 if isinstance(data, float) else data


# Each finding is "path|message|allowed" on one line; `program.problems` reads them back.


def _duplicates(program: PhysicalProgram) -> list[str]:
    scene = program.scene
    problems: list[str] = []
    seen: set[str] = set()
    for room, items in (
        ("objects", scene.objects),
        ("supports", scene.supports),
        ("landmarks", scene.landmarks),
    ):
        for item in items:
            if item.name in seen:
                problems.append(f"scene.{room}.{item.name}|the name is used twice|names are unique")
            if item.name == AIR:
                problems.append(f"scene.{room}.air|'air' means no support|another name")
            seen.add(item.name)
    for path, ids in (
        ("event.actions", [a.id for a in program.event.actions]),
        ("contract.statements", [s.id for s in program.contract.statements]),
        ("contract.clauses", [c.id for c in program.contract.clauses]),
    ):
        problems += [
            f"{path}.{one}|the id is used twice|ids are unique"
            for one in sorted({i for i in ids if ids.count(i) > 1})
        ]
    return problems


def _unknown(path: str, name: str, known: set[str], what: str) -> list[str]:
    if name in known:
        return []
    return [f"{path}|there is no {what} '{name}'|known: {', '.join(sorted(known)) or 'none'}"]


def _unknown_names(program: PhysicalProgram) -> list[str]:
    scene = program.scene
    objects = {item.name for item in scene.objects}
    solids = objects | {item.name for item in scene.supports}
    places = solids | {item.name for item in scene.landmarks}
    actions = {item.id for item in program.event.actions}
    problems: list[str] = []
    for room, things in (("objects", scene.objects), ("supports", scene.supports)):
        for thing in things:
            path = f"scene.{room}.{thing.name}.material"
            problems += _unknown(path, thing.material, set(MATERIALS), "material")
    for item in scene.objects:
        if item.support is not None:
            path = f"scene.objects.{item.name}.support"
            problems += _unknown(path, item.support, (solids | {AIR}) - {item.name}, "support")
        if problem := problem_of(item):
            problems.append(f"scene.objects.{item.name}.{problem}")
    for action in program.event.actions:
        path = f"event.actions.{action.id}"
        problems += _unknown(f"{path}.name", action.name, objects, "object")
        for field in ("velocity", "angular_velocity", "force", "torque"):
            vector = getattr(action, field, None)
            if isinstance(vector, Directed) and isinstance(vector.toward, str):
                problems += _unknown(f"{path}.{field}.toward", vector.toward, places, "place")
        if isinstance(action.when, OnContact):
            problems += _unknown(f"{path}.when.a", action.when.a, solids, "object or support")
            problems += _unknown(f"{path}.when.b", action.when.b, solids, "object or support")
        if isinstance(action.when, After):
            others = actions - {action.id}
            problems += _unknown(f"{path}.when.action", action.when.action, others, "action")
        if isinstance(action.when, When):
            path = f"{path}.when.statement"
            problems += _unknown_in_statement(path, action.when.statement, objects, places)
    return problems + _unknown_in_contract(program, objects, places)


def _unknown_in_statement(
    path: str, statement: object, objects: set[str], places: set[str]
) -> list[str]:
    problems: list[str] = []
    if (subject := getattr(statement, "subject", None)) is not None:
        problems += _unknown(f"{path}.subject", subject, objects, "object")
    for field in ("other", "landmark", "near", "before", "toward"):
        if (name := getattr(statement, field, None)) is not None:
            problems += _unknown(f"{path}.{field}", name, places, "place")
    return problems


def _unknown_in_contract(
    program: PhysicalProgram, objects: set[str], places: set[str]
) -> list[str]:
    problems: list[str] = _circular(program)
    clauses = {clause.id for clause in program.contract.clauses}
    ids = {statement.id for statement in program.contract.statements}
    for statement in program.contract.statements:
        path = f"contract.statements.{statement.id}"
        if statement.clause is not None:
            problems += _unknown(f"{path}.clause", statement.clause, clauses, "clause")
        problems += _unknown_in_statement(path, statement, objects, places)
        if getattr(statement, "low", 0) > getattr(statement, "high", 1e9):
            problems.append(f"{path}.low|is more than high|at most {getattr(statement, 'high', 0)}")
        if (statement.to_step or 100_000) < (statement.from_step or 0):
            problems.append(f"{path}.to_step|comes before from_step|{statement.from_step} or more")
        for name in spoken_of(statement):
            problems += _unknown(path, name, ids - {statement.id}, "statement")
    return problems


def _circular(program: PhysicalProgram) -> list[str]:
    """Composites that lead back to themselves through others."""
    parts = {one.id: spoken_of(one) for one in program.contract.statements}
    problems: list[str] = []
    for start in parts:
        seen: set[str] = set()
        ahead = [name for name in parts[start] if name != start]
        while ahead:
            name = ahead.pop()
            if name == start:
                path = f"contract.statements.{start}"
                problems.append(f"{path}|refers to itself through other statements|none may")
                break
            if name not in seen:
                seen.add(name)
                ahead += parts.get(name, ())
    return problems


def _windows(program: PhysicalProgram) -> list[str]:
    steps = program.clip.steps
    problems: list[str] = []
    for action in program.event.actions:
        path = f"event.actions.{action.id}"
        if action.when is None and action.start_step >= steps:
            problems.append(
                f"{path}.start_step|step {action.start_step} lies past the end of the clip"
                f"|0 … {steps - 1}"
            )
        elif action.when is None and action.start_step + duration_of(action) > steps:
            problems.append(
                f"{path}.duration|{duration_of(action)} steps from step {action.start_step} "
                f"run past the end of the clip|at most {steps - action.start_step}"
            )
    return problems
