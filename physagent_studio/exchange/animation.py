"""Exports a rollout as animated binary glTF 2.0: textured objects that move, supports, camera."""

import math
from dataclasses import replace
from pathlib import Path
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from physagent_studio.errors import InputError
from physagent_studio.exchange.files import written
from physagent_studio.exchange.gltf import INDICES, UNLIT, VERTICES, GltfWriter
from physagent_studio.program.rotations import quaternion_of
from physagent_studio.program.scene.camera import Camera
from physagent_studio.records.rollout import Rollout
from physagent_studio.records.scene import Mesh, Scene
from physagent_studio.rendering.lit import vertex_light

_Y_UP = [-math.sqrt(0.5), 0.0, 0.0, math.sqrt(0.5)]
"""Our z is up, glTF's y: the root turns by −90° about x (xyzw)."""
_MOST_SHAPES = 41
"""Key shapes of a deformable object; those between are blended."""


def write_glb(path: Path | str, scene: Scene, rollout: Rollout, fps: float) -> None:
    """Write the rollout as one .glb that three.js, Blender and others play.

    Objects are nodes with translation and rotation keys at every frame, deformable ones carry
    morph targets. Times are those of the played clip: frame number / fps.

    Raises:
        InputError: the rollout is of other objects, a mesh is missing, the path is unwritable.
    """
    names = tuple(item.name for item in scene.state.objects)
    if rollout.objects != names:
        raise InputError(
            f"the rollout is of {', '.join(rollout.objects) or 'nothing'}, "
            f"the scene has {', '.join(names) or 'nothing'}"
        )
    gltf = GltfWriter()
    times = gltf.add_array((np.arange(rollout.frames) / fps).astype(np.float32))
    deformed = dict(rollout.vertices)
    channels: list[dict[str, Any]] = []
    samplers: list[dict[str, Any]] = []
    children = []
    for index, name in enumerate(names):
        mesh = scene.meshes.get(name)
        if mesh is None:
            raise InputError(f"object '{name}' has no mesh, so it cannot be exported")
        if name in deformed:
            node, tracks = _deforming(gltf, name, mesh, deformed[name], fps)
        else:
            node, tracks = _rigid(gltf, name, mesh, rollout, index, times)
        children.append(node)
        for target, sampler in tracks:
            channels.append({"sampler": len(samplers), "target": {"node": node, "path": target}})
            samplers.append(sampler)
    for name, mesh in scene.support_meshes.items():
        children.append(gltf.add("nodes", {"name": name, "mesh": _mesh(gltf, name, mesh)}))
    if scene.state.camera is not None:
        children.append(_camera(gltf, scene.state.camera))
    root = gltf.add("nodes", {"name": "world", "rotation": _Y_UP, "children": children})
    gltf.add("scenes", {"nodes": [root]})
    gltf.document["scene"] = 0
    if channels:
        gltf.add("animations", {"name": "rollout", "channels": channels, "samplers": samplers})
    with written(Path(path)) as partial:
        partial.write_bytes(gltf.glb())


Tracks = list[tuple[str, dict[str, Any]]]


def _rigid(
    gltf: GltfWriter, name: str, mesh: Mesh, rollout: Rollout, index: int, times: int
) -> tuple[int, Tracks]:
    steps = rollout.frame_steps()
    places = rollout.positions[steps, index].astype(np.float32)
    # glTF writes quaternions xyzw, and viewers interpolate the shorter way between neighbours.
    turns = _continuous(rollout.rotations[steps, index])[:, [1, 2, 3, 0]].astype(np.float32)
    node = {
        "name": name,
        "mesh": _mesh(gltf, name, mesh),
        "translation": places[0].tolist(),
        "rotation": turns[0].tolist(),
    }
    tracks = [
        ("translation", {"input": times, "output": gltf.add_array(places)}),
        ("rotation", {"input": times, "output": gltf.add_array(turns)}),
    ]
    return gltf.add("nodes", node), tracks


def _continuous(rotations: NDArray[np.float64]) -> NDArray[np.float64]:
    """The same rotations (T, 4) with signs so that neighbours lie close together."""
    flips = np.sum(rotations[1:] * rotations[:-1], axis=1) < 0
    sign = np.where(np.cumsum(np.concatenate([[False], flips])) % 2 == 1, -1.0, 1.0)
    return rotations * sign[:, None]


