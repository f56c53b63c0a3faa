"""Meshes of simple forms, each a grid of points wrapped around a body."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from physagent_studio.arrays import FloatArray

IntArray = NDArray[np.int32]
ROWS, COLUMNS = 14, 26
"""Points of a grid along and around a body."""
POINTS_OF_TUBE = 9
"""Points around a tube, which is thin."""


@dataclass(frozen=True, eq=False, slots=True)
class Form:
    """vertices (V, 3), metres; faces (F, 3); local (V, 3): the same points, −1 … 1 in the form."""

    vertices: FloatArray
    faces: IntArray
    local: FloatArray


def ball(size: Sequence[float], roundness: float = 1.0) -> Form:
    """An ellipsoid of that size; a block with rounded edges for a roundness near 0.

    The superellipsoid of Barr, "Superquadrics and angle-preserving transformations", 1981.
    """
    up, around = np.meshgrid(
        np.linspace(-np.pi / 2, np.pi / 2, ROWS), _turn(COLUMNS), indexing="ij"
    )
    c, s = _power(np.cos(up), roundness), _power(np.sin(up), roundness)
    points = np.stack(
        [c * _power(np.cos(around), roundness), c * _power(np.sin(around), roundness), s], -1
    )
    return _wrapped(points * np.asarray(size) / 2)


def can(size: Sequence[float], taper: float = 1.0) -> Form:
    """An upright cylinder or cone. taper: width of the top over that of the foot."""
    half = size[2] / 2
    profile = [(0.0, -half), (0.5, -half), (0.5 * taper, half), (0.0, half)]
    made = lathe(profile)
    scale = np.array([size[0], size[1], 1.0])
    return _scaled(Form(made.vertices * scale, made.faces, made.local))


def lathe(profile: Sequence[Sequence[float]]) -> Form:
    """A profile of (radius, height), from the foot up, turned about the z axis."""
    line = _finer(np.asarray(profile, float), 3)
    around = _turn(2 * COLUMNS)
    points = np.stack(
        [
            line[:, :1] * np.cos(around),
            line[:, :1] * np.sin(around),
            np.repeat(line[:, 1:], len(around), 1),
        ],
        -1,
    )
    return _scaled(_wrapped(points))


def tube(through: Sequence[Sequence[float]], thick: float, sharp: bool = False) -> Form:
    """A tube of that thickness through points, around bends unless they are sharp."""
    line = np.asarray(through, float)
    line = _finer(line, 5) if sharp or len(line) < 3 else _bent(line)
    # Both ends are flat: there the tube comes to its full width at once.
    line = np.vstack([line[:1], line, line[-1:]])
    ahead = np.gradient(line, axis=0)
    ahead /= np.maximum(np.linalg.norm(ahead, axis=1, keepdims=True), 1e-9)
    side = np.cross(ahead, np.where(np.abs(ahead[:, 2:]) < 0.9, (0.0, 0.0, 1.0), (0.0, 1.0, 0.0)))
    side /= np.maximum(np.linalg.norm(side, axis=1, keepdims=True), 1e-9)
    other = np.cross(side, ahead)
    around = _turn(POINTS_OF_TUBE)
    ring = (
        np.cos(around)[None, :, None] * side[:, None]
        + np.sin(around)[None, :, None] * (other[:, None])
    )
    reach = np.full(len(line), thick / 2)
    reach[[0, -1]] = 0.0
    made = _wrapped(line[:, None] + reach[:, None, None] * ring)
    along = np.repeat(np.linspace(-1, 1, len(line)), len(around))
    return Form(made.vertices, made.faces, np.stack([0 * along, 0 * along, along], 1))


def ring(size: Sequence[float]) -> Form:
    """A ring that lies flat: outer width, depth, and its thickness."""
    thick = size[2] / 2
    turn, around = np.meshgrid(_turn(2 * COLUMNS), _turn(ROWS), indexing="ij")
    reach = 1 + thick / (size[0] / 2 - thick) * np.cos(around)
    middle = np.array([size[0] / 2 - thick, size[1] / 2 - thick])
    points = np.stack(
        [
            middle[0] * reach * np.cos(turn),
            middle[1] * reach * np.sin(turn),
            thick * np.sin(around),
        ],
        -1,
    )
    return _scaled(_wrapped(points, closed=True))


def brick(size: Sequence[float], right: float = 1.0) -> Form:
    """A block with sharp edges. right: height of its right side over the left one's, 0 a wedge."""
    (x, y, z), (u, v, w) = -np.asarray(size) / 2, np.asarray(size) / 2
    low = z + right * (w - z)
    sides = (
        ((x, y, w), (u, y, low), (u, v, low), (x, v, w)),
        ((x, v, z), (u, v, z), (u, y, z), (x, y, z)),
        ((x, v, z), (x, y, z), (x, y, w), (x, v, w)),
        ((u, y, z), (u, v, z), (u, v, low), (u, y, low)),
        ((x, y, z), (u, y, z), (u, y, low), (x, y, w)),
        ((u, v, z), (x, v, z), (x, v, w), (u, v, low)),
    )
    # Sides share no corners, so that each is flat.
    vertices = np.array([corner for side in sides for corner in side])
    first = 4 * np.arange(len(sides))[:, None, None]
    faces = (first + np.array([[0, 1, 2], [0, 2, 3]])).reshape(-1, 3)
    return _scaled(Form(vertices, faces.astype(np.int32), vertices))


def _wrapped(points: FloatArray, closed: bool = False) -> Form:
    """A grid (R, C, 3) whose columns, and rows if closed, meet again."""
    rows, columns = points.shape[:2]
    index = np.arange(rows * columns).reshape(rows, columns)
    below = index if closed else index[:-1]
    above = np.roll(index, -1, 0) if closed else index[1:]
    a, b = below, np.roll(below, -1, 1)
    c, d = above, np.roll(above, -1, 1)
    faces = np.concatenate(
        [np.stack([a, b, d], -1).reshape(-1, 3), np.stack([a, d, c], -1).reshape(-1, 3)]
    )
    vertices = points.reshape(-1, 3)
    return _scaled(Form(vertices, faces.astype(np.int32), vertices))


def _scaled(form: Form) -> Form:
    """With the local place of each vertex anew, −1 … 1 in the form's bounds."""
    low, high = form.vertices.min(0), form.vertices.max(0)
    local = 2 * (form.vertices - low) / np.maximum(high - low, 1e-9) - 1
    return Form(form.vertices, form.faces, local)


def _turn(count: int) -> FloatArray:
    return np.arange(count) * 2 * np.pi / count


def _power(values: FloatArray, exponent: float) -> FloatArray:
    return np.sign(values) * np.abs(values) ** exponent


def _finer(line: FloatArray, times: int) -> FloatArray:
    """The line with points between; its corners stay."""
    at = np.linspace(0, len(line) - 1, (len(line) - 1) * times + 1)
    return np.stack([np.interp(at, np.arange(len(line)), column) for column in line.T], 1)


def _bent(line: FloatArray) -> FloatArray:
    """A smooth line through the points (Catmull and Rom 1974)."""
    padded = np.vstack([2 * line[0] - line[1], line, 2 * line[-1] - line[-2]])
    t = np.linspace(0, 1, 7)[:-1, None]
    out = []
    for k in range(len(line) - 1):
        a, b, c, d = padded[k : k + 4]
        out.append(
            0.5 * (2 * b + (c - a) * t + (2 * a - 5 * b + 4 * c - d) * t**2)
            + 0.5 * (3 * b - a - 3 * c + d) * t**3
        )
    return np.vstack([*out, line[-1:]])
