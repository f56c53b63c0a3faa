"""A whole case from the photo to a pass: the real rooms, a real server, a scripted model."""

from __future__ import annotations

import base64
import functools
import re
from collections.abc import Callable
from typing import Any, TypeVar

import cv2
import numpy as np
import pytest

from physagent_studio.agent.crew import Bench
from physagent_studio.agent.loop import advance
from physagent_studio.agent.vlm import CallLog, crew_from_environment
from physagent_studio.assets import assets_dir
from physagent_studio.contract import measure
from physagent_studio.exchange import load_case
from physagent_studio.program import SceneState
from physagent_studio.reconstruction import reconstruct
from physagent_studio.records import Case, Image, LoopState, Rollout, Scene
from physagent_studio.rendering import Compositor
from physagent_studio.simulation import simulate
from tests.agent.vlm import scripted
from tests.agent.vlm.server import Asked, Model, ModelServer, Reply, says

Serve = Callable[[Model], ModelServer]
T = TypeVar("T")


def keep(shelf: dict[str, T]) -> Callable[[T], str]:
    def put(item: T) -> str:
        shelf[f"k{len(shelf)}"] = item
        return f"k{len(shelf) - 1}"

    return put


def real_bench(case: Case) -> Bench:
    """The rooms as the workbench binds them, everything kept in memory."""
    scenes: dict[str, Scene] = {}
    rollouts: dict[str, Rollout] = {}
    known: dict[str, Scene] = {}

    def see_again(state: SceneState, previous: Scene | None) -> Scene:
        # A completed state reconstructs to itself, so it is known by both keys.
        if (key := state.model_dump_json()) not in known:
            scene = reconstruct(case, state, previous=previous)
            known[key] = known[scene.state.model_dump_json()] = scene
        return known[key]

    @functools.cache
    def compositor(key: str) -> Compositor:
        return Compositor(next(scene for scene in known.values() if scene.hash == key))

    def view(scene: Scene) -> Image:
        objects = scene.state.objects
        positions = np.array([item.position for item in objects], float)
        rotations = np.array([item.rotation for item in objects], float)
        return compositor(scene.hash).frame(positions, rotations).rgb

    def evidence(scene: Scene, rollout: Rollout) -> tuple[Image, ...]:
        frame = compositor(scene.hash).frame
        steps = rollout.frame_steps()[::3]
        return tuple(frame(rollout.positions[i], rollout.rotations[i]).rgb for i in steps)

    return Bench(
        case=case,
        reconstruct=see_again,
        simulate=lambda program, scene: simulate(program, scene.meshes),
        measure=lambda program, rollout, scene: measure(program, rollout),
        view=view,
        evidence=evidence,
        put_scene=keep(scenes),
        get_scene=scenes.__getitem__,
        put_rollout=keep(rollouts),
        get_rollout=rollouts.__getitem__,
        put_frames=lambda frames: f"{len(frames)} frames",
    )


def see() -> dict[str, Any]:
    names = {"red_ball": "rubber", "wooden_block": "wood", "green_cube": "wood"}
    return {
        "objects": [
            {"name": name, "material": material, "support": "floor"}
            for name, material in names.items()
        ],
        "supports": [{"name": "floor", "material": "wood"}],
        "landmarks": [],
    }


def stage() -> dict[str, Any]:
    parts = [
        {"id": "rolls", "kind": "moves", "subject": "red_ball", "direction": "right"},
        {"id": "hits", "kind": "contacts", "subject": "red_ball", "other": "wooden_block"},
        {"id": "falls", "kind": "topples", "subject": "wooden_block"},
    ]
    texts = ("The red ball rolls to the right", "hits the wooden block", "and knocks it over")
    push = {
        "id": "push",
        "operator": "SetVelocity",
        "name": "red_ball",
        "velocity": {"magnitude": 0.5, "toward": "wooden_block"},
    }
    return {
        "clauses": [{"id": f"c{i}", "text": text} for i, text in enumerate(texts)],
        "statements": [part | {"clause": f"c{i}"} for i, part in enumerate(parts)],
        "actions": [push],
    }


