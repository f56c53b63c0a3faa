"""Does it begin as the photograph and end as told, on what it stands on?"""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from physagent_studio.contract.facts import Facts
from physagent_studio.contract.track import Window
from physagent_studio.contract.view.basics import (
    DROPPING,
    INSIDE,
    NOTICED,
    STOPPING,
    said,
    sight_in,
    view_check,
)
from physagent_studio.contract.words import number
from physagent_studio.records.judgement import Check

COVERS, JUMP = 0.93, 1.0
"""Least overlap of the drawn solid with its mask, and farthest jump as it takes over, pixels."""
APART = 0.06
"""How far the parts of what breaks move at least against each other, in its own sizes."""
SETTLED = 0.1
"""Part of the clip at its end for which what stops is at rest."""
TOUCHING = 2.0
"""Widest gap between what is drawn to stand on something and that, pixels."""


@dataclass(frozen=True, slots=True)
class Drawn:
    """How an object is drawn at its first pose: overlap with its mask (IoU), how far its middle
    lies from the mask's, pixels, and the gap below it to what it stands on, pixels."""

    overlap: float
    jump: float
    gap: float | None = None


def begins(facts: Facts, drawn: Mapping[str, Drawn]) -> list[Check]:
    """The drawn things cover their masks, and nothing stirs before it has a reason to."""
    found = []
    for name, one in drawn.items():
        text = f"{name} is drawn as the photograph shows it: overlap {one.overlap:.2f}: {{answer}}"
        found.append(
            view_check(
                "begins", name, text, (one.overlap - COVERS) / COVERS,
                measured=one.overlap, threshold=COVERS, step=0,
            )
        )  # fmt: skip
    worst, who = 0.0, ""
    for name in facts.rollout.objects:
        if _may_stir(facts, name):
            continue
        until = max(_first_cause(facts, name), 2)
        marks = sight_in(facts, name).marks[: until + 1]
        away = np.linalg.norm(marks - marks[0], axis=-1).max(axis=1)
        # What was built a little above its support settles on it; more than that is a fall.
        shift = max(float(away[:3].max()), float(away.max()) / TOUCHING)
        worst, who = max((worst, who), (shift, name))
    text = "nothing stirs before its time: {answer}"
    if worst > JUMP:
        text += f", {who} moves by {worst:.1f} px before anything makes it"
    found.append(
        view_check(
            "calm", "", text, (JUMP - worst) / JUMP, measured=worst, threshold=JUMP, unit="px",
            step=0,
        )
    )  # fmt: skip
    return found


def _first_cause(facts: Facts, name: str) -> int:
    """The last frame before an action is on it, or on what it leans on or carries, or another
    thing touches it that did not at first; the last of the clip where nothing ever does."""
    window, stack = facts.whole(), _stack(facts, name)
    caused = np.zeros(len(window), bool)
    for one in stack:
        caused |= facts.acted_on(one)[window.rows]
        for other in facts.rollout.objects:
            if other not in stack:
                caused |= facts.touching(one, other, window)
    first = int(np.argmax(caused)) if caused.any() else facts.last
    return max(facts.rollout.frame_of(first) - 1, 0)


def _stack(facts: Facts, name: str) -> frozenset[str]:
    """The object with all that it touches at first, directly or through others."""
    start, found = Window(0, min(3, facts.last)), {name}
    for _ in facts.rollout.objects:
        found |= {
            other
            for one in tuple(found)
            for other in facts.rollout.objects
            if other not in found and facts.touching(one, other, start).any()
        }
    return frozenset(found)


def _may_stir(facts: Facts, name: str) -> bool:
    """Whether an action, a fall that is told, or another thing that moves explains a motion."""
    first = Window(0, min(2 * facts.rollout.steps_per_frame, facts.last))
    if facts.acted_on(name)[first.rows].any() or said(facts.program, name, DROPPING | {"deforms"}):
        return True
    if not facts.touching_anything(name, first).any():
        return True
    others = (o for o in facts.rollout.objects if o != name and facts.acted_on(o)[first.rows].any())
    return any(facts.touching(name, other, first).any() for other in others)


