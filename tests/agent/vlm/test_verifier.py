"""The verifier: what it is shown, what it concludes, and what it does with contradictions."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import pytest

from physagent_studio.agent.crew import Crew
from physagent_studio.agent.loop import advance
from physagent_studio.agent.vlm import VlmGenerator, VlmPlanner, VlmVerifier
from physagent_studio.program import (
    PhysicalProgram,
)
from physagent_studio.records import (
    Finding,
    LoopState,
    RolloutEvidence,
    SceneEvidence,
)
from tests.agent.vlm import scripted, world
from tests.agent.vlm.helpers import Connect, Serve, program, replies
from tests.agent.vlm.server import Asked, says


def rollout_evidence(first: PhysicalProgram) -> RolloutEvidence:
    bench = world.bench()
    scene = world.reconstruct(first.scene)
    rollout = world.simulate(first, scene)
    checks = bench.measure(first, rollout, scene)
    return RolloutEvidence(first, scene, rollout, checks, bench.evidence(scene, rollout))


def test_stage_two_is_shown_the_frames_and_the_measured_facts(
    serve: Serve, connect: Connect
) -> None:
    evidence = rollout_evidence(program(serve, connect))
    for style, count in (("sheet", 1), ("images", 27)):
        server = serve(replies(scripted.stage_two(False)))
        VlmVerifier(connect(server), style).judge(evidence, world.SENTENCE)  # type: ignore[arg-type]
        asked = server.asked[0]
        assert len(asked.pictures) == count
        text = asked.text("user")
        assert "moves to the right 0.5 m ≥ 1.8 m: no" in text
        assert "ball: from [-1, 3, 0.1] to [-0.5, 3, 0.1] m" in text
        assert "acted on steps 0 to 1" in text
    assert "Picture: x79  3.12 s" in text


def test_without_frames_it_judges_from_the_facts(serve: Serve, connect: Connect) -> None:
    evidence = replace(rollout_evidence(program(serve, connect)), frames=())
    server = serve(replies(scripted.stage_two(False)))
    VlmVerifier(connect(server)).judge(evidence, world.SENTENCE)
    assert server.asked[0].pictures == []
    assert "No pictures are given" in server.asked[0].text("user")


def test_a_verdict_carries_clauses_criteria_and_mismatches(serve: Serve, connect: Connect) -> None:
    evidence = rollout_evidence(program(serve, connect))
    server = serve(replies(scripted.stage_two(False)))
    verdict = VlmVerifier(connect(server)).judge(evidence, world.SENTENCE)
    assert not verdict.passed
    assert verdict.contradiction == ""
    assert [(one.name, one.ok) for one in verdict.clauses] == [(world.SENTENCE, False)]
    assert [one.ok for one in verdict.criteria] == [False, True, True, True]
    seen, measured, shown = verdict.diagnosis
    assert (seen.code, seen.subject, seen.step) == ("falls_short", "ball", 160)
    assert (measured.code, measured.check) == ("falls_short", "s1")
    assert measured.figures["measured"] == pytest.approx(0.5, abs=0.01)
    # It is over after a second of the three.
    assert shown.check == "view.fills"


@pytest.mark.parametrize(("speed", "says_passed"), [(1.0, True), (2.0, False)])
def test_a_verdict_against_the_measured_contract_is_flagged_and_does_not_pass(
    speed: float, says_passed: bool, serve: Serve, connect: Connect
) -> None:
    evidence = rollout_evidence(program(serve, connect, speed=speed))
    server = serve(replies(scripted.stage_two(says_passed)))
    verdict = VlmVerifier(connect(server)).judge(evidence, world.SENTENCE)
    assert not verdict.passed
    assert verdict.contradiction
    assert verdict.diagnosis[-1].code == "contradiction"


def test_ask_when_asks_on_a_contradiction_and_auto_goes_on(serve: Serve, connect: Connect) -> None:
    def model(asked: Asked) -> Any:
        if asked.form == "StageTwoReply":
            return says(scripted.stage_two(not scripted.holds(asked)))
        return scripted.competent(asked)

    for policy, phase in (("ask_when", "decide"), ("auto", "reconstruct")):
        line = connect(serve(model))
        crew = Crew(VlmGenerator(line), VlmVerifier(line), VlmPlanner(line))
        bench, state = world.bench(), LoopState.model_validate({"policy": policy})
        for _ in range(5):
            state = advance(state, crew, bench)
        assert state.phase == phase
        proposal = state.path()[0].proposal
        assert proposal is not None
        assert proposal.contradiction.startswith("the model passes the event")


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"clauses": []}, "c1 are not judged"),
        ({"clauses": [{"clause": "c9", "ok": True, "reason": ""}]}, "c1 are not judged"),
        ({"passed": True}, "passed is true, but not ok is: object trajectory, clause c1"),
        (
            {"mismatches": [{"code": "other", "subject": "cat", "text": "gone"}]},
            "there is no cat",
        ),
    ],
)
def test_a_verdict_that_does_not_hold_together_is_sent_back(
    change: dict[str, Any], message: str, serve: Serve, connect: Connect
) -> None:
    evidence = rollout_evidence(program(serve, connect))
    server = serve(replies(scripted.stage_two(False) | change, scripted.stage_two(False)))
    verdict = VlmVerifier(connect(server)).judge(evidence, world.SENTENCE)
    assert message in server.asked[1].text("user")
    assert verdict.diagnosis[0].code == "falls_short"


def test_no_verdict_fails_with_that_reason(serve: Serve, connect: Connect) -> None:
    evidence = rollout_evidence(program(serve, connect, speed=3.0))
    verdict = VlmVerifier(connect(serve(replies("well")))).judge(evidence, world.SENTENCE)
    assert not verdict.passed
    assert verdict.diagnosis[0].code == "no_verdict"
    assert all(one.reason.startswith("no verdict") for one in verdict.criteria)
    assert len(verdict.checks) == len(evidence.checks)


def scene_evidence(serve: Serve, connect: Connect, *findings: Finding) -> SceneEvidence:
    first = program(serve, connect)
    scene = replace(world.reconstruct(first.scene), findings=findings)
    return SceneEvidence(first, scene, world.PHOTO)


def finding(ok: bool, measured: float = 0.2) -> Finding:
    return Finding(
        "contact", "ball", measured, 0.002, "m", ok, "placement", "ball is 200 mm above floor"
    )


def test_stage_one_is_shown_photo_and_view_points_camera_and_findings(
    serve: Serve, connect: Connect
) -> None:
    evidence = scene_evidence(serve, connect, finding(True, 0.0))
    server = serve(replies(scripted.stage_one()))
    verdict = VlmVerifier(connect(server)).judge(evidence, world.SENTENCE)
    text = server.asked[0].text("user")
    assert verdict.passed
    assert len(server.asked[0].pictures) == 1
    assert "ball: (20, 30)" in text
    assert "0.5 m above the floor" in text
    assert "[ok] placement: ball is 200 mm above floor" in text


def test_stage_one_does_not_pass_against_what_was_measured(serve: Serve, connect: Connect) -> None:
    evidence = scene_evidence(serve, connect, finding(False), finding(False, float("nan")))
    verdict = VlmVerifier(connect(serve(replies(scripted.stage_one())))).judge(evidence, "x")
    assert not verdict.passed
    assert "200 mm above floor" in verdict.contradiction
    assert [one.code for one in verdict.diagnosis] == ["wrong_place"] * 2 + ["contradiction"]
