"""Photo: the picture with its objects outlined, what was clicked, horizon and the sentence."""

from __future__ import annotations

import math
from typing import Any

from physagent_studio.knowledge import support_kind
from physagent_studio.program.scene.state import SceneObject, Support
from physagent_studio.studio.first_scene import marked
from physagent_studio.studio.guesses import Spot, stale_spots, without_stale
from physagent_studio.studio.panels.goings import ways_of
from physagent_studio.studio.panels.outline import path_of
from physagent_studio.studio.panels.seen_edges import seen_edges
from physagent_studio.studio.scene.colours import own_colours
from physagent_studio.workbench import Snapshot
from physagent_studio.workbench.photo_edits import forms_of


def state_of(snapshot: Snapshot) -> dict[str, Any]:
    """Address and size of the picture, outlines and groundings in its pixels."""
    case, scene = snapshot.case, snapshot.scene
    image = None if case is None else case.image
    if image is None:
        return {
            "session": snapshot.session_id,
            "image": None,
            "prompt": snapshot.program.event.prompt,
        }
    assert case is not None
    state = marked(snapshot)
    camera = state.camera
    masks = {} if scene is None else scene.masks
    looks = {} if scene is None else scene.meshes
    colours = own_colours([item.name for item in state.objects], looks)
    stale = stale_spots(case, state)
    return {
        "session": snapshot.session_id,
        "image": f"photo/{case.image_hash}.jpg",
        "size": [image.shape[1], image.shape[0]],
        "seen": scene is not None,
        "prompt": snapshot.program.event.prompt or case.prompt,
        "readOnly": snapshot.read_only,
        "horizon": None if camera is None else round(camera.horizon, 2),
        "roll": 0.0 if camera is None else round(math.degrees(camera.roll), 2),
        "horizonBy": _horizon_by(snapshot),
        "scale": state.scale.model_dump(mode="json"),
        "objects": [
            {
                **_grounded(item, stale),
                "colour": colours[item.name],
                "path": path_of(masks[item.name]) if item.name in masks else "",
                "shape": item.form or (item.shape.kind if item.shape is not None else ""),
                **_shapes(item.name, snapshot),
                "ways": ways_of(item, snapshot),
            }
            for item in state.objects
        ],
        "supports": [
            {
                **_grounded(item, stale),
                "ramp": support_kind(item.name) == "ramp",
                **(_edges(item, snapshot) if _placed(item) else {"placed": False}),
            }
            for item in state.supports
        ],
    }


def _shapes(name: str, snapshot: Snapshot) -> dict[str, Any]:
    """The kinds of shape to switch to, the best first, and how each covers the mask, percent."""
    scene = snapshot.scene
    offers = () if scene is None else scene.shapes.get(name, ())
    return {
        "shapes": forms_of(name, snapshot.program.event.prompt, offers),
        "covers": {offer.kind: round(100 * offer.iou) for offer in offers},
    }


def _placed(item: Support) -> bool:
    """Whether it was put where it is by hand, or can be by the ramp's tool."""
    said = item.grounding
    return bool(said.points or said.marks) or support_kind(item.name) == "ramp"


def _edges(item: Support, snapshot: Snapshot) -> dict[str, Any]:
    meshes = {} if snapshot.scene is None else snapshot.scene.support_meshes
    camera = snapshot.program.scene.camera
    return {"placed": True, **seen_edges(item, camera, meshes.get(item.name))}


def _grounded(item: SceneObject | Support, stale: set[Spot]) -> dict[str, Any]:
    said = without_stale(item.grounding, stale)
    return {"name": item.name, "grounding": said.model_dump(mode="json")}


def _horizon_by(snapshot: Snapshot) -> str:
    """Who says where the horizon is, in words."""
    camera = snapshot.program.scene.camera
    if camera is None:
        return ""
    if camera.source == "person":
        return "set by you"
    if camera.confirmed:
        return "given"
    return f"estimated, ± {camera.horizon_sigma or 0:.0f} px"
