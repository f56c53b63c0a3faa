"""Stems, handles and leaves: what a silhouette shows beside the body, joined to the body's look.

The body keeps its shape, so that it weighs, rolls and collides as that; the parts are drawn
with it. They lie on the upright plane through its middle, as thick as they are thin in the picture.
"""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np

from physagent_studio.knowledge.things import Usual
from physagent_studio.program.rotations import matrix_of
from physagent_studio.program.scene.camera import Camera
from physagent_studio.program.scene.state import SceneObject
from physagent_studio.reconstruction.photo.regions import BoolArray, bounds
from physagent_studio.reconstruction.shapes.inflation import sheet_on_plane
from physagent_studio.reconstruction.shapes.meshes import one_surface
from physagent_studio.reconstruction.shapes.silhouettes import in_world, silhouette
from physagent_studio.reconstruction.switches import at_work
from physagent_studio.records.scene import Mesh


@dataclass(frozen=True, slots=True)
class StemSettings:
    """Which parts beside a body are drawn with it."""

    min_area_share: float = 0.003  # 0..0.02: of the mask; smaller parts are its ragged rim
    max_area_share: float = 0.3  # 0.1..0.6: of the mask; larger, the body is another one than shown
    min_reach_share: float = 0.03  # 0.005..0.1: of the longer side, that a part sticks out
    # 0..0.4: of the silhouette from below: shadows and reflections are there
    foot_share: float = 0.15


STEM = StemSettings()

WITH_PARTS = frozenset(
    ["sphere", "ellipsoid", "box", "cylinder", "capsule", "frustum", "revolved", "torus"]
)
"""Kinds that leave parts out; a body made from the mask itself has them in it."""


def with_parts(
    camera: Camera, mask: BoolArray, item: SceneObject, mesh: Mesh, usual: Usual
) -> Mesh:
    """The mesh (body frame) joined with the parts that the mask (H, W) shows beside it.

    usual: what its name says. What is known to have one form alone, a ball or a block, has no
    parts: what sticks out there is something else than the thing.
    """
    if not at_work("stems"):
        return mesh
    kind = item.shape.kind if item.shape is not None else None
    if kind not in WITH_PARTS or usual.shapes == (kind,) or not mask.any():
        return mesh
    body = silhouette(camera, in_world(item, mesh), mesh.faces)
    found = blobs(mask, body)
    parts = [(mesh.vertices, mesh.faces)]
    low = float(in_world(item, mesh)[:, 2].min())
    turn, place = matrix_of(item.rotation), np.asarray(item.position)
    for blob in found:
        world, triangles = sheet_on_plane(blob, camera, place)
        # What stands on the ground does not reach into it with its parts.
        world[:, 2] = np.maximum(world[:, 2], low)
        parts.append(((world - place) @ turn, triangles.astype(np.int32)))
    return Mesh(*one_surface(parts), color=mesh.color) if found else mesh


def blobs(mask: BoolArray, body: BoolArray) -> list[BoolArray]:
    """The parts of a mask beside a body (H, W), each reaching a little into it."""
    x0, y0, x1, y1 = bounds(mask)
    side = max(x1 - x0, y1 - y0)
    beside = (mask & ~body).astype(np.uint8)
    if np.count_nonzero(beside) > STEM.max_area_share * np.count_nonzero(mask) or not body.any():
        return []
    away = cv2.distanceTransform((~body).astype(np.uint8), cv2.DIST_L2, 5)
    # A rim of a pixel or two all around is no part, and would join those that are.
    rim = max(1.5, 0.006 * side)
    count, labels, stats, centres = cv2.connectedComponentsWithStats(beside * (away > rim))
    low = y1 - STEM.foot_share * (y1 - y0)
    out = []
    for label in range(1, count):
        own = labels == label
        large = stats[label, cv2.CC_STAT_AREA] >= STEM.min_area_share * np.count_nonzero(mask)
        if large and away[own].max() >= STEM.min_reach_share * side and centres[label][1] < low:
            reach = 2 * int(np.ceil(rim)) + 5
            kernel = cv2.getStructuringElement(cv2.MORPH_ELLIPSE, (reach, reach))
            out.append((cv2.dilate(own.astype(np.uint8), kernel) > 0) & mask)
    return out
