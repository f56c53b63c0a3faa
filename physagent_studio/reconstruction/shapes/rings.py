"""Rings fitted to a silhouette: a tyre, a hoop, a doughnut, lying flat or standing on its rim."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from physagent_studio.arrays import FloatArray
from physagent_studio.program.base import IDENTITY
from physagent_studio.program.rotations import about_up, matrix_of, multiply
from physagent_studio.program.scene.camera import Camera
from physagent_studio.program.scene.state import Torus
from physagent_studio.reconstruction.camera.rays import metres_per_pixel
from physagent_studio.reconstruction.photo.regions import BoolArray, bounds, grow
from physagent_studio.reconstruction.shapes.contour_fitting import least_near
from physagent_studio.reconstruction.shapes.fit_target import Target
from physagent_studio.reconstruction.shapes.primitives import PRIMITIVE, Base, Fit

Quat = tuple[float, float, float, float]


@dataclass(frozen=True, slots=True)
class RingSettings:
    """When a silhouette is a ring."""

    ring_cost: float = 0.02  # IoU, 0..0.1: a ring has to win by
    min_hole_share: float = 0.04  # 0.01..0.2: of what its outline encloses; less is a spot
    max_off_share: float = 0.12  # 0.03..0.3: of its size: of the hole's middle from the outline's
    min_round_iou: float = 0.9  # IoU, 0.7..1: of an ellipse with the filled outline
    usual_tube_ratio: float = 0.3  # 0.1..0.5: over the ring's radius, where no hole shows it


RING = RingSettings()

_TURN = np.linspace(0, 2 * math.pi, 40, endpoint=False)
_RING = np.stack([np.cos(_TURN), np.sin(_TURN), np.zeros(40)], 1)


@dataclass(frozen=True, slots=True)
class Hole:
    """The hole of a ring in the picture: its box over the ring's, across and up, 0 … 1."""

    across: float
    up: float


def hole_of(mask: BoolArray, hidden: BoolArray | None = None) -> Hole | None:
    """The hole in the middle of a round silhouette; None where there is none.

    hidden: pixels (H, W) of other things: what is seen through the hole, or passes in front.
    """
    found, _ = cv2.findContours(mask.astype(np.uint8), cv2.RETR_EXTERNAL, cv2.CHAIN_APPROX_NONE)
    if not found:
        return None
    outline = cv2.convexHull(np.vstack(found))
    filled = np.zeros(mask.shape, np.uint8)
    cv2.fillConvexPoly(filled, outline, 1)
    inner = (filled > 0) & ~mask
    if hidden is not None:
        inner &= ~hidden
    x0, y0, x1, y1 = bounds(mask)
    size = max(x1 - x0, y1 - y0)
    if (
        len(outline) < 5
        or inner.sum() < RING.min_hole_share * filled.sum()
        or not _is_round(filled)
    ):
        return None
    count, labels, stats, centres = cv2.connectedComponentsWithStats(inner.astype(np.uint8))
    largest = max((int(stats[label, cv2.CC_STAT_AREA]) for label in range(1, count)), default=0)
    cover = grow(hidden, 2) if hidden is not None else np.zeros_like(mask)
    middle = np.array([(x0 + x1 - 1) / 2, (y0 + y1 - 1) / 2])
    parts = [
        label
        for label in range(1, count)
        if np.linalg.norm(centres[label] - middle) < RING.max_off_share * size
        # What passes in front of a ring cuts its hole in two.
        or (stats[label, cv2.CC_STAT_AREA] > 0.2 * largest and cover[labels == label].any())
    ]
    hole = np.isin(labels, parts)
    if hole.sum() < RING.min_hole_share * filled.sum():
        return None
    left, top, right, bottom = bounds(hole)
    off = np.array([(left + right - 1) / 2, (top + bottom - 1) / 2]) - middle
    if np.linalg.norm(off) > RING.max_off_share * size or min(left - x0, x1 - right) <= 0:
        return None
    return Hole((right - left) / (x1 - x0), (bottom - top) / (y1 - y0))


def _is_round(filled: NDArray[np.uint8]) -> bool:
    """Whether an ellipse covers a filled outline."""
    outline, _ = cv2.findContours(filled, cv2.RETR_EXTERNAL, cv2.CHAIN_APPROX_NONE)
    drawn = np.zeros_like(filled)
    cv2.ellipse(drawn, cv2.fitEllipse(outline[0]), (1,), -1)
    both, either = int((drawn & filled).sum()), int((drawn | filled).sum())
    return both > RING.min_round_iou * either


def fit_ring(
    camera: Camera,
    mask: BoolArray,
    base: Base,
    suggested: Sequence[str],
    hidden: BoolArray | None = None,
) -> Fit | None:
    """The ring at `base` that covers the mask best: lying, on its rim, or turned freely in the air.

    hidden: pixels (H, W) of other objects, where this one may go on unseen.
    """
    target = Target.of(mask, hidden)
    pixel = metres_per_pixel(camera, (base.x, base.y, base.z))
    if pixel <= 0 or target.width * pixel <= 0:
        return None
    hole = hole_of(mask, hidden)
    width, height = target.width * pixel, target.height * pixel
    tries = [
        _tried(camera, target, base, (width, height), start)
        for start in _starts(width, height, hole, base.free_z)
    ]
    loss, made = min(tries, key=lambda one: one[0])
    iou = target.iou_of(made.drawn(camera, target))
    gain = PRIMITIVE.named_gain * ("torus" in suggested)
    if made.tube > made.radius or loss >= 2.0:
        return None
    shape = Torus(radius=made.radius, tube=made.tube)
    return Fit(shape, made.place, made.rotation, iou, iou - RING.ring_cost + gain)


