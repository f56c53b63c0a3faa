"""What a search may ask for next is begun ahead, and makes no difference but in time."""

from __future__ import annotations

import threading
from collections.abc import Callable, Iterator
from concurrent.futures import wait
from pathlib import Path
from typing import Any

import pytest

from physagent_studio.agent.loop import trial_of
from physagent_studio.agent.roles import Situation, Trial
from physagent_studio.agent.rules.planner.parameter_search import along_one, cross_entropy
from physagent_studio.agent.rules.planner.parameters import action_knobs, material_knobs
from physagent_studio.agent.rules.planner.trials import Candidate, Search
from physagent_studio.errors import Cancelled, StudioError
from physagent_studio.jobs import Executor, Inline, Processes
from physagent_studio.program import PhysicalProgram, SetField, apply
from physagent_studio.records import Assessment, Case, LoopState, Memory
from physagent_studio.session import Store
from physagent_studio.workbench import tasks
from physagent_studio.workbench.ahead import Lane, Lanes
from physagent_studio.workbench.engine import Engine
from tests.sweep.programs import slider

# --- a search ------------------------------------------------------------------------------------


def planned(search: Search) -> Candidate | None:
    """Along one number, from which no answer follows, and then over two."""
    program = search.situation.program
    knobs = [material_knobs(program)[0], action_knobs(program)[0]]
    along_one(search, knobs[0], (1.0, -1.0), runs=4)
    return cross_entropy(search, knobs, seed=1, population=4, rounds=3)


def searched(folder: Path, executor: Executor) -> tuple[object, ...]:
    target = slider(0.6)
    case = Case("bare", prompt=target.program.event.prompt)
    session = Store(folder).create(case, LoopState())
    try:
        engine = Engine(session, case, evidence=False, executor=executor)
        bench = engine.bench()
        try_out = trial_of(target.scene, bench)
        first = try_out(target.program)
        situation = Situation(
            case, target.program, target.scene, first.rollout,
            Assessment(stage="simulation", passed=False, checks=first.checks), Memory(), try_out,
            ahead=bench.ahead(target.scene),
        )  # fmt: skip
        assert (situation.ahead is None) == (executor.width == 1)
        search = Search(situation, limit=11)
        found = search.carry_out(planned)
    finally:
        session.close()
    assert found is not None
    assert found.rollout is not None
    return found.edits, found.checks, found.rollout.positions.tobytes(), search.runs


@pytest.fixture(scope="module")
def on_one(tmp_path_factory: pytest.TempPathFactory) -> tuple[object, ...]:
    return searched(tmp_path_factory.mktemp("one"), Inline())


