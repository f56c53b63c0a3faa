"""Animated GLB: valid by the specification's rules, the motion in it, read back by trimesh."""

from __future__ import annotations

import io
import json
import struct
from dataclasses import replace
from pathlib import Path
from types import MappingProxyType

import cv2
import numpy as np
import pytest
import trimesh

from physagent_studio.errors import InputError
from physagent_studio.exchange import write_glb
from physagent_studio.program.rotations import about_axis, matrix_of
from physagent_studio.records.scene import Mesh, Shading
from physagent_studio.rendering.compositor import initial_poses
from tests.rendering.scenes import FLOOR, ball, crate, rollout_of, scene_of, table

FRAMES = 5
SIZES = {5126: 4, 5125: 4, 5123: 2, 5121: 1}
WIDTHS = {"SCALAR": 1, "VEC2": 2, "VEC3": 3, "VEC4": 4}


@pytest.fixture
def scene():
    first, first_mesh = ball()
    second, second_mesh = crate()
    support, support_mesh = table()
    texture = np.random.default_rng(0).integers(0, 255, (12, 20, 3), np.uint8)
    uv = np.abs(first_mesh.vertices[:, :2]) * (40, 20)
    painted = Mesh(first_mesh.vertices, first_mesh.faces, uv, texture)
    meshes = {"ball": painted, "crate": second_mesh}
    return scene_of([first, second], meshes, [FLOOR, support], {"table": support_mesh})


def moved(scene):
    positions, rotations = initial_poses(scene)
    places = np.repeat(positions[None], FRAMES, 0)
    places[:, 0, 0] += np.linspace(0, 1, FRAMES)
    turns = np.repeat(rotations[None], FRAMES, 0)
    turns[:, 1] = [about_axis((0, 0, 1), 1.4 * t) for t in range(FRAMES)]
    turns[2, 1] *= -1
    return rollout_of(("ball", "crate"), places, turns)


def read(path: Path):
    """(document, function from accessor index to its array)."""
    data = path.read_bytes()
    magic, version, total = struct.unpack("<4sII", data[:12])
    assert (magic, version, total) == (b"glTF", 2, len(data))
    length, kind = struct.unpack("<II", data[12:20])
    assert kind == 0x4E4F534A
    assert length % 4 == 0
    document = json.loads(data[20 : 20 + length])
    size, kind = struct.unpack("<II", data[20 + length : 28 + length])
    assert kind == 0x004E4942
    binary = data[28 + length :]
    assert len(binary) == size

    def array(index: int) -> np.ndarray:
        accessor = document["accessors"][index]
        view = document["bufferViews"][accessor["bufferView"]]
        assert view["byteOffset"] % 4 == 0
        dtype = {5126: np.float32, 5125: np.uint32}[accessor["componentType"]]
        width = WIDTHS[accessor["type"]]
        wanted = accessor["count"] * width * SIZES[accessor["componentType"]]
        assert view["byteLength"] == wanted
        values = np.frombuffer(binary, dtype, accessor["count"] * width, view["byteOffset"])
        values = values.reshape(-1, width)
        assert np.allclose(values.min(0), accessor["min"])
        assert np.allclose(values.max(0), accessor["max"])
        return values

    return document, array, binary


def test_motion_is_that_of_the_rollout(scene, tmp_path: Path):
    rollout = moved(scene)
    write_glb(tmp_path / "a.glb", scene, rollout, 20)
    document, array, _ = read(tmp_path / "a.glb")
    (animation,) = document["animations"]
    nodes = [node["name"] for node in document["nodes"]]
    assert nodes[:2] == ["ball", "crate"]
    assert {"table", "camera", "world"} <= set(nodes)
    for channel in animation["channels"]:
        index = nodes.index(document["nodes"][channel["target"]["node"]]["name"])
        sampler = animation["samplers"][channel["sampler"]]
        assert np.allclose(array(sampler["input"])[:, 0], np.arange(FRAMES) / 20)
        values = array(sampler["output"])
        if channel["target"]["path"] == "translation":
            assert np.allclose(values, rollout.positions[:, index], atol=1e-6)
            continue
        for value, truth in zip(values, rollout.rotations[:, index], strict=True):
            x, y, z, w = (float(part) for part in value)
            assert np.allclose(matrix_of((w, x, y, z)), matrix_of(truth), atol=1e-6)
        assert (np.sum(values[1:] * values[:-1], axis=1) > 0).all()


