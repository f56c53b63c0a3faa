"""The closed contour of greatest contrast around a point, by dynamic programming.

On a log-polar image around the point an outline is a path from angle to angle, and the path
of least cost is found exactly. It does not look at colour statistics, so that it fails on
other pictures than GrabCut does; where both agree, the mask is most likely right.
"""

from __future__ import annotations

from collections.abc import Sequence

import cv2
import numpy as np
from numpy.typing import NDArray

from physagent_studio.reconstruction.masks import BoolArray, Pixel

ANGLES = 180
RADII = 96


def around(
    lab: NDArray[np.float32],
    centre: Pixel,
    stiffness: int,
    outside: Sequence[Pixel] = (),
) -> BoolArray:
    """The mask inside the best contour; `stiffness` 1 (round) to 3 (ragged) radii per angle."""
    rows, columns = lab.shape[:2]
    radii = np.geomspace(4, np.hypot(rows, columns) * 0.5, RADII)
    angles = np.arange(ANGLES) * 2 * np.pi / ANGLES
    x = (centre[0] + np.outer(np.cos(angles), radii)).astype(np.float32)
    y = (centre[1] + np.outer(np.sin(angles), radii)).astype(np.float32)
    cost = _edge_cost(cv2.remap(lab, x, y, cv2.INTER_LINEAR, borderMode=cv2.BORDER_REPLICATE))
    cost[(x < 1) | (x > columns - 2) | (y < 1) | (y > rows - 2)] = 1.0
    for px, py in outside:
        _keep_before(cost, radii, px - centre[0], py - centre[1])
    first = _best_path(cost, stiffness, None)[0]
    path = _best_path(cost, stiffness, int(first))
    polygon = np.stack(
        [centre[0] + np.cos(angles) * radii[path], centre[1] + np.sin(angles) * radii[path]], 1
    )
    canvas = np.zeros((rows, columns), np.uint8)
    cv2.fillPoly(canvas, [np.round(polygon).astype(np.int32)], 1)
    return canvas.astype(bool)


def _edge_cost(polar: NDArray[np.float32]) -> NDArray[np.float64]:
    """Low where colour differs between the two radii before and after; (angles, radii)."""
    width = 2
    sums = np.cumsum(np.pad(polar, ((0, 0), (1, 0), (0, 0))), axis=1)
    index = np.arange(RADII)
    before = (sums[:, index] - sums[:, np.maximum(index - width, 0)]) / np.maximum(
        np.minimum(index, width), 1
    )[None, :, None]
    end = np.minimum(index + width, RADII)
    after = (sums[:, end] - sums[:, index]) / (end - index)[None, :, None]
    cost = np.exp(-np.linalg.norm(before - after, axis=2) / 18.0)
    cost[:, 0] = 1.0
    return cost.astype(np.float64)


def _keep_before(cost: NDArray[np.float64], radii: NDArray, dx: float, dy: float) -> None:
    """Make the contour pass before a point that lies outside the object."""
    angle = round(float(np.arctan2(dy, dx)) / (2 * np.pi) * ANGLES)
    beyond = int(np.searchsorted(radii, np.hypot(dx, dy) * 0.9))
    for turn in range(-4, 5):
        cost[(angle + turn) % ANGLES, beyond:] = 5.0


def _best_path(cost: NDArray[np.float64], stiffness: int, start: int | None) -> NDArray[np.int64]:
    """Radius index per angle of the least costly path; closed if `start` is given."""
    total = cost[0].copy()
    if start is not None:
        total[:] = np.inf
        total[start] = cost[0, start]
    shifts = [0, *(sign * d for d in range(1, stiffness + 1) for sign in (-1, 1))]
    back = np.zeros((ANGLES, RADII), np.int64)
    index = np.arange(RADII)
    for angle in range(1, ANGLES):
        options = np.full((len(shifts), RADII), np.inf)
        for k, shift in enumerate(shifts):
            source = index - shift
            valid = (source >= 0) & (source < RADII)
            options[k, valid] = total[source[valid]] + 0.04 * abs(shift)
        choice = options.argmin(0)
        back[angle] = index - np.array(shifts)[choice]
        total = cost[angle] + options[choice, index]
    path = np.zeros(ANGLES, np.int64)
    if start is None:
        path[-1] = int(total.argmin())
    else:
        low, high = max(0, start - stiffness), min(RADII, start + stiffness + 1)
        path[-1] = low + int(total[low:high].argmin())
    for angle in range(ANGLES - 1, 0, -1):
        path[angle - 1] = back[angle, path[angle]]
    return path
