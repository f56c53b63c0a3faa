"""Numbers and edits in words that a newcomer reads."""

from __future__ import annotations

import json
import re
from collections.abc import Callable, Iterable
from typing import Any

from physagent_studio.contract import INSTEAD
from physagent_studio.errors import EditError
from physagent_studio.program import AddItem, Edit, PhysicalProgram, RemoveItem, SetField, value_at
from physagent_studio.records import Check, Criterion

UNITS = {
    "velocity": "m/s",
    "angular_velocity": "rad/s",
    "force": "N",
    "torque": "N·m",
    "amplitude": "N",
    "angle": "°",
    "elevation": "°",
    "azimuth": "°",
    "heading": "°",
    "frequency": "Hz",
    "position": "m",
    "point": "m",
    "size": "m",
    "radius": "m",
    "height": "m",
    "density": "kg/m³",
    "start_step": "steps",
    "duration": "steps",
    "delay": "steps",
    "timeout": "steps",
    "from_step": "steps",
    "to_step": "steps",
    "gravity": "m/s²",
    "run": "m",
    "rise": "m",
    "width": "m",
    "yaw": "rad",
    "radii": "m",
    "tube": "m",
    "bottom_radius": "m",
    "top_radius": "m",
    "wall": "m",
    "toe": "m",
    "plateau": "m",
    "focal": "px",
    "principal": "px",
    "horizon_sigma": "px",
    "distance": "m",
    "drop": "m",
    "tilt": "°",
    "speed": "m/s",
    "low": "m/s",
    "high": "m/s",
    "seconds": "s",
}

DIRECTED_UNITS = {"acceleration": "m/s²", "target_speed": "m/s"}
"""Units of a vector by meaning whose magnitude is not the quantity itself."""

OPERATORS = {
    "SetVelocity": "Set velocity",
    "SetAngularVelocity": "Set spin",
    "ApplyForce": "Push",
    "ApplyTorque": "Twist",
    "ApplyAngledForce": "Steer",
    "ApplyDisturbance": "Disturb",
    "SetPosition": "Place",
    "SetOrientation": "Turn",
    "FixObject": "Hold",
}

SLOWING = "Slow down"
"""A push against the way a thing goes, or to a standstill."""

OF_MATERIAL = frozenset({"friction", "rolling", "restitution", "density"})
"""Fields that the material answers for where they are empty."""
MASK = ".grounding.candidate"
SETTLED = ".grounding.settled"
OPENED = frozenset({"shape", "position", "support", "camera", "horizon", "form"})
"""Fields of the scene that are read off the photo again where they are emptied."""

CRITERIA = {
    "object trajectory": "Do the right things go the right way?",
    "contact timing": "Do the right things touch, in the right order?",
    "force direction": "Does what moves have a cause, and the right direction?",
    "material response": "Do things turn, tip and bend as they should?",
}
"""What an event is judged by, as a question of a person."""
SEEN_WELL = "Can a viewer see it well?"
"""The same where nothing is wrong but what a viewer sees."""
UNSEEN = {
    "fills": "too short to see", "pace": "too fast to follow", "something": "too small to see",
    "inside": "partly out of the picture", "gone": "still in the picture at the end",
    "meeting": "too soon to see what meets", "act": "one does not see that it is hit",
    "in_time": "not over when the clip ends", "ends": "not as it should be in the end",
    "calm": "something stirs too early", "wheels": "it drives sideways",
    "amount": "faster than it is told", "place": "away from its place",
    "tossed": "tossed into the air", "apart": "not seen to come apart",
    "breaks": "out of the picture as it breaks",
    "alone": "something else moves as well", "footing": "not standing as it should",
    "lean": "not standing as it should", "touches": "not touching what it stands on",
    "begins": "not drawn as in the photo",
}  # fmt: skip
"""What a viewer cannot see, by the rule of a view check: the second word of its id."""

FACTORS = {"reconstruction": "The scene", "simulation": "The event"}


