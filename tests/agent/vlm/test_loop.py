"""The three roles in the loop, against a server, from a picture to a pass."""

from __future__ import annotations

from collections.abc import Callable

from physagent_studio.agent.crew import Crew
from physagent_studio.agent.loop import advance
from physagent_studio.agent.vlm import VlmGenerator, VlmPlanner, VlmVerifier
from physagent_studio.agent.vlm.line import Line
from physagent_studio.agent.vlm.spending import CallRecord
from physagent_studio.records import LoopState
from tests.agent.vlm import scripted, world
from tests.agent.vlm.server import Model, ModelServer

Serve = Callable[[Model], ModelServer]
Connect = Callable[..., Line]


def crew_on(line: Line) -> Crew:
    return Crew(VlmGenerator(line), VlmVerifier(line), VlmPlanner(line))


def run(crew: Crew, state: LoopState) -> LoopState:
    bench = world.bench()
    for _ in range(100):
        after = advance(state, crew, bench)
        if after is state:
            return state
        state = after
    raise AssertionError("the loop does not end")


def test_from_a_picture_to_a_pass(serve: Serve, connect: Connect, calls: list[CallRecord]) -> None:
    server = serve(scripted.competent)
    final = run(crew_on(connect(server)), LoopState(policy="auto"))
    assert final.outcome == "realised"
    speeds = [
        item.program.event.actions[0].model_dump()["velocity"]["magnitude"] for item in final.path()
    ]
    # v²/2 ≥ 1.8 m at 1 m/s²: the first that is fast enough is 2.0 m/s.
    assert speeds == [1.0, 1.5, 2.0]
    assert [call.outcome for call in calls] == ["ok"] * len(server.asked)
    assert final.current is not None
    assert final.current.assessment is not None
    assert [item.name for item in final.current.assessment.criteria] == [
        "object trajectory",
        "contact timing",
        "force direction",
        "material response",
    ]
    assert final.current.assessment.clauses[0].reason == "see frame x79"
