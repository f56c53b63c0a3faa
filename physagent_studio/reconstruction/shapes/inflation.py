"""A solid from a silhouette: the outline as the picture shows it, a plausible depth behind it.

The mask is laid on an upright plane that faces the camera and given a thickness there. Round
things swell as the balls that find room in their outline; things whose usual depth is known (a car,
a house) or larger than that get flat sides with a rounded rim. What stands was cut level where it
touches the ground, for a thing that is seen to stand has a base to stand on.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from physagent_studio.arrays import FloatArray
from physagent_studio.program.scene.camera import Camera
from physagent_studio.program.scene.state import Inflated
from physagent_studio.reconstruction.camera.rays import depth_of, on_plane, on_upright_through
from physagent_studio.reconstruction.photo.regions import BoolArray, bounds
from physagent_studio.reconstruction.shapes.footing import across_the_feet, levelled
from physagent_studio.reconstruction.shapes.legs import several_rows, split_legs, thin_legs
from physagent_studio.reconstruction.shapes.meshes import one_surface, volume_and_centre
from physagent_studio.reconstruction.shapes.prisms import plan_of, prism_mesh
from physagent_studio.reconstruction.shapes.sheets import (
    SHEET,
    Sheet,
    closed,
    is_slender,
    sheet_of,
    thickness,
)
from physagent_studio.reconstruction.switches import at_work
from physagent_studio.records.scene import Mesh


def natural_depth(mask: BoolArray) -> float:
    """Thickness in pixels of the round body over a mask."""
    return 2.0 * float(sheet_of(mask).swell.max(initial=0.0))


def inflated_mesh(mask: BoolArray, camera: Camera, shape: Inflated) -> Mesh:
    """The mesh of an `Inflated` shape, body frame, its bounding box as `shape.size` says.

    It depends on where the mask lies in the picture and on how the camera looks, not on how far
    away the object is, so that moving the object does not change its body.
    """
    share = shape.size[2 if shape.flat else 1] / max(shape.size[0], 1e-9)
    plane = _plane(mask, camera, shape.facing)
    plan = None if shape.turn is None else plan_of(mask, camera, shape.turn, shape.thickness)
    if plan is not None:
        vertices, faces = prism_mesh(mask, camera, plan)
    elif shape.flat:
        vertices, faces = _level(mask, camera, share, shape.straight)
    else:
        half = _half_depth(_laid(mask, plane, shape.straight), mask, share)
        vertices, faces = _stood(mask, plane, half, shape)
    low, high = vertices.min(0), vertices.max(0)
    scale = np.array(shape.size) / np.maximum(high - low, 1e-12)
    vertices = levelled((vertices - (low + high) / 2) * scale, faces.astype(np.int32))
    _, centre = volume_and_centre(vertices, faces.astype(np.int32))
    return Mesh(vertices - centre, faces.astype(np.int32))


def seen_mesh(
    mask: BoolArray, camera: Camera, shape: Inflated, world: FloatArray
) -> tuple[FloatArray, NDArray[np.int64]]:
    """World vertices (V, 3), m, and faces of an upright `Inflated` shape that lie on rays of the

    mask, front and back. world: vertices of its body, in whose middle its outline is laid.
    """
    plane = replace(_plane(mask, camera, shape.facing), sight=True)
    half = _half_depth(
        _laid(mask, plane, shape.straight), mask, shape.size[1] / max(shape.size[0], 1e-9)
    )
    vertices, faces = _stood(mask, plane, half, shape)
    eye = np.asarray(camera.position)
    reach = (world - eye) @ plane.ahead
    away = (float(reach.min()) + float(reach.max())) / 2 / float((plane.centre - eye) @ plane.ahead)
    return eye + away * (vertices - eye), faces


def has_slender_parts(mask: BoolArray, camera: Camera, shape: Inflated) -> bool:
    """Whether much of an `Inflated` shape over a mask would be boards where its outline is thin."""
    if shape.flat or shape.turn is not None:
        return False
    laid = _laid(mask, _plane(mask, camera, shape.facing), shape.straight)
    half = _half_depth(laid, mask, shape.size[1] / max(shape.size[0], 1e-9))
    return laid[2].straight_at(half) and is_slender(laid[2], half)


def sheet_on_plane(
    mask: BoolArray, camera: Camera, point: FloatArray
) -> tuple[FloatArray, NDArray[np.int64]]:
    """World vertices (V, 3), m, and faces of the round body over a mask, around the upright plane

    through `point` that faces the camera.
    """
    sheet = sheet_of(mask, cells=SHEET.max_drawn_cells)
    ahead = np.asarray(point, float) - np.asarray(camera.position)
    ahead[2] = 0.0
    ahead /= max(float(np.hypot(*ahead[:2])), 1e-9)
    flat = on_upright_through(camera, sheet.pixels, point, ahead)
    pixel = depth_of(camera, point) / camera.focal
    push = (sheet.swell * pixel)[:, None] * ahead[None]
    return closed(np.vstack([flat - push, flat + push]), sheet, sheet.swell)


def sheet_on_level(
    mask: BoolArray, camera: Camera, low: float, high: float
) -> tuple[FloatArray, NDArray[np.int64]]:
    """World vertices (V, 3), m, and faces of the round body over a mask that lies between two
    levels, m."""
    sheet = sheet_of(mask, cells=SHEET.max_drawn_cells)
    flat = on_plane(camera, sheet.pixels, (low + high) / 2)
    pixel = depth_of(camera, flat.mean(axis=0)) / camera.focal
    thick = np.minimum(sheet.swell, (high - low) / 2 / pixel)
    push = thick[:, None] * np.array([[0.0, 0.0, pixel]])
    # Front first, as of upright ones: that is what the camera looks down on.
    return closed(np.vstack([flat + push, flat - push]), sheet, thick)


def standing_plane(mask: BoolArray, camera: Camera, facing: bool) -> tuple[FloatArray, FloatArray]:
    """Level unit vectors across the front of what stands over a mask, and along its sides, back."""
    plane = _plane(mask, camera, facing)
    return plane.ahead, plane.behind


def upright_extent(
    mask: BoolArray, camera: Camera, depth: float, straight: bool = False, facing: bool = False
) -> tuple[float, float, float]:
    """Extent (x, y, z) of a body over a mask one unit away, world axes.

    depth: its thickness through the upright plane on which the mask is laid, pixels. straight,
    facing: see `Inflated`.
    """
    plane = _plane(mask, camera, facing)
    low, high = _box(*_laid(mask, plane, straight), depth / 2)
    x, y, z = (float(value) for value in high - low)
    return x, y, z


def _stood(
    mask: BoolArray, plane: _Plane, half: float, shape: Inflated
) -> tuple[FloatArray, NDArray[np.int64]]:
    """World vertices around a plane one unit away, and faces; 2 · half pixels deep."""
    if shape.seat is not None:
        return _with_back(mask, plane, half, shape.seat)
    if sheet_of(mask, shape.straight).straight_at(half):
        split = (lambda own: thin_legs(own, half)) if plane.sight else split_legs
        body, legs = split(mask) if at_work("legs") else (mask, [])
        if legs:
            return _on_legs(body, legs, plane, half)
    return plane.standing(mask, half, 0.0, shape.straight)


def _half_depth(
    laid: tuple[FloatArray, FloatArray, Sheet], mask: BoolArray, depth_share: float
) -> float:
    """Half thickness in pixels with which what is laid reaches so far along y, of that along x."""
    x0, y0, x1, y1 = bounds(mask)
    least, most = 0.0, 6.0 * max(x1 - x0, y1 - y0)
    for _ in range(30):
        half = (least + most) / 2
        low, high = _box(*laid, half)
        extent = high - low
        if extent[1] < depth_share * extent[0]:
            least = half
        else:
            most = half
    return most


def _level(
    mask: BoolArray, camera: Camera, depth_share: float, straight: bool
) -> tuple[FloatArray, NDArray[np.int64]]:
    """World vertices around a level plane one unit below the camera, and faces.

    depth_share: extent of the result along z as a share of that along x.
    """
    sheet = sheet_of(mask, straight)
    flat = on_plane(camera, sheet.pixels, camera.position[2] - 1.0)
    pixel = depth_of(camera, flat.mean(axis=0)) / camera.focal
    half = depth_share * float(np.ptp(flat[:, 0])) / 2 / pixel
    thick = thickness(sheet, half)
    push = thick[:, None] * np.array([[0.0, 0.0, -pixel]])
    return closed(np.vstack([flat - push, flat + push]), sheet, thick)


def _on_legs(
    body: BoolArray, legs: list[BoolArray], plane: _Plane, half: float, shift: float = 0.0
) -> tuple[FloatArray, NDArray[np.int64]]:
    """A flat body 2 · half pixels deep on posts, of each leg one at the front, one at the back.

    shift: of its middle behind the plane, pixels.
    """
    parts = [plane.standing(body, half, shift, straight=True)] if body.any() else []
    max_post_share = 0.4  # 0.1..0.6: of the body's depth: legs are thinner
    ground = max(bounds(leg)[3] for leg in legs)
    # Where more than two are seen, those behind are among them.
    sides = (0.0,) if plane.sight and several_rows(legs) else (-1.0, 1.0)
    for leg in legs:
        if plane.sight:
            own = min(float(sheet_of(leg).swell.max()), max_post_share * half)
        else:
            leg = _down_to(leg, ground)
            x0, _, x1, _ = bounds(leg)
            own = min(0.5 * (x1 - x0), max_post_share * half)
        for side in sides:
            parts.append(plane.standing(leg, own, shift + side * (half - own)))
    vertices, faces = one_surface(parts)
    return vertices, faces.astype(np.int64)


def _with_back(
    mask: BoolArray, plane: _Plane, half: float, seat: float
) -> tuple[FloatArray, NDArray[np.int64]]:
    """What is seen below its seat 2 · half pixels deep, and above that only its back, behind."""
    row = seat_row(mask, seat)
    low, high = np.zeros_like(mask), mask.copy()
    low[row:], high[row:] = mask[row:], False
    # What stands on the seat hides where it goes on.
    columns = np.flatnonzero(low.any(0))
    first = low.argmax(0)
    hidden_share = 0.35  # 0.1..0.6: of what is seen below the seat, that may be hidden of it
    for column in columns[first[columns] - row < hidden_share * (low.shape[0] - row)]:
        low[row : first[column], column] = True
    body, legs = split_legs(low) if at_work("legs") else (low, [])
    front = plane.farther(-half)
    if legs:
        parts = [_on_legs(body, legs, front, half, half)]
    else:
        parts = [front.standing(low, half, half, straight=True)]
    if high.any():
        back_share = 0.15  # 0.05..0.4: of the depth of the seat, that of its back
        own = back_share * half
        parts.append(plane.farther(half - own).standing(high, own, 0.0, straight=True))
    vertices, faces = one_surface(parts)
    return vertices, faces.astype(np.int64)


def seat_row(mask: BoolArray, seat: float) -> int:
    """The row of the picture in which the front edge of a seat is seen."""
    _, y0, _, y1 = bounds(mask)
    return int(np.clip(round(y1 - seat * (y1 - y0)), y0 + 1, y1 - 1))


def _down_to(leg: BoolArray, row: int) -> BoolArray:
    """A leg (H, W) with its foot at that row: seen from above, those behind seem to end higher."""
    bottom = bounds(leg)[3]
    out = leg.copy()
    out[bottom:row] = leg[bottom - 1]
    return out


@dataclass(frozen=True, eq=False, slots=True)
class _Plane:
    """The upright plane on which a silhouette is laid, one unit away: a point and its normal.

    behind: level unit vector along which the body reaches back, midway between that normal and the
    view: the photo hardly shows its sides then, and they are nearly at right angles to its front.
    sight: it reaches back along each ray instead, and what is thin stays so.
    """

    camera: Camera
    centre: FloatArray
    ahead: FloatArray
    behind: FloatArray
    sight: bool = False

    def farther(self, shift: float) -> _Plane:
        """The plane so many pixels behind it: what is laid on it is seen in the same place."""
        return replace(self, centre=self.centre + shift * self.behind / self.camera.focal)

    def laid(self, sheet: Sheet) -> FloatArray:
        """Places (V, 3) of a sheet, m."""
        return on_upright_through(self.camera, sheet.pixels, self.centre, self.ahead)

    def standing(
        self, mask: BoolArray, half: float, shift: float, straight: bool = False
    ) -> tuple[FloatArray, NDArray[np.int64]]:
        """The body over a mask, 2 · half pixels deep, its middle `shift` pixels behind."""
        sheet = sheet_of(mask, straight)
        thick = thickness(sheet, half, self.sight)
        flat = self.laid(sheet)
        ends = [self.pushed(flat, shift - thick), self.pushed(flat, shift + thick)]
        return closed(np.vstack(ends), sheet, thick)

    def pushed(self, flat: FloatArray, push: FloatArray) -> FloatArray:
        """Places (V, 3) so many pixels (V,) behind those on the plane."""
        if not self.sight:
            return flat + push[:, None] * self.behind / self.camera.focal
        eye = np.asarray(self.camera.position)
        far = 1 + push / self.camera.focal / ((flat - eye) @ self.ahead)
        return np.asarray(eye + (flat - eye) * far[:, None])


def _laid(mask: BoolArray, plane: _Plane, straight: bool) -> tuple[FloatArray, FloatArray, Sheet]:
    """The silhouette on an upright plane: places (V, 3) m, the level unit vector through the

    plane scaled to a pixel (1 / focal, for the plane is one unit away), and the sheet.
    """
    sheet = sheet_of(mask, straight)
    return plane.laid(sheet), plane.behind / plane.camera.focal, sheet


def _plane(mask: BoolArray, camera: Camera, facing: bool) -> _Plane:
    """It faces the camera, or stands across the two feet that are seen where that is not stated."""
    x0, y0, x1, y1 = bounds(mask)
    middle = np.array([(x0 + x1) / 2, (y0 + y1) / 2])
    ray = camera.rays(middle[None])[0]
    view = np.array([ray[0], ray[1], 0.0])
    view /= max(float(np.hypot(*view[:2])), 1e-9)
    ahead = view if facing else across_the_feet(mask, camera, view)
    behind = (ahead + view) / float(np.linalg.norm(ahead + view))
    return _Plane(camera, np.asarray(camera.position) + ray, ahead, behind)


def _box(
    flat: FloatArray, ahead: FloatArray, sheet: Sheet, half: float
) -> tuple[FloatArray, FloatArray]:
    """Least and greatest coordinates of the body of that half thickness, pixels."""
    push = thickness(sheet, half)[:, None] * ahead[None]
    return np.minimum(flat - push, flat + push).min(0), np.maximum(flat - push, flat + push).max(0)
