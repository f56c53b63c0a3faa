"""Heavy steps in a process of their own: the same bits, and what ends there ends alone."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import threading
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest

from physagent_studio.benchmark.durability.bench import PROGRAM
from physagent_studio.jobs import Inline, Processes
from physagent_studio.program import SetField
from physagent_studio.program.text.document import load_program
from physagent_studio.session import Store
from physagent_studio.workbench import Workbench, commands, tasks

PATIENCE = 60.0


def crashing(*_values: object) -> None:
    os.kill(os.getpid(), signal.SIGSEGV)


def endless(*_values: object) -> None:
    while True:
        pass


class Instead:
    """An executor that has a task carried out in place of another, the runs of the engine."""

    def __init__(
        self, pool: Processes, task: Callable[..., Any], of: Callable[..., Any] = tasks.simulated
    ) -> None:
        self.pool, self.task, self.of = pool, task, of

    width = 1

    def submit(self, task: Callable[..., Any], *values: Any, **more: Any) -> Any:
        return self.pool.submit(self.task if task is self.of else task, *values, **more)


@pytest.fixture(scope="module")
def pool() -> Iterator[Processes]:
    made = Processes(1, keeping=True)
    yield made
    made.close()


def _opened(root: Path, executor: Any) -> Workbench:
    workbench = Workbench(Store(root), executor=executor)
    workbench.post(commands.OpenProgram(load_program(PROGRAM)))
    assert workbench.wait(PATIENCE)
    return workbench


def _run(root: Path, executor: Any) -> Workbench:
    workbench = _opened(root, executor)
    workbench.post(commands.Run())
    return workbench


def _made(workbench: Workbench) -> list[tuple[str, str | None, str | None]]:
    assert workbench.wait(PATIENCE)
    rounds = workbench.snapshot().state.rounds
    workbench.close()
    return [(one.program.hash, one.scene, one.rollout) for one in rounds]


def test_another_process_makes_the_same_bits(tmp_path: Path, pool: Processes) -> None:
    here = _made(_run(tmp_path / "here", Inline()))
    assert here
    assert here == _made(_run(tmp_path / "there", pool))


def test_a_crash_fails_the_step_alone(tmp_path: Path, pool: Processes) -> None:
    instead = Instead(pool, tasks.simulated)
    workbench = _opened(tmp_path, instead)
    instead.task = crashing
    workbench.post(commands.Run())
    assert workbench.wait(PATIENCE)
    assert any("broke down" in one.text for one in workbench.snapshot().notices)
    instead.task = tasks.simulated
    workbench.post(commands.Run())
    assert workbench.wait(PATIENCE)
    assert workbench.snapshot().state.rounds[0].rollout
    workbench.close()


def test_a_crash_while_something_is_shown_is_said(tmp_path: Path, pool: Processes) -> None:
    instead = Instead(pool, crashing, tasks.outlined)
    workbench = _opened(tmp_path, instead)
    workbench.post(commands.ShowCollisions(True))
    assert workbench.wait(PATIENCE)
    assert "broke down" in workbench.snapshot().notices[-1].text
    instead.task = tasks.outlined
    workbench.post(commands.ShowCollisions(True))
    assert workbench.wait(PATIENCE)
    assert workbench.snapshot().collisions
    workbench.close()


def test_what_hears_nothing_is_cancelled(tmp_path: Path, pool: Processes) -> None:
    instead = Instead(pool, tasks.simulated)
    workbench = _opened(tmp_path, instead)
    instead.task = endless
    workbench.post(commands.Run())
    until = time.monotonic() + PATIENCE
    while "simulating" not in (workbench.snapshot().busy or "") and time.monotonic() < until:
        time.sleep(0.01)
    workbench.cancel()
    assert workbench.wait(PATIENCE)
    assert "Cancelled" in workbench.snapshot().notices[-1].text
    instead.task = tasks.simulated
    workbench.post(commands.ApplyEdits((SetField(path="event.actions.go.start_step", value=2),)))
    assert workbench.wait(PATIENCE)
    assert workbench.snapshot().program.event.actions[0].start_step == 2
    workbench.close()


ALONE = """
import sys, threading
from physagent_studio.jobs import Processes
from tests.workbench.test_tasks import endless
pool = Processes(1, keeping=True)
pool.submit(abs, 1)
print(pool._idle[0]._process.pid, flush=True)
threading.Thread(target=pool.submit, args=(endless,)).start()
"""


def test_no_process_outlives_the_one_that_it_works_for() -> None:
    root = Path(__file__).parents[2]
    command = [sys.executable, "-c", ALONE]
    with subprocess.Popen(command, stdout=subprocess.PIPE, text=True, cwd=root) as parent:
        assert parent.stdout is not None
        worker = int(parent.stdout.readline())
        threading.Event().wait(0.2)
        parent.kill()
    until = time.monotonic() + PATIENCE
    while _runs(worker) and time.monotonic() < until:
        time.sleep(0.02)
    assert not _runs(worker)


def _runs(pid: int) -> bool:
    try:
        return Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()[0] != "Z"
    except OSError:
        return False
