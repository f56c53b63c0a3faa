"""Energy from nowhere, and motion without a cause."""

import numpy as np

from physagent_studio.arrays import BoolArray, FloatArray
from physagent_studio.contract.facts import Facts
from physagent_studio.contract.track import Window, bounded
from physagent_studio.contract.words import number
from physagent_studio.program.actions import FixObject
from physagent_studio.program.scene.bodies import DEFORMABLE
from physagent_studio.program.scene.shapes import depth_inside, place_support
from physagent_studio.program.scene.state import Floor, Slab
from physagent_studio.records.judgement import Check

ELASTIC_SECONDS = 0.06
"""Longest time for which a contact may store energy that the books do not show."""
CAUSE_SECONDS = 0.1
"""A cause may lie this far back when something starts to move."""
FELL = 20.0
"""A tilt in degrees at which something is falling over."""
STILL, MOVING = 0.01, 0.05
"""Speeds below and above which a body counts as at rest and as moving, m/s."""


def physics_check(
    name: str,
    text: str,
    margin: float,
    measured: float | None = None,
    threshold: float | None = None,
    unit: str = "",
    step: int | None = None,
) -> Check:
    """An always-on check; `{answer}` in its text becomes yes or no."""
    ok = margin >= 0
    return Check(
        id=f"physics.{name}",
        text=text.format(answer="yes" if ok else "no"),
        ok=ok,
        measured=measured,
        threshold=threshold,
        unit=unit,
        margin=bounded(margin),
        step=step,
        kind=name,
        always_on=True,
    )


def start_overlap(facts: Facts, name: str) -> float:
    """Deepest overlap of an object with anything on the first step, m."""
    rows, index = facts.rollout.contacts, facts.rollout.index(name)
    first = rows[(rows["step"] == 0) & ((rows["a"] == index) | (rows["b"] == index))]
    return float(first["depth"].max(initial=0.0))


# --- energy ----------------------------------------------------------------------------------


def energy(facts: Facts) -> Check:
    """How much energy appears beyond the work of the actions, over a fiftieth of all of it.

    Not judged where something is elastic, see `Rollout`.
    """
    if any(item.body.kind in DEFORMABLE for item in facts.program.scene.objects):
        text = "energy rises only where an action does work: {answer}, not judged: elastic bodies"
        return physics_check("energy", text + " keep energy that is not recorded", 0.0)
    kinetic, potential = facts.rollout.kinetic, facts.rollout.potential
    rows = slice(0, facts.last + 1)
    total = (kinetic + potential)[rows].sum(axis=1)
    gained = _gains(total, facts.dt)
    acted = _any_action(facts)[rows]
    work = sum(span.work for span in facts.rollout.spans)
    change = float(np.diff(total, prepend=total[0])[acted].sum())
    appeared = float(gained[~acted].sum()) + max(change - work, 0.0)
    step = int(np.where(acted, 0.0, gained).argmax()) if appeared > 0 else None
    weights = facts.rollout.masses * 9.81
    overlaps = np.array([start_overlap(facts, name) for name in facts.rollout.objects])
    allowed = 0.02 * float(kinetic[rows].sum(axis=1).max() + np.ptp(total))
    allowed += float(weights.sum()) * 2e-4 + 2 * float(weights @ overlaps)
    figures = f"{number(appeared, 'J')} ≤ {number(allowed, 'J')}"
    text = f"energy that nothing put in: {figures}: {{answer}}"
    if overlaps.max(initial=0.0) > 1e-3:
        text += ", what overlapped in frame 0 may come apart"
    margin = (allowed - appeared) / max(allowed, 1e-9)
    return physics_check("energy", text, margin, appeared, allowed, "J", step)


def _gains(total: FloatArray, dt: float) -> FloatArray:
    """(S,) rise of each row above all rows of the moment before it.

    A bounce takes energy into the contact and gives it back; only what exceeds the level of
    the last hundredths of a second is new.
    """
    reach = max(1, round(ELASTIC_SECONDS / dt))
    padded = np.concatenate([np.full(reach, -np.inf), total])
    before = np.lib.stride_tricks.sliding_window_view(padded, reach)[: len(total)].max(axis=1)
    return np.where(np.isfinite(before), np.maximum(total - before, 0.0), 0.0)


def _any_action(facts: Facts) -> BoolArray:
    """(S + 1,) whether any action that can do work acts, or has just stopped."""
    acted = np.zeros(facts.rollout.steps + 1, bool)
    for span in facts.rollout.spans:
        action = facts.program.action(span.id)
        if span.start is not None and not isinstance(action, FixObject):
            end = facts.rollout.steps if span.end is None else span.end
            acted[span.start : end + 2] = True
    return acted


