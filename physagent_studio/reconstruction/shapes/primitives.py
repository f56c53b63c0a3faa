"""Primitives fitted to a silhouette: each is drawn as the camera would see it and compared."""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from physagent_studio.arrays import BoolArray, FloatArray
from physagent_studio.program.base import IDENTITY
from physagent_studio.program.rotations import about_up
from physagent_studio.program.scene.camera import Camera
from physagent_studio.program.scene.shapes import frustum_centre
from physagent_studio.program.scene.state import (
    Box,
    Capsule,
    Cylinder,
    Ellipsoid,
    Frustum,
    Revolved,
    Shape,
    Sphere,
)
from physagent_studio.reconstruction.camera.rays import metres_per_pixel
from physagent_studio.reconstruction.photo.line_segments import Segments
from physagent_studio.reconstruction.shapes.contour_fitting import drawn_to, least_near, rim_of
from physagent_studio.reconstruction.shapes.creases import CREASE, Creases
from physagent_studio.reconstruction.shapes.fit_target import Target
from physagent_studio.reconstruction.shapes.meshes import profile_centre
from physagent_studio.reconstruction.shapes.outlines import bowl_profile, faces_seen, outline
from physagent_studio.reconstruction.switches import at_work

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


@dataclass(frozen=True, slots=True)
class PrimitiveSettings:
    """How primitives are fitted and compared."""

    bowl_rings: int = 16  # count, 6..60: between the foot and the rim of a bowl
    named_gain: float = 0.04  # IoU, 0..0.2: of a kind that the name suggests
    # IoU, 0..0.1: by which a box e times as deep as wide has to fit better, where its name tells
    # no depth; and e times as deep as its name tells
    depth_weight: float = 0.006
    told_depth_weight: float = 0.1  # IoU, 0.01..1: the same
    flat_weight: float = 0.03  # IoU, 0..0.2: the same of a flat box's thickness over its length
    # sine, 0.1..0.5: of the angle from above, from which the tops of round bodies are seen
    top_seen_slope: float = 0.25
    least_side_ratio: float = 0.2  # 0.05..0.5: of what is seen of one, that is its side then
    foot_ratio: float = 0.25  # 0.1..0.5: radius of its foot over its width
    top_ratio: float = 0.4  # 0.2..0.5: the same of its top: a handle may take the rest
    refined_turns: int = 3  # count, 1..10: beginnings of a turned box that are refined
    # 0.005..0.5: with which the best box is refined again: a simplex may be stuck
    polish_steps: tuple[float, float] = (0.1, 0.04)
    # -0.8..0.8: of boxes that are tried where no edge tells
    yaws_rad: tuple[float, ...] = (-0.7, -0.45, -0.2, 0.2, 0.45, 0.7)


