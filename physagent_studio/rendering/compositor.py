"""`Compositor`: the scene prepared once, then one picture per set of poses."""

from __future__ import annotations

from collections.abc import Mapping

import cv2
import numpy as np
from numpy.typing import ArrayLike, NDArray

from physagent_studio.errors import InputError
from physagent_studio.program.camera import Camera
from physagent_studio.program.rotations import matrices_of
from physagent_studio.records.scene import Mesh, Scene
from physagent_studio.rendering.backdrop import PALETTE, draw_backdrop
from physagent_studio.rendering.batch import Batch, corner_normals
from physagent_studio.rendering.blend import blend_outlines
from physagent_studio.rendering.coverage import partial_pixels
from physagent_studio.rendering.frame import Frame, Picture, Surface
from physagent_studio.rendering.light import LIGHT, lambert, relative
from physagent_studio.rendering.raster import FloatArray, Hits, Lens, rasterise
from physagent_studio.rendering.settled import Settled
from physagent_studio.rendering.shadow import transmitted
from physagent_studio.rendering.stage import Stage
from physagent_studio.rendering.texture import Paint, paints

_SAME = 1e-12
_UNPAINTED = Mesh(np.zeros((0, 3)), np.zeros((0, 3), np.int32)).color


class Compositor:
    """Renders a scene: the plate, the objects in their photo textures, their shadows.

    The photo already carries light and shadow of the initial pose, so light is applied as the
    change since then, shadows as objects leave their place, and frame 0 looks like the photo.
    Without a photo the backdrop is drawn, light and shadow are applied in full. Nothing in it
    changes after it is made.
    """

    def __init__(self, scene: Scene) -> None:
        """Prepare a scene whose state is complete.

        Raises:
            InputError: the scene has no camera, or an object without mesh or position.
        """
        camera = scene.state.camera
        if camera is None:
            raise InputError("the scene has no camera, so it cannot be rendered")
        self.names = tuple(item.name for item in scene.state.objects)
        self.lens = lens_of(camera)
        self._camera = camera
        self._matrix = camera.matrix
        self._photographed = scene.plate is not None
        meshes = _meshes(scene, self._photographed)
        self._batch = Batch.of(meshes)
        self._paints = paints(meshes)
        self._textured = np.array([bool(p.levels) for p in self._paints], bool)
        self._stage = Stage.of(scene.state, scene.support_meshes, camera, self.lens)
        self._plate = self._backdrop(scene)
        self._positions, self._rotations = initial_poses(scene)
        world = self._batch.placed(self._positions, self._rotations)
        self._cosine = self._cosines(self._rotations)
        points = self._to_camera(world)
        self._settled = self._still_in_photo(scene, points)
        self._detail = _detail(self._batch, points, self.lens)
        hits = self._cast(points)
        self._tolerance = self._stage.tolerances(
            hits, self._owner(hits), _radii(self._batch), self._shown(scene, hits)
        )

    def frame(
        self,
        positions: ArrayLike | None = None,
        rotations: ArrayLike | None = None,
        vertices: Mapping[str, FloatArray] | None = None,
        *,
        shadows: bool = True,
    ) -> Frame:
        """The picture at these poses.

        positions: (N, 3) world, m, and rotations: (N, 4) R_world_body wxyz, in the order of
        `names`; None for the initial ones. vertices: by name, (V, 3) world, of soft objects.
        """
        where = self._positions if positions is None else np.asarray(positions, float)
        turned = self._rotations if rotations is None else np.asarray(rotations, float)
        self._check(where, turned)
        deformed = self._deformed(vertices or {})
        world = self._batch.placed(where, turned, deformed)
        points = self._to_camera(world)
        hits = self._visible(self._cast(points))
        backdrop = self._behind(points, world, shadows)
        canvas = backdrop.copy()
        flat = canvas.reshape(-1, 3)
        flat[hits.pixel] = self._colors(hits, turned, world if deformed else None)
        ids = np.full(len(flat), -1, np.int16)
        ids[hits.pixel] = self._owner(hits)
        depth = np.full(len(flat), np.inf, np.float32)
        depth[hits.pixel] = hits.depth
        shape = (self.lens.height, self.lens.width)
        ids, depth = ids.reshape(shape), depth.reshape(shape)
        partial = partial_pixels(self._batch, points, self.lens)
        blend_outlines(canvas, backdrop, ids, depth, self._stage.depth, partial)
        return Frame(canvas, ids, depth, Surface(hits, points, self._batch.faces, self.lens))

    # --- preparation -------------------------------------------------------------------------

    def _backdrop(self, scene: Scene) -> Picture:
        if scene.plate is not None:
            return np.ascontiguousarray(scene.plate)
        return draw_backdrop(scene.state, scene.support_meshes, self._camera, self.lens)

    def _still_in_photo(self, scene: Scene, points: FloatArray) -> Settled | None:
        if scene.photo is None or scene.photo.shape != self._plate.shape:
            return None
        masks = [scene.masks.get(name) for name in self.names]
        return Settled.of(scene.photo, self._plate, masks, self._batch, points, self.lens)

    def _shown(self, scene: Scene, hits: Hits) -> NDArray[np.bool_]:
        """Which hits of the initial pose lie in their object's mask in the photo."""
        shown = np.zeros(len(hits.pixel), bool)
        owner = self._owner(hits)
        for index, name in enumerate(self.names):
            mine = np.flatnonzero(owner == index)
            mask = scene.masks.get(name)
            if mask is not None and mask.size == self.lens.width * self.lens.height:
                shown[mine] = mask.ravel()[hits.pixel[mine]]
        return shown

    # --- one frame ---------------------------------------------------------------------------

    def _check(self, positions: FloatArray, rotations: FloatArray) -> None:
        count = len(self.names)
        if positions.shape != (count, 3) or rotations.shape != (count, 4):
            raise InputError(
                f"poses of {count} objects are ({count}, 3) and ({count}, 4), "
                f"not {positions.shape} and {rotations.shape}"
            )
        if not (np.isfinite(positions).all() and np.isfinite(rotations).all()):
            raise InputError("a pose is not finite, so it cannot be rendered")

    def _deformed(self, vertices: Mapping[str, FloatArray]) -> dict[int, FloatArray]:
        return {self.names.index(n): np.asarray(v, float) for n, v in vertices.items()}

    def _to_camera(self, world: FloatArray) -> FloatArray:
        return (world - np.array(self._camera.position)) @ self._matrix

    def _cast(self, points: FloatArray) -> Hits:
        return rasterise(points, self._batch.faces, self.lens, self._batch.one_sided)

    def _owner(self, hits: Hits) -> NDArray[np.int32]:
        return self._batch.face_owner[hits.face]

    def _visible(self, hits: Hits) -> Hits:
        hidden = self._stage.hidden(hits, self._owner(hits), self._tolerance)
        if not hidden.any():
            return hits
        keep = ~hidden
        return Hits(hits.pixel[keep], hits.face[keep], hits.weights[keep], hits.depth[keep])

    def _cosines(self, rotations: FloatArray) -> FloatArray:
        """(F, 3) cosine between each corner's normal and the light."""
        towards = np.einsum("nij,i->nj", matrices_of(rotations), LIGHT)
        return np.einsum("fcj,fj->fc", self._batch.normals, towards[self._batch.face_owner])

    def _shading(self, rotations: FloatArray, bent: FloatArray | None) -> FloatArray:
        """Brightness (F, 3): the change since the photo, or all of it on flat colours.

        bent: (V, 3) world vertices where something has deformed.
        """
        cosine = self._cosines(rotations)
        if bent is not None:
            cosine = corner_normals(bent, self._batch.faces, self._batch.welded) @ LIGHT
        change = relative(cosine, self._cosine)
        full = np.minimum(lambert(cosine, 0.35) * 1.12, 1.15)
        return np.where(self._textured[self._batch.face_owner, None], change, full)

    def _colors(self, hits: Hits, turned: FloatArray, bent: FloatArray | None) -> Picture:
        corners = self._batch.faces[hits.face]
        colors = np.empty((len(hits.pixel), 3), np.float32)
        uv = np.einsum("ki,kij->kj", hits.weights, self._batch.uv[corners])
        owner = self._owner(hits)
        for index, paint in enumerate(self._paints):
            mine = np.flatnonzero(owner == index)
            if len(mine):
                shrink = self._detail[index] * float(hits.depth[mine].mean())
                colors[mine] = paint.sample(uv[mine], shrink)
        if bent is None and self._untouched(turned):
            return (colors + 0.5).astype(np.uint8)
        bright = self._shading(turned, bent)
        shade = np.einsum("ki,ki->k", hits.weights, bright[hits.face])
        return np.clip(colors * shade[:, None] + 0.5, 0, 255).astype(np.uint8)

    def _untouched(self, rotations: FloatArray) -> bool:
        same = np.abs(rotations - self._rotations).max(initial=0) < _SAME
        return bool(same and self._textured.all())

    def _behind(self, points: FloatArray, world: FloatArray, shadows: bool) -> Picture:
        """The picture without objects, under the shadows that the photo does not show already."""
        backdrop, fresh = self._plate, np.ones(len(self.names))
        if self._settled is not None:
            settled = self._settled.weights(self._batch, points, self.lens)
            backdrop, fresh = self._settled.restore(backdrop, settled), 1 - settled
        if not shadows:
            return backdrop
        return apply_light(backdrop, transmitted(self._batch, world, self._stage.ground, fresh))


