"""Long round things that lie: a pencil, a can on its side, a log.

The axis of a cylinder or a capsule is level then, at any turn. Where it may lie is read from the
mask: its long axis leads along the ground rather than up.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from physagent_studio.arrays import BoolArray, FloatArray
from physagent_studio.knowledge import Usual
from physagent_studio.program.rotations import about_axis, about_up, matrix_of, multiply
from physagent_studio.program.scene.camera import Camera
from physagent_studio.program.scene.state import Capsule, Cylinder, Shape
from physagent_studio.reconstruction.camera.rays import metres_per_pixel, on_plane, on_upright
from physagent_studio.reconstruction.shapes.contour_fitting import least_near
from physagent_studio.reconstruction.shapes.fit_target import Target
from physagent_studio.reconstruction.shapes.outlines import sphere_rim
from physagent_studio.reconstruction.shapes.primitives import COST, PRIMITIVE, Base, Fit

KINDS = ("cylinder", "capsule")


@dataclass(frozen=True, slots=True)
class LyingSettings:
    """When what is long and round lies."""

    min_length_ratio: float = 1.35  # 1.1..2: over the width of the mask
    # 0.2..0.9: from the picture of an upright line; less is a thing that stands
    min_lean_rad: float = math.radians(28)
    lying_cost: float = 0.01  # IoU, 0..0.1: lying has to win by over standing
    away_cost: float = 0.06  # IoU, 0..0.2: the same where it would point away from the camera
    open_cost: float = 0.1  # IoU, 0..0.3: the same of what is open at the top: pans and bowls
    # IoU, 0.8..1: a standing form so good explains a mask whose axis leads up
    good_iou: float = 0.93


LYING = LyingSettings()


_TURN = np.linspace(0, 2 * math.pi, 32, endpoint=False)
_RING = np.stack([np.cos(_TURN), np.sin(_TURN)], 1)


def lies(rotation: Sequence[float]) -> bool:
    """Whether a body's own axis is level, to within 3°."""
    return abs(float(matrix_of(rotation)[2, 2])) < math.sin(math.radians(3))


@dataclass(frozen=True, slots=True)
class Axis:
    """The long axis of a mask in the picture: its ends (x, y), and length over width."""

    one: tuple[float, float]
    other: tuple[float, float]
    width: float

    @property
    def length(self) -> float:
        """Pixels from end to end."""
        return math.dist(self.one, self.other)


def axis_of(mask: BoolArray) -> Axis:
    """The long axis of a mask (H, W), by its second moments."""
    rows, columns = np.nonzero(mask)
    points = np.column_stack([columns, rows]).astype(float) + 0.5
    middle = points.mean(axis=0)
    spread, ways = np.linalg.eigh(np.cov((points - middle).T) + 1e-9 * np.eye(2))
    along = (points - middle) @ ways[:, 1]
    low, high = np.percentile(along, [0.5, 99.5])
    across = 4 * math.sqrt(max(float(spread[0]), 1e-9))
    one, other = (middle + way * ways[:, 1] for way in (low, high))
    return Axis((float(one[0]), float(one[1])), (float(other[0]), float(other[1])), across)


def leans(camera: Camera, axis: Axis, base: Base) -> bool:
    """Whether the axis is clearly not the picture of an upright line at the base."""
    up = camera.project(np.array([[base.x, base.y, base.z], [base.x, base.y, base.z + 0.01]]))[0]
    plumb, own = up[1] - up[0], np.subtract(axis.other, axis.one)
    cosine = abs(float(plumb @ own)) / max(float(np.hypot(*plumb) * np.hypot(*own)), 1e-12)
    return cosine < math.cos(LYING.min_lean_rad)


def fit_lying(
    camera: Camera,
    mask: BoolArray,
    base: Base,
    kinds: Sequence[str],
    usual: Usual,
    hidden: BoolArray | None = None,
    standing: float = 0.0,
) -> list[Fit]:
    """Lying cylinders and capsules in place; none where the mask is not long.

    Arguments as of `shapes.fit_all`. standing: IoU of the best form that stands; where that is
    good and the mask's axis leads up, only what is known to lie is tried.
    """
    axis = axis_of(mask)
    if axis.length < LYING.min_length_ratio * axis.width:
        return []
    leaning = leans(camera, axis, base)
    if not leaning and standing > LYING.good_iou and usual.lies is None:
        return []
    cost = 0.0 if usual.lies is not None else LYING.lying_cost if leaning else LYING.away_cost
    cost += LYING.open_cost * (usual.opens and usual.lies is None)
    target = Target.of(mask, hidden)
    first = _start(camera, axis, base)
    found = []
    for kind in (kind for kind in KINDS if kind in kinds):
        fit = None if first is None else _fit(camera, target, base, kind, first)
        if fit is not None:
            merit = fit.iou - COST[kind] - cost + PRIMITIVE.named_gain * (kind in usual.shapes)
            found.append(Fit(fit.shape, fit.position, fit.rotation, fit.iou, merit))
    return found


