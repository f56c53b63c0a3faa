"""What was measured, as short lines of text for the model."""

import json
import math
from collections.abc import Iterable
from typing import Any

import numpy as np

from physagent_studio.program import PhysicalProgram, SceneState
from physagent_studio.program.rotations import matrix_of
from physagent_studio.program.scene.materials import density_of, touch_of
from physagent_studio.program.scene.shapes import outline_of
from physagent_studio.records import Check, Finding, Rollout

MOST_CONTACTS = 40


def figure(value: float) -> str:
    """Three significant digits."""
    return f"{value:.3g}"


def vector(values: Iterable[float]) -> str:
    """A vector with three significant digits each."""
    return "[" + ", ".join(figure(float(part)) for part in values) + "]"


def scene_lines(scene: SceneState) -> str:
    """Objects, supports and landmarks with their sizes and places."""
    lines = []
    for item in scene.objects:
        parts = [f"object {item.name}"]
        if item.shape is not None:
            parts.append(f"{item.shape.kind}, extent {vector(outline_of(item.shape).size)} m")
        if item.position is not None:
            parts.append(f"at {vector(item.position)}")
        parts += [
            f"on {item.support or 'unknown'}",
            f"{item.material}, {figure(density_of(item))} kg/m³",
            f"friction {figure(touch_of(item).friction)}",
            item.body.kind,
        ]
        lines.append("; ".join(parts))
    for item in scene.supports:
        shape = "unresolved" if item.shape is None else _plain(item.shape.model_dump())
        lines.append(f"support {item.name}; {shape}; {item.material}")
    for item in scene.landmarks:
        where = "unresolved" if not item.points else ", ".join(vector(p) for p in item.points)
        lines.append(f"landmark {item.name}; {item.kind}; {where}")
    return "\n".join(lines) or "nothing"


def camera_line(scene: SceneState) -> str:
    """Where the camera stands and looks."""
    camera = scene.camera
    if camera is None:
        return "unknown"
    forward = camera.matrix[:, 2]
    pitch = math.degrees(math.asin(float(np.clip(-forward[2], -1, 1))))
    width, rows = camera.size
    view = math.degrees(2 * math.atan(rows / 2 / camera.focal))
    sure = "confirmed by a person" if camera.confirmed else f"not confirmed ({camera.source})"
    return (
        f"{figure(camera.position[2])} m above the floor, looking {figure(pitch)}° down, vertical "
        f"field of view {figure(view)}°, horizon at row {figure(camera.horizon)} of {rows}, "
        f"picture {width} × {rows}; {sure}"
    )


def finding_lines(findings: tuple[Finding, ...]) -> str:
    """The findings of stage 1."""
    return (
        "\n".join(f"[{'ok' if item.ok else 'FAILS'}] {item.kind}: {item.text}" for item in findings)
        or "none"
    )


def check_lines(checks: tuple[Check, ...], program: PhysicalProgram) -> str:
    """The measured contract, clause by clause, and the physical checks."""
    clauses = {clause.id: clause.text for clause in program.contract.clauses}
    lines = []
    for check in checks:
        state = "holds" if check.ok else "FAILS"
        about = f" (clause {check.clause}: {clauses.get(check.clause, '')})" if check.clause else ""
        note = "" if check.demanded else " (only serves another)"
        lines.append(
            f"[{state}, margin {figure(check.margin)}] {check.id}: {check.text}{about}{note}"
        )
    untested = [clause.text for clause in program.contract.untested]
    lines += [f"not measured by anything: {text}" for text in untested]
    return "\n".join(lines) or "nothing was measured"


def action_lines(program: PhysicalProgram, rollout: Rollout | None = None) -> str:
    """The schedule as it was written and when each action really acted."""
    spans = {span.id: span for span in rollout.spans} if rollout else {}
    lines = []
    for action in program.event.actions:
        text = _plain(
            action.model_dump(mode="json", exclude_defaults=True)
            | {"operator": action.operator, "name": action.name}
        )
        span = spans.get(action.id)
        if span is not None:
            text += (
                f" — acted on steps {span.start} to {span.end}, work {figure(span.work)} J"
                if span.start is not None
                else " — never started"
            )
        lines.append(text)
    return "\n".join(lines) or "none"


def motion_lines(rollout: Rollout) -> str:
    """Per object: where it began and ended, how far and fast it went; then who touched whom."""
    lines = [_motion(rollout, index) for index in range(len(rollout.objects))]
    lines += contact_lines(rollout)
    lines += [f"warning at step {item.step}: {item.text}" for item in rollout.warnings]
    return "\n".join(lines)


def _motion(rollout: Rollout, index: int) -> str:
    path = rollout.positions[:, index]
    speed = np.linalg.norm(rollout.velocities[:, index], axis=1)
    moving = np.flatnonzero(speed > 0.02)
    length = float(np.linalg.norm(np.diff(path, axis=0), axis=1).sum())
    tilt = _tilt(rollout.rotations[0, index], rollout.rotations[-1, index])
    when = f"moves from step {moving[0]} to {moving[-1]}" if len(moving) else "never moves"
    return (
        f"{rollout.objects[index]}: from {vector(path[0])} to {vector(path[-1])} m, path "
        f"{figure(length)} m, top speed {figure(float(speed.max()))} m/s at step "
        f"{int(speed.argmax())}, speed at the end {figure(float(speed[-1]))} m/s, tilted "
        f"{figure(tilt)}° at the end, {when}"
    )


def _tilt(first: np.ndarray, last: np.ndarray) -> float:
    """Degrees between the first and last direction of the body's first up axis."""
    up = (matrix_of(tuple(last)) @ matrix_of(tuple(first)).T)[2, 2]
    return math.degrees(math.acos(float(np.clip(up, -1, 1))))


def contact_lines(rollout: Rollout) -> list[str]:
    """Each pair that touched: first step, how long, the hardest blow."""
    found: dict[tuple[int, int], list[Any]] = {}
    for row in rollout.contacts:
        pair = (int(row["a"]), int(row["b"]))
        entry = found.setdefault(pair, [int(row["step"]), int(row["step"]), 0.0])
        entry[1] = int(row["step"])
        entry[2] = max(entry[2], float(row["impulse"]))
    ordered = sorted(found.items(), key=lambda one: (one[1][0], one[0]))
    return [
        f"{rollout.bodies[a]} touches {rollout.bodies[b]}: first at step {first}, last at step "
        f"{last}, at most {figure(blow)} N·s in a step"
        for (a, b), (first, last, blow) in ordered[:MOST_CONTACTS]
    ]


def _plain(data: dict[str, Any]) -> str:
    return json.dumps(rounded(data), ensure_ascii=False)


def rounded(data: Any) -> Any:
    """Plain data with floats cut to four significant digits, for reading."""
    if isinstance(data, float):
        return float(f"{data:.4g}")
    if isinstance(data, dict):
        return {key: rounded(value) for key, value in data.items()}
    if isinstance(data, list | tuple):
        return [rounded(value) for value in data]
    return data
