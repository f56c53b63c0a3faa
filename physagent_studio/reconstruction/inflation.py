"""A solid from a silhouette: the outline as the picture shows it, a plausible depth behind it.

The mask is laid on an upright plane that faces the camera and given a thickness there. Round
things swell like a membrane under pressure; things whose usual depth is larger than that (a
car, a house) get flat sides with a bevelled rim. What stands was cut level where it touches the
ground, for a thing that is seen to stand has a base to stand on.
"""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray
from scipy import sparse
from scipy.sparse.linalg import spsolve

from physagent_studio.program.camera import Camera
from physagent_studio.program.scene import Inflated
from physagent_studio.reconstruction.footing import across_the_feet, levelled
from physagent_studio.reconstruction.geometry import depth_of, on_upright_through
from physagent_studio.reconstruction.masks import BoolArray, bounds
from physagent_studio.reconstruction.meshes import volume_and_centre
from physagent_studio.records.scene import Mesh

FloatArray = NDArray[np.float64]
FOOT = 0.04
"""Lowest share of a silhouette's height that may touch the ground."""
CELLS = 60
FINEST = 110
"""Cells of the grid along the longer side of the silhouette: usual, and at most."""


@dataclass(frozen=True, eq=False, slots=True)
class _Sheet:
    """The silhouette as a flat grid: pixel places (V, 2), faces (F, 3), rim flags (V,),

    swell (V,) half thickness of a round body and inset (V,) distance to the outline, pixels.
    """

    pixels: FloatArray
    faces: NDArray[np.int64]
    rim: BoolArray
    swell: FloatArray
    inset: FloatArray


def natural_depth(mask: BoolArray) -> float:
    """Thickness in pixels of the round body over a mask."""
    return 2.0 * float(_sheet(mask).swell.max(initial=0.0))


def inflated_mesh(mask: BoolArray, camera: Camera, shape: Inflated) -> Mesh:
    """The mesh of an `Inflated` shape, body frame, its bounding box as `shape.size` says.

    It depends on where the mask lies in the picture and on how the camera looks, not on how far
    away the object is, so that moving the object does not change its body.
    """
    vertices, faces = _upright(mask, camera, shape.size[1] / max(shape.size[0], 1e-9))
    low, high = vertices.min(0), vertices.max(0)
    scale = np.array(shape.size) / np.maximum(high - low, 1e-12)
    vertices = levelled((vertices - (low + high) / 2) * scale, faces.astype(np.int32))
    _, centre = volume_and_centre(vertices, faces.astype(np.int32))
    return Mesh(vertices - centre, faces.astype(np.int32))


def sheet_on_plane(
    mask: BoolArray, camera: Camera, point: FloatArray
) -> tuple[FloatArray, NDArray[np.int64]]:
    """World vertices (V, 3), m, and faces of the round body over a mask, around the upright plane

    through `point` that faces the camera.
    """
    sheet = _sheet(mask)
    ahead = np.asarray(point, float) - np.asarray(camera.position)
    ahead[2] = 0.0
    ahead /= max(float(np.hypot(*ahead[:2])), 1e-9)
    flat = on_upright_through(camera, sheet.pixels, point, ahead)
    pixel = depth_of(camera, point) / camera.focal
    push = (sheet.swell * pixel)[:, None] * ahead[None]
    return _closed(np.vstack([flat - push, flat + push]), sheet, sheet.swell)


def upright_extent(mask: BoolArray, camera: Camera, depth: float) -> tuple[float, float, float]:
    """Extent (x, y, z) of a body over a mask one unit away, world axes.

    depth: its thickness through the upright plane on which the mask is laid, pixels.
    """
    low, high = _box(*_laid(mask, camera), depth / 2)
    x, y, z = (float(value) for value in high - low)
    return x, y, z


