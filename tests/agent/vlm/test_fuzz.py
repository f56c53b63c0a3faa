"""Any JSON at all in a reply: every role ends with a legal value or with its own error."""

from __future__ import annotations

import contextlib
import copy
import json
from dataclasses import dataclass, field
from typing import Any

from hypothesis import given, settings
from hypothesis import strategies as st

from physagent_studio.agent.roles import Situation
from physagent_studio.agent.vlm import VlmError, VlmGenerator, VlmPlanner, VlmVerifier
from physagent_studio.agent.vlm.config import Endpoint
from physagent_studio.agent.vlm.forms import EventReply, SceneReply
from physagent_studio.agent.vlm.generator import program_of, scene_of
from physagent_studio.agent.vlm.line import Line
from physagent_studio.agent.vlm.messages import Answer, Question
from physagent_studio.agent.vlm.spending import Ledger
from physagent_studio.program import apply, value_at
from physagent_studio.records import Assessment, Memory, RolloutEvidence, SceneEvidence
from tests.agent.vlm import scripted, world

PINNED = ("scene.objects.ball.density", "event.actions.push.start_step")
_SCENE = world.reconstruct(
    scene_of(SceneReply.model_validate(scripted.scene()), world.CASE, (64, 48), 1.0)
)
PROGRAM = program_of(EventReply.model_validate(scripted.event()), world.SENTENCE, _SCENE.state)
ROLLOUT = world.simulate(PROGRAM, _SCENE)
CHECKS = world.bench().measure(PROGRAM, ROLLOUT, _SCENE)


@dataclass
class Puppet(Line):
    """A line whose answers are given beforehand, the last one again and again."""

    answers: list[str] = field(default_factory=list)

    def ask(self, question: Question) -> Answer:
        text = self.answers[0]
        self.answers = self.answers[1:] or self.answers
        return Answer(text)


def puppet(*answers: Any) -> Puppet:
    endpoint = Endpoint(base_url="http://127.0.0.1:9/v1", model="m")
    texts = [one if isinstance(one, str) else json.dumps(one) for one in answers]
    return Puppet("planner", endpoint, Ledger(), answers=texts)


WORDS = st.sampled_from(
    [
        *("ball", "floor", "push", "c1", "s1", "set", "add", "remove", "move", "sphere"),
        *("scene.objects.ball.density", "scene.objects.ball.shape", "scene.horizon", ""),
        *("scene.objects.ball.grounding.points", "event.actions", "event.actions.push"),
        *("event.actions.0.id", "ApplyForce"),
    ]
)
LEAVES = (
    st.none()
    | st.booleans()
    | st.integers(-(10**20), 10**20)
    | st.floats(allow_nan=False, allow_infinity=False)
    | WORDS
    | st.text(max_size=8)
)
JSON = st.recursive(
    LEAVES,
    lambda inner: st.lists(inner, max_size=3) | st.dictionaries(WORDS, inner, max_size=3),
    max_leaves=6,
)


def spots(value: Any, here: tuple[Any, ...] = ()) -> list[tuple[Any, ...]]:
    """Every place in plain data."""
    found = [here]
    if isinstance(value, dict):
        found += [spot for key, item in value.items() for spot in spots(item, (*here, key))]
    if isinstance(value, list):
        found += [spot for i, item in enumerate(value) for spot in spots(item, (*here, i))]
    return found


@st.composite
def mutated(draw: st.DrawFn, good: dict[str, Any]) -> Any:
    """A good reply with up to three values replaced or left out."""
    data: Any = copy.deepcopy(good)
    for _ in range(draw(st.integers(1, 3))):
        spot = draw(st.sampled_from(spots(data)))
        if not spot:
            return draw(JSON)
        node = data
        for key in spot[:-1]:
            node = node[key]
        if draw(st.booleans()) and isinstance(node, dict):
            del node[spot[-1]]
        else:
            node[spot[-1]] = draw(JSON)
    return data


EDITS = [
    {"op": "set", "path": "event.actions.push.velocity", "value": [1.0, 0.0, 0.0]},
    {"op": "set", "path": "scene.objects.ball.material", "value": "wood"},
    {"op": "add", "path": "event.actions", "item": scripted.event()["actions"][0] | {"id": "b"}},
    {"op": "move", "path": "event.actions.push", "index": 0},
]
PLAN = scripted.faster(2.0) | {"hunks": [{"summary": "all", "edits": EDITS}]}
SCENE_PLAN = scripted.lower(0.2)


def situation(stage: str) -> Situation:
    assessment = Assessment.model_validate({"stage": stage, "passed": False})

    def no_trial(program: Any) -> Any:
        raise AssertionError

    memory = Memory(pinned=PINNED)
    return Situation(world.CASE, PROGRAM, _SCENE, ROLLOUT, assessment, memory, no_trial)


@settings(max_examples=300, deadline=None)
@given(st.sampled_from(["simulation", "reconstruction"]), st.data())
def test_any_plan_is_a_proposal_that_applies_or_a_question(stage: str, data: st.DataObject) -> None:
    good = PLAN if stage == "simulation" else SCENE_PLAN
    proposal = VlmPlanner(puppet(data.draw(mutated(good)))).propose(situation(stage))
    if not proposal.hunks:
        assert proposal.question
        return
    revised = apply(PROGRAM, proposal.edits)
    for path in PINNED:
        assert value_at(revised, path) == value_at(PROGRAM, path)
    assert revised.contract == PROGRAM.contract
    assert revised.event.prompt == PROGRAM.event.prompt
    assert revised.clip == PROGRAM.clip
    assert revised.scene.gravity == PROGRAM.scene.gravity
    if stage == "reconstruction":
        assert revised.event == PROGRAM.event


@settings(max_examples=200, deadline=None)
@given(mutated(scripted.stage_two(False)))
def test_any_verdict_on_a_rollout_is_an_assessment(reply: Any) -> None:
    evidence = RolloutEvidence(PROGRAM, _SCENE, ROLLOUT, CHECKS)
    verdict = VlmVerifier(puppet(reply)).judge(evidence, world.SENTENCE)
    # The contract of this rollout does not hold, so nothing that is said makes it pass.
    assert verdict.passed is False
    assert len(verdict.criteria) == 4
    assert verdict.diagnosis
    assert Assessment.model_validate_json(verdict.model_dump_json()) == verdict


@settings(max_examples=100, deadline=None)
@given(mutated(scripted.stage_one(False)))
def test_any_verdict_on_a_scene_is_an_assessment(reply: Any) -> None:
    evidence = SceneEvidence(PROGRAM, _SCENE, None)
    verdict = VlmVerifier(puppet(reply)).judge(evidence, world.SENTENCE)
    assert Assessment.model_validate_json(verdict.model_dump_json()) == verdict


@settings(max_examples=150, deadline=None)
@given(mutated(scripted.scene()), mutated(scripted.event()), st.booleans())
def test_any_first_program_is_valid_or_an_error(scene: Any, event: Any, keep: bool) -> None:
    first = scripted.scene() if keep else scene
    with contextlib.suppress(VlmError):
        program = VlmGenerator(puppet(first, event)).first(world.CASE, world.reconstruct)
        assert type(program).model_validate_json(program.model_dump_json()) == program
        assert program.scene.object("ball") is not None
