"""Primitives fitted to a silhouette: each is drawn as the camera would see it and compared."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import minimize

from physagent_studio.program.base import IDENTITY
from physagent_studio.program.camera import Camera
from physagent_studio.program.rotations import about_up
from physagent_studio.program.scene import (
    Box,
    Capsule,
    Cylinder,
    Ellipsoid,
    Frustum,
    Revolved,
    Shape,
    Sphere,
)
from physagent_studio.reconstruction.geometry import metres_per_pixel
from physagent_studio.reconstruction.masks import BoolArray
from physagent_studio.reconstruction.meshes import frustum_centre, profile_centre
from physagent_studio.reconstruction.target import Target

FloatArray = NDArray[np.float64]

COST = {
    "sphere": 0.0,
    "ellipsoid": 0.015,
    "capsule": 0.02,
    "cylinder": 0.015,
    "box": 0.018,
    "frustum": 0.028,
    "bowl": 0.028,
}
"""What a kind has to win by: more freedom fits anything."""
BOWL_RINGS = 16
"""Rings between the foot and the rim of a bowl."""
PRIOR = 0.04
"""What a kind gains if the name suggests it."""

_TURN = np.linspace(0, 2 * math.pi, 40, endpoint=False)
_CIRCLE = np.stack([np.cos(_TURN), np.sin(_TURN)], 1)


@dataclass(frozen=True, slots=True)
class Lying:
    """A box that carries another: x, y of its middle, width and depth of its top, m, its yaw."""

    x: float
    y: float
    width: float
    depth: float
    yaw: float


@dataclass(frozen=True, slots=True)
class Base:
    """Where an object stands: x, y of its foot and the height z of what it stands on, m.

    hold: how strongly y is held (0: free along the plane, as seen; 1: y is known). free_z: the
    height is found from the picture instead (an object in the air). below: the box that it
    stands on, if it does: what is stacked lies much the same way. longest: usual length of the
    thing's longer side, m, and the spread of its logarithm, where that is known.
    """

    x: float
    y: float
    z: float
    hold: float = 0.0
    free_z: bool = False
    below: Lying | None = None
    longest: tuple[float, float] | None = None


@dataclass(frozen=True, slots=True)
class Fit:
    """A shape in place: its numbers, its pose (centre of mass), how well it covers the mask."""

    shape: Shape
    position: tuple[float, float, float]
    rotation: tuple[float, float, float, float]
    iou: float
    merit: float


def fit_all(
    camera: Camera,
    mask: BoolArray,
    base: Base,
    kinds: Sequence[str],
    suggested: Sequence[str],
    hidden: BoolArray | None = None,
) -> list[Fit]:
    """The primitives of the given kinds in place, best first.

    hidden: pixels (H, W) of other objects, where this one may go on unseen.
    """
    target = Target.of(mask, hidden)
    fits = [_fit(camera, target, base, kind) for kind in kinds]
    graded = [
        Fit(f.shape, f.position, f.rotation, f.iou, f.iou - COST[k] + PRIOR * (k in suggested))
        for k, f in zip(kinds, fits, strict=True)
        if f is not None
    ]
    return sorted(graded, key=lambda fit: -fit.merit)


def sphere_rim(eye: FloatArray, centre: FloatArray, radii: FloatArray) -> FloatArray:
    """Points (40, 3) of an ellipsoid's contour as seen from `eye`."""
    view = (eye - centre) / radii
    far = float(np.linalg.norm(view))
    if far <= 1.001:
        return centre + np.zeros((1, 3))
    axis = view / far
    helper = np.array([0.0, 0, 1]) if abs(axis[2]) < 0.9 else np.array([1.0, 0, 0])
    u = np.cross(axis, helper)
    u /= np.linalg.norm(u)
    v = np.cross(axis, u)
    ring = math.sqrt(1 - 1 / far**2) * (_CIRCLE[:, :1] * u + _CIRCLE[:, 1:] * v)
    return centre + radii * (axis / far + ring)