def number(value: float | None) -> str:
    """Three significant figures, without an exponent where it can be avoided."""
    if value is None:
        return "–"
    if value != 0 and not 1e-4 <= abs(value) < 1e6:
        return f"{value:.2e}"
    text = f"{value:.3g}" if abs(value) < 1000 else f"{value:.0f}"
    return text.replace("-", "−")


NOTHING = 1e-6
"""What is measured as less, in any unit, is nothing to a person."""

COUNTED = frozenset({"swings", "joints"})
"""Units that are counted: one of them is said without its s."""

BOUND = re.compile(r" (≤|≥|<|>) ")
AS_WORDS = {"≤": "at most", "≥": "at least", "<": "less than", ">": "more than"}


def figure(check: Check, stated: str = "") -> str:
    """What was measured, as one says it; "" where there is only a yes or no.

    stated: the statement in words; a bound that it names already is not repeated.
    """
    if check.measured is None or (check.measured == 0 and not check.threshold):
        return ""
    value = _with_unit(abs(check.measured), check.unit)
    if not check.threshold:
        return _against_nothing(check, value)
    sign = "−" if check.measured < 0 else ""
    bound = BOUND.search(check.text)
    if check.ok or bound is None or "(" in stated:
        return f"{sign}{value}"
    return f"{sign}{value} ({AS_WORDS[bound[1]]} {_with_unit(check.threshold, check.unit)})"


def _against_nothing(check: Check, value: str) -> str:
    """A figure that is held against zero: how far off, or how much to spare."""
    assert check.measured is not None
    if check.unit == "s":
        return f"{value} {'earlier' if check.measured > 0 else 'too late'}"
    if check.unit != "m":
        return value if check.measured > 0 else f"−{value}"
    if check.ok:
        return f"{value} {'away' if check.measured < 0 or check.kind == 'leaves' else 'to spare'}"
    return f"misses by {value}"


def _with_unit(value: float, unit: str) -> str:
    if abs(value) < NOTHING:
        value = 0.0
    if unit == "m" and 0 < abs(value) < 0.01:
        value, unit = value * 1000, "mm"
    if value == 1 and unit in COUNTED:
        unit = unit.removesuffix("s")
    return f"{number(value)} {unit}".replace(" °", "°").strip()


def short(value: Any) -> str:
    """A plain value on one line."""
    if isinstance(value, bool):
        return "yes" if value else "no"
    if isinstance(value, int | float):
        return number(value) if isinstance(value, float) else str(value)
    if isinstance(value, list):
        return "(" + ", ".join(short(part) for part in value) + ")"
    if isinstance(value, dict):
        return ", ".join(f"{key} {short(part)}" for key, part in value.items() if part is not None)
    return "none" if value is None else str(value)


MISSED = re.compile(r"([^:;,]+?) (≤|≥|<|>) ([^:;,]+): no\b")
AIRBORNE = re.compile(r"\bfl(?:y|(ies)) free of any contact")
IOU = re.compile(r"\bwith IoU (\d(?:\.\d+)?)")
MINUS = re.compile(r"(?<![\w.])-(?=\d)")
FRAME = re.compile(r"\b(?:in |((?:at|from|until|by|to) ))frame (\d+)\b")
"""Moments that the checks name by their frame; a person is told seconds of the event."""
SAID = frozenset(
    {"text", "found", "told", "also", "rationale", "summary", "question", "reason", "problem"}
)
"""Keys of what is written for a person to read."""


def speaker(program: PhysicalProgram) -> Callable[[str], str]:
    """Writes sentences as one says them: `red_ball at -3` becomes `red ball at −3`."""
    names = {*program.scene.names, *(action.id for action in program.event.actions)}
    longest_first = sorted((re.escape(one) for one in names if "_" in one), key=len, reverse=True)
    # Neither a part of a longer name nor of a path.
    # At the start of a sentence a name has a capital.
    tick = program.clip.steps_per_frame * program.clip.step_seconds
    known = re.compile(rf"(?<![\w.])(?i:{'|'.join(longest_first)})(?![\w.]*\w)")

    def speak(text: str) -> str:
        text = without_paths(text)
        text = AIRBORNE.sub(lambda m: "stays in the air" if m[1] else "stay in the air", text)
        text = IOU.sub(lambda m: f"to {100 * float(m[1]):.0f} %", text)
        text = FRAME.sub(lambda m: f"{m[1] or 'at '}{int(m[2]) * tick:.2f} s", text)
        text = MISSED.sub(lambda m: f"{m[1]}, {INSTEAD[m[2]]} {m[3]}", MINUS.sub("−", text))
        return known.sub(lambda m: m[0].replace("_", " "), text) if longest_first else text

    return speak


