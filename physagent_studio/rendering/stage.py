"""What does not move: the ground that takes shadows and the supports that hide objects."""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Self

import cv2
import numpy as np
from numpy.typing import NDArray

from physagent_studio.program.scene.camera import Camera
from physagent_studio.program.scene.state import Floor, SceneState, Vessel, Wall
from physagent_studio.records.scene import Mesh
from physagent_studio.rendering.batch import Batch
from physagent_studio.rendering.coverage import partial_pixels
from physagent_studio.rendering.frame import Picture
from physagent_studio.rendering.raster import FloatArray, Hits, Lens, rasterise
from physagent_studio.rendering.seen_supports import margins_of
from physagent_studio.rendering.shadow import Ground

_STRIDE = 2
"""Shadows are soft, so the ground is looked up once for this many pixels, each way."""
_TOLERANCE = 0.08
"""How far an object may sink into its support, in its own radii, before the support hides it."""
_CONTRADICTED = 0.2
"""Share of an object's visible pixels that a support would hide in the photo itself."""


@dataclass(frozen=True, eq=False, slots=True)
class Solid:
    """A support that can hide objects. planes: (P, 4) outward normal and offset of those of its
    faces that look at the camera, n·x ≤ offset behind them.
    """

    name: str
    planes: FloatArray

    def sunk(self, points: FloatArray) -> FloatArray:
        """How far points (K, 3) lie behind the faces that the camera sees, m."""
        if not len(self.planes):
            return np.full(len(points), np.inf)
        return (self.planes[:, 3] - points @ self.planes[:, :3].T).min(1)


@dataclass(frozen=True, eq=False, slots=True)
class Stage:
    """Static geometry as the camera sees it.

    depth: (H·W,) along the axis to the nearest solid, inf for none. solid: (H·W,) its index. share:
    (H·W,) how much of each pixel solids cover.
    rays: (H·W, 3) world directions with optical-axis component 1. ground: takes shadows.
    """

    solids: tuple[Solid, ...]
    depth: FloatArray
    solid: NDArray[np.int16]
    share: NDArray[np.float32]
    rays: FloatArray
    origin: FloatArray
    ground: Ground

    @classmethod
    def of(cls, state: SceneState, meshes: Mapping[str, Mesh], camera: Camera, lens: Lens) -> Self:
        """Prepare the supports of a scene; `meshes` are in the world frame."""
        origin = np.array(camera.position, float)
        rays = pixel_rays(camera, lens)
        names = _solid_names(state, meshes)
        hollow = {item.name for item in state.supports if isinstance(item.shape, Vessel)}
        depth, solid = np.full(len(rays), np.inf), np.full(len(rays), -1, np.int16)
        hits, _, owner = struck([meshes[n] for n in names], camera, lens)
        depth[hits.pixel], solid[hits.pixel] = hits.depth, owner
        return cls(
            solids=tuple(_solid(n, meshes[n], origin, n in hollow) for n in names),
            depth=depth,
            solid=solid,
            share=_covered(_solid_meshes(state, meshes), solid, camera, lens),
            rays=rays,
            origin=origin,
            ground=_ground(state, meshes, camera, lens),
        )

    def as_seen(self, plate: Picture) -> Self:
        """The same where the plate (H, W, 3) shows its solids; their margins hide nothing."""
        shape = plate.shape[:2]
        margins = margins_of(plate, self.solid.reshape(shape))
        if not margins.any():
            return self
        gone = margins.ravel()
        soft = cv2.blur(margins.astype(np.float32), (3, 3)).ravel()
        return replace(
            self,
            depth=np.where(gone, np.inf, self.depth),
            solid=np.where(gone, np.int16(-1), self.solid),
            share=np.where(gone, np.float32(0), np.minimum(self.share, 1 - soft)),
        )

    def hidden(self, hits: Hits, owner: NDArray, tolerance: FloatArray) -> NDArray[np.bool_]:
        """Which hits lie behind a solid. tolerance: (objects, solids) m, inf never hides."""
        result = np.zeros(len(hits.pixel), bool)
        near = np.flatnonzero(hits.depth > self.depth[hits.pixel])
        if not len(near):
            return result
        which = self.solid[hits.pixel[near]]
        points = self.origin + self.rays[hits.pixel[near]] * hits.depth[near, None]
        for index, solid in enumerate(self.solids):
            mine = np.flatnonzero(which == index)
            if len(mine):
                sunk = solid.sunk(points[mine])
                allowed = tolerance[owner[near[mine]], index]
                result[near[mine]] = sunk > allowed
        return result

    def tolerances(
        self, hits: Hits, owner: NDArray, radii: FloatArray, shown: NDArray[np.bool_]
    ) -> FloatArray:
        """(objects, solids) tolerance that agrees with the photo.

        hits, owner: of the initial pose. shown: (K,) whether the photo shows the object at that
        hit. What the photo shows is never hidden: the tolerance grows, or the pair is let off.
        """
        result = np.tile(_TOLERANCE * radii[:, None], (1, len(self.solids)))
        for index in range(len(radii)):
            mine = np.flatnonzero((owner == index) & shown)
            if not len(mine):
                continue
            behind = mine[hits.depth[mine] > self.depth[hits.pixel[mine]]]
            which = self.solid[hits.pixel[behind]]
            points = self.origin + self.rays[hits.pixel[behind]] * hits.depth[behind, None]
            for other, solid in enumerate(self.solids):
                sunk = solid.sunk(points[which == other])
                limit = result[index, other]
                wrong = np.count_nonzero(sunk > limit)
                if wrong > _CONTRADICTED * len(mine):
                    result[index, other] = np.inf
                elif wrong:
                    result[index, other] = max(limit, 1.1 * float(sunk.max()))
        return result


