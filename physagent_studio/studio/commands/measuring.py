"""How far two points of the photo are apart in the scene: on things, on supports, on the ground."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray
from pydantic import JsonValue

from physagent_studio.errors import InputError
from physagent_studio.program.base import Pixel
from physagent_studio.program.rotations import matrix_of
from physagent_studio.program.scene.forms import Floor
from physagent_studio.studio.commands.asking import asked
from physagent_studio.workbench import Snapshot

if TYPE_CHECKING:
    from physagent_studio.studio.studio import Studio

FloatArray = NDArray[np.float64]
GRAZING = 1e-12
"""Determinant below which a ray runs along a face and meets it nowhere."""


@asked("measure", "look")
def measure(studio: Studio, browser: int, a: Pixel, b: Pixel) -> None:
    """How far two pixels of the photo are apart in the scene, metres; nothing is changed."""
    apart = point_at(studio.snapshot, b) - point_at(studio.snapshot, a)
    told: JsonValue = {
        "metres": round(float(np.linalg.norm(apart)), 4),
        "up": round(float(apart[2]), 4),
        "along": round(float(np.linalg.norm(apart[:2])), 4),
    }
    studio.tell(browser, "measured", told)


def point_at(snapshot: Snapshot, pixel: tuple[float, float]) -> FloatArray:
    """The first point (3,) of the scene at its start that a pixel of the photo shows, world, m."""
    camera = snapshot.program.scene.camera
    if camera is None:
        raise InputError("there is no scene yet to measure in")
    eye, ray = np.array(camera.position), camera.rays(np.array([pixel], float))[0]
    near = min(_distances(snapshot, eye, ray), default=np.inf)
    if not np.isfinite(near):
        raise InputError("there is nothing but sky at that point; click on a thing or the ground")
    return eye + near * ray


def _distances(snapshot: Snapshot, eye: FloatArray, ray: FloatArray) -> Iterator[float]:
    """How many times the ray reaches what it meets."""
    scene, state = snapshot.scene, snapshot.program.scene
    for item in state.objects:
        mesh = scene.meshes.get(item.name) if scene else None
        if mesh is not None and item.position is not None:
            turn = matrix_of(item.rotation)
            here = (eye - np.array(item.position)) @ turn
            yield from _hits(mesh.vertices[mesh.faces], here, ray @ turn)
    for mesh in scene.support_meshes.values() if scene else ():
        yield from _hits(mesh.vertices[mesh.faces], eye, ray)
    for support in state.supports:
        if isinstance(support.shape, Floor) and ray[2] < 0:
            yield float((support.shape.height - eye[2]) / ray[2])


def _hits(corners: FloatArray, eye: FloatArray, ray: FloatArray) -> Iterator[float]:
    """Where a ray meets triangles (N, 3, 3). Möller and Trumbore, 1997."""
    first, second = corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]
    across = np.cross(ray, second)
    size = np.einsum("ij,ij->i", first, across)
    flat = np.abs(size) < GRAZING
    inverse = 1.0 / np.where(flat, 1.0, size)
    away = eye - corners[:, 0]
    u = np.einsum("ij,ij->i", away, across) * inverse
    over = np.cross(away, first)
    v = (over @ ray) * inverse
    share = np.einsum("ij,ij->i", second, over) * inverse
    met = ~flat & (u >= 0) & (v >= 0) & (u + v <= 1) & (share > 0)
    yield from share[met].tolist()