def spoken(text: str, program: PhysicalProgram) -> str:
    """One sentence as one says it."""
    return speaker(program)(text)


def all_spoken(data: Any, speak: Callable[[str], str], said: bool = False) -> Any:
    """A panel's data with every sentence in it spoken; values and paths stay as they are."""
    if isinstance(data, str):
        return speak(data) if said else data
    if isinstance(data, dict):
        return {key: all_spoken(part, speak, key in SAID) for key, part in data.items()}
    if isinstance(data, list):
        return [all_spoken(part, speak, said) for part in data]
    return data


def criterion_row(one: Criterion, *, seen_only: bool = False) -> dict[str, Any]:
    """One of the four things by which an event is judged, and why it holds or not.

    seen_only: nothing fails but what a viewer sees.
    """
    name = SEEN_WELL if seen_only and not one.ok else CRITERIA.get(one.name, one.name)
    return {"name": name, "ok": one.ok, "reason": one.reason}


def unseen(checks: Iterable[Check]) -> str:
    """What a viewer cannot see of an event, in words, by the first such check that fails; or ""."""
    for check in checks:
        if check.kind == "view" and not check.ok:
            rule = check.id.split(".")[1]
            least, most = check.threshold, check.measured
            if rule == "fills" and least is not None and most is not None and most > least:
                return UNSEEN["in_time"]
            return UNSEEN.get(rule, "not well seen")
    return ""


def edit_row(edit: Edit, program: PhysicalProgram) -> dict[str, Any]:
    """One edit as a row: what it changes, from what to what, and whether it is one number."""
    if isinstance(edit, SetField):
        try:
            before = value_at(program, edit.path)
        except EditError:
            before = None
        row = {"op": "set", "path": edit.path, "what": place(edit.path), "value": edit.value}
        if unit_of(edit.path) == "steps" and isinstance(edit.value, int):
            scale = program.clip.step_seconds
            was = "" if not isinstance(before, int) else number(before * scale)
            now = number(edit.value * scale)
            return row | {"before": was, "after": now, "unit": "s", "scale": scale}
        said = [_in_words(edit.path, value) for value in (before, edit.value)]
        if said[1]:
            ends = {"before": said[0] or short(before), "after": said[1]}
            return row | ends | {"unit": "", "fixed": True}
        unit = _unit_in(program, edit.path)
        own = before is None and edit.path.rpartition(".")[2] in OF_MATERIAL
        was = "its material's" if own else "" if before is None else short(before)
        return row | {"before": was, "after": short(edit.value), "unit": unit}
    if isinstance(edit, AddItem):
        return {
            "op": "add",
            "path": edit.path,
            "what": "Add",
            "after": _added(edit.item),
            "value": None,
        }
    what = "Remove" if isinstance(edit, RemoveItem) else "Reorder"
    return {"op": edit.op, "path": edit.path, "what": f"{what} {place(edit.path)}", "value": None}


def _added(item: Any) -> str:
    """What is new, in words: an action by what it does to what, anything else by its kind."""
    if not isinstance(item, dict):
        return short(item)
    operator, name = str(item.get("operator", "")), str(item.get("name", "")).replace("_", " ")
    if operator in OPERATORS:
        return f"{OPERATORS[operator].lower()} of {name}"
    subject = str(item.get("subject", "")).replace("_", " ")
    kind = str(item.get("kind", "")).replace("_", " ")
    if "text" in item:
        return f"“{item['text']}”"
    return f"{subject} {kind}".strip() or name or short(item)