def _deforming(
    gltf: GltfWriter, name: str, mesh: Mesh, vertices: NDArray[np.float64], fps: float
) -> tuple[int, Tracks]:
    """vertices: (T, V, 3) world. The first is the mesh, the others are morph targets."""
    keys = np.unique(np.linspace(0, len(vertices) - 1, _MOST_SHAPES).round().astype(int))
    first = vertices[0]
    base = replace(mesh, vertices=first)
    shapes = [(vertices[key] - first).astype(np.float32) for key in keys[1:]]
    index = _mesh(gltf, name, base, vertex_light(mesh))
    primitive = gltf.document["meshes"][index]["primitives"][0]
    primitive["targets"] = [{"POSITION": gltf.add_array(s, VERTICES)} for s in shapes]
    gltf.document["meshes"][index]["weights"] = [0.0] * len(shapes)
    node = gltf.add("nodes", {"name": name, "mesh": index})
    if not shapes:
        return node, []
    weights = np.concatenate([np.zeros((1, len(shapes))), np.eye(len(shapes))])
    times = gltf.add_array((keys / fps).astype(np.float32))
    output = gltf.add_array(weights.ravel().astype(np.float32))
    return node, [("weights", {"input": times, "output": output})]


def _mesh(gltf: GltfWriter, name: str, mesh: Mesh, light: NDArray[np.float64] | None = None) -> int:
    """light: (V, 3) the photo's on the mesh; where its texture is without it, as built if None."""
    attributes = {"POSITION": gltf.add_array(mesh.vertices.astype(np.float32), VERTICES)}
    textured = mesh.uv is not None and mesh.texture is not None
    if mesh.uv is not None and mesh.texture is not None:
        height, width = mesh.texture.shape[:2]
        uv = (mesh.uv / (width, height)).astype(np.float32)
        attributes["TEXCOORD_0"] = gltf.add_array(uv, VERTICES)
        light = vertex_light(mesh) if light is None else light
        if light is not None:
            # Colours of vertices multiply linear light and are at most 1: what brightens more is
            # in the texture.
            most = max(1.0, float(light.max(initial=0)))
            bright = np.clip(mesh.texture * most + 0.5, 0, 255).astype(np.uint8)
            mesh = replace(mesh, texture=bright) if most > 1 else mesh
            colours = ((light / most) ** 2.2).astype(np.float32)
            attributes["COLOR_0"] = gltf.add_array(np.minimum(colours, 1), VERTICES)
    indices = gltf.add_array(mesh.faces.astype(np.uint32).ravel(), INDICES)
    material = _photo(gltf, name, mesh) if textured else _plain(gltf, name, mesh.color)
    primitive = {"attributes": attributes, "indices": indices, "material": material}
    return gltf.add("meshes", {"name": name, "primitives": [primitive]})


def _photo(gltf: GltfWriter, name: str, mesh: Mesh) -> int:
    """The photo as the object's colour; it carries its own light, so it is not lit again."""
    assert mesh.texture is not None
    done, data = cv2.imencode(".png", np.ascontiguousarray(mesh.texture[..., ::-1]))
    if not done:
        raise InputError(f"the texture of '{name}' cannot be encoded as a PNG")
    view = gltf.add_bytes(data.tobytes())
    image = gltf.add("images", {"name": name, "bufferView": view, "mimeType": "image/png"})
    sampler = gltf.document.get("samplers") and 0
    if sampler is None:
        sampler = gltf.add("samplers", {"wrapS": 33071, "wrapT": 33071})
    texture = gltf.add("textures", {"source": image, "sampler": sampler})
    gltf.extension(UNLIT)
    return gltf.add(
        "materials",
        {
            "name": name,
            "pbrMetallicRoughness": {"baseColorTexture": {"index": texture}, "metallicFactor": 0},
            "extensions": {UNLIT: {}},
        },
    )


def _plain(gltf: GltfWriter, name: str, color: tuple[int, int, int]) -> int:
    linear = [round((part / 255) ** 2.2, 6) for part in color]
    surface = {"baseColorFactor": [*linear, 1.0], "metallicFactor": 0, "roughnessFactor": 0.9}
    return gltf.add(
        "materials", {"name": name, "pbrMetallicRoughness": surface, "doubleSided": True}
    )


def _camera(gltf: GltfWriter, camera: Camera) -> int:
    """The photo's camera; glTF's looks along −z with y up, ours along z with y down."""
    width, height = camera.size
    index = gltf.add(
        "cameras",
        {
            "type": "perspective",
            "perspective": {
                "yfov": 2 * math.atan(height / 2 / camera.focal),
                "aspectRatio": width / height,
                "znear": 0.01,
            },
        },
    )
    w, x, y, z = quaternion_of(camera.matrix @ np.diag([1.0, -1.0, -1.0]))
    pose = {"translation": list(camera.position), "rotation": [x, y, z, w]}
    return gltf.add("nodes", {"name": "camera", "camera": index, **pose})
