"""Openings that a body laid out from its outline would close: what projects beside is not drawn."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from physagent_studio.program.scene.state import SceneObject
from physagent_studio.reconstruction.photo.regions import BoolArray, iou
from physagent_studio.reconstruction.shapes.silhouettes import in_world
from physagent_studio.reconstruction.switches import at_work
from physagent_studio.reconstruction.texture.outline_fitting import (
    FITTING,
    FloatArray,
    Sight,
    looked_up,
)
from physagent_studio.records.scene import Mesh

CARVED = ("inflated",)
"""Kinds made from the outline of a mask, which fill what it leaves open. What is turned about an
axis has no openings, and would be torn at its far rim."""


def carved(sight: Sight, item: SceneObject, mesh: Mesh) -> Mesh:
    """The mesh (body frame) without what would cover the openings that the mask shows.

    A body laid out deep from its silhouette closes them behind: legs, spokes, a backrest. What
    projects beside the mask at the first pose, front and back, is not drawn; it still collides.
    """
    if item.shape is None or item.shape.kind not in CARVED or not at_work("outline carving"):
        return mesh
    told = sight.mask | ~sight.free
    finer = mesh
    max_halvings = 4  # count, 1..8: of a face across the mask's outline; each doubles the work
    for _ in range(max_halvings):
        pixels = sight.camera.project(in_world(item, finer))[0]
        finer = _halved(finer, _across(told, pixels, finer.faces))
    world = in_world(item, finer)
    kept = looked_up(told, sight.camera.project(world)[0][finer.faces].mean(axis=1))
    mask = sight.mask & sight.free
    before, after = (iou(sight.drawn(world, f), mask) for f in (finer.faces, finer.faces[kept]))
    return replace(finer, faces=finer.faces[kept]) if after > before + FITTING.min_gain else mesh


def _across(told: BoolArray, pixels: FloatArray, faces: NDArray[np.int32]) -> BoolArray:
    """(F,) which faces lie across the border of a region and are more than a pixel or two wide."""
    corners = pixels[faces]
    spots = np.concatenate([corners, (corners + np.roll(corners, 1, axis=1)) / 2], axis=1)
    inside = looked_up(told, spots.reshape(-1, 2)).reshape(spots.shape[:2])
    fine_px = 1.5  # 0.5..4: faces with shorter edges are not divided any more
    wide = np.linalg.norm(corners - np.roll(corners, 1, axis=1), axis=2).max(axis=1) > fine_px
    return np.asarray(inside.any(axis=1) & ~inside.all(axis=1) & wide)


def _halved(mesh: Mesh, which: BoolArray) -> Mesh:
    """The mesh with each of these faces (F,) as four; what lies beside them stays whole."""
    old = mesh.faces[which]
    middles = (mesh.vertices[old] + mesh.vertices[np.roll(old, -1, axis=1)]) / 2
    ab, bc, ca = (len(mesh.vertices) + np.arange(3 * len(old)).reshape(-1, 3)).T
    a, b, c = old.T
    four = np.stack([[a, ab, ca], [ab, b, bc], [ca, bc, c], [ab, bc, ca]]).transpose(0, 2, 1)
    return replace(
        mesh,
        vertices=np.vstack([mesh.vertices, middles.reshape(-1, 3)]),
        faces=np.vstack([mesh.faces[~which], four.reshape(-1, 3)]).astype(np.int32),
    )
