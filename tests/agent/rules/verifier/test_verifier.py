"""Verdicts: the scene by its findings, the rollout by contract, physics and what is seen."""

from __future__ import annotations

import math
from dataclasses import replace

import pytest

from physagent_studio.agent.rules import RuleGenerator, RuleVerifier
from physagent_studio.agent.rules.verifier.diagnosing import mismatches
from physagent_studio.benchmark.physics import scenes
from physagent_studio.contract import measure
from physagent_studio.contract.words import number
from physagent_studio.program import PhysicalProgram
from physagent_studio.program.actions import FixObject, SetVelocity
from physagent_studio.program.contract import Contract
from physagent_studio.program.scene.state import Box, Sphere
from physagent_studio.program.statements import Contacts, Topples
from physagent_studio.records import (
    CRITERIA,
    Assessment,
    Finding,
    RolloutEvidence,
    SceneEvidence,
)
from physagent_studio.simulation import simulate
from tests.agent.rules.scenes import CAMERA, STAGES

ROLLS = "The ball rolls forward and crosses the goal line."


def first(stage: str, prompt: str) -> PhysicalProgram:
    return RuleGenerator().first(STAGES[stage].case(prompt), STAGES[stage].reconstruct)


def judged(stage: str, program: PhysicalProgram) -> Assessment:
    rollout = simulate(program, {})
    scene = STAGES[stage].reconstruct(program.scene)
    evidence = RolloutEvidence(program, scene, rollout, measure(program, rollout))
    return RuleVerifier().judge(evidence, program.event.prompt)


def still(program: PhysicalProgram) -> PhysicalProgram:
    return program.model_copy(update={"event": program.event.model_copy(update={"actions": ()})})


def scene_evidence(*findings: Finding, confirmed: bool = True) -> SceneEvidence:
    program = first("field", ROLLS)
    camera = CAMERA.model_copy(
        update={"confirmed": confirmed, "source": "given" if confirmed else "estimated"}
    )
    scene = STAGES["field"].reconstruct(program.scene)
    state = scene.state.model_copy(update={"camera": camera})
    return SceneEvidence(program, replace(scene, state=state, findings=findings), None)


def finding(kind: str, name: str, measured: float, threshold: float, ok: bool) -> Finding:
    return Finding(name, "ball", measured, threshold, "", ok, kind, f"{name} {measured}")  # type: ignore[arg-type]


def test_the_event_passes_with_all_four_criteria() -> None:
    verdict = judged("field", first("field", ROLLS))
    assert verdict.passed
    assert tuple(c.name for c in verdict.criteria) == CRITERIA
    assert all(c.ok and c.reason for c in verdict.criteria)
    assert not verdict.diagnosis
    assert not verdict.untested


def test_nothing_happening_fails_and_says_so() -> None:
    verdict = judged("field", still(first("field", ROLLS)))
    assert not verdict.passed
    assert {m.code for m in verdict.diagnosis} >= {"does_not_move", "not_visible"}
    assert not all(c.ok for c in verdict.criteria)


@pytest.mark.parametrize(("left", "code"), [(0.0, "falls_short"), (0.6, "misses")])
def test_a_miss_is_told_with_the_gap_and_the_frame_of_its_check(left: float, code: str) -> None:
    ball = scenes.thing("ball", Sphere(radius=0.1), (-0.6, -left, 0.1))
    box = scenes.thing("box", Box(size=(0.2, 0.2, 0.2)), (0.6, 0, 0.1))
    hits = Contacts(id="hits", subject="ball", other="box")
    roll = SetVelocity(id="roll", name="ball", velocity=(1.0, 0, 0))
    brake = FixObject(id="brake", name="ball", start_step=70, duration=90)
    actions = [roll] if left else [roll, brake]
    clip = scenes.program([ball, box], [scenes.ground()], actions, seconds=1.6)
    clip = clip.model_copy(update={"contract": Contract(statements=(hits,))})
    rollout = simulate(clip)
    (check,) = (c for c in measure(clip, rollout) if not c.always_on)
    (miss,) = mismatches(clip, rollout, (check,))
    assert miss.code == code
    assert check.measured is not None
    assert check.step is not None
    gap = number(-check.measured, "m")
    assert gap in check.text
    assert gap in miss.text
    assert miss.text.endswith(f"of box at frame {rollout.frame_of(check.step)}")


@pytest.mark.parametrize(
    ("most", "turn", "code"), [(125.0, 180.0, "too_much_turn"), (125.0, 20.0, "not_toppled")]
)
def test_what_turns_too_far_is_told_from_what_does_not_fall(most, turn, code) -> None:
    program = first("desk", "The red cube is pushed to the left.")
    over = Topples(id="over", subject="red_cube", tilt=60.0, most=most)
    program = program.model_copy(update={"contract": Contract(statements=(over,))})
    rollout = simulate(program, {})
    rotations = rollout.rotations.copy()
    half = math.radians(turn) / 2
    rotations[1:, rollout.index("red_cube")] = (math.cos(half), math.sin(half), 0.0, 0.0)
    rollout = replace(rollout, rotations=rotations)
    checks = tuple(c for c in measure(program, rollout) if c.id == "over")
    assert [m.code for m in mismatches(program, rollout, checks)] == [code]


def test_a_diagnosis_has_figures_and_no_remedy() -> None:
    verdict = judged("field", still(first("field", ROLLS)))
    for mismatch in verdict.diagnosis:
        assert mismatch.text
        assert mismatch.check
        assert not any(word in mismatch.text for word in ("should", "increase", "try", "set "))


def test_a_contract_without_statements_never_passes() -> None:
    program = first("field", ROLLS).model_copy(update={"contract": Contract()})
    assert not judged("field", program).passed


def test_untested_clauses_are_listed() -> None:
    verdict = judged("field", first("field", "The ball rolls forward while the crowd cheers."))
    assert verdict.untested[0] == "while the crowd cheers"


def test_what_happens_only_at_the_very_end_is_not_seen() -> None:
    program = first("field", ROLLS)
    late = tuple(action.model_copy(update={"start_step": 305}) for action in program.event.actions)
    event = program.event.model_copy(update={"actions": late})
    verdict = judged("field", program.model_copy(update={"event": event}))
    assert not verdict.passed


def test_good_findings_pass_stage_one() -> None:
    verdict = RuleVerifier().judge(
        scene_evidence(finding("mask", "reprojection", 0.93, 0.8, True)), ROLLS
    )
    assert verdict.stage == "reconstruction"
    assert verdict.passed


def test_a_bad_placement_fails_stage_one() -> None:
    verdict = RuleVerifier().judge(
        scene_evidence(finding("placement", "contact", 0.2, 0.002, False)), ROLLS
    )
    assert not verdict.passed
    assert verdict.diagnosis[0].code == "placement_contact"


def test_an_estimated_camera_is_reported_and_not_failed() -> None:
    bad = finding("camera", "horizon", 0.2, 0.15, False)
    verdict = RuleVerifier().judge(scene_evidence(bad, confirmed=False), ROLLS)
    assert verdict.passed
    assert verdict.untested
    assert not RuleVerifier().judge(scene_evidence(bad, confirmed=True), ROLLS).passed


def test_what_shall_stay_need_not_be_seen_to_move() -> None:
    verdict = judged("stack", first("stack", "The boxes stay where they are."))
    assert verdict.passed, [m.text for m in verdict.diagnosis]


def test_a_miss_has_to_be_seen() -> None:
    program = first("lane", "The bowling ball rolls forward and misses the pins.")
    assert not judged("lane", still(program)).passed
