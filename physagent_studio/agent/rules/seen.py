"""What a person would notice in the clip beside the contract: is there something to see?"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from physagent_studio.program.program import PhysicalProgram
from physagent_studio.program.shapes import outline_of
from physagent_studio.records import Check, Rollout

FloatArray = NDArray[np.float64]
SMALLEST_PIXELS = 5.0
LEAST_SHIFT = 0.012
"""Least way in the picture that is noticed, as a part of the picture's diagonal."""
LEAST_TURN = 8.0
STILL = frozenset(("stays", "upright", "rests_on"))
MOVING = frozenset(("moves", "falls", "topples", "leaves", "rotates", "flips", "sways", "breaks"))
TIMED = frozenset(
    ("contacts", "falls", "moves", "passes_over", "flips", "rotates", "path_bends", "reverses")
)


def seen_checks(
    program: PhysicalProgram, rollout: Rollout, checks: tuple[Check, ...]
) -> tuple[Check, ...]:
    """Checks of what is visible; none where there is no camera."""
    acting = acting_objects(program)
    names = tuple(name for name in rollout.objects if name in acting)
    if program.scene.camera is None or not names or rollout.blown_up is not None:
        return ()
    in_time = _in_time(program, rollout, checks)
    if _nothing_shall_happen(program):
        return (in_time,)
    stays_in = _stops_in_the_picture(program, rollout)
    return (_something_happens(program, rollout, names), in_time, *stays_in)


def _nothing_shall_happen(program: PhysicalProgram) -> bool:
    """Whether all that is demanded is that things stay as they are."""
    statements = program.contract.statements
    return bool(statements) and all(
        s.kind in STILL or (s.negated and s.kind in MOVING) for s in statements
    )


def acting_objects(program: PhysicalProgram) -> frozenset[str]:
    """Objects that the contract or the schedule says something happens to."""
    named = {
        str(getattr(s, "subject", ""))
        for s in program.contract.statements
        if s.kind not in STILL and not s.negated
    }
    return frozenset(named | {action.name for action in program.event.actions})


STOPPING = frozenset(("stops", "stops_before", "covers"))
"""What is seen only where the thing is in the picture at the end."""


def _stops_in_the_picture(program: PhysicalProgram, rollout: Rollout) -> tuple[Check, ...]:
    """What shall come to rest somewhere has not left the picture by then."""
    camera = program.scene.camera
    assert camera is not None
    wanted = {
        str(getattr(s, "subject", ""))
        for s in program.contract.statements
        if s.kind in STOPPING and not s.negated
    }
    found = []
    for name in (n for n in rollout.objects if n in wanted):
        ends = rollout.positions[-1, rollout.objects.index(name)]
        pixel, depth = camera.project(ends[None])
        size = np.array(camera.size, float)
        out = float(np.maximum(-pixel[0], pixel[0] - size).max())
        out = out if depth[0] > 0.01 else float(size.max())
        found.append(
            Check(
                id=f"seen.inside.{name}"[:64],
                text=f"{name} is in the picture at the end: {'yes' if out <= 0 else 'no'}",
                ok=out <= 0,
                measured=out,
                threshold=0.0,
                unit="px",
                margin=float(np.clip(-out / float(np.hypot(*size)), -1.0, 1.0)),
                step=rollout.steps,
                kind="visible",
                always_on=True,
            )
        )
    return tuple(found)


def _something_happens(program: PhysicalProgram, rollout: Rollout, names: tuple[str, ...]) -> Check:
    """Some acting object visibly moves, turns or changes its shape inside the picture."""
    camera = program.scene.camera
    assert camera is not None
    diagonal = float(np.hypot(*camera.size))
    best = 0.0
    text = "something visible happens"
    for name in names:
        shift, size = _visible_shift(program, rollout, name)
        if size < SMALLEST_PIXELS:
            continue
        turn = _turn(rollout, name) / LEAST_TURN
        bend = 2.0 if any(one == name for one, _ in rollout.vertices) else 0.0
        best = max(best, shift / (LEAST_SHIFT * diagonal), turn, bend)
    ok = best >= 1.0
    figures = f"{best * LEAST_SHIFT * diagonal:.0f} px ≥ {LEAST_SHIFT * diagonal:.0f} px"
    return Check(
        id="seen.something",
        text=f"{text}: {figures}: {'yes' if ok else 'no'}",
        ok=ok,
        measured=best * LEAST_SHIFT * diagonal,
        threshold=LEAST_SHIFT * diagonal,
        unit="px",
        margin=float(np.clip(best - 1.0, -1.0, 10.0)),
        kind="visible",
        always_on=True,
    )


def _visible_shift(program: PhysicalProgram, rollout: Rollout, name: str) -> tuple[float, float]:
    """How far it moves inside the picture, and how large it is at most, pixels."""
    camera = program.scene.camera
    assert camera is not None
    steps = rollout.frame_steps()
    points = rollout.positions[steps, rollout.objects.index(name)]
    if not np.isfinite(points).all():
        return 0.0, 0.0
    pixels, depth = camera.project(points)
    width, height = camera.size
    inside = (depth > 0.01) & (pixels >= 0).all(axis=1) & (pixels < [width, height]).all(axis=1)
    if not inside.any():
        return 0.0, 0.0
    kept = pixels[inside]
    shift = float(np.linalg.norm(kept - kept[0], axis=1).max())
    item = program.scene.object(name)
    edge = float(outline_of(item.shape).size.mean()) if item and item.shape else 0.1
    return shift, float((camera.focal * edge / depth[inside]).max())


def _turn(rollout: Rollout, name: str) -> float:
    """Greatest turn from its first pose, degrees."""
    rotations = rollout.rotations[:, rollout.objects.index(name)]
    dot = np.abs(rotations @ rotations[0])
    return float(np.degrees(2 * np.arccos(np.clip(dot, 0, 1))).max())


def _in_time(program: PhysicalProgram, rollout: Rollout, checks: tuple[Check, ...]) -> Check:
    """Nothing decisive happens only in the last two frames."""
    last = rollout.steps - 2 * rollout.steps_per_frame
    steps = [
        c.step for c in checks if c.ok and c.demanded and c.kind in TIMED and c.step is not None
    ]
    negated = {s.id for s in program.contract.statements if s.negated}
    steps = [
        c.step
        for c in checks
        if c.ok and c.demanded and c.kind in TIMED and c.id not in negated and c.step is not None
    ]
    latest = max(steps, default=0)
    ok = latest <= last
    return Check(
        id="seen.in_time",
        text=f"the event is over before the last frames: {'yes' if ok else 'no'}, frame "
        f"{rollout.frame_of(latest)} of {rollout.frames}",
        ok=ok,
        measured=float(rollout.frame_of(latest)),
        threshold=float(rollout.frame_of(last)),
        unit="frame",
        margin=(last - latest) / max(rollout.steps, 1),
        step=latest,
        kind="visible",
        always_on=True,
    )
