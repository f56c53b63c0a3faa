"""Timeline: a lane per object with its actions, what was touched when, and the contract's marks;
when something is seen to move, and what leaves the picture."""

from __future__ import annotations

from typing import Any

import numpy as np

from physagent_studio.contract import Facts, describe
from physagent_studio.contract.view import Pacing, pacing_of
from physagent_studio.program import Action, Clip, Directed, PhysicalProgram, duration_of
from physagent_studio.program.actions import (
    After,
    OnContact,
    SetOrientation,
    SetPosition,
    SetVelocity,
)
from physagent_studio.program.timing import PACE, SAME, length_in_words, pace_in_words
from physagent_studio.records import ActionSpan, Check, Rollout
from physagent_studio.studio.panels.words import (
    DIRECTED_UNITS,
    OPERATORS,
    SLOWING,
    number,
    plain,
    unit_of,
)
from physagent_studio.studio.scene.places import colours_of
from physagent_studio.workbench import Snapshot

KEPT = 4
"""Rollouts whose pacing is remembered: going back and forth between rounds costs nothing."""
OFFERED = ((1.0, "real time"), (1 / 2, "1/2"), (1 / 3, "1/3"), (1 / 4, "1/4"))
"""Time factors to choose from, in words."""


class Pacings:
    """The pacing of the rollouts that were shown last, each worked out once."""

    def __init__(self) -> None:
        self._kept: list[tuple[PhysicalProgram, Rollout, Pacing | None]] = []

    def of(self, program: PhysicalProgram, rollout: Rollout | None) -> Pacing | None:
        """The pacing of a run; None where nothing ran or there is no camera."""
        if rollout is None:
            return None
        for known, ran, pacing in self._kept:
            if known is program and ran is rollout:
                return pacing
        found = pacing_of(Facts.of(program, rollout))
        self._kept = [(program, rollout, found), *self._kept[: KEPT - 1]]
        return found


def pace_of(
    clip: Clip, pacing: Pacing | None, rollout: Rollout | None, pinned: tuple[str, ...]
) -> dict[str, Any]:
    """How the clip is shown, and from when to when something moves in the picture, in steps."""
    moves = None
    if pacing is not None and rollout is not None and pacing.first is not None:
        assert pacing.last is not None
        frames = (pacing.first, pacing.last)
        moves = {
            "first": frames[0] * rollout.steps_per_frame,
            "last": frames[1] * rollout.steps_per_frame,
            "text": f"Something moves in the picture from {_seconds(rollout, frames[0])} (frame "
            f"{frames[0]}) to {_seconds(rollout, frames[1])} (frame {frames[1]})",
        }
    return {
        "factor": clip.time_factor,
        "text": pace_in_words(clip.time_factor),
        "length": length_in_words(clip),
        "pinned": is_pinned(pinned),
        "moves": moves,
    }


def _seconds(rollout: Rollout, frame: int) -> str:
    """When a frame is, as a person is told: seconds of the event."""
    return f"{frame * rollout.steps_per_frame * rollout.step_seconds:.2f} s"


def is_pinned(pinned: tuple[str, ...]) -> bool:
    """Whether the agent keeps the pace as a person has set it."""
    return set(PACE) <= set(pinned) or "clip" in pinned


def leaving(
    name: str, pacing: Pacing | None, rollout: Rollout | None, checks: tuple[Check, ...]
) -> dict[str, Any] | None:
    """From when on less than half of a thing is in the picture; None where it stays in it."""
    if pacing is None or rollout is None:
        return None
    frame = dict(pacing.crossings).get(name)
    if frame is None:
        return None
    failed = any(one.id == f"view.inside.{name}"[:64] and not one.ok for one in checks)
    said = name.replace("_", " ")
    at = _seconds(rollout, frame)
    text = (
        f"{said} is out of the picture from {at} on (frame {frame}): less than half of it is seen"
    )
    return {"step": frame * rollout.steps_per_frame, "frame": frame, "ok": not failed, "text": text}


def choice_of(clip: Clip, pinned: tuple[str, ...]) -> dict[str, Any]:
    """What the inspector's control of the pace shows."""
    return {
        "factor": clip.time_factor,
        "text": pace_in_words(clip.time_factor),
        "pinned": is_pinned(pinned),
        "paths": list(PACE),
        "offered": [
            {"factor": factor, "text": text, "on": abs(clip.time_factor - factor) < SAME}
            for factor, text in OFFERED
        ],
    }


INSTANT = (SetVelocity, SetPosition, SetOrientation)
MARKS_PER_LANE = 80


