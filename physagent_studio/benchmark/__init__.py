"""Measuring commands: each bench is a function that returns rows of figures with bounds."""

from __future__ import annotations

import importlib
from pathlib import Path

from physagent_studio.benchmark.rows import Row
from physagent_studio.errors import InputError

BENCHES = {
    "physics": "physagent_studio.benchmark.physics",
    "reconstruction": "physagent_studio.benchmark.reconstruction",
    "events": "physagent_studio.benchmark.events",
}


def run_bench(name: str, *, cases: Path | None, out: Path | None) -> list[Row]:
    """Runs a bench by name. cases: folder of case folders; out: a Markdown file to write."""
    if name not in BENCHES:
        raise InputError(f"there is no bench '{name}'; benches: {', '.join(BENCHES)}")
    module = importlib.import_module(BENCHES[name])
    return module.bench(cases=cases, out=out)
