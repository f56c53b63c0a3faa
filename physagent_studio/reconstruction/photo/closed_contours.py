"""Closed contours of great contrast around a point, by dynamic programming.

On a log-polar image around the point an outline is a path from angle to angle, and the path
of least cost is found exactly. It does not look at colour statistics, so that it fails on
other pictures than GrabCut does; where both agree, the mask is most likely right. Elongated
things are round in a picture that is squeezed along their axis.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from physagent_studio.reconstruction.photo.regions import BoolArray, Pixel, bounds
from physagent_studio.reconstruction.photo.statistics import lengths

ANGLES = 120
RADII = 72
_ANGLE = np.arange(ANGLES) * 2 * np.pi / ANGLES
_ACROSS = np.array([-1.0, -2.2, 1.0, 2.2])[:, None, None]
"""Where the colours inside and outside of an outline are looked up, pixels along its normal."""


@dataclass(frozen=True, eq=False, slots=True)
class _Polar:
    """A picture around a point: where each sample lies (ANGLES, RADII) and what it costs."""

    x: NDArray[np.float32]
    y: NDArray[np.float32]
    cost: NDArray[np.float64]


@dataclass(frozen=True, eq=False, slots=True)
class _Job:
    """An outline to be found: around what, and how stiff."""

    polar: _Polar
    stiffness: int


def again(
    lab: NDArray[np.float32], mask: BoolArray, outside: Sequence[Pixel] = ()
) -> list[BoolArray]:
    """Outlines near that of a mask, seen from its middle and at its proportions."""
    x0, y0, x1, y1 = bounds(mask)
    width, height = max(x1 - x0, 4) / 2, max(y1 - y0, 4) / 2
    mean = float(np.sqrt(width * height))
    axes = (width / mean, height / mean)
    centre = ((x0 + x1) / 2, (y0 + y1) / 2)
    radii = np.geomspace(max(0.35 * mean, 2.5), max(1.9 * mean, 6), RADII)
    polar = _polar(lab, centre, axes, radii, outside)
    return _outlines([_Job(polar, stiffness) for stiffness in (1, 2, 3)], lab.shape[:2])


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

    # All four samples of a ray are taken at once.
    at_x = (x + _ACROSS * dx).astype(np.float32).reshape(-1, RADII)
    at_y = (y + _ACROSS * dy).astype(np.float32).reshape(-1, RADII)
    found = cv2.remap(lab, at_x, at_y, cv2.INTER_LINEAR, borderMode=cv2.BORDER_REPLICATE)
    inner, within, outer, beyond = np.asarray(found, np.float32).reshape(4, ANGLES, RADII, 3)
    cost = np.exp(-lengths(inner + within - outer - beyond) / 32.0).astype(np.float64)
    cost[(x < 1) | (x > columns - 2) | (y < 1) | (y > rows - 2)] = 1.0
    for px, py in outside:
        u, v = (px - centre[0]) / axes[0], (py - centre[1]) / axes[1]
        angle = round(float(np.arctan2(v, u)) / (2 * np.pi) * ANGLES)
        past = int(np.searchsorted(radii, np.hypot(u, v) * 0.9))
        # The contour passes before a point that lies outside the object.
        cost[np.arange(angle - 3, angle + 4) % ANGLES, past:] = 5.0
    return _Polar(x, y, cost)


def _outlines(jobs: Sequence[_Job], shape: tuple[int, ...]) -> list[BoolArray]:
    """The mask (H, W) of each outline; those of one stiffness are sought side by side."""
    paths = np.zeros((len(jobs), ANGLES), np.int64)
    for stiffness in sorted({job.stiffness for job in jobs}):
        some = [k for k, job in enumerate(jobs) if job.stiffness == stiffness]
        cost = np.stack([jobs[k].polar.cost for k in some], axis=1)
        first = _best_paths(cost, stiffness, None)[:, 0]
        paths[some] = _best_paths(cost, stiffness, first)
    return [_filled(job.polar, path, shape) for job, path in zip(jobs, paths, strict=True)]


def _filled(polar: _Polar, path: NDArray[np.int64], shape: tuple[int, ...]) -> BoolArray:
    index = np.arange(ANGLES)
    polygon = np.stack([polar.x[index, path], polar.y[index, path]], 1)
    canvas = np.zeros(shape[:2], np.uint8)
    cv2.fillPoly(canvas, [np.round(polygon).astype(np.int32)], 1)
    return canvas.astype(bool)


def _best_paths(
    cost: NDArray[np.float64], stiffness: int, start: NDArray[np.int64] | None
) -> NDArray[np.int64]:
    """Radius index per angle of the least costly path through each (ANGLES, N, RADII) cost; (N,
    ANGLES).

    Closed ones if the radii (N,) are given at which they start.
    """
    many = np.arange(cost.shape[1])
    total = _totals(cost, stiffness, start)
    last = total[-1, :, stiffness:-stiffness]
    if start is not None:
        away = np.abs(np.arange(RADII)[None] - start[:, None])
        last = np.where(away <= stiffness, last, np.inf)
    path = np.zeros((len(many), ANGLES), np.int64)
    path[:, -1] = at = last.argmin(1)
    # Radii from which one is reached, the farthest first: where two are as good, it is taken.
    before = np.arange(2 * stiffness, -1, -1)
    bend = 0.04 * np.abs(before - stiffness)
    for angle in range(ANGLES - 1, 0, -1):
        come = total[angle - 1][many[:, None], at[:, None] + before] + bend
        at = at + stiffness - come.argmin(1)
        path[:, angle - 1] = at
    return path


def _totals(
    cost: NDArray[np.float64], stiffness: int, start: NDArray[np.int64] | None
) -> NDArray[np.float64]:
    """(ANGLES, N, RADII + 2 stiffness) what the best way to each radius costs, padded with inf."""
    count = cost.shape[1]
    total = np.full((ANGLES, count, RADII + 2 * stiffness), np.inf)
    inner = total[:, :, stiffness:-stiffness]
    if start is None:
        inner[0] = cost[0]
    else:
        every = np.arange(count)
        inner[0, every, start] = cost[0, every, start]
    best, other = np.empty((count, RADII)), np.empty((count, RADII))
    for angle in range(1, ANGLES):
        before = total[angle - 1]
        np.add(before[:, :RADII], 0.04 * stiffness, out=best)
        for shift in range(1, 2 * stiffness + 1):
            bend = 0.04 * abs(shift - stiffness)
            np.minimum(best, np.add(before[:, shift : shift + RADII], bend, out=other), out=best)
        np.add(cost[angle], best, out=inner[angle])
    return total