def test_texture_and_texture_coordinates(scene, tmp_path: Path):
    write_glb(tmp_path / "a.glb", scene, moved(scene), 20)
    document, array, binary = read(tmp_path / "a.glb")
    (image,) = document["images"]
    view = document["bufferViews"][image["bufferView"]]
    data = binary[view["byteOffset"] : view["byteOffset"] + view["byteLength"]]
    picture = cv2.imdecode(np.frombuffer(data, np.uint8), cv2.IMREAD_COLOR)
    assert picture is not None
    mesh = scene.meshes["ball"]
    assert np.array_equal(picture[..., ::-1], mesh.texture)
    uv = array(document["meshes"][0]["primitives"][0]["attributes"]["TEXCOORD_0"])
    assert np.allclose(uv * (20, 12), mesh.uv, atol=1e-4)
    assert document["extensionsUsed"] == ["KHR_materials_unlit"]


def test_the_light_of_the_photo_is_in_colours_of_at_most_one(scene, tmp_path: Path):
    # The light of the photo is 1.4 everywhere, and its texture goes up to 170.
    terms = ((float(np.log(1.4)),) + (0.0,) * 15,) * 3
    dark = (scene.meshes["ball"].texture * (2 / 3)).astype(np.uint8)
    lit = replace(scene.meshes["ball"], texture=dark, shading=Shading(terms, (0.0, -1.0, 0.0)))
    scene = replace(scene, meshes=MappingProxyType(dict(scene.meshes) | {"ball": lit}))
    write_glb(tmp_path / "a.glb", scene, moved(scene), 20)
    document, array, binary = read(tmp_path / "a.glb")
    colours = array(document["meshes"][0]["primitives"][0]["attributes"]["COLOR_0"])
    assert colours.max() <= 1
    view = document["bufferViews"][document["images"][0]["bufferView"]]
    data = binary[view["byteOffset"] : view["byteOffset"] + view["byteLength"]]
    picture = cv2.imdecode(np.frombuffer(data, np.uint8), cv2.IMREAD_COLOR)
    assert picture is not None
    shown = picture[..., ::-1] * colours.mean() ** (1 / 2.2)
    assert np.abs(shown - 1.4 * dark).max() < 1


def test_another_reader_finds_everything_in_its_place(scene, tmp_path: Path):
    write_glb(tmp_path / "a.glb", scene, moved(scene), 20)
    loaded = trimesh.load_scene(
        io.BytesIO((tmp_path / "a.glb").read_bytes()), file_type="glb", process=False
    )
    assert set(loaded.geometry) == {"ball", "crate", "table"}
    low, high = loaded.geometry["crate"].bounds
    assert np.allclose(high - low, [0.3, 0.4, 0.4], atol=1e-6)
    # y is up there: (x, y, z) of ours is (x, z, −y).
    pose = loaded.graph.get("ball")[0]
    assert np.allclose(pose[:3, 3], [0.0, 0.25, -3.0], atol=1e-6)


def test_deformed_object_carries_shapes(scene, tmp_path: Path):
    rollout = moved(scene)
    mesh = scene.meshes["ball"]
    squash = np.linspace(1, 0.6, FRAMES)
    shapes = np.stack([mesh.vertices * (1, 1, s) + (0, 3, 0.25 * s) for s in squash])
    soft = rollout_of(
        rollout.objects, rollout.positions, rollout.rotations, vertices=(("ball", shapes),)
    )
    write_glb(tmp_path / "a.glb", scene, soft, 20)
    document, array, _ = read(tmp_path / "a.glb")
    primitive = document["meshes"][0]["primitives"][0]
    base = array(primitive["attributes"]["POSITION"])
    assert np.allclose(base, shapes[0], atol=1e-6)
    assert len(primitive["targets"]) == FRAMES - 1
    last = base + array(primitive["targets"][-1]["POSITION"])
    assert np.allclose(last, shapes[-1], atol=1e-6)
    (track,) = [
        c for c in document["animations"][0]["channels"] if c["target"]["path"] == "weights"
    ]
    weights = array(document["animations"][0]["samplers"][track["sampler"]]["output"])
    assert weights.reshape(FRAMES, FRAMES - 1)[-1].tolist() == [0, 0, 0, 1]


def test_rollout_of_something_else_is_refused(scene, tmp_path: Path):
    rollout = moved(scene)
    other = rollout_of(("a", "b"), rollout.positions, rollout.rotations)
    with pytest.raises(InputError, match="a, b"):
        write_glb(tmp_path / "a.glb", scene, other, 20)
    assert not list(tmp_path.iterdir())
