"""What a body stands on: its feet in the picture, and a base cut level so that it stands."""

from __future__ import annotations

import math
from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from physagent_studio.arrays import BoolArray, FloatArray
from physagent_studio.program.scene.camera import Camera
from physagent_studio.reconstruction.camera.rays import on_plane
from physagent_studio.reconstruction.shapes.meshes import volume_and_centre
from physagent_studio.reconstruction.switches import at_work


@dataclass(frozen=True, slots=True)
class FootingSettings:
    """When a body stands, and how it is made to."""

    # 0..0.5: of a body's height, at which it may be cut level to stand
    cut_shares: tuple[float, ...] = (0.01, 0.02, 0.035, 0.05, 0.075, 0.1, 0.14, 0.2, 0.28)
    margin_share: float = 0.12  # 0..0.4: of the base: the centre of mass from its rim at least
    # cosine, 0.1..0.9: of the picture and a thing on feet, to be so turned
    min_facing_cosine: float = 0.4
    # 0.1..0.5: of a body's height, from which on what is open between its feet is between legs
    min_leg_share: float = 0.25
    # cosine, 0.4..1: by which one that is turned more counts as turned: rows of feet tell it badly
    least_facing_cosine: float = 0.75


FOOTING = FootingSettings()


def levelled(vertices: FloatArray, faces: NDArray[np.int32]) -> FloatArray:
    """The body cut level just above its lowest point, as little as makes it stand.

    What lies below the cut is pressed up to it and the body stretched to its former height. A
    body that would not stand on any cut leans in the picture too, and gets the least one.
    """
    low, high = float(vertices[:, 2].min()), float(vertices[:, 2].max())
    cuts = [_cut(vertices, low, high, share) for share in FOOTING.cut_shares]
    for cut in cuts:
        _, centre = volume_and_centre(cut, faces)
        if stands(cut, centre):
            return cut
    return cuts[0]


def _cut(vertices: FloatArray, low: float, high: float, share: float) -> FloatArray:
    height = high - low
    level = low + share * height
    out = vertices.copy()
    out[:, 2] = low + (np.maximum(out[:, 2], level) - level) / max(1 - share, 1e-9)
    return out


def stands(vertices: FloatArray, centre: FloatArray) -> bool:
    """Whether a body (V, 3) rests on its lowest points without falling over.

    centre: its centre of mass in the same frame. The centre has to lie over the base, `MARGIN` of
    the base's extent away from its rim.
    """
    low = float(vertices[:, 2].min())
    touching = vertices[:, 2] < low + 1e-3 * float(np.ptp(vertices[:, 2]))
    base = vertices[touching][:, :2].astype(np.float32)
    if len(base) < 3:
        return False
    narrow = float(min(cv2.minAreaRect(base)[1]))
    middle = (float(centre[0]), float(centre[1]))
    inside = cv2.pointPolygonTest(cv2.convexHull(base), middle, True)
    return bool(narrow > 0 and inside > FOOTING.margin_share * narrow)


def across_the_feet(mask: BoolArray, camera: Camera, ahead: FloatArray) -> FloatArray:
    """Level unit vector across the line on which two feet stand; `ahead` where there are none.

    A thing on legs or wheels that is seen at an angle would have one of its feet in the air if
    it were taken to face the camera.
    """
    found = _feet(mask) if at_work("feet") else None
    if found is None:
        return ahead
    feet, _ = found
    spots = on_plane(camera, feet, camera.position[2] - 1.0)[:, :2]
    along = spots[1] - spots[0]
    if not np.isfinite(along).all() or float(np.hypot(*along)) < 1e-9:
        return ahead
    across = np.array([-along[1], along[0], 0.0]) / float(np.hypot(*along))
    cosine, least = float(across @ ahead), FOOTING.least_facing_cosine
    if cosine >= least or cosine <= FOOTING.min_facing_cosine:
        return across if cosine >= least else ahead
    beside = across - cosine * ahead
    return least * ahead + math.sqrt(1 - least**2) * beside / float(np.linalg.norm(beside))


def on_legs(mask: BoolArray) -> bool:
    """Whether the outline rises between two feet as far as between legs."""
    found = _feet(mask)
    return found is not None and found[1] > FOOTING.min_leg_share


def _feet(mask: BoolArray) -> tuple[FloatArray, float] | None:
    """The two feet (2, 2) pixels between which the middle of a silhouette lies; None without.

    They are the ends of the lowest line that the outline can be set on, left first, with a gap
    between them where the outline rises, and how far it does, as a share of its height.
    """
    columns = np.flatnonzero(mask.any(0))
    rows = mask.shape[0] - mask[::-1, columns].argmax(0)
    height = float(rows.max() - np.flatnonzero(mask.any(1))[0])
    outline = np.column_stack([columns + 0.5, rows]).astype(float)
    hull = cv2.convexHull(outline.astype(np.float32))[:, 0].astype(float)
    lower = hull[np.argsort(hull[:, 0], kind="stable")]
    middle = float(np.average(columns + 0.5, weights=mask.sum(0)[columns]))
    found = [
        (p, q)
        for i, p in enumerate(lower)
        for q in lower[i + 1 :]
        if p[0] < middle < q[0] and _above(outline, p, q).min() > -0.75
    ]
    if not found:
        return None
    left, right = max(found, key=lambda pair: pair[1][0] - pair[0][0])
    between = (outline[:, 0] > left[0]) & (outline[:, 0] < right[0])
    rise = _above(outline[between], left, right)
    gap = float((rise > 0.04 * height).mean()) if len(rise) else 0.0
    wide = right[0] - left[0] > 0.3 * len(columns)
    if not (wide and gap > 0.4):
        return None
    return np.array([left, right]), float(rise.max()) / height


def _above(outline: FloatArray, left: FloatArray, right: FloatArray) -> FloatArray:
    """How far (N,) pixels (N, 2) lie above the line through two of them."""
    slope = (right[1] - left[1]) / max(right[0] - left[0], 1e-9)
    return left[1] + slope * (outline[:, 0] - left[0]) - outline[:, 1]
