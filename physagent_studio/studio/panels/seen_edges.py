"""The edges of a support as they are seen in the photo, as paths over it."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from physagent_studio.program.scene.camera import Camera
from physagent_studio.program.scene.state import Support
from physagent_studio.records import Mesh
from physagent_studio.studio.scene.outline import edges_of
from physagent_studio.studio.scene.primitives import mesh_of_support

FloatArray = NDArray[np.float64]
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
