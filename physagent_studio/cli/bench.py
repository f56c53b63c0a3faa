"""Benches by name: those of `benchmark`, and the studio's own, which only this room may reach."""

from pathlib import Path
from typing import Any

from physagent_studio.benchmark import BENCHES, run_bench
from physagent_studio.benchmark.rows import Row, at_least, at_most, page, shown
from physagent_studio.errors import InputError


def measured(name: str, **options: Any) -> list[Row]:
    """The rows of the bench of that name; options: as `run_bench` takes them."""
    if name == "list":
        return [shown(bench, f"physagent bench {bench}") for bench in (*BENCHES, *_OF_STUDIO)]
    if name in _OF_STUDIO:
        rows = _studio(name, options["cases"], options["full"])
        if options["out"] is not None:
            options["out"].write_text(page(name, rows), encoding="utf-8")
        return rows
    if name not in BENCHES:
        known = ", ".join((*BENCHES, *_OF_STUDIO))
        raise InputError(f"there is no bench '{name}'; benches: {known}")
    return run_bench(name, **options)


_OF_STUDIO = ("studio", "safety")


def _studio(name: str, cases: Path | None, full: bool) -> list[Row]:
    from physagent_studio.benchmark.hostile import hostile
    from physagent_studio.studio.figures import examples, measure_safety, measure_studio

    figures = (
        measure_studio(photos=examples(cases)) if name == "studio" else measure_safety(full=full)
    )
    rows = [
        (at_least if figure.above else at_most)(
            figure.name, figure.value, figure.bound, figure.unit
        )
        for figure in figures
    ]
    return rows if name == "studio" else [*rows, *hostile()]
