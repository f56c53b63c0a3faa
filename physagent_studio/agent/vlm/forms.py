"""The forms of the model's replies. What they hold is only accepted after `PhysicalProgram` has."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import Field, JsonValue, model_validator

from physagent_studio.program import (
    MATERIALS,
    Action,
    Clause,
    Click,
    Directed,
    Frozen,
    MoveItem,
    RemoveItem,
    Statement,
)
from physagent_studio.program.base import Length, Name, Pixel
from physagent_studio.program.edits import Path
from physagent_studio.program.scene.bodies import Body
from physagent_studio.program.scene.state import Density, Shape
from physagent_studio.records import CRITERIA

Words = Annotated[str, Field(max_length=2000)]


_KNOWN: list[JsonValue] = [*sorted(MATERIALS)]
Material = Annotated[str, Field(json_schema_extra={"enum": _KNOWN})]

# --- generator -------------------------------------------------------------------------------


class SeenObject(Frozen):
    """A thing that can move. points: pixels of the picture, label 1 on it and 0 beside it.

    box: left, top, right, bottom in pixels. longest_side: its usual size in metres. support:
    what it stands on, by name, or "air".
    """

    name: Name
    points: Annotated[tuple[Click, ...], Field(max_length=24)] = ()
    box: tuple[float, float, float, float] | None = None
    material: Material
    density: Density | None = None
    longest_side: Length | None = None
    support: Name | None = None
    body: Body | None = None


class SeenSupport(Frozen):
    """A thing that does not move and carries others. points: pixels on the carrying surface."""

    name: Name
    points: Annotated[tuple[Click, ...], Field(max_length=24)] = ()
    material: Material = "wood"


class SeenLandmark(Frozen):
    """A named place that the event speaks of; pixels in order along it."""

    name: Name
    kind: Literal["point", "line", "area", "opening"]
    on: Name | None = None
    pixels: Annotated[tuple[Pixel, ...], Field(min_length=1, max_length=64)]


class SceneReply(Frozen):
    """What the picture shows, as far as the event needs it.

    scale_reference: the object whose `longest_side` is known best.
    """

    objects: Annotated[tuple[SeenObject, ...], Field(min_length=1, max_length=60)]
    supports: Annotated[tuple[SeenSupport, ...], Field(max_length=30)] = ()
    landmarks: Annotated[tuple[SeenLandmark, ...], Field(max_length=30)] = ()
    scale_reference: Name | None = None


class EventReply(Frozen):
    """The contract (clauses and statements) and the schedule of actions."""

    clauses: Annotated[tuple[Clause, ...], Field(min_length=1, max_length=32)]
    statements: Annotated[tuple[Statement, ...], Field(min_length=1, max_length=64)]
    actions: Annotated[tuple[Action, ...], Field(max_length=64)] = ()
    not_understood: Annotated[tuple[Words, ...], Field(max_length=32)] = ()


# --- verifier --------------------------------------------------------------------------------


class Said(Frozen):
    """A verdict on one aspect with its reason."""

    ok: bool
    reason: Words


class SaidOfClause(Frozen):
    """Whether one clause of the prompt happened, and what shows it."""

    clause: Name
    ok: bool
    reason: Words


SceneFault = Literal[
    "wrong_points", "wrong_mask", "wrong_shape", "wrong_place", "wrong_size", "wrong_support",
    "wrong_camera",
]  # fmt: skip
EventFault = Literal[
    "misses", "too_slow", "too_fast", "falls_short", "overshoots", "wrong_direction", "too_early",
    "too_late", "no_contact", "unwanted_contact", "not_toppled", "toppled", "not_moved", "moved",
    "wrong_material", "left_picture", "not_visible", "other",
]  # fmt: skip


class SceneMismatch(Frozen):
    """What is wrong with the reconstruction; never what to do about it."""

    code: SceneFault
    subject: Name
    text: Words


class EventMismatch(Frozen):
    """What went wrong in the rollout; never what to do about it. frame: 0 to 80."""

    code: EventFault
    subject: Name
    other: Name | None = None
    text: Words
    frame: Annotated[int, Field(ge=0, le=100_000)] | None = None


class _Verdict(Frozen):
    passed: bool

    def aspects(self) -> dict[str, Said]:
        """What was judged one by one, by name."""
        return {}

    def _failing(self) -> list[str]:
        return [name for name, said in self.aspects().items() if not said.ok]

    @model_validator(mode="after")
    def _of_one_mind(self) -> _Verdict:
        failing = self._failing()
        if self.passed and failing:
            raise ValueError(f"passed is true, but not ok is: {', '.join(failing)}")
        if not self.passed and not failing and not getattr(self, "mismatches", ()):
            raise ValueError("passed is false, but nothing is named that failed; add a mismatch")
        return self


class StageOneReply(_Verdict):
    """The verdict on a reconstruction."""

    points: Said
    shapes: Said
    placement: Said
    supports: Said
    camera: Said
    mismatches: Annotated[tuple[SceneMismatch, ...], Field(max_length=24)] = ()

    def aspects(self) -> dict[str, Said]:
        names = ("points", "shapes", "placement", "supports", "camera")
        return {name: getattr(self, name) for name in names}


class StageTwoReply(_Verdict):
    """The verdict on a rollout: each clause, and the four criteria."""

    clauses: Annotated[tuple[SaidOfClause, ...], Field(max_length=64)] = ()
    object_trajectory: Said
    contact_timing: Said
    force_direction: Said
    material_response: Said
    mismatches: Annotated[tuple[EventMismatch, ...], Field(max_length=24)] = ()

    def aspects(self) -> dict[str, Said]:
        return {name: getattr(self, name.replace(" ", "_")) for name in CRITERIA}

    def _failing(self) -> list[str]:
        return super()._failing() + [f"clause {one.clause}" for one in self.clauses if not one.ok]


# --- planner ---------------------------------------------------------------------------------


class SetValue(Frozen):
    """Sets the field at `path`; null opens a field, so that the picture decides it anew."""

    op: Literal["set"] = "set"
    path: Path
    value: (
        bool
        | int
        | float
        | Annotated[str, Field(max_length=200)]
        | Annotated[tuple[float, ...], Field(max_length=64)]
        | Annotated[tuple[Click, ...], Field(max_length=24)]
        | Directed
        | Shape
        | None
    )


class AddAction(Frozen):
    """Adds an action to the schedule, at `index` or at the end."""

    op: Literal["add"] = "add"
    path: Literal["event.actions"] = "event.actions"
    item: Action
    index: Annotated[int, Field(ge=0, le=10_000)] | None = None


PlannedEdit = Annotated[SetValue | AddAction | RemoveItem | MoveItem, Field(discriminator="op")]
SceneFactor = Literal[
    "image points", "mask candidate", "primitive", "placement", "support", "camera", "scale"
]
EventFactor = Literal[
    "target", "direction", "magnitude", "timing", "duration", "material", "density", "friction",
    "restitution", "support", "pose", "camera",
]  # fmt: skip


class PlannedHunk(Frozen):
    """A part of the repair that a person can accept by itself."""

    summary: Annotated[str, Field(max_length=300)]
    edits: Annotated[tuple[PlannedEdit, ...], Field(min_length=1, max_length=16)]


class _Plan(Frozen):
    """A repair of the one factor that failed; without hunks, a question to a person."""

    hunks: Annotated[tuple[PlannedHunk, ...], Field(max_length=6)] = ()
    rationale: Words
    confidence: Annotated[float, Field(ge=0, le=1)]
    question: Words = ""


class ScenePlan(_Plan):
    """A repair of the reconstruction."""

    factor: SceneFactor


class EventPlan(_Plan):
    """A repair of the event program."""

    factor: EventFactor
