"""A solid from a silhouette: the outline as the picture shows it, a plausible depth behind it.

The mask is laid on an upright plane that faces the camera and given a thickness there. Round
things swell like a membrane under pressure; things whose usual depth is larger than that (a
car, a house) get flat sides with a bevelled rim, so that they stand on a flat base.
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
from physagent_studio.reconstruction.geometry import on_upright_through
from physagent_studio.reconstruction.masks import BoolArray, bounds
from physagent_studio.reconstruction.meshes import volume_and_centre
from physagent_studio.records.scene import Mesh

FloatArray = NDArray[np.float64]
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
    vertices = (vertices - (low + high) / 2) * scale
    _, centre = volume_and_centre(vertices, faces.astype(np.int32))
    return Mesh(vertices - centre, faces.astype(np.int32))


def _upright(
    mask: BoolArray, camera: Camera, depth_share: float
) -> tuple[FloatArray, NDArray[np.int64]]:
    """World vertices around a plane one unit away, and faces; depth is a share of the width."""
    sheet = _sheet(mask)
    x0, y0, x1, y1 = bounds(mask)
    middle = np.array([(x0 + x1) / 2, (y0 + y1) / 2])
    ray = camera.rays(middle[None])[0]
    ahead = np.array([ray[0], ray[1], 0.0])
    ahead /= max(float(np.hypot(*ahead[:2])), 1e-9)
    centre = np.asarray(camera.position) + ray
    flat = on_upright_through(camera, sheet.pixels, centre, ahead)
    half = depth_share * (x1 - x0) / 2
    swell, inset = sheet.swell, sheet.inset
    most = float(swell.max(initial=1e-9))
    if half <= 1.15 * most:
        thick = swell * (half / most)
    else:
        bevel = 0.25 * float(np.median(inset[~sheet.rim])) + 1.0
        thick = half * (0.8 + 0.2 * np.sqrt(1 - (1 - np.clip(inset / bevel, 0, 1)) ** 2))
    # One pixel at the plane is 1 / focal units, for the plane is one unit away.
    push = (thick / camera.focal)[:, None] * ahead[None]
    vertices = np.vstack([flat - push, flat + push])
    return _closed(vertices, sheet, thick)


def _closed(
    vertices: FloatArray, sheet: _Sheet, thick: FloatArray
) -> tuple[FloatArray, NDArray[np.int64]]:
    """Front and back sheet joined along the rim, faces outward."""
    count = len(sheet.pixels)
    faces = [sheet.faces, sheet.faces[:, ::-1] + count]
    if thick[sheet.rim].max(initial=0.0) > 1e-9:
        edges = _border(sheet.faces)
        a, b = edges[:, 0], edges[:, 1]
        faces.append(np.stack([b, a, a + count], 1))
        faces.append(np.stack([b, a + count, b + count], 1))
        return vertices, np.vstack(faces)
    merged = np.arange(2 * count)
    merged[count:][sheet.rim] = np.flatnonzero(sheet.rim)
    joined = merged[np.vstack(faces)]
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
    swell = _membrane(inside) * step
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


def _membrane(inside: BoolArray) -> FloatArray:
    """Half thickness in cells of a body swollen over a region: √ of a Poisson solution."""
    count = int(np.count_nonzero(inside))
    out = np.zeros(inside.shape)
    if not count:
        return out
    index = np.full(np.add(inside.shape, 2), -1)
    index[1:-1, 1:-1][inside] = np.arange(count)
    rows, columns = np.nonzero(index >= 0)
    own = index[rows, columns]
    entries = [(own, own, np.full(count, 4.0))]
    for dy, dx in ((0, 1), (0, -1), (1, 0), (-1, 0)):
        near = index[rows + dy, columns + dx]
        some = near >= 0
        entries.append((own[some], near[some], np.full(int(some.sum()), -1.0)))
    r, c, v = (np.concatenate(part) for part in zip(*entries, strict=True))
    matrix = sparse.csc_matrix((v, (r, c)), (count, count))
    pressed = np.asarray(spsolve(matrix, np.full(count, 4.0)), float)
    out[inside] = np.sqrt(np.maximum(pressed, 0))
    return out
