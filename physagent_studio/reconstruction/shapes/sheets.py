"""A silhouette as a flat grid of triangles, and the closed body that two of them make."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

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
    slender_ratio: float = 2.0  # 1..4: of depth over width, of thin parts of what is flat
    min_slender_share: float = 0.35  # 0.1..0.8: of an outline: from there on it is of thin parts
    # exponent, 1..8: what is flatter than round: how sharply its thickest parts are levelled off
    flat_power: float = 3.0
    chamfer_ratios: tuple[float, float] = (0.25, 0.2)  # 0..2: the same of what is deeper than round
    cells_count: int = 60  # 20..200: of the grid along the longer side
    max_cells: int = 110  # count, 40..400: along it, for thin parts
    max_drawn_cells: int = 240  # count, 40..600: likewise, of what is drawn alone


SHEET = SheetSettings()


@dataclass(frozen=True, eq=False, slots=True)
class Sheet:
    """The silhouette as a flat grid: pixel places (V, 2), faces (F, 3), rim flags (V,),

    swell (V,) half thickness of a round body, inset (V,) distance to the outline, and wide (V,)
    half the width of the part that is there, pixels. straight: the body over it is not round.
    """

    pixels: FloatArray
    faces: NDArray[np.int64]
    rim: BoolArray
    swell: FloatArray
    inset: FloatArray
    wide: FloatArray
    straight: bool = False

    def straight_at(self, half: float) -> bool:
        """Whether a body that is 2 · half pixels deep has flat sides."""
        return self.straight or half > SHEET.max_round_ratio * float(self.swell.max(initial=1e-9))


def thickness(sheet: Sheet, half: float, slender: bool = False) -> FloatArray:
    """Half thickness (V,) of a body that is 2 · half pixels deep: round, or flat with a bevel.

    slender: what is thin in its outline is about as thin across it.
    """
    if not sheet.straight_at(half):
        return _flattened(sheet.swell, half)
    wide, deep = SHEET.bevel_ratios if sheet.straight else SHEET.chamfer_ratios
    bevel = wide * float(np.median(sheet.inset[~sheet.rim])) + 1.0
    rise = np.sqrt(1 - (1 - np.clip(sheet.inset / bevel, 0, 1)) ** 2)
    most = np.minimum(half, SHEET.slender_ratio * sheet.wide) if slender else half
    return most * (1 - deep * (1 - rise))


def is_slender(sheet: Sheet, half: float) -> bool:
    """Whether much of a body that is 2 · half pixels deep is too thin in its outline for that."""
    thin = SHEET.slender_ratio * sheet.wide[~sheet.rim] < half
    return bool(thin.size and thin.mean() > SHEET.min_slender_share)


def _flattened(swell: FloatArray, half: float) -> FloatArray:
    """A round body's half thickness (V,), `half` where it is thickest: what is thin stays round."""
    most = float(swell.max(initial=1e-9))
    if half >= most:
        return swell * (half / most)
    power = SHEET.flat_power
    level = (max(half, 1e-6) ** -power - most**-power) ** (-1 / power)
    return level * swell / (swell**power + level**power) ** (1 / power)


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


