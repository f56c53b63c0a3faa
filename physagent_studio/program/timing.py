"""Slow motion and time lapse: another time factor for a program, its schedule kept in seconds."""

import math

from physagent_studio.program import actions
from physagent_studio.program.contract import Statement
from physagent_studio.program.edits import Edit, SetField
from physagent_studio.program.program import Clip, PhysicalProgram

SLOWEST, FASTEST = 0.25, 4.0
"""Bounds of the time factor that is chosen by itself: slow motion and time lapse fourfold."""
ENGINE_STEP = 1e-3
"""Longest step of the physics engine, s."""
STEP = 0.01
"""Control step that a clip keeps as near to as it can, s."""
SAME = 0.005
"""Time factors that differ by less than this part are one."""
PACE = ("clip.step_seconds", "clip.steps_per_frame")
"""Paths that hold a clip's time factor: pinned where a person sets it."""


def timing_of(clip: Clip) -> dict[str, float]:
    """How the clip's time goes, for files that carry it: `time_factor` (simulated seconds for each
    that is shown), `simulated_seconds` and `playback_fps`."""
    return {
        "time_factor": clip.time_factor,
        "simulated_seconds": round(clip.seconds, 6),
        "playback_fps": clip.playback_fps,
    }


def pace_in_words(factor: float) -> str:
    """`0.4 × real time`; less than 1 is slow motion."""
    return "real time" if abs(factor - 1) < SAME else f"{float(f'{factor:.2g}'):g} × real time"


def length_in_words(clip: Clip) -> str:
    """How long the clip is shown, and what that is in the scene's own time."""
    shown = clip.seconds / clip.time_factor
    text = f"{shown:.3g} s at {clip.playback_fps:.3g} frames a second"
    slow = abs(clip.time_factor - 1) >= SAME
    return f"{text}, {pace_in_words(clip.time_factor)}" + (
        f": {clip.seconds:.3g} s of the event" if slow else ""
    )


def clip_of(seconds: float | None) -> Clip:
    """A clip in real time that is shown for so many seconds; None is the usual one."""
    usual = Clip()
    if seconds is None:
        return usual
    return usual.model_copy(update={"frames": round(seconds * usual.playback_fps) + 1})


def clip_at(clip: Clip, factor: float) -> Clip:
    """The clip with another time factor; `playback_fps` and the number of frames stay.

    Whole steps per frame come first, so that for quarters the steps stay as long as they were.
    """
    seconds = factor / clip.playback_fps
    per_frame = max(round(seconds / STEP), 1)
    step = float(f"{seconds / per_frame:.6g}")
    substeps = max(math.ceil(step / ENGINE_STEP - 1e-9), min(clip.substeps, 10))
    return clip.model_copy(
        update={"step_seconds": step, "steps_per_frame": per_frame, "substeps": substeps}
    )


def retimed(program: PhysicalProgram, factor: float, *, skip: float = 0.0) -> tuple[Edit, ...]:
    """The edits that give a program another time factor, to be applied together.

    All starts, durations and windows keep their seconds; what reached beyond the shorter clip
    ends with it. An action that would begin after the end begins on the last step. skip: seconds
    by which everything is earlier, at most `wait_of`.
    """
    clip = clip_at(program.clip, factor)
    ratio = program.clip.step_seconds / clip.step_seconds
    earlier = round(skip / clip.step_seconds)
    found: list[Edit] = []
    for field in ("step_seconds", "steps_per_frame", "substeps"):
        found += _changed(f"clip.{field}", getattr(program.clip, field), getattr(clip, field))
    for action in program.event.actions:
        base = f"event.actions.{action.id}"
        whole = action.start_step + actions.duration_of(action) >= program.clip.steps
        start = round(action.start_step * ratio)
        if action.when is None:
            start = min(max(start - earlier, 0), clip.steps - 1)
            found += _changed(f"{base}.start_step", action.start_step, start)
        else:
            found += _condition(base, action.when, ratio, clip.steps)
        if hasattr(action, "duration"):
            length = max(round(actions.duration_of(action) * ratio) - earlier * _holds(action), 1)
            if action.when is None:
                room = clip.steps - start
                length = room if whole else min(length, room)
            found += _changed(f"{base}.duration", actions.duration_of(action), length)
    for statement in program.contract.statements:
        base = f"contract.statements.{statement.id}"
        found += _window(base, statement, ratio, clip.steps, earlier)
    return tuple(found)


def wait_of(program: PhysicalProgram) -> float:
    """Seconds that pass at the beginning of a program without anything being done but held."""
    waits = [
        actions.duration_of(action) if _holds(action) else action.start_step
        for action in program.event.actions
        if action.when is None
    ]
    return min(waits, default=0) * program.clip.step_seconds


def _holds(action: actions.Action) -> bool:
    return isinstance(action, actions.FixObject) and action.when is None and action.start_step == 0


def _window(
    base: str, statement: Statement, ratio: float, last: int, earlier: int = 0
) -> list[Edit]:
    found: list[Edit] = []
    for field in ("from_step", "to_step"):
        step = getattr(statement, field)
        if step is not None:
            moved = max(round(step * ratio) - earlier, 1 if step else 0)
            found += _changed(f"{base}.{field}", step, min(moved, last))
    return found


def _condition(
    base: str, when: actions.OnContact | actions.After | actions.When, ratio: float, last: int
) -> list[Edit]:
    found = _changed(f"{base}.when.delay", when.delay, round(when.delay * ratio))
    if when.timeout is not None:
        found += _changed(f"{base}.when.timeout", when.timeout, round(when.timeout * ratio))
    if isinstance(when, actions.When):
        found += _window(f"{base}.when.statement", when.statement, ratio, last)
    return found


def _changed(path: str, before: float, after: float) -> list[Edit]:
    return [SetField(path=path, value=after)] if after != before else []