def ends(facts: Facts, names: tuple[str, ...]) -> list[Check]:
    """What stops is at rest for the last tenth; what is kept swaying still moves: what a blow sets
    swaying comes to rest in its own time."""
    found = []
    last = max(round(SETTLED * facts.rollout.frames), 2)
    for name in names:
        steps = sight_in(facts, name).steps[-last:]
        driven = facts.acted_on(name)[-last * facts.rollout.steps_per_frame :].any()
        if said(facts.program, name, STOPPING):
            most = float(steps.max())
            text = f"{name} is at rest at the end: {{answer}}"
            margin = (2 * NOTICED - most) / (2 * NOTICED)
            found.append(
                view_check("ends", name, text, max(margin, -3.0), measured=most,
                           threshold=2 * NOTICED, unit="width")
            )  # fmt: skip
        elif said(facts.program, name, ("sways",)) and driven:
            most = float(steps.max())
            text = f"{name} still moves at the end: {{answer}}"
            found.append(
                view_check("ends", name, text, (most - NOTICED) / NOTICED, measured=most,
                           threshold=NOTICED, unit="width")
            )  # fmt: skip
    return found


def comes_apart(facts: Facts, names: tuple[str, ...]) -> list[Check]:
    """What broke is seen to be broken: its parts are no longer where they were to each other."""
    found = []
    for name in dict.fromkeys(release.name for release in facts.rollout.releases):
        if name not in names:
            continue
        marks, shown = sight_in(facts, name).marks, sight_in(facts, name).share >= INSIDE
        # What comes apart outside the picture is not seen to.
        last = int(np.flatnonzero(shown)[-1]) if shown.any() else 0
        moved = marks[last] - marks[0]
        apart = float(np.linalg.norm(moved - np.median(moved, axis=0), axis=-1).mean())
        share = apart / max(float(sight_in(facts, name).length[0]), 1.0)
        text = (
            f"{name} is seen to come apart: by {number(100 * share, '%')} of its size "
            f"≥ {number(100 * APART, '%')}: {{answer}}"
        )
        found.append(
            view_check("apart", name, text, (share - APART) / APART, measured=share,
                       threshold=APART)
        )  # fmt: skip
    return found


def touches(facts: Facts, names: tuple[str, ...]) -> list[Check]:
    """What has come to rest is drawn no farther than `TOUCHING` from what carries it.

    Told of bodies whose outline is exact; of others only contacts tell.
    """
    camera, last = facts.program.scene.camera, facts.last
    assert camera is not None
    found = []
    end = Window(max(last - facts.rollout.steps_per_frame, 0), last)
    for name in names:
        sight, outline = sight_in(facts, name), facts.outline(name)
        if sight.steps[-2:].max() >= NOTICED or sight.share[-1] < INSIDE or not outline.exact:
            continue
        carriers = [b for b in facts.rollout.bodies if facts.carried(name, b, end).any()]
        gaps = [
            float(values[-1])
            for carrier in carriers
            if (placed := facts.placed(carrier, end)) is not None
            and (placed.outline is None or placed.outline.exact)
            and (values := facts.gaps(name, carrier, end)) is not None
        ]
        if not gaps:
            continue
        _, depth = camera.project(facts.track(name, end).positions[-1:])
        pixels = max(min(gaps), 0.0) * camera.focal / max(float(depth[0]), 1e-3)
        text = f"{name} touches what it stands on: {pixels:.1f} px ≤ {TOUCHING:.0f} px: {{answer}}"
        found.append(
            view_check("touches", name, text, (TOUCHING - pixels) / TOUCHING, measured=pixels,
                       threshold=TOUCHING, unit="px", step=last)
        )  # fmt: skip
    return found
