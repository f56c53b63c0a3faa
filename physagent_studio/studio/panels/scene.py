"""Scene: switches of the 3D view, and what the reconstruction found."""

from __future__ import annotations

from typing import Any

import numpy as np

from physagent_studio.program import PhysicalProgram
from physagent_studio.program.scene import Floor
from physagent_studio.program.shapes import outline_of
from physagent_studio.studio.panels.words import number
from physagent_studio.studio.view import View
from physagent_studio.workbench import Snapshot

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
    ("gizmo", "Handle to move the selection"),
)


def spot_of(program: PhysicalProgram) -> dict[str, Any]:
    """Where new things go: beside what is there, on the ground, and of its size, m."""
    whole = [o for o in program.scene.objects if o.shape is not None and o.position is not None]
    if not whole:
        return {"x": 0.0, "y": 1.5, "ground": 0.0, "size": 0.2}
    sizes = np.array([outline_of(o.shape).size for o in whole if o.shape is not None])
    places = np.array([o.position for o in whole])
    size = float(np.median(sizes.max(axis=1)))
    floors = [s.shape.height for s in program.scene.supports if isinstance(s.shape, Floor)]
    return {
        "x": round(float((places + sizes / 2)[:, 0].max()) + size, 4),
        "y": round(float(places[:, 1].mean()), 4),
        "ground": min(floors, default=0.0),
        "size": float(f"{size:.3g}"),
    }


def state_of(snapshot: Snapshot, view: View) -> dict[str, Any]:
    """Switches and findings."""
    scene = snapshot.scene
    camera = snapshot.program.scene.camera
    return {
        "switches": [
            {"what": what, "text": text, "on": what in view.shown} for what, text in SWITCHES
        ],
        "things": [
            {"kind": "object", "name": item.name, "material": item.material}
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
        else [{"ok": one.ok, "text": one.text, "subject": one.subject} for one in scene.findings],
        "spot": spot_of(snapshot.program),
        "readOnly": snapshot.read_only or snapshot.session_id is None,
        "flags": list(snapshot.program.scene.flags),
    }
