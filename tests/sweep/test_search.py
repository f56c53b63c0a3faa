"""A population of candidates is the same on one core and on two."""

from __future__ import annotations

from pathlib import Path

import pytest

from physagent_studio.agent.loop import trial_of
from physagent_studio.agent.previews import tried
from physagent_studio.agent.roles import Situation
from physagent_studio.agent.rules.planner.parameter_search import cross_entropy
from physagent_studio.agent.rules.planner.parameters import action_knobs, material_knobs
from physagent_studio.agent.rules.planner.trials import Search
from physagent_studio.benchmark.sweep import bench
from physagent_studio.cli.programs import bare_case
from physagent_studio.jobs import Inline, Processes
from physagent_studio.records import Assessment, LoopState, Memory
from physagent_studio.session import Store
from physagent_studio.workbench.engine import Engine
from tests.sweep.programs import slider


def searched(folder: Path, executor: Inline | Processes) -> tuple[object, ...]:
    target = slider(0.6)
    case = bare_case(target.program, "bare")
    session = Store(folder).create(case, LoopState())
    try:
        bench = Engine(session, case, evidence=False, executor=executor).bench()
        try_out = trial_of(target.scene, bench)
        first = try_out(target.program)
        situation = Situation(
            case, target.program, target.scene, first.rollout,
            Assessment(stage="simulation", passed=False, checks=first.checks), Memory(), try_out,
            try_all=lambda programs: bench.side_by_side(lambda one: tried(try_out, one), programs),
        )  # fmt: skip
        knobs = [action_knobs(target.program)[0], material_knobs(target.program)[0]]
        search = Search(situation, limit=11)
        found = cross_entropy(search, knobs, seed=1, population=4, rounds=3)
    finally:
        session.close()
    assert found is not None
    assert found.rollout is not None
    return found.edits, found.checks, found.rollout.positions.tobytes(), search.runs


def test_a_search_has_the_same_bits_on_one_core_and_on_two(tmp_path: Path) -> None:
    pool = Processes(2, keeping=True)
    try:
        assert searched(tmp_path / "two", pool) == searched(tmp_path / "one", Inline())
    finally:
        pool.close()


@pytest.mark.slow
def test_in_a_small_dose_of_the_bench_all_executors_agree() -> None:
    assert [row.name for row in bench() if not row.ok] == []
