"""What went wrong, in words and figures: from failed checks to mismatches, never a remedy."""

from dataclasses import dataclass

import numpy as np

from physagent_studio.agent.rules.scene.measures import Layout, level, unit
from physagent_studio.contract import Facts
from physagent_studio.contract.view import subject_of, view_code
from physagent_studio.contract.words import number
from physagent_studio.program.contract import (
    AllOf,
    AnyOf,
    Before,
    CountOf,
    InTurn,
    Statement,
    Together,
)
from physagent_studio.program.program import PhysicalProgram
from physagent_studio.program.statements import Covers, Topples
from physagent_studio.records import Check, Finding, Mismatch, Rollout

CODES: dict[str, tuple[str, str]] = {
    "moves": ("falls_short", "moved"),
    "falls": ("not_fallen", "fell"),
    "contacts": ("no_contact", "unwanted_contact"),
    "topples": ("not_toppled", "toppled"),
    "upright": ("toppled", "not_toppled"),
    "stays": ("moved", "falls_short"),
    "rests_on": ("not_resting", "unwanted_contact"),
    "reaches": ("no_contact", "unwanted_contact"),
    "leaves": ("not_left", "left"),
    "lands_in": ("misses", "overshoots"),
    "passes_over": ("falls_short", "overshoots"),
    "stops": ("not_stopped", "stopped"),
    "stops_before": ("overshoots", "falls_short"),
    "airborne": ("not_airborne", "airborne"),
    "rotates": ("too_little_turn", "too_much_turn"),
    "flips": ("too_little_turn", "too_much_turn"),
    "speed_between": ("wrong_speed", "wrong_speed"),
    "path_bends": ("path_too_straight", "path_too_bent"),
    "reverses": ("not_reversed", "reversed"),
    "descends_slowly": ("too_fast", "too_slow"),
    "deforms": ("not_deformed", "deformed"),
    "spreads": ("not_spread", "spread"),
    "breaks": ("not_broken", "broken"),
    "sways": ("not_swaying", "swaying"),
    "bounces": ("too_few_bounces", "too_many_bounces"),
    "covers": ("falls_short", "overshoots"),
    "side_of": ("misses", "overshoots"),
    "before": ("wrong_order", "wrong_order"),
    "in_turn": ("wrong_order", "wrong_order"),
    "together": ("wrong_order", "wrong_order"),
    "blow_up": ("blow_up", "blow_up"),
    "penetration": ("penetration", "penetration"),
    "energy": ("energy", "energy"),
    "cause": ("no_cause", "no_cause"),
    "sink": ("sinks", "sinks"),
}
"""Code where the plain statement fails, and where its negation does."""


def mismatches(
    program: PhysicalProgram, rollout: Rollout, checks: tuple[Check, ...]
) -> tuple[Mismatch, ...]:
    """One per failed demanded check, causes before consequences."""
    statements = {s.id: s for s in program.contract.statements}
    by_id = {c.id: c for c in checks}
    failing = [c for c in checks if c.demanded and not c.ok]
    found: dict[str, tuple[tuple[float, ...], Mismatch]] = {}
    for check in failing:
        statement = _concrete(statements.get(check.id), statements, by_id)
        one = _mismatch(check, statement, program, rollout)
        kind = statement.kind if statement is not None else check.kind
        rank = (
            float(check.kind in ("before", "in_turn", "together")),
            _RANK.get(kind, 3.0),
            check.margin,
        )
        # The same miss may fail several statements: it is told once.
        if one.text not in found or rank < found[one.text][0]:
            found[one.text] = (rank, one)
    return tuple(one for _, one in sorted(found.values(), key=lambda row: row[0]))


_RANK: dict[str, float] = {
    "blow_up": 0.0, "moves": 1.0, "contacts": 1.0, "passes_over": 1.0, "lands_in": 1.0,
    "reaches": 1.5, "leaves": 2.0, "falls": 2.0, "airborne": 2.0, "view": 9.0,
}  # fmt: skip
"""What fails first comes first: a pin that is not hit cannot fall over."""


