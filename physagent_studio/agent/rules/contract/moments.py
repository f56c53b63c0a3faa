"""Which of the demands of a clause happen at a moment, and what a denial of it denies."""

from __future__ import annotations

from collections.abc import Sequence

from physagent_studio.agent.rules.contract.specs import Spec


def denied(group: list[Spec], touched: bool | None) -> list[Spec]:
    """What "does not …" denies: where it gets to, else the events, and not how they go on.

    touched: an earlier clause has the agent touch it; None without an agent. "Touches it without
    knocking it over" denies that it falls over; "does not slide off the table" that it comes off,
    not that it moves.
    """
    aims = [s for s in group if s.kind in _AIMS and not s.fields.get("negated")]
    if aims:
        return aims
    events = [s for s in group if s.kind in _MOMENTS and _happens(s)]
    effects = [s for s in events if s.kind in _EFFECTS]
    if touched and any(s.kind not in ("contacts", "moves") for s in effects):
        events = [s for s in effects if s.kind != "moves"]
    elif touched is None and any(s.kind in _ENDS_OF_WAY for s in events):
        events = [s for s in events if s.kind not in ("moves", "rotates")]
    return [s for s in events if s.kind != "airborne"] or events or group


def _happens(one: Spec) -> bool:
    """Whether it is an event, and neither a denial nor how things are when the clip begins."""
    return not one.fields.get("negated") and "to_step" not in one.fields


def events(specs: Sequence[Spec]) -> list[Spec]:
    """Of the demands of a clause those that happen at some moment, the most telling first."""
    found = [s for s in specs if s.kind in _MOMENTS and _happens(s)]
    return sorted(found, key=lambda s: _MOMENTS.index(s.kind))


_EFFECTS = ("topples", "flips", "leaves", "falls", "passes_over", "breaks")
"""What befalls a thing that something else acts on."""
_ENDS_OF_WAY = ("leaves", "contacts", "passes_over")
"""To where, or off what, something moves."""
_AIMS = ("lands_in", "side_of", "covers")
"""What says where something gets to; "does not roll into the goal" denies that alone."""
_MOMENTS = (
    "breaks", "topples", "flips", "passes_over", "side_of", "covers", "bounces", "leaves",
    "contacts", "falls", "reverses", "airborne", "moves", "rotates",
)  # fmt: skip