PRIMITIVE = PrimitiveSettings()


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
    thing's longer side, m, and the spread of its logarithm, where that is known. deep: its usual
    depth over its width, where that is. flat: of flat boxes the shortest side over the longest.
    """

    x: float
    y: float
    z: float
    hold: float = 0.0
    free_z: bool = False
    below: Lying | None = None
    longest: tuple[float, float] | None = None
    deep: float | None = None
    flat: float | None = None


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
    found: Segments | None = None,
) -> list[Fit]:
    """The primitives of the given kinds in place, best first.

    hidden: pixels (H, W) of other objects, where this one may go on unseen. found: straight edges
    of the picture, where those within the mask shall say how a box is turned.
    """
    target = Target.of(mask, hidden)
    creases = None
    if found is not None and "box" in kinds and at_work("creases"):
        creases = Creases.within(mask, found)
    fits = [_fit(camera, target, base, kind, creases if kind == "box" else None) for kind in kinds]
    graded = [
        Fit(
            f.shape,
            f.position,
            f.rotation,
            f.iou,
            f.iou - COST[k] + PRIMITIVE.named_gain * (k in suggested),
        )
        for k, f in zip(kinds, fits, strict=True)
        if f is not None
    ]
    return sorted(graded, key=lambda fit: -fit.merit)


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
    return [[w - 0.05, h - 0.08, w - 0.6, 0.0]]


def _starts_from_above(kind: str, width: float, height: float, slope: float) -> list[list[float]]:
    """Beginnings for round bodies of which the top is seen: it takes a part of their height.

    slope: sine of the angle by which one looks down on them.
    """
    if slope < PRIMITIVE.top_seen_slope or not at_work("starts from above"):
        return []
    side = (height - width * slope) / math.sqrt(1 - min(slope, 0.99) ** 2)
    w, h = math.log(width), math.log(max(side, PRIMITIVE.least_side_ratio * height))
    foot, top = w + math.log(PRIMITIVE.foot_ratio), w + math.log(PRIMITIVE.top_ratio)
    starts = {"cylinder": [w - math.log(2), h], "bowl": [foot, h, top, 0.7]}
    starts["frustum"] = [foot, h, top]
    return [starts[kind]] if kind in starts else []


@dataclass(frozen=True, eq=False, slots=True)
class _Search:
    """Numbers of one kind of body that cover a target best.

    Parameters p: x, y, z of the foot from the base's, in extents of what is seen (width, height:
    m); then log sizes, a box's yaw or a bowl's belly.
    """

    camera: Camera
    target: Target
    base: Base
    kind: str
    creases: Creases | None
    width: float
    height: float

    @property
    def slope(self) -> float:
        """Sine of the angle by which one looks down on the foot; 0 from below."""
        away = np.array([self.base.x, self.base.y, self.base.z]) - self.camera.position
        return max(-float(away[2]) / float(np.linalg.norm(away)), 0.0)

    def placed(self, p: FloatArray) -> FloatArray:
        """x, y, z of the foot, m, and the numbers of the body: what `outline` takes."""
        q = np.zeros(7)
        along = 0.0 if self.base.hold >= 1 else p[1] * self.width
        up = p[2] * self.height if self.base.free_z else 0.0
        q[:3] = self.base.x + p[0] * self.width, self.base.y + along, self.base.z + up
        q[3 : len(p)] = p[3:]
        return q

    def corners(self, p: FloatArray) -> FloatArray | None:
        """Pixels (N, 2) of the outline; None where it comes too near."""
        eye = np.array(self.camera.position)
        pixels, depth = self.camera.project(outline(self.kind, self.placed(p), eye))
        return None if depth.min() < 0.02 * self.base.y else pixels

    def in_window(self, p: FloatArray) -> FloatArray | None:
        """The same in the window of the target."""
        pixels = self.corners(p)
        return None if pixels is None else self.target.local(pixels)

    def unlikely(self, p: FloatArray) -> float:
        """What speaks against the numbers beside the picture, in IoU."""
        q = self.placed(p)
        value = (0.004 + 1.0 * self.base.hold) * p[1] ** 2 if self.base.hold < 1 else 0.0
        if self.base.longest is not None and at_work("usual sizes of bodies"):
            value += _unusual(q, self.kind, self.base.longest)
        if self.kind == "box":
            # What the outline leaves open: a depth like the width, and a straight view.
            value += _unlikely(q, self.base)
        return value

    def loss(self, p: FloatArray) -> float:
        """1 − IoU, what is unlikely, less what creases on edges of the picture are worth."""
        pixels = self.corners(p)
        if pixels is None:
            return 2.0
        value = 1 - self.target.iou(pixels) + self.unlikely(p)
        if self.creases is not None:
            faces = faces_seen(self.placed(p), np.array(self.camera.position))
            value -= CREASE.crease_weight * self.creases.nearness(pixels, faces)
        return value

    def best(self) -> FloatArray:
        """The parameters found."""
        first = 0.3 * (1 - self.base.hold)
        starts = [[0.0, first, 0.0, *s] for s in _starts(self.kind, self.width, self.height)]
        if self.kind == "box":
            return self._best_box([*starts, *self._turned()])
        above = _starts_from_above(self.kind, self.width, self.height, self.slope)
        starts += [[0.0, 0.0, 0.0, *start] for start in above]
        free = np.arange(len(starts[0]))
        tried = [_refined(self.loss, np.array(start), free, 0.18, 260) for start in starts]
        return min(tried, key=lambda one: one[0])[1]

    def _best_box(self, starts: Sequence[Sequence[float]]) -> FloatArray:
        """Outlines are drawn to the rim, then the creases have their say."""
        fixed = [1] * (self.base.hold >= 1) + [2] * (not self.base.free_z)
        free = np.setdiff1d(np.arange(len(starts[0])), fixed)
        rim = rim_of(self.target.mask, self.target.open)
        snug = [
            drawn_to(rim, self.in_window, self.unlikely, np.array(start), free)
            for start in (starts if at_work("snug boxes") else ())
        ]
        first = min((*snug, *map(np.array, starts)), key=self.loss)
        tried = [_refined(self.loss, first, free, step, 200) for step in PRIMITIVE.polish_steps]
        return min(tried, key=lambda one: one[0])[1]

    def _turned(self) -> list[list[float]]:
        """Beginnings of turned boxes: what edges say is always tried."""
        yaws = self.creases.turns(self.camera) if self.creases is not None else []
        each = [
            min(_turned_boxes(self.width, self.height, yaw), key=lambda s: self.loss(np.array(s)))
            for yaw in (*yaws, *PRIMITIVE.yaws_rad)
        ]
        rest = sorted(each[len(yaws) :], key=lambda start: self.loss(np.array(start)))
        starts = [*each[: len(yaws)], *rest][: max(PRIMITIVE.refined_turns, len(yaws))]
        if self.base.below is not None and at_work("as what is below"):
            starts += _stacked(self.base, self.base.below, self.width, self.height)
        return starts


def _fit(
    camera: Camera, target: Target, base: Base, kind: str, creases: Creases | None
) -> Fit | None:
    pixel = metres_per_pixel(camera, (base.x, base.y, base.z))
    width, height = target.width * pixel, target.height * pixel
    if pixel <= 0 or width <= 0:
        return None
    search = _Search(camera, target, base, kind, creases, width, height)
    p = search.best()
    pixels = search.corners(p)
    return _named(kind, search.placed(p), 0.0 if pixels is None else target.iou(pixels))


def _refined(
    loss: Callable[[FloatArray], float],
    first: FloatArray,
    free: NDArray[np.intp],
    step: float,
    runs: int,
) -> tuple[float, FloatArray]:
    """The least loss near a beginning, and where it is.

    free: which parameters count. step: of sizes and turn, at first; of places it is half of it.
    """
    steps = np.array([step * (0.55 if k < 3 else 1.0) for k in range(len(first))])[free]

    def whole(some: FloatArray) -> FloatArray:
        out = first.copy()
        out[free] = some
        return out

    value, best = least_near(lambda p: loss(whole(p)), first[free], steps, runs)
    return value, whole(best)


def _turned_boxes(width: float, height: float, yaw: float) -> list[list[float]]:
    """Beginnings for boxes at a turn: x, y of the middle, 0, log sizes, yaw.

    width, height: of what is seen, m. A turned box looks wider than it is, its middle lies behind
    its foot, and of what is seen of it from above part is its top.
    """
    starts = []
    cos, sin = math.cos(yaw), abs(math.sin(yaw))
    for share, deep in itertools.product((0.2, 0.45, 0.85), (0.5, 1.0, 2.0)):
        side = width / (cos + deep * sin)
        behind = side * (deep * cos + sin) / 2 / width
        sizes = [math.log(side), math.log(share * height), math.log(deep * side)]
        starts.append([0.0, behind, 0.0, *sizes, yaw])
    return starts


def _unusual(q: FloatArray, kind: str, longest: tuple[float, float]) -> float:
    """What a size loses that is far from the usual one: more than two spreads.

    What other things hide would else let a body grow without end.
    """
    sizes = q[3:6] if kind in ("box", "frustum", "bowl") else q[3:5]
    usual, spread = longest
    off = abs(float(sizes.max()) - math.log(usual)) / (spread + 0.25)
    return 0.02 * max(off - 2.0, 0.0) ** 2


def _unlikely(q: FloatArray, base: Base) -> float:
    """What a box loses for numbers that its outline leaves open and that are not usual.

    The thickness or the depth that its name tells, else a depth like the width, and a straight
    view; in a stack, the size and the turn of what is below.
    """
    below = base.below
    if below is None:
        if base.flat is not None:
            thin = float(np.ptp(q[3:6])) + math.log(base.flat)
            return PRIMITIVE.flat_weight * thin**2 + 0.003 * abs(math.sin(2 * q[6]))
        told = base.deep is not None and at_work("usual depths")
        off = q[5] - q[3] - (math.log(base.deep) if told and base.deep is not None else 0.0)
        weight = PRIMITIVE.told_depth_weight if told else PRIMITIVE.depth_weight
        return weight * off**2 + 0.003 * abs(math.sin(2 * q[6]))
    size = (q[3] - math.log(below.width)) ** 2 + (q[5] - math.log(below.depth)) ** 2
    return 0.02 * size + 0.02 * math.sin(q[6] - below.yaw) ** 2


def _stacked(base: Base, below: Lying, width: float, height: float) -> list[list[float]]:
    """Starts for a box that lies on another as that one lies: x, y, 0, log sizes, yaw."""
    x, y = (below.x - base.x) / width, (below.y - base.y) / width
    wide, deep = math.log(below.width), math.log(below.depth)
    low, flat = math.log(0.5 * height), math.log(0.25 * height)
    return [[x, y, 0.0, wide, h, deep, below.yaw] for h in (low, flat)]


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
        curve = bowl_profile(np.array(size), float(q[6]), PRIMITIVE.bowl_rings)
        lift = profile_centre(curve)
        shape = Revolved(profile=tuple((rise - lift, radius) for rise, radius in curve))
    else:
        shape, lift = Box(size=(size[0], size[2], size[1])), size[1] / 2
        rotation = about_up(float(q[6]))
    return Fit(shape, (x, y, z + lift), rotation, iou, iou)
