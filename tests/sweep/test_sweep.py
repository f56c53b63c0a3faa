"""A sweep runs every different program once, whoever dies, and gives the same bits everywhere."""

from __future__ import annotations

import csv
import importlib
import os
import signal
import threading
import time
import weakref
from collections.abc import Callable, Mapping
from pathlib import Path

import pytest

from physagent_studio.errors import BackendMissing, Cancelled, EditError, InputError
from physagent_studio.exchange.tables import write_csv, write_parquet
from physagent_studio.jobs import Executor, Inline, Processes
from physagent_studio.jobs.cluster import Cluster
from physagent_studio.program import PhysicalProgram
from physagent_studio.sweep import Plan, Point, Ran, Store, Target, carry_out, planned, ran
from physagent_studio.sweep.page import columns_of, write_page
from physagent_studio.sweep.plan import span_of
from tests.sweep.programs import slider

carrying = importlib.import_module("physagent_studio.sweep.carry_out")
"""The module: the package hands out its function by the same name."""
SPEED = "event.actions.go.velocity.0"
KILLED = 10
"""Workers that die in a test."""


@pytest.fixture(scope="module")
def block() -> Target:
    return slider(0.1)


def speeds(count: int, low: float = 0.5) -> Plan:
    return Plan(grid=(span_of(f"{SPEED}={low}:1.5:{count}", grid=True),))


def dying(program: PhysicalProgram, *rest: object) -> Ran:
    """Kills its worker in the midst of the first runs; leaves a mark for each that is finished."""
    folder = Path(os.environ["SWEEP_MARKS"])
    for number in range(0 if (folder / f"begun {program.hash}").exists() else KILLED):
        try:
            (folder / f"killed{number}").touch(exist_ok=False)
        except FileExistsError:
            continue
        # Each of the first ones is killed once: nothing is tried for ever.
        (folder / f"begun {program.hash}").touch()
        threading.Timer(0.02, os.kill, (os.getpid(), signal.SIGKILL)).start()
        time.sleep(30)
    found = ran(program, *rest)  # type: ignore[arg-type]
    with (folder / "done").open("a") as file:
        file.write(f"{program.hash}\n")
    return found


def dead(*_values: object) -> Ran:
    os.kill(os.getpid(), signal.SIGKILL)
    raise AssertionError


def slow(*_values: object) -> Ran:
    time.sleep(60)
    return Ran()


def runs_of(
    plan: Plan, target: Target, executor: Executor, task: Callable[..., Ran] = ran
) -> dict[str, Ran]:
    found: dict[str, Ran] = {}

    def done(point, one: Ran) -> None:
        assert point.key not in found
        found[point.key] = one

    carry_out(planned(plan, (target,)), executor, done, task=task)
    return found


def kept(store: Store) -> Callable[[Point, Ran], None]:
    return lambda point, one: store.add(point.key, one)


def told(runs: Mapping[str, Ran]) -> dict[str, str]:
    return {key: one.model_dump_json(exclude={"path"}) for key, one in runs.items()}


def test_inline_and_processes_give_the_same_bits(block: Target) -> None:
    pool = Processes(width=2, keeping=True)
    try:
        apart = runs_of(speeds(5), block, pool)
    finally:
        pool.close()
    here = runs_of(speeds(5), block, Inline())
    assert told(apart) == told(here)
    assert len({one.rollout for one in here.values()}) == 5


