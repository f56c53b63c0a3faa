"""Every statement of a contract, and the physics that always has to hold, on one rollout."""

from collections.abc import Callable, Mapping
from dataclasses import replace
from typing import Any

from physagent_studio.contract import change, motion, relations, touch
from physagent_studio.contract.always import always_on
from physagent_studio.contract.composites import composed
from physagent_studio.contract.facts import Facts
from physagent_studio.contract.places import lands_in, passes_over
from physagent_studio.contract.track import Outcome, Window, bounded, opposite, unmeasurable
from physagent_studio.contract.view import Drawn, view_checks
from physagent_studio.contract.words import MEASURED, SIDES, claim, compared, window_text
from physagent_studio.program.contract import Before, Composite, Statement
from physagent_studio.program.program import PhysicalProgram
from physagent_studio.records.judgement import Check
from physagent_studio.records.rollout import Rollout

Measure = Callable[[Any, Facts, Window], Outcome]

MEASURES: dict[str, Measure] = {
    "moves": motion.moves,
    "falls": motion.falls,
    "contacts": touch.contacts,
    "topples": motion.topples,
    "stays": motion.stays,
    "rests_on": touch.rests_on,
    "reaches": touch.reaches,
    "leaves": touch.leaves,
    "lands_in": lands_in,
    "passes_over": passes_over,
    "stops": touch.stops,
    "stops_before": touch.stops_before,
    "airborne": motion.airborne,
    "rotates": motion.rotates,
    "flips": motion.flips,
    "upright": motion.upright,
    "speed_between": motion.speed_between,
    "path_bends": motion.path_bends,
    "reverses": motion.reverses,
    "descends_slowly": motion.descends_slowly,
    "deforms": change.deforms,
    "spreads": change.spreads,
    "breaks": change.breaks,
    "sways": change.sways,
    "bounces": relations.bounces,
    "covers": relations.covers,
    "side_of": relations.side_of,
}
OPPOSITE = {"≥": "<", "≤": ">"}


def measure(
    program: PhysicalProgram, rollout: Rollout, drawn: Mapping[str, Drawn] | None = None
) -> tuple[Check, ...]:
    """The contract's statements in order, then what always has to hold: the physics, the view.

    Shapes come from `program.scene`, which must be the completed one. Nothing is raised for a
    rollout that blew up: what it cannot show is failed and says so.
    """
    facts = Facts.of(program, rollout)
    serving = program.contract.serving
    known: dict[str, Outcome] = {}
    checks = tuple(
        _check(statement, _measured(statement, facts, known, ()), facts, statement.id in serving)
        for statement in program.contract.statements
    )
    return (*checks, *always_on(facts), *view_checks(facts, checks, drawn))


def met(statement: Statement, program: PhysicalProgram, rollout: Rollout) -> bool:
    """Whether a statement holds of a run so far; "at the end" means its last step.

    For `when` conditions: `rollout` covers the steps that have been run. Composites look up
    their parts in the program's contract.
    """
    facts = Facts.of(program, rollout)
    window = facts.window(statement.from_step, statement.to_step)
    return window is not None and _measured(statement, facts, {}, ()).holds


def _measured(
    statement: Statement, facts: Facts, known: dict[str, Outcome], above: tuple[str, ...]
) -> Outcome:
    """The statement with its negation applied; `above` are the composites that asked for it."""
    if statement.id not in known:
        known[statement.id] = _negated(statement, _plain(statement, facts, known, above), facts)
    return known[statement.id]


def _plain(
    statement: Statement, facts: Facts, known: dict[str, Outcome], above: tuple[str, ...]
) -> Outcome:
    if isinstance(statement, Composite):
        return _composite(statement, facts, known, above)
    window = facts.window(statement.from_step, statement.to_step)
    if window is None:
        reason = "the run ended before its window began"
        return unmeasurable(reason if not facts.complete else "its window lies outside the clip")
    if not facts.is_object(statement.subject):
        return unmeasurable(f"{statement.subject} was not simulated")
    return _honest(MEASURES[statement.kind](statement, facts, window), facts, window)


def _honest(outcome: Outcome, facts: Facts, window: Window) -> Outcome:
    """A run that ended early cannot show what speaks of the end, nor that something never was."""
    decided = outcome.holds and not outcome.lasting
    if facts.complete or decided or (facts.last > window.last):
        return outcome
    margin = min(outcome.margin, -1.0)
    return replace(
        outcome, margin=margin, note=f"the run ended at step {facts.last}", measurable=False
    )


def _negated(statement: Statement, outcome: Outcome, facts: Facts) -> Outcome:
    if not statement.negated or not outcome.measurable:
        return outcome
    flipped = replace(outcome, margin=opposite(outcome.margin), op=OPPOSITE.get(outcome.op, ""))
    if flipped.holds:
        # That something did not happen is known only when the window is over.
        window = facts.window(statement.from_step, statement.to_step)
        flipped = replace(flipped, step=window.last if window else facts.last)
    return flipped


def _composite(
    statement: Composite,
    facts: Facts,
    known: dict[str, Outcome],
    above: tuple[str, ...],
) -> Outcome:
    by_id = {one.id: one for one in facts.program.contract.statements}
    names = (statement.first, statement.second) if isinstance(statement, Before) else statement.of
    if statement.id in above or any(name not in by_id for name in names):
        return unmeasurable("it refers to itself or to an unknown statement")
    parts = [_measured(by_id[name], facts, known, (*above, statement.id)) for name in names]
    return composed(statement, parts, facts)


def _check(statement: Statement, outcome: Outcome, facts: Facts, serves: bool) -> Check:
    return Check(
        id=statement.id,
        text=_text(statement, outcome, facts),
        ok=outcome.holds,
        measured=None if outcome.value is None else float(outcome.value),
        threshold=None if outcome.threshold is None else float(outcome.threshold),
        unit=outcome.unit,
        margin=bounded(outcome.margin),
        step=outcome.step,
        clause=statement.clause,
        kind=statement.kind,
        demanded=not serves,
    )


def _text(statement: Statement, outcome: Outcome, facts: Facts) -> str:
    """ "left_pin tilts 2° ≤ 20°: yes", "ball touches pin: no, comes within 0.31 m at frame 38"."""
    if outcome.op and outcome.value is not None and outcome.threshold is not None:
        head = outcome.claim or f"{getattr(statement, 'subject', '')} {_introduced(statement)}"
        text = f"{head} {compared(outcome.value, outcome.op, outcome.threshold, outcome.unit)}"
    else:
        text = claim(statement, facts.program)
    text += window_text(statement, facts.program)
    parts = [f"{text}: {'yes' if outcome.holds else 'no'}"]
    if outcome.note:
        parts.append(outcome.note)
    if outcome.holds and outcome.step and not outcome.lasting and not statement.negated:
        parts.append(f"frame {facts.rollout.frame_of(outcome.step)}")
    return ", ".join(parts)


def _introduced(statement: Statement) -> str:
    side = getattr(statement, "direction", None) or getattr(statement, "side", None)
    words = MEASURED.get(statement.kind, "measures")
    if side in SIDES:
        return f"{words} {SIDES[side]}"
    toward = getattr(statement, "toward", None)
    return f"{words} towards {toward}" if toward else words
