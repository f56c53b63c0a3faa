"""The photograph projected on a mesh: what it shows as it shows it, hidden sides mirrored."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from enum import IntEnum

import cv2
import numpy as np
from numpy.typing import NDArray

from physagent_studio.arrays import FloatArray
from physagent_studio.program.rotations import matrix_of
from physagent_studio.program.scene.camera import Camera
from physagent_studio.program.scene.state import Ellipsoid, Inflated, SceneObject, Sphere
from physagent_studio.reconstruction.photo.regions import BoolArray, bounds, shrink
from physagent_studio.reconstruction.switches import at_work
from physagent_studio.reconstruction.texture.block_sides import opposite_sides
from physagent_studio.reconstruction.texture.hidden_sides import covered_painted
from physagent_studio.reconstruction.texture.inward import (
    calmed,
    led_inward,
    nearest,
    without_features,
)
from physagent_studio.reconstruction.texture.lighting import no_light, unlit
from physagent_studio.reconstruction.texture.plain_ball import is_plain, plainly_painted
from physagent_studio.reconstruction.texture.revolved import Around, around
from physagent_studio.reconstruction.texture.rim_shade import with_rim_shade
from physagent_studio.reconstruction.texture.round_bodies import round_textured
from physagent_studio.reconstruction.texture.soft_rim import soft_rim
from physagent_studio.reconstruction.texture.straight_sides import carried_back, cut_halfway
from physagent_studio.reconstruction.texture.turned_prisms import opposite_parts
from physagent_studio.records.case import Image
from physagent_studio.records.scene import Mesh


@dataclass(frozen=True, slots=True)
class ProjectionSettings:
    """How wide a rim is not taken from the photo."""

    # 0..0.2: over the smaller extent: the outline's outer ring, where others shine through
    ring_ratio: float = 0.012
    # sine, 0..0.4: of face and view, from which on the photo shows a swelling body
    min_facing_sine: float = math.sin(math.radians(15.0))
    # 0..0.05: over the longer side: of what is carried back along straight sides
    blur_ratio: float = 0.01
    # cosine, 0.3..1: of a face and straight down, from where on it is of a thing's underside
    min_down_cosine: float = 0.6
    # 0.01..0.3: over the longer side: of what an unseen underside shows, which is mostly plain
    underside_blur_ratio: float = 0.05


PROJECTION = ProjectionSettings()


class _Look(IntEnum):
    """Where the look of a face comes from."""

    SEEN = 0
    MIRRORED = 1
    COPIED = 2
    CARRIED = 3
    ACROSS = 4
    FOLDED = 5
    UNDERSIDE = 6


_DRAWN_OUT = (_Look.MIRRORED, _Look.CARRIED, _Look.FOLDED)
"""What shows a few pixels of the front's rim drawn out, where it lies beneath."""
_BLURS = {
    _Look.CARRIED: PROJECTION.blur_ratio,
    _Look.UNDERSIDE: PROJECTION.underside_blur_ratio,
}


def textured(photo: Image, mask: BoolArray, camera: Camera, item: SceneObject, mesh: Mesh) -> Mesh:
    """The mesh with the photo on it; grey if the mask is empty.

    Faces that look at the camera carry the pixel that they project to. The others carry what
    their mirror image in the upright plane through the object's middle projects to, so that the
    far side continues the near one without a seam. There the outermost ring of the outline, in
    which little of the surface is much stretched and the surroundings shine through, gives
    way to what lies as far inside of it. Balls and ellipsoids: see `round_textured`; what else is
    round about an axis: see `around`. Where the light on what is smooth and round is told by
    the photo, the texture is without it, and the mesh has it as its `shading`: see `unlit`.
    """
    if not mask.any():
        return mesh
    red, green, blue = (round(float(value)) for value in photo[mask].mean(0))
    color = (red, green, blue)
    plain = unlit(photo, mask, camera, item, mesh)
    if isinstance(item.shape, Sphere | Ellipsoid) and at_work("plain balls"):
        picture = photo if plain is None else plain[0]
        if is_plain(picture, mask):
            light = replace(no_light(camera, item), gloss=plain and plain[1].gloss)
            picture = plainly_painted(picture, mask)
            painted = _painted(picture, mask, camera, item, mesh, lit=False)
            painted = replace(painted, color=color, shading=light)
            return with_rim_shade(photo, mask, camera, item, painted, whole=True)
    if plain is None:
        return replace(_painted(photo, mask, camera, item, mesh, lit=True), color=color)
    painted = _painted(plain[0], mask, camera, item, mesh, lit=False)
    painted = replace(painted, color=color, shading=plain[1])
    if isinstance(item.shape, Sphere | Ellipsoid) and at_work("rim shade"):
        return with_rim_shade(photo, mask, camera, item, painted)
    return painted


