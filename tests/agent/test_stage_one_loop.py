"""Stage 1 with the real reconstruction: what is wrong in the picture is found and repaired there.

Each test spoils one fact of a small scene whose truth is known, then lets the loop run until
stage 1 holds. Nothing may be simulated before, and nothing but the spoilt factor may change.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from physagent_studio.agent.crew import Bench, Crew
from physagent_studio.agent.loop import advance
from physagent_studio.agent.rules import RuleGenerator, RulePlanner, RuleVerifier
from physagent_studio.exchange import load_case
from physagent_studio.program import PhysicalProgram, SceneState, apply
from physagent_studio.program.edits import Edit, SetField
from physagent_studio.reconstruction import reconstruct
from physagent_studio.records import Case, LoopState, Rollout, Scene

pytestmark = pytest.mark.usefixtures("unfilled")

SCENES = Path(__file__).parent.parent / "data" / "synthetic"


class Never(Exception):
    """Raised where something is simulated."""


class Room:
    """A bench whose simulator counts its calls and refuses them."""

    def __init__(self, case: Case) -> None:
        self.case = case
        self.calls = 0
        self.scenes: dict[str, Scene] = {}

    def bench(self) -> Bench:
        return Bench(
            case=self.case,
            reconstruct=lambda state, before: reconstruct(self.case, state, previous=before),
            simulate=self._simulate,
            measure=lambda program, rollout, scene: (),
            view=lambda scene: None,
            evidence=lambda scene, rollout: (),
            put_scene=self._put,
            get_scene=self.scenes.__getitem__,
            put_rollout=lambda rollout: "",
            get_rollout=self._get_rollout,
            put_frames=lambda frames: "",
        )

    def _put(self, scene: Scene) -> str:
        # A session stores them as JSON.
        assert all(type(finding.ok) is bool for finding in scene.findings)
        self.scenes[scene.hash] = scene
        return scene.hash

    def _simulate(self, program: PhysicalProgram, scene: Scene) -> Rollout:
        self.calls += 1
        raise Never

    def _get_rollout(self, key: str) -> Rollout:
        raise Never


class Spoilt:
    """A generator that spoils its program, as a wrong click or a wrong word would."""

    def __init__(self, *edits: Edit) -> None:
        self.edits = edits

    def first(self, case: Case, reconstruct: object) -> PhysicalProgram:
        program = RuleGenerator().first(case, reconstruct)  # type: ignore[arg-type]
        return apply(program, self.edits)


def repaired(name: str, *edits: Edit) -> tuple[LoopState, Room]:
    """The state when stage 1 holds and the first simulation is asked for."""
    room = Room(load_case(SCENES / name, None))
    crew = Crew(Spoilt(*edits), RuleVerifier(), RulePlanner())
    state = LoopState(policy="auto", budget=10)
    while state.phase != "done" and state.phase != "simulate":
        state = advance(state, crew, room.bench())
    assert room.calls == 0
    assert state.phase == "simulate", [m.text for m in state.rounds[-1].assessment.diagnosis]  # type: ignore[union-attr]
    first = state.rounds[0].assessment
    assert first is not None
    assert first.stage == "reconstruction"
    assert not first.passed
    return state, room


def open_object(name: str) -> tuple[Edit, ...]:
    base = f"scene.objects.{name}"
    return tuple(SetField(path=f"{base}.{field}", value=None) for field in ("shape", "position"))


def open_all(state: SceneState) -> tuple[Edit, ...]:
    opened = [edit for item in state.objects for edit in open_object(item.name)]
    shapes = [f"scene.supports.{item.name}.shape" for item in state.supports]
    return (
        SetField(path="scene.camera", value=None),
        *opened,
        *(SetField(path=path, value=None) for path in shapes),
    )


def untouched(before: PhysicalProgram, after: PhysicalProgram, *names: str) -> None:
    """Everything but the named objects is the same."""
    same = [item.name for item in before.scene.objects if item.name not in names]
    for name in same:
        assert before.scene.object(name) == after.scene.object(name)
    assert before.scene.supports == after.scene.supports
    assert before.scene.camera == after.scene.camera
    assert before.event == after.event
    assert before.contract == after.contract


@pytest.mark.parametrize(
    ("name", "wrong", "right"),
    [
        ("yellow_cube", "floor", "table"),
        pytest.param("blue_ball", "table", "floor", marks=pytest.mark.slow),
    ],
)
def test_a_wrong_support_is_found_anew(name: str, wrong: str, right: str) -> None:
    state, _ = repaired(
        "table",
        SetField(path=f"scene.objects.{name}.support", value=wrong),
        *open_object(name),
    )
    assert state.rounds[0].proposal is not None
    assert state.rounds[0].proposal.factor == "support"
    last = state.rounds[-1].program
    item = last.scene.object(name)
    assert item is not None
    assert item.support == right
    untouched(state.rounds[0].program, last, name)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("x", "y"),
    [
        pytest.param(91.0, 133.0, id="a box"),
        pytest.param(30.0, 225.0, id="the floor"),
    ],
)
def test_a_wrong_click_goes_to_what_is_called_so(x: float, y: float) -> None:
    points = "scene.objects.yellow_ball.grounding.points"
    state, _ = repaired(
        "shapes_1",
        SetField(path=points, value=[{"x": x, "y": y}]),
        *open_object("yellow_ball"),
    )
    assert state.rounds[0].proposal is not None
    assert state.rounds[0].proposal.factor == "image points"
    last = state.rounds[-1].program
    ball = last.scene.object("yellow_ball")
    assert ball is not None
    click = ball.grounding.points[0]
    assert np.hypot(click.x - 299, click.y - 119) < 16, "the ball's true place in the picture"
    before = state.rounds[0].program
    assert last.scene.object("grey_box").grounding == before.scene.object("grey_box").grounding  # type: ignore[union-attr]
    assert last.event == before.event
    assert last.contract == before.contract


@pytest.mark.slow
@pytest.mark.parametrize(
    ("scene", "row"),
    [("shapes_1", 200.0), ("shapes_3", -150.0)],
)
def test_a_wrong_camera_is_taken_from_the_picture(scene: str, row: float) -> None:
    case = load_case(SCENES / scene, None)
    start = RuleGenerator().first(case, lambda state: reconstruct(case, state))
    state, _ = repaired(scene, SetField(path="scene.horizon", value=row), *open_all(start.scene))
    assert state.rounds[0].proposal is not None
    assert state.rounds[0].proposal.factor == "camera"
    assert start.scene.camera is not None
    before, last = state.rounds[0].program, state.rounds[-1].program
    assert last.scene.camera is not None
    assert last.scene.camera.horizon == pytest.approx(start.scene.camera.horizon, abs=3.0)
    assert [o.grounding for o in last.scene.objects] == [o.grounding for o in before.scene.objects]
    assert last.event == before.event
    assert last.contract == before.contract