# --- causes ----------------------------------------------------------------------------------


def caused(facts: Facts) -> Check:
    """Nothing that lay still starts to move without an action, another body or a fall, and what
    stands on level ground does not fall over by itself.
    """
    for name in facts.rollout.objects:
        item = facts.program.scene.object(name)
        if item is not None and item.body.kind in DEFORMABLE:
            continue
        fell = _fell_over(facts, name)
        if fell is not None:
            frame = facts.rollout.frame_of(fell)
            text = f"nothing moves without a cause: {{answer}}, {name} falls over by itself"
            return physics_check("cause", f"{text} at frame {frame}", -1.0, step=fell)
        for start in _starts(facts, name):
            if not _has_cause(facts, name, start):
                frame = facts.rollout.frame_of(start)
                text = (
                    "nothing moves without a cause: {answer}, "
                    f"{name} starts to move at frame {frame}"
                )
                return physics_check("cause", text, -1.0, step=start)
    return physics_check("cause", "nothing moves without a cause: {answer}", 1.0)


def _fell_over(facts: Facts, name: str) -> int | None:
    """The step at which something that stood on level ground has tipped over by itself.

    In the picture it stood there, so a body that cannot is a wrong body. What hangs over an
    edge or lies on a slope may fall; so may what anything has touched or acted on.
    """
    track = facts.track(name, facts.whole())
    if not _stands_level(facts, name):
        return None
    fell = track.first(track.tilt() > FELL)
    if fell is None:
        return None
    until = Window(0, fell)
    others = (other for other in facts.rollout.objects if other != name)
    if facts.acted_on(name)[until.rows].any() or start_overlap(facts, name) > 1e-3:
        return None
    return None if any(facts.touching(name, other, until).any() for other in others) else fell


def _stands_level(facts: Facts, name: str) -> bool:
    """Whether it starts on a floor or well on a table."""
    first = Window(0, min(facts.last, 5))
    position = facts.track(name, first).positions[:1]
    for support in facts.program.scene.supports:
        if support.shape is None or not facts.carried(name, support.name, first).any():
            continue
        if isinstance(support.shape, Floor):
            return True
        if isinstance(support.shape, Slab):
            over = position * [1, 1, 0] + [0, 0, support.shape.position[2]]
            return float(depth_inside(over, place_support(support.shape))[0]) > 0.0
    return False


def _starts(facts: Facts, name: str) -> list[int]:
    """Steps at which the object, having been still, begins a motion that gets anywhere."""
    track = facts.track(name, facts.whole())
    bustle = track.bustle
    starts: list[int] = []
    still = True
    since = 0
    for row, value in enumerate(bustle):
        if value < STILL:
            still, since = True, row
        elif value > MOVING and still:
            ahead = track.positions[row : row + round(0.5 / facts.dt) + 1]
            travel = np.linalg.norm(ahead - track.positions[since], axis=-1).max()
            if travel > max(0.005, 0.05 * track.size):
                starts.append(since)
            still = False
    return starts


def _has_cause(facts: Facts, name: str, start: int) -> bool:
    reach = max(2, round(CAUSE_SECONDS / facts.dt))
    around = Window(max(0, start - reach), min(facts.last, start + reach))
    if facts.acted_on(name)[around.rows].any():
        return True
    others = (other for other in facts.rollout.objects if other != name)
    if any(facts.touching(name, other, around).any() for other in others):
        return True
    if not facts.touching_anything(name, Window(start, start)).any():
        return True
    if start * facts.dt < 0.5 and start_overlap(facts, name) > 1e-3:
        return True
    return _paid_by_height(facts, name, start)


def _paid_by_height(facts: Facts, name: str, start: int) -> bool:
    """Whether its height pays for its motion: it slides, rolls or tips over.

    Until an action or another body gives it more.
    """
    index = facts.rollout.objects.index(name)
    ahead = Window(start, min(facts.last, start + round(0.5 / facts.dt)))
    given = facts.acted_on(name)[ahead.rows].copy()
    for other in facts.rollout.objects:
        if other != name:
            given |= facts.touching(name, other, ahead)
    count = int(given.argmax()) if given.any() else len(given)
    rows = slice(start, start + max(count, 1))
    energy = (facts.rollout.kinetic + facts.rollout.potential)[rows, index]
    kinetic = facts.rollout.kinetic[rows, index]
    return float(energy.max() - energy[0]) <= 0.2 * float(kinetic.max()) + 1e-9