def test_killed_workers_lose_nothing_and_nothing_is_done_twice(
    block: Target, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("SWEEP_MARKS", str(tmp_path))
    pool = Processes(width=2, keeping=True)
    try:
        found = runs_of(speeds(12), block, pool, dying)
    finally:
        pool.close()
    assert len(list(tmp_path.glob("killed*"))) == KILLED
    done = (tmp_path / "done").read_text().split()
    assert len(done) == len(set(done)) == 12
    assert told(found) == told(runs_of(speeds(12), block, Inline()))


def nothing(*_values: object) -> Ran:
    return Ran()


def test_points_are_made_as_they_are_needed_and_none_is_kept(block: Target, tmp_path: Path) -> None:
    """So that memory does not grow with their number: on disk lie the runs."""
    seen: list[weakref.ref[Point]] = []
    alive: list[int] = []
    store = Store(tmp_path)

    def done(point: Point, one: Ran) -> None:
        store.add(point.key, one)
        seen.append(weakref.ref(point))
        alive.append(sum(ref() is not None for ref in seen))

    carry_out(planned(speeds(40), (block,)), Inline(), done, task=nothing)
    store.close()
    assert len(seen) == 40
    assert max(alive) <= 3


def test_what_breaks_down_every_time_is_said_and_tried_again_by_another_sweep(
    block: Target, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(carrying, "ATTEMPTS", 2)
    pool = Processes(width=1)
    try:
        (lost,) = runs_of(speeds(1), block, pool, dead).values()
    finally:
        pool.close()
    assert lost.lost
    assert "Killed" in lost.problem
    assert not lost.holds
    store = Store(tmp_path)
    store.add("key", lost)
    assert store["key"] == lost
    store.close()
    again = Store(tmp_path)
    assert "key" not in again
    again.close()


def test_a_sweep_goes_on_where_it_was_and_a_torn_line_is_run_again(
    block: Target, tmp_path: Path
) -> None:
    store = Store(tmp_path)
    carry_out(planned(speeds(2), (block,)), Inline(), kept(store))
    with pytest.raises(InputError, match="another sweep"):
        Store(tmp_path)
    store.close()
    path = tmp_path / "runs.jsonl"
    path.write_bytes(path.read_bytes()[:-20])
    begun: list[str] = []

    def counted(program: PhysicalProgram, *rest: object) -> Ran:
        begun.append(program.hash)
        return ran(program, *rest)  # type: ignore[arg-type]

    store = Store(tmp_path)
    known, points = store.__contains__, planned(speeds(3), (block,))
    carry_out(points, Inline(), kept(store), known=known, task=counted)
    # Both ends are those of the first sweep, and the last line of it was torn.
    assert len(begun) == 2
    assert len(store) == 3
    store.close()


def test_a_cancelled_sweep_ends_at_once(block: Target) -> None:
    cancel = threading.Event()
    pool = Processes(width=2, keeping=True)
    threading.Timer(0.3, cancel.set).start()
    try:
        with pytest.raises(Cancelled):
            carry_out(
                planned(speeds(9), (block,)), pool, lambda *_: None,
                cancelled=cancel.is_set, task=slow,
            )  # fmt: skip
    finally:
        pool.close()


@pytest.mark.parametrize(
    ("word", "allowed"),
    [
        ("event.actions.go.speed=0:1:3", "fields: id, name"),
        ("event.actions.stop.velocity.0=0:1:3", "items: go"),
        ("event.actions.go.velocity=0:1:3", "is no number .items: 0, 1, 2"),
        (f"{SPEED}=0:501:3", "at most 500"),
    ],
)
def test_a_field_that_is_none_is_refused_with_what_is_allowed(
    block: Target, word: str, allowed: str
) -> None:
    with pytest.raises(EditError if "501" not in word else InputError, match=allowed):
        planned(Plan(grid=(span_of(word, grid=True),)), (block,))


@pytest.mark.parametrize("word", ["a.b", "a=1:2", "a=1:x:3", "=1:2:3", "a=0:inf:3", "a=0:1:0"])
def test_a_range_that_is_none_is_refused(word: str) -> None:
    with pytest.raises(InputError):
        span_of(word, grid=True)


def test_draws_are_the_same_each_time_and_an_open_number_may_be_drawn(block: Target) -> None:
    field = "scene.objects.block.density"
    plan = Plan(random=(span_of(f"{field}=100:900", grid=False),), seeds=4)
    first, second = ([point.values[field] for point in planned(plan, (block,))] for _ in range(2))
    assert first == second
    assert len(set(first)) == 4
    assert all(100 <= value <= 900 for value in first)


def test_tables_and_page_hold_every_point(block: Target, tmp_path: Path) -> None:
    plan = Plan((*speeds(3).grid, span_of("scene.supports.floor.friction=0.1:0.5:2", grid=True)))
    runs = runs_of(plan, block, Inline())
    table = columns_of((point, runs[point.key]) for point in planned(plan, (block,)))
    write_csv(table, tmp_path / "results.csv")
    with (tmp_path / "results.csv").open() as file:
        rows = list(csv.DictReader(file))
    assert [float(row[SPEED]) for row in rows] == [0.5, 0.5, 1.0, 1.0, 1.5, 1.5]
    assert [row["holds"] for row in rows] == [str(one.holds) for one in runs.values()]
    pytest.importorskip("pyarrow")
    from pyarrow.parquet import read_table

    write_parquet(table, tmp_path / "results.parquet")
    read = read_table(tmp_path / "results.parquet").to_pydict()
    assert read["margin slides"] == [float(row["margin slides"]) for row in rows]
    write_page(table, tmp_path / "index.html", ["6 points"])
    page = (tmp_path / "index.html").read_text()
    assert page.count("<rect") == 6 + 3 + 2
    assert page.count("<circle") >= 6
    assert "http" not in page.replace("http://www.w3.org", "")


# --- Ray -----------------------------------------------------------------------------------------


def test_without_ray_there_is_one_sentence(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(__import__("sys").modules, "ray", None)
    with pytest.raises(BackendMissing, match=r"physagent-studio\[ray\]"):
        Cluster()


@pytest.mark.ray
def test_a_local_cluster_loses_no_run_and_gives_the_same_bits(
    block: Target, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    pytest.importorskip("ray", reason="the package ray is not installed")
    monkeypatch.setenv("SWEEP_MARKS", str(tmp_path))
    root = str(Path(__file__).parents[2])
    monkeypatch.setenv("PYTHONPATH", os.pathsep.join([root, os.environ.get("PYTHONPATH", "")]))
    cluster = Cluster(cores=2)
    cancel = threading.Event()
    try:
        assert cluster.width == 2
        found = runs_of(speeds(12), block, cluster, dying)
        threading.Timer(0.5, cancel.set).start()
        with pytest.raises(Cancelled):
            cluster.submit(slow, cancelled=cancel.is_set)
    finally:
        cluster.close()
    assert len(list(tmp_path.glob("killed*"))) == KILLED
    done = (tmp_path / "done").read_text().split()
    assert len(done) == len(set(done)) == 12
    assert told(found) == told(runs_of(speeds(12), block, Inline()))
