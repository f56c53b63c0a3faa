"""The bench of the studio measures what it says; how fast it is depends on the machine."""

from __future__ import annotations

import math

import pytest

from physagent_studio.studio.figures import Figure, examples, measure_studio
from physagent_studio.studio.figures.wire import memory, p95

WORDS = (
    "scrub to pose", "opening", "frames a second", "share of a core", "scrubs", "bar dropped",
    "dragged bars", "memory grown over 1 rounds", "4 rounds open",
)  # fmt: skip
MARKED = ("after a click, 3 things, slowest", "after a box, 3 things, median")


@pytest.mark.usefixtures("shared_scenes")
@pytest.mark.parametrize(
    ("photos", "words"),
    [(0, WORDS), pytest.param(1, (*WORDS, *MARKED), marks=pytest.mark.slow)],
)
def test_every_promise_has_a_row(photos: int, words: tuple[str, ...]) -> None:
    rows = measure_studio(
        scrubs=5,
        drops=2,
        dragged=3,
        rounds=1,
        many=4,
        browser=False,
        watched=0.5,
        photos=examples(None)[:photos],
    )  # fmt: skip
    names = [row.name for row in rows]
    assert len(set(names)) == len(names)
    for said in words:
        assert any(said in name for name in names), said
    assert all(math.isfinite(row.value) and row.value >= 0 and row.unit for row in rows)


def test_a_bound_is_kept_from_the_right_side() -> None:
    assert Figure("a", 5, "ms", 10).ok
    assert not Figure("a", 11, "ms", 10).ok
    assert Figure("a", 31, "1/s", 30, above=True).ok
    assert not Figure("a", 29, "1/s", 30, above=True).ok


def test_percentile_and_memory_are_in_the_units_they_say() -> None:
    assert 0.9 * 95 < p95([n / 1000 for n in range(1, 101)]) < 1.1 * 96
    assert 10 < memory() < 100_000
