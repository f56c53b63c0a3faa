"""The director: the same event at a pace and within bounds that a viewer can follow.

From what the view checks measured follow, in closed form, how much gentler the pushes have to be
and how much slower the clip; a handful of such programs is tried before any number is searched.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from physagent_studio.agent.roles import Situation
from physagent_studio.contract import Facts
from physagent_studio.contract.picture import sight_of
from physagent_studio.contract.view import FILLS, INSIDE, acting_objects, pacing_of, subject_of
from physagent_studio.errors import StudioError
from physagent_studio.program.actions import ApplyForce, Directed, SetVelocity
from physagent_studio.program.edits import Edit, SetField, apply
from physagent_studio.program.program import PhysicalProgram
from physagent_studio.program.timing import PACE, SLOWEST, retimed, wait_of
from physagent_studio.records import Rollout

VIEW = ("framing", "pace", "heading", "stirs")
"""Codes of mismatches of the view."""


@dataclass(frozen=True, slots=True)
class DirectingSettings:
    """How much gentler or slower a clip is made at once."""

    spare_share: float = 0.9  # 0.7..1: of what would just do, that is aimed at
    # factor, 0.1..1: that are chosen by themselves, as people name them
    time_factors: tuple[float, ...] = (0.25, 1 / 3, 0.4, 0.5, 2 / 3, 0.8, 1.0)
    comfort_share: float = 0.6  # 0.3..1: of the clip that a motion shall fill
    lead_frames: int = 6  # frames, 2..20: that show how things stand before anything moves
    blow_seconds: float = 0.06  # s, 0.02..0.2: a push shorter than this is a blow, and stays one


DIRECTING = DirectingSettings()


@dataclass(frozen=True, slots=True)
class Shown:
    """What a viewer saw of a run. haste: how many times too fast the fastest thing was; kept: part
    of the way of what got out of the picture that lay inside; fills: part of the clip in which
    something moved; sudden: whether anything falls or is struck; falls: whether it falls, breaks
    or falls over, which takes as long as it takes however gently it begins."""

    haste: float
    kept: float
    fills: float
    sudden: bool
    falls: bool


def direct(situation: Situation) -> Iterator[tuple[Edit, ...]]:
    """Programs that show the same event more gently, the mildest change first."""
    rollout = situation.rollout
    codes = {m.code for m in situation.assessment.diagnosis}
    if rollout is None or rollout.blown_up is not None or not codes & set(VIEW):
        return
    shown = shown_of(situation, rollout)
    keeps_pace = pace_is_pinned(situation)
    seen: set[str] = set()
    for gentler, longer, factor in _plans(shown, situation.program):
        if factor != 1 and keeps_pace:
            continue
        edits = replanned(situation.program, gentler, longer, factor)
        if edits and repr(edits) not in seen:
            seen.add(repr(edits))
            yield edits


def shown_of(situation: Situation, rollout: Rollout) -> Shown:
    """What the view checks of a run amount to."""
    program = situation.program
    facts = Facts.of(program, rollout)
    checks = [c for c in situation.assessment.checks if c.kind == "view"]
    haste = max(
        (
            c.measured / c.threshold
            for c in checks
            if ".pace." in c.id and c.measured and c.threshold
        ),
        default=0.0,
    )
    fills = next((c.measured or 0.0 for c in checks if c.id == "view.fills"), FILLS)
    kept = 1.0
    for check in checks:
        if check.id.startswith(("view.inside.", "view.breaks.")) and not check.ok:
            kept = min(kept, _kept(facts, subject_of(check, rollout)))
    falls = _falls_down(program, rollout)
    return Shown(haste, kept, fills, falls or is_sudden(program, rollout), falls)


def pace_is_pinned(situation: Situation) -> bool:
    """Whether a person has pinned how fast the clip is shown, as a whole or one number of it."""
    return any(path == "clip" or path in PACE for path in situation.memory.pinned)


def is_sudden(program: PhysicalProgram, rollout: Rollout) -> bool:
    """Whether something falls, flies, falls over, is struck, or goes from under another thing:
    what slow motion is for."""
    told = [s for s in program.contract.statements if not s.negated]
    met = any(s.kind == "contacts" for s in told)
    apart = any(s.kind == "leaves" and s.other in rollout.objects for s in told)
    return met or apart or _falls_down(program, rollout)


def _falls_down(program: PhysicalProgram, rollout: Rollout) -> bool:
    # A leap takes as long as it is high, a low one too.
    kinds = ("topples", "breaks", "flips", "spreads", "airborne", "bounces")
    if any(s.kind in kinds and not s.negated for s in program.contract.statements):
        return True
    facts = Facts.of(program, rollout)
    acting = acting_objects(program)
    return any(_falls(facts, name) for name in rollout.objects if name in acting)


def _falls(facts: Facts, name: str) -> bool:
    """Whether it is in the air for a while and comes down by a part of its height."""
    free = ~facts.touching_anything(name, facts.whole())
    height = facts.track(name, facts.whole()).positions[:, 2]
    return bool(free.sum() * facts.dt > 0.04 and np.ptp(height[free]) > 0.3 * _size(facts, name))


def _size(facts: Facts, name: str) -> float:
    return float(facts.outline(name).size.mean())


def _kept(facts: Facts, name: str) -> float:
    """Part of its way that a thing went before it left the picture."""
    sight = sight_of(facts, name) if facts.is_object(name) else None
    if sight is None:
        return 1.0
    out = np.flatnonzero(sight.share < INSIDE)
    if not len(out):
        return 1.0
    rows = np.minimum(facts.rollout.frame_steps(), facts.last)
    path = facts.rollout.positions[rows, facts.rollout.objects.index(name)]
    way = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(path, axis=0), axis=-1))])
    return float(np.clip(way[out[0]] / max(way[-1], 1e-6), 0.02, 1.0))


def _plans(shown: Shown, program: PhysicalProgram) -> Iterator[tuple[float, float, float]]:
    """(ratio of speeds, ratio of the pushes' durations, ratio of the clip's time).

    What falls is slowed first; what rolls, slides or is pushed stays at real time if it can.
    """
    slower, gentler = [*_slower(shown, program)], [*_gentler(shown)]
    yield from (*slower, *gentler) if shown.falls else (*gentler, *slower)


def _gentler(shown: Shown) -> Iterator[tuple[float, float, float]]:
    slow = min(1.0, DIRECTING.spare_share / shown.haste) if shown.haste > 1 else 1.0
    nearer, much_nearer = (
        DIRECTING.spare_share * shown.kept**0.5,
        DIRECTING.spare_share * shown.kept,
    )
    gentle = min(slow, nearer) if shown.kept < 1 else slow
    if gentle < 1:
        yield gentle, 1.0, 1.0
        yield gentle, 1 / gentle, 1.0
    if shown.kept < 1:
        yield min(slow, much_nearer), 1.0, 1.0
        yield min(slow, much_nearer), 1 / max(much_nearer, 0.1), 1.0
    if shown.fills < FILLS:
        for length in (2.0, 4.0):
            yield min(gentle, 1 / length), length, 1.0


def _slower(shown: Shown, program: PhysicalProgram) -> Iterator[tuple[float, float, float]]:
    now = program.clip.time_factor
    if not shown.sudden or now <= SLOWEST:
        return
    slow = min(1.0, DIRECTING.spare_share / shown.haste) if shown.haste > 1 else 1.0
    stretch = min(shown.fills / DIRECTING.comfort_share, 1.0) if shown.fills < FILLS else 1.0
    both = min(slow, stretch)
    for wanted in dict.fromkeys((both, 1.4 * both, slow, stretch, 0.7 * both)):
        factor = _named_factor(now * wanted)
        if factor >= now:
            continue
        yield 1.0, 1.0, factor / now
        if shown.kept < 1:
            yield DIRECTING.spare_share * shown.kept**0.5, 1.0, factor / now
        if (left := min(1.0, slow * now / factor)) < 1:
            yield left, 1.0, factor / now


def _named_factor(factor: float) -> float:
    """The slowest of the usual factors that is not faster than this."""
    return max((f for f in DIRECTING.time_factors if f <= factor + 1e-9), default=SLOWEST)


def replanned(
    program: PhysicalProgram, gentler: float, longer: float, slower: float
) -> tuple[Edit, ...]:
    """Edits that scale the speeds that pushes give, how long they last, and the clip's time."""
    edits: list[Edit] = []
    for action in program.event.actions:
        base = f"event.actions.{action.id}"
        vector = getattr(action, "force", None) or getattr(action, "velocity", None)
        if not isinstance(vector, Directed) or not isinstance(action, ApplyForce | SetVelocity):
            continue
        speeds = isinstance(action, SetVelocity) or vector.quantity == "target_speed"
        # Over the same way a brake ends a slower motion by the square of how much slower it is.
        ratio = gentler if speeds else gentler**2 if _is_brake(vector) else 1.0
        if ratio != 1:
            field = "force" if isinstance(action, ApplyForce) else "velocity"
            value = float(f"{vector.magnitude * ratio:.5g}")
            edits.append(SetField(path=f"{base}.{field}.magnitude", value=value))
        blow = getattr(action, "duration", 0) * program.clip.step_seconds < DIRECTING.blow_seconds
        if longer != 1 and isinstance(action, ApplyForce) and speeds and not blow:
            room = program.clip.steps - (action.start_step if action.when is None else 0)
            value = max(min(round(action.duration * longer), room), 1)
            edits.append(SetField(path=f"{base}.duration", value=value))
    if slower == 1:
        return tuple(edits)
    try:
        changed = apply(program, edits)
    except StudioError:
        return ()
    return (*edits, *retimed(changed, changed.clip.time_factor * slower))


def _is_brake(vector: Directed) -> bool:
    return vector.along == "against_velocity" and vector.quantity == "acceleration"


def begun_sooner(program: PhysicalProgram, rollout: Rollout) -> tuple[Edit, ...]:
    """Edits with which nothing waits for more than a moment before the first motion, where it is
    the schedule alone that has it wait; () where it does not."""
    pacing = pacing_of(Facts.of(program, rollout))
    if pacing is None or pacing.first is None:
        return ()
    frame = program.clip.steps_per_frame * program.clip.step_seconds
    wait = max(int(wait_of(program) / frame) - 1, 0)
    skip = min(max(pacing.first - DIRECTING.lead_frames, 0), wait)
    return retimed(program, program.clip.time_factor, skip=skip * frame) if skip else ()
