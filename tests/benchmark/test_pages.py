"""A bench without a page of its own writes the table of its rows where it is asked to."""

from pathlib import Path

import pytest

from physagent_studio.benchmark import run_bench
from physagent_studio.benchmark.durability import bench as durability
from physagent_studio.benchmark.rows import at_least, at_most, page, shown


def test_a_page_says_what_holds() -> None:
    rows = [at_most("peak", 12.34567, 20, "MB"), at_least("IoU", 0.5, 0.9), shown("done", "all")]
    assert page("what", rows).splitlines() == [
        "# what",
        "",
        "| figure | value | bound | |",
        "|---|---|---|---|",
        "| peak | 12.35 MB | ≤ 20 | ✓ |",
        "| IoU | 0.5 | ≥ 0.9 | ✗ |",
        "| done | all | – | ✓ |",
    ]


def test_out_is_written(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(durability, "bench", lambda cases: [at_most("lost", 0, 0)])
    run_bench("durability", cases=None, out=tmp_path / "page.md")
    assert "| lost | 0 | ≤ 0 | ✓ |" in (tmp_path / "page.md").read_text("utf-8")
