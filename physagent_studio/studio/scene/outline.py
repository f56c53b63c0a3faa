"""The edges of a mesh that a draughtsman would draw."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from physagent_studio.records import Mesh


def edges_of(mesh: Mesh, angle: float = 25.0) -> NDArray[np.float64]:
    """(E, 2, 3) segments where two faces meet at more than `angle` degrees, or only one is."""
    corners = np.unique(mesh.vertices.round(9), axis=0, return_inverse=True)
    points, index = corners[0], corners[1].reshape(-1)
    faces = index[mesh.faces]
    a, b, c = (points[faces[:, i]] for i in range(3))
    normals = np.cross(b - a, c - a)
    normals /= np.maximum(np.linalg.norm(normals, axis=1, keepdims=True), 1e-20)
    found: dict[tuple[int, int], list[int]] = {}
    for face, (i, j, k) in enumerate(faces):
        for edge in ((i, j), (j, k), (k, i)):
            found.setdefault((min(edge), max(edge)), []).append(face)
    limit = np.cos(np.radians(angle))
    sharp = [
        edge
        for edge, sides in found.items()
        if len(sides) != 2 or normals[sides[0]] @ normals[sides[1]] < limit
    ]
    if not sharp:
        return np.zeros((0, 2, 3))
    return points[np.array(sharp)]