def _in_words(path: str, value: Any) -> str:
    """What a field that is no plain number says to a person; "" for one that says it itself."""
    if value is None and path.startswith("scene.") and path.rpartition(".")[2] in OPENED:
        return "found anew"
    if path.endswith(MASK) and isinstance(value, int):
        return f"number {value + 1}"
    if path.endswith(".grounding") and isinstance(value, dict):
        return _marked(value)
    if path.endswith(SETTLED):
        return "taken as right" if value else "open"
    return ""


def _marked(grounding: dict[str, Any]) -> str:
    """What a hand has marked in the photo, counted."""
    points, strokes = grounding.get("points") or [], grounding.get("strokes") or []
    inside = sum(bool(point.get("label", 1)) for point in points)
    counted = ((inside, "click"), (len(points) - inside, "click outside"), (len(strokes), "stroke"))
    parts = [_count(number, what) for number, what in counted if number]
    parts += ["a box"] if grounding.get("box") else []
    return ", ".join([*parts, f"mask {grounding.get('candidate', 0) + 1}"])


def _count(number: int, what: str) -> str:
    """`1 click outside`, `2 clicks outside`."""
    word, _, more = what.partition(" ")
    return f"{number} {word}{'' if number == 1 else 's'} {more}".strip()


SPOKEN = {
    "start_step": "start", "duration": "length", "magnitude": "strength", "elevation": "upwards",
    "azimuth": "aside", "restitution": "bounciness", "rolling": "rolling resistance",
    "step_seconds": "pace", "statements": "demands", "grounding": "marks in the photo",
}  # fmt: skip
"""Fields that have another name for a person."""
PATH = re.compile(
    r"(?<![\w/.])(?:scene\.(?:objects|supports|landmarks|camera|gravity|scale|horizon|roll)"
    r"|event\.(?:actions|prompt)|contract\.\w+|clip\.(?:steps?|frames?|playback)\w*)(?:\.\w+)*"
)
"""Where something stands in the program, in a message."""
VECTOR = frozenset({"force", "velocity", "angular_velocity", "torque"})
"""Fields whose number says it all: "push ball · strength"."""


def place(path: str) -> str:
    """`event.actions.kick.force.magnitude` → `kick · force · magnitude`."""
    for end in (MASK, SETTLED):
        path = path.removesuffix(end) + ".mask" if path.endswith(end) else path
    if path.endswith(".grounding"):
        path = path.removesuffix("grounding") + "marks in the photo"
    parts = path.split(".")
    for head in (("event", "actions"), ("scene", "objects"), ("scene", "supports"),
                 ("scene", "landmarks"), ("contract", "statements")):  # fmt: skip
        if tuple(parts[:2]) == head:
            parts = parts[2:]
    told = [part for at, part in enumerate(parts) if part not in VECTOR or at == len(parts) - 1]
    return " · ".join(SPOKEN.get(part, part.replace("_", " ")) for part in told)


def without_paths(text: str) -> str:
    """A message with what a person calls a field in place of where it stands in the program."""
    return PATH.sub(lambda found: place(found[0]), text)


def _unit_in(program: PhysicalProgram, path: str) -> str:
    """The unit of a field, as the vector that it belongs to has it."""
    above, _, field = path.rpartition(".")
    if field == "magnitude":
        try:
            vector = value_at(program, above)
        except EditError:
            vector = None
        quantity = vector.get("quantity") if isinstance(vector, dict) else None
        if isinstance(quantity, str) and quantity in DIRECTED_UNITS:
            return DIRECTED_UNITS[quantity]
    return unit_of(path)


def unit_of(path: str) -> str:
    """The unit of the field at a path, "" where it has none."""
    if path == "scene.camera.size":
        return "px"
    parts = path.split(".")
    for part in reversed(parts):
        if part in UNITS:
            return UNITS[part]
        if part == "magnitude" and len(parts) >= 2:
            return UNITS.get(parts[-2], "")
    return ""


def plain(model: Any) -> Any:
    """A pydantic value as JSON data."""
    return json.loads(model.model_dump_json())
