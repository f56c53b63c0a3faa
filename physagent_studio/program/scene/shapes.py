"""Convex outlines of objects and supports in NumPy: support points, extents and gaps.

Exact for the primitives. Inflated masks and meshes count as the corners of their hulls that they
have with them, else as the ellipsoid and the box of their size, a support's mesh as its bounding
box: good enough for distances that guide a search, and said so by `Outline.exact`.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import ArrayLike, NDArray

from physagent_studio.arrays import FloatArray
from physagent_studio.program.rotations import about_up, matrices_of, matrix_of
from physagent_studio.program.scene import forms
from physagent_studio.program.scene.boards import is_hollow
from physagent_studio.program.scene.stairs import profile_of

_TINY = 1e-12


@dataclass(frozen=True, eq=False, slots=True)
class Outline:
    """A convex body in its own frame, m: the sum of one core and a ball of radius `rounding`.

    The core is an ellipsoid (`radii`), a box (`half` edges), rings about z (`rings`, rows of
    (z, radius)) or a point cloud (`points`, (P, 3)). axis: body axis of rotational symmetry;
    is_ball: looks the same however it is turned.
    """

    radii: FloatArray | None = None
    half: FloatArray | None = None
    rings: FloatArray | None = None
    points: FloatArray | None = None
    rounding: float = 0.0
    exact: bool = True
    axis: tuple[float, float, float] | None = None
    is_ball: bool = False

    def support(self, directions: ArrayLike) -> FloatArray:
        """The farthest point (T, 3) of the body along each direction (T, 3), body frame."""
        d = np.asarray(directions, float)
        unit = d / np.maximum(np.linalg.norm(d, axis=-1, keepdims=True), _TINY)
        return self._core(unit) + self.rounding * unit

    def _core(self, d: FloatArray) -> FloatArray:
        if self.radii is not None:
            length = np.linalg.norm(self.radii * d, axis=-1, keepdims=True)
            return self.radii**2 * d / np.maximum(length, _TINY)
        if self.half is not None:
            return np.where(d >= 0, self.half, -self.half)
        if self.rings is not None:
            across = np.linalg.norm(d[..., :2], axis=-1)
            reach = d[..., 2:3] * self.rings[:, 0] + across[..., None] * self.rings[:, 1]
            ring = self.rings[np.argmax(reach, axis=-1)]
            flat = d[..., :2] / np.maximum(across, _TINY)[..., None] * ring[..., 1:2]
            return np.concatenate([flat, ring[..., :1]], axis=-1)
        if self.points is not None:
            return self.points[np.argmax(d @ self.points.T, axis=-1)]
        return np.zeros_like(d)

    @property
    def bounds(self) -> FloatArray:
        """(2, 3): lowest and highest corner of the bounding box in the body frame, m."""
        axes = np.eye(3)
        return np.stack([np.diag(self.support(-axes)), np.diag(self.support(axes))])

    @property
    def size(self) -> FloatArray:
        """(3,): edges of the bounding box in the body frame, m."""
        low, high = self.bounds
        return high - low

    @property
    def radius(self) -> float:
        """Half of the bounding box's diagonal, or the radius of a ball, m."""
        if self.is_ball:
            return float(self.size.max() / 2)
        return float(np.linalg.norm(self.size) / 2)


@dataclass(frozen=True, eq=False, slots=True)
class HalfSpace:
    """All points x with normal · x ≤ offset, world, m."""

    normal: FloatArray
    offset: float


@dataclass(frozen=True, eq=False, slots=True)
class Placed:
    """An outline over T poses, or a half-space that never moves.

    positions: (T, 3) world, m. matrices: (T, 3, 3) R_world_body. Static bodies have T = 1.
    """

    outline: Outline | None = None
    half_space: HalfSpace | None = None
    positions: FloatArray = field(default_factory=lambda: np.zeros((1, 3)))
    matrices: FloatArray = field(default_factory=lambda: np.eye(3)[None])

    def support(self, directions: FloatArray) -> FloatArray:
        """Farthest points (T, 3) along world directions (T, 3); only for outlines."""
        assert self.outline is not None
        local = np.einsum("tji,tj->ti", self.matrices, directions)
        world = np.einsum("tij,tj->ti", self.matrices, self.outline.support(local))
        return self.positions + world

    def at(self, rows: slice | NDArray[np.intp]) -> Placed:
        """The same body at some of its poses."""
        if len(self.positions) == 1:
            return self
        return Placed(self.outline, self.half_space, self.positions[rows], self.matrices[rows])


def outline_of(shape: forms.Shape) -> Outline:
    """The convex outline of an object's shape, centred as the shape is.

    Of hollow ones it is no measure of what is inside them.
    """
    outline = _outline_of(shape)
    return replace(outline, exact=False) if is_hollow(shape) else outline


