"""Benches by name: those of `benchmark`, and the studio's own, which only this room may reach."""

from __future__ import annotations

from pathlib import Path

from physagent_studio.benchmark import BENCHES, run_bench
from physagent_studio.benchmark.rows import Row, at_least, at_most, shown
from physagent_studio.errors import InputError


def measured(
    name: str,
    *,
    cases: Path | None,
    out: Path | None,
    annotations: Path | None,
    references: Path | None,
    only: tuple[str, ...],
    full: bool = False,
    sheets: Path | None = None,
    left_out: tuple[str, ...] = (),
    count: int | None = None,
    variants: tuple[str, ...] = (),
) -> list[Row]:
    """The rows of the bench of that name."""
    if name == "list":
        return [shown(bench, f"physagent bench {bench}") for bench in (*BENCHES, *_OF_STUDIO)]
    if name in _OF_STUDIO:
        return _studio(name, cases, full)
    if name not in BENCHES:
        known = ", ".join((*BENCHES, *_OF_STUDIO))
        raise InputError(f"there is no bench '{name}'; benches: {known}")
    return run_bench(
        name,
        cases=cases,
        out=out,
        annotations=annotations,
        references=references,
        only=only,
        full=full,
        sheets=sheets,
        left_out=left_out,
        count=count,
        variants=variants,
    )


_OF_STUDIO = ("studio", "safety")


def _studio(name: str, cases: Path | None, full: bool) -> list[Row]:
    from physagent_studio.studio.figures import examples, measure_safety, measure_studio

    figures = (
        measure_studio(photos=examples(cases)) if name == "studio" else measure_safety(full=full)
    )
    return [
        (at_least if figure.above else at_most)(
            figure.name, figure.value, figure.bound, figure.unit
        )
        for figure in figures
    ]
