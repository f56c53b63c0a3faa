"""`Compositor`: the scene prepared once, then one picture per set of poses."""

from collections.abc import Callable, Iterator, Mapping
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import ArrayLike, NDArray

from physagent_studio.errors import InputError
from physagent_studio.program.scene.bodies import Granular
from physagent_studio.program.scene.camera import Camera
from physagent_studio.records.scene import Mesh, Scene
from physagent_studio.rendering import heaps
from physagent_studio.rendering.backdrop import PALETTE, draw_backdrop
from physagent_studio.rendering.batch import Batch
from physagent_studio.rendering.blend import blend_hidden, blend_outlines
from physagent_studio.rendering.coverage import Partial, partial_pixels
from physagent_studio.rendering.crumbs import Crumbs
from physagent_studio.rendering.frame import Frame, Picture, Surface
from physagent_studio.rendering.mirror import Mirror
from physagent_studio.rendering.raster import FloatArray, Hits, Lens, rasterise
from physagent_studio.rendering.scenery import Scenery
from physagent_studio.rendering.skin import Skin
from physagent_studio.rendering.stage import Stage, planes_seen


@dataclass(frozen=True, eq=False, slots=True)
class _Placed:
    """Everything at some poses, not yet looked at.

    world, points: (V, 3) in the world and from the camera, m. turned: (N, 4) wxyz. soft: whether
    anything is deformed. torn: (F,) what has come apart. loose: (F,) crumbs of heaps that have run.
    """

    world: FloatArray
    points: FloatArray
    turned: FloatArray
    soft: bool
    torn: NDArray[np.bool_] | None
    loose: NDArray[np.bool_]


@dataclass(frozen=True, eq=False, slots=True)
class _Looked:
    """What the pixels see of it, not yet drawn.

    cast: what they would see without supports. hidden: (K,) what of it those hide. hits: the rest.
    """

    cast: Hits
    hidden: NDArray[np.bool_]
    hits: Hits


_UNPAINTED = Mesh(np.zeros((0, 3)), np.zeros((0, 3), np.int32)).color


_MANY = 4
"""Things that have left their place from which their shadows are worth a thread: of three a frame
takes as long either way, of ten 31 ms in one thread and 24 in two."""


@contextmanager
def _alongside(work: Callable[[], Picture], apart: bool) -> Iterator[Callable[[], Picture]]:
    """A call that gives what `work` does, which has begun in a thread of its own if `apart`.

    NumPy and OpenCV let go of the interpreter, so that two threads share two cores.
    """
    if not apart:
        yield work
        return
    with ThreadPoolExecutor(1) as aside:
        yield aside.submit(work).result


