"""What the camera sees of meshes: silhouettes, visible faces, depth."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from physagent_studio.arrays import BoolArray, FloatArray
from physagent_studio.program.rotations import matrix_of
from physagent_studio.program.scene.camera import Camera
from physagent_studio.program.scene.state import SceneObject
from physagent_studio.records.scene import Mesh
from physagent_studio.rendering.raster import Lens, rasterise


@dataclass(frozen=True, eq=False, slots=True)
class Seen:
    """Per pixel (H, W): index of the mesh in front or −1; its face; depth in m or inf."""

    owner: NDArray[np.int32]
    face: NDArray[np.int32]
    depth: FloatArray


def in_world(item: SceneObject, mesh: Mesh) -> FloatArray:
    """World vertices (V, 3) of an object's mesh in its place."""
    assert item.position is not None
    return mesh.vertices @ matrix_of(item.rotation).T + np.asarray(item.position)


def look(camera: Camera, bodies: Mapping[str, tuple[FloatArray, NDArray[np.int32]]]) -> Seen:
    """What a camera sees of closed meshes given as world vertices and faces, in their order."""
    width, height = camera.size
    lens = Lens(width, height, camera.focal, *camera.principal)
    owner = np.full(width * height, -1, np.int32)
    face = np.full(width * height, -1, np.int32)
    depth = np.full(width * height, np.inf)
    turn, eye = camera.matrix, np.asarray(camera.position)
    for index, (vertices, faces) in enumerate(bodies.values()):
        local = (vertices - eye) @ turn
        hits = rasterise(local, faces, lens, np.ones(len(faces), bool))
        front = hits.depth < depth[hits.pixel]
        pixel = hits.pixel[front]
        owner[pixel] = index
        face[pixel] = hits.face[front]
        depth[pixel] = hits.depth[front]
    shape = (height, width)
    return Seen(owner.reshape(shape), face.reshape(shape), depth.reshape(shape))


def silhouette(camera: Camera, vertices: FloatArray, faces: NDArray[np.int32]) -> BoolArray:
    """(H, W) the pixels that a mesh covers."""
    return np.asarray(look(camera, {"": (vertices, faces)}).owner >= 0)
