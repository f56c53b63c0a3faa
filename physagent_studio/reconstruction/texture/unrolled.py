"""The surface of what is turned about an axis, unrolled: rings below one another, angles beside."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Self

import cv2
import numpy as np
from numpy.typing import NDArray

from physagent_studio.arrays import BoolArray, FloatArray
from physagent_studio.program.rotations import matrix_of
from physagent_studio.program.scene.camera import Camera
from physagent_studio.program.scene.forms import Capsule, Cylinder, Frustum, Revolved
from physagent_studio.program.scene.state import SceneObject
from physagent_studio.reconstruction.photo.regions import bounds, grow, shrink
from physagent_studio.reconstruction.shapes.meshes import MESHING, mesh_of
from physagent_studio.records.scene import Mesh
from physagent_studio.rendering.raster import Lens, rasterise


@dataclass(frozen=True, slots=True)
class UnrolledSettings:
    """How finely a surface is unrolled, and what of it the photo shows well."""

    across_px: tuple[int, int] = (96, 640)  # 32..2048: all around, least and most
    down_px: int = 640  # 64..2048: most, along its outline
    # 0.2..0.6: of the most squarely seen spot of a ring, from which on its colours are taken
    min_told_share: float = math.cos(math.radians(69.0))
    min_shown_share: float = math.cos(math.radians(79.0))  # 0.1..0.6: from which on it is shown
    min_facing_cosine: float = 0.08  # cosine, 0.02..0.3: below, the photo tells of nothing
    # cosine, -1..0: of a normal and up, below which it faces down
    below_cosine: float = -0.3
    # cosine, 0..0.7: of such a normal and the view, below which it is too shady to tell
    min_below_cosine: float = 0.25
    foot_share: float = 0.08  # 0..0.2: of its height, at the foot of what faces down
    rim_ratio: float = 0.012  # 0..0.05: over the smaller extent: the outline's rim of mixed pixels
    hidden_px: float = 3.0  # 1..8: within which one part of it is before another


UNROLLED = UnrolledSettings()


@dataclass(frozen=True, eq=False, slots=True)
class Unrolled:
    """A surface of revolution laid out flat, body frame.

    rings: (R, A) rows of the mesh's vertices, from one pole to the other. row: (R,) where in the
    picture each ring lies. places, normals: (H, W, 3) of its pixels. rim: the ring from
    which on they are the inside of a vessel. inside: (H,) whether a row is.
    """

    rings: NDArray[np.int64]
    row: FloatArray
    places: FloatArray
    normals: FloatArray
    rim: int
    inside: BoolArray

    @classmethod
    def of(cls, item: SceneObject, mesh: Mesh, metres_per_pixel: float) -> Self | None:
        """Of a thing whose mesh begins with that of its shape; None where that has no axis."""
        shape = item.shape
        if not isinstance(shape, Cylinder | Capsule | Frustum | Revolved):
            return None
        plain = mesh_of(shape).vertices
        around, count = MESHING.around_count, len(plain) - 2
        rings = np.arange(count).reshape(-1, around)
        rings = np.vstack([np.full(around, count), rings, np.full(around, count + 1)])
        grid = mesh.vertices[np.column_stack([rings, rings[:, 0]])]
        steps = np.linalg.norm(np.diff(grid, axis=0), axis=2).mean(1) / metres_per_pixel
        steps *= min(1.0, UNROLLED.down_px / max(float(steps.sum()), 1e-9))
        row = np.concatenate([[0.0], np.cumsum(np.maximum(steps, 1.0))])
        width = float(np.linalg.norm(np.diff(grid, axis=1), axis=2).sum(1).max())
        across = int(np.clip(width / metres_per_pixel, *UNROLLED.across_px))
        at = np.interp(np.arange(math.ceil(row[-1])) + 0.5, row, np.arange(len(row)))
        band = np.minimum(at.astype(int), len(row) - 2)
        share = (at - band)[:, None, None]
        lines = (1 - share) * grid[band] + share * grid[band + 1]
        turn = (np.arange(across) + 0.5) / across * around
        low = turn.astype(int)
        part = (turn - low)[None, :, None]
        places = (1 - part) * lines[:, low] + part * lines[:, low + 1]
        down = (grid[band + 1] - grid[band])[:, low]
        normals = np.cross(np.roll(places, -1, 1) - np.roll(places, 1, 1), down)
        normals /= np.maximum(np.linalg.norm(normals, axis=2, keepdims=True), 1e-12)
        hollow = getattr(shape, "wall", None) is not None
        rim = int(plain[rings[:, 0], 2].argmax()) if hollow else len(rings)
        return cls(rings, row, places, normals, rim, band >= rim)

    def seen(
        self, camera: Camera, item: SceneObject, mesh: Mesh, mask: BoolArray
    ) -> tuple[FloatArray, BoolArray, BoolArray]:
        """(H, W, 2) the photo's pixels of its places, (H, W) where they show them, and (H, W) where
        so well that it tells of other places too."""
        turn = matrix_of(item.rotation).T
        world = self.places.reshape(-1, 3) @ turn + np.asarray(item.position)
        view = np.asarray(camera.position) - world
        normals = self.normals.reshape(-1, 3) @ turn
        facing = (normals * view).sum(1) / np.maximum(np.linalg.norm(view, axis=1), 1e-12)
        pixels, depth = camera.project(world)
        x0, y0, x1, y1 = bounds(mask)
        rim = max(2, round(UNROLLED.rim_ratio * min(x1 - x0, y1 - y0)))
        core, own = shrink(mask, rim), grow(mask, rim)
        column = np.clip(pixels[:, 0].astype(int), 0, mask.shape[1] - 1)
        line = np.clip(pixels[:, 1].astype(int), 0, mask.shape[0] - 1)
        # What faces down ends in the shade of where it stands.
        below = normals[:, 2] < UNROLLED.below_cosine
        foot = np.minimum(line + round(UNROLLED.foot_share * (y1 - y0)), len(mask) - 1)
        shady = below & ((facing < UNROLLED.min_below_cosine) | ~mask[foot, column])
        # Between neighbours in the photo depth changes by as much as the surface is slanted.
        slope = np.sqrt(np.maximum(1 - facing**2, 0)) / np.maximum(facing, 1e-3)
        spare = UNROLLED.hidden_px * depth / camera.focal * (1 + slope)
        nearest, within = self._before(camera, item, mesh)
        shape = self.places.shape[:2]
        # What another thing covers is not shown either.
        free = (depth < nearest[line, column] + spare) & ~shady & own[line, column]
        facing = np.where(free, facing, -1.0).reshape(shape)
        # The walls of a vessel are thin: which side is seen is known where all around are of it.
        sides = [self.inside[:, None] == side[line, column].reshape(shape) for side in within]
        most = np.where(sides[0] | sides[1], facing, -1.0).max(1, keepdims=True)
        shown = (sides[0] | sides[1]) & (facing > np.maximum(UNROLLED.min_shown_share * most, 0.05))
        least = np.maximum(UNROLLED.min_told_share * most, UNROLLED.min_facing_cosine)
        told = sides[0] & sides[1] & (facing > least) & core[line, column].reshape(shape)
        for part in (self.inside, ~self.inside):
            told[part] &= _even(told[part])
        return pixels.reshape(*shape, 2), shown, told

    def _before(
        self, camera: Camera, item: SceneObject, mesh: Mesh
    ) -> tuple[FloatArray, tuple[BoolArray, BoolArray]]:
        """(H, W) how near the nearest part of a thing is within a pixel, along the axis, m, inf for
        none; and whether it is the inside of a vessel, all around and anywhere there."""
        lens = Lens(*camera.size, camera.focal, *camera.principal)
        world = mesh.vertices @ matrix_of(item.rotation).T + np.asarray(item.position)
        points = (world - np.asarray(camera.position)) @ camera.matrix
        hits = rasterise(points, mesh.faces, lens, np.zeros(len(mesh.faces), bool))
        depth = np.full(lens.height * lens.width, np.inf)
        depth[hits.pixel] = hits.depth
        inner = np.zeros(len(mesh.vertices), bool)
        inner[self.rings[self.rim :]] = True
        within = np.zeros(len(depth), np.uint8)
        within[hits.pixel] = inner[mesh.faces[hits.face]].all(1)
        shape = (lens.height, lens.width)
        around = np.ones((3, 3), np.uint8)
        near = cv2.erode(depth.reshape(shape), around)
        sides = (
            cv2.erode(within.reshape(shape), around),
            cv2.dilate(within.reshape(shape), around),
        )
        return np.asarray(near, np.float64), (sides[0] > 0, sides[1] > 0)


def _even(shown: BoolArray) -> BoolArray:
    """What is seen of rings (N, W), with an even rim: what is filled in from it would be torn."""
    if not len(shown):
        return shown
    rows_share = 0.04  # 0.01..0.2: of all rings, among which the least that is seen counts
    told = shown.any(1, keepdims=True)
    reach = max(1, round(rows_share * len(shown) / 2))
    least = cv2.erode((shown | ~told).astype(np.uint8), np.ones((2 * reach + 1, 1), np.uint8))
    even = cv2.GaussianBlur(least.astype(np.float32), (0, 0), sigmaX=0.5, sigmaY=reach)
    return np.asarray(even > 0.5) & told
