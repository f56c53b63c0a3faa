"""Masks and edges come out of a process as they come here, and its end is a reason."""

from __future__ import annotations

import os
import signal
from collections.abc import Iterator

import numpy as np
import pytest

from physagent_studio.benchmark.reconstruction.lookalikes import stack
from physagent_studio.errors import StudioError
from physagent_studio.jobs import Inline, Processes
from physagent_studio.program.scene.state import Click, Grounding
from physagent_studio.studio.photo_desk import DeskApart


@pytest.fixture(scope="module")
def pool() -> Iterator[Processes]:
    made = Processes(1, keeping=True, grace=120.0)
    yield made
    made.close()


def _clicked(mask: np.ndarray) -> Grounding:
    rows, columns = mask.nonzero()
    return Grounding(points=(Click(x=float(columns.mean()), y=float(rows.mean()), label=1),))


def test_a_click_finds_the_same_masks_there_and_keeps_them(pool: Processes) -> None:
    drawn = stack(11)
    said = [(name, _clicked(mask)) for name, mask in drawn.masks.items()]
    name, early = said[1][0], list[object]()
    here, there = DeskApart(Inline()), DeskApart(pool)
    for whole in (False, True):
        found = there.masks(drawn.image, name, said, whole=whole, early=early.append)
        found.pop("now", None)
        wanted = here.masks(drawn.image, name, said, whole=whole)
        assert found == wanted
    process = pool._idle[0]
    assert there.way(drawn.image, (5.0, 5.0), (60.0, 40.0)) == here.way(
        drawn.image, (5.0, 5.0), (60.0, 40.0)
    )
    # Nobody waits any more: the search ends, and what the process has is kept.
    there.masks(drawn.image, name, said[:1] + said[1:][::-1], stop=lambda: True)
    assert pool._idle == [process]


def test_a_process_that_dies_is_a_reason_and_the_next_click_is_answered(pool: Processes) -> None:
    drawn = stack(11)
    said = [(name, _clicked(mask)) for name, mask in drawn.masks.items()]
    desk = DeskApart(pool)
    pid = pool.submit(os.getpid)

    def killed(_found: object) -> None:
        os.kill(pid, signal.SIGKILL)

    with pytest.raises(StudioError, match="broke down"):
        pool.submit(_telling_then_waiting, tell=killed)
    assert desk.masks(drawn.image, said[0][0], said, whole=False)["masks"]


def _telling_then_waiting() -> None:
    import time

    from physagent_studio.jobs import hearing

    hearing()[1]("begun")
    time.sleep(60)