def _upright(
    mask: BoolArray, camera: Camera, depth_share: float
) -> tuple[FloatArray, NDArray[np.int64]]:
    """World vertices around a plane one unit away, and faces.

    depth_share: extent of the result along y as a share of that along x.
    """
    flat, ahead, sheet = _laid(mask, camera)
    x0, y0, x1, y1 = bounds(mask)
    least, most = 0.0, 6.0 * max(x1 - x0, y1 - y0)
    for _ in range(30):
        half = (least + most) / 2
        low, high = _box(flat, ahead, sheet, half)
        extent = high - low
        if extent[1] < depth_share * extent[0]:
            least = half
        else:
            most = half
    thick = _thickness(sheet, most)
    push = thick[:, None] * ahead[None]
    return _closed(np.vstack([flat - push, flat + push]), sheet, thick)


def _laid(mask: BoolArray, camera: Camera) -> tuple[FloatArray, FloatArray, _Sheet]:
    """The silhouette on an upright plane: places (V, 3) m, the level unit vector through the

    plane scaled to a pixel (1 / focal, for the plane is one unit away), and the sheet.
    """
    sheet = _sheet(mask)
    x0, y0, x1, y1 = bounds(mask)
    middle = np.array([(x0 + x1) / 2, (y0 + y1) / 2])
    ray = camera.rays(middle[None])[0]
    ahead = np.array([ray[0], ray[1], 0.0])
    ahead /= max(float(np.hypot(*ahead[:2])), 1e-9)
    ahead = across_the_feet(mask, camera, ahead)
    centre = np.asarray(camera.position) + ray
    flat = on_upright_through(camera, sheet.pixels, centre, ahead)
    return flat, ahead / camera.focal, sheet


def _box(
    flat: FloatArray, ahead: FloatArray, sheet: _Sheet, half: float
) -> tuple[FloatArray, FloatArray]:
    """Least and greatest coordinates of the body of that half thickness, pixels."""
    push = _thickness(sheet, half)[:, None] * ahead[None]
    return np.minimum(flat - push, flat + push).min(0), np.maximum(flat - push, flat + push).max(0)


def _thickness(sheet: _Sheet, half: float) -> FloatArray:
    """Half thickness (V,) of a body that is 2 · half pixels deep: round, or flat with a bevel."""
    most = float(sheet.swell.max(initial=1e-9))
    if half <= 1.15 * most:
        return sheet.swell * (half / most)
    bevel = 0.25 * float(np.median(sheet.inset[~sheet.rim])) + 1.0
    return half * (0.8 + 0.2 * np.sqrt(1 - (1 - np.clip(sheet.inset / bevel, 0, 1)) ** 2))


def _closed(
    vertices: FloatArray, sheet: _Sheet, thick: FloatArray
) -> tuple[FloatArray, NDArray[np.int64]]:
    """Front and back sheet joined along the rim, faces outward.

    Where the rim has no thickness its two vertices become one, elsewhere a wall joins them.
    """
    count = len(sheet.pixels)
    edges = _border(sheet.faces)
    a, b = edges[:, 0], edges[:, 1]
    walls = [np.stack([b, a, a + count], 1), np.stack([b, a + count, b + count], 1)]
    merged = np.arange(2 * count)
    sharp = np.flatnonzero(sheet.rim & (thick <= 1e-9))
    merged[count + sharp] = sharp
    joined = merged[np.vstack([sheet.faces, sheet.faces[:, ::-1] + count, *walls])]
    first, second, third = joined.T
    joined = joined[(first != second) & (second != third) & (third != first)]
    used, compact = np.unique(joined, return_inverse=True)
    return vertices[used], compact.reshape(joined.shape)


def _border(faces: NDArray[np.int64]) -> NDArray[np.int64]:
    """Directed edges (E, 2) that belong to one face alone."""
    edges = np.vstack([faces[:, [0, 1]], faces[:, [1, 2]], faces[:, [2, 0]]])
    big = int(faces.max()) + 1
    forward = edges[:, 0] * big + edges[:, 1]
    backward = edges[:, 1] * big + edges[:, 0]
    return edges[~np.isin(forward, backward)]


