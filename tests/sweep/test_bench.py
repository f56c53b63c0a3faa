"""The bench of sweeps and searches."""

from __future__ import annotations

import pytest

from physagent_studio.benchmark.sweep import bench


@pytest.mark.slow
def test_in_a_small_dose_of_the_bench_all_executors_agree() -> None:
    assert [row.name for row in bench() if not row.ok] == []
