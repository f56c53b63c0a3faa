"""What a prompt says that no statement of its contract speaks of."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from physagent_studio.agent.rules.contract.impossible import too_high
from physagent_studio.agent.rules.scene.measures import Layout, place_name
from physagent_studio.language import EDGES, EventFrame, Place, Reading
from physagent_studio.language.tokens.vocabulary import SHARES

_WHERE = ("on", "in", "at", "from", "along", "over", "down", "object")
"""Relations to what a thing stands on that only say where the event happens."""
_AMONG = ("on", "in", "at", "from", "off", "atop", "object")
"""Relations to a stack or row that say from where in it a thing comes."""
_SAID = {
    "alltheway": "all the way", "partway": "part of the way", "mostway": "most of the way",
    "thirdway": "a third of the way", "in_turn": "one after another",
    "together": "at the same time",
}  # fmt: skip
"""How joined words were written."""


def untold(
    reading: Reading, layout: Layout, rows: Sequence[dict[str, Any]]
) -> list[dict[str, str]]:
    """Places of the prompt that no statement speaks of, as in "rolls under the table": a
    clause of its own for each, which nothing tests.

    Where a thing is to begin with, and the ground it moves on, need no statement; nor does
    a place in a clause that is untested anyway.
    """
    tested = {row["clause"] for row in rows}
    said = {clause.id: clause.text[:3000] for clause in reading.clauses}
    named = {
        (row["clause"], name)
        for row in rows
        for value in row.values()
        for name in (value if isinstance(value, list) else (value,))
        if isinstance(name, str)
    }
    found: dict[str, str] = {}
    for frame in reading.frames:
        for relation, place in frame.places:
            high = (too_high(layout, frame, name, relation, place) for name in frame.patient)
            if why := "" if frame.negated else next(filter(None, high), ""):
                found.setdefault(f"{why}, in “{said[frame.clause]}”", f"cannot_{len(found) + 1}")
                continue
            # A landmark may belong to another thing ("the stone at the target").
            clauses = tested if place.kind == "landmark" else {frame.clause}
            names = (place.name, place_name(place), *place.members)
            mine = {(c, name) for c in clauses for name in names}
            told = mine & named or frame.clause not in tested
            if not told and not _is_given(layout, frame, relation, place):
                text = f"{place.name.replace('_', ' ')}, in “{said[frame.clause]}”"
                found.setdefault(text, f"{frame.clause}_place_{len(found) + 1}")
    for frame in reading.frames:
        for word in _unsaid(frame, rows):
            text = f"{word}, in “{said[frame.clause]}”"
            found.setdefault(text, f"{frame.clause}_said_{len(found) + 1}")
    return [{"id": name, "text": text} for text, name in found.items()]


def _unsaid(frame: EventFrame, rows: Sequence[dict[str, Any]]) -> list[str]:
    """How far, and how in time, where no statement of its clause says it."""
    kinds = {row["kind"] for row in rows if row["clause"] == frame.clause}
    found = []
    juts = frame.partly_off and "rests_on" in kinds
    covered = juts or "covers" in kinds or "offscreen" in frame.manner
    if frame.share is not None and not covered:
        word = next((w for w, row in SHARES.items() if row == frame.share), "so far")
        found.append(_SAID.get(word, word))
    if frame.timing and frame.timing not in kinds:
        found.append(_SAID[frame.timing])
    return [*found, *_unmeasured(frame, kinds)]


def _is_given(layout: Layout, frame: EventFrame, relation: str, place: Place) -> bool:
    if frame.sense in ("be", "hang", "withdrawn"):
        return True
    if place.kind == "group":
        # "Knocks down the tower": what is knocked down, and no place.
        acted_on = len(frame.patient) > 1 and bool(frame.agent or frame.cause)
        return relation in _AMONG or (acted_on and relation in ("down", "over"))
    here = place.kind != "landmark" and layout.is_known(place_name(place))
    if relation in ("from", "off") and not here:
        # "Comes loose from the line": what it hangs by is no thing of the scene.
        return any(layout.has(n) and layout.carrier(n) is None for n in frame.patient)
    carriers = {layout.ground()}
    for name in (*frame.patient, *frame.agent):
        if layout.has(name):
            carriers |= {layout.carrier(name), layout.base(name)}
    hangs = any(layout.has(name) and layout.carrier(name) is None for name in frame.patient)
    if hangs and relation in ("on", "from", "by") and frame.sense in ("sway", "spin", "stay"):
        # "Swings to and fro on its hook": what it hangs by.
        return True
    if relation in ("on", "at") and place.part in EDGES and frame.sense in _IN_PLACE:
        # "Teeters on the edge": where it has to be for that.
        return any(_is_at_edge(layout, name) for name in frame.patient)
    return relation in _WHERE and place.name in carriers


_IN_PLACE = ("sway", "lose_balance", "lean", "stop", "settle")


def _is_at_edge(layout: Layout, name: str) -> bool:
    edge = layout.nearest_edge(name) if layout.has(name) else None
    return edge is not None and edge[1] < layout.size(name)


def _unmeasured(frame: EventFrame, kinds: set[str]) -> list[str]:
    """Numbers of a clause that no statement of the kind that takes them holds."""
    takes = (
        (frame.distance, ("moves", "stops"), "m"), (frame.speed, ("speed_between",), "m/s"),
        (frame.angle, ("rotates", "flips"), "degrees"), (frame.delay, ("stays",), "s"),
    )  # fmt: skip
    return [
        f"{said:g} {unit}"
        for said, holding, unit in takes
        if said is not None and not kinds & set(holding)
    ]