def _outline(kind: str, q: FloatArray, eye: FloatArray) -> FloatArray:
    """Points whose hull is the silhouette. q: x, y, z of the foot, log sizes, yaw of a box."""
    foot = q[:3]
    size = np.exp(np.minimum(q[3:6], 8))
    if kind == "sphere":
        return sphere_rim(eye, foot + np.array([0, 0, size[0]]), np.full(3, size[0]))
    if kind == "ellipsoid":
        return sphere_rim(eye, foot + np.array([0, 0, size[1]]), size[[0, 0, 1]])
    if kind == "capsule":
        radius, straight = size[0], size[1]
        low = foot + np.array([0, 0, radius])
        high = low + np.array([0, 0, straight])
        ball = np.full(3, radius)
        return np.vstack([sphere_rim(eye, low, ball), sphere_rim(eye, high, ball)])
    if kind in ("cylinder", "frustum"):
        top = size[2] if kind == "frustum" else size[0]
        rings = [
            np.column_stack([_CIRCLE * size[0], np.zeros(40)]),
            np.column_stack([_CIRCLE * top, np.full(40, size[1])]),
        ]
        return foot + np.vstack(rings)
    if kind == "bowl":
        rings = [
            np.column_stack([_CIRCLE * radius, np.full(40, rise)])
            for rise, radius in _bowl_profile(size, float(q[6]), 6)
        ]
        return foot + np.vstack(rings)
    return foot + _box_corners(size, q[6])


def _bowl_profile(size: FloatArray, belly: float, rings: int) -> list[tuple[float, float]]:
    """(height, radius) from the foot to the rim of a bowl: foot radius, height, rim radius.

    belly: 0 for straight sides, 1 for those of an upright quarter of an ellipse.
    """
    foot, height, rim = (float(edge) for edge in size)
    power = 1 + min(max(belly, 0.0), 1.3)
    rise = 1 - np.cos(np.linspace(0, math.pi / 2, rings))
    bulge = (1 - (1 - rise) ** power) ** (1 / power)
    return [
        (float(height * r), float(foot + (rim - foot) * b))
        for r, b in zip(rise, bulge, strict=True)
    ]


def _box_corners(size: FloatArray, yaw: float) -> FloatArray:
    width, height, depth = size
    cos, sin = math.cos(yaw), math.sin(yaw)
    flat = np.array([[-width, -depth], [width, -depth], [width, depth], [-width, depth]]) / 2
    turned = flat @ np.array([[cos, sin], [-sin, cos]])
    lower = np.column_stack([turned, np.zeros(4)])
    return np.vstack([lower, lower + np.array([0, 0, height])])


def _starts(kind: str, width: float, height: float) -> list[list[float]]:
    w, h = math.log(width), math.log(height)
    if kind == "sphere":
        return [[math.log(min(width, height) / 2)]]
    if kind == "ellipsoid":
        return [[math.log(width / 2), math.log(height / 2)]]
    if kind == "capsule":
        return [[math.log(width / 2), math.log(max(height - width, 0.1 * height))]]
    if kind == "cylinder":
        return [[math.log(width / 2), math.log(height * 0.95)]]
    if kind == "bowl":
        return [[math.log(width / 4), h, math.log(width / 2), belly] for belly in (0.4, 1.0)]
    if kind == "frustum":
        return [[math.log(width / 2), h, math.log(width / 2)]]
    square = math.log(width * 0.74)
    yaws = (0.5, -0.5, math.pi / 4)
    turned = [[square, math.log(height * 0.85), square, yaw] for yaw in yaws]
    if width > 1.6 * height:
        # A flat thing seen from above: most of its visible height is its top.
        low = math.log(height * 0.4)
        turned = [
            [w - 0.25, low, w - 0.25 + more, yaw] for yaw in (0.5, -0.5) for more in (0, -0.5)
        ]
    return [[w - 0.05, h - 0.08, w - 0.6, 0.0], *turned]


