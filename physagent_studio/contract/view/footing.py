"""What goes along the ground stays as it stands, and what falls over does so the way it is told."""

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
DROPPED = 0.4
"""How far what drops off something has come down, in its own heights."""
MOST_ASIDE = 45.0
"""Degrees between the way that something is told to fall over and the way that its top leans."""
_LEVEL = frozenset(("left", "right", "away", "toward_camera"))


def keeps_its_footing(facts: Facts, names: tuple[str, ...]) -> list[Check]:
    """What slides, is pushed or moves does not tip over, until it meets another thing or drops."""
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
        text = f"{name} goes as it stands: it tilts by"
        found.append(_at_most("footing", name, text, most, TIPPED, step))
    return found


def _at_most(rule: str, name: str, text: str, angle: float, most: float, step: int) -> Check:
    """A view check that an angle is no larger than that; degrees both."""
    figures = f"{text} {number(angle, '°')} ≤ {most:.0f}°: {{answer}}"
    margin = 1 - angle / most
    return view_check(
        rule, name, figures, margin, measured=angle, threshold=most, unit="°", step=step
    )


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
        over = track.tilt() >= TIPPED
        if not over.any():
            # That it does not fall over at all is said by its contract.
            continue
        step = int(over.argmax())
        up = track.placed.matrices[step] @ track.placed.matrices[0].T @ np.array([0.0, 0.0, 1.0])
        way = np.array(next(iter(told.values())))[:2]
        lean = max(float(np.linalg.norm(up[:2])), 1e-6)
        off = float(np.degrees(np.arccos(np.clip(up[:2] @ way / lean, -1, 1))))
        text = f"{name} leans aside of the way it is told to fall by"
        found.append(_at_most("lean", name, text, off, MOST_ASIDE, step))
    return found
