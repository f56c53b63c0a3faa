"""Can an eye follow it, and does it last? What moves when, from frame to frame."""

import itertools
from dataclasses import dataclass

import numpy as np

from physagent_studio.arrays import BoolArray
from physagent_studio.contract.facts import Facts
from physagent_studio.contract.view.basics import (
    DROPPING,
    INSIDE,
    NOTICED,
    STOPPING,
    TIMED,
    acting_objects,
    said,
    sight_in,
    view_check,
)
from physagent_studio.program.timing import SLOWEST
from physagent_studio.records.judgement import Check

STEP, FALLING_STEP = 0.04, 0.08
"""Farthest step from frame to frame, parts of the width; in the frames of a blow or a fall."""
TIPPING = 2.0
"""Degrees from frame to frame from which on a tilting thing is falling over."""
LIES, LIES_STEPS, TILTS = 0.1, 10, 15.0
"""Part of the clip at its end for which what fell over lies, and control steps at least, by which
short clips tell a fall from rest; degrees by which it may still rock."""
FALL_FILLS = 0.2
"""The same of a fall in the slowest motion there is."""
FILLS, RESTS_BY = 0.45, 0.9
"""Least part of the clip that the motion fills, and by when what comes to rest does so."""
LEAST_SHIFT = 0.012
"""Least way in the picture that is noticed, parts of its diagonal."""


def paces(facts: Facts, names: tuple[str, ...]) -> list[Check]:
    """Nothing moves farther from one frame to the next than an eye follows."""
    found = []
    for name in facts.rollout.objects:
        steps = sight_in(facts, name).steps
        allowed = np.where(_sudden(facts, name), FALLING_STEP, STEP)
        ratio = steps / allowed
        worst = int(ratio.argmax())
        if name not in names and ratio[worst] <= 1:
            continue
        limit = float(allowed[worst])
        figures = f"{100 * steps[worst]:.1f} % of the width per frame ≤ {100 * limit:.0f} %"
        found.append(
            view_check(
                "pace",
                name,
                f"{name} moves so that an eye can follow: {figures}: {{answer}}",
                1.0 - float(ratio[worst]),
                measured=float(steps[worst]),
                threshold=limit,
                unit="width",
                step=int(facts.rollout.frame_steps()[worst]),
            )
        )
    return found


def _sudden(facts: Facts, name: str) -> BoolArray:
    """(F − 1,) the frames in which it falls, flies freely or falls over, or is struck."""
    whole = facts.whole()
    free = ~facts.touching_anything(name, whole)
    struck = np.zeros(len(whole), bool)
    for other in facts.rollout.objects:
        if other != name:
            touching = facts.touching(name, other, whole)
            struck |= touching & ~np.concatenate([[True], touching[:-1]])
    rows = np.minimum(facts.rollout.frame_steps(), facts.last)
    falls = np.array([free[a : b + 1].mean() > 0.5 for a, b in itertools.pairwise(rows)])
    blows = np.array([struck[a : b + 1].any() for a, b in itertools.pairwise(rows)])
    tilt = facts.track(name, whole).tilt()[rows]
    tips = np.abs(np.diff(tilt)) > TIPPING
    # A blow is seen on its own frame and on the next.
    return falls | tips | blows | np.concatenate([[False], blows[:-1]])


def moving_frames(facts: Facts, names: tuple[str, ...]) -> BoolArray:
    """(F − 1,) between which frames any of the things is seen to move in the picture."""
    moving = np.zeros(facts.rollout.frames - 1, bool)
    for name in names:
        sight = sight_in(facts, name)
        seen = np.maximum(sight.steps, sight.turns)
        moving |= (seen >= NOTICED) & (sight.share[1:] >= INSIDE)
    return moving


@dataclass(frozen=True, slots=True)
class Pacing:
    """When a viewer sees something, in frames. moving: how many of the clip's intervals show a
    motion; first, last: the first and the last of them, None where nothing moves; crossings: for
    each acting thing that gets out of the picture the frame from which less than half of it is
    seen; fastest: the farthest step, parts of the width; time_factor: of the clip."""

    moving: int
    first: int | None
    last: int | None
    crossings: tuple[tuple[str, int], ...]
    fastest: float
    time_factor: float