def state_of(snapshot: Snapshot, pacing: Pacing | None = None) -> dict[str, Any]:
    """All that the timeline draws; times in control steps. pacing: of the rollout on view."""
    program, rollout = snapshot.program, snapshot.rollout
    clip = program.clip
    colours = colours_of(snapshot)
    return {
        "steps": clip.steps,
        "stepSeconds": clip.step_seconds,
        "stepsPerFrame": clip.steps_per_frame,
        "frames": clip.frames,
        "readOnly": snapshot.read_only,
        "pace": pace_of(clip, pacing, rollout, snapshot.state.pinned),
        "lanes": [
            _lane(item.name, program, rollout)
            | {"colour": list(colours[item.name])}
            | {"leaves": leaving(item.name, pacing, rollout, snapshot.checks)}
            for item in program.scene.objects
        ],
        "marks": [
            {"step": check.step, "ok": check.ok, "text": check.text}
            for check in snapshot.checks
            # What only serves another demand need not hold.
            if check.step is not None and (check.ok or check.demanded)
        ],
        "alarms": []
        if rollout is None
        else [{"step": one.step, "text": one.text} for one in rollout.warnings[:40]],
        "ran": None if rollout is None else rollout.steps,
    }


def _lane(name: str, program: PhysicalProgram, rollout: Rollout | None) -> dict[str, Any]:
    return {
        "name": name,
        "actions": [
            _bar(action, program, rollout)
            for action in program.event.actions
            if action.name == name
        ],
        "contacts": [] if rollout is None else first_contacts(rollout, name)[:MARKS_PER_LANE],
    }


def _bar(action: Action, program: PhysicalProgram, rollout: Rollout | None) -> dict[str, Any]:
    span = None
    if rollout is not None:
        span = next((one for one in rollout.spans if one.id == action.id), None)
    start = action.start_step
    if action.when is not None and span is not None and span.start is not None:
        start = span.start
    return {
        "id": action.id,
        "kind": action.operator,
        "label": label_of(action),
        "start": start,
        "duration": duration_of(action),
        "instant": isinstance(action, INSTANT),
        "muted": action.muted,
        "item": plain(action),
        "when": _condition(action, program, rollout, span),
        "fired": None if span is None else span.start,
        "never": action.when is not None
        and rollout is not None
        and (span is None or span.start is None),
    }


def label_of(action: Action) -> str:
    """`Push 12 N →`-like words for a bar."""
    words = OPERATORS[action.operator]
    for field in ("velocity", "angular_velocity", "force", "torque"):
        value = getattr(action, field, None)
        if value is None:
            continue
        if not isinstance(value, Directed):
            return f"{words} {number(float(np.linalg.norm(value)))} {unit_of(field)}"
        unit = DIRECTED_UNITS.get(value.quantity, unit_of(field))
        goal = "to " if value.quantity == "target_speed" else ""
        if value.along == "against_velocity" or (goal and value.magnitude == 0):
            words = SLOWING
        return f"{words} {goal}{number(float(value.magnitude))} {unit}"
    for field in ("magnitude", "amplitude"):
        value = getattr(action, field, None)
        if value is not None:
            return f"{words} {number(value)} N"
    return words


def _condition(
    action: Action, program: PhysicalProgram, rollout: Rollout | None, span: ActionSpan | None
) -> dict[str, Any] | None:
    """What starts the action in words, its delay, and where on the timeline its cause lies."""
    when = action.when
    if when is None:
        return None
    cause: dict[str, Any] = {"delay": when.delay, "lane": None, "step": None}
    begun = None if span is None else span.start
    if isinstance(when, OnContact):
        names = [when.a, when.b]
        cause |= {"text": f"when {when.a} touches {when.b}", "lane": names[0]}
    elif isinstance(when, After):
        cause["text"] = f"after {when.action}"
        other = program.action(when.action)
        cause["lane"] = None if other is None else other.name
        ends = [one.end for one in rollout.spans if one.id == when.action] if rollout else []
        cause["step"] = ends[0] if ends else None
    else:
        cause["text"] = f"when {describe(when.statement, program)}"
        cause["lane"] = when.statement.subject
    if cause["step"] is None and begun is not None:
        # It starts one step after what has happened, and then waits.
        cause["step"] = max(begun - when.delay - 1, 0)
    lanes = {item.name for item in program.scene.objects}
    if cause["lane"] not in lanes:
        other = [n for n in (getattr(when, "a", ""), getattr(when, "b", "")) if n in lanes]
        cause["lane"] = other[0] if other else None
    return cause


def first_contacts(rollout: Rollout, name: str) -> list[dict[str, Any]]:
    """When the object begins to touch another body, step and partner; rest is not repeated."""
    if name not in rollout.bodies or len(rollout.contacts) == 0:
        return []
    me = rollout.bodies.index(name)
    contacts = rollout.contacts
    mine = contacts[(contacts["a"] == me) | (contacts["b"] == me)]
    found = []
    partners = np.where(mine["a"] == me, mine["b"], mine["a"])
    for partner in np.unique(partners):
        steps = np.unique(mine["step"][partners == partner])
        # A gap of fewer than three steps is chatter of one and the same contact.
        begins = steps[np.insert(np.diff(steps) > 3, 0, True)]
        found += [
            {"step": int(step), "with": rollout.bodies[partner]} for step in begins if step > 0
        ]
    return sorted(found, key=lambda one: one["step"])