class Compositor:
    """Renders a scene: the plate, the objects in their photo textures, their shadows.

    The photo already carries light and shadow of the initial pose, so light is applied as the
    change since then, shadows as objects leave their place, and frame 0 looks like the photo.
    Without a photo the backdrop is drawn, light and shadow are applied in full. Nothing in it
    changes after it is made.
    """

    def __init__(self, scene: Scene, *, lit: bool = True) -> None:
        """Prepare a scene whose state is complete.

        lit: False where only what is seen where matters, not its light.

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
        self._crumbs = {
            index: Crumbs.of(meshes[index])
            for index, item in enumerate(scene.state.objects)
            if isinstance(item.body, Granular)
        }
        for index, crumbs in self._crumbs.items():
            meshes[index] = crumbs.split(meshes[index])
        self._batch = _opened(Batch.of(meshes), list(self._crumbs))
        self._stage = Stage.of(scene.state, scene.support_meshes, camera, self.lens)
        self._state = scene.state
        self._positions, self._rotations = initial_poses(scene)
        world = self._batch.placed(self._positions, self._rotations)
        points = self._to_camera(world)
        plate, ground = self._backdrop(scene), self._stage.ground
        if self._photographed:
            self._stage = self._stage.as_seen(plate)
        self._scenery = Scenery.of(scene, plate, self._batch, world, points, ground, self.lens, lit)
        light = self._scenery.sun.lamp.direction
        self._skin = Skin.of(self._batch, meshes, light, self._rotations, points, self.lens)
        self._mirror = Mirror.of(scene, self._skin, ground, world) if lit else None
        hits = self._cast(points)
        self._tolerance = self._stage.tolerances(
            hits, self._owner(hits), self._batch.radii, self._shown(scene, hits)
        )

    def frame(
        self,
        positions: ArrayLike | None = None,
        rotations: ArrayLike | None = None,
        vertices: Mapping[str, FloatArray] | None = None,
        *,
        shadows: bool = True,
        as_built: bool = False,
    ) -> Frame:
        """The picture at these poses.

        positions: (N, 3) world, m, and rotations: (N, 4) R_world_body wxyz, in the order of
        `names`; None for the initial ones. vertices: by name, (V, 3) world, of soft objects.
        as_built: draw every object from its mesh, even where it has not moved and the photo
        itself is the better picture; this is how a reconstruction shows its faults.
        """
        pose = self._placed(positions, rotations, vertices)
        standing, lingering = self._scenery.standing(pose.points)
        if as_built:
            standing = lingering = np.zeros(len(self.names))

        def behind() -> Picture:
            return self._scenery.behind(pose.world, standing, lingering, shadows)

        with _alongside(behind, int(np.count_nonzero(standing < 1)) >= _MANY) as shaded:
            look = self._look(pose)
            colors = self._skin.colors(look.hits, pose.turned, pose.world if pose.soft else None)
            colors = self._as_sand(pose, look, colors)
            partial = partial_pixels(self._batch, pose.points, self.lens, pose.torn)
            backdrop = shaded()
        if self._mirror is not None and shadows:
            each = 1 - standing
            backdrop = self._mirror.drawn(backdrop, pose.world, pose.turned, pose.soft, each)
        frame = self._composed(pose, look, backdrop, colors, partial, standing)
        if look.hidden.any():
            hidden = look.cast.pixel[look.hidden]
            owner = self._owner(look.cast)[look.hidden]
            blend_hidden(frame.rgb, backdrop, frame.ids, hidden, owner, self._stage.share)
        return frame

    def geometry(
        self,
        positions: ArrayLike | None = None,
        rotations: ArrayLike | None = None,
        vertices: Mapping[str, FloatArray] | None = None,
    ) -> Frame:
        """What a frame at these poses says but for its picture, which is black: enough for flow."""
        pose = self._placed(positions, rotations, vertices)
        hits = self._look(pose).hits
        ids, depth = self._seen(hits)
        surface = Surface(hits, pose.points, self._batch.faces, self.lens)
        return Frame(np.zeros((*ids.shape, 3), np.uint8), ids, depth, surface)

    @property
    def background_depth(self) -> NDArray[np.float32]:
        """(H, W) depth along the optical axis of supports, ground and walls, m; inf for none."""
        stage = self._stage
        depth = np.minimum(stage.depth, planes_seen(self._state, stage.origin, stage.rays)[0])
        return depth.astype(np.float32).reshape(self.lens.height, self.lens.width)

    # --- preparation -------------------------------------------------------------------------

    def _backdrop(self, scene: Scene) -> Picture:
        if scene.plate is not None:
            return np.ascontiguousarray(scene.plate)
        return draw_backdrop(scene.state, scene.support_meshes, self._camera, self.lens)

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

    def _placed(
        self,
        positions: ArrayLike | None,
        rotations: ArrayLike | None,
        vertices: Mapping[str, FloatArray] | None,
    ) -> _Placed:
        where = self._positions if positions is None else np.asarray(positions, float)
        turned = self._rotations if rotations is None else np.asarray(rotations, float)
        self._check(where, turned)
        deformed = self._deformed(vertices or {})
        world = self._batch.placed(where, turned, deformed)
        points = self._to_camera(world)
        torn = self._batch.torn(world) if deformed else None
        loose = self._loose(vertices or {})
        return _Placed(world, points, turned, bool(deformed), torn, loose)

    def _look(self, pose: _Placed) -> _Looked:
        cast = self._cast(pose.points, pose.torn)
        for mine, running in self._heaps(cast, pose.loose):
            cast = heaps.closed(cast, mine, running, self.lens)
        hidden = self._stage.hidden(cast, self._owner(cast), self._tolerance)
        return _Looked(cast, hidden, _chosen(cast, ~hidden))

    def _seen(self, hits: Hits) -> tuple[NDArray[np.int16], NDArray[np.float32]]:
        """(H, W) ids, −1 for none, and depth, m."""
        shape = (self.lens.height, self.lens.width)
        ids = np.full(shape, -1, np.int16)
        ids.ravel()[hits.pixel] = self._owner(hits)
        depth = np.full(shape, np.inf, np.float32)
        depth.ravel()[hits.pixel] = hits.depth
        return ids, depth

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
        deformed = {}
        for name, given in vertices.items():
            if name not in self.names:
                raise InputError(f"there is no object '{name}' (known: {', '.join(self.names)})")
            index, places = self.names.index(name), np.asarray(given, float)
            crumbs = self._crumbs.get(index)
            count = int(self._batch.first[index + 1] - self._batch.first[index])
            count = count if crumbs is None else crumbs.count
            if places.shape != (count, 3) or not np.isfinite(places).all():
                raise InputError(
                    f"object '{name}' has {count} vertices, so ({count}, 3) finite places are "
                    f"needed, not {places.shape}"
                )
            deformed[index] = places if crumbs is None else crumbs.placed(places)
        return deformed

    def _loose(self, vertices: Mapping[str, FloatArray]) -> NDArray[np.bool_]:
        """(F,) the crumbs of heaps that have come loose."""
        loose = np.zeros(len(self._batch.faces), bool)
        for index, crumbs in self._crumbs.items():
            if self.names[index] in vertices:
                own = self._batch.face_owner == index
                loose[own] = crumbs.loose(np.asarray(vertices[self.names[index]], float))
        return loose

    def _heaps(
        self, hits: Hits, loose: NDArray[np.bool_]
    ) -> Iterator[tuple[NDArray[np.bool_], NDArray[np.bool_]]]:
        """Of each heap that has run, (K,) the hits of it and those of its loose crumbs."""
        for index in self._crumbs if loose.any() else ():
            mine = self._owner(hits) == index
            running = mine & loose[hits.face]
            if running.any():
                yield mine, running

    def _as_sand(
        self, pose: _Placed, look: _Looked, colors: NDArray[np.float32]
    ) -> NDArray[np.float32]:
        for mine, running in self._heaps(look.hits, pose.loose):
            heap = heaps.heap_of(look.hits, mine, running, self.lens)
            grain = self._skin.grain(look.hits)
            colors = heaps.as_sand(heap, look.hits, colors, grain, self.lens)
        return colors

    def _to_camera(self, world: FloatArray) -> FloatArray:
        return (world - np.array(self._camera.position)) @ self._matrix

    def _cast(self, points: FloatArray, torn: NDArray[np.bool_] | None = None) -> Hits:
        batch = self._batch
        if torn is None or not torn.any():
            return rasterise(points, batch.faces, self.lens, batch.one_sided)
        # What has come apart is open, and its insides are seen.
        opened = np.zeros(len(self.names), bool)
        opened[batch.face_owner[torn]] = True
        keep = np.flatnonzero(~torn)
        closed = batch.one_sided[keep] & ~opened[batch.face_owner[keep]]
        hits = rasterise(points, batch.faces[keep], self.lens, closed)
        return Hits(hits.pixel, keep[hits.face].astype(np.int32), hits.weights, hits.depth)

    def _owner(self, hits: Hits) -> NDArray[np.int32]:
        return self._batch.face_owner[hits.face]

    def _composed(
        self,
        pose: _Placed,
        look: _Looked,
        backdrop: Picture,
        colors: NDArray[np.float32],
        partial: list[Partial],
        standing: FloatArray,
    ) -> Frame:
        """Objects over the backdrop, with smooth outlines."""
        hits = look.hits
        settled = self._scenery.settled if standing.any() else None
        if settled is not None:
            colors = settled.keep(colors, hits.pixel, self._owner(hits), standing)
        canvas = backdrop.copy()
        canvas.reshape(-1, 3)[hits.pixel] = (colors + np.float32(0.5)).astype(np.uint8)
        ids, depth = self._seen(hits)

        def photographed(pixel: NDArray[np.int64], index: NDArray[np.int32]) -> NDArray[np.float32]:
            if settled is None:
                return np.zeros(len(pixel), np.float32)
            return settled.shares(pixel, index, standing)

        blend_outlines(canvas, backdrop, ids, depth, self._stage.depth, partial, photographed)
        return Frame(canvas, ids, depth, Surface(hits, pose.points, self._batch.faces, self.lens))


def _chosen(hits: Hits, keep: NDArray[np.bool_]) -> Hits:
    if keep.all():
        return hits
    return Hits(hits.pixel[keep], hits.face[keep], hits.weights[keep], hits.depth[keep])


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


def _opened(batch: Batch, indices: list[int]) -> Batch:
    """A batch in which the faces of these objects are seen from both sides."""
    return replace(batch, one_sided=batch.one_sided & ~np.isin(batch.face_owner, indices))