def pacing_of(facts: Facts) -> Pacing | None:
    """The pace of a run as a viewer sees it; None where there is no camera."""
    program = facts.program
    if program.scene.camera is None:
        return None
    acting = acting_objects(program)
    names = tuple(n for n in facts.rollout.objects if n in acting)
    moving = np.flatnonzero(moving_frames(facts, names))
    crossings = []
    for name in names:
        out = np.flatnonzero(sight_in(facts, name).share < INSIDE)
        if len(out):
            crossings.append((name, int(out[0])))
    return Pacing(
        moving=len(moving),
        first=int(moving[0]) if len(moving) else None,
        last=int(moving[-1]) + 1 if len(moving) else None,
        crossings=tuple(crossings),
        fastest=max(
            (float(sight_in(facts, n).steps.max()) for n in facts.rollout.objects), default=0.0
        ),
        time_factor=program.clip.time_factor,
    )


def fills(facts: Facts, names: tuple[str, ...]) -> Check:
    """The motion that the sentence is about fills a good part of the clip."""
    moving = moving_frames(facts, names)
    share = float(moving.mean())
    least = _least_fill(facts, names)
    if share < least:
        text = f"the motion fills {100 * share:.0f} % of the clip ≥ {100 * least:.0f} %: {{answer}}"
        margin = (share - least) / least
        return view_check("fills", "", text, margin, measured=share, threshold=least)
    rests = [n for n in names if said(facts.program, n, STOPPING)]
    ends = (int(np.flatnonzero(moving)[-1]) + 1) / len(moving)
    if rests and len(rests) == len(names) and ends > RESTS_BY:
        text = f"the motion is over by {100 * ends:.0f} % of the clip ≤ {100 * RESTS_BY:.0f} %"
        margin = (RESTS_BY - ends) / RESTS_BY
        return view_check(
            "fills", "", text + ": {answer}", margin, measured=ends, threshold=RESTS_BY
        )  # fmt: skip
    text = f"the motion fills {100 * share:.0f} % of the clip: {{answer}}"
    return view_check("fills", "", text, (share - least) / least, measured=share, threshold=least)


def _least_fill(facts: Facts, names: tuple[str, ...]) -> float:
    """Less in the slowest motion there is, where things fall: a fall lasts as long as it does."""
    slowest = facts.program.clip.time_factor <= SLOWEST + 1e-6
    falls = any(said(facts.program, name, DROPPING) for name in names)
    return FALL_FILLS if slowest and falls else FILLS


def something(facts: Facts, names: tuple[str, ...]) -> Check:
    """Some acting object visibly moves, turns or changes its shape inside the picture."""
    camera = facts.program.scene.camera
    assert camera is not None
    least = LEAST_SHIFT * float(np.hypot(*camera.size))
    best = 0.0
    for name in names:
        sight = sight_in(facts, name)
        seen = sight.share > 0.25
        if seen.any():
            points = np.concatenate([sight.marks, sight.sides], axis=1)[seen]
            best = max(best, float(np.linalg.norm(points - points[0], axis=-1).max()))
    text = f"something visible happens: {best:.0f} px ≥ {least:.0f} px: {{answer}}"
    return view_check(
        "something",
        "",
        text,
        min(best / least - 1, 10.0),
        measured=best,
        threshold=least,
        unit="px",
    )


def in_time(facts: Facts, checks: tuple[Check, ...]) -> Check:
    """Nothing decisive happens only in the last two frames."""
    rollout = facts.rollout
    last = rollout.steps - 2 * rollout.steps_per_frame
    negated = {s.id for s in facts.program.contract.statements if s.negated}
    steps = [
        c.step
        for c in checks
        if c.ok and c.demanded and c.kind in TIMED and c.id not in negated and c.step is not None
    ]
    latest = max(steps, default=0)
    frame = rollout.frame_of(latest)
    text = (
        f"the event is over before the last frames: {{answer}}, frame {frame} of {rollout.frames}"
    )
    return view_check(
        "in_time", "", text, (last - latest) / max(rollout.steps, 1), measured=float(frame),
        threshold=float(rollout.frame_of(last)), unit="frame", step=latest,
    )  # fmt: skip


def come_down(facts: Facts, names: tuple[str, ...]) -> list[Check]:
    """What falls over within the picture is seen to lie: the clip does not end in mid fall."""
    found = []
    last = max(round(LIES * facts.rollout.steps), LIES_STEPS)
    for name in names:
        if not said(facts.program, name, ("topples",)) or sight_in(facts, name).share[-1] < INSIDE:
            continue
        turn = float(np.ptp(facts.track(name, facts.whole()).tilt()[-last:]))
        text = (
            f"{name} has come down: it tilts by {turn:.0f}° ≤ {TILTS:.0f}° at the end: {{answer}}"
        )
        found.append(
            view_check("in_time", name, text, (TILTS - turn) / TILTS, measured=turn,
                       threshold=TILTS, unit="°", step=facts.last)
        )  # fmt: skip
    return found