def _sheet(mask: BoolArray) -> _Sheet:
    x0, y0, x1, y1 = bounds(mask)
    pad = 8
    window = np.pad(mask[y0:y1, x0:x1], pad).astype(np.uint8)
    signed = cv2.distanceTransform(window, cv2.DIST_L2, 5)
    signed = signed - cv2.distanceTransform(1 - window, cv2.DIST_L2, 5)
    # Thin parts need a finer grid: a pole shall be at least two cells wide.
    inset = signed[signed > 0]
    thin = float(np.median(inset)) if len(inset) else 1.0
    longest = max(x1 - x0, y1 - y0)
    step = max(1.0, longest / FINEST, min(longest / CELLS, thin))
    gx, gy = np.meshgrid(
        np.arange(pad - step, pad + x1 - x0 + 2 * step, step),
        np.arange(pad - step, pad + y1 - y0 + 2 * step, step),
    )
    field = cv2.remap(
        signed.astype(np.float32),
        (gx - 0.5).astype(np.float32),
        (gy - 0.5).astype(np.float32),
        cv2.INTER_LINEAR,
        borderMode=cv2.BORDER_CONSTANT,
        borderValue=-99,
    )
    inside = field > 0
    ring = cv2.dilate(inside.astype(np.uint8), np.ones((3, 3), np.uint8)).astype(bool) & ~inside
    slope_x = cv2.Sobel(field, cv2.CV_32F, 1, 0, ksize=3)
    slope_y = cv2.Sobel(field, cv2.CV_32F, 0, 1, ksize=3)
    steep = np.hypot(slope_x, slope_y) + 1e-6
    shift = np.clip(-field, 0, 1.5 * step)
    px = gx + np.where(ring, slope_x / steep * shift, 0)
    py = gy + np.where(ring, slope_y / steep * shift, 0)
    foot = _foot(inside)
    swell = _membrane(inside, foot) * step
    below = np.zeros_like(foot)
    below[1:] = foot[:-1]
    below &= ring
    swell[below] = swell[:-1][below[1:]]
    used = inside | ring
    number = np.full(used.shape, -1)
    number[used] = np.arange(np.count_nonzero(used))
    a, b, c, d = number[:-1, :-1], number[:-1, 1:], number[1:, :-1], number[1:, 1:]
    faces = np.vstack([np.stack([t.ravel() for t in tri], 1) for tri in ((a, c, b), (b, c, d))])
    # Cells between two parts of the ring alone lie outside.
    core = np.append(inside[used], False)
    faces = faces[(faces >= 0).all(1) & core[faces].any(1)]
    pixels = np.stack([px[used] - pad + x0, py[used] - pad + y0], 1)
    return _Sheet(pixels, faces, ring[used], swell[used], np.maximum(field[used], 0))


def _foot(inside: BoolArray) -> BoolArray:
    """The lowest cells of a region: it goes on below, for a thing stands on more than a line."""
    rows = np.flatnonzero(inside.any(1))
    out = np.zeros_like(inside)
    if len(rows):
        from_row = rows[-1] - max(1, round(FOOT * len(rows))) + 1
        out[from_row:] = inside[from_row:]
    return out


def _membrane(inside: BoolArray, foot: BoolArray) -> FloatArray:
    """Half thickness in cells of a body swollen over a region: √ of a Poisson solution.

    It is held flat along the outline, but for the lower side of cells of the foot.
    """
    count = int(np.count_nonzero(inside))
    out = np.zeros(inside.shape)
    if not count:
        return out
    index = np.full(np.add(inside.shape, 2), -1)
    index[1:-1, 1:-1][inside] = np.arange(count)
    rows, columns = np.nonzero(index >= 0)
    own = index[rows, columns]
    open_below = foot[rows - 1, columns - 1] & (index[rows + 1, columns] < 0)
    entries = [(own, own, 4.0 - open_below)]
    for dy, dx in ((0, 1), (0, -1), (1, 0), (-1, 0)):
        near = index[rows + dy, columns + dx]
        some = near >= 0
        entries.append((own[some], near[some], np.full(int(some.sum()), -1.0)))
    r, c, v = (np.concatenate(part) for part in zip(*entries, strict=True))
    matrix = sparse.csc_matrix((v, (r, c)), (count, count))
    pressed = np.asarray(spsolve(matrix, np.full(count, 4.0)), float)
    out[inside] = np.sqrt(np.maximum(pressed, 0))
    return out
