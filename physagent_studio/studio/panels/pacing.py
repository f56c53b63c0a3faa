"""Pace: when a viewer sees something move, what leaves the picture, and how slow the clip is."""

from __future__ import annotations

from typing import Any

from physagent_studio.contract import Facts
from physagent_studio.contract.view import Pacing, pacing_of
from physagent_studio.program import Clip, PhysicalProgram
from physagent_studio.program.timing import PACE
from physagent_studio.records import Check, Rollout
from physagent_studio.studio.panels.words import number

KEPT = 4
"""Rollouts whose pacing is remembered: going back and forth between rounds costs nothing."""
SAME = 0.005
"""Time factors that differ by less than this part are one."""
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


def pace_in_words(factor: float) -> str:
    """`0.4 × real time`; less than 1 is slow motion."""
    return (
        "real time" if abs(factor - 1) < SAME else f"{number(float(f'{factor:.2g}'))} × real time"
    )


def length_in_words(clip: Clip) -> str:
    """How long the clip is shown, and what that is in the scene's own time."""
    shown = clip.seconds / clip.time_factor
    text = f"{number(shown)} s at {number(clip.playback_fps)} frames a second"
    slow = abs(clip.time_factor - 1) >= SAME
    return f"{text}, {pace_in_words(clip.time_factor)}" + (
        f": {number(clip.seconds)} s of the event" if slow else ""
    )


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
