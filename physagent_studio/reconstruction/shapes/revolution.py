"""A surface of revolution from a silhouette that is symmetric about an upright axis."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from physagent_studio.arrays import FloatArray
from physagent_studio.program.scene.camera import Camera
from physagent_studio.program.scene.state import Revolved
from physagent_studio.reconstruction.camera.rays import on_plane, on_upright
from physagent_studio.reconstruction.photo.regions import BoolArray, bounds, iou
from physagent_studio.reconstruction.shapes.meshes import profile_centre
from physagent_studio.reconstruction.shapes.primitives import Base


@dataclass(frozen=True, slots=True)
class RevolutionSettings:
    """How a silhouette is turned about its axis."""

    rings_count: int = 44  # 12..200: from its foot to its top
    spur_share: float = 0.12  # 0.03..0.4: of the silhouette: a narrower end may be a spur of shade
    spur_factor: float = 2.5  # 1.5..6: by which the silhouette widens within two rows behind a spur
    # 0.5..1: of half a row's width, from which on a narrower ring is only a rough outline
    rim_share: float = 0.8


REVOLUTION = RevolutionSettings()


def mirror_symmetry(mask: BoolArray) -> float:
    """IoU of the mask with its mirror image about its own upright axis."""
    rows, columns = np.nonzero(mask)
    x0, _, x1, _ = bounds(mask)
    best = 0.0
    for axis in {x0 + x1 - 1, round(2 * float(np.median(columns)))}:
        mirrored = axis - columns
        fine = (mirrored >= 0) & (mirrored < mask.shape[1])
        flipped = np.zeros_like(mask)
        flipped[rows[fine], mirrored[fine]] = True
        best = max(best, iou(mask, flipped))
    return best


def revolved(
    camera: Camera, mask: BoolArray, base: Base
) -> tuple[Revolved, tuple[float, float, float]] | None:
    """The shape and the position of its centre of mass, standing at `base`.

    The rims of flat ends are seen as ellipses: the silhouette ends below its foot's middle and
    above its top's middle by the rim's radius times the sine of the view's slope.
    """
    _, y0, _, y1 = bounds(mask)
    rows = np.flatnonzero(mask.any(1))
    left = mask.argmax(1)[rows]
    right = mask.shape[1] - mask[:, ::-1].argmax(1)[rows]
    half = (right - left) / 2
    axis = float(np.median(((right + left) / 2)[half > 0.5 * half.max()]))
    ray = camera.rays(np.array([[axis, (y0 + y1) / 2]]))[0]
    slope = abs(float(ray[2])) / float(np.linalg.norm(ray)) if ray[2] < 0 else 0.0
    first, last = _end(half, slope), len(half) - 1 - _end(half[::-1], slope)
    if last - first < 4:
        return None
    centres = rows[first : last + 1] + 0.5
    y = base.y
    if base.hold < 1 and not base.free_z:
        seen = on_plane(camera, [(axis, centres[-1])], base.z)[0, 1]
        y = float((1 - base.hold) * seen + base.hold * base.y) if np.isfinite(seen) else base.y
    sample = np.linspace(centres[-1], centres[0], REVOLUTION.rings_count)
    points = on_upright(camera, np.column_stack([np.full(REVOLUTION.rings_count, axis), sample]), y)
    depth = camera.project(points)[1]
    rings = _rings(half, slope)[first : last + 1]
    radius = np.interp(sample, centres, rings) * depth / camera.focal
    radius = np.convolve(np.pad(radius, 1, mode="edge"), (0.25, 0.5, 0.25), mode="valid")
    height = points[:, 2] - points[0, 2]
    if not np.all(np.diff(height) > 0) or not np.isfinite(radius).all():
        return None
    profile = [(float(z), float(max(r, 1e-5))) for z, r in zip(height, radius, strict=True)]
    centre = profile_centre(profile)
    foot = float(points[0, 2]) if base.free_z else base.z
    x = float(np.average(points[:, 0], weights=radius))
    shape = Revolved(profile=tuple((z - centre, r) for z, r in profile))
    return shape, (x, y, foot + centre)


def _rings(half: FloatArray, slope: float) -> FloatArray:
    """px; radius in each row of the widest ring about the axis that no row of the outline cuts.

    A ring is seen as an ellipse, as wide as in its own row only there: a flat plate from above
    covers as many rows as a low drum, but a ring as wide as the plate fits in its middle row alone.
    """
    if slope < math.sin(math.radians(1)):
        return half
    reach = np.pad(half, 1)
    away = (np.arange(len(reach)) - np.arange(1, len(half) + 1)[:, None]) / slope
    widest = np.sqrt((reach**2 + away**2).min(1))
    return np.asarray(np.where(widest < REVOLUTION.rim_share * half, widest, half))


def _end(half: FloatArray, slope: float) -> int:
    """Rows from an end of the silhouette to the middle of the rim there."""
    if slope < math.sin(math.radians(1)):
        return 0
    limit = max(1, len(half) // 2)
    spur = _spur(half[:limit], float(half.max()))
    steps = np.arange(limit - spur)
    reached = np.flatnonzero(steps >= half[spur:limit] * slope)
    return spur + int(reached[0]) if len(reached) else limit - 1


def _spur(half: FloatArray, most: float) -> int:
    """Rows of a narrow spur at an end, from which the silhouette widens at once: shade at a foot.

    What comes to a point widens row by row and has none.
    """
    wider = half[2:] > REVOLUTION.spur_factor * half[:-2] + 2.0
    found = np.flatnonzero(wider & (half[:-2] < REVOLUTION.spur_share * most))
    return int(found[-1]) + 1 if len(found) else 0