def _concrete(
    statement: Statement | None, statements: dict[str, Statement], checks: dict[str, Check]
) -> Statement | None:
    """The statement that decides a composite: its best part, or the part that fails."""
    for _ in range(8):
        if isinstance(statement, AnyOf):
            parts = [checks[i] for i in statement.of if i in checks]
            best = max(parts, key=lambda c: c.margin, default=None)
        elif isinstance(statement, AllOf):
            parts = [checks[i] for i in statement.of if i in checks]
            best = min(parts, key=lambda c: c.margin, default=None)
        elif isinstance(statement, CountOf):
            # The part that is nearest to changing its answer decides a count.
            parts = [checks[i] for i in statement.of if i in checks]
            best = min(parts, key=lambda c: abs(c.margin), default=None)
        elif isinstance(statement, Before | InTurn | Together):
            parts = [checks[i] for i in _ordered(statement) if i in checks]
            failing = [c for c in parts if not c.ok]
            best = min(failing, key=lambda c: c.margin, default=None)
        else:
            return statement
        if best is None:
            return statement
        statement = statements.get(best.id)
    return statement


def _ordered(statement: Before | InTurn | Together) -> tuple[str, ...]:
    """What stands in an order in time."""
    if isinstance(statement, Before):
        return (statement.first, statement.second)
    return statement.of


def _mismatch(
    check: Check, statement: Statement | None, program: PhysicalProgram, rollout: Rollout
) -> Mismatch:
    kind = statement.kind if statement is not None else check.kind
    negated = bool(statement is not None and statement.negated)
    code = CODES.get(kind, ("fails", "fails"))[negated]
    if check.kind == "view":
        return _told(check, view_code(check), check.text, subject_of(check, rollout))
    subject, other = str(getattr(statement, "subject", "") or ""), _other(statement)
    beginning_steps = 40  # 10..80: statements over no more speak of how the clip begins
    if kind == "contacts" and (getattr(statement, "to_step", None) or 1000) <= beginning_steps:
        # How things stood in the photo: no force can put that right.
        return _told(check, "wrong_start", check.text, subject, other)
    if isinstance(statement, Covers) and not negated and (check.measured or 0.0) > statement.high:
        code = "overshoots"
    if isinstance(statement, Topples) and not negated and (check.measured or 0.0) > statement.tilt:
        # It did fall over, and too far or onto another side.
        code = "too_much_turn"
    text, figures = check.text, dict[str, float]()
    if kind == "contacts" and negated and check.step is not None:
        text = f"{subject} touches {other} at frame {rollout.frame_of(check.step)}"
    leaves_it = subject and Layout(program.scene).carrier(subject) == other
    if subject in rollout.objects and other and not negated and not leaves_it:
        span = (getattr(statement, "from_step", None), getattr(statement, "to_step", None))
        pass_by = passing(program, rollout, subject, other, span)
        if pass_by is not None and kind in _ARRIVING:
            code, text = pass_by.code, pass_by.text(subject, other, rollout)
            figures = {"left": round(pass_by.left, 4), "ahead": round(pass_by.ahead, 4)}
    return _told(check, code, text, subject, other, **figures)


_ARRIVING = ("contacts", "reaches", "lands_in", "passes_over", "moves")
"""Kinds that fail by how something came by a place."""


def _told(
    check: Check, code: str, text: str, subject: str, other: str = "", **figures: float
) -> Mismatch:
    known = {"margin": check.margin, "measured": check.measured}
    own = {name: round(value, 4) for name, value in known.items() if value is not None}
    return Mismatch(
        code=code, text=text, subject=subject, other=other, check=check.id,
        figures=own | figures, step=check.step,
    )  # fmt: skip


def _other(statement: Statement | None) -> str:
    for field in ("other", "landmark", "near", "before", "toward"):
        name = getattr(statement, field, None)
        if name:
            return str(name)
    return ""


