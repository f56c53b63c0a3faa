"""Meshes of objects whose shape is stated: from their numbers, or a stored mesh of their size."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from physagent_studio.errors import InputError
from physagent_studio.program.scene.state import Meshed, SceneObject
from physagent_studio.reconstruction.shapes.meshes import mesh_of
from physagent_studio.records.scene import Mesh


def stated_mesh(item: SceneObject, assets: Mapping[str, Mesh]) -> Mesh:
    """The mesh of an object with a shape, body frame, m.

    assets: stored meshes by what `Meshed.asset` names; one is stretched along its axes to the
    size that the shape states, which keeps its centre of mass at the origin.
    Raises InputError for a mesh that is not stored here.
    """
    assert item.shape is not None
    if not isinstance(item.shape, Meshed):
        return mesh_of(item.shape)
    stored = assets.get(item.shape.asset)
    if stored is None:
        raise InputError(
            f"the mesh of '{item.name}' ({item.shape.asset[:12]}…) is not kept here; "
            "add its file to the scene again"
        )
    return stretched(stored, item.shape.size)


def stretched(mesh: Mesh, size: tuple[float, float, float]) -> Mesh:
    """The mesh whose bounding box has that size, m."""
    factors = np.array(size) / np.maximum(np.ptp(mesh.vertices, axis=0), 1e-12)
    if np.allclose(factors, 1.0, rtol=1e-9):
        return mesh
    return replace(mesh, vertices=mesh.vertices * factors)
