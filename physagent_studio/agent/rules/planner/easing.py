"""The gentlest program that realises the event: after a pass, efforts and speeds are lowered.

What things do and how far they go stays as it was; only how hard they are driven changes.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Iterator
from dataclasses import dataclass
from functools import partial
from itertools import chain, zip_longest

import numpy as np

from physagent_studio.agent.roles import Situation
from physagent_studio.agent.rules.planner.costs import cost_of
from physagent_studio.agent.rules.planner.directing import (
    DIRECTING,
    begun_sooner,
    pace_is_pinned,
    replanned,
)
from physagent_studio.agent.rules.planner.factors import may_change
from physagent_studio.agent.rules.planner.trials import TRIAL, Candidate, Search
from physagent_studio.agent.rules.planner.wording import proposal
from physagent_studio.contract import Facts
from physagent_studio.contract.picture import sight_of
from physagent_studio.contract.view import acting_objects, pacing_of
from physagent_studio.program.edits import Edit
from physagent_studio.program.program import PhysicalProgram
from physagent_studio.program.statements import Contacts
from physagent_studio.records import Check, Proposal, Rollout


@dataclass(frozen=True, slots=True)
class EasingSettings:
    """How far a program is made gentler."""

    max_runs: int = 10  # count, 3..50: of one easing, where a run costs one unit
    settled_ratio: float = 0.9  # 0.7..0.99: of two efforts, from which it is not settled further
    min_ratio: float = 0.25  # 0.1..0.9: of the efforts, below which none goes at once
    times_as_long: tuple[float, ...] = (1.0, 3.0)  # ratio, 1..6: of how long a push lasts, tried
    soon_frames: int = 9  # frames, 4..20: by then something moves, unless it began later before
    min_way_share: float = 0.85  # 0.5..1: of its way that each acting thing still goes
    balance_deg: tuple[float, float] = (20.0, 65.0)  # 5..85: of tilt, where a thing may hang
    max_balance_s: float = 0.3  # s, 0.1..1: that it may be between these: a metre takes so long
    start_way_share: float = 0.2  # 0.05..0.4: of its way, that each has gone by the next number
    max_start_share: float = 0.5  # 0.3..0.8: of the frames on which it moves
    still_ratio: float = 0.02  # 0.005..0.1: over its fastest step, below which it does not move
    # 0..0.2: of its longer side in the picture, by which each may reach beyond the frame
    max_beyond_ratio: float = 0.02


EASING = EasingSettings()


class Easing:
    """Lowers efforts and speeds of a program that holds, while all margins stay, and lets nothing
    wait for long before it moves."""

    def ease(self, situation: Situation) -> Proposal:
        """A gentler program; without hunks where there is none."""
        search = Search(situation, max(int(EASING.max_runs / cost_of(situation.program)), 1))
        best, told = None, ""
        gentlest = search.carry_out(partial(_gentlest, situation))
        for longer, found in zip(EASING.times_as_long, gentlest, strict=True):
            if found is not None and (best is None or _is_clearer(found[1], best)):
                ratio, best = found
                told = f"It happens as well with {100 * ratio:.0f} % of the speeds"
                told += f" and {longer:.0f} times as long a push" if longer > 1 else ""
                told += f": the gentlest of {search.runs} tried that holds everything. "
        best, cut = self._begun_sooner(situation, search, best)
        if best is None:
            why = f"nothing gentler holds everything ({search.runs} tried)"
            return _told(situation, why, search, confidence=1.0)
        told += "It begins sooner." if cut else ""
        return _told(situation, told.strip(), search, best.edits, confidence=0.9)

    def _begun_sooner(
        self, situation: Situation, search: Search, best: Candidate | None
    ) -> tuple[Candidate | None, bool]:
        """The best program, or the present one, without a wait before what happens, and whether
        that is another one."""
        program = situation.program if best is None else best.program
        rollout = situation.rollout if best is None else best.rollout
        if rollout is None or pace_is_pinned(situation):
            return best, False
        cut = begun_sooner(program, rollout)
        edits = (*(best.edits if best else ()), *cut)
        search.limit += 1
        found = search.run(edits) if cut and may_change(situation, edits) else None
        holds = found is not None and found.score.holds
        return (found, True) if holds else (best, False)


Gentler = tuple[float, Candidate] | None
"""Ratio of the speeds and what comes of it; None where nothing gentler holds."""


def _gentlest(situation: Situation, search: Search) -> list[Gentler]:
    """For each length of the pushes the lowest ratio of the speeds with which all still holds."""
    found: dict[float, Gentler] = dict.fromkeys(EASING.times_as_long)
    ways = [_halved(situation, search, longer, found) for longer in found]
    if search.limit < EASING.max_runs:
        # There may be no run left for the second, and longer pushes are the second choice.
        ways = [chain(*ways)]
    # In turn, for what the one comes to says nothing of the other: two cores have both to do.
    deque(zip_longest(*ways), maxlen=0)
    return list(found.values())


def _halved(
    situation: Situation, search: Search, longer: float, best: dict[float, Gentler]
) -> Iterator[None]:
    """By halving, a run at a time: the lowest ratio where the pushes last so many times as long."""
    low, high = EASING.min_ratio / longer, 1.0
    while high / low > 1 / EASING.settled_ratio and not search.exhausted:
        ratio = (low * high) ** 0.5
        edits = replanned(situation.program, ratio, longer, 1.0)
        if not edits or not may_change(situation, edits):
            break
        found = search.run(edits)
        if found is not None and _is_as_good(situation, found):
            best[longer], high = (ratio, found), ratio
        else:
            low = ratio
        yield


def _is_as_good(situation: Situation, found: Candidate) -> bool:
    """Whether all still holds, no margin that was sturdy is weak now, and each goes as far."""
    if not found.score.holds or found.rollout is None or situation.rollout is None:
        return False
    before = {c.id: c.margin for c in situation.assessment.checks if c.demanded}
    weaker = any(
        c.margin < min(TRIAL.sturdy_margin, before.get(c.id, TRIAL.sturdy_margin))
        for c in found.checks
        if c.demanded
    )
    shorter = _filled(found.checks) < _filled(situation.assessment.checks) - 0.02
    alike = _is_seen_as_well(situation, found, situation.rollout)
    return not weaker and not shorter and alike


def _is_clearer(one: Candidate, other: Candidate) -> bool:
    """Whether more of the clip shows it happen, where little does, else whether it is slower."""
    most = DIRECTING.comfort_share
    fuller = min(_filled(one.checks), most) - min(_filled(other.checks), most)
    return fuller > 0.03 or (fuller > -0.03 and _haste(one) < EASING.settled_ratio * _haste(other))


def _haste(found: Candidate) -> float:
    """The farthest step from frame to frame of what acts, parts of the width."""
    return max(
        (c.measured or 0.0 for c in found.checks if c.id.startswith("view.pace.")), default=0.0
    )


def _filled(checks: tuple[Check, ...]) -> float:
    """Part of the clip in which something moves."""
    return next((c.measured or 0.0 for c in checks if c.id == "view.fills"), 1.0)


def _is_seen_as_well(situation: Situation, found: Candidate, before: Rollout) -> bool:
    """Whether each goes as far and is as whole in the picture, and something moves as soon."""
    assert found.rollout is not None
    now, was = Facts.of(found.program, found.rollout), Facts.of(situation.program, before)
    meant = acting_objects(situation.program) | _met(situation.program)
    names = [name for name in before.objects if name in meant]
    far = all(_way(now, name) >= EASING.min_way_share * _way(was, name) for name in names)
    whole = all(_beyond(now, n) <= max(_beyond(was, n), EASING.max_beyond_ratio) for n in names)
    lets_go = _pushed_through(now) <= _pushed_through(was)
    falls = all(_balances(now, n) <= max(_balances(was, n), EASING.max_balance_s) for n in names)
    most = EASING.max_start_share
    lively = all(_creeps(now, name) <= max(_creeps(was, name) + 0.02, most) for name in names)
    soon = _first(now) <= max(_first(was), EASING.soon_frames)
    return far and whole and lets_go and falls and lively and soon


def _balances(facts: Facts, name: str) -> float:
    """How long what topples is neither standing nor about to lie, s: a push that hardly suffices
    leaves it on its edge."""
    told = (s for s in facts.program.contract.statements if s.kind == "topples" and not s.negated)
    if name not in {s.subject for s in told}:
        return 0.0
    tilt = facts.track(name, facts.whole()).tilt()
    low, high = EASING.balance_deg
    return float(np.count_nonzero((tilt > low) & (tilt < high))) * facts.dt


def _creeps(facts: Facts, name: str) -> float:
    """After how much of the time that it moves a thing has gone the first part of its way."""
    rows = np.minimum(facts.rollout.frame_steps(), facts.last)
    path = facts.rollout.positions[rows, facts.rollout.objects.index(name)]
    steps = np.linalg.norm(np.diff(path, axis=0), axis=1)
    steps = steps[steps > EASING.still_ratio * steps.max(initial=0.0)]
    if not len(steps):
        return 0.0
    gone = np.cumsum(steps) / steps.sum()
    return int(np.argmax(gone > EASING.start_way_share)) / len(steps)


def _pushed_through(facts: Facts) -> set[str]:
    """What is still pushed when it meets the thing that it shall meet: both go on together."""
    found = set()
    for told in facts.program.contract.statements:
        if not isinstance(told, Contacts) or told.negated or told.to_step is not None:
            continue
        if not (facts.is_object(told.subject) and facts.is_object(told.other)):
            continue
        met = np.flatnonzero(facts.touching(told.subject, told.other, facts.whole()))
        pushes = {a.id for a in facts.program.event.actions if a.name == told.subject}
        spans = (span for span in facts.rollout.spans if span.id in pushes)
        if len(met) and any((s.start or 0) <= met[0] < (s.end or 0) for s in spans):
            found.add(told.subject)
    return found


def _beyond(facts: Facts, name: str) -> float:
    """How far it reaches beyond the frame at most, in parts of its longer side in the picture."""
    sight = sight_of(facts, name)
    if sight is None:
        return 0.0
    assert facts.program.scene.camera is not None
    size = np.array(facts.program.scene.camera.size, float)
    over = np.maximum(-sight.outline, sight.outline - size).max(axis=(1, 2))
    return float((np.maximum(over, 0) / np.maximum(sight.length, 1e-9)).max(initial=0.0))


def _met(program: PhysicalProgram) -> set[str]:
    """What another thing shall meet, and not touch at first alone: how hard is seen on it."""
    told = (s for s in program.contract.statements if isinstance(s, Contacts) and not s.negated)
    return {one.other for one in told if one.to_step is None}


def _first(facts: Facts) -> int:
    """The first frame on which something is seen to move."""
    pacing = pacing_of(facts)
    return 0 if pacing is None or pacing.first is None else pacing.first


def _way(facts: Facts, name: str) -> float:
    """How far it gets from where it began, in the picture and beyond it, m."""
    rows = np.minimum(facts.rollout.frame_steps(), facts.last)
    path = facts.rollout.positions[rows, facts.rollout.objects.index(name)]
    return float(np.linalg.norm(path - path[0], axis=1).max(initial=0.0))


def _told(
    situation: Situation, why: str, search: Search, *edits: tuple[Edit, ...], confidence: float
) -> Proposal:
    return proposal(
        situation.program, why, *edits, factor="easing", confidence=confidence,
        simulations=search.runs,
    )  # fmt: skip