@pytest.mark.parametrize("width", [2, 3])
def test_a_search_has_the_same_bits_on_any_number_of_cores(
    tmp_path: Path,
    on_one: tuple[object, ...],
    width: int,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr("physagent_studio.workbench.ahead.WORTH_SECONDS", 0.0)
    pool = Processes(width, keeping=True)
    try:
        assert searched(tmp_path, pool) == on_one
    finally:
        pool.close()


class Foreseeing:
    """Trials one after the other; notes what was foreseen while each was waited for."""

    def __init__(self, engine: Engine, scene: Any) -> None:
        self.engine, self.scene = engine, scene
        self.asked: list[PhysicalProgram] = []
        self.foreseen: list[list[PhysicalProgram]] = []

    def take(self, program: PhysicalProgram, then: Callable[[], Any] = tuple) -> Trial:
        self.asked.append(program)
        self.foreseen.append(list(then()))
        return self.engine.trial(program, self.scene)

    def give_up(self) -> None:
        pass


def test_what_is_asked_for_in_any_case_is_foreseen_long_before(tmp_path: Path) -> None:
    target = slider(0.6)
    case = Case("bare", prompt=target.program.event.prompt)
    session = Store(tmp_path).create(case, LoopState())
    try:
        engine = Engine(session, case, evidence=False)
        try_out = trial_of(target.scene, engine.bench())
        first = try_out(target.program)
        ahead = Foreseeing(engine, target.scene)
        situation = Situation(
            case, target.program, target.scene, first.rollout,
            Assessment(stage="simulation", passed=False, checks=first.checks), Memory(), try_out,
            ahead=ahead,  # type: ignore[arg-type]
        )  # fmt: skip
        search = Search(situation, limit=11)
        search.carry_out(planned)
    finally:
        session.close()
    # What is waited for comes first, and the first population, of which no draw follows from an
    # answer, is seen coming from the second trial of the line on.
    assert all(seen[0] is one for seen, one in zip(ahead.foreseen, ahead.asked, strict=True))
    drawn = ahead.asked[4:7]
    assert all(any(one is other for other in ahead.foreseen[1]) for one in drawn)


def test_what_is_only_rougher_is_not_drawn_again(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    drawn: list[str] = []
    monkeypatch.setattr(tasks, "likened", lambda scene: drawn.append(scene.hash) or {})
    target = slider(0.6)
    case = Case("bare", prompt=target.program.event.prompt)
    session = Store(tmp_path).create(case, LoopState())
    try:
        engine = Engine(session, case, evidence=False)
        for path, value in (("friction", 0.1), ("position.0", 0.3)):
            edited = apply(
                target.program, [SetField(path=f"scene.objects.block.{path}", value=value)]
            )
            engine.likeness(target.scene)
            engine.likeness(engine.reconstruct(edited.scene, target.scene))
            assert len(drawn) == (1 if path == "friction" else 2)
    finally:
        session.close()


# --- lanes ---------------------------------------------------------------------------------------

ONE, TWO, THREE, FOUR = (
    PhysicalProgram().model_copy(update={"version": number}) for number in range(1, 5)
)


class Held:
    """Trials that end when a test lets them."""

    def __init__(self) -> None:
        self.ends = {id(one): threading.Event() for one in (ONE, TWO, THREE, FOUR)}
        self.begun: list[PhysicalProgram] = []

    def run(self, program: PhysicalProgram, _scene: object, dropped: Callable[[], bool]) -> Trial:
        self.begun.append(program)
        while not self.ends[id(program)].wait(0.01):
            if dropped():
                raise Cancelled("cancelled")
        if program is FOUR:
            raise StudioError("it cannot run")
        return Trial(program, ())  # type: ignore[arg-type]

    def end(self, *programs: PhysicalProgram) -> None:
        for one in programs:
            self.ends[id(one)].set()

    def lanes(self, width: int, check: Callable[[], None] = lambda: None) -> Lanes:
        return Lanes([Lane(self.run, lambda: None) for _ in range(width)], check)


@pytest.fixture
def held(monkeypatch: pytest.MonkeyPatch) -> Iterator[Held]:
    monkeypatch.setattr("physagent_studio.workbench.ahead.WORTH_SECONDS", 0.0)
    made = Held()
    yield made
    made.end(ONE, TWO, THREE, FOUR)


SCENE: Any = None


def opened(held: Held, width: int) -> Lanes:
    """Lanes of which all are open."""
    lanes = held.lanes(width)
    held.end(ONE)
    lanes.take(SCENE, ONE, tuple)
    held.begun.clear()
    return lanes


def test_what_is_foreseen_is_run_once_and_beside_what_is_waited_for(held: Held) -> None:
    lanes = opened(held, 2)

    def foreseen() -> list[PhysicalProgram]:
        held.end(TWO, THREE)
        return [TWO, THREE]

    assert lanes.take(SCENE, TWO, foreseen).rollout is TWO
    assert lanes.take(SCENE, THREE, tuple).rollout is THREE
    assert sorted(map(id, held.begun)) == sorted(map(id, [TWO, THREE]))


def test_a_wrong_guess_does_not_stand_in_the_way(held: Held) -> None:
    lanes = opened(held, 1)
    lanes._want(SCENE, [TWO, FOUR])
    held.end(TWO, THREE)
    assert lanes.take(SCENE, THREE, tuple).rollout is THREE
    assert held.begun == [TWO, THREE]


def test_what_is_no_longer_likely_makes_room(held: Held) -> None:
    lanes = opened(held, 1)
    lanes._want(SCENE, [FOUR])
    held.end(TWO)
    # FOUR never ends by itself.
    assert lanes.take(SCENE, TWO, lambda: [TWO, THREE]).rollout is TWO
    assert held.begun[:2] == [FOUR, TWO]


def test_what_is_likely_goes_on_and_what_has_ended_is_kept(held: Held) -> None:
    lanes = opened(held, 2)
    lanes._want(SCENE, [THREE])

    def foreseen() -> list[PhysicalProgram]:
        held.end(TWO)
        return [TWO, THREE]

    assert lanes.take(SCENE, TWO, foreseen).rollout is TWO
    held.end(THREE, ONE)
    wait([job.future for job in lanes._jobs if job.future is not None])
    # Nobody foresees THREE any more, but it is there.
    assert lanes.take(SCENE, ONE, lambda: [ONE]).rollout is ONE
    assert lanes.take(SCENE, THREE, tuple).rollout is THREE
    assert held.begun.count(THREE) == 1


def test_an_engine_is_told_to_end_a_trial(tmp_path: Path) -> None:
    target = slider(0.6)
    case = Case("bare", prompt=target.program.event.prompt)
    session = Store(tmp_path).create(case, LoopState())
    try:
        lane = Engine(session, case, evidence=False)._lane(Inline())
        with pytest.raises(Cancelled, match="cancelled"):
            lane.run(target.program, target.scene, lambda: True)
    finally:
        session.close()


def test_what_was_given_up_may_be_asked_for_again(held: Held) -> None:
    lanes = opened(held, 1)
    lanes._want(SCENE, [TWO])
    lanes.give_up()
    held.end(TWO)
    assert lanes.take(SCENE, TWO, tuple).rollout is TWO


def test_an_error_is_that_of_the_trial(held: Held) -> None:
    held.end(FOUR)
    with pytest.raises(StudioError, match="cannot run"):
        held.lanes(1).take(SCENE, FOUR, tuple)


def test_who_waits_can_cancel(held: Held) -> None:
    def cancelled() -> None:
        raise Cancelled("cancelled")

    with pytest.raises(Cancelled, match="cancelled"):
        held.lanes(1, cancelled).take(SCENE, TWO, tuple)


def test_the_others_stay_closed_for_a_short_search(
    held: Held, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("physagent_studio.workbench.ahead.WORTH_SECONDS", 60.0)
    lanes = opened(held, 2)
    held.end(TWO)
    assert lanes.take(SCENE, TWO, lambda: [THREE]).rollout is TWO
    assert held.begun == [TWO]