def _fit(camera: Camera, target: Target, base: Base, kind: str) -> Fit | None:
    eye = np.array(camera.position)
    pixel = metres_per_pixel(camera, (base.x, base.y, base.z))
    width, height = target.width * pixel, target.height * pixel
    if pixel <= 0 or width <= 0:
        return None
    move_y = 0.0 if base.hold >= 1 else 1.0
    move_z = 1.0 if base.free_z else 0.0

    def placed(p: FloatArray) -> FloatArray:
        q = np.zeros(7)
        q[:3] = (
            base.x + p[0] * width,
            base.y + p[1] * width * move_y,
            base.z + p[2] * height * move_z,
        )
        q[3 : len(p)] = p[3:]
        return q

    def loss(p: FloatArray) -> float:
        q = placed(p)
        pixels, depth = camera.project(_outline(kind, q, eye))
        if depth.min() < 0.02 * base.y:
            return 2.0
        value = 1 - target.iou(pixels) + (0.004 + 1.0 * base.hold) * p[1] ** 2 * move_y
        if base.longest is not None:
            value += _unusual(q, kind, base.longest)
        if kind == "box":
            # What the outline leaves open: a depth like the width, and a straight view.
            value += _unlikely(q, base.below)
        return value

    best: tuple[float, FloatArray] | None = None
    starts = [[0.0, 0.3 * (1 - base.hold), *start] for start in _starts(kind, width, height)]
    if kind == "box" and base.below is not None:
        starts += _stacked(base, base.below, width, height)
    for x, y, *start in starts:
        first = np.array([x, y * move_y, 0.0, *start])
        steps = [0.1 if k < 3 else 0.18 for k in range(len(first))]
        simplex = np.vstack([first, first + np.diag(steps)])
        options = {"initial_simplex": simplex, "maxfev": 260, "xatol": 2e-3, "fatol": 2e-4}
        result = minimize(loss, first, method="Nelder-Mead", options=options)
        if best is None or result.fun < best[0]:
            best = (float(result.fun), result.x)
    assert best is not None
    q = placed(best[1])
    return _named(kind, q, target.iou(camera.project(_outline(kind, q, eye))[0]))


def _unusual(q: FloatArray, kind: str, longest: tuple[float, float]) -> float:
    """What a size loses that is far from the usual one: more than two spreads.

    What other things hide would else let a body grow without end.
    """
    sizes = q[3:6] if kind in ("box", "frustum", "bowl") else q[3:5]
    usual, spread = longest
    off = abs(float(sizes.max()) - math.log(usual)) / (spread + 0.25)
    return 0.02 * max(off - 2.0, 0.0) ** 2


def _unlikely(q: FloatArray, below: Lying | None) -> float:
    """What a box loses for numbers that its outline leaves open and that are not usual.

    A depth like the width and a straight view; in a stack, the size and the turn of what is below.
    """
    if below is None:
        return 0.006 * (q[5] - q[3]) ** 2 + 0.003 * abs(math.sin(2 * q[6]))
    size = (q[3] - math.log(below.width)) ** 2 + (q[5] - math.log(below.depth)) ** 2
    return 0.02 * size + 0.02 * math.sin(q[6] - below.yaw) ** 2


def _stacked(base: Base, below: Lying, width: float, height: float) -> list[list[float]]:
    """Starts for a box that lies on another as that one lies: x, y, log sizes, yaw."""
    x, y = (below.x - base.x) / width, (below.y - base.y) / width
    wide, deep = math.log(below.width), math.log(below.depth)
    low, flat = math.log(0.5 * height), math.log(0.25 * height)
    return [[x, y, wide, h, deep, below.yaw] for h in (low, flat)]


def _named(kind: str, q: FloatArray, iou: float) -> Fit:
    x, y, z = (float(v) for v in q[:3])
    size = [float(v) for v in np.exp(q[3:6])]
    rotation = IDENTITY
    shape: Shape
    if kind == "sphere":
        shape, lift = Sphere(radius=size[0]), size[0]
    elif kind == "ellipsoid":
        shape, lift = Ellipsoid(radii=(size[0], size[0], size[1])), size[1]
    elif kind == "capsule":
        total = size[1] + 2 * size[0]
        shape, lift = Capsule(radius=size[0], height=total), total / 2
    elif kind == "cylinder":
        shape, lift = Cylinder(radius=size[0], height=size[1]), size[1] / 2
    elif kind == "frustum":
        shape = Frustum(bottom_radius=size[0], height=size[1], top_radius=size[2])
        lift = frustum_centre(shape)
    elif kind == "bowl":
        outline = _bowl_profile(np.array(size), float(q[6]), BOWL_RINGS)
        lift = profile_centre(outline)
        shape = Revolved(profile=tuple((rise - lift, radius) for rise, radius in outline))
    else:
        shape, lift = Box(size=(size[0], size[2], size[1])), size[1] / 2
        rotation = about_up(float(q[6]))
    return Fit(shape, (x, y, z + lift), rotation, iou, iou)