def apply_light(picture: Picture, change: NDArray[np.float32]) -> Picture:
    """A picture (H, W, 3) times a coarse map of light (h, w), only where that is not 1."""
    rows, columns = np.nonzero(np.abs(change - 1) > 1 / 300)
    if not len(rows):
        return picture
    height, width = picture.shape[:2]
    step = -(-height // change.shape[0])
    top, left = max(rows.min() - 1, 0), max(columns.min() - 1, 0)
    bottom, right = rows.max() + 2, columns.max() + 2
    patch = change[top:bottom, left:right]
    patch = cv2.resize(patch, None, fx=step, fy=step, interpolation=cv2.INTER_LINEAR)
    y, x = top * step, left * step
    patch = patch[: height - y, : width - x]
    result = picture.copy()
    part = result[y : y + patch.shape[0], x : x + patch.shape[1]]
    lit = part.astype(np.float32) * patch[..., None]
    part[:] = np.clip(lit + 0.5, 0, 255).astype(np.uint8)
    return result


def lens_of(camera: Camera) -> Lens:
    """The projection of a camera."""
    return Lens(*camera.size, camera.focal, *camera.principal)


def initial_poses(scene: Scene) -> tuple[FloatArray, FloatArray]:
    """Positions (N, 3) and rotations (N, 4) of the scene's objects as reconstructed."""
    places = []
    for item in scene.state.objects:
        if item.position is None:
            raise InputError(f"object '{item.name}' has no position, so it cannot be rendered")
        places.append(item.position)
    turned = [item.rotation for item in scene.state.objects]
    return np.array(places, float).reshape(-1, 3), np.array(turned, float).reshape(-1, 4)


def _meshes(scene: Scene, photographed: bool) -> list[Mesh]:
    found = []
    for index, item in enumerate(scene.state.objects):
        mesh = scene.meshes.get(item.name)
        if mesh is None:
            raise InputError(f"object '{item.name}' has no mesh, so it cannot be rendered")
        if mesh.texture is None and not photographed and mesh.color == _UNPAINTED:
            color = PALETTE[index % len(PALETTE)]
            mesh = Mesh(mesh.vertices, mesh.faces, None, None, color)
        found.append(mesh)
    return found


def _radii(batch: Batch) -> FloatArray:
    count = len(batch.first) - 1
    lengths = np.linalg.norm(batch.vertices, axis=1)
    radii = np.zeros(count)
    np.maximum.at(radii, batch.owner, lengths)
    return radii


def _detail(batch: Batch, points: FloatArray, lens: Lens) -> FloatArray:
    """(N,) texture pixels per screen pixel and metre of depth, for the choice of a level."""
    count = len(batch.first) - 1
    result = np.zeros(count)
    if not len(batch.faces):
        return result
    z = np.maximum(points[:, 2], 1e-6)
    pixels = lens.focal * points[:, :2] / z[:, None]
    ratio = np.sqrt(_area(batch.uv, batch.faces) / np.maximum(_area(pixels, batch.faces), 1e-9))
    away = z[batch.faces].mean(1)
    for index in range(count):
        # The faces that look at the camera squarely; slanted ones would ask for too much blur.
        mine = ratio[batch.face_owner == index] / away[batch.face_owner == index]
        if len(mine):
            result[index] = np.percentile(mine, 25)
    return result


def _area(places: FloatArray, faces: NDArray[np.int32]) -> FloatArray:
    a, b, c = (places[faces[:, i]] for i in range(3))
    first, second = b - a, c - a
    return np.abs(first[:, 0] * second[:, 1] - first[:, 1] * second[:, 0])


__all__ = ["Compositor", "Paint", "apply_light", "initial_poses", "lens_of"]
