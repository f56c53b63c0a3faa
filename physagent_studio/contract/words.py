"""Statements in plain English, for checklists and reports."""

import itertools
from collections.abc import Callable
from typing import Any

from physagent_studio.program.contract import Statement
from physagent_studio.program.program import PhysicalProgram
from physagent_studio.program.statements import SpeedBetween

COMPOSITES = ("all_of", "any_of", "count_of", "before", "in_turn", "together")
"""Kinds that speak of other statements."""

INSTEAD = {"≤": "more than", "≥": "less than", "<": "at least", ">": "at most"}
"""What is said of a figure that misses such a bound."""
SIDES = {
    "left": "to the left",
    "right": "to the right",
    "up": "up",
    "down": "down",
    "away": "away from the camera",
    "toward_camera": "towards the camera",
}


def number(value: float, unit: str = "") -> str:
    """A measured value as one reads it: 2°, 0.31 m, 1.2 m/s."""
    if unit == "m" and 5e-5 <= abs(value) < 1e-3:
        return number(1000 * value, "mm")
    size = abs(value)
    if size < 5e-5:
        text = "0"
    elif size >= 100 or (unit in ("°", "joints", "swings") and size >= 10):
        text = f"{value:.0f}"
    elif size >= 10 or unit in ("°", "joints", "swings"):
        text = f"{value:.1f}"
    else:
        text = f"{value:.2f}" if size >= 0.1 else f"{value:.3f}" if size >= 1e-3 else f"{value:.4f}"
    if "." in text:
        text = text.rstrip("0").rstrip(".")
    return text + (unit if unit in ("", "°", "×") else f" {unit}")


def compared(value: float, op: str, threshold: float, unit: str) -> str:
    """ "2° ≤ 20°", with as many digits as it takes to tell the two apart."""
    left, right = number(value, unit), number(threshold, unit)
    if left == right and value != threshold:
        tail = unit if unit in ("", "°", "×") else f" {unit}"
        digits = next((d for d in range(1, 7) if f"{value:.{d}f}" != f"{threshold:.{d}f}"), 7)
        left = f"{value:.{digits}f}{tail}"
    return f"{left} {op} {right}"


def describe(statement: Statement, program: PhysicalProgram) -> str:
    """The statement as a line of a checklist, its thresholds included."""
    bound = _BOUNDS.get(statement.kind)
    text = claim(statement, program)
    if bound is not None and (extra := bound(statement)):
        text += f" ({extra})"
    return text + window_text(statement, program)


def claim(statement: Statement, program: PhysicalProgram) -> str:
    """The statement without thresholds: "bowling_ball does not touch right_pin"."""
    if statement.kind in COMPOSITES:
        return _composite(statement, program)
    plain, denied = _CLAIMS[statement.kind](statement)
    subject = getattr(statement, "subject", "")
    return f"{subject} {denied if statement.negated else plain}"


def window_text(statement: Statement, program: PhysicalProgram) -> str:
    """Which part of the clip it speaks of, if not all of it."""
    per = program.clip.steps_per_frame
    start, end = statement.from_step, statement.to_step
    if not start and end is not None and end < per:
        return ", to begin with"
    if start and end is not None:
        return f", between frames {start // per} and {end // per}"
    if start:
        return f", from frame {start // per} on"
    return f", until frame {end // per}" if end is not None else ""


def _composite(statement: Any, program: PhysicalProgram) -> str:
    by_id = {one.id: one for one in program.contract.statements}

    def words(name: str, alone: bool = False) -> str:
        other = by_id.get(name)
        if other is None:
            return f"“{name}”"
        if other.kind in COMPOSITES:
            # A composite cannot hold itself: validation sees to it.
            inner = _composite(other, program)
            return inner if alone else f"({inner})"
        return claim(other, program)

    if statement.kind == "before":
        text = f"{words(statement.first)}, before {words(statement.second)}"
        if statement.within is not None:
            text += f" within {number(statement.within, 's')}"
    elif statement.kind == "count_of":
        text = f"{_how_many(statement)} of: {'; '.join(map(words, statement.of))}"
    elif statement.kind == "in_turn":
        joint = ", then " if statement.ordered else " and "
        text = f"{joint.join(map(words, statement.of))}, one after another"
    elif statement.kind == "together":
        within = number(statement.within, "s")
        text = f"{' and '.join(map(words, statement.of))}, all within {within}"
    else:
        alone = len(statement.of) == 1
        joint = " and " if statement.kind == "all_of" else " or "
        text = _joined([words(name, alone) for name in statement.of], joint)
    return f"not so: {text}" if statement.negated else text


