"""Physics bench: malformed programs are refused in order, by the thousand."""

from __future__ import annotations

from physagent_studio.benchmark.rows import Row, at_least, at_most
from physagent_studio.program.text.fuzz import fuzz_programs

COUNT = 100_000
DOSE = 3_000
SEED = 1


def malformed(count: int = DOSE) -> list[Row]:
    """Mutated programs: each is read or refused with path and line, none slowly."""
    report = fuzz_programs(count, SEED)
    return [
        at_least("malformed programs read", report.count, count, "programs"),
        at_most("uncaught errors and errors without a line", len(report.failures), 0, "programs"),
        at_most("slowest malformed program", report.seconds, 1.0, "s"),
    ]
