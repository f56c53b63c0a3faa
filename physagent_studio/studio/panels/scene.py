"""Scene: switches of the 3D view, and what the reconstruction found."""

from __future__ import annotations

from typing import Any

from physagent_studio.records import LearnedUse
from physagent_studio.studio.panels.spots import Spot, ground_spot, spot_of
from physagent_studio.studio.panels.words import number, speaker
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