def _joined(claims: list[str], joint: str) -> str:
    """Claims side by side, words that all begin or end with said once: "ball touches a or b"."""
    told = [claim.split() for claim in claims]
    if len(claims) < 2 or any(claim.startswith("(") or " not " in claim for claim in claims):
        return joint.join(claims)
    first, last = _shared(told), _shared([words[::-1] for words in told])
    own = [" ".join(words[first : len(words) - last]) for words in told]
    if not all(own) or not first + last:
        return joint.join(claims)
    return " ".join([*told[0][:first], joint.join(own), *told[0][len(told[0]) - last :]])


def _shared(told: list[list[str]]) -> int:
    """How many words all of them begin with."""
    same = (len(set(words)) == 1 for words in zip(*told, strict=False))
    return sum(itertools.takewhile(bool, same))


def _how_many(statement: Any) -> str:
    low, high = statement.low, min(statement.high, len(statement.of))
    if low == high:
        return f"exactly {low}"
    if high == len(statement.of):
        return f"at least {low}"
    return f"at most {high}" if low == 0 else f"{low} to {high}"


def _verb(verb: str, base: str, rest: str = "") -> tuple[str, str]:
    tail = f" {rest}" if rest else ""
    return f"{verb}{tail}", f"does not {base}{tail}"


def _moves(s: Any) -> tuple[str, str]:
    rest = SIDES[s.direction] if s.direction else f"towards {s.toward}" if s.toward else ""
    return _verb("moves", "move", rest)


PLACES = {
    "behind": "behind",
    "in_front": "in front of",
    "left": "to the left of",
    "right": "to the right of",
    "above": "above",
    "under": "under",
    "beside": "beside",
}


def _side(s: Any) -> tuple[str, str]:
    if s.at_end:
        return _verb("is", "end up", f"{PLACES[s.side]} {s.other} at the end")
    return _verb("gets", "get", f"{PLACES[s.side]} {s.other}")


def times(count: float) -> str:
    """ "once", "twice", "3 times"."""
    return {1.0: "once", 2.0: "twice"}.get(count, f"{count:g} times")


def _returns(s: Any) -> tuple[str, str]:
    return _verb("turns", "turn", "back" if s.times == 1 else f"back {times(s.times)}")


def _covers(s: Any) -> tuple[str, str]:
    low, high = number(100 * s.low), number(100 * s.high)
    share = f"at least {low} %" if s.high >= 1.5 else f"{low} to {high} %"
    return _verb("covers", "cover", f"{share} of the way to {s.other}")


def _bends(s: Any) -> tuple[str, str]:
    return _verb("bends its path", "bend its path", "" if s.side == "either" else SIDES[s.side])


_ANY_SPEED = SpeedBetween.model_fields["high"].default


def _speed(s: Any) -> tuple[str, str]:
    if s.high >= _ANY_SPEED:
        return _verb("gets", "get", "fast enough")
    if s.low == 0:
        return "stays slow enough", "gets faster"
    return "has the right top speed", "has another top speed"


def _speeds(s: Any) -> str:
    if s.high >= _ANY_SPEED:
        return f"at least {number(s.low, 'm/s')}"
    top = number(s.high, "m/s") + (" level" if s.level else "")
    return f"at most {top}" if s.low == 0 else f"{number(s.low)} to {top}"


def _tilts(s: Any, bound: str) -> str:
    return f"tilts {bound} {number(s.tilt, '°')}"


def _topples(s: Any) -> tuple[str, str]:
    return _verb("topples", "topple", f"onto the side that faced {SIDES[s.onto]}" if s.onto else "")


def _tilted(s: Any) -> str:
    most = f", at most {number(s.most, '°')}" if s.most is not None else ""
    return _tilts(s, "less than" if s.negated else "at least") + most


