"""From a mismatch to the knobs that may repair it, and from a person's words to their sign."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass

from physagent_studio.agent.roles import Situation
from physagent_studio.agent.rules.planner.asked import FACTORS
from physagent_studio.agent.rules.planner.directing import is_sudden, pace_is_pinned
from physagent_studio.agent.rules.planner.parameters import (
    Knob,
    action_knobs,
    material_knobs,
    time_knobs,
)
from physagent_studio.language.wishes import wishes
from physagent_studio.program.base import overlap
from physagent_studio.program.edits import AddItem, Edit
from physagent_studio.records import Mismatch

ORDER: dict[str, tuple[str, ...]] = {
    "misses": ("direction", "magnitude", "elevation", "timing"),
    "falls_short": ("magnitude", "friction", "rolling", "duration", "direction", "elevation"),
    "overshoots": ("magnitude", "friction", "rolling", "duration", "direction"),
    "does_not_move": ("magnitude", "duration", "friction", "direction"),
    "no_contact": ("direction", "magnitude", "elevation", "friction", "timing"),
    "unwanted_contact": ("direction", "magnitude", "elevation", "timing", "friction"),
    "not_toppled": ("magnitude", "direction", "density", "elevation", "friction", "duration"),
    "toppled": ("direction", "magnitude", "friction", "timing", "density"),
    "moved": ("magnitude", "timing", "friction", "rolling", "direction", "density"),
    "not_fallen": ("magnitude", "duration", "friction", "direction"),
    "fell": ("magnitude", "friction"),
    "not_resting": ("magnitude", "rolling", "friction", "restitution", "duration"),
    "not_left": ("magnitude", "friction", "duration", "direction"),
    "not_stopped": ("magnitude", "rolling", "friction", "duration", "restitution"),
    "not_airborne": ("elevation", "magnitude", "timing"),
    "too_few_bounces": ("restitution", "magnitude", "elevation", "direction"),
    "too_many_bounces": ("restitution", "magnitude", "elevation"),
    "airborne": ("elevation", "magnitude", "restitution"),
    "too_little_turn": ("magnitude", "duration", "elevation", "friction"),
    "too_much_turn": ("magnitude", "duration", "friction"),
    "wrong_speed": ("magnitude", "duration", "friction"),
    "path_too_straight": ("magnitude", "duration", "direction"),
    "path_too_bent": ("magnitude", "direction"),
    "not_reversed": ("restitution", "magnitude", "direction", "density", "duration"),
    "too_fast": ("magnitude", "friction", "rolling", "duration"),
    "not_deformed": ("material", "density", "magnitude"),
    "not_broken": ("material", "density", "magnitude"),
    "not_spread": ("material", "magnitude", "density"),
    "not_swaying": ("magnitude", "material", "duration"),
    "wrong_order": ("timing", "magnitude", "direction"),
    "not_visible": ("magnitude", "timing", "duration"),
    "blow_up": ("magnitude", "material", "density"),
    "wrong_start": ("timing",),
    "framing": ("magnitude", "rolling", "friction", "duration", "direction", "elevation", "pace"),
    "pace": ("magnitude", "pace", "duration", "rolling", "friction", "timing"),
    "heading": ("direction",),
    "stirs": ("timing", "density", "friction"),
    "penetration": ("magnitude", "density", "material"),
}
"""Factors by code of a mismatch, the most natural first."""
EVERY = ("magnitude", "direction", "friction", "elevation", "duration", "timing", "density")


@dataclass(frozen=True)
class Bias:
    """What a person's words ask for: the sign of change per factor."""

    wanted: tuple[tuple[str, float], ...] = ()

    def signs(self, knob: Knob) -> Sequence[float]:
        """Directions that may be tried on a knob, the likelier first."""
        for factor, sign in self.wanted:
            if factor == knob.factor:
                return (sign,)
        return (1.0, -1.0)

    def rank(self, knob: Knob) -> int:
        """Factors that were named come first."""
        return 0 if any(factor == knob.factor for factor, _ in self.wanted) else 1


