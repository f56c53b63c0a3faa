"""`PathTracer`: a compositor whose things and shadows are path traced by Mitsuba 3.

Things are put into the photo by differential rendering (Debevec, "Rendering Synthetic Objects into
Real Scenes", 1998): a stand-in for the ground is traced with and without them, and the plate is
multiplied by what that changes. Where nothing changes the plate is kept.
"""

import importlib
import math
from collections.abc import Mapping
from typing import Any

import cv2
import numpy as np
from numpy.typing import ArrayLike, NDArray

from physagent_studio.errors import BackendMissing, InputError
from physagent_studio.program.scene.state import Floor, Wall
from physagent_studio.records.scene import Scene
from physagent_studio.rendering.batch import corner_normals
from physagent_studio.rendering.compositor import Compositor
from physagent_studio.rendering.frame import Frame, Surface
from physagent_studio.rendering.light import linear_of, srgb_of
from physagent_studio.rendering.raster import FloatArray, between

SAMPLES = 16
MOST_SAMPLES = 4096
_BOUNCES, _ROUGH = 5, 0.1
_DARKEST, _BRIGHTEST, _WHITEST = 0.3, 3.0, 0.95
"""What a texture is multiplied by so that it looks as in the photo, and what it then reflects."""
_PARTS = 16
"""Parts of a texture, each way, between which the light that falls on it may differ."""
_FAR = 1000.0
"""Metres to the disk that is the sun, and half the side of floors and walls."""
_SMOOTH = 5
"""Pixels over which the noise of shadows is evened out, each way."""


