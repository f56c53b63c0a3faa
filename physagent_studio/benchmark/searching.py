"""Rows of `physagent bench sweep`: how much sooner two cores find a planner's proposal than one."""

import time
from contextlib import closing
from pathlib import Path
from tempfile import TemporaryDirectory

from physagent_studio.agent.crew import Bench
from physagent_studio.agent.previews import trial_of
from physagent_studio.agent.roles import Situation
from physagent_studio.agent.rules import RulePlanner, RuleVerifier
from physagent_studio.benchmark.rows import Row, at_least, at_most, shown
from physagent_studio.jobs import Processes
from physagent_studio.program import SetField, apply
from physagent_studio.records import Case, LoopState, Memory, Proposal, RolloutEvidence
from physagent_studio.session import Store
from physagent_studio.sweep import Target
from physagent_studio.workbench.engine import Engine

SOONER = 1.6
"""What two cores have to make of one, where all of it is measured."""
WEAK = SetField(path="event.actions.roll.velocity.0", value=0.05)
"""A ball so slow that the dominoes stay as they are."""


def rows_of(target: Target, *, full: bool) -> list[Row]:
    """The seconds, their ratio, and whether the proposal is the same."""
    target = Target(target.label, apply(target.program, [WEAK]), target.scene)
    limit = 60 if full else 6
    (one, first), (two, second) = (_searched(target, width, limit) for width in (1, 2))
    return [
        shown(f"a search of {first.simulations} runs in one process", one, "s"),
        shown("the same in two", two, "s"),
        # In a dose, what else is at work on the machine counts for too much.
        at_least("a search: one process over two", one / two, SOONER if full else 0.0, "×"),
        at_most("searches with another proposal", int(first.edits != second.edits), 0),
    ]


def _searched(target: Target, width: int, limit: int) -> tuple[float, Proposal]:
    """Seconds of a search, and what it proposes; all processes run and have run the scene."""
    case = Case("bench", prompt=target.program.event.prompt)
    with TemporaryDirectory() as home, closing(Processes(width, keeping=True)) as pool:
        session = Store(Path(home)).create(case, LoopState())
        bench = Engine(session, case, evidence=False, executor=pool).bench()
        situation = _situation(target, case, bench)
        RulePlanner(limit).propose(situation)
        began = time.perf_counter()
        proposal = RulePlanner(limit).propose(situation)
        seconds = time.perf_counter() - began
        session.close()
    return seconds, proposal


def _situation(target: Target, case: Case, bench: Bench) -> Situation:
    program, scene = target.program, target.scene
    try_out = trial_of(scene, bench)
    ran = try_out(program)
    evidence = RolloutEvidence(program, scene, ran.rollout, ran.checks, ())
    verdict = RuleVerifier().judge(evidence, program.event.prompt)
    return Situation(
        case, program, scene, ran.rollout, verdict, Memory(), try_out, ahead=bench.ahead(scene)
    )
