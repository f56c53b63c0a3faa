"""As much as told: as fast as the verb says, and along the axis of what has wheels."""

from __future__ import annotations

import numpy as np

from physagent_studio.contract.facts import Facts
from physagent_studio.contract.view.basics import (
    said,
    view_check,
)
from physagent_studio.contract.words import number
from physagent_studio.records.judgement import Check

OFF_AXIS, TIPPED = 20.0, 45.0
"""Degrees that what rolls on wheels may go off its axis, and tilt (a ramp tilts it as well)."""


def amounts(facts: Facts) -> list[Check]:
    """What something sets going is as fast as the verb and its size allow, while it stands on
    something: a fall is as fast as it is."""
    found = []
    for pace in facts.program.contract.paces:
        if not facts.is_object(pace.subject):
            continue
        # Level, since what lands is still as fast as it fell on the step that it touches down.
        level = facts.track(pace.subject, facts.whole()).velocities[:, :2]
        carried = facts.touching_anything(pace.subject, facts.whole())
        speed = np.where(carried, np.linalg.norm(level, axis=1), 0.0)
        most = float(speed.max())
        text = (
            f"{pace.subject} goes at most as fast as “{pace.verb}” says: "
            f"{number(most, 'm/s')} ≤ {number(pace.high, 'm/s')}: {{answer}}"
        )
        found.append(
            view_check(
                "amount", pace.subject, text, (pace.high - most) / max(pace.high, 1e-3),
                measured=most, threshold=pace.high, unit="m/s",
                step=int(speed.argmax()),
            )
        )  # fmt: skip
    return found


def on_wheels(facts: Facts, names: tuple[str, ...]) -> list[Check]:
    """What rolls on wheels goes along its axis, front first, and stays upright."""
    found = []
    for name in names:
        item = facts.program.scene.object(name)
        wheels = None if item is None else item.wheels
        if wheels is None or (wheels.grip is not None and wheels.grip <= wheels.rolling):
            continue
        track = facts.track(name, facts.whole())
        if said(facts.program, name, ("topples", "flips", "rotates", "reverses")):
            continue
        turned = track.placed.matrices @ track.placed.matrices[0].T
        angle = np.radians(wheels.heading)
        # Seen from above: the heading says nothing of the slope on which it may begin.
        front = (turned @ np.array([np.cos(angle), np.sin(angle), 0.0]))[:, :2]
        goes = track.velocities[:, :2]
        speed = np.linalg.norm(goes, axis=1)
        moves = speed > max(0.05, 0.1 * float(speed.max()))
        if not moves.any():
            continue
        along = np.abs(np.einsum("ti,ti->t", front, goes)) / np.maximum(
            np.linalg.norm(front, axis=1) * speed, 1e-9
        )
        off = np.degrees(np.arccos(np.clip(along, 0, 1)))
        worst = float(np.quantile(off[moves], 0.9))
        tilt = float(track.tilt()[moves].max())
        text = (
            f"{name} rolls along its own axis: {number(worst, '°')} off ≤ {OFF_AXIS:.0f}°, "
            f"tilted by {number(tilt, '°')}: {{answer}}"
        )
        margin = min(1 - worst / OFF_AXIS, 1 - tilt / TIPPED)
        found.append(
            view_check("wheels", name, text, margin, measured=worst, threshold=OFF_AXIS, unit="°")
        )
    return found
