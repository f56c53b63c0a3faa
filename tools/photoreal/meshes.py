"""Triangle meshes with smooth normals and texture coordinates. Body frame, metres.

A texture's first row lies at v = 0 and its first column at u = 0.
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.floating]

# The faces of a box: normal axis, its sign, and the axes that u and v run along.
_FACES = ((0, 1, 1, 2), (0, -1, 1, 2), (1, 1, 0, 2), (1, -1, 0, 2), (2, 1, 0, 1), (2, -1, 0, 1))


@dataclass(frozen=True)
class Mesh:
    """points (N, 3), normals (N, 3), uv (N, 2), faces (M, 3) counter-clockwise from outside."""

    points: Array
    normals: Array
    uv: Array
    faces: NDArray[np.int32]

    def posed(self, rotation: Array, position: Array) -> Mesh:
        """The mesh in the world: x_world = R x + p."""
        moved = self.points @ rotation.T + position
        return Mesh(moved, self.normals @ rotation.T, self.uv, self.faces)

    def write_ply(self, path: Path) -> None:
        """Binary PLY with normals and texture coordinates."""
        fields = ("x", "y", "z", "nx", "ny", "nz", "u", "v")
        table = np.hstack([self.points, self.normals, self.uv]).astype("<f4")
        faces = np.zeros(len(self.faces), [("n", "u1"), ("v", "<i4", 3)])
        faces["n"], faces["v"] = 3, self.faces
        header = ["ply", "format binary_little_endian 1.0", f"element vertex {len(table)}"]
        header += [f"property float {name}" for name in fields]
        header += [f"element face {len(faces)}", "property list uchar int vertex_indices"]
        header += ["end_header", ""]
        path.write_bytes("\n".join(header).encode() + table.tobytes() + faces.tobytes())


def _grid(rows: int, columns: int) -> NDArray[np.int32]:
    """Triangles of a rows × columns grid of vertices, counter-clockwise in (column, row)."""
    a = (np.arange(rows - 1)[:, None] * columns + np.arange(columns - 1)[None, :]).ravel()
    b, c, d = a + 1, a + columns + 1, a + columns
    return np.concatenate([np.stack([a, b, c], 1), np.stack([a, c, d], 1)]).astype(np.int32)


def _joined(parts: list[Mesh]) -> Mesh:
    starts = np.cumsum([0] + [len(p.points) for p in parts[:-1]])
    return Mesh(
        np.concatenate([p.points for p in parts]),
        np.concatenate([p.normals for p in parts]),
        np.concatenate([p.uv for p in parts]),
        np.concatenate([p.faces + s for p, s in zip(parts, starts, strict=True)]).astype(np.int32),
    )


def _outward(mesh: Mesh) -> Mesh:
    """Turn every triangle that disagrees with its vertex normals."""
    a, b, c = (mesh.points[mesh.faces[:, k]] for k in range(3))
    wrong = np.einsum("ij,ij->i", np.cross(b - a, c - a), mesh.normals[mesh.faces[:, 0]]) < 0
    faces = mesh.faces.copy()
    faces[wrong] = faces[wrong][:, ::-1]
    return Mesh(mesh.points, mesh.normals, mesh.uv, faces)


def box(size: tuple[float, float, float], edge: float, *, planar: bool = False) -> Mesh:
    """A box of full extents `size` about the origin with edges rounded by radius `edge`.

    Texture coordinates are a 3 × 2 atlas of the six faces (`atlas_points` gives its texels),
    or, `planar`, x and y over the whole extent for every face.
    """
    half = np.asarray(size) / 2
    steps = (1 - np.cos(np.linspace(0, np.pi / 2, 7))) * edge
    parts = []
    for cell, (axis, sign, ua, va) in enumerate(_FACES):
        line = [np.concatenate([-half[k] + steps, (half[k] - steps)[::-1]]) for k in (ua, va)]
        u, v = np.meshgrid(*line)
        sharp = np.zeros((u.size, 3))
        sharp[:, axis], sharp[:, ua], sharp[:, va] = sign * half[axis], u.ravel(), v.ravel()
        core = np.clip(sharp, -(half - edge), half - edge)
        normal = sharp - core
        normal /= np.linalg.norm(normal, axis=1, keepdims=True)
        local = (sharp[:, [ua, va]] / half[[ua, va]] + 1) / 2
        uv = (local * 0.98 + 0.01 + (cell % 3, cell // 3)) / (3, 2)
        if planar:
            uv = sharp[:, :2] / (2 * half[:2]) + 0.5
        parts.append(Mesh(core + normal * edge, normal, uv, _grid(*u.shape)))
    return _outward(_joined(parts))


def atlas_points(size: tuple[float, float, float], cell: int) -> Array:
    """Body points (2 · cell, 3 · cell, 3) of the texels of a box's atlas."""
    half = np.asarray(size) / 2
    t = np.clip(((np.arange(cell) + 0.5) / cell - 0.01) / 0.98, -0.02, 1.02) * 2 - 1
    points = np.zeros((2 * cell, 3 * cell, 3))
    for k, (axis, sign, ua, va) in enumerate(_FACES):
        rows, columns = slice((k // 3) * cell, (k // 3 + 1) * cell), slice(k % 3 * cell, None)
        view = points[rows, columns][:, :cell]
        view[..., axis] = sign * half[axis]
        view[..., ua], view[..., va] = (t * half[ua])[None, :], (t * half[va])[:, None]
    return points


def lathe(profile: Array, normals: Array, around: int = 256) -> Mesh:
    """A profile (N, 2) of (radius, z) with normals (N, 2), turned about z.

    u goes around, v along the profile's length.
    """
    length = np.concatenate([[0], np.cumsum(np.linalg.norm(np.diff(profile, axis=0), axis=1))])
    angle = np.linspace(0, 2 * np.pi, around + 1)
    cos, sin = np.cos(angle)[None, :], np.sin(angle)[None, :]

    def turned(rz: Array) -> Array:
        r, z = rz[:, :1], rz[:, 1:]
        return np.stack([r * cos, r * sin, np.broadcast_to(z, (len(rz), len(angle)))], -1)

    u, v = np.meshgrid(angle / (2 * np.pi), length / length[-1])
    return _outward(
        Mesh(
            turned(profile).reshape(-1, 3),
            turned(normals).reshape(-1, 3),
            np.stack([u.ravel(), v.ravel()], 1),
            _grid(len(profile), len(angle)),
        )
    )


def ellipsoid(radii: tuple[float, float, float], rings: int = 160) -> Mesh:
    """An ellipsoid (or sphere) with semi-axes `radii`; v runs from the south pole up."""
    latitude = np.linspace(-np.pi / 2, np.pi / 2, rings + 1)
    unit = np.stack([np.cos(latitude), np.sin(latitude)], 1)
    ball = lathe(unit, unit, 2 * rings)
    normals = ball.points / np.asarray(radii)
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    return Mesh(ball.points * radii, normals, ball.uv, ball.faces)


def sphere(radius: float) -> Mesh:
    """A ball about the origin."""
    return ellipsoid((radius, radius, radius))


def cube(side: float, edge: float) -> Mesh:
    """A cube about the origin with edges rounded by `edge`."""
    return box((side, side, side), edge)


def cylinder(radius: float, height: float, edge: float) -> Mesh:
    """An upright cylinder about the origin with rims rounded by `edge`."""
    turn = np.linspace(0, np.pi / 2, 9)
    corner = np.stack([np.sin(turn), -np.cos(turn)], 1)
    low = corner * edge + (radius - edge, -height / 2 + edge)
    high = (corner * (1, -1))[::-1]
    upper = high * edge + (radius - edge, height / 2 - edge)
    profile = np.concatenate([[[1e-5, -height / 2]], low, upper, [[1e-5, height / 2]]])
    normals = np.concatenate([[[0, -1]], corner, high, [[0, 1]]])
    return lathe(profile, normals)


def wedge(run: float, rise: float, width: float) -> Mesh:
    """A ramp: toe edge at x = 0, climbing along +x to `rise` at x = `run`, y within ± width/2."""
    w = width / 2
    toe, foot, top = np.array([0, 0]), np.array([run, 0]), np.array([run, rise])

    def at(p: Array, y: float) -> Array:
        return np.array([p[0], y, p[1]])

    quads = [
        [at(toe, -w), at(top, -w), at(top, w), at(toe, w)],
        [at(foot, -w), at(foot, w), at(top, w), at(top, -w)],
        [at(toe, -w), at(toe, w), at(foot, w), at(foot, -w)],
        [at(toe, -w), at(foot, -w), at(top, -w), at(top, -w)],
        [at(toe, w), at(top, w), at(foot, w), at(foot, w)],
    ]
    middle = np.array([run * 2 / 3, 0, rise / 3])
    parts = []
    for quad in quads:
        points = np.array(quad, float)
        normal = np.cross(points[1] - points[0], points[2] - points[0])
        normal /= np.linalg.norm(normal)
        normal *= np.sign(normal @ (points[:3].mean(0) - middle))
        flat = points[:, [0, 1]] if abs(normal[1]) < 0.5 else points[:, [0, 2]]
        faces = np.array([[0, 1, 2], [0, 2, 3]], np.int32)
        parts.append(Mesh(points, np.tile(normal, (4, 1)), flat / max(run, width) + 0.5, faces))
    return _outward(_joined(parts))
