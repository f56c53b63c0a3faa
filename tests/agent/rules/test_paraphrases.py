"""One event in five wordings gives one contract, and its first programs lead to the event."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest
import yaml

from physagent_studio.agent.crew import Bench, Crew
from physagent_studio.agent.loop import advance
from physagent_studio.agent.rules import RuleGenerator, RulePlanner, RuleVerifier
from physagent_studio.contract import measure
from physagent_studio.program.contract import Contract, Statement
from physagent_studio.records import LoopState
from physagent_studio.simulation import simulate
from tests.agent.rules.scenes import STAGES, Stage

EVENTS = yaml.safe_load((Path(__file__).parent / "prompts.yaml").read_text(encoding="utf-8"))
NAMES = [f"{event['stage']}/{event['event']}" for event in EVENTS]


def demands(contract: Contract) -> set[Any]:
    """What is demanded, without the ids and clauses that the wording decides."""
    by_id = {s.id: s for s in contract.statements}

    def plain(statement: Statement) -> tuple[Any, ...]:
        data = statement.model_dump(exclude={"id", "clause"}, exclude_defaults=True)
        data["kind"] = statement.kind
        if "of" in data:
            data["of"] = sorted(str(plain(by_id[i])) for i in data["of"])
        for part in ("first", "second"):
            if part in data:
                data[part] = plain(by_id[data[part]])
        return tuple(sorted((key, str(value)) for key, value in data.items()))

    return {plain(s) for s in contract.statements if s.id not in contract.serving}


@pytest.mark.parametrize("event", EVENTS, ids=NAMES)
def test_five_wordings_one_contract(event: dict[str, Any]) -> None:
    stage = STAGES[event["stage"]]
    programs = [RuleGenerator().first(stage.case(w), stage.reconstruct) for w in event["wordings"]]
    assert len(programs) == 5
    for program, wording in zip(programs, event["wordings"], strict=True):
        assert demands(program.contract) == demands(programs[0].contract), wording
        assert not program.contract.untested, wording
        assert not program.contract.not_understood, wording


def bench_of(stage: Stage, prompt: str) -> tuple[Bench, list[int]]:
    """A bench over a synthetic scene, and the number of runs in a list of one."""
    store: dict[str, Any] = {}
    runs = [0]

    def put(value: Any) -> str:
        store[str(len(store))] = value
        return str(len(store) - 1)

    def run(program: Any, scene: Any) -> Any:
        runs[0] += 1
        return simulate(program, scene.meshes)

    bench = Bench(
        case=stage.case(prompt),
        reconstruct=lambda state, previous: stage.reconstruct(state),
        simulate=run,
        measure=lambda program, rollout, scene: measure(program, rollout),
        view=lambda scene: None,
        evidence=lambda scene, rollout: (),
        put_scene=put,
        get_scene=store.__getitem__,
        put_rollout=put,
        get_rollout=store.__getitem__,
        put_frames=lambda frames: None,  # type: ignore[arg-type, return-value]
    )
    return bench, runs


def play(stage: Stage, prompt: str, budget: int = 6) -> tuple[LoopState, int]:
    """The loop to its end, deciding automatically."""
    bench, runs = bench_of(stage, prompt)
    crew = Crew(RuleGenerator(), RuleVerifier(), RulePlanner(limit=40))
    state = LoopState(policy="auto", budget=budget)
    while state.phase != "done":
        state = advance(state, crew, bench)
    return state, runs[0]


@pytest.mark.parametrize("event", EVENTS, ids=NAMES)
def test_the_event_is_realised(event: dict[str, Any]) -> None:
    wording = event["wordings"][len(event["event"]) % 5]
    state, runs = play(STAGES[event["stage"]], wording)
    current = state.current
    assert current is not None
    assert current.assessment is not None
    failing = [c.text for c in current.assessment.checks if c.demanded and not c.ok]
    assert state.outcome == "realised", failing
    assert runs == sum(r.simulations for r in state.rounds)
