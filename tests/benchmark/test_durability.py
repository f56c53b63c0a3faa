"""Very small doses of the bench, and the walk of several clients as a state machine."""

from __future__ import annotations

import sys
import tempfile
from pathlib import Path

import pytest
from hypothesis import HealthCheck, settings
from hypothesis import strategies as st
from hypothesis.stateful import RuleBasedStateMachine, invariant, rule

from physagent_studio.benchmark.durability.bench import PROGRAM, bench
from physagent_studio.benchmark.durability.clients import STEPS, Clients
from physagent_studio.program.text.document import load_program

CLIENTS = 3


@pytest.mark.slow
@pytest.mark.skipif(sys.platform != "linux", reason="the disk is made to fail through /proc")
def test_a_small_dose_of_everything_holds() -> None:
    rows = bench(dose=(3, 3, 24, 1, 10, 200))
    assert [row.name for row in rows if not row.ok] == []


class Walk(RuleBasedStateMachine):
    """Hypothesis chooses who does what, and makes a failure short."""

    def __init__(self) -> None:
        super().__init__()
        self.folder = tempfile.TemporaryDirectory()
        self.clients = Clients(Path(self.folder.name), load_program(PROGRAM), CLIENTS)

    @rule(
        client=st.integers(0, CLIENTS - 1),
        step=st.sampled_from(STEPS),
        value=st.integers(0, 39),
    )
    def act(self, client: int, step: str, value: int) -> None:
        self.clients.act(client, step, value)

    @invariant()
    def nothing_is_lost(self) -> None:
        assert self.clients.lost == []

    def teardown(self) -> None:
        self.clients.bench.close()
        self.folder.cleanup()


TestWalk = Walk.TestCase
TestWalk.settings = settings(
    max_examples=3,
    stateful_step_count=12,
    deadline=None,
    derandomize=True,
    suppress_health_check=[HealthCheck.too_slow],
)