def _painted(
    photo: Image, mask: BoolArray, camera: Camera, item: SceneObject, mesh: Mesh, *, lit: bool
) -> Mesh:
    """The mesh with that picture (H, W, 3) on it, which may have its light; see `textured`."""
    texture, origin = padded_crop(photo, mask)
    texture = covered_painted(photo, mask, camera, item, (texture, origin))
    whole = round_textured(camera, item, mesh, mask, (texture, origin), lit)
    if whole is not None:
        return whole
    turned = around(camera, item, mesh, mask, (texture, origin), lit)
    if turned is not None:
        mesh, whole = replace(mesh, faces=mesh.faces[~turned.faces]), mesh
    mesh = cut_halfway(mask, camera, item, mesh)
    kinds = np.where(_unseen(camera, item, mesh), _Look.MIRRORED, _Look.SEEN)
    elsewhere = _elsewhere(camera, item, mask, mesh)
    for which, (chosen, _) in elsewhere.items():
        kinds[chosen] = which
    # Undersides show what they would anyway, from a panel of their own: they are split off for it.
    beneath = _beneath(item, mesh) & np.isin(kinds, _DRAWN_OUT)
    vertices, faces, source, kind = _split(mesh, np.where(beneath, kinds + len(_Look), kinds))
    under, kind = kind >= len(_Look), kind % len(_Look)
    place, turn = np.asarray(item.position), matrix_of(item.rotation).T
    world = vertices @ turn + place
    shown = np.where((kind == _Look.MIRRORED)[:, None], _mirrored(camera, world, place), world)
    for which, (_, places) in elsewhere.items():
        shown = np.where((kind == which)[:, None], places[source] @ turn + place, shown)
    uv = camera.project(shown)[0]
    edge = np.array([texture.shape[1], texture.shape[0]])
    uv = np.clip(uv - origin, 0.5, edge - 0.5)
    crop = tuple(slice(at, at + wide) for at, wide in zip(origin[::-1], edge[::-1], strict=True))
    own = mask[crop]
    panels = [texture]
    kind = np.where(under, int(_Look.UNDERSIDE), kind)
    x0, y0, x1, y1 = bounds(own)
    ring = max(PROJECTION.ring_ratio, soft_rim(photo[crop], own) / min(x1 - x0, y1 - y0))
    for which in (*_DRAWN_OUT, _Look.ACROSS, _Look.UNDERSIDE):
        if not (kind == which).any():
            continue
        panel = led_inward(texture, own, ring)
        if which == _Look.MIRRORED and _swells(item):
            panel = calmed(without_features(panel, own), own)
        if which in _BLURS:
            # Single pixels would be drawn out to stripes, or stand for a whole end.
            panel = cv2.GaussianBlur(panel, (0, 0), _BLURS[which] * float(edge.max()))
        uv[kind == which, 0] += len(panels) * edge[0]
        panels.append(np.asarray(panel, np.uint8))
    texture = np.hstack(panels)
    flat = Mesh(vertices, faces, uv, texture)
    return flat if turned is None or whole is None else _joined(flat, whole, turned)


def _joined(mesh: Mesh, whole: Mesh, turned: Around) -> Mesh:
    """The textured mesh with those faces of the whole one that show a picture of their own."""
    assert mesh.uv is not None
    assert mesh.texture is not None
    width, rows = mesh.texture.shape[1], max(len(mesh.texture), len(turned.picture))
    both = [
        np.pad(one, ((0, rows - len(one)), (0, 0), (0, 0)), mode="edge")
        for one in (mesh.texture, turned.picture)
    ]
    texture = np.hstack(both)
    own = whole.faces[turned.faces].reshape(-1)
    places = np.column_stack([own, turned.corners.reshape(-1, 2)])
    used, compact = np.unique(places, axis=0, return_inverse=True)
    faces = compact.reshape(-1, 3) + len(mesh.vertices)
    return Mesh(
        np.vstack([mesh.vertices, whole.vertices[used[:, 0].astype(int)]]),
        np.vstack([mesh.faces, faces]).astype(np.int32),
        np.asarray(np.vstack([mesh.uv, used[:, 1:] + (width, 0)]), np.float64),
        texture,
    )


