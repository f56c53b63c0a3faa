"""Where things are on a step, how much room a scene takes, and who is held."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from physagent_studio.program import PhysicalProgram
from physagent_studio.program.actions import FixObject
from physagent_studio.program.scene.aloft import hangs
from physagent_studio.workbench import Snapshot

Poses = dict[str, tuple[NDArray[np.float64], NDArray[np.float64]]]
"""Object name → position, m, and rotation, wxyz."""


def held_at(snapshot: Snapshot, step: int) -> frozenset[str]:
    """The objects that an action keeps where they are on a step, or that still hang there."""
    rollout, program = snapshot.rollout, snapshot.program
    if rollout is None:
        return frozenset()
    ran = [
        (program.action(span.id), span.start, rollout.steps + 1 if span.end is None else span.end)
        for span in rollout.spans
        if span.start is not None
    ]
    held = {a.name for a, from_, to in ran if isinstance(a, FixObject) and from_ <= step < to}
    moved = {a.name for a, from_, _ in ran if a is not None and from_ <= step}
    return frozenset(held | {o.name for o in program.scene.objects if hangs(o)} - moved)


def poses_at(snapshot: Snapshot, step: int) -> Poses:
    """Position and rotation (wxyz) of every object at a step; as placed where nothing ran."""
    rollout = snapshot.rollout
    poses = {
        item.name: (np.array(item.position), np.array(item.rotation))
        for item in snapshot.program.scene.objects
        if item.position is not None
    }
    if rollout is not None:
        row = min(step, rollout.steps)
        for at, name in enumerate(rollout.objects):
            poses[name] = (rollout.positions[row, at], rollout.rotations[row, at])
    return poses


def centre_and_size(program: PhysicalProgram) -> tuple[NDArray[np.float64], float]:
    """Middle of the objects, world, m, and a length that suits their spread."""
    places = [np.array(o.position) for o in program.scene.objects if o.position is not None]
    if not places:
        return np.zeros(3), 1.0
    points = np.array(places)
    low, high = points.min(axis=0), points.max(axis=0)
    return (low + high) / 2, max(float(np.linalg.norm(high - low)), 0.3)


def small(image: NDArray[np.uint8], longest: int = 640) -> NDArray[np.uint8]:
    """The picture thinned out to at most `longest` pixels a side."""
    stride = max(1, -(-max(image.shape[:2]) // longest))
    return np.ascontiguousarray(image[::stride, ::stride])