def _outline_of(shape: forms.Shape) -> Outline:
    match shape:
        case forms.Inflated() | forms.Meshed() if len(shape.hull) > 3:
            corners = np.array(shape.hull)
            wide = np.ptp(corners, axis=0)
            # As large as its size says, which a person may change; what is flat stays so.
            grown = np.where(wide > _TINY, np.array(shape.size) / np.maximum(wide, _TINY), 1.0)
            return Outline(points=corners * grown, exact=False)
        case forms.Sphere():
            return Outline(rounding=shape.radius, is_ball=True)
        case forms.Ellipsoid():
            return _ellipsoid(np.array(shape.radii))
        case forms.Box():
            return Outline(half=np.array(shape.size) / 2)
        case forms.Cylinder():
            h, r = shape.height / 2, shape.radius
            return Outline(rings=np.array([[-h, r], [h, r]]), axis=(0.0, 0.0, 1.0))
        case forms.Capsule():
            h = max(shape.height / 2 - shape.radius, 0.0)
            core = np.array([[-h, 0.0], [h, 0.0]])
            return Outline(rings=core, rounding=shape.radius, axis=(0.0, 0.0, 1.0))
        case forms.Torus():
            # Exact against planes; its hole is no part of a convex outline.
            rim = np.array([[0.0, shape.radius]])
            axis = (0.0, 0.0, 1.0)
            return Outline(rings=rim, rounding=shape.tube, axis=axis)
        case forms.Frustum():
            low = -frustum_centre(shape)
            ends = [[low, shape.bottom_radius], [low + shape.height, shape.top_radius]]
            return Outline(rings=np.array(ends), axis=(0.0, 0.0, 1.0))
        case forms.Revolved():
            return Outline(rings=np.array(shape.profile), axis=(0.0, 0.0, 1.0))
        case forms.Inflated():
            return Outline(radii=np.array(shape.size) / 2, exact=False)
        case forms.Meshed():
            return Outline(half=np.array(shape.size) / 2, exact=False)


def _ellipsoid(radii: FloatArray) -> Outline:
    """An ellipsoid within a tenth of a ball counts as one: nobody sees which way it is turned."""
    ball = bool(radii.max() <= 1.1 * radii.min())
    axis = None
    for i in range(3):
        j, k = (i + 1) % 3, (i + 2) % 3
        if not ball and math.isclose(radii[j], radii[k], rel_tol=0.02):
            axis = tuple(float(part) for part in np.eye(3)[i])
    return Outline(radii=radii, is_ball=ball, axis=axis)  # type: ignore[arg-type]


def frustum_centre(shape: forms.Frustum) -> float:
    """Height of the centre of mass of a solid frustum above its base, m."""
    a, b = shape.bottom_radius, shape.top_radius
    area = a * a + a * b + b * b
    if area < _TINY:
        return shape.height / 2
    return shape.height / 4 * (a * a + 2 * a * b + 3 * b * b) / area


def place_object(shape: forms.Shape, positions: ArrayLike, rotations: ArrayLike) -> Placed:
    """An object over poses (T, 3) and (T, 4) wxyz."""
    return Placed(
        outline_of(shape),
        positions=np.atleast_2d(np.asarray(positions, float)),
        matrices=matrices_of(np.atleast_2d(np.asarray(rotations, float))),
    )


def place_support(shape: forms.SupportShape) -> Placed:
    """A support where it stands."""
    match shape:
        case forms.Floor():
            return Placed(half_space=HalfSpace(np.array([0.0, 0.0, 1.0]), shape.height))
        case forms.Wall():
            normal = np.array([math.cos(shape.yaw), math.sin(shape.yaw), 0.0])
            return Placed(half_space=HalfSpace(normal, float(normal @ shape.point)))
        case forms.Slab():
            outline = Outline(half=np.array(shape.size) / 2, exact=shape.rail is None)
            return _static(outline, np.array(shape.position), shape.yaw)
        case forms.Ramp():
            outline = Outline(points=_wedge(shape), exact=shape.steps < 2)
            return _static(outline, np.array(shape.toe), shape.yaw)
        case forms.Vessel():
            return _static(outline_of(shape.body), np.array(shape.position), shape.yaw)
        case forms.MeshedSupport():
            outline = Outline(half=np.array(shape.size) / 2, exact=False)
            return Placed(
                outline,
                positions=np.array([shape.position]),
                matrices=matrix_of(shape.rotation)[None],
            )


def _static(outline: Outline, position: FloatArray, yaw: float) -> Placed:
    return Placed(outline, positions=position[None], matrices=matrix_of(about_up(yaw))[None])


