"""Measuring commands: each bench is a function that returns rows of figures with bounds."""

import importlib
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from physagent_studio.benchmark.rows import Row, page
from physagent_studio.errors import InputError
from physagent_studio.reconstruction.switches import without

BENCHES = {
    "physics": "physagent_studio.benchmark.physics.bench",
    "durability": "physagent_studio.benchmark.durability.bench",
    "reconstruction": "physagent_studio.benchmark.reconstruction.bench",
    "ledger": "physagent_studio.benchmark.reconstruction.ledger",
    "events": "physagent_studio.benchmark.events.bench",
    "view": "physagent_studio.benchmark.events.bench",
    "words": "physagent_studio.benchmark.events.words",
    "paper": "physagent_studio.benchmark.paper.bench",
    "motion-prior": "physagent_studio.benchmark.motion_prior.bench",
    "sweep": "physagent_studio.benchmark.sweep",
}
_ON_EVENTS = ("events", "view")
"""Two names of the bench that runs events of cases: it takes annotations, references, a choice."""
_PLAIN = ("durability", "reconstruction", "motion-prior", "sweep")
"""Benches whose page is the table of their rows."""


def run_bench(
    name: str,
    *,
    cases: Path | None,
    out: Path | None,
    annotations: Path | None = None,
    references: Path | None = None,
    only: Sequence[str] = (),
    full: bool = False,
    sheets: Path | None = None,
    left_out: Sequence[str] = (),
    count: int | None = None,
    variants: Sequence[str] = (),
) -> list[Row]:
    """Runs a bench by name.

    cases: folder of case folders. out: a Markdown file to write. annotations, references:
    folders of clicks and of contracts per case. only: `case` or `case/event`. full: all
    of the benches of physics and durability, not a dose. sheets: folder for the contact sheets
    of events and for all that `paper` makes. left_out: heuristics that the bench of reconstruction
    does without. count, variants: how many events of `paper`, and in which variants.
    """
    if name not in BENCHES:
        raise InputError(f"there is no bench '{name}'; benches: {', '.join(BENCHES)}")
    options: dict[str, Any] = {}
    if name in _ON_EVENTS:
        options = {"annotations": annotations, "references": references, "only": tuple(only)}
    elif name == "paper":
        options = {"only": tuple(only), "count": count, "variants": tuple(variants)}
    elif annotations or references or only:
        listed = " and ".join(_ON_EVENTS)
        raise InputError(f"--annotations, --references and --only are for the benches {listed}")
    if (count is not None or variants) and name != "paper":
        raise InputError("--events and --variant are for the bench paper")
    if sheets is not None and name not in (*_ON_EVENTS, "paper"):
        raise InputError("--sheets is for the benches events and paper")
    if sheets is not None:
        options["sheets"] = sheets
    if full and name not in ("physics", "durability", "sweep"):
        raise InputError("--full is for the benches physics, durability, sweep and safety")
    if full:
        options["full"] = True
    if left_out and name != "reconstruction":
        raise InputError("--without is for the bench reconstruction")
    module = importlib.import_module(BENCHES[name])
    with without(left_out):
        if name not in _PLAIN:
            return module.bench(cases=cases, out=out, **options)
        rows = module.bench(cases=cases, **options)
    if out is not None:
        out.write_text(page(name, rows), encoding="utf-8")
    return rows
