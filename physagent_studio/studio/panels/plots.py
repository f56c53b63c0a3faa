"""Plots: height, speed and energy of every object over the clip."""

from __future__ import annotations

from typing import Any

import numpy as np

from physagent_studio.records import Rollout
from physagent_studio.studio.scene.places import colours_of
from physagent_studio.workbench import Snapshot

POINTS = 160


def state_of(
    snapshot: Snapshot, other: Rollout | None = None, *, earlier: bool = False
) -> dict[str, Any]:
    """Series of the shown rollout, and of another one to compare with."""
    rollout = snapshot.rollout
    if rollout is None:
        return {"steps": 0, "objects": [], "plots": []}
    rows = np.unique(np.linspace(0, rollout.steps, POINTS).astype(int))
    colours = colours_of(snapshot)
    return {
        "steps": snapshot.program.clip.steps,
        "stepSeconds": rollout.step_seconds,
        "at": rows.tolist(),
        "objects": list(rollout.objects),
        "colours": [list(colours[name]) for name in rollout.objects],
        "dashed": "the round compared with" if earlier else "with the proposed repair",
        "plots": [
            {"title": title, "unit": unit, "series": _series(rollout, key, rows),
             "other": _matched(rollout, other, key, rows)}
            for title, unit, key in (
                ("Height", "m", "height"), ("Speed", "m/s", "speed"), ("Energy", "J", "energy")
            )
        ],
    }  # fmt: skip


def _values(rollout: Rollout, key: str) -> np.ndarray:
    if key == "height":
        return rollout.positions[:, :, 2]
    if key == "speed":
        return np.linalg.norm(rollout.velocities, axis=2)
    return rollout.kinetic + rollout.potential - rollout.potential[:1]


def _series(rollout: Rollout, key: str, rows: np.ndarray) -> list[list[float]]:
    values = np.nan_to_num(_values(rollout, key)[rows], posinf=0, neginf=0)
    return [[float(f"{value:.4g}") for value in column] for column in values.T]


def _matched(
    rollout: Rollout, other: Rollout | None, key: str, rows: np.ndarray
) -> list[list[float]] | None:
    if other is None or other.objects != rollout.objects or other.steps < rollout.steps:
        return None
    return _series(other, key, rows)
