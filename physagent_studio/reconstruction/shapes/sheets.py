"""A silhouette as a flat grid of triangles, and the closed body that two of them make."""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray
from scipy import sparse
from scipy.sparse.linalg import spsolve

from physagent_studio.arrays import FloatArray
from physagent_studio.reconstruction.photo.regions import BoolArray, bounds, grow


@dataclass(frozen=True, slots=True)
class SheetSettings:
    """How a silhouette becomes a body."""

    foot_share: float = 0.04  # 0..0.2: of its height from below, that may touch the ground
    # 1..3: of depth over the round body's: deeper ones have flat sides
    max_round_ratio: float = 1.6
    # 0..2: over the usual inset and the depth: rim of what is cut straight through
    bevel_ratios: tuple[float, float] = (1.0, 0.5)
    chamfer_ratios: tuple[float, float] = (0.25, 0.2)  # 0..2: the same of what is deeper than round
    cells_count: int = 60  # 20..200: of the grid along the longer side
    max_cells: int = 110  # count, 40..400: along it, for thin parts
    # 0.01..0.2: of a cell, that the outline is away from its middle: nearer, the matrix is stiff
    nearest_share: float = 0.05


SHEET = SheetSettings()


@dataclass(frozen=True, eq=False, slots=True)
class Sheet:
    """The silhouette as a flat grid: pixel places (V, 2), faces (F, 3), rim flags (V,),

    swell (V,) half thickness of a round body and inset (V,) distance to the outline, pixels.
    straight: the body over it is not round.
    """

    pixels: FloatArray
    faces: NDArray[np.int64]
    rim: BoolArray
    swell: FloatArray
    inset: FloatArray
    straight: bool = False

    def straight_at(self, half: float) -> bool:
        """Whether a body that is 2 · half pixels deep has flat sides."""
        return self.straight or half > SHEET.max_round_ratio * float(self.swell.max(initial=1e-9))


def thickness(sheet: Sheet, half: float) -> FloatArray:
    """Half thickness (V,) of a body that is 2 · half pixels deep: round, or flat with a bevel."""
    if not sheet.straight_at(half):
        return sheet.swell * (half / float(sheet.swell.max(initial=1e-9)))
    wide, deep = SHEET.bevel_ratios if sheet.straight else SHEET.chamfer_ratios
    bevel = wide * float(np.median(sheet.inset[~sheet.rim])) + 1.0
    rise = np.sqrt(1 - (1 - np.clip(sheet.inset / bevel, 0, 1)) ** 2)
    return half * (1 - deep * (1 - rise))


def closed(
    vertices: FloatArray, sheet: Sheet, thick: FloatArray
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


def sheet_of(mask: BoolArray, straight: bool = False) -> Sheet:
    """The grid over a mask (H, W), fine enough for its thin parts; `straight`: see `Sheet`."""
    x0, y0, x1, y1 = bounds(mask)
    pad = 8
    window = np.pad(mask[y0:y1, x0:x1], pad).astype(np.uint8)
    signed = cv2.distanceTransform(window, cv2.DIST_L2, 5)
    signed = signed - cv2.distanceTransform(1 - window, cv2.DIST_L2, 5)
    # Thin parts need a finer grid: a pole shall be at least two cells wide.
    inset = signed[signed > 0]
    thin = float(np.median(inset)) if len(inset) else 1.0
    longest = max(x1 - x0, y1 - y0)
    step = max(1.0, longest / SHEET.max_cells, min(longest / SHEET.cells_count, thin))
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
    if not inside.any() and mask.any():
        # A sliver between two points of the grid is taken as wide as the grid sees things.
        return sheet_of(grow(mask, 1), straight)
    ring = cv2.dilate(inside.astype(np.uint8), np.ones((3, 3), np.uint8)).astype(bool) & ~inside
    slope_x = cv2.Sobel(field, cv2.CV_32F, 1, 0, ksize=3)
    slope_y = cv2.Sobel(field, cv2.CV_32F, 0, 1, ksize=3)
    steep = np.hypot(slope_x, slope_y) + 1e-6
    shift = np.clip(-field, 0, 1.5 * step)
    px = gx + np.where(ring, slope_x / steep * shift, 0)
    py = gy + np.where(ring, slope_y / steep * shift, 0)
    foot = _foot(inside)
    swell = _membrane(np.asarray(field, np.float32), foot) * step
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
    inset = np.maximum(field[used], 0)
    return Sheet(pixels, faces, ring[used], swell[used], inset, straight)


def _foot(inside: BoolArray) -> BoolArray:
    """The lowest cells of a region: it goes on below, for a thing stands on more than a line."""
    rows = np.flatnonzero(inside.any(1))
    out = np.zeros_like(inside)
    if len(rows):
        from_row = rows[-1] - max(1, round(SHEET.foot_share * len(rows))) + 1
        out[from_row:] = inside[from_row:]
    return out


def _membrane(field: NDArray[np.float32], foot: BoolArray) -> FloatArray:
    """Half thickness in cells of a body swollen over a region: √ of a Poisson solution.

    It is held flat along the outline, but for the lower side of cells of the foot. field: signed
    distance to the outline, positive inside; it says where between two cells the outline runs
    (Gibou et al. 2002: a second-order symmetric scheme), or else the surface would have its steps.
    """
    inside = field > 0
    count = int(np.count_nonzero(inside))
    out = np.zeros(inside.shape)
    if not count:
        return out
    index = np.full(np.add(inside.shape, 2), -1)
    index[1:-1, 1:-1][inside] = np.arange(count)
    rows, columns = np.nonzero(index >= 0)
    own = index[rows, columns]
    open_below = foot[rows - 1, columns - 1] & (index[rows + 1, columns] < 0)
    padded = np.pad(field, 1, constant_values=-1.0)
    held, entries, least = np.zeros(count), [], SHEET.nearest_share
    for dy, dx in ((0, 1), (0, -1), (1, 0), (-1, 0)):
        near = index[rows + dy, columns + dx]
        some = near >= 0
        entries.append((own[some], near[some], np.full(int(some.sum()), -1.0)))
        here, there = padded[rows, columns], padded[rows + dy, columns + dx]
        part = np.where(some, 1.0, np.clip(here / np.maximum(here - there, 1e-6), least, 1.0))
        held += np.where(open_below & (dy == 1), 0.0, 1 / part)
    entries.append((own, own, held))
    r, c, v = (np.concatenate(part) for part in zip(*entries, strict=True))
    matrix = sparse.csc_matrix((v, (r, c)), (count, count))
    pressed = np.asarray(spsolve(matrix, np.full(count, 4.0)), float)
    out[inside] = np.sqrt(np.maximum(pressed, 0))
    return out
