"""Concave bodies cut into convex pieces along the gaps of their silhouette.

A stool seen from the front is a seat with two legs; its hull is a block. The body is looked at
along the body axis that shows the most gaps, the silhouette is cut by level and upright lines
until what is left is nearly convex, and the surface over each part becomes one convex piece. Fast,
and the same on every machine; hollows that no silhouette shows are left to `convex`.
"""

from dataclasses import dataclass
from functools import lru_cache

import cv2
import numpy as np
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components
from trimesh.remesh import subdivide_to_size

from physagent_studio.arrays import BoolArray
from physagent_studio.simulation.surfaces import FloatArray, Surface, hull

CELLS = 96
"""Cells along the longer side of a silhouette."""
LEFT = 0.04
"""Share of its area by which the hulls of the parts may exceed a silhouette."""
GAIN = 0.012
"""Least share of the area that a cut has to free."""
CLOSED = 0.06
"""Share of the area by which the hull of a part exceeds it that no single cut frees: a ring."""
MOST = 12
"""Pieces of one closed part of a body."""
OF_WHOLE = 0.3
"""A part of a body is cut as finely as if it were this share of the body's silhouette."""
SMALL = 0.002
"""Parts of a smaller share of the area are left out."""


def carved(surface: Surface) -> tuple[Surface, ...]:
    """Convex pieces of a closed surface, at least one; equal surfaces give equal pieces."""
    return _carved(_Key(surface))


class _Key:
    """A surface that is known by its content."""

    def __init__(self, surface: Surface) -> None:
        self.surface = surface
        self._bytes = surface[0].tobytes() + surface[1].tobytes()

    def __hash__(self) -> int:
        return hash(self._bytes)

    def __eq__(self, other: object) -> bool:
        return isinstance(other, _Key) and other._bytes == self._bytes


@lru_cache(maxsize=64)
def _carved(key: _Key) -> tuple[Surface, ...]:
    whole = _largest(key.surface[0])
    pieces = [piece for part in _closed_parts(key.surface) for piece in _pieces(part, whole)]
    return tuple(pieces) or (hull(key.surface[0], "body"),)


def _closed_parts(surface: Surface) -> list[Surface]:
    """The parts of a surface that share no vertex, each a surface of its own."""
    vertices, faces = surface
    edges = faces[:, [0, 1, 1, 2]].reshape(-1, 2)
    ones = np.ones(len(edges), np.int8)
    graph = coo_array((ones, (edges[:, 0], edges[:, 1])), shape=(len(vertices), len(vertices)))
    count, labels = connected_components(graph, directed=False)
    parts = []
    for label in range(count):
        own = faces[labels[faces[:, 0]] == label]
        if len(own) >= 4:
            used, index = np.unique(own, return_inverse=True)
            parts.append((vertices[used], index.reshape(-1, 3).astype(np.int32)))
    return parts


def _largest(points: FloatArray) -> float:
    """m²: the largest silhouette that points (N, 3) can have along a body axis, as a box."""
    x, y, z = (float(value) for value in np.ptp(points, axis=0))
    return max(x * y, x * z, y * z)


def _pieces(part: Surface, whole: float) -> list[Surface]:
    """whole: silhouette of the body that the part belongs to, m²."""
    view = min((_view(part, axis) for axis in range(3)), key=lambda view: view.filled)
    vertices = _dense(part, view.cell)
    out = []
    for region in _regions(view.mask, OF_WHOLE * whole / view.cell**2):
        points = vertices[view.inside(vertices, region)]
        if _is_solid(points):
            out.append(hull(points, "piece"))
    return out


def _is_solid(points: FloatArray) -> bool:
    """Whether points (N, 3) span a volume."""
    if len(points) < 4:
        return False
    spread = np.linalg.svd(points - points.mean(0), compute_uv=False)
    return bool(spread[2] > 1e-4 * spread[0])


@dataclass(frozen=True, eq=False, slots=True)
class _View:
    """The silhouette (H, W) of a surface along a body axis.

    axes: the body axes across and up in it. low: (2,) where its first cell begins, m. cell: m.
    filled: its area over that of its hull.
    """

    mask: BoolArray
    axes: tuple[int, int]
    low: FloatArray
    cell: float
    filled: float

    def inside(self, vertices: FloatArray, region: BoolArray) -> BoolArray:
        """Which vertices (V, 3) lie over a region (H, W) or within a cell of it."""
        wide = cv2.dilate(region.astype(np.uint8), np.ones((3, 3), np.uint8))
        at = ((vertices[:, self.axes] - self.low) / self.cell).astype(int)
        column = np.clip(at[:, 0], 0, region.shape[1] - 1)
        row = np.clip(at[:, 1], 0, region.shape[0] - 1)
        return wide[row, column] > 0


