"""What the mask shows of a thing and its body does not: openings, and parts that stand off.

Looks alone: what is cut out of what is drawn, or added to it, collides as before.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import cv2
import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import map_coordinates

from physagent_studio.program.rotations import matrix_of
from physagent_studio.program.scene.state import Inflated, SceneObject
from physagent_studio.reconstruction.photo.regions import BoolArray, grow, iou
from physagent_studio.reconstruction.shapes.inflation import sheet_on_level, sheet_on_plane
from physagent_studio.reconstruction.shapes.meshes import one_surface
from physagent_studio.reconstruction.shapes.silhouettes import in_world
from physagent_studio.reconstruction.switches import at_work
from physagent_studio.reconstruction.texture.outline_fitting import (
    FITTING,
    FLAT,
    LEFT,
    WHOLE,
    FloatArray,
    Sight,
)
from physagent_studio.records.scene import Mesh

CARVED = ("inflated",)
"""Kinds made from the outline of a mask, which fill what it leaves open. What is turned about an
axis has no openings, and would be torn at its far rim."""


SMOOTH = (*WHOLE, *LEFT, *FLAT)
"""Kinds that have no parts beside them: what a mask shows beside a ball or a box is wrong."""


@dataclass(frozen=True, slots=True)
class PartSettings:
    """Which parts of a mask are drawn that the body leaves out."""

    enough_iou: float = 0.97  # IoU, 0.9..1: with its mask, from which nothing is missing
    # 0.001..0.05: of the mask: smaller parts beside the body are its rough rim
    min_share: float = 0.004
    # 0.0005..0.05: of the mask: smaller openings are its rim
    min_open_share: float = 0.002
    # IoU, 0.9..1: with its mask, that is enough with the rim left whole
    rim_iou: float = 0.97
    # IoU, 0..0.05: with its mask, that may be lost with the rim left whole
    max_rim_loss: float = 0.012
    # IoU, 0.6..0.95: with its mask, below which what is laid out deep is mostly openings
    open_iou: float = 0.85
    # IoU, 0..0.1: that a sheet may lose to what is cut open: spokes and wires are too thin for one
    max_sheet_loss: float = 0.04
    # 0.6..0.95: of the mask, that what has openings covers: what was moved by hand covers less
    min_shown_share: float = 0.8
    overlap_px: int = 2  # 0..6: by which a part goes on into what is drawn


PART = PartSettings()


def carved(sight: Sight, item: SceneObject, mesh: Mesh) -> Mesh:
    """The mesh (body frame) without what would cover the openings that the mask shows.

    A body laid out deep from its silhouette closes them behind: legs, spokes, a backrest. What
    projects beside the mask at the first pose, front and back, is not drawn; it still collides.
    Where that is much of it, shreds would be left: then the mask itself is drawn as a round sheet.
    """
    if item.shape is None or item.shape.kind not in CARVED or not at_work("outline carving"):
        return mesh
    mask, drawn = sight.mask & sight.free, sight.drawn(in_world(item, mesh), mesh.faces)
    if np.count_nonzero(mask & drawn) < PART.min_shown_share * np.count_nonzero(mask):
        return mesh
    cut, covers = _cut_open(sight, item, mesh)
    if iou(drawn, mask) < PART.open_iou:
        sheet, seen = _cut_open(sight, item, _laid(sight, item, mask, in_world(item, mesh)))
        return sheet if seen > covers - PART.max_sheet_loss else cut
    return cut


def _cut_open(sight: Sight, item: SceneObject, mesh: Mesh) -> tuple[Mesh, float]:
    """The mesh without the faces that project beside the mask, where that covers it better, and
    its IoU with it."""
    told = sight.mask | ~sight.free
    finer = mesh
    max_halvings = 5  # count, 1..8: of a face across the mask's outline; each doubles the work
    for _ in range(max_halvings):
        pixels = sight.camera.project(in_world(item, finer))[0]
        finer = _halved(finer, _across(told, pixels, finer.faces))
    world, mask = in_world(item, finer), sight.mask & sight.free
    middles = sight.camera.project(world)[0][finer.faces].mean(axis=1)
    beside = sight.drawn(world, finer.faces) & ~told
    wide = grow(_wide_parts(beside, PART.min_open_share * np.count_nonzero(mask)), 2)
    kept = [_within(told, middles), _within(told | ~wide, middles)]
    every = [finer.faces, *(finer.faces[one] for one in kept)]
    before, after, least = (iou(sight.drawn(world, faces), mask) for faces in every)
    if least > min(PART.rim_iou, after - PART.max_rim_loss):
        # Without its rim front and back would come apart.
        every[1], after = every[2], least
    if after > before + FITTING.min_gain:
        return replace(finer, faces=every[1]), after
    return mesh, before


def with_parts(sight: Sight, item: SceneObject, mesh: Mesh) -> Mesh:
    """The mesh (body frame) with what the mask shows beside it: handles, legs, ears.

    They are round sheets on the upright plane through its middle, or as near as the ground lets
    them be: what a body of one simple form has no place for.
    """
    if item.shape is None or item.shape.kind in SMOOTH or not at_work("parts beside"):
        return mesh
    world, mask = in_world(item, mesh), sight.mask & sight.free
    drawn = sight.drawn(world, mesh.faces)
    before = iou(drawn, mask)
    if not FITTING.min_iou <= before < PART.enough_iou:
        return mesh
    lost = _wide_parts(mask & ~drawn, PART.min_share * np.count_nonzero(mask))
    if not lost.any():
        return mesh
    part = _laid(sight, item, grow(lost, PART.overlap_px) & mask, world)
    vertices, faces = one_surface([(mesh.vertices, mesh.faces), (part.vertices, part.faces)])
    whole = replace(mesh, vertices=vertices, faces=faces)
    gain = iou(sight.drawn(in_world(item, whole), faces), mask) - before
    return whole if gain > FITTING.min_gain else mesh


def _laid(sight: Sight, item: SceneObject, area: BoolArray, world: FloatArray) -> Mesh:
    """A region (H, W) as a round sheet (body frame) on the upright plane through the middle of a
    thing, or as near as its foot lets it be; of what lies, on the level. world: (V, 3) vertices
    of its body."""
    if isinstance(item.shape, Inflated) and item.shape.flat:
        low, high = float(world[:, 2].min()), float(world[:, 2].max())
        vertices, faces = sheet_on_level(area, sight.camera, low, high)
    else:
        vertices, faces = sheet_on_plane(area, sight.camera, np.asarray(item.position))
        vertices = _above(sight, vertices, world)
    body = (vertices - np.asarray(item.position)) @ matrix_of(item.rotation)
    return Mesh(body, faces.astype(np.int32))


def _wide_parts(area: BoolArray, least: float) -> BoolArray:
    """(H, W) the parts of a region that are wider than a rim and have so many pixels at least."""
    core = cv2.morphologyEx(area.astype(np.uint8), cv2.MORPH_OPEN, np.ones((3, 3), np.uint8))
    _, labels, stats, _ = cv2.connectedComponentsWithStats(core, connectivity=8)
    kept = 1 + np.flatnonzero(stats[1:, cv2.CC_STAT_AREA] >= least)
    return np.isin(labels, kept)


def _above(sight: Sight, vertices: FloatArray, world: FloatArray) -> FloatArray:
    """Places (V, 3) nearer to the camera, seen alike, where they lie below the body's foot."""
    if sight.up is None:
        return vertices
    eye = np.asarray(sight.camera.position)
    high, low = float(eye @ sight.up), float((world @ sight.up).min())
    lowest = float((vertices @ sight.up).min())
    if lowest >= low or high <= low:
        return vertices
    return np.asarray(eye + (vertices - eye) * (high - low) / (high - lowest))


def _across(told: BoolArray, pixels: FloatArray, faces: NDArray[np.int32]) -> BoolArray:
    """(F,) which faces lie across the border of a region and are more than a pixel or two wide."""
    corners = pixels[faces]
    spots = np.concatenate([corners, (corners + np.roll(corners, 1, axis=1)) / 2], axis=1)
    inside = _within(told, spots.reshape(-1, 2)).reshape(spots.shape[:2])
    fine_px = 0.7  # 0.3..4: faces with shorter edges are not divided any more
    wide = np.linalg.norm(corners - np.roll(corners, 1, axis=1), axis=2).max(axis=1) > fine_px
    return np.asarray(inside.any(axis=1) & ~inside.all(axis=1) & wide)


def _within(area: BoolArray, points: FloatArray) -> BoolArray:
    """(N,) whether pixels (N, 2) lie in a region (H, W), between whose pixels its outline runs."""
    outline_px = 0.6  # 0.3..1.2: by which an outline is rounded, so that it has no steps
    soft = cv2.GaussianBlur(area.astype(np.float32), (0, 0), outline_px)
    spots = points[:, ::-1].T - 0.5
    return np.asarray(map_coordinates(soft, spots, order=1, mode="nearest") > 0.5)


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