def sheet_of(mask: BoolArray, straight: bool = False, cells: int = SHEET.max_cells) -> Sheet:
    """The grid over a mask (H, W), fine enough for its thin parts; `straight`: see `Sheet`.

    cells: along its longer side at most.
    """
    x0, y0, x1, y1 = bounds(mask)
    pad = 8
    deep = pad + min(x1 - x0, y1 - y0) // 2
    window = np.pad(mask[y0:y1, x0:x1], ((pad, deep), (pad, pad))).astype(np.uint8)
    signed, room = (
        _distance(own) - _distance(1 - own) for own in (window, _on_below(window, y1 - y0, pad))
    )
    # Thin parts need a finer grid: a pole shall be at least two cells wide.
    inset = signed[signed > 0]
    thin = float(np.median(inset)) if len(inset) else 1.0
    longest = max(x1 - x0, y1 - y0)
    step = max(1.0, longest / cells, min(longest / SHEET.cells_count, thin))
    gx, gy = np.meshgrid(
        np.arange(pad - step, pad + x1 - x0 + 2 * step, step),
        np.arange(pad - step, deep + y1 - y0 + 2 * step, step),
    )

    def at_grid(values: NDArray[np.float32]) -> NDArray[np.float32]:
        found = cv2.remap(
            values,
            (gx - 0.5).astype(np.float32),
            (gy - 0.5).astype(np.float32),
            cv2.INTER_LINEAR,
            borderMode=cv2.BORDER_CONSTANT,
            borderValue=-99,
        )
        return np.asarray(found, np.float32)

    field = at_grid(signed)
    inside = field > 0
    if not inside.any() and mask.any():
        # A sliver between two points of the grid is taken as wide as the grid sees things.
        return sheet_of(grow(mask, 1), straight, cells)
    ring = cv2.dilate(inside.astype(np.uint8), np.ones((3, 3), np.uint8)).astype(bool) & ~inside
    slope_x = cv2.Sobel(field, cv2.CV_32F, 1, 0, ksize=3)
    slope_y = cv2.Sobel(field, cv2.CV_32F, 0, 1, ksize=3)
    steep = np.hypot(slope_x, slope_y) + 1e-6
    shift = np.clip(-field, 0, 1.5 * step)
    px = gx + np.where(ring, slope_x / steep * shift, 0)
    py = gy + np.where(ring, slope_y / steep * shift, 0)
    swell, wide = (np.where(inside | ring, one, 0.0) for one in _balls(room, at_grid, step))
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
    wide = np.asarray(cv2.GaussianBlur(wide, (0, 0), 1.0), float)[used]
    return Sheet(pixels, faces, ring[used], swell[used], inset, wide, straight)


def _distance(inside: NDArray[np.uint8]) -> NDArray[np.float32]:
    """(H, W) how far pixels are from the nearest that is 0, to the bit.

    The exact transform takes roots of whole numbers, and takes them by other ways where an array
    lies elsewhere in memory.
    """
    found = np.asarray(cv2.distanceTransform(inside, cv2.DIST_L2, cv2.DIST_MASK_PRECISE))
    return np.sqrt(np.rint(found * found), dtype=np.float32)


def _on_below(window: NDArray[np.uint8], height: int, pad: int) -> NDArray[np.uint8]:
    """A mask with that height that goes on below its foot: a thing stands on more than a line."""
    low = window.copy()
    foot = max(1, round(SHEET.foot_share * height))
    columns = window[pad + height - foot : pad + height].any(0)
    last = len(window) - 1 - window[::-1].argmax(0)
    rows = np.arange(len(window))[:, None]
    low[(rows > last) & columns] = 1
    return low


def _balls(
    room: NDArray[np.float32],
    at_grid: Callable[[NDArray[np.float32]], NDArray[np.float32]],
    step: float,
) -> tuple[FloatArray, FloatArray]:
    """Half thickness (R, C) of the largest balls that a silhouette has room for, and their radius.

    room: (H, W) how far pixels are from the outline. at_grid: what the points of a grid, that is a
    step wide, have of it.
    """
    # The middle of a ball may lie between the points.
    wide = 2 * math.ceil(step / 2) + 1
    radius = np.maximum(
        at_grid(np.asarray(cv2.dilate(room, np.ones((wide, wide))), np.float32)), 0.0
    )
    squared = radius**2
    for _ in range(2):
        at = step * np.arange(squared.shape[1], dtype=np.float32)
        reached = squared[:, None] - (at[:, None] - at) ** 2
        best = reached.argmax(2)
        squared = np.take_along_axis(reached, best[..., None], 2)[..., 0].T
        radius = np.take_along_axis(radius, best, 1).T
    # How far a point is from the outline is known better than where the middle of its ball is.
    own = np.maximum(at_grid(room), 0.0)
    swell = np.sqrt(own * np.maximum(2 * radius - own, 0.0))
    return swell.astype(np.float64), radius.astype(np.float64)
