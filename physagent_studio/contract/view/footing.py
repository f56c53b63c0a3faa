"""What goes along the ground stays as it stands, and what falls over does so the way it is told."""

from __future__ import annotations

import numpy as np

from physagent_studio.contract.facts import Facts
from physagent_studio.contract.view.basics import TIPPED, height_of, said, view_check
from physagent_studio.contract.words import number
from physagent_studio.program.base import DIRECTIONS
from physagent_studio.program.statements import Moves
from physagent_studio.records.judgement import Check

ALONG_THE_GROUND = frozenset(("slide", "move", "push", "pull", "drift"))
"""Senses of verbs by which a thing goes as it stands; what rolls or is hit may turn over."""
_TURNING = (
    "topples", "flips", "rotates", "falls", "leaves", "airborne", "breaks", "spreads", "sways",
    "descends_slowly", "lands_in",
)  # fmt: skip

_LEVEL = frozenset(("left", "right", "away", "toward_camera"))


def keeps_its_footing(facts: Facts, names: tuple[str, ...]) -> list[Check]:
    """Until it meets another thing, or leaves what it stands on."""
    going = {one.subject for one in facts.program.contract.paces if one.verb in ALONG_THE_GROUND}
    found = []
    for name in (one for one in names if one in going):
        item = facts.program.scene.object(name)
        if item is None or item.body.kind != "rigid" or item.wheels is not None:
            continue
        if said(facts.program, name, _TURNING):
            continue
        tilt = facts.track(name, facts.whole()).tilt()[: _alone_until(facts, name) + 1]
        most, step = float(tilt.max()), int(tilt.argmax())
        text = (
            f"{name} goes as it stands: it tilts by {number(most, '°')} ≤ {TIPPED:.0f}°: {{answer}}"
        )
        found.append(
            view_check(
                "footing", name, text, 1 - most / TIPPED,
                measured=most, threshold=TIPPED, unit="°", step=step,
            )
        )  # fmt: skip
    return found


def _alone_until(facts: Facts, name: str) -> int:
    """The last step before it meets an object, or drops off what it stood on at first."""
    whole = facts.whole()
    ends = [facts.last]
    for other in facts.rollout.objects:
        if other != name:
            touching = facts.touching(name, other, whole)
            if not touching[0] and touching.any():
                ends.append(int(touching.argmax()))
    height = facts.track(name, whole).positions[:, 2]
    # What tips over hops a little, and its middle comes down a little.
    low = height < height[0] - DROPPED * height_of(facts, name)
    dropped = low & ~facts.touching_anything(name, whole)
    if dropped.any():
        ends.append(int(dropped.argmax()))
    return min(ends)


DROPPED = 0.4
"""How far what drops off something has come down, in its own heights."""
MOST_ASIDE = 45.0
"""Degrees between the way that something is told to fall over and the way that its top leans."""


def falls_as_told(facts: Facts, names: tuple[str, ...]) -> list[Check]:
    """What is told to fall over to a side leans to that side when it does."""
    found = []
    for name in names:
        clauses = {one.clause for one in said(facts.program, name, ("topples",))}
        told = {
            way.direction: DIRECTIONS[way.direction]
            for way in said(facts.program, name, ("moves",))
            if isinstance(way, Moves) and way.clause in clauses and way.direction is not None
        }
        track = facts.track(name, facts.whole())
        if len(told) != 1 or not set(told) <= _LEVEL or track.outline.is_ball:
            continue
        tilt = track.tilt()
        step = int((tilt >= min(TIPPED, float(tilt.max()))).argmax())
        up = track.placed.matrices[step] @ track.placed.matrices[0].T @ np.array([0.0, 0.0, 1.0])
        way = np.array(next(iter(told.values())))[:2]
        lean = max(float(np.linalg.norm(up[:2])), 1e-6)
        off = float(np.degrees(np.arccos(np.clip(up[:2] @ way / lean, -1, 1))))
        text = (
            f"{name} falls over the way it is told to: {number(off, '°')} off ≤ {MOST_ASIDE:.0f}°: "
            "{answer}"
        )
        found.append(
            view_check(
                "lean", name, text, 1 - off / MOST_ASIDE,
                measured=off, threshold=MOST_ASIDE, unit="°", step=step,
            )
        )  # fmt: skip
    return found
