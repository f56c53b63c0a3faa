"""Every kind of fault, ten rounds each: a legal state, an intact session, a budget that holds."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import pytest

from physagent_studio.agent.crew import Crew
from physagent_studio.agent.loop import advance, decide
from physagent_studio.agent.vlm import VlmError, VlmGenerator, VlmPlanner, VlmVerifier
from physagent_studio.agent.vlm.config import Limits, Patience
from physagent_studio.agent.vlm.line import Line
from physagent_studio.agent.vlm.spending import CallRecord, Ledger
from physagent_studio.program import SetField
from physagent_studio.program.text.document import dump_program, load_program
from physagent_studio.records import Decision, LoopState, Proposal
from physagent_studio.session import Store
from tests.agent.vlm import scripted, world
from tests.agent.vlm.faults import FAULTS, LASTING
from tests.agent.vlm.server import Asked, Model, ModelServer, Reply, says

Serve = Callable[[Model], ModelServer]
Connect = Callable[..., Line]
HASTY = Patience(timeout=0.06, retries=1, backoff=0.0)
LIMITS = Limits(calls=24, tokens=100_000_000)
MAGNITUDE = "event.actions.push.velocity.magnitude"
GENERATING = ("SceneReply", "EventReply")


def crew_with(connect: Connect, server: ModelServer, ledger: Ledger, patience: Patience) -> Crew:
    return Crew(
        VlmGenerator(connect(server, role="generator", ledger=Ledger(LIMITS))),
        VlmVerifier(connect(server, role="verifier", ledger=ledger, patience=patience)),
        VlmPlanner(connect(server, role="planner", ledger=ledger, patience=patience)),
    )


def person(state: LoopState, number: int) -> Decision:
    """Accepts what is proposed; where nothing is, goes on with a number of their own."""
    assert state.current is not None
    proposal, preview = state.current.proposal, state.current.preview
    assert proposal is not None
    assert preview is not None
    if proposal.hunks and not preview.problem:
        return Decision(kind="accept", author="person", at="now", edits=proposal.edits)
    own = SetField(path=MAGNITUDE, value=1.0 + number / 100)
    return Decision(kind="override", author="person", at="now", edits=(own,))


@pytest.mark.parametrize("kind", FAULTS)
def test_ten_rounds_of_one_fault(
    kind: str, serve: Serve, connect: Connect, calls: list[CallRecord], tmp_path: Path
) -> None:
    fault = FAULTS[kind]

    def model(asked: Asked) -> Reply:
        if asked.form == "EventReply":
            # Out of reach, so that the loop uses all its rounds.
            return says(scripted.event(distance=500.0))
        if asked.form == "StageOneReply":
            judged.append(asked)
        # The first stage fails for some rounds and then passes, so that both stages see it.
        well = asked.form in GENERATING or (asked.form == "StageOneReply" and len(judged) > 6)
        return scripted.competent(asked) if well else fault(asked)

    judged: list[Asked] = []
    server = serve(model)
    ledger = Ledger(LIMITS)
    slow = kind in ("silence", "slow drip")
    crew = crew_with(connect, server, ledger, HASTY if slow else Patience(retries=1, backoff=0.0))
    bench = world.bench()
    session = Store(tmp_path / "store").create(world.CASE, LoopState())
    state = LoopState(policy="ask", budget=10, pinned=("scene.objects.ball.density",))
    gravity = None
    while state.phase != "done":
        after = advance(state, crew, bench)
        if after is state:
            after = decide(state, person(state, len(state.rounds)))
        state = after
        assert LoopState.model_validate_json(state.model_dump_json()) == state
        session.save(state)
    assert state.outcome == "budget"
    assert len(state.path()) == 10
    for item in state.path():
        assert item.passed is False
        assert load_program(dump_program(item.program)) == item.program
        # Whatever the model was told: the contract, the sentence and the world stay.
        assert item.program.contract == state.path()[0].program.contract
        assert item.program.event.prompt == world.SENTENCE
        gravity = gravity or item.program.scene.gravity
        assert item.program.scene.gravity == gravity
    session.close()
    reopened = Store(tmp_path / "store").open(session.id)
    assert reopened.load() == state
    reopened.close()
    assert ledger.calls <= LIMITS.calls
    asked = [one for one in server.asked if one.form not in GENERATING]
    assert len(asked) <= LIMITS.calls
    # Every attempt is recorded, also one that ended before the server had read it.
    assert len(calls) >= len(server.asked)


@pytest.mark.parametrize("kind", [name for name in FAULTS if name not in LASTING])
def test_a_fault_that_passes_is_overcome(kind: str, serve: Serve, connect: Connect) -> None:
    """Each question fails once; the answer to the second attempt is taken."""
    seen: set[str] = set()

    def model(asked: Asked) -> Reply:
        question = repr(asked.body["messages"][:2])
        if question in seen or asked.again:
            return scripted.competent(asked)
        seen.add(question)
        if kind == "contradicting":
            return says("{}")
        well = asked.form in GENERATING or (slow and asked.form != "EventPlan")
        return scripted.competent(asked) if well else FAULTS[kind](asked)

    slow = kind in ("silence", "slow drip")
    server = serve(model)
    patience = Patience(timeout=2.0 if slow else 30.0, retries=3, backoff=0)
    crew = crew_with(connect, server, Ledger(Limits()), patience)
    bench, state = world.bench(), LoopState(policy="auto")
    while state.phase != "done":
        state = advance(state, crew, bench)
    assert state.outcome == "realised"
    assert len(state.path()) == 3


@pytest.mark.parametrize("kind", ["401", "prose", "NaN", "refusal", "hangs up", "wrong schema"])
def test_a_generator_that_cannot_says_so_and_the_state_stays(
    kind: str, serve: Serve, connect: Connect
) -> None:
    def model(asked: Asked) -> Reply:
        if kind in ("prose", "NaN", "refusal"):
            return says({"prose": "Well.", "NaN": '{"objects": NaN}', "refusal": ""}[kind])
        return FAULTS[kind](asked)

    crew = crew_with(connect, serve(model), Ledger(LIMITS), HASTY)
    state = LoopState()
    with pytest.raises(VlmError):
        advance(state, crew, world.bench())
    assert state == LoopState()


def proposals(state: LoopState) -> list[Proposal]:
    return [item.proposal for item in state.path() if item.proposal is not None]


def test_tokens_and_money_stop_after_the_call_that_met_the_limit(
    serve: Serve, connect: Connect
) -> None:
    def model(asked: Asked) -> Reply:
        if asked.form == "StageTwoReply":
            return says(scripted.stage_two(False), usage=(700, 100))
        return scripted.competent(asked)

    server = serve(model)
    for limits, spent in (
        (Limits(tokens=1500), lambda ledger: ledger.tokens),
        (Limits(money=0.0015), lambda ledger: ledger.money * 1e6),
    ):
        ledger = Ledger(limits)
        prices = {"input": 1.0, "output": 1.0}
        line = connect(server, ledger=ledger, prices=prices)
        crew = Crew(VlmGenerator(connect(server)), VlmVerifier(line), VlmPlanner(line))
        bench, state = world.bench(), LoopState(policy="auto")
        while state.phase != "done":
            state = advance(state, crew, bench)
        assert state.outcome == "stuck"
        assert 1500 <= spent(ledger) <= 1500 + 800
        last = proposals(state)[-1]
        assert last.hunks == ()
        assert "used up" in last.question