def pixel_rays(camera: Camera, lens: Lens) -> FloatArray:
    """World directions (H·W, 3) through the pixel centres, optical-axis component 1."""
    x = (np.arange(lens.width) + 0.5 - lens.cx) / lens.focal
    y = (np.arange(lens.height) + 0.5 - lens.cy) / lens.focal
    right, down, forward = camera.matrix.T
    rays = forward + x[None, :, None] * right + y[:, None, None] * down
    return rays.reshape(-1, 3)


def struck(
    meshes: list[Mesh], camera: Camera, lens: Lens
) -> tuple[Hits, FloatArray, NDArray[np.int32]]:
    """What the pixels see of meshes in the world frame, the unit normals (K, 3) there, towards the
    camera, and the meshes (K,).

    Without regard to facing, so that the hollow of an open mesh is seen too.
    """
    batch = Batch.of(meshes)
    points = (batch.vertices - camera.position) @ camera.matrix
    hits = rasterise(points, batch.faces, lens, np.zeros(len(batch.faces), bool))
    a, b, c = (batch.vertices[batch.faces[hits.face, i]] for i in range(3))
    normals = np.cross(b - a, c - a)
    normals /= np.maximum(np.linalg.norm(normals, axis=1, keepdims=True), 1e-12)
    away = np.einsum("ki,ki->k", normals, a - camera.position) > 0
    normals[away] *= -1
    return hits, normals, batch.face_owner[hits.face]


def _covered(
    meshes: list[Mesh], solid: NDArray[np.int16], camera: Camera, lens: Lens
) -> NDArray[np.float32]:
    """(H·W,) share of each pixel that lies on a solid."""
    batch = Batch.of(meshes)
    points = (batch.vertices - camera.position) @ camera.matrix
    missed = np.ones(lens.width * lens.height, np.float32)
    whole = solid >= 0
    for partial in partial_pixels(batch, points, lens):
        missed[partial.pixel] *= 1 - partial.share
        whole[partial.pixel] = False
    return np.where(whole, np.float32(1), 1 - missed)


def planes_seen(
    state: SceneState, origin: FloatArray, rays: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Depth of the nearest floor or wall along each ray, inf for none, and its unit normal."""
    depth, normals = np.full(len(rays), np.inf), np.zeros((len(rays), 3))
    for support in state.supports:
        if isinstance(support.shape, Floor):
            normal, offset = np.array([0.0, 0, 1]), support.shape.height
        elif isinstance(support.shape, Wall):
            yaw = support.shape.yaw
            normal = np.array([np.cos(yaw), np.sin(yaw), 0])
            offset = float(normal @ np.array(support.shape.point))
        else:
            continue
        along = rays @ normal
        with np.errstate(divide="ignore", invalid="ignore"):
            distance = (offset - origin @ normal) / along
        nearer = (along < 0) & (distance > 0) & (distance < depth)
        depth[nearer], normals[nearer] = distance[nearer], normal
    return depth, normals


def _solid(name: str, mesh: Mesh, origin: FloatArray, hollow: bool) -> Solid:
    """The faces of a solid; of a hollow one those of its outside, behind which its inside is."""
    a, b, c = (mesh.vertices[mesh.faces[:, i]] for i in range(3))
    normals = np.cross(b - a, c - a)
    length = np.linalg.norm(normals, axis=1)
    keep = length > 1e-12
    normals = normals[keep] / length[keep, None]
    planes = np.column_stack([normals, np.einsum("ij,ij->i", normals, a[keep])])
    planes = np.unique(np.round(planes.astype(np.float64), 6), axis=0)
    if hollow:
        reach = (mesh.vertices @ planes[:, :3].T).max(0)
        planes = planes[reach <= planes[:, 3] + 1e-3 * float(np.ptp(mesh.vertices, axis=0).max())]
    return Solid(name, planes[planes[:, :3] @ origin > planes[:, 3]])


def _ground(state: SceneState, meshes: Mapping[str, Mesh], camera: Camera, lens: Lens) -> Ground:
    """What each cell of `_STRIDE` by `_STRIDE` pixels shows in its middle."""
    k = _STRIDE
    size = (-(-lens.width // k), -(-lens.height // k))
    coarse = Lens(*size, lens.focal / k, lens.cx / k, lens.cy / k)
    rays, origin = pixel_rays(camera, coarse), np.array(camera.position, float)
    hits, facing, _ = struck(_solid_meshes(state, meshes), camera, coarse)
    depth, normals = planes_seen(state, origin, rays)
    near = hits.depth <= depth[hits.pixel]
    depth[hits.pixel[near]], normals[hits.pixel[near]] = hits.depth[near], facing[near]
    with np.errstate(invalid="ignore"):
        points = origin + rays * depth[:, None]
    points[~np.isfinite(depth)] = np.inf
    shape = (size[1], size[0], 3)
    where = points.reshape(shape), normals.reshape(shape)
    return Ground(*where, k, coarse, origin, camera.matrix)


def _solid_meshes(state: SceneState, meshes: Mapping[str, Mesh]) -> list[Mesh]:
    return [meshes[name] for name in _solid_names(state, meshes)]


def _solid_names(state: SceneState, meshes: Mapping[str, Mesh]) -> list[str]:
    """Supports that can stand before an object: nothing gets behind a floor or a wall."""
    shapes = {support.name: support.shape for support in state.supports}
    return [name for name in meshes if not isinstance(shapes.get(name), Floor | Wall)]