@dataclass(frozen=True, slots=True)
class Passing:
    """How an object came by another: left > 0 is to its left as it moves; ahead > 0 is short.

    left, ahead: m, from middle to middle at `step`, where these are nearest to each other. gap: m
    between the two surfaces where they are nearest, which is at `closest`; None where the other is
    a place, or a shape is open.
    """

    left: float
    ahead: float
    step: int
    still: bool
    gap: float | None = None
    closest: int = 0

    @property
    def code(self) -> str:
        """`misses` where it goes by at the side, `falls_short` where it does not get there."""
        if self.still:
            return "does_not_move"
        return "falls_short" if self.ahead > abs(self.left) else "misses"

    def text(self, subject: str, other: str, rollout: Rollout) -> str:
        """The sentence."""
        if self.still:
            return f"{subject} does not move towards {other}"
        side = "left" if self.left > 0 else "right"
        if self.gap is None or self.gap <= 0:
            frame, middle = rollout.frame_of(self.step), f"the middle of {other} at frame"
            if self.code == "falls_short":
                return f"{subject} stays {self.ahead:.2f} m short of {middle} {frame}"
            return f"{subject} passes {abs(self.left):.2f} m {side} of {middle} {frame}"
        frame, gap = rollout.frame_of(self.closest), number(self.gap, "m")
        if self.code == "falls_short":
            return f"{subject} stays {gap} short of {other} at frame {frame}"
        return f"{subject} passes {gap} {side} of {other} at frame {frame}"


Span = tuple[int | None, int | None]
"""First and last step; None: of the run."""


def passing(
    program: PhysicalProgram,
    rollout: Rollout,
    subject: str,
    other: str,
    span: Span = (None, None),
) -> Passing | None:
    """How the subject comes nearest to another body or place, seen along its motion.

    span: the steps within which the gap of their surfaces is looked for.
    """
    layout = Layout(program.scene)
    if not layout.is_known(other) or rollout.blown_up is not None:
        return None
    path = rollout.positions[:, rollout.objects.index(subject)]
    if other in rollout.objects:
        goal = rollout.positions[:, rollout.objects.index(other)]
    else:
        goal = np.broadcast_to(layout.position(other), path.shape)
    away = np.linalg.norm((path - goal)[:, :2], axis=1)
    nearest = int(away.argmin())
    gap, closest = _nearest(program, rollout, subject, other, span)
    moved = level(path[nearest] - path[0])
    length = float(np.linalg.norm(moved))
    if length < 0.02:
        return Passing(0.0, float(away[0]), nearest, True, gap, closest)
    heading = unit(level(path[nearest] - path[max(0, nearest - 20)]))
    if float(np.linalg.norm(level(path[nearest] - path[max(0, nearest - 20)]))) < 1e-3:
        heading = unit(moved)
    offset = level(goal[nearest] - path[nearest])
    # To the left of the target means that the target lies to its right.
    left = -float(heading[0] * offset[1] - heading[1] * offset[0])
    return Passing(left, float(heading @ offset), nearest, False, gap, closest)


def _nearest(
    program: PhysicalProgram, rollout: Rollout, subject: str, other: str, span: Span
) -> tuple[float | None, int]:
    """The least gap of two surfaces within a span, m, as the contract measures it, and its step.

    0 where they touch.
    """
    if other not in rollout.bodies:
        return None, 0
    facts = Facts.of(program, rollout)
    window = facts.window(*span) or facts.whole()
    gaps = facts.gaps(subject, other, window)
    if gaps is None:
        return None, 0
    closest = int(gaps.argmin())
    apart = not facts.touching(subject, other, window).any()
    return max(float(gaps[closest]), 1e-4 if apart else 0.0), window.first + closest


def stage_one_mismatch(finding: Finding) -> Mismatch:
    """A failed finding of the reconstruction."""
    return Mismatch(
        code=f"{finding.kind}_{finding.name}",
        text=finding.text,
        subject=finding.subject,
        check=f"{finding.kind}.{finding.name}.{finding.subject}",
        figures={"measured": finding.measured, "threshold": finding.threshold},
    )
