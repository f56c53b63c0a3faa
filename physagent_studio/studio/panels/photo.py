"""Photo: the picture with its objects outlined, what was clicked, horizon and the sentence; where
things are told to go, and the edges of supports, as paths over it."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from physagent_studio.arrays import FloatArray
from physagent_studio.knowledge import support_kind
from physagent_studio.program.scene.aloft import in_air
from physagent_studio.program.scene.camera import Camera
from physagent_studio.program.scene.state import SceneObject, Support
from physagent_studio.records import Mesh
from physagent_studio.studio.first_scene import Spot, marked, stale_spots, without_stale
from physagent_studio.studio.panels.outline import path_of
from physagent_studio.studio.scene.arrows import vector_of
from physagent_studio.studio.scene.places import own_colours
from physagent_studio.studio.scene.primitives import edges_of, mesh_of_support
from physagent_studio.workbench import Snapshot
from physagent_studio.workbench.aloft_edits import foot_of
from physagent_studio.workbench.photo_edits import forms_of

LONG = 0.3
"""Length of an arrow, as a part of the distance from the camera."""


def ways_of(item: SceneObject, snapshot: Snapshot) -> dict[str, Any] | None:
    """Pixels of a thing and of the tips of its arrows; None where the camera does not see it."""
    camera, place = snapshot.program.scene.camera, item.position
    if camera is None or place is None:
        return None
    middle = np.array(place)
    reach = LONG * float(np.linalg.norm(middle - np.array(camera.position)))

    def pixel(point: FloatArray) -> list[float] | None:
        pixels, depth = camera.project(point[None])
        return [round(float(part), 1) for part in pixels[0]] if depth[0] > 0 else None

    at = pixel(middle)
    if at is None:
        return None
    foot = foot_of(snapshot.program.scene, item) if in_air(item) else None
    goes, heading = _driven(item, snapshot), item.wheels.heading if item.wheels else None
    front = None if heading is None else _level(math.radians(heading))
    return {
        "at": at,
        "goes": None if goes is None else pixel(middle + reach * goes),
        "ground": None if foot is None else pixel(foot[0]),
        "front": None if front is None else pixel(middle + reach * front),
    }


def _driven(item: SceneObject, snapshot: Snapshot) -> FloatArray | None:
    """The level direction of what first drives a thing; None where nothing does."""
    for action in snapshot.program.event.actions:
        value = getattr(action, "force", None) or getattr(action, "velocity", None)
        if action.name != item.name or value is None or action.muted:
            continue
        way = vector_of(value, snapshot, np.array(item.position, float), np.zeros(3), 1.0)
        flat = 0.0 if way is None else math.hypot(way[0], way[1])
        if way is not None and flat > 0:
            return np.array([way[0] / flat, way[1] / flat, 0.0])
    return None


def _level(angle: float) -> FloatArray:
    return np.array([math.cos(angle), math.sin(angle), 0.0])


NEAR = 0.01
"""What is nearer to the camera is cut off, as a share of how far its farthest corner is."""


def seen_edges(item: Support, camera: Camera | None, given: Mesh | None = None) -> dict[str, str]:
    """`path`, the edges, and `area`, what they enclose: SVG paths, pixels; empty without a shape.

    given: the mesh in the world, m, of a support whose shape is a mesh file's. Only faces that
    look at the camera count; what hides them does not.
    """
    mesh = mesh_of_support(item) or given
    if mesh is None or camera is None or item.shape is None or item.shape.kind in ("floor", "wall"):
        return {"path": "", "area": ""}
    corners = mesh.vertices[mesh.faces]
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    facing = np.einsum("ij,ij->i", normals, np.array(camera.position) - corners[:, 0]) > 0
    front = Mesh(mesh.vertices, mesh.faces[facing])
    edges = [_in_picture(line, camera) for line in edges_of(front)] if facing.any() else []
    faces = [_in_picture(face, camera) for face in corners[facing]]
    return {
        "path": "".join("M" + _text(line) for line in edges if len(line) == 2),
        "area": "".join("M" + _text(face) + "Z" for face in faces if len(face) > 2),
    }


def _in_picture(points: FloatArray, camera: Camera) -> FloatArray:
    """Pixels (M, 2) of a line or a face (N, 3), m, as far as it is before the camera."""
    depth = camera.project(points)[1]
    least = max(float(depth.max()), 0.0) * NEAR + 1e-9
    kept = []
    count = len(points)
    for start in range(count):
        end = (start + 1) % count
        if depth[start] >= least:
            kept.append(points[start])
        if (depth[start] >= least) != (depth[end] >= least) and (count > 2 or start == 0):
            share = (least - depth[start]) / (depth[end] - depth[start])
            kept.append(points[start] + share * (points[end] - points[start]))
    return camera.project(np.array(kept))[0] if kept else np.zeros((0, 2))


def _text(pixels: FloatArray) -> str:
    return "L".join(f"{x:.1f} {y:.1f}" for x, y in pixels)


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