def _elsewhere(
    camera: Camera, item: SceneObject, mask: BoolArray, mesh: Mesh
) -> dict[int, tuple[BoolArray, FloatArray]]:
    """By kind the faces (F,) that show what is elsewhere on the body, and where (V, 3) that is."""
    parts = opposite_parts(camera, item, mesh)
    if parts:
        kinds = (_Look.SEEN, _Look.ACROSS, _Look.CARRIED, _Look.FOLDED)
        return dict(zip(kinds, parts, strict=True))
    found = {
        _Look.COPIED: opposite_sides(camera, item, mesh),
    }
    straight = carried_back(camera, item, mask, mesh)
    if straight is not None:
        found |= dict(zip((_Look.CARRIED, _Look.COPIED, _Look.FOLDED), straight, strict=True))
    return {kind: own for kind, own in found.items() if own is not None}


def padded_crop(photo: Image, mask: BoolArray) -> tuple[Image, tuple[int, int]]:
    """The photo around the object, its surroundings replaced by the object's nearest pixels.

    Returns the crop (h, w, 3) and its top left corner (x, y). The outline itself mixes object
    and background, so the outermost pixels are replaced too.
    """
    rows, columns = mask.shape
    x0, y0, x1, y1 = bounds(mask)
    pad = max(6, round(0.12 * max(x1 - x0, y1 - y0)))
    left, top = max(0, x0 - pad), max(0, y0 - pad)
    crop = (slice(top, min(rows, y1 + pad)), slice(left, min(columns, x1 + pad)))
    own = mask[crop]
    part = photo[crop]
    core = shrink(own, 1)
    thin = own & ~cv2.dilate(core.astype(np.uint8), np.ones((5, 5), np.uint8)).astype(bool)
    core = core | thin
    source = nearest(core)
    filled = part[source[..., 0], source[..., 1]]
    soft = cv2.GaussianBlur(filled, (0, 0), 1.5)
    return np.where(core[..., None], filled, soft).astype(np.uint8), (left, top)


def _unseen(camera: Camera, item: SceneObject, mesh: Mesh) -> BoolArray:
    """(F,) which faces look away from the camera, or hardly at it where a body swells."""
    world = mesh.vertices @ matrix_of(item.rotation).T + np.asarray(item.position)
    a, b, c = (world[mesh.faces[:, k]] for k in range(3))
    normal = np.cross(b - a, c - a)
    view = np.asarray(camera.position) - (a + b + c) / 3
    sine = (view * normal).sum(1)
    sine /= np.maximum(np.linalg.norm(view, axis=1) * np.linalg.norm(normal, axis=1), 1e-15)
    return np.asarray(sine <= (PROJECTION.min_facing_sine if _swells(item) else 0.0))


def _beneath(item: SceneObject, mesh: Mesh) -> BoolArray:
    """(F,) which faces are of a thing's underside."""
    if not at_work("plain undersides"):
        return np.zeros(len(mesh.faces), bool)
    a, b, c = (mesh.vertices[mesh.faces[:, k]] for k in range(3))
    normal = np.cross(b - a, c - a)
    normal /= np.maximum(np.linalg.norm(normal, axis=1, keepdims=True), 1e-15)
    return np.asarray(normal @ matrix_of(item.rotation)[2] < -PROJECTION.min_down_cosine)


def _swells(item: SceneObject) -> bool:
    """Whether a thing's body swells over its outline, its far side as its near one."""
    return isinstance(item.shape, Inflated) and not item.shape.straight


def _split(
    mesh: Mesh, kinds: NDArray[np.int64]
) -> tuple[FloatArray, NDArray[np.int32], NDArray[np.int64], NDArray[np.int64]]:
    """Vertices doubled where faces of two kinds (F,) meet.

    Returns them (V, 3), the faces, and of each vertex the one that it was and its kind (V,).
    """
    count = len(mesh.vertices)
    faces = mesh.faces.astype(np.int64) + count * kinds[:, None]
    used, compact = np.unique(faces, return_inverse=True)
    source = used % count
    return (
        mesh.vertices[source],
        compact.reshape(faces.shape).astype(np.int32),
        source,
        used // count,
    )


def _mirrored(camera: Camera, world: FloatArray, middle: FloatArray) -> FloatArray:
    """World points, those behind the upright plane through `middle` that faces the camera mirrored
    in it."""
    view = middle - np.asarray(camera.position)
    view[2] = 0.0
    view /= max(float(np.linalg.norm(view)), 1e-9)
    return world - 2 * np.maximum((world - middle) @ view, 0)[:, None] * view
