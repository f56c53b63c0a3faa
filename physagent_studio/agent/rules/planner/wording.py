"""Sentences of the planner: what it changes, why, and what it asks when it is stuck."""

from __future__ import annotations

import hashlib
import re
from collections.abc import Sequence
from typing import Any

from physagent_studio.agent.roles import Situation
from physagent_studio.agent.rules.planner.trials import Candidate
from physagent_studio.contract import INSTEAD
from physagent_studio.errors import StudioError
from physagent_studio.program.edits import AddItem, Edit, RemoveItem, SetField, value_at
from physagent_studio.program.program import PhysicalProgram
from physagent_studio.program.timing import PACE
from physagent_studio.records import Hunk, Proposal

BOUND = re.compile(r" (≤|≥|<|>) ")


def proposal(
    program: PhysicalProgram,
    rationale: str,
    *edits: tuple[Edit, ...],
    summary: str = "",
    factor: str = "none",
    confidence: float = 0.0,
    **more: Any,
) -> Proposal:
    """A proposal over a program with a hunk for each tuple of edits; the same has the same id.

    summary: of its hunks, where their edits do not say it. more: further fields.
    """
    hunks = tuple(
        Hunk(id=f"h{number}", summary=summary or summary_of(program, own), edits=own)
        for number, own in enumerate(edits, 1)
    )
    name = hashlib.sha256(f"{program.hash}{hunks!r}{rationale}".encode()).hexdigest()[:12]
    return Proposal(
        id=f"p{name}",
        hunks=hunks,
        rationale=rationale,
        factor=factor,
        confidence=confidence,
        **more,
    )  # fmt: skip


def summary_of(program: PhysicalProgram, edits: tuple[Edit, ...]) -> str:
    """What the edits do, in words and figures; another pace is one thing, however many it sets."""
    paced, others = apart_from_pace(edits)
    told = [_paced(program, paced)] if paced else []
    return "; ".join([*told, *(_one(program, edit) for edit in others)])


def apart_from_pace(edits: Sequence[Edit]) -> tuple[tuple[Edit, ...], tuple[Edit, ...]]:
    """Edits that give the clip another pace, with the starts and lengths that keep their seconds,
    and all others."""
    paths = [getattr(edit, "path", "") for edit in edits]
    if not any(path in PACE for path in paths):
        return (), tuple(edits)
    of_pace = [path.startswith("clip.") or path.rsplit(".", 1)[-1] in _IN_STEPS for path in paths]
    paced = tuple(edit for edit, mine in zip(edits, of_pace, strict=True) if mine)
    return paced, tuple(edit for edit, mine in zip(edits, of_pace, strict=True) if not mine)


def _paced(program: PhysicalProgram, edits: tuple[Edit, ...]) -> str:
    clip = program.clip.model_dump(mode="json")
    clip |= {e.path.split(".")[1]: e.value for e in edits
             if isinstance(e, SetField) and e.path.startswith("clip.")}  # fmt: skip
    before, now = program.clip.time_factor, type(program.clip).model_validate(clip).time_factor
    return f"pace from {before:.2g} to {now:.2g} × real time"


def _one(program: PhysicalProgram, edit: Edit) -> str:
    if isinstance(edit, AddItem):
        item = edit.item if isinstance(edit.item, dict) else {}
        what = ADDED.get(str(item.get("operator", "")), f"a demand ({item.get('kind', '')})")
        return f"add {what} on {item['name']}" if "name" in item else f"add {what}"
    if isinstance(edit, RemoveItem):
        return f"remove {edit.path.rsplit('.', 1)[-1]}"
    if isinstance(edit, SetField):
        field, old = edit.path.rsplit(".", 1)[-1], _before(program, edit.path)
        step = program.clip.step_seconds if field in _IN_STEPS else 1.0
        before, now = _figure(old, step), _figure(edit.value, step)
        unit = " s" if field in _IN_STEPS else _UNITS.get(field, "")
        known = "" if old is None and field not in _OF_MATERIAL else f" from {before}"
        return f"{_short(edit.path)}{known} to {now}{unit}"
    return f"move {edit.path}"


def _before(program: PhysicalProgram, path: str) -> object:
    try:
        return value_at(program, path)
    except StudioError:
        return None


def _short(path: str) -> str:
    parts = path.split(".")
    tail = [p for p in parts[3:] if p not in _AROUND]
    words = [_WORDS.get(p, p.replace("_", " ")) for p in tail or parts[-1:]]
    return f"{' '.join(words)} of {parts[2]}" if len(parts) > 3 else path


