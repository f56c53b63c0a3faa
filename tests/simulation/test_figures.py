"""The figures of `physagent bench physics` that need no clock, each with its bound."""

import pytest

from physagent_studio.benchmark.physics.bench import FIGURES

TIMED = {"overhead", "rerun", "cold"}
ELSEWHERE = {"bowl", "ring", "soft_squash", "cloth_area", "rope_length", "stool"}
SLOW = {"grains"}


@pytest.mark.parametrize("name", sorted(set(FIGURES) - TIMED - ELSEWHERE - SLOW))
def test_figure_holds_its_bound(name):
    assert [row for row in FIGURES[name]() if not row.ok] == []


@pytest.mark.slow
@pytest.mark.parametrize("name", sorted(SLOW))
def test_slow_figure_holds_its_bound(name):
    assert [row for row in FIGURES[name]() if not row.ok] == []
