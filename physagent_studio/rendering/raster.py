"""A triangle rasteriser in NumPy: which face each pixel centre sees, and where on it.

A pixel's ray is d = (x, y, 1) in the camera frame. With the triangle's corners A, B, C as
vectors from the optical centre, the three products d·(B×C), d·(C×A), d·(A×B) are its
unnormalised barycentric coordinates, perspective included, and stay right for triangles that
reach behind the camera, so nothing is clipped (Olano & Greer, "Triangle scan conversion using
2D homogeneous coordinates", 1997). They are linear in the pixel, so that each row of a
triangle is one span, found by division rather than by testing its bounding box.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from physagent_studio.arrays import FloatArray

IntArray = NDArray[np.int32]

NEAR = 1e-4
"""Points closer to the camera plane than this (m) are not drawn."""
_SLACK = 1e-7
"""Spans reach this far (pixels) over their ends, so that neighbours leave no crack."""


@dataclass(frozen=True, eq=False, slots=True)
class Lens:
    """How camera-frame points land on pixels: focal and principal point in pixels."""

    width: int
    height: int
    focal: float
    cx: float
    cy: float

    def project(self, points: FloatArray) -> FloatArray:
        """Camera-frame points (N, 3), z > 0 → pixels (N, 2)."""
        scaled = self.focal * points[:, :2] / points[:, 2:]
        return scaled + np.array([self.cx, self.cy])


@dataclass(frozen=True, eq=False, slots=True)
class Hits:
    """What the pixels see, one row per pixel that sees a face.

    pixel: (K,) int64 flat index, ascending. face: (K,) int32 row of the face array.
    weights: (K, 3) float64 barycentric coordinates. depth: (K,) float64, along the axis, m.
    """

    pixel: NDArray[np.int64]
    face: IntArray
    weights: FloatArray
    depth: FloatArray


@dataclass(frozen=True, eq=False, slots=True)
class Facets:
    """Faces ready to be scanned.

    face: (F,) int32 original rows. sides: the planes of the corners, one after the other, each as
    three (F,) coefficients of x, y and 1, in units where a point inside has all products ≥ 0.
    order: the same of what decides who is in front (larger wins). rows: (F, 2) int32 first and last
    pixel row.
    """

    face: IntArray
    sides: tuple[Plane, Plane, Plane]
    order: Plane
    rows: IntArray


Plane = tuple[FloatArray, FloatArray, FloatArray]


def facets(points: FloatArray, faces: IntArray, lens: Lens, one_sided: NDArray[np.bool_]) -> Facets:
    """Prepare the faces that can be seen.

    points: (V, 3) camera frame. faces: (F, 3), counter-clockwise from outside.
    one_sided: (F,) faces whose back is never drawn (those of closed meshes).
    """
    k, rows = _candidates(points, faces, lens, one_sided)
    x, y, z = (np.ascontiguousarray(points[:, axis]) for axis in range(3))
    a, b, c = (_picked(faces[k, corner], x, y, z) for corner in range(3))
    bc = _cross(b, c)
    volume = a[0] * bc[0] + a[1] * bc[1] + a[2] * bc[2]
    # A face looks at the camera where its outward normal does: A·n < 0, and A·n is the volume.
    seen = (np.abs(volume) > 1e-18) & ((volume < 0) | ~one_sided[k])
    inverse = 1 / np.where(seen, volume, 1.0)
    across = inverse / lens.focal
    sides = [
        (part[0] * across, part[1] * across, part[2] * inverse)
        for part in (bc, _cross(c, a), _cross(a, b))
    ]
    # A face that is left out after all has no rows.
    rows[~seen] = (0, -1)
    return Facets(k, (sides[0], sides[1], sides[2]), _sum(sides, None), rows)


def flat_facets(
    points: FloatArray,
    depth: FloatArray,
    faces: IntArray,
    lens: Lens,
    one_sided: NDArray[np.bool_],
) -> Facets:
    """Faces for a parallel projection, the far surface in front.

    points: (V, 2) pixels from the principal point. depth: (V,), larger wins. one_sided: (F,) faces
    that are left out where their outside looks at the viewer.
    """
    x, y = np.ascontiguousarray(points[:, 0]), np.ascontiguousarray(points[:, 1])
    at_x, at_y = ([v[faces[:, corner]] for corner in range(3)] for v in (x, y))
    volume = (at_x[1] - at_x[0]) * (at_y[2] - at_y[0]) - (at_x[2] - at_x[0]) * (at_y[1] - at_y[0])
    rows, touching = _rows(at_x, at_y, lens)
    drawn = np.where(one_sided, volume > 1e-12, np.abs(volume) > 1e-12)
    k = np.flatnonzero(drawn & touching).astype(np.int32)
    one = np.ones(len(k))
    a, b, c = ((at_x[i][k], at_y[i][k], one) for i in range(3))
    sides = [
        (part[0] / volume[k], part[1] / volume[k], part[2] / volume[k])
        for part in (_cross(b, c), _cross(c, a), _cross(a, b))
    ]
    weights = [depth[faces[k, corner]] for corner in range(3)]
    return Facets(k, (sides[0], sides[1], sides[2]), _sum(sides, weights), rows[k])


def scan(facets: Facets, lens: Lens) -> tuple[NDArray[np.int64], IntArray, NDArray[np.float32]]:
    """Scan convert: flat pixels, rows of `facets` and priority of the winner at each pixel."""
    row_of, y = _expand(facets.rows[:, 0], facets.rows[:, 1])
    yc = y.astype(np.float64) + (0.5 - lens.cy)
    left, right = _spans(facets, row_of, yc, lens)
    some = np.flatnonzero(left <= right)
    row_of, y, yc, left, right = row_of[some], y[some], yc[some], left[some], right[some]
    span, x = _expand(left, right)
    along, down, offset = (part[row_of] for part in facets.order)
    base = down * yc + offset + along * (0.5 - lens.cx)
    # NumPy would promote int32 × float32 to float64 and the comparison below would then fail.
    priority = (base[span] + along[span] * x).astype(np.float32)
    pixel = (y * np.int64(lens.width))[span] + x
    front = np.full(lens.width * lens.height, -np.inf, np.float32)
    np.maximum.at(front, pixel, priority)
    won = np.flatnonzero(priority >= front[pixel])
    winner = np.full(lens.width * lens.height, -1, np.int32)
    winner[pixel[won]] = row_of[span[won]]
    seen = np.flatnonzero(winner >= 0)
    return seen, winner[seen], front[seen]


def rasterise(
    points: FloatArray, faces: IntArray, lens: Lens, one_sided: NDArray[np.bool_]
) -> Hits:
    """What every pixel centre of a perspective camera sees; see `facets` for the arguments."""
    prepared = facets(points, faces, lens, one_sided)
    pixel, row, _ = scan(prepared, lens)
    down, across = np.divmod(pixel, lens.width)
    x, y = across + (0.5 - lens.cx), down + (0.5 - lens.cy)
    weights = np.empty((len(pixel), 3))
    for corner, (along, below, offset) in enumerate(prepared.sides):
        weights[:, corner] = along[row] * x + below[row] * y + offset[row]
    inverse = weights[:, 0] + weights[:, 1] + weights[:, 2]
    weights /= inverse[:, None]
    return Hits(pixel, prepared.face[row], weights, 1.0 / inverse)


def between(hits: Hits, values: FloatArray, faces: IntArray) -> FloatArray:
    """(K, C) at each hit, between what the corners of its face have: values (V, C)."""
    # `take` is three times as fast as brackets here.
    rows = faces.take(hits.face, 0)
    found = hits.weights[:, :1] * values.take(rows[:, 0], 0)
    for corner in (1, 2):
        found += hits.weights[:, corner, None] * values.take(rows[:, corner], 0)
    return found


def _picked(rows: IntArray, *values: FloatArray) -> Plane:
    x, y, z = (value[rows] for value in values)
    return x, y, z


def _cross(a: Plane, b: Plane) -> Plane:
    """a × b of vectors given by their parts."""
    return a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]


def _sum(sides: list[Plane], weights: list[FloatArray] | None) -> Plane:
    """The planes together, each times its weight (F,), 1 for None."""
    first, second, third = weights or (1.0, 1.0, 1.0)
    a, b, c = sides
    x, y, z = (first * a[i] + second * b[i] + third * c[i] for i in range(3))
    return x, y, z


def _range(corners: list[FloatArray]) -> tuple[FloatArray, FloatArray]:
    """Least and greatest (F,) of three values; ten times as fast as min(1)."""
    a, b, c = corners
    return np.minimum(np.minimum(a, b), c), np.maximum(np.maximum(a, b), c)


def _rows(
    x: list[FloatArray], y: list[FloatArray], lens: Lens
) -> tuple[IntArray, NDArray[np.bool_]]:
    """First and last row (F, 2) of faces from their corners, and (F,) whether they touch a pixel.

    x, y: (F,) of each corner, pixels from the principal point.
    """
    top, bottom = _range(y)
    rows = np.empty((len(top), 2), np.int32)
    shift = lens.cy - 0.5
    rows[:, 0] = np.ceil(np.clip(top + (shift - _SLACK), 0, lens.height))
    rows[:, 1] = np.floor(np.clip(bottom + (shift + _SLACK), -1, lens.height - 1))
    left, right = _range(x)
    shift = lens.cx - 0.5
    first = np.ceil(np.maximum(left + (shift - _SLACK), 0))
    last = np.floor(np.minimum(right + (shift + _SLACK), lens.width - 1))
    return rows, (rows[:, 0] <= rows[:, 1]) & (first <= last)


def _candidates(
    points: FloatArray, faces: IntArray, lens: Lens, one_sided: NDArray[np.bool_]
) -> tuple[IntArray, IntArray]:
    """Faces that may touch a pixel, and their first and last row (K, 2), from their corners.

    Most faces of a mesh look away or lie between pixels; they go before anything costly.
    """
    behind = points[:, 2] < NEAR
    scale = lens.focal / np.where(behind, 1.0, points[:, 2])
    x, y = points[:, 0] * scale, points[:, 1] * scale
    corner = [np.ascontiguousarray(faces[:, i]) for i in range(3)]
    at_x, at_y = [x[c] for c in corner], [y[c] for c in corner]
    area = (at_x[1] - at_x[0]) * (at_y[2] - at_y[0]) - (at_x[2] - at_x[0]) * (at_y[1] - at_y[0])
    some = np.any(behind)
    facing = np.flatnonzero((area < 0) | ~one_sided) if not some else np.arange(len(faces))
    rows, keep = _rows([v[facing] for v in at_x], [v[facing] for v in at_y], lens)
    if some:
        count = sum((behind[c].astype(np.int8) for c in corner), np.zeros(len(faces), np.int8))
        keep = np.where(count > 0, count < 3, keep & ((area < 0) | ~one_sided))
        rows[count > 0] = (0, lens.height - 1)
    kept = np.flatnonzero(keep)
    return facing[kept].astype(np.int32), rows[kept]


def _expand(first: IntArray, last: IntArray) -> tuple[IntArray, IntArray]:
    """Each range first … last written out: (index of the range, value in it)."""
    count = last - first + 1
    index = np.repeat(np.arange(len(count), dtype=np.int32), count)
    start = first - (np.cumsum(count, dtype=np.int64) - count)
    return index, (np.arange(len(index), dtype=np.int64) + start[index]).astype(np.int32)


def _spans(
    facets: Facets, row_of: IntArray, yc: FloatArray, lens: Lens
) -> tuple[IntArray, IntArray]:
    """First and last pixel of each row of a face; empty where first > last."""
    low, high = np.full(len(yc), -np.inf), np.full(len(yc), np.inf)
    for along, down, offset in facets.sides:
        slope = along[row_of]
        at_zero = down[row_of] * yc + offset[row_of]
        with np.errstate(divide="ignore", invalid="ignore"):
            crossing = -at_zero / slope
        low = np.maximum(low, np.where(slope > 0, crossing, -np.inf))
        high = np.minimum(high, np.where(slope < 0, crossing, np.inf))
        # A side that runs along the row has the whole row on one hand.
        high[(slope == 0) & (at_zero < 0)] = -np.inf
    shift = lens.cx - 0.5
    left = np.ceil(np.clip(low + (shift - _SLACK), 0, lens.width))
    right = np.floor(np.clip(high + (shift + _SLACK), -1, lens.width - 1))
    return left.astype(np.int32), right.astype(np.int32)
