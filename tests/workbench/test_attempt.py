"""What is tried under the pointer: newest wins, nothing is kept, a drop costs no second run."""

from __future__ import annotations

import threading
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest

from physagent_studio.program import (
    Clip,
    EventProgram,
    PhysicalProgram,
    SceneObject,
    SceneState,
    SetField,
    Support,
)
from physagent_studio.program.actions import SetVelocity
from physagent_studio.program.scene import state as shapes
from physagent_studio.session import Store
from physagent_studio.workbench import Snapshot, Workbench, commands

START = "event.actions.go.start_step"


@pytest.fixture
def bench(tmp_path: Path) -> Iterator[Workbench]:
    ball = SceneObject(
        name="ball",
        shape=shapes.Sphere(radius=0.1),
        position=(0, 1, 0.1),
        support="floor",
        material="rubber",
    )
    floor = Support(name="floor", shape=shapes.Floor(), material="wood")
    go = SetVelocity(id="go", name="ball", velocity=(1, 0, 0))
    program = PhysicalProgram(
        scene=SceneState(objects=(ball,), supports=(floor,)),
        event=EventProgram(prompt="It rolls.", actions=(go,)),
        clip=Clip(frames=21),
    )
    workbench = Workbench(Store(tmp_path), evidence=False)
    workbench.post(commands.OpenProgram(program))
    assert workbench.wait(30)
    yield workbench
    workbench.close()


def test_an_attempt_is_shown_and_not_kept(bench: Workbench) -> None:
    before = bench.snapshot()
    bench.try_out((SetField(path=START, value=20),))
    assert bench.wait(30)
    tried = bench.snapshot().attempt
    assert tried is not None
    assert tried.rollout is not None
    assert tried.rollout.spans[0].start == 20
    after = bench.snapshot()
    assert (after.program, after.state, after.can_undo) == (
        before.program,
        before.state,
        before.can_undo,
    )
    bench.try_out(None)
    assert bench.wait(30)
    assert bench.snapshot().attempt is None


def test_a_drop_takes_over_what_was_tried(bench: Workbench) -> None:
    edits = (SetField(path=START, value=20),)
    bench.try_out(edits)
    assert bench.wait(30)
    tried = bench.snapshot().attempt
    assert tried is not None
    bench.post(commands.ApplyEdits(edits))
    assert bench.wait(30)
    done = bench.snapshot()
    assert done.attempt is None
    assert done.rollout is tried.rollout
    bench.post(commands.Undo())
    assert bench.wait(30)
    assert bench.snapshot().program.action("go").start_step == 0  # type: ignore[union-attr]


def test_it_is_what_a_whole_run_gives(bench: Workbench) -> None:
    edits = (SetField(path="scene.objects.ball.position", value=[0.1, 1, 0.4]),)
    bench.try_out(edits)
    assert bench.wait(30)
    tried = bench.snapshot().attempt
    bench.post(commands.ApplyEdits(edits))
    assert bench.wait(30)
    done = bench.snapshot().rollout
    assert tried is not None
    assert tried.rollout is not None
    assert done is not None
    assert np.array_equal(tried.rollout.positions, done.positions)


def test_only_the_newest_of_a_burst_is_run(bench: Workbench) -> None:
    seen: list[int] = []
    held = threading.Event()

    def look(snapshot: Snapshot) -> None:
        if snapshot.attempt and snapshot.attempt.rollout:
            start = snapshot.attempt.rollout.spans[0].start
            assert start is not None
            seen.append(start)
            held.wait(10)

    leave = bench.subscribe(look)
    for step in range(1, 40):
        bench.try_out((SetField(path=START, value=step),))
    held.set()
    assert bench.wait(30)
    leave()
    assert seen[-1] == 39
    assert len(seen) < 10


def test_what_cannot_be_is_said_and_changes_nothing(bench: Workbench) -> None:
    bench.try_out((SetField(path=START, value=5000),))
    assert bench.wait(30)
    tried = bench.snapshot().attempt
    assert tried is not None
    assert tried.rollout is None
    assert "clip" in tried.problem
    assert bench.snapshot().notices == ()