def _stays(s: Any) -> str:
    bound, joint = ("more than", " or ") if s.negated else ("at most", ", ")
    return f"moves {bound} {number(s.distance, 'm')}{joint}{_tilts(s, bound)}"


_CLAIMS: dict[str, Callable[[Any], tuple[str, str]]] = {
    "moves": _moves,
    "falls": lambda s: _verb("falls", "fall"),
    "contacts": lambda s: _verb("touches", "touch", s.other),
    "topples": _topples,
    "stays": lambda s: _verb("stays", "stay", "in place"),
    "rests_on": lambda s: _verb("rests", "rest", f"on {s.other} at the end"),
    "reaches": lambda s: _verb("reaches", "reach", s.other),
    "leaves": lambda s: _verb("leaves", "leave", f"{s.other} for good"),
    "lands_in": lambda s: _verb("lands", "land", f"in {s.landmark}"),
    "passes_over": lambda s: _verb("passes", "pass", f"{'by' if s.by else 'over'} {s.landmark}"),
    "stops": lambda s: _verb("stops", "stop", f"near {s.near}" if s.near else ""),
    "stops_before": lambda s: _verb("stops", "stop", f"before {s.before}"),
    "airborne": lambda s: _verb("flies", "fly", "free of any contact"),
    "rotates": lambda s: _verb("turns", "turn"),
    "flips": lambda s: _verb("flips", "flip", SIDES[s.direction] if s.direction else ""),
    "upright": lambda s: _verb("stands", "stand", "upright at the end"),
    "speed_between": _speed,
    "path_bends": _bends,
    "reverses": _returns,
    "descends_slowly": lambda s: _verb("comes", "come", "down slowly"),
    "deforms": lambda s: _verb("changes", "change", "its shape"),
    "spreads": lambda s: _verb("spreads", "spread", "out"),
    "breaks": lambda s: _verb("breaks", "break"),
    "sways": lambda s: _verb("sways", "sway"),
    "bounces": lambda s: _verb("bounces", "bounce", f"off {s.other} {times(s.times)}"),
    "covers": _covers,
    "side_of": _side,
}

_BOUNDS: dict[str, Callable[[Any], str]] = {
    "moves": lambda s: f"by at least {number(s.distance, 'm')}",
    "falls": lambda s: f"by at least {number(s.drop, 'm')}",
    "topples": _tilted,
    "stays": _stays,
    "stops": lambda s: f"within {number(s.distance, 'm')}" if s.near else "",
    "airborne": lambda s: f"for at least {number(s.seconds, 's')}",
    "rotates": lambda s: f"by at least {number(s.angle, '°')}",
    "flips": lambda s: f"by at least {number(s.angle, '°')}",
    "upright": lambda s: _tilts(s, "more than" if s.negated else "at most"),
    "speed_between": _speeds,
    "path_bends": lambda s: f"by at least {number(s.angle, '°')}",
    "reverses": lambda s: f"by at least {number(s.angle, '°')}",
    "descends_slowly": lambda s: (
        f"by at least {number(s.drop, 'm')}, at most {number(s.speed, 'm/s')}"
    ),
    "deforms": lambda s: (
        f"by at least {number(100 * s.strain)} % of its size{' at the end' if s.at_end else ''}"
    ),
    "spreads": lambda s: f"to at least {number(s.factor, '×')} its footprint",
    "sways": lambda s: f"at least {times(s.cycles)} by ±{number(s.amplitude, '°')}",
    "bounces": lambda s: f"by at least {number(s.height, 'm')}",
}

MEASURED: dict[str, str] = {
    "moves": "moves",
    "falls": "falls",
    "topples": "tilts",
    "upright": "tilts",
    "stays": "moves",
    "airborne": "flies",
    "rotates": "turns",
    "flips": "flips",
    "path_bends": "bends its path",
    "reverses": "turns back",
    "descends_slowly": "comes down",
    "speed_between": "has a top speed of",
    "deforms": "changes its shape by",
    "spreads": "grows its footprint",
    "breaks": "breaks",
    "sways": "sways",
}
"""How a figure is introduced: "left_pin tilts 2° ≤ 20°"."""