def bias_of(situation: Situation) -> Bias:
    """The bias of hints and of the reasons with which proposals were rejected, newest first."""
    memory = situation.memory
    texts = [*(reason for _, reason in memory.rejected), *memory.hints]
    wanted: dict[str, float] = {}
    for text in reversed(texts):
        for wish in wishes(text):
            factor = FACTORS.get(wish.quantity, "direction" if wish.kind == "side" else "")
            if factor and wish.sign:
                wanted.setdefault(factor, float(wish.sign))
    return Bias(tuple(wanted.items()))


def relevant_knobs(situation: Situation, verified: bool) -> list[Knob]:
    """Knobs for the failed checks, most natural first; verified ones only where asked for."""
    program = situation.program
    knobs = [*action_knobs(program), *material_knobs(program)]
    if situation.rollout is not None and is_sudden(program, situation.rollout):
        knobs += [] if pace_is_pinned(situation) else time_knobs(program)
    knobs = [k for k in knobs if _is_verified(situation, k.path) == verified]
    knobs = [k for k in knobs if not _is_pinned(situation, k.path)]
    turned_down = _rejected_factors(situation)
    bias = bias_of(situation)
    ranked = sorted(
        enumerate(knobs),
        key=lambda row: (
            bias.rank(row[1]),
            (row[1].factor, row[1].target) in turned_down,
            _urgency(row[1], situation) - _credit(row[1], situation),
            row[0],
        ),
    )
    near = [knob for _, knob in ranked if _urgency(knob, situation) < 1000]
    left = [k for k in near if (k.factor, k.target) not in turned_down or bias.rank(k) == 0]
    return left or near


def _urgency(knob: Knob, situation: Situation) -> float:
    """Small for the knob of the factor that the worst mismatches speak of, on their objects."""
    best = 1000.0
    for place, mismatch in enumerate(situation.assessment.diagnosis[:6]):
        order = ORDER.get(mismatch.code, EVERY)
        if knob.factor not in order:
            continue
        near = _nearness(knob, mismatch, situation)
        best = min(best, order.index(knob.factor) + 1.5 * place + 3.0 * near)
    return best


def _credit(knob: Knob, situation: Situation) -> float:
    """How much better a factor has done in earlier sessions against the worst mismatch, −2 … 2."""
    worst = next((m.code for m in situation.assessment.diagnosis), "")
    told = [
        1.0 if lesson.helped else -1.0
        for lesson in situation.memory.lessons
        if lesson.mismatch == worst and lesson.factor == knob.factor
    ]
    return 2.0 * sum(told) / (len(told) + 2) if told else 0.0


def _nearness(knob: Knob, mismatch: Mismatch, situation: Situation) -> float:
    """0 for the object of the mismatch, 1 for what touches it or acts in the prompt, 2 else."""
    if knob.target in (mismatch.subject, mismatch.other, ""):
        return 0.0
    driven = {action.name for action in situation.program.event.actions}
    if mismatch.subject not in driven and knob.target in driven:
        return 0.0
    return 1.0 if knob.target in driven else 2.0


def _rejected_factors(situation: Situation) -> set[tuple[str, str]]:
    """(factor, object) pairs of proposals that a person has turned down."""
    found: set[tuple[str, str]] = set()
    for proposal, _ in situation.memory.rejected:
        for edit in proposal.edits:
            parts = getattr(edit, "path", "").split(".")
            if len(parts) > 2:
                action = situation.program.action(parts[2])
                found.add((proposal.factor, action.name if action else parts[2]))
    return found


def may_change(situation: Situation, edits: Iterable[Edit]) -> bool:
    """Whether no edit touches what a person has pinned."""
    return not any(_is_pinned(situation, _path(edit)) for edit in edits)


def _path(edit: Edit) -> str:
    if isinstance(edit, AddItem):
        item = edit.item if isinstance(edit.item, dict) else {}
        return f"{edit.path}.{item.get('id', '')}"
    return edit.path


def _is_pinned(situation: Situation, path: str) -> bool:
    return any(overlap(path, pinned) for pinned in situation.memory.pinned)


def _is_verified(situation: Situation, path: str) -> bool:
    return any(path == v or path.startswith(f"{v}.") for v in situation.memory.verified)