_AROUND = ("force", "velocity", "torque", "angular_velocity", "wheels")
_WORDS = {
    "magnitude": "strength",
    "azimuth": "sideways angle",
    "elevation": "upward angle",
    "start_step": "start",
    "duration": "length",
    "restitution": "bounciness",
    "rolling": "rolling resistance",
    "density": "weight",
}
_UNITS = {"azimuth": "°", "elevation": "°", "density": " kg/m³"}
_IN_STEPS = frozenset({"start_step", "duration", "delay", "timeout", "from_step", "to_step"})
_OF_MATERIAL = frozenset({"friction", "rolling", "restitution", "density"})
"""What people call the numbers of a push, what they are counted in, which are said in seconds, and
which the material answers for."""
ADDED = {
    "ApplyForce": "a push", "SetVelocity": "a start", "SetAngularVelocity": "a spin",
    "ApplyTorque": "a twist", "ApplyAngledForce": "a steered push", "ApplyDisturbance": "wind",
    "FixObject": "a hold", "SetPosition": "a new place", "SetOrientation": "a turn",
}  # fmt: skip
"""What an action that is new does, in a word."""


def _figure(value: object, unit: float = 1.0) -> str:
    if value is None:
        return "its material's"
    if isinstance(value, float | int):
        return f"{value * unit:.3g}"
    if isinstance(value, list):
        return "(" + ", ".join(_figure(v) for v in value) + ")"
    if isinstance(value, dict):
        toward = value.get("toward") or value.get("direction") or value.get("along")
        return f"{_figure(value.get('magnitude'))} {toward}"
    return str(value)


def rationale_of(situation: Situation, start: Candidate, best: Candidate) -> str:
    """Why: the worst mismatch, the change, and what it did in the trial."""
    diagnosis = situation.assessment.diagnosis
    why = _said_of(diagnosis[0].text) if diagnosis else "the event does not hold"
    change = summary_of(situation.program, best.edits)
    left = best.score.failing
    was = start.score.failing
    if best.score.holds:
        outcome = "everything that is demanded holds"
    elif left < was:
        outcome = f"{left} instead of {was} checks fail"
    else:
        outcome = f"the {was} failing checks miss by {best.score.shortfall:.2g} instead of "
        outcome += f"{start.score.shortfall:.2g}"
    reached = _reached(diagnosis[0].check, best) if diagnosis else ""
    return f"Because {why}: {change}; then {f'{reached}, and ' if reached else ''}{outcome}."


def _reached(check: str, best: Candidate) -> str:
    """What the trial measured for a check that failed, "ball turns 95°"; "" for no figure."""
    text = next((one.text for one in best.checks if one.id == check), "").partition(": ")[0]
    bound = BOUND.search(text)
    return text[: bound.start()] if bound else ""


def _said_of(mismatch: str) -> str:
    """A mismatch after "because": "it is in sight: no, from 2 s on" does not read on from there."""
    claim, denied, more = mismatch.partition(": no")
    if not denied or more[:1] not in ("", ","):
        return mismatch
    plain = BOUND.sub(lambda m: f", {INSTEAD[m[1]]} ", claim)
    return f"{plain}{more}" if plain != claim else f"it does not hold that {claim}{more}"


def question_for(situation: Situation) -> str:
    """A concrete question to a person."""
    diagnosis = situation.assessment.diagnosis
    if not diagnosis:
        untested = situation.assessment.untested
        if untested:
            return f"Nothing tests “{untested[0]}”: what should be true at the end?"
        return "What should happen that does not?"
    worst = diagnosis[0]
    flags = situation.program.scene.flags
    if flags:
        return f"{worst.text}. {flags[0][0].upper()}{flags[0][1:]}: can you put it right?"
    about = worst.subject or "it"
    if worst.code == "unlike_the_photo":
        return f"{worst.text}. Does another mask or another kind of shape suit {about} better?"
    if worst.code in ("not_deformed", "not_broken", "not_spread", "not_swaying"):
        return f"{worst.text}. What is {about} made of: soft, brittle, loose grains or rigid?"
    if worst.other:
        return (
            f"{worst.text}. Is {worst.other} where the scene has it, and what should move {about}?"
        )
    return f"{worst.text}. What should make {about} do this: a push, from where and how strong?"