def judge(asked: Asked) -> dict[str, Any]:
    """Believes the measured facts and says what it sees of each clause."""
    passed = scripted.holds(asked)
    clauses = [
        {"clause": f"c{i}", "ok": passed, "reason": f"figure {i} of the facts"} for i in range(3)
    ]
    wrong = {"code": "not_toppled", "subject": "wooden_block", "text": "it still stands"}
    mismatches = [] if passed else [wrong]
    return scripted.stage_two(passed) | {"clauses": clauses, "mismatches": mismatches}


def mend(asked: Asked) -> dict[str, Any]:
    """A little more speed, as much as an eye follows; then a heavy ball against a light block."""
    if scripted.speed_shown(asked) < 0.6:
        return scripted.faster(0.6)
    edits = [
        {"op": "set", "path": f"scene.objects.{name}.density", "value": density}
        for name, density in (("red_ball", 4000.0), ("wooden_block", 60.0))
    ]
    hunks = [{"summary": "a stone ball, a hollow block", "edits": edits}]
    return scripted.faster(0.6) | {"factor": "density", "hunks": hunks}


def model(asked: Asked) -> Reply:
    answers: dict[str, Callable[[], Any]] = {
        "SceneReply": see,
        "EventReply": stage,
        "StageOneReply": scripted.stage_one,
        "StageTwoReply": lambda: judge(asked),
        "EventPlan": lambda: mend(asked),
    }
    return says(answers[asked.form]())


def decoded(url: str) -> Image:
    data = np.frombuffer(base64.b64decode(url.partition(",")[2]), np.uint8)
    picture = cv2.imdecode(data, cv2.IMREAD_COLOR_RGB)
    assert picture is not None
    return np.asarray(picture, np.uint8)


@pytest.mark.slow
def test_a_case_from_the_photo_to_a_pass(
    serve: Serve, tmp_path: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    server = serve(model)
    monkeypatch.setenv("PHYSAGENT_VLM_BASE_URL", server.url)
    monkeypatch.setenv("PHYSAGENT_VLM_MODEL", "scripted")
    monkeypatch.setenv("PHYSAGENT_VLM_KEY", "sk-local")
    monkeypatch.setenv("PHYSAGENT_VLM_LOG", str(tmp_path / "calls.jsonl"))
    case = load_case(assets_dir() / "demo", "knocks_block_over")
    assert case.image is not None
    bench = real_bench(case)
    crew = crew_from_environment(lambda: False)
    state = LoopState(policy="auto")
    while state.phase != "done":
        state = advance(state, crew, bench)

    assert state.outcome == "realised"
    # The first program is too gentle to knock the block over, and is repaired.
    assert len(state.path()) > 1
    first, last = state.path()[0], state.path()[-1]
    assert first.assessment is not None
    assert last.assessment is not None
    assert [one.name for one in last.assessment.clauses] == [
        "The red ball rolls to the right",
        "hits the wooden block",
        "and knocks it over",
    ]
    assert last.assessment.untested == ()
    assert [item.code for item in first.assessment.diagnosis][:1] == ["not_toppled"]
    assert [item.frames for item in state.path()] == ["27 frames"] * len(state.path())
    # The scene is the case's own, completed by the reconstruction.
    assert last.program.scene.is_resolved
    assert [(o.name, o.grounding) for o in last.program.scene.objects] == list(case.objects)

    pictures = {asked.form: decoded(asked.pictures[0]) for asked in server.asked if asked.pictures}
    assert pictures["SceneReply"].shape == case.image.shape
    # Away from the ruler's marks it is the photo, as far as JPEG goes.
    difference = np.abs(pictures["SceneReply"][60:, 80:].astype(int) - case.image[60:, 80:])
    assert np.median(difference) <= 3
    assert pictures["StageOneReply"].shape[1] > 3 * pictures["StageOneReply"].shape[0]
    calls = CallLog(tmp_path / "calls.jsonl").read()
    assert [call.outcome for call in calls] == ["ok"] * len(server.asked)
    roles = {call.purpose: call.role for call in calls}
    assert roles["planner.propose"] == "planner"
    assert roles["verifier.scene"] == "verifier"
    assert all(asked.headers["authorization"] == "Bearer sk-local" for asked in server.asked)
    assert re.search(r"red_ball; sphere", server.asked[1].text("user"))