def _wedge(ramp: forms.Ramp) -> FloatArray:
    """Corners of a ramp, its toe at the origin and uphill along +x."""
    side = ramp.width / 2
    return np.array([(x, y, z) for x, z in profile_of(ramp) for y in (-side, side)])


def lowest(body: Placed) -> FloatArray:
    """(T,) height of the lowest point, m; minus infinity for a half-space."""
    return -reach(body, np.array([0.0, 0.0, -1.0]))


def reach(body: Placed, direction: FloatArray) -> FloatArray:
    """(T,) how far the body reaches along a unit world direction (3,), m."""
    if body.outline is None:
        return np.full(len(body.positions), np.inf)
    directions = np.broadcast_to(direction, body.positions.shape)
    return body.support(directions) @ direction


def gap(first: Placed, second: Placed, iterations: int = 12) -> FloatArray:
    """(T,) distance between two bodies' surfaces, m; negative (not below minus the overlap) inside.

    Half-spaces are exact. For two outlines it is the best separating plane among those square to
    the bodies' axes and those that Gilbert's algorithm visits (E. G. Gilbert, SIAM J. Control 4,
    1966): a bound from below, for boxes of half a metre within 5 mm.
    """
    if first.half_space is not None and second.half_space is not None:
        return np.zeros(1)
    if first.half_space is not None:
        return gap(second, first, iterations)
    if second.half_space is not None:
        return -reach(first, -second.half_space.normal) - second.half_space.offset
    length = max(len(first.positions), len(second.positions))
    one, two = stretched(first, length), stretched(second, length)
    best = np.full(length, -np.inf)
    for axis in range(3):
        for matrices in (one.matrices, two.matrices):
            for sign in (1.0, -1.0):
                best = np.maximum(best, _separation(one, two, sign * matrices[:, :, axis])[0])
    v = one.positions - two.positions
    for _ in range(iterations):
        apart, w = _separation(one, two, v)
        best = np.maximum(best, apart)
        step = v - w
        share = np.sum(v * step, -1) / np.maximum(np.sum(step * step, -1), _TINY)
        v = v - np.clip(share, 0, 1)[:, None] * step
    return best


def _separation(one: Placed, two: Placed, direction: FloatArray) -> tuple[FloatArray, FloatArray]:
    """How far a plane square to a direction (T, 3) keeps the bodies apart, (T,) m, and the point
    (T, 3) of the difference body one − two that lies farthest against it.
    """
    w = one.support(-direction) - two.support(direction)
    length = np.linalg.norm(direction, axis=-1)
    apart = np.sum(direction * w, -1) / np.maximum(length, _TINY)
    return np.where(length > 1e-9, apart, -np.inf), w


def stretched(body: Placed, length: int) -> Placed:
    """The body with its one pose repeated, where it has only one."""
    if len(body.positions) == length:
        return body
    return Placed(
        body.outline,
        positions=np.broadcast_to(body.positions, (length, 3)),
        matrices=np.broadcast_to(body.matrices, (length, 3, 3)),
    )


def depth_inside(points: FloatArray, body: Placed) -> FloatArray:
    """(T,) how deep world points (T, 3) lie inside a static support, m; negative outside.

    Boxes and ramps are intersections of half-spaces, so outside the figure is a lower bound
    of the distance. What is in a vessel is outside of it: of round ones this is told of all points.
    """
    if body.half_space is not None:
        return body.half_space.offset - points @ body.half_space.normal
    assert body.outline is not None
    local = (points - body.positions[0]) @ body.matrices[0]
    if body.outline.half is not None:
        return np.min(body.outline.half - np.abs(local), axis=-1)
    if body.outline.rings is not None:
        return np.full(len(points), -np.inf)
    assert body.outline.points is not None
    normals, offsets = _faces(body.outline.points)
    return np.min(offsets - local @ normals.T, axis=-1)


def _faces(corners: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Outward face normals (F, 3) and offsets (F,) of a wedge's corners (see `_wedge`)."""
    side = float(corners[1, 1])
    section = corners[::2][:, [0, 2]]
    ahead = np.roll(section, -1, axis=0) - section
    length = np.hypot(ahead[:, 0], ahead[:, 1])
    start, ahead = section[length > _TINY], (ahead / length[:, None].clip(_TINY))[length > _TINY]
    # The section runs over the surface and back below it: outside lies on the left.
    normals = np.column_stack([-ahead[:, 1], np.zeros(len(ahead)), ahead[:, 0]])
    offsets = np.einsum("ij,ij->i", normals[:, [0, 2]], start)
    sides = np.array([[0.0, 1.0, 0.0], [0.0, -1.0, 0.0]])
    return np.vstack([sides, normals]), np.concatenate([[side, side], offsets])