class PathTracer(Compositor):
    """Renders a scene as a `Compositor` does, each thing and its shadow anew in every frame.

    The sun is the one that shadows in the photo tell of; sun and sky are as bright as makes level
    ground as bright as the photo has it, and every texture reflects what makes its thing, part by
    part, as bright as the photo shows it there. Surfaces are matt but for those that the photo has
    shining. On the processor; the same seed gives the same bits.
    """

    def __init__(self, scene: Scene, samples: int = SAMPLES, seed: int = 0) -> None:
        """samples: rays for each pixel, 1 … 4096, rounded up to 4, 16, 64 and so on.

        Raises:
            InputError: as a compositor does, or for another number of samples.
            BackendMissing: without Mitsuba.
        """
        if not 1 <= samples <= MOST_SAMPLES:
            raise InputError(f"{samples} samples a pixel cannot be traced (1 … {MOST_SAMPLES})")
        try:
            mi: Any = importlib.import_module("mitsuba")
        except ImportError as error:
            raise BackendMissing(
                "path tracing needs Mitsuba: pip install 'physagent-studio[pbr]'"
            ) from error
        super().__init__(scene)
        # What needs LLVM would end the process where the LLVM at hand does not suit.
        mi.set_variant("scalar_rgb")
        self._mi, self._seed, self._in_photo = mi, seed, frozenset(scene.masks)
        self._plate = _LINEAR[self._scenery.plate]
        ground = self._plate[np.isfinite(self.background_depth)]
        albedo = ground.mean(0) if len(ground) else np.full(3, 0.5)
        self._sensor = mi.load_dict(
            self._seen_from(4 ** max(1, math.ceil(math.log(samples, 4) - 1e-9)))
        )
        self._lights = {name: mi.load_dict(light) for name, light in self._sun_and_sky().items()}
        self._ground = self._receivers(scene, albedo)
        self._surfaces = [self._surface(index, np.ones(3)) for index in range(len(self.names))]
        self._bare = self._traced(self._lights | self._ground, _BOUNCES)
        if self._photographed:
            self._surfaces = [self._surface(i, much) for i, much in enumerate(self._brighter())]

    def frame(
        self,
        positions: ArrayLike | None = None,
        rotations: ArrayLike | None = None,
        vertices: Mapping[str, FloatArray] | None = None,
        *,
        shadows: bool = True,
        as_built: bool = False,
    ) -> Frame:
        """The picture at these poses, see `Compositor.frame`; things are always as built."""
        pose = self._placed(positions, rotations, vertices)
        hits = self._look(pose).hits
        faces = self._batch.faces
        kept = np.ones(len(faces), bool) if pose.torn is None else ~pose.torn
        lit, cover = self._lit(pose.world, kept)
        change = self._change(lit, cover) if shadows else np.ones_like(lit)
        behind = (1 - cover) * change
        mixed = np.maximum(lit - behind * self._bare, 0) + behind * self._plate
        clear = cover[..., 0] == 0
        mixed[clear] = (change * self._plate)[clear]
        ids, depth = self._seen(hits)
        surface = Surface(hits, pose.points, faces, self.lens)
        rgb = (255 * srgb_of(np.clip(mixed, 0, 1)) + 0.5).astype(np.uint8)
        return Frame(rgb, ids, depth, surface)

    def _lit(self, world: FloatArray, kept: NDArray[np.bool_]) -> tuple[FloatArray, FloatArray]:
        """(H, W, 3) linear light with things, and (H, W, 1) how much of each pixel they cover.

        Both are of the same rays, or outlines would have a noise of their own.
        """
        lit = self._traced(self._lights | self._ground | self._things(world, kept, False), _BOUNCES)
        # Only what shines is seen by rays that do not bounce.
        cover = self._traced(self._ground | self._things(world, kept, True), 1)
        return lit, cover[..., :1]

    def _brighter(self) -> list[FloatArray]:
        """By how much each texture is too dark to look as the photo shows it, (3,) or (h, w, 3).

        A texture cut from the photo as it is carries the photo's light. What falls on it here is
        divided out of it, place by place, so that it is lit once.
        """
        shown = super().frame()
        world = self._batch.placed(self._positions, self._rotations)
        lit, cover = self._lit(world, np.ones(len(self._batch.faces), bool))
        hits, whole = shown.surface.hits, cover[..., 0].ravel() == 1
        uv = between(hits, self._batch.uv, self._batch.faces)
        owner = shown.ids.ravel()[hits.pixel]
        found: list[FloatArray] = []
        for index, paint in enumerate(self._skin.paints):
            mine = (owner == index) & whole[hits.pixel]
            if not paint.levels or not mine.any():
                found.append(np.ones(3))
                continue
            pixel = hits.pixel[mine]
            wanted, given = _LINEAR[shown.rgb.reshape(-1, 3)[pixel]], lit.reshape(-1, 3)[pixel]
            cut = self._skin.shadings[index] is None and self.names[index] in self._in_photo
            size = paint.levels[0].shape[:2]
            much = _ratio(wanted, given, uv[mine], size) if cut else _mean_ratio(wanted, given)
            found.append(np.clip(much, _DARKEST, _BRIGHTEST))
        return found

    def _change(self, lit: FloatArray, cover: FloatArray) -> FloatArray:
        """(H, W, 3) how much of its light the ground keeps, continued beneath outlines."""
        clear = (cover == 0).astype(np.float64)
        ratio = lit / np.maximum(self._bare, 1e-4)
        size = (_SMOOTH, _SMOOTH)
        count = cv2.blur(clear, size)[..., None]
        total = np.asarray(cv2.blur(ratio * clear, size))
        return np.where(count > 0, total / np.maximum(count, 1e-9), 1.0)

    # --- what is traced ----------------------------------------------------------------------

    def _traced(self, parts: Mapping[str, Any], bounces: int) -> FloatArray:
        """(H, W, 3) linear light."""
        integrator = {"type": "path", "max_depth": bounces}
        scene = self._mi.load_dict({"type": "scene", "integrator": integrator, **parts})
        seen = self._mi.render(scene, sensor=self._sensor, seed=self._seed)
        return np.asarray(seen, np.float64)

    def _seen_from(self, samples: int) -> dict[str, Any]:
        """The scene's camera; Mitsuba's looks along z with x left and y up."""
        lens, pose = self.lens, np.eye(4)
        pose[:3, :3] = self._matrix * (-1, -1, 1)
        pose[:3, 3] = self._camera.position
        return {
            "type": "perspective",
            "fov_axis": "x",
            "fov": float(np.degrees(2 * np.arctan(lens.width / 2 / lens.focal))),
            "principal_point_offset_x": 0.5 - lens.cx / lens.width,
            "principal_point_offset_y": 0.5 - lens.cy / lens.height,
            "near_clip": 1e-3,
            "far_clip": 10 * _FAR,
            "to_world": self._mi.ScalarTransform4f(pose),
            # Its places within a pixel depend on nothing that happens to the rays.
            "sampler": {"type": "ldsampler", "sample_count": samples},
            "film": {
                "type": "hdrfilm",
                "width": lens.width,
                "height": lens.height,
                "pixel_format": "rgb",
                "component_format": "float32",
                "rfilter": {"type": "box"},
            },
        }

    def _sun_and_sky(self) -> dict[str, Any]:
        """Together they give level ground the light π, so that it shows its own colour."""
        lamp, share = self._scenery.sun.lamp, np.asarray(self._scenery.sun.strength, float)
        width = lamp.penumbra**2 / (1 + lamp.penumbra**2)
        bright = share / (width * max(float(lamp.direction[2]), 0.1))
        right, down, along = lamp.axes
        reach = _FAR * lamp.penumbra
        centre = self._positions.mean(0) if len(self._positions) else np.zeros(3)
        pose = _pose(right * reach, down * reach, along, centre + _FAR * lamp.direction)
        sun = {"type": "area", "radiance": _rgb(bright)}
        return {
            "sun": {"type": "disk", "to_world": self._mi.ScalarTransform4f(pose), "light": sun},
            "sky": {"type": "constant", "radiance": _rgb(1 - share)},
        }

    def _receivers(self, scene: Scene, albedo: FloatArray) -> dict[str, Any]:
        """Floors, walls that the sun shines on, and every other support, in the plate's colour."""
        surface = {"type": "diffuse", "reflectance": _rgb(albedo)}
        bsdf = self._mi.load_dict({"type": "twosided", "surface": surface})
        found: dict[str, Any] = {}
        for support in scene.state.supports:
            shape, name = support.shape, f"support_{len(found)}"
            if isinstance(shape, Floor):
                x, y, z = np.eye(3)
                point = z * shape.height
            elif isinstance(shape, Wall):
                z = np.array([math.cos(shape.yaw), math.sin(shape.yaw), 0.0])
                y, point = np.array([0.0, 0.0, 1.0]), np.array(shape.point)
                x = np.array([-z[1], z[0], 0.0])
                if z @ self._scenery.sun.lamp.direction <= 0:
                    continue
            elif support.name in scene.support_meshes:
                mesh = scene.support_meshes[support.name]
                corners = mesh.vertices[mesh.faces]
                found[name] = self._mesh(name, corners, None, None, {"bsdf": bsdf})
                continue
            else:
                continue
            pose = self._mi.ScalarTransform4f(_pose(x * _FAR, y * _FAR, z, point))
            plane = {"type": "rectangle", "to_world": pose, "bsdf": bsdf}
            found[name] = self._mi.load_dict(plane)
        return found

    def _surface(self, index: int, brighter: FloatArray) -> Any:
        """brighter: (3,) or (h, w, 3) what the colours are multiplied by."""
        paint, shading = self._skin.paints[index], self._skin.shadings[index]
        colour = _rgb(_LINEAR[np.array(paint.color, np.uint8)])
        if paint.levels:
            light = np.minimum(_LINEAR[paint.levels[0]] * brighter, _WHITEST)
            bitmap = self._mi.Bitmap(np.ascontiguousarray(light, np.float32))
            colour = {"type": "bitmap", "bitmap": bitmap, "raw": True, "wrap_mode": "clamp"}
        surface = {"type": "diffuse", "reflectance": colour}
        if shading is not None and shading.gloss is not None:
            surface = {"type": "roughplastic", "alpha": _ROUGH, "diffuse_reflectance": colour}
        return self._mi.load_dict({"type": "twosided", "surface": surface})

    def _things(self, world: FloatArray, kept: NDArray[np.bool_], shining: bool) -> dict[str, Any]:
        batch = self._batch
        normals = corner_normals(world, batch.faces, batch.welded)
        found = {}
        for index in range(len(self.names)):
            mine = np.flatnonzero(kept & (batch.face_owner == index))
            if not len(mine):
                continue
            paint, uv = self._skin.paints[index], None
            if paint.levels:
                height, width = paint.levels[0].shape[:2]
                uv = batch.uv[batch.faces[mine]] / (width, height)
            made = {"bsdf": self._surfaces[index]}
            if shining:
                made = {
                    "emitter": self._mi.load_dict({"type": "area", "radiance": _rgb(np.ones(3))})
                }
            name = f"thing_{index}"
            found[name] = self._mesh(name, world[batch.faces[mine]], normals[mine], uv, made)
        return found

    def _mesh(
        self,
        name: str,
        corners: FloatArray,
        normals: FloatArray | None,
        uv: FloatArray | None,
        made: Mapping[str, Any],
    ) -> Any:
        """corners, normals: (F, 3, 3) world, uv: (F, 3, 2) of each face's corners, 0 … 1."""
        properties = self._mi.Properties()
        for key, value in made.items():
            properties[key] = value
        mesh = self._mi.Mesh(
            name,
            vertex_count=3 * len(corners),
            face_count=len(corners),
            has_vertex_normals=normals is not None,
            has_vertex_texcoords=uv is not None,
            props=properties,
        )
        values = self._mi.traverse(mesh)
        values["faces"] = np.arange(3 * len(corners), dtype=np.uint32)
        told = {"vertex_positions": corners, "vertex_normals": normals, "vertex_texcoords": uv}
        for key, value in told.items():
            if value is not None:
                values[key] = np.ascontiguousarray(value, np.float32).ravel()
        values.update()
        return mesh


