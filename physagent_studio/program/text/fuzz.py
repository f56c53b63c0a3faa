"""Malformed programs by mutation of a valid one, for tests and for `physagent bench physics`."""

import random
import time
from dataclasses import dataclass

from physagent_studio.errors import ProgramError
from physagent_studio.program.text.document import load_program

SEED_TEXT = """\
version: 1
clip: {frames: 21, step_seconds: 0.01, steps_per_frame: 4, substeps: 10, playback_fps: 25.0}
scene:
  gravity: [0.0, 0.0, -9.81]
  objects:
  - name: ball   # a comment
    grounding: {points: [{x: 10.0, y: 20.0, label: 1}]}
    shape: {kind: sphere, radius: 0.11}
    position: [-1.0, 0.0, 0.11]
    support: floor
    material: leather
  - name: crate
    shape:
      kind: box
      size: [0.3, 0.3, 0.3]
    position: [0.5, 0.0, 0.15]
    rotation: [0.9238795325112867, 0.0, 0.0, 0.3826834323650898]
    density: 120.0
    body: {kind: breakable, cuts: [2, 1, 2], release_impulse: 3.5}
  supports:
  - name: floor
    shape: {kind: floor, height: 0.0}
  - {name: ramp, shape: {kind: ramp, toe: [1, 0, 0], yaw: 0, run: 1.0, rise: 0.3, width: 1}}
  landmarks:
  - {name: line, kind: line, points: [[0.2, -1, 0], [0.2, 1, 0]]}
event:
  prompt: 'the ball rolls into the crate: it breaks'
  actions:
  - id: kick
    name: ball
    operator: SetVelocity
    velocity: {magnitude: 3, toward: crate}
  - id: push
    name: crate
    operator: ApplyForce
    when: {kind: on_contact, a: ball, b: crate, delay: 2}
    duration: 10
    force: [5, 0, 0]
  - {id: hold, name: ball, operator: FixObject, start_step: 60, duration: 20}
contract:
  clauses:
  - {id: c1, text: the ball rolls into the crate}
  statements:
  - {id: s1, kind: contacts, clause: c1, subject: ball, other: crate}
  - {id: s2, kind: breaks, subject: crate}
  - {id: s3, kind: before, first: s1, second: s2}
"""
"""A valid program that uses most forms of the language."""

_TOKENS = (
    *("", "null", "~", "true", "no", ".inf", "-.inf", ".nan", "1e999", "1e3", "-1", "0", "007"),
    *("0x1F", "1_000", "12:30:45", "2001-01-01", "'", '"', "[", "]", "{", "}", ":", "- ", "? "),
    *("&a ", "*a", "!!python/object:os.system ", "!x ", "|", ">", "#", "%", "@", "`", "\t", "\n"),
    *("\x00", "\x07", "\ufeff", "\u2028", "é", "𝔘", "---\n", "...\n", "<<: ", ", ", "9" * 400),
    *("[" * 60, "{a: " * 60, "a" * 5000, "1.7976931348623157e308", "-0.0", "NaN", "Infinity"),
)


@dataclass(frozen=True, slots=True)
class FuzzReport:
    """What a fuzz run found. seconds: the slowest single program.

    failures: (seed, reason) of every text that broke a promise: another exception than
    `ProgramError`, an error without problems, or a problem without a line.
    """

    count: int
    accepted: int
    refused: int
    seconds: float
    slowest: int
    failures: tuple[tuple[int, str], ...]


def fuzz_programs(count: int, seed: int, limit: float = 1.0) -> FuzzReport:
    """Reads `count` mutated programs; text number i is `mutated(seed + i)`.

    Everything must either be a program or a `ProgramError` whose every problem names its line,
    and none may take longer than `limit` seconds of processor time.
    """
    accepted = refused = slowest = 0
    worst = 0.0
    failures: list[tuple[int, str]] = []
    for number in range(seed, seed + count):
        text = mutated(number)
        began = time.process_time()
        reason = _broken_promise(text)
        took = time.process_time() - began
        if took > worst:
            worst, slowest = took, number
        if took > limit:
            reason = f"took {took:.2f} s"
        accepted += reason is None
        refused += reason == ""
        if reason:
            failures.append((number, reason))
    return FuzzReport(count, accepted, refused, worst, slowest, tuple(failures))


def _broken_promise(text: str) -> str | None:
    """None for a program, "" for an honest refusal, else what went wrong."""
    try:
        load_program(text)
    except ProgramError as error:
        if not error.problems:
            return "an error without a problem"
        if any(problem.line is None for problem in error.problems):
            return f"a problem without a line: {error}"
        return ""
    except (RecursionError, MemoryError, ValueError, TypeError, KeyError, IndexError) as error:
        return f"{type(error).__name__}: {error}"
    except (AttributeError, AssertionError, ArithmeticError, LookupError) as error:
        return f"{type(error).__name__}: {error}"
    return None


def mutated(seed: int) -> str:
    """The seed text with one to six changes, the same for the same seed."""
    dice = random.Random(seed)
    text = SEED_TEXT
    for _ in range(dice.randint(1, 6)):
        text = dice.choice(_MUTATIONS)(text, dice)
    return text[:300_000]


def _span(text: str, dice: random.Random) -> tuple[int, int]:
    start = dice.randrange(len(text) + 1)
    return start, min(len(text), start + dice.choice((0, 1, 1, 2, 5, 20)))


def _insert(text: str, dice: random.Random) -> str:
    at = dice.randrange(len(text) + 1)
    return text[:at] + dice.choice(_TOKENS) + text[at:]


def _replace(text: str, dice: random.Random) -> str:
    start, end = _span(text, dice)
    return text[:start] + dice.choice(_TOKENS) + text[end:]


def _delete(text: str, dice: random.Random) -> str:
    start, end = _span(text, dice)
    return text[:start] + text[end:]


def _lines(text: str, dice: random.Random) -> str:
    """Repeats, drops, swaps or shifts lines."""
    lines = text.split("\n")
    one, two = dice.randrange(len(lines)), dice.randrange(len(lines))
    match dice.randrange(5):
        case 0:
            lines.insert(two, lines[one])
        case 1:
            del lines[one]
        case 2:
            lines[one], lines[two] = lines[two], lines[one]
        case 3:
            lines[one] = " " * dice.randrange(5) + lines[one]
        case 4:
            lines[one] = lines[one].lstrip()
    return "\n".join(lines)


def _value(text: str, dice: random.Random) -> str:
    """Puts something else where a value stands."""
    places = [index for index, character in enumerate(text) if text[index : index + 2] == ": "]
    if not places:
        return _insert(text, dice)
    start = dice.choice(places) + 2
    end = start
    while end < len(text) and text[end] not in ",}\n":
        end += 1
    return text[:start] + dice.choice(_TOKENS) + text[end:]


def _word(text: str, dice: random.Random) -> str:
    """Swaps one word of the text for another."""
    words = text.split(" ")
    one, two = dice.randrange(len(words)), dice.randrange(len(words))
    words[one] = words[two]
    return " ".join(words)


_MUTATIONS = (_insert, _replace, _delete, _lines, _value, _value, _word)
