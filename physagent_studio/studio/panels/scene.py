"""Scene: switches of the 3D view, what the reconstruction found, and where new things go: beside
what is there on the ground, or free on the chosen support."""

from __future__ import annotations

import itertools
from collections import Counter
from dataclasses import dataclass
from typing import Any

import numpy as np

from physagent_studio.arrays import FloatArray
from physagent_studio.program import PhysicalProgram, Support
from physagent_studio.program.rotations import about_up, matrix_of
from physagent_studio.program.scene.shapes import outline_of
from physagent_studio.program.scene.state import Floor, Ramp, SceneState, Slab, Vessel
from physagent_studio.records import LearnedUse
from physagent_studio.studio.panels.words import number, speaker
from physagent_studio.studio.view import Selection, View
from physagent_studio.workbench import Snapshot

GRID = (-0.8, -0.4, 0.0, 0.4, 0.8)
"""Places on a top that are looked at, in halves of its length and width from its middle."""


@dataclass(frozen=True, slots=True)
class Spot:
    """A free place: `foot` on its ground, world, m; what lies there; the usual size, m."""

    foot: tuple[float, float, float]
    on: str | None
    size: float


def spot_of(program: PhysicalProgram, selection: Selection) -> Spot:
    """On the table that is selected or carries most things, else beside all on the ground."""
    beside = _beside(program)
    chosen = program.scene.support(selection.name) if selection.kind == "support" else None
    if chosen is None:
        carry = Counter(one.support for one in program.scene.objects if one.support)
        most = next((name for name, _ in carry.most_common(1)), "")
        chosen = program.scene.support(most or "")
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
    y = float(places[:, 1].mean())
    x = _clear_of(scene, float((places + sizes / 2)[:, 0].max()) + size, y, size)
    return Spot((round(x, 4), round(y, 4), ground), on, float(f"{size:.3g}"))


def _clear_of(scene: SceneState, x: float, y: float, size: float) -> float:
    """x, m, or as far to the right of it as no table and no ramp is in the way."""
    shapes = [one.shape for one in scene.supports]
    blocks = [_footprint(one) for one in shapes if isinstance(one, Slab | Ramp | Vessel)]
    for low, high in sorted(blocks, key=lambda block: float(block[0][0])):
        beside_it = low[1] - size < y < high[1] + size
        if beside_it and low[0] - size < x < high[0] + size:
            x = float(high[0]) + size
    return x


def _footprint(shape: Slab | Ramp | Vessel) -> tuple[FloatArray, FloatArray]:
    """Lowest and highest x and y of a support, m."""
    if isinstance(shape, Slab | Vessel):
        edges = shape.size if isinstance(shape, Slab) else outline_of(shape.body).size
        half = np.array(edges[:2]) / 2
        corners, place = np.array([[-1, -1], [1, -1], [1, 1], [-1, 1]]) * half, shape.position
    else:
        length, side = shape.run + shape.plateau, shape.width / 2
        corners = np.array([[0, -side], [length, -side], [length, side], [0, side]])
        place = shape.toe
    turned = corners @ matrix_of(about_up(shape.yaw))[:2, :2].T + np.array(place[:2])
    return turned.min(axis=0), turned.max(axis=0)


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


SWITCHES = (
    ("photo", "Photo behind"),
    ("supports", "Ground and supports"),
    ("labels", "Names"),
    ("trails", "Paths"),
    ("ghosts", "Ghosts of other rounds"),
    ("forces", "Forces and velocities"),
    ("contacts", "Contacts"),
    ("centres", "Centres of mass"),
    ("collisions", "What collides"),
    ("frustum", "Camera"),
    ("gravity", "Gravity"),
    ("axes", "Axes"),
    ("clean", "The clip alone while it plays"),
    ("gizmo", "Handle to move the selection"),
)


def _written(spot: Spot) -> dict[str, Any]:
    x, y, ground = spot.foot
    return {"x": x, "y": y, "ground": ground, "on": spot.on, "size": spot.size}


def _use(one: LearnedUse) -> str:
    """What a learned model did, in a sentence."""
    if one.failed:
        return f"{one.model} is not used: {one.failed}"
    return f"{one.model} made: {', '.join(one.made) or 'nothing that is shown'}"


def state_of(snapshot: Snapshot, view: View) -> dict[str, Any]:
    """Switches and findings."""
    scene = snapshot.scene
    camera = snapshot.program.scene.camera
    speak = speaker(snapshot.program)
    return {
        "switches": [
            {"what": what, "text": text, "on": what in view.shown} for what, text in SWITCHES
        ],
        "things": [
            {
                "kind": "object",
                "name": item.name,
                "material": item.material,
                "hidden": item.name in view.hidden,
            }
            for item in snapshot.program.scene.objects
        ]
        + [
            {"kind": "support", "name": item.name, "material": item.material}
            for item in snapshot.program.scene.supports
        ]
        + [
            {"kind": "landmark", "name": item.name, "material": item.kind}
            for item in snapshot.program.scene.landmarks
        ],
        "camera": None
        if camera is None
        else {
            "text": f"{number(camera.position[2])} m above the ground, horizon at row "
            f"{number(camera.horizon)}, {camera.source}",
        },
        "findings": []
        if scene is None
        else [
            {"ok": one.ok, "text": speak(one.text), "subject": one.subject}
            for one in scene.findings
        ],
        "spot": _written(spot_of(snapshot.program, view.selection)),
        "groundSpot": _written(ground_spot(snapshot.program)),
        "readOnly": snapshot.read_only or snapshot.session_id is None,
        "learned": [] if scene is None else [_use(one) for one in scene.learned],
        "flags": [speak(one) for one in snapshot.program.scene.flags],
    }
