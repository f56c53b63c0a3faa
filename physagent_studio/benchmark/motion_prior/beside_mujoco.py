"""Our rasteriser beside MuJoCo's own renderer on the same ten textured things, with shadows.

MuJoCo draws through EGL, which has to be chosen before it is loaded: the comparison is a process of
its own that prints JSON. Where EGL is not to be had the rows say so.
"""

import json
import os
import subprocess
import sys
import time
from statistics import median
from typing import Any

import numpy as np
import trimesh
from numpy.typing import NDArray

from physagent_studio.benchmark.motion_prior.scenes import SIZE, scene, texture
from physagent_studio.benchmark.rows import Row, at_least, shown
from physagent_studio.program.rotations import matrix_of
from physagent_studio.program.scene.camera import Camera
from physagent_studio.program.scene.state import Floor, SceneObject, Sphere, Support
from physagent_studio.records.scene import Mesh
from physagent_studio.rendering import Compositor

COUNT, SUBDIVISIONS, RADIUS = 10, 4, 0.16
"""Things, each an icosphere of 5,120 triangles that is a little dented, and their radius, m."""
REPEATS = 9
LARGE = 5000
"""Pixels from which silhouettes are compared."""
LONGEST = 300
"""Seconds after which the comparison is given up."""


def beside_mujoco() -> list[Row]:
    """How much faster ours is, and how alike the silhouettes are."""
    command = [sys.executable, "-m", "physagent_studio.benchmark.motion_prior.beside_mujoco"]
    try:
        run = subprocess.run(
            command,
            env=os.environ | {"MUJOCO_GL": "egl"},
            capture_output=True,
            timeout=LONGEST,
            check=True,
        )
        found = json.loads(run.stdout.splitlines()[-1])
    except (subprocess.SubprocessError, OSError, ValueError, IndexError):
        return [shown("ours beside MuJoCo's renderer", "not measured: no EGL here")]
    return [
        shown("a frame of ten things, ours", found["ours"], "s"),
        shown("a frame of ten things, MuJoCo's EGL renderer", found["theirs"], "s"),
        at_least("ours is faster by", found["theirs"] / found["ours"], 2.0, "×"),
        at_least("IoU with its silhouettes above 5,000 px, least", found["iou"], 0.99),
    ]


def _things() -> tuple[Camera, list[SceneObject], list[Mesh]]:
    rng = np.random.default_rng(0)
    camera = Camera.from_horizon(SIZE, 60, 1.3)
    items, meshes = [], []
    body = trimesh.creation.icosphere(SUBDIVISIONS, RADIUS)
    ways = np.asarray(body.vertices) / RADIUS
    turn = np.arctan2(ways[:, 1], ways[:, 0]) / (2 * np.pi) + 0.5
    for number in range(COUNT):
        bumps = 1 + 0.06 * np.sin(ways @ rng.normal(0, 5, (3, 3))).mean(1)
        picture = texture(number)
        uv = np.stack([turn, (1 - ways[:, 2]) / 2], 1) * (len(picture) - 1) + 0.5
        faces = np.asarray(body.faces, np.int32)
        meshes.append(Mesh(RADIUS * ways * bumps[:, None], faces, uv, picture))
        x, y = 0.42 * (number % 5 - 2), 1.7 + 0.55 * (number // 5)
        place = (x, y, RADIUS * 1.06)
        items.append(SceneObject(name=f"t{number}", shape=Sphere(radius=RADIUS), position=place))
    return camera, items, meshes


def _ours(camera: Camera, items: list[SceneObject], meshes: list[Mesh]) -> Compositor:
    things = {item.name: (item, mesh) for item, mesh in zip(items, meshes, strict=True)}
    return Compositor(scene(things, camera, (Support(name="floor", shape=Floor()),), 150))


def _theirs(camera: Camera, items: list[SceneObject], meshes: list[Mesh]) -> tuple[Any, Any, Any]:
    """MuJoCo's model of the same, its data and a renderer with shadows."""
    from physagent_studio.simulation.mj import mj

    spec = mj.MjSpec()
    getattr(spec.visual, "global").offwidth, getattr(spec.visual, "global").offheight = SIZE
    world = spec.worldbody
    world.add_light(pos=[0.5, 0, 4], dir=[-0.1, 0.4, -1], castshadow=True)
    world.add_geom(type=mj.mjtGeom.mjGEOM_PLANE, size=[5, 5, 0.1])
    half = matrix_of(camera.rotation) @ np.diag([1.0, -1.0, -1.0])
    quaternion = np.zeros(4)
    mj.mju_mat2Quat(quaternion, half.ravel())
    fovy = np.degrees(2 * np.arctan(SIZE[1] / 2 / camera.focal))
    world.add_camera(name="eye", pos=camera.position, quat=quaternion, fovy=float(fovy))
    for item, mesh in zip(items, meshes, strict=True):
        assert mesh.uv is not None
        assert mesh.texture is not None
        side = len(mesh.texture)
        spec.add_texture(
            name=item.name,
            type=mj.mjtTexture.mjTEXTURE_2D,
            width=side,
            height=side,
            nchannel=3,
            data=mesh.texture.ravel().tolist(),
        )
        paint = spec.add_material(name=item.name)
        paint.textures[mj.mjtTextureRole.mjTEXROLE_RGB] = item.name
        spec.add_mesh(
            name=item.name,
            uservert=mesh.vertices.ravel().tolist(),
            userface=mesh.faces.ravel().tolist(),
            usertexcoord=(mesh.uv / side).ravel().tolist(),
            userfacetexcoord=mesh.faces.ravel().tolist(),
        )
        own = world.add_body(name=item.name, pos=item.position)
        own.add_geom(type=mj.mjtGeom.mjGEOM_MESH, meshname=item.name, material=item.name)
    model = spec.compile()
    data = mj.MjData(model)
    mj.mj_forward(model, data)
    return model, data, mj.Renderer(model, SIZE[1], SIZE[0])


def _compare() -> dict[str, float]:
    camera, items, meshes = _things()
    compositor = _ours(camera, items, meshes)
    model, data, renderer = _theirs(camera, items, meshes)
    places = np.array([item.position for item in items], float)
    turns = np.tile([1.0, 0, 0, 0], (COUNT, 1))
    seconds: dict[str, list[float]] = {"ours": [], "theirs": []}
    for number in range(REPEATS):
        # Everything has moved, so that nothing is taken from the photo.
        moved = places + np.array([0.0, 0.0, 0.002 * (number + 1)])
        started = time.perf_counter()
        compositor.frame(moved, turns)
        seconds["ours"].append(time.perf_counter() - started)
        started = time.perf_counter()
        renderer.update_scene(data, "eye")
        renderer.render()
        seconds["theirs"].append(time.perf_counter() - started)
    frame = compositor.frame(places, turns, as_built=True)
    renderer.enable_segmentation_rendering()
    renderer.update_scene(data, "eye")
    seen: NDArray[np.int32] = renderer.render()[..., 0]
    least = 1.0
    for index, item in enumerate(items):
        own, other = frame.ids == index, seen == model.body(item.name).geomadr[0]
        if np.count_nonzero(own) > LARGE:
            least = min(least, np.count_nonzero(own & other) / np.count_nonzero(own | other))
    middle = {name: median(values[1:]) for name, values in seconds.items()}
    return middle | {"iou": float(least)}


if __name__ == "__main__":
    print(json.dumps(_compare()))
