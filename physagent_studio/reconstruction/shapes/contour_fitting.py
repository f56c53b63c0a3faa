"""Outlines drawn snugly around a mask: distances of its rim from a convex outline."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray
from scipy.optimize import least_squares, minimize

from physagent_studio.arrays import BoolArray, FloatArray


@dataclass(frozen=True, slots=True)
class ContourSettings:
    """How an outline is drawn to a rim."""

    points_count: int = 80  # 30..400: of the rim that are compared
    robust_px: float = 1.5  # 0.5..5: from which a point counts less: parts that stick out, shadows
    # IoU, 1e-4..0.01: of a squared pixel of one point, for what else speaks for a shape
    pixel_worth: float = 7e-4
    max_tries: int = 150  # count, 30..1000: shapes looked at from one beginning


CONTOUR = ContourSettings()


def rim_of(mask: BoolArray, free: BoolArray) -> FloatArray:
    """Points (N, 2) of a mask's convex rim, pixel (0, 0) with its middle at (0, 0).

    free: (H, W) pixels that nothing hides; the rim is left out where something does.
    """
    outlines, _ = cv2.findContours(mask.astype(np.uint8), cv2.RETR_EXTERNAL, cv2.CHAIN_APPROX_NONE)
    if not outlines:
        return np.zeros((0, 2))
    hull = cv2.convexHull(np.vstack(outlines)).reshape(-1, 2).astype(float)
    closed = np.vstack([hull, hull[:1]])
    steps = np.linalg.norm(np.diff(closed, axis=0), axis=1)
    where = np.concatenate([[0.0], np.cumsum(steps)])
    spots = np.linspace(0, where[-1], CONTOUR.points_count, endpoint=False)
    points = np.column_stack([np.interp(spots, where, closed[:, k]) for k in (0, 1)])
    # The rim runs between pixels: half a pixel outside the outermost centres.
    middle = mask.nonzero()
    away = points - np.array([middle[1].mean(), middle[0].mean()])
    points = points + 0.5 * away / np.maximum(np.linalg.norm(away, axis=1, keepdims=True), 1e-9)
    blind = cv2.dilate((~free).astype(np.uint8), np.ones((5, 5), np.uint8))
    x = np.clip(np.round(points[:, 0]).astype(int), 0, blind.shape[1] - 1)
    y = np.clip(np.round(points[:, 1]).astype(int), 0, blind.shape[0] - 1)
    return points[blind[y, x] == 0]


def gaps(rim: FloatArray, corners: FloatArray) -> FloatArray:
    """(N,) how far points (N, 2) lie outside the convex hull of corners (M, 2); inside below 0."""
    hull = cv2.convexHull(corners.astype(np.float32)).reshape(-1, 2).astype(float)
    side = np.roll(hull, -1, axis=0) - hull
    out = np.column_stack([side[:, 1], -side[:, 0]])
    out /= np.maximum(np.linalg.norm(out, axis=1, keepdims=True), 1e-9)
    middle = hull.mean(axis=0)
    out *= np.sign(((hull - middle) * out).sum(1))[:, None]
    return (rim @ out.T - (hull * out).sum(1)).max(1)


def drawn_to(
    rim: FloatArray,
    outline: Callable[[FloatArray], FloatArray | None],
    unlikely: Callable[[FloatArray], float],
    first: FloatArray,
    free: NDArray[np.intp],
) -> FloatArray:
    """Parameters near `first` whose outline runs along the rim (N, 2).

    outline: corners (M, 2) in the window; None where they cannot be seen. unlikely: what else
    speaks against parameters, in IoU. free: which of them may change.
    """

    def whole(some: FloatArray) -> FloatArray:
        out = first.copy()
        out[free] = some
        return out

    def off(some: FloatArray) -> FloatArray:
        p = whole(some)
        corners = outline(p)
        if corners is None:
            return np.full(len(rim) + 1, 1e3)
        return np.append(gaps(rim, corners), np.sqrt(max(unlikely(p), 0.0) / CONTOUR.pixel_worth))

    found = least_squares(
        off,
        first[free],
        loss="soft_l1",
        f_scale=CONTOUR.robust_px,
        max_nfev=CONTOUR.max_tries // (len(free) + 1),
        diff_step=1e-3,
        x_scale=0.1,
    )
    return whole(found.x)


def least_near(
    loss: Callable[[FloatArray], float],
    first: FloatArray,
    steps: FloatArray,
    runs: int,
    fine: float = 2e-3,
) -> tuple[float, FloatArray]:
    """The least loss near a beginning, and where it is (downhill simplex).

    steps: of each number at first. runs: shapes looked at. fine: steps with which it ends; of the
    loss a tenth of it.
    """
    options = {"maxfev": runs, "xatol": fine, "fatol": fine / 10}
    options["initial_simplex"] = np.vstack([first, first + np.diag(steps)])
    result = minimize(loss, first, method="Nelder-Mead", options=options)
    return float(result.fun), np.asarray(result.x)