@dataclass(frozen=True, slots=True)
class _Ring:
    """A ring in place; tilt: of its axis from the vertical; yaw: where the axis points, rad."""

    place: tuple[float, float, float]
    radius: float
    tube: float
    tilt: float
    yaw: float

    @property
    def rotation(self) -> Quat:
        if self.tilt == 0:
            return IDENTITY
        lean = (math.cos(self.tilt / 2), 0.0, math.sin(self.tilt / 2), 0.0)
        return multiply(about_up(self.yaw), lean)

    def drawn(self, camera: Camera, target: Target) -> NDArray[np.uint8] | None:
        """What the camera sees of it in the target's window: the union of the balls of its tube."""
        world = _RING @ matrix_of(self.rotation).T * self.radius + np.array(self.place)
        pixels, depth = camera.project(world)
        if depth.min() <= 2 * self.tube:
            return None
        at = target.local(pixels)
        reach = self.tube * camera.focal / depth * target.factor
        canvas = np.zeros(target.mask.shape, np.uint8)
        ahead = np.roll(at, -1, axis=0) - at
        length = np.maximum(np.linalg.norm(ahead, axis=1, keepdims=True), 1e-9)
        side = np.column_stack([-ahead[:, 1], ahead[:, 0]]) / length
        wide, wider = side * reach[:, None], side * np.roll(reach, -1)[:, None]
        after = np.roll(at, -1, axis=0)
        quads = np.stack([at + wide, after + wider, after - wider, at - wide], 1)
        fixed = np.round(np.clip(quads, -1e4, 1e4) * 16).astype(np.int32)
        spots = np.round(np.clip(at, -1e4, 1e4) * 16).astype(np.int32)
        for quad, spot, r in zip(fixed, spots.tolist(), reach.tolist(), strict=True):
            cv2.fillConvexPoly(canvas, quad, 1, shift=4)
            cv2.circle(canvas, spot, max(round(r * 16), 1), 1, -1, shift=4)
        return canvas


def _starts(
    width: float, height: float, hole: Hole | None, free: bool
) -> list[tuple[float, float, float, float]]:
    """Where to begin: ring's radius, m, tube over it, tilt, yaw of the axis."""

    def sizes(extent: float, inner: float | None) -> tuple[float, float]:
        if inner is None:
            return extent / 2 / (1 + RING.usual_tube_ratio), RING.usual_tube_ratio
        inner = min(inner, 0.95)
        return extent * (1 + inner) / 4, (1 - inner) / (1 + inner)

    lying = (*sizes(width, hole.across if hole else None), 0.0, 0.0)
    radius, tube = sizes(height, hole.up if hole else None)
    # The narrower it looks, the more it is turned away.
    seen = (width / 2 - tube * radius) / radius
    away = math.acos(min(max(seen, 0.05), 1.0))
    upright = [
        (radius, tube, math.pi / 2, math.pi / 2 + turn)
        for turn in {round(away, 3), -round(away, 3)}
    ]
    # Sorted, for sets have no order of their own.
    found = [lying, *sorted(upright)]
    if free:
        radius, tube = sizes(max(width, height), max(hole.across, hole.up) if hole else None)
        found += [(radius, tube, tilt, math.pi / 2) for tilt in (0.6, 1.1)]
    return found


def _tried(
    camera: Camera,
    target: Target,
    base: Base,
    seen: tuple[float, float],
    start: tuple[float, float, float, float],
) -> tuple[float, _Ring]:
    """The best ring from one start, and its loss. seen: width and height of the mask there, m."""
    radius, ratio, tilt, yaw = start
    width, height = seen
    moves = np.array([1.0, 0.0 if base.hold >= 1 else 1.0, 1.0 if base.free_z else 0.0])
    turns = np.array([1.0 if base.free_z else 0.0, 1.0 if tilt > 0 else 0.0])

    def made(p: FloatArray) -> _Ring:
        big = math.exp(min(float(p[3]), 8.0))
        thin = big * math.exp(min(float(p[4]), 0.0))
        lean, turn = tilt + turns[0] * float(p[5]), yaw + turns[1] * float(p[6])
        x, y, z = np.array([p[0] * width, p[1] * width, p[2] * height]) * moves
        lift = thin + big * abs(math.sin(lean))
        place = (base.x + float(x), base.y + float(y), base.z + float(z) + lift)
        return _Ring(place, big, thin, lean, turn)

    def loss(p: FloatArray) -> float:
        drawn = made(p).drawn(camera, target)
        if drawn is None:
            return 2.0
        return 1 - target.iou_of(drawn) + (0.004 + base.hold) * (p[1] * moves[1]) ** 2

    behind = 0.0 if tilt > 0 else radius * (1 - base.hold) / width
    first = np.array([0.0, behind, 0.0, math.log(radius), math.log(ratio), 0.0, 0.0])
    steps = np.array([0.1, 0.1, 0.1, 0.15, 0.2, 0.2, 0.2])
    value, best = least_near(loss, first, steps, 240)
    return value, made(best)
