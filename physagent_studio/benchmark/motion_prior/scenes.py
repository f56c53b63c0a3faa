"""Scenes whose flow is known in closed form, a plate or a ball that moves; and the demo event."""

import math
from collections.abc import Callable
from dataclasses import dataclass
from types import MappingProxyType

import cv2
import numpy as np
import trimesh
from numpy.typing import NDArray

from physagent_studio.arrays import FloatArray
from physagent_studio.assets import assets_dir
from physagent_studio.exchange import load_case
from physagent_studio.program import PhysicalProgram
from physagent_studio.program.rotations import matrix_of
from physagent_studio.program.scene.camera import Camera
from physagent_studio.program.scene.state import Box, SceneObject, SceneState, Sphere, Support
from physagent_studio.records import Rollout, Scene
from physagent_studio.records.scene import Mesh
from physagent_studio.simulation import simulate
from physagent_studio.workbench.first import first_program

SIZE = (832, 480)
PLATE = (1.6, 0.2, 1.0)
"""Metres; it stands upright before the camera."""
PLACE = (0.1, 3.0, 1.2)
CELLS = 24
"""Cells across the plate's mesh, so that a smooth bend is followed closely."""


def camera() -> Camera:
    """Level, 1.2 m up, 45° of view."""
    return Camera.from_horizon(SIZE, SIZE[1] / 2, 1.2)


def texture(seed: int, side: int = 256) -> NDArray[np.uint8]:
    """Smooth random colours with detail at all sizes, (side, side, 3)."""
    rng = np.random.default_rng(seed)
    picture = np.zeros((side, side, 3), np.float32)
    for cells in (4, 16, 64):
        part = rng.random((cells, cells, 3), np.float32)
        picture += cv2.resize(part, (side, side), interpolation=cv2.INTER_CUBIC)
    low, high = picture.min(), picture.max()
    return (255 * (picture - low) / (high - low)).astype(np.uint8)


def plate(seed: int = 0) -> Mesh:
    """An upright sheet with a fine grid, closed by its thickness; texture on its front."""
    width, depth, height = PLATE
    grid = np.linspace(-0.5, 0.5, CELLS + 1)
    x, z = np.meshgrid(grid * width, grid * height)
    front = np.stack([x.ravel(), np.full(x.size, -depth / 2), z.ravel()], 1)
    back = front * (1, -1, 1)
    index = np.arange(x.size).reshape(x.shape)
    a, b, c, d = (
        part.ravel() for part in (index[:-1, :-1], index[:-1, 1:], index[1:, 1:], index[1:, :-1])
    )
    faces = np.vstack([np.stack([a, b, c], 1), np.stack([a, c, d], 1)])
    both = np.vstack([faces, faces[:, ::-1] + len(front)])
    side = texture(seed)
    uv = (np.stack([x.ravel() / width, -z.ravel() / height], 1) + 0.5) * (len(side) - 1) + 0.5
    return Mesh(np.vstack([front, back]), both.astype(np.int32), np.vstack([uv, uv]), side)


def scene(
    items: dict[str, tuple[SceneObject, Mesh]],
    eye: Camera | None = None,
    supports: tuple[Support, ...] = (),
    grey: int = 128,
) -> Scene:
    """Of these objects alone, on these supports, before a flat backdrop."""
    objects = tuple(item for item, _ in items.values())
    backdrop = np.full((*SIZE[::-1], 3), grey, np.uint8)
    return Scene(
        state=SceneState(camera=eye or camera(), objects=objects, supports=supports),
        photo=backdrop,
        plate=backdrop,
        masks=MappingProxyType({}),
        meshes=MappingProxyType({name: mesh for name, (_, mesh) in items.items()}),
        support_meshes=MappingProxyType({}),
        candidates=MappingProxyType({}),
        findings=(),
        hash="bench",
    )


def plate_scene() -> Scene:
    """The plate alone."""
    item = SceneObject(name="plate", shape=Box(size=PLATE), position=PLACE)
    return scene({"plate": (item, plate())})


def pair_scene() -> Scene:
    """A ball before the plate, which hides part of it."""
    wide = SceneObject(name="plate", shape=Box(size=PLATE), position=PLACE)
    ball = SceneObject(name="ball", shape=Sphere(radius=0.25), position=(-0.2, 2.0, 1.2))
    body = trimesh.creation.icosphere(5, 0.25)
    mesh = Mesh(np.asarray(body.vertices, float), np.asarray(body.faces, np.int32))
    return scene({"plate": (wide, plate()), "ball": (ball, mesh)})


@dataclass(frozen=True, eq=False, slots=True)
class Motion:
    """Where the plate's points are before and after. move: body (N, 3) → world (N, 3)."""

    name: str
    position: tuple[float, float, float]
    rotation: tuple[float, float, float, float]
    bend: Callable[[FloatArray], FloatArray] | None = None

    def moved(self, body: FloatArray) -> FloatArray:
        """World places (N, 3) of points of the body (N, 3) after the motion."""
        bent = body if self.bend is None else self.bend(body)
        return bent @ matrix_of(self.rotation).T + np.asarray(self.position)


def sheared(body: FloatArray) -> FloatArray:
    """A soft body that leans and widens: linear within it, so that its truth is exact."""
    x, y, z = body.T
    return np.stack([1.03 * x + 0.04 * z, y + 0.05 * x, z - 0.02 * x], 1)


MOTIONS = (
    Motion("translation", (PLACE[0] + 0.037, PLACE[1], PLACE[2] - 0.021), (1, 0, 0, 0)),
    Motion("rotation", PLACE, (math.cos(0.02), 0.0, math.sin(0.02), 0.0)),
    Motion("zoom", (PLACE[0], PLACE[1] - 0.08, PLACE[2]), (1, 0, 0, 0)),
    Motion("turn out of the plane", PLACE, (math.cos(0.03), 0.0, 0.0, math.sin(0.03))),
    Motion("soft body", PLACE, (1, 0, 0, 0), sheared),
)


def seen_on_plate(pixels: FloatArray, where: FloatArray) -> tuple[FloatArray, NDArray[np.bool_]]:
    """Body points (N, 3) of the unturned plate's front at `where` (3,) that pixels (N, 2) see, and

    whether they see it (N,).
    """
    eye = camera()
    rays = eye.rays(pixels)
    origin = np.asarray(eye.position) - where
    along = (-PLATE[1] / 2 - origin[1]) / rays[:, 1]
    body = origin + rays * along[:, None]
    inside = (np.abs(body[:, 0]) < PLATE[0] / 2) & (np.abs(body[:, 2]) < PLATE[2] / 2)
    return body, inside & (along > 0)


def seen_on_ball(pixels: FloatArray, where: FloatArray, radius: float) -> NDArray[np.bool_]:
    """(N,) whether the rays through pixels (N, 2) meet a ball."""
    eye = camera()
    rays = eye.rays(pixels)
    rays /= np.linalg.norm(rays, axis=1, keepdims=True)
    off = np.asarray(eye.position) - where
    along = rays @ off
    return along**2 - off @ off + radius**2 > 0


def demo_run() -> tuple[Scene, Rollout, PhysicalProgram]:
    """Scene, rollout and program of the demo's first event."""
    program, scene = first_program(load_case(assets_dir() / "demo"))
    return scene, simulate(program, scene.meshes), program
