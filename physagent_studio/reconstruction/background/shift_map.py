"""Candidates of what to copy into a hole: shifts of the picture and of the level plane in it.

Boards, tiles and lanes repeat on the level plane and not in the picture: a shift there is a
homography of the picture. All level planes, floor or table top, share these homographies.
"""

from __future__ import annotations

import cv2
import numpy as np
from numpy.typing import NDArray

from physagent_studio.arrays import FloatArray, FloatImage
from physagent_studio.program.scene.camera import Camera
from physagent_studio.reconstruction.photo.regions import BoolArray, bounds


class _Searched:
    """A picture (H, W, 3) in which patches are looked for; whole: where one may be copied from."""

    def __init__(self, image: FloatImage, whole: BoolArray) -> None:
        self.image = image
        self.square = (image * image).sum(-1)
        self.level = image.mean(-1)
        self.whole = whole

    def unlike(self, patch: FloatImage, mask: FloatImage) -> FloatImage:
        """(h, w) how unlike the patch each place is; infinite where it may not be copied from.

        mask: which of the patch's pixels count. A difference in brightness counts for less.
        """
        count = float(mask.sum())
        masked = patch * mask[..., None]
        square = cv2.matchTemplate(self.square, mask, cv2.TM_CCORR)
        square -= 2 * cv2.matchTemplate(self.image, masked, cv2.TM_CCORR)
        square = (square + float((masked * patch).sum())) / count
        mean = cv2.matchTemplate(self.level, mask, cv2.TM_CCORR) / count
        # 0..60: by which a place may be brighter or darker at little cost: it is levelled
        lift_levels = 20.0
        lifted = np.minimum(np.abs(mean - masked.sum() / (3 * count)), lift_levels)
        cost = square - 0.8 * 3 * lifted**2
        return np.where(self.whole, cost, np.inf).astype(np.float32)


def shift(x: float, y: float) -> FloatArray:
    """The copy (3, 3) of what lies (x, y) pixels away."""
    return np.array([[1, 0, x], [0, 1, y], [0, 0, 1]], float)


def rescaled(copy: FloatArray, x: float, y: float) -> FloatArray:
    """The same copy in a picture x times as wide and y times as high."""
    return np.diag([x, y, 1.0]) @ copy @ np.diag([1 / x, 1 / y, 1.0])


def bent(
    copy: FloatArray,
    columns: NDArray[np.int64],
    rows: NDArray[np.int64],
    x: FloatImage,
    y: FloatImage,
) -> FloatArray:
    """(N,) how far a copy is from a mere shift where it takes (x, y) to places (N,)."""
    depth = copy[2, 0] * (columns + 0.5) + copy[2, 1] * (rows + 0.5) + copy[2, 2]
    depth = np.where(depth > 1e-6, depth, 1.0)
    off = [
        (copy[i, j] - (place + 0.5) * copy[2, j]) / depth - (i == j)
        for i, place in enumerate((x, y))
        for j in range(2)
    ]
    return np.asarray(np.linalg.norm(off, axis=0), float)


def shifts_in(image: FloatImage, hole: BoolArray, barred: BoolArray) -> list[FloatArray]:
    """Shifts (x, y) that bring to the rim of the hole (H, W) what looks like it there.

    barred: (H, W) the hole and what else shall not be copied.
    """
    x0, y0, x1, y1 = bounds(hole)
    half = int(np.clip(0.16 * max(x1 - x0, y1 - y0), 6, 28))
    usable = np.pad((~barred).astype(np.float32), half)
    # Around zero, so that sums of squares stay small.
    framed = np.pad(image - np.float32(128), ((half, half), (half, half), (0, 0)), mode="edge")
    side = 2 * half + 1
    inside = cv2.boxFilter(usable, -1, (side, side), borderType=cv2.BORDER_CONSTANT)
    seen = _Searched(framed, inside[half:-half, half:-half] > 0.97)
    out = []
    best_count = 2  # 1..6: places taken of each
    for x, y in _along_rim(hole, half):
        box = slice(y, y + side), slice(x, x + side)
        mask = usable[box]
        if not 0.15 * mask.size < mask.sum() < mask.size:
            continue
        cost = seen.unlike(framed[box], mask)
        for _ in range(best_count):
            row, column = np.unravel_index(int(cost.argmin()), cost.shape)
            if not np.isfinite(cost[row, column]):
                break
            fine = _between(cost, int(row), int(column))
            out.append(np.array([column - x + fine[0], row - y + fine[1]]))
            cost[max(0, row - half) : row + half, max(0, column - half) : column + half] = np.inf
    return out


