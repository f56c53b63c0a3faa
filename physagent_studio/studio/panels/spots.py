"""Where new things go: beside what is there on the ground, or free on the chosen support."""

from __future__ import annotations

import itertools
from dataclasses import dataclass

import numpy as np

from physagent_studio.program import PhysicalProgram, Support
from physagent_studio.program.rotations import about_up, matrix_of
from physagent_studio.program.scene import Floor, Slab
from physagent_studio.program.shapes import outline_of
from physagent_studio.studio.view import Selection

GRID = (-0.8, -0.4, 0.0, 0.4, 0.8)
"""Places on a top that are looked at, in halves of its length and width from its middle."""


@dataclass(frozen=True, slots=True)
class Spot:
    """A free place: `foot` on its ground, world, m; what lies there; the usual size, m."""

    foot: tuple[float, float, float]
    on: str | None
    size: float


def spot_of(program: PhysicalProgram, selection: Selection) -> Spot:
    """On top of the selected table where there is one, else beside everything on the ground."""
    beside = _beside(program)
    chosen = program.scene.support(selection.name) if selection.kind == "support" else None
    if chosen is None or not isinstance(chosen.shape, Slab):
        return beside
    return Spot(_free_on(program, chosen, chosen.shape), chosen.name, beside.size)


def ground_spot(program: PhysicalProgram) -> Spot:
    """Beside everything on the ground, whatever is selected: where new supports go."""
    return _beside(program)


def _beside(program: PhysicalProgram) -> Spot:
    scene = program.scene
    floors = [
        (one.shape.height, one.name) for one in scene.supports if isinstance(one.shape, Floor)
    ]
    ground, on = min(floors, default=(0.0, None))
    whole = [o for o in scene.objects if o.shape is not None and o.position is not None]
    if not whole:
        return Spot((0.0, 1.5, ground), on, 0.2)
    sizes = np.array([outline_of(o.shape).size for o in whole if o.shape is not None])
    places = np.array([o.position for o in whole])
    size = float(np.median(sizes.max(axis=1)))
    x = round(float((places + sizes / 2)[:, 0].max()) + size, 4)
    return Spot((x, round(float(places[:, 1].mean()), 4), ground), on, float(f"{size:.3g}"))


def _free_on(program: PhysicalProgram, support: Support, shape: Slab) -> tuple[float, float, float]:
    """The place on a top that is farthest from everything, of a few."""
    turn = matrix_of(about_up(shape.yaw))
    half, middle = np.array(shape.size) / 2, np.array(shape.position)
    steps = np.array(list(itertools.product(GRID, GRID)))
    places = middle + np.column_stack([steps * half[:2], np.full(len(steps), half[2])]) @ turn.T
    others = [
        (np.array(one.position[:2]), float(outline_of(one.shape).size.max()) / 2)
        for one in program.scene.objects
        if one.shape is not None and one.position is not None
    ]
    # Nearer the middle where all are as free, so that it does not start on an edge.
    room = -1e-3 * np.linalg.norm(steps, axis=1)
    if others:
        gaps = [np.linalg.norm(places[:, :2] - place, axis=1) - reach for place, reach in others]
        room += np.minimum(np.min(gaps, axis=0), half[:2].max() / 2)
    x, y, z = (round(float(part), 4) for part in places[int(np.argmax(room))])
    return x, y, z