def _mean_ratio(wanted: FloatArray, given: FloatArray) -> FloatArray:
    """(3,) of the means of (K, 3)."""
    return wanted.mean(0) / np.maximum(given.mean(0), 1e-4)


def _ratio(
    wanted: FloatArray, given: FloatArray, uv: FloatArray, size: tuple[int, int]
) -> FloatArray:
    """(h, w, 3) the ratio of light (K, 3) around each place of a texture, smooth over its parts.

    uv: (K, 2) pixels. Where nothing is seen it becomes that of all.
    """
    cells = (uv / size[::-1] * _PARTS).astype(int).clip(0, _PARTS - 1)
    parts = []
    for light in (wanted, given):
        grid = np.zeros((_PARTS, _PARTS, 3))
        np.add.at(grid, (cells[:, 1], cells[:, 0]), light)
        # As if each part had a pixel of the mean.
        parts.append(cv2.GaussianBlur(grid, (0, 0), 1.0) + light.mean(0))
    ratio = parts[0] / np.maximum(parts[1], 1e-4)
    return np.asarray(cv2.resize(ratio, size[::-1], interpolation=cv2.INTER_LINEAR))


def _pose(x: FloatArray, y: FloatArray, z: FloatArray, place: FloatArray) -> FloatArray:
    pose = np.eye(4)
    pose[:3] = np.column_stack([x, y, z, place])
    return pose


def _rgb(values: FloatArray) -> dict[str, Any]:
    return {"type": "rgb", "value": [float(value) for value in values]}


_LINEAR = linear_of(np.arange(256) / 255)