def _along_rim(hole: BoolArray, half: int) -> list[tuple[int, int]]:
    """Pixels (x, y) evenly spaced on the outlines of the hole."""
    found, _ = cv2.findContours(hole.astype(np.uint8), cv2.RETR_CCOMP, cv2.CHAIN_APPROX_NONE)
    border = [p for ring in found for p in ring[:, 0]]
    if not border:
        return []
    rows, columns = hole.shape
    inner = [(int(x), int(y)) for x, y in border if 0 < x < columns - 1 and 0 < y < rows - 1]
    patches_count = 16  # 4..64: along the rim that are looked for elsewhere
    step = max(1, half, len(inner) // patches_count)
    return inner[::step]


def _between(cost: FloatImage, row: int, column: int) -> tuple[float, float]:
    """How far (x, y) beside a whole pixel the least cost lies, by parabolas through it."""
    out = []
    for dy, dx in ((0, 1), (1, 0)):
        ahead, behind = (row + dy, column + dx), (row - dy, column - dx)
        if min(behind) < 0 or ahead[0] >= cost.shape[0] or ahead[1] >= cost.shape[1]:
            out.append(0.0)
            continue
        low, middle, high = float(cost[behind]), float(cost[row, column]), float(cost[ahead])
        bent = low - 2 * middle + high
        whole = np.isfinite(bent) and bent > 1e-6
        out.append(float(np.clip(0.5 * (low - high) / bent, -0.5, 0.5)) if whole else 0.0)
    return out[0], out[1]


def level_shifts(
    image: FloatImage, hole: BoolArray, barred: BoolArray, level: FloatArray
) -> list[FloatArray]:
    """Copies (3, 3) of the picture that are shifts of the level plane in it.

    level: (3, 3) from pixels to that plane, as `to_level` gives it.
    """
    canvas = _canvas(level, hole)
    if canvas is None:
        return []
    flat, size = canvas
    inside = cv2.warpPerspective(hole.astype(np.float32), flat, size) > 0.01
    usable = cv2.warpPerspective((~barred).astype(np.float32), flat, size)
    seen = cv2.warpPerspective(image, flat, size, borderMode=cv2.BORDER_REPLICATE)
    closed = np.asarray(usable < 0.99)
    if closed.all() or not inside.any():
        return []
    back = np.linalg.inv(flat)
    return [
        back @ shift(x, y) @ flat
        for x, y in shifts_in(seen.astype(np.float32), np.asarray(inside), closed)
    ]


def to_level(camera: Camera) -> FloatArray:
    """The map (3, 3) from pixels to places on a level plane one unit below the camera."""
    away = np.diag([1.0, 1.0, -1.0]) @ camera.matrix @ np.linalg.inv(camera.intrinsics)
    return away / np.linalg.norm(away)


def _canvas(level: FloatArray, hole: BoolArray) -> tuple[FloatArray, tuple[int, int]] | None:
    """The map from pixels to a picture of the plane around the hole's foot, and its size."""
    x0, _, x1, y1 = bounds(hole)
    rows, columns = hole.shape
    foot = _through(level, np.array([[(x0 + x1) / 2, y1]]))[0]
    beside = _through(level, np.array([[(x0 + x1) / 2 + 1, y1]]))[0]
    if not np.isfinite([foot, beside]).all():
        return None
    pixels = 1 / max(float(np.linalg.norm(beside - foot)), 1e-9)
    near = _through(level, np.array([[columns / 2, rows]]))[0]
    wide = min((x1 - x0) * 1.6 + 20, columns) / pixels
    low = max(foot[1] - wide, near[1]) if np.isfinite(near).all() else foot[1] - wide
    high = foot[1] + 1.5 * wide
    left = foot[0] - wide
    flat_px = 260  # 100..600: longer side of the flattened plane
    factor = min(pixels, flat_px / max(high - low, 2 * wide))
    size = (max(16, round(2 * wide * factor)), max(16, round((high - low) * factor)))
    # Far is up, as in the picture.
    view = np.array([[factor, 0, -left * factor], [0, -factor, high * factor], [0, 0, 1]])
    return view @ level, size


def _through(copy: FloatArray, points: FloatArray) -> FloatArray:
    """Points (N, 2) through a map (3, 3); not finite where they are beyond its horizon."""
    mapped = np.column_stack([points, np.ones(len(points))]) @ copy.T
    with np.errstate(divide="ignore", invalid="ignore"):
        out = mapped[:, :2] / mapped[:, 2:]
    return np.where(mapped[:, 2:] > 0, out, np.inf)
