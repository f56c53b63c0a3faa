"""A search along one number ends, whatever cannot be run."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace

import pytest

from physagent_studio.agent.rules.planner.parameter_search import along_one, cross_entropy
from physagent_studio.agent.rules.planner.parameters import Knob
from physagent_studio.agent.rules.planner.trials import Candidate, Score, Search
from physagent_studio.program.edits import Edit

KNOB = Knob("friction", "friction", "ball", value=1.0, low=1e-6, high=1e6, stride=0.5)


@dataclass
class Refusing(Search):
    """Runs what is asked for until `allowed` are run; what follows may not be run.

    A try is the better the nearer it comes to twenty times the first value, and never holds.
    """

    allowed: int = 0
    asked: list[float] = field(default_factory=list)

    def start(self) -> Candidate:
        return self._at(KNOB.value)

    def turn(self, values: object, first: tuple[Edit, ...] = ()) -> Candidate | None:
        ((_, value),) = values  # type: ignore[misc]
        self.asked.append(value)
        assert len(self.asked) < 200, "the search goes on for ever"
        if self.runs >= self.allowed:
            return None
        self.runs += 1
        return self._at(value)

    def _at(self, value: float) -> Candidate:
        score = Score(1, abs(value - 20.0))
        return Candidate(None, (), score, ())  # type: ignore[arg-type]


@pytest.mark.parametrize("allowed", range(9))
def test_a_search_ends_where_nothing_more_may_be_run(allowed: int) -> None:
    search = Refusing(None, allowed=allowed)  # type: ignore[arg-type]
    found = along_one(search, KNOB, (1.0, -1.0), runs=30)
    assert (found is not None) == (allowed > 0)
    assert search.runs == allowed


@dataclass
class Recording(Search):
    """Runs all that is asked for; nothing holds."""

    asked: list[float] = field(default_factory=list)

    @property
    def exhausted(self) -> bool:
        return False

    def turn(
        self, values: Sequence[tuple[Knob, float]], first: tuple[Edit, ...] = ()
    ) -> Candidate | None:
        self.asked += [abs(knob.distance(value)) for knob, value in values]
        return Candidate(None, (), Score(1, 1.0), ())  # type: ignore[arg-type]


def test_numbers_are_shaken_by_as_much_as_is_said() -> None:
    knobs = [KNOB, replace(KNOB, path="mass", factor="density")]
    far, near = (
        Recording(None)  # type: ignore[arg-type]
        for _ in range(2)
    )
    assert cross_entropy(far, knobs, seed=3, rounds=1) is not None
    assert cross_entropy(near, knobs, seed=3, rounds=1, spread=0.5) is not None
    assert len(near.asked) == len(far.asked) == 24
    assert max(near.asked) == pytest.approx(max(far.asked) / 5)
