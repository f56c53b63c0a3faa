"""What the mask shows of a thing and its body does not: openings, and parts that stand off.

Looks alone: what is laid out anew to be drawn, or added to that, collides as before.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import cv2
import numpy as np

from physagent_studio.program.rotations import matrix_of
from physagent_studio.program.scene.state import Inflated, SceneObject
from physagent_studio.reconstruction.photo.regions import BoolArray, bounds, grow, iou
from physagent_studio.reconstruction.shapes.inflation import (
    has_slender_parts,
    seen_mesh,
    sheet_on_level,
    sheet_on_plane,
)
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

SMOOTH = (*WHOLE, *LEFT, *FLAT)
"""Kinds that have no parts beside them: what a mask shows beside a ball or a box is wrong."""


@dataclass(frozen=True, slots=True)
class PartSettings:
    """Which parts of a mask are drawn that the body leaves out."""

    enough_iou: float = 0.97  # IoU, 0.9..1: with its mask, from which nothing is missing
    # 0.001..0.05: of the mask: smaller parts beside the body are its rough rim
    min_share: float = 0.004
    # IoU, 0.3..0.9: of its box with that of its mask: what was moved by hand stands elsewhere
    min_box_iou: float = 0.7
    # IoU, 0..0.1: with its mask, that may be lost where thin parts would be boards
    max_slender_loss: float = 0.03
    # IoU, 0..0.1: with its mask, that may be lost of a foot cut level in the middle of its body
    max_foot_loss: float = 0.015
    overlap_px: int = 2  # 0..6: by which a part goes on into what is drawn


PART = PartSettings()


def carved(sight: Sight, item: SceneObject, mesh: Mesh) -> Mesh:
    """The mesh (body frame), or one that covers no opening that the mask shows.

    A body laid out deep from its silhouette closes them behind: legs, spokes, a backrest; and its
    thin parts are boards. Where that is much of it, what is drawn is laid out along the rays by
    which it is seen: closed, as deep, and in the mask whatever its depth. It collides as before.
    """
    if not isinstance(item.shape, Inflated) or not at_work("outline carving"):
        return mesh
    world, mask = in_world(item, mesh), sight.mask & sight.free
    drawn = sight.drawn(world, mesh.faces)
    before = iou(drawn, mask)
    elsewhere = not drawn.any() or _box_iou(bounds(drawn), bounds(mask)) < PART.min_box_iou
    slender = has_slender_parts(mask, sight.camera, item.shape)
    if elsewhere or (before >= PART.enough_iou and not slender):
        return mesh
    whole = mask if sight.behind is None else mask | sight.behind
    laid = _along_sight(sight, item, whole, world)
    after = iou(sight.drawn(in_world(item, laid), laid.faces), mask)
    gain = -PART.max_slender_loss if slender else FITTING.min_gain
    return laid if after > before + gain else mesh


def _box_iou(one: tuple[int, int, int, int], other: tuple[int, int, int, int]) -> float:
    """IoU of two boxes x0, y0, x1, y1."""
    wide, tall = (max(0, min(one[k + 2], other[k + 2]) - max(one[k], other[k])) for k in (0, 1))
    areas = [(x1 - x0) * (y1 - y0) for x0, y0, x1, y1 in (one, other)]
    return wide * tall / (sum(areas) - wide * tall)


def _along_sight(sight: Sight, item: SceneObject, mask: BoolArray, world: FloatArray) -> Mesh:
    """What is seen of a thing (body frame), as deep as its body (V, 3), world, on its ground."""
    assert isinstance(item.shape, Inflated)
    if item.shape.flat or item.shape.turn is not None:
        return _laid(sight, item, mask, world)
    vertices, own = seen_mesh(mask, sight.camera, item.shape, world)
    faces = own.astype(np.int32)
    nearer = _above(sight, vertices, world)
    if sight.up is not None:
        under = np.minimum(vertices @ sight.up - float((world @ sight.up).min()), 0.0)
        cut = vertices - under[:, None] * sight.up
        whole, level = (iou(sight.drawn(one, faces), mask) for one in (nearer, cut))
        # Feet that are thin stand where they are seen, not in the middle of a deep body.
        nearer = cut if level > whole - PART.max_foot_loss else nearer
    body = (nearer - np.asarray(item.position)) @ matrix_of(item.rotation)
    return Mesh(body, faces)


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
