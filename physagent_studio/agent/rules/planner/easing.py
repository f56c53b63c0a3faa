"""The gentlest program that realises the event: after a pass, efforts and speeds are lowered.

What things do and how far they go stays as it was; only how hard they are driven changes.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from physagent_studio.agent.roles import Situation
from physagent_studio.agent.rules.planner.costs import cost_of
from physagent_studio.agent.rules.planner.directing import replanned
from physagent_studio.agent.rules.planner.factors import may_change
from physagent_studio.agent.rules.planner.trials import TRIAL, Candidate, Search
from physagent_studio.agent.rules.planner.wording import proposal
from physagent_studio.contract.view import acting_objects
from physagent_studio.program.edits import Edit
from physagent_studio.records import Check, Proposal, Rollout


@dataclass(frozen=True, slots=True)
class EasingSettings:
    """How far a program is made gentler."""

    max_runs: int = 10  # count, 3..50: of one easing, where a run costs one unit
    settled_ratio: float = 0.9  # 0.7..0.99: of two efforts, from which it is not settled further
    min_ratio: float = 0.5  # 0.2..0.9: of the efforts, below which none goes at once
    min_way_share: float = 0.85  # 0.5..1: of its way that each acting thing still goes


EASING = EasingSettings()


class Easing:
    """Lowers efforts and speeds of a program that holds, while all margins stay."""

    def ease(self, situation: Situation) -> Proposal:
        """A gentler program; without hunks where there is none."""
        search = Search(situation, max(int(EASING.max_runs / cost_of(situation.program)), 1))
        low, high, best = EASING.min_ratio, 1.0, None
        # By halving: the lowest ratio of the speeds with which everything still holds.
        while high / low > 1 / EASING.settled_ratio and not search.exhausted:
            ratio = (low * high) ** 0.5
            edits = replanned(situation.program, ratio, 1.0, 1.0)
            if not edits or not may_change(situation, edits):
                break
            found = search.run(edits)
            if found is not None and _is_as_good(situation, found):
                best, high = found, ratio
            else:
                low = ratio
        if best is None:
            why = f"nothing gentler holds everything ({search.runs} tried)"
            return _told(situation, why, search, confidence=1.0)
        why = f"It happens as well with {100 * high:.0f} % of the speeds: the gentlest of "
        why += f"{search.runs} tried that holds everything."
        return _told(situation, why, search, best.edits, confidence=0.9)


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
    return not weaker and not shorter and _goes_as_far(situation, situation.rollout, found.rollout)


def _filled(checks: tuple[Check, ...]) -> float:
    """Part of the clip in which something moves."""
    return next((c.measured or 0.0 for c in checks if c.id == "view.fills"), 1.0)


def _goes_as_far(situation: Situation, before: Rollout, now: Rollout) -> bool:
    names = acting_objects(situation.program)
    return all(
        _way(now, name) >= EASING.min_way_share * _way(before, name)
        for name in before.objects
        if name in names
    )


def _way(rollout: Rollout, name: str) -> float:
    path = rollout.positions[:, rollout.objects.index(name)]
    return float(np.linalg.norm(path - path[0], axis=1).max())


def _told(
    situation: Situation, why: str, search: Search, *edits: tuple[Edit, ...], confidence: float
) -> Proposal:
    return proposal(
        situation.program, why, *edits, factor="easing", confidence=confidence,
        simulations=search.runs,
    )  # fmt: skip
