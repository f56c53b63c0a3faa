"""Closed contours of great contrast around a point, by dynamic programming.

On a log-polar image around the point an outline is a path from angle to angle, and the path
of least cost is found exactly. It does not look at colour statistics, so that it fails on
other pictures than GrabCut does; where both agree, the mask is most likely right. Elongated
things are round in a picture that is squeezed along their axis, so several squeezes are tried,
and inner radii are closed off in turn, so that an outline inside the object does not hide it.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from physagent_studio.reconstruction.masks import BoolArray, Pixel, bounds

ANGLES = 120
RADII = 72
SQUEEZES = ((1.0, 1.0), (0.55, 1.4), (1.5, 0.5), (2.2, 0.4))
"""Axes (x, y) of the ellipses that stand for circles."""
CLOSED = (0, 22, 34, 44)
"""How many of the innermost radii are closed off."""

_ANGLE = np.arange(ANGLES) * 2 * np.pi / ANGLES


@dataclass(frozen=True, eq=False, slots=True)
class _Polar:
    """A picture around a point: where each sample lies (ANGLES, RADII) and what it costs."""

    x: NDArray[np.float32]
    y: NDArray[np.float32]
    cost: NDArray[np.float64]


def around(
    lab: NDArray[np.float32], centre: Pixel, outside: Sequence[Pixel] = ()
) -> Iterator[BoolArray]:
    """Outlines of all squeezes, closed radii and two stiffnesses around a point."""
    reach = float(np.hypot(*lab.shape[:2])) * 0.55
    radii = np.geomspace(3, reach, RADII)
    for axes in SQUEEZES:
        polar = _polar(lab, centre, axes, radii, outside)
        for closed in CLOSED:
            for stiffness in (1, 2):
                yield _outline(polar, lab.shape[:2], stiffness, closed)


def again(
    lab: NDArray[np.float32], mask: BoolArray, outside: Sequence[Pixel] = ()
) -> Iterator[BoolArray]:
    """Outlines near that of a mask, seen from its middle and at its proportions."""
    x0, y0, x1, y1 = bounds(mask)
    width, height = max(x1 - x0, 4) / 2, max(y1 - y0, 4) / 2
    mean = float(np.sqrt(width * height))
    axes = (width / mean, height / mean)
    centre = ((x0 + x1) / 2, (y0 + y1) / 2)
    radii = np.geomspace(max(0.35 * mean, 2.5), max(1.9 * mean, 6), RADII)
    polar = _polar(lab, centre, axes, radii, outside)
    for stiffness in (1, 2, 3):
        yield _outline(polar, lab.shape[:2], stiffness, 0)


def beyond(
    lab: NDArray[np.float32], mask: BoolArray, outside: Sequence[Pixel] = ()
) -> Iterator[BoolArray]:
    """Outlines that hold a mask and reach further on one side: past a stripe or a seam."""
    x0, y0, x1, y1 = bounds(mask)
    width, height = x1 - x0, y1 - y0
    for dx, dy in ((0, -1), (0, 1), (-1, 0), (1, 0)):
        for share in (0.45, 0.9):
            grown_x, grown_y = abs(dx) * share * width, abs(dy) * share * height
            half = ((width + grown_x) / 2 + 1, (height + grown_y) / 2 + 1)
            centre = ((x0 + x1 + dx * grown_x) / 2, (y0 + y1 + dy * grown_y) / 2)
            mean = float(np.sqrt(half[0] * half[1]))
            axes = (half[0] / mean, half[1] / mean)
            radii = np.geomspace(max(0.3 * mean, 2.5), max(1.6 * mean, 6), RADII)
            polar = _polar(lab, centre, axes, radii, outside)
            _include(polar, mask, (dx, dy))
            yield _outline(polar, lab.shape[:2], 2, 0)


def _include(polar: _Polar, mask: BoolArray, side: tuple[int, int]) -> None:
    """Close the radii inside a mask, and just past it on one side."""
    rows, columns = mask.shape
    x = np.clip(polar.x.astype(int), 0, columns - 1)
    y = np.clip(polar.y.astype(int), 0, rows - 1)
    solid = mask.astype(np.uint8)
    inner = cv2.erode(solid, np.ones((5, 5), np.uint8)).astype(bool)
    x0, y0, x1, y1 = bounds(mask)
    margin = max(3, round(0.12 * (y1 - y0 if side[1] else x1 - x0)))
    closed = inner[y, x]
    facing = np.cos(_ANGLE) * side[0] + np.sin(_ANGLE) * side[1] > 0.8
    past = {
        (0, -1): polar.y > y0 - margin,
        (0, 1): polar.y < y1 + margin,
        (-1, 0): polar.x > x0 - margin,
        (1, 0): polar.x < x1 + margin,
    }[side]
    closed |= facing[:, None] & past
    # Everything nearer than the farthest closed sample of a ray is closed as well.
    reach = np.maximum.accumulate(closed[:, ::-1], axis=1)[:, ::-1]
    polar.cost[reach] = np.maximum(polar.cost[reach], 3.0)


def _polar(
    lab: NDArray[np.float32],
    centre: Pixel,
    axes: tuple[float, float],
    radii: NDArray[np.float64],
    outside: Sequence[Pixel],
) -> _Polar:
    rows, columns = lab.shape[:2]
    x = (centre[0] + np.outer(np.cos(_ANGLE), radii) * axes[0]).astype(np.float32)
    y = (centre[1] + np.outer(np.sin(_ANGLE), radii) * axes[1]).astype(np.float32)
    dx, dy = np.cos(_ANGLE) * axes[0], np.sin(_ANGLE) * axes[1]
    length = np.hypot(dx, dy)
    dx, dy = (dx / length)[:, None], (dy / length)[:, None]

    def sample(out: float) -> NDArray[np.float32]:
        at = (x + out * dx).astype(np.float32), (y + out * dy).astype(np.float32)
        found = cv2.remap(lab, *at, cv2.INTER_LINEAR, borderMode=cv2.BORDER_REPLICATE)
        return found.astype(np.float32)

    step = sample(-1.0) + sample(-2.2) - sample(1.0) - sample(2.2)
    cost = np.exp(-np.linalg.norm(step, axis=2) / 32.0).astype(np.float64)
    cost[(x < 1) | (x > columns - 2) | (y < 1) | (y > rows - 2)] = 1.0
    for px, py in outside:
        u, v = (px - centre[0]) / axes[0], (py - centre[1]) / axes[1]
        angle = round(float(np.arctan2(v, u)) / (2 * np.pi) * ANGLES)
        beyond = int(np.searchsorted(radii, np.hypot(u, v) * 0.9))
        # The contour passes before a point that lies outside the object.
        cost[np.arange(angle - 3, angle + 4) % ANGLES, beyond:] = 5.0
    return _Polar(x, y, cost)


def _outline(polar: _Polar, shape: tuple[int, int], stiffness: int, closed: int) -> BoolArray:
    cost = polar.cost.copy()
    cost[:, :closed] = 3.0
    path = _best_path(cost, stiffness, int(_best_path(cost, stiffness, None)[0]))
    index = np.arange(ANGLES)
    polygon = np.stack([polar.x[index, path], polar.y[index, path]], 1)
    canvas = np.zeros(shape, np.uint8)
    cv2.fillPoly(canvas, [np.round(polygon).astype(np.int32)], 1)
    return canvas.astype(bool)


def _best_path(cost: NDArray[np.float64], stiffness: int, start: int | None) -> NDArray[np.int64]:
    """Radius index per angle of the least costly path; closed if `start` is given."""
    total = cost[0].copy()
    if start is not None:
        total[:] = np.inf
        total[start] = cost[0, start]
    shifts = np.arange(-stiffness, stiffness + 1)
    index = np.arange(RADII)
    source = index[None] - shifts[:, None]
    beyond = (source < 0) | (source >= RADII)
    source = np.clip(source, 0, RADII - 1)
    penalty = np.where(beyond, np.inf, 0.04 * np.abs(shifts)[:, None])
    back = np.zeros((ANGLES, RADII), np.int64)
    for angle in range(1, ANGLES):
        options = total[source] + penalty
        choice = options.argmin(0)
        back[angle] = index - shifts[choice]
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
