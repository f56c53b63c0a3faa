"""Very small doses of the bench, and the walk of several clients as a state machine."""

from __future__ import annotations

import sys

import pytest

from physagent_studio.benchmark.durability.bench import PROGRAM, bench
from physagent_studio.benchmark.durability.walks import walking, walks_of
from physagent_studio.program.text.document import load_program


@pytest.mark.slow
@pytest.mark.skipif(sys.platform != "linux", reason="the disk is made to fail through /proc")
def test_a_small_dose_of_everything_holds() -> None:
    rows = bench(dose=(3, 3, 24, 1, 10, 200))
    assert [row.name for row in rows if not row.ok] == []


TestWalk = walks_of(load_program(PROGRAM)).TestCase
TestWalk.settings = walking(3, 12)