def _view(part: Surface, axis: int) -> _View:
    vertices, faces = part
    axes = [(1, 2), (0, 2), (0, 1)][axis]
    flat = vertices[:, axes]
    low, size = flat.min(0), np.ptp(flat, axis=0)
    cell = float(size.max()) / CELLS or 1.0
    low = low - 1.5 * cell
    shape = np.ceil(size / cell).astype(int) + 4
    canvas = np.zeros((shape[1], shape[0]), np.uint8)
    corners = np.round(((flat - low) / cell - 0.5) * 16).astype(np.int32)
    for triangle in corners[faces]:
        cv2.fillConvexPoly(canvas, triangle, 1, shift=4)
    mask = canvas.astype(bool)
    return _View(mask, axes, low, cell, np.count_nonzero(mask) / max(_hull_area(mask), 1.0))


def _dense(part: Surface, cell: float) -> FloatArray:
    """Vertices of the surface, its long edges divided so that every cell of it holds some."""
    vertices, faces = part
    edges = vertices[faces] - vertices[np.roll(faces, 1, axis=1)]
    if float(np.linalg.norm(edges, axis=2).max()) <= 3 * cell:
        return vertices
    return np.asarray(subdivide_to_size(vertices, faces, 2 * cell, max_iter=20)[0], float)


def _regions(mask: BoolArray, least: float) -> list[BoolArray]:
    """Nearly convex parts of a silhouette. least: an area below which it counts as that, cells."""
    area = max(int(np.count_nonzero(mask)), least)
    parts = _components(mask)
    while len(parts) < MOST:
        spare = [_hull_area(part) - np.count_nonzero(part) for part in parts]
        if sum(spare) <= LEFT * area:
            break
        worst = int(np.argmax(spare))
        cut = _best_cut(parts[worst], GAIN * area)
        if cut is None and spare[worst] > CLOSED * area:
            # One cut frees nothing of a ring, but what is left of it can be cut.
            cut = _halves(parts[worst])
        if cut is None:
            break
        parts[worst : worst + 1] = cut
    return [part for part in parts if np.count_nonzero(part) > SMALL * area]


def _best_cut(part: BoolArray, least: float) -> list[BoolArray] | None:
    """The parts after the level or upright cut that frees most area; None if below `least`."""
    whole = _hull_area(part)
    rows, columns = np.flatnonzero(part.any(1)), np.flatnonzero(part.any(0))
    window = slice(rows[0], rows[-1] + 1), slice(columns[0], columns[-1] + 1)
    inner = part[window]
    best: tuple[float, list[BoolArray]] | None = None
    for turned in (inner, inner.T):
        for line in range(1, len(turned)):
            sides = turned[:line], turned[line:]
            freed = whole - sum(_hull_area(piece) for side in sides for piece in _components(side))
            if best is None or freed > best[0] + 1e-9:
                cut = [np.zeros_like(turned), np.zeros_like(turned)]
                cut[0][:line], cut[1][line:] = sides
                best = (freed, [one if turned is inner else one.T for one in cut])
    if best is None or best[0] < least:
        return None
    return [piece for side in best[1] for piece in _components(_widened(side, window, part))]


def _widened(inner: BoolArray, window: tuple[slice, slice], like: BoolArray) -> BoolArray:
    out = np.zeros_like(like)
    out[window] = inner
    return out


def _halves(part: BoolArray) -> list[BoolArray]:
    rows, columns = np.flatnonzero(part.any(1)), np.flatnonzero(part.any(0))
    sides = [part.copy(), part.copy()]
    if np.ptp(rows) > np.ptp(columns):
        line = int(rows.mean()) + 1
        sides[0][line:], sides[1][:line] = False, False
    else:
        line = int(columns.mean()) + 1
        sides[0][:, line:], sides[1][:, :line] = False, False
    return [piece for side in sides for piece in _components(side)]


def _components(mask: BoolArray) -> list[BoolArray]:
    count, labels = cv2.connectedComponents(mask.astype(np.uint8))
    return [labels == label for label in range(1, count)]


def _hull_area(mask: BoolArray) -> float:
    """Area of the convex hull of a mask, in cells."""
    rows = np.flatnonzero(mask.any(1))
    if not len(rows):
        return 0.0
    first = mask[rows].argmax(1)
    last = mask.shape[1] - mask[rows][:, ::-1].argmax(1)
    corners = np.concatenate(
        [np.column_stack([x, rows + down]) for x in (first, last) for down in (0, 1)]
    )
    return float(cv2.contourArea(cv2.convexHull(corners.astype(np.float32))))