def _start(camera: Camera, axis: Axis, base: Base) -> FloatArray | None:
    """x, y of its middle, m; log radius, log length; turn: by the mask's axis on the ground."""
    ends = np.array([axis.one, axis.other])
    thin = _spots(camera, ends, base, 0.0)
    if not np.isfinite(thin).all():
        return None
    radius = axis.width / 2 * metres_per_pixel(camera, thin.mean(axis=0))
    spots = _spots(camera, ends, base, radius)
    length = float(np.hypot(*(spots[1] - spots[0])[:2]))
    if not np.isfinite(spots).all() or length <= 0 or radius <= 0:
        return None
    x, y = (float(v) for v in spots.mean(axis=0)[:2])
    turn = math.atan2(spots[1, 1] - spots[0, 1], spots[1, 0] - spots[0, 0])
    return np.array([x, y, math.log(radius), math.log(length), turn])


def _spots(camera: Camera, ends: FloatArray, base: Base, radius: float) -> FloatArray:
    """World points (2, 3) of the ends; in the air, or at a known depth, across the view."""
    if base.free_z or base.hold >= 1:
        return on_upright(camera, ends, base.y)
    return on_plane(camera, ends, base.z + radius)


def _fit(camera: Camera, target: Target, base: Base, kind: str, first: FloatArray) -> Fit | None:
    scale = math.exp(float(first[3]))
    eye = np.array(camera.position)
    start = np.append(first, _height(camera, target, base) if base.free_z else base.z)
    held = base.hold >= 1

    def placed(p: FloatArray) -> FloatArray:
        q = start + p * np.array([scale, 0.0 if held else scale, 1, 1, 1, scale * base.free_z])
        q[2:4] = np.minimum(q[2:4], 8)
        return q

    def loss(p: FloatArray) -> float:
        q = placed(p)
        pixels, depth = camera.project(_outline(kind, q, eye))
        if depth.min() <= 0.02 * base.y:
            return 2.0
        unusual = 0.0
        if base.longest is not None:
            usual, spread = base.longest
            off = abs(math.log(_longest(kind, q) / usual)) / (spread + 0.25)
            unusual = 0.02 * max(off - 2.0, 0.0) ** 2
        return 1 - target.iou(pixels) + 0.004 * float(p[0] ** 2 + p[1] ** 2) + unusual

    steps = np.array([0.1, 0.1, 0.2, 0.2, 0.2, 0.1])
    q = placed(least_near(loss, np.zeros(6), steps, 260)[1])
    return _named(kind, q, target.iou(camera.project(_outline(kind, q, eye))[0]))


def _height(camera: Camera, target: Target, base: Base) -> float:
    """z of the middle of what hangs in the air, m."""
    rows, columns = np.nonzero(target.mask)
    middle = np.array([columns.mean() + 0.5, rows.mean() + 0.5]) / target.factor + target.origin
    return float(on_upright(camera, [middle], base.y)[0, 2])


def _longest(kind: str, q: FloatArray) -> float:
    radius, length = (float(v) for v in np.exp(q[2:4]))
    return max(length + 2 * radius * (kind == "capsule"), 2 * radius)


def _outline(kind: str, q: FloatArray, eye: FloatArray) -> FloatArray:
    """Points whose hull is the silhouette. q: x, y, log radius, log length, turn, z of its foot."""
    radius, length = np.exp(q[2:4])
    way = np.array([math.cos(q[4]), math.sin(q[4]), 0.0])
    middle = np.array([q[0], q[1], q[5] + radius])
    ends = [middle + half * length * way for half in (-0.5, 0.5)]
    if kind == "capsule":
        return np.vstack([sphere_rim(eye, end, np.full(3, radius)) for end in ends])
    side = np.array([-way[1], way[0], 0.0])
    ring = radius * (_RING[:, :1] * side + _RING[:, 1:] * np.array([0.0, 0, 1]))
    return np.vstack([end + ring for end in ends])


def _named(kind: str, q: FloatArray, iou: float) -> Fit:
    radius, length = (float(v) for v in np.exp(q[2:4]))
    shape: Shape = (
        Capsule(radius=radius, height=length + 2 * radius)
        if kind == "capsule"
        else Cylinder(radius=radius, height=length)
    )
    # The body's own axis, z, is laid along x and then turned.
    rotation = multiply(about_up(float(q[4])), about_axis((0.0, 1.0, 0.0), math.pi / 2))
    position = (float(q[0]), float(q[1]), float(q[5]) + radius)
    return Fit(shape, position, rotation, iou, iou)
