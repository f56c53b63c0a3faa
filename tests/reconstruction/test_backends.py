"""Backends out of process, tested by round trips through generated result folders."""

import json
import math
import struct

import cv2
import numpy as np
import pytest
import trimesh
from hypothesis import given, settings
from hypothesis import strategies as st

from physagent_studio.benchmark.reconstruction.synthetic import scene
from physagent_studio.errors import BackendMissing, InputError
from physagent_studio.program.rotations import matrix_of
from physagent_studio.program.scene.camera import Camera
from physagent_studio.program.scene.state import (
    Click,
    Grounding,
    Meshed,
    SceneObject,
    SceneState,
    Stroke,
)
from physagent_studio.reconstruction import mesh_of, photo_hash
from physagent_studio.reconstruction.backends import backend
from physagent_studio.reconstruction.backends.frames import camera_from_sam3d, world_from_camera
from physagent_studio.reconstruction.backends.jobs import read_result, write_job
from physagent_studio.reconstruction.backends.mesh_files import mesh_from, read_mesh
from physagent_studio.reconstruction.backends.sam2 import Sam2Segmenter
from physagent_studio.reconstruction.backends.sam3d import import_bodies
from physagent_studio.reconstruction.shapes.silhouettes import in_world
from physagent_studio.records.case import Case

pytestmark = pytest.mark.usefixtures("unfilled")

numbers = st.floats(-1, 1)


def sam3d_from_camera(points, rotation, translation, scale):
    """The inverse of `camera_from_sam3d`: what its GLB holds for points in our camera frame."""
    w, x, y, z = np.asarray(rotation, float) / np.linalg.norm(np.asarray(rotation, float))
    turn = matrix_of((w, x, y, z)).T
    local = (points @ np.diag([-1.0, -1.0, 1.0]) - np.asarray(translation, float)) @ turn
    return (local / scale) @ np.array([[1.0, 0, 0], [0, 0, -1.0], [0, 1.0, 0]])


def camera_from_world(points, camera):
    """World points (N, 3) in the camera frame."""
    return (points - np.asarray(camera.position)) @ camera.matrix


@settings(max_examples=40, deadline=None)
@given(
    q=st.tuples(numbers, numbers, numbers, numbers).filter(lambda q: sum(v * v for v in q) > 0.01),
    t=st.tuples(numbers, numbers, numbers),
    s=st.floats(0.05, 5),
)
def test_sam3d_frames_are_inverse(q, t, s):
    points = np.array([[0.1, 0.2, 2.0], [-0.3, 0.1, 3.0], [0.5, -0.4, 1.0]])
    stored = sam3d_from_camera(points, q, t, s)
    assert camera_from_sam3d(stored, q, t, s) == pytest.approx(points, abs=1e-9)


def test_sam3d_axes_as_documented():
    # A quarter turn about +z, row vectors: (1, 0, 0) · R(q) is (0, −1, 0).
    q = (math.cos(math.pi / 4), 0, 0, math.sin(math.pi / 4))
    # GLB +x → local +x → turned (0, −1, 0): down in a y-up camera; down is +y in ours.
    assert camera_from_sam3d([[1, 0, 0]], q, (0, 0, 0), 1.0) == pytest.approx(
        np.array([[0, 1, 0]]), abs=1e-12
    )
    # Left (+x) and up (+y) of PyTorch3D are −x and −y of OpenCV; forward stays.
    assert camera_from_sam3d([[0, 0, 0]], (1, 0, 0, 0), (1, 2, 3), 1.0) == pytest.approx(
        np.array([[-1, -2, 3]])
    )
    # A y-up file's up is z in the local frame, which the identity leaves pointing forward.
    assert camera_from_sam3d([[0, 1, 0]], (1, 0, 0, 0), (0, 0, 0), 2.0) == pytest.approx(
        np.array([[0, 0, 2.0]])
    )


def _result(folder, kind, objects):
    (folder / "result").mkdir(parents=True, exist_ok=True)
    text = json.dumps({"version": 1, "kind": kind, "objects": objects})
    (folder / "result" / "result.json").write_text(text)


def _write_glb(path, vertices, faces):
    trimesh.Trimesh(vertices, faces, process=False).export(path)


def test_a_result_folder_gives_back_the_world(tmp_path):
    drawn = scene(4)
    rng = np.random.default_rng(0)
    entries, truth = [], {}
    for k, item in enumerate(drawn.objects):
        assert item.shape is not None
        mesh = mesh_of(item.shape)
        world = in_world(item, mesh)
        truth[item.name] = world
        q = rng.normal(size=4)
        q /= np.linalg.norm(q)
        t, s = rng.normal(size=3), float(rng.uniform(0.3, 2))
        # The model works at another scale: everything 0.4 times as far.
        camera_points = 0.4 * camera_from_world(world, drawn.camera)
        stored = sam3d_from_camera(camera_points, q, t, s)
        (tmp_path / "result").mkdir(exist_ok=True)
        _write_glb(tmp_path / "result" / f"{k}.glb", stored, mesh.faces)
        entries.append(
            {
                "name": item.name,
                "mesh": f"{k}.glb",
                "rotation": q.tolist(),
                "translation": t.tolist(),
                "scale": [s] * 3,
            }
        )
    _result(tmp_path, "sam3d", entries)
    bodies = import_bodies(tmp_path, drawn.camera)
    for item in drawn.objects:
        body = bodies[item.name]
        assert body.position == pytest.approx(item.position, abs=2e-3)
        found = body.mesh.vertices + np.array(body.position)
        low, high = truth[item.name].min(0), truth[item.name].max(0)
        # GLB holds float32: 1e-5 of a scene of a few metres.
        assert found.min(0) == pytest.approx(low, abs=1e-5)
        assert found.max(0) == pytest.approx(high, abs=1e-5)


def test_world_and_camera_are_inverse():
    camera = Camera.from_horizon((320, 240), 90, 1.3)
    points = np.array([[0.1, 2, 0.3], [1, 3, -0.2]])
    assert world_from_camera(camera_from_world(points, camera), camera) == pytest.approx(points)


def _case(drawn):
    name = drawn.objects[0].name
    rows, columns = np.nonzero(drawn.masks[name])
    click = Click(x=float(np.median(columns)), y=float(np.median(rows)))
    objects = ((name, Grounding(points=(click,))),)
    case = Case("t", drawn.image, photo_hash(drawn.image), objects, (), (), "It stays.")
    state = SceneState(
        objects=tuple(SceneObject(name=n, grounding=g) for n, g in objects), camera=drawn.camera
    )
    return name, case, state


def test_sam3d_writes_its_job_and_says_how_to_run_it(tmp_path):
    _, case, state = _case(scene(4))
    with pytest.raises(BackendMissing, match=r"sam3d_runner\.py"):
        backend("sam3d", tmp_path).reconstruct(case, state)
    job = json.loads((tmp_path / "job.json").read_text())
    assert job["kind"] == "sam3d"
    assert (tmp_path / job["objects"][0]["mask"]).is_file()
    assert np.array(job["intrinsics"]).shape == (3, 3)


def test_meshes_from_files_stand_in_the_scene(tmp_path):
    drawn = scene(4)
    name, case, state = _case(drawn)
    cone = trimesh.creation.cone(radius=0.5, height=1.0)
    cone.export(tmp_path / f"{name}.obj")
    made = backend("meshes", tmp_path).reconstruct(case, state)
    item = made.state.object(name)
    assert item is not None
    assert isinstance(item.shape, Meshed)
    gaps = [f.measured for f in made.findings if f.name == "contact"]
    assert gaps == pytest.approx([1e-5], abs=1e-6)
    assert made.meshes[name].texture is not None


def test_sam2_candidates_are_read(tmp_path):
    drawn = scene(4)
    name, case, _ = _case(drawn)
    segmenter = Sam2Segmenter(tmp_path)
    assert case.image is not None
    with pytest.raises(BackendMissing, match=r"sam2_runner\.py"):
        segmenter.segment(case.image, case.objects)
    (tmp_path / "result").mkdir()
    mask = drawn.masks[name]
    cv2.imwrite(str(tmp_path / "result" / "a.png"), mask.astype(np.uint8) * 255)
    cv2.imwrite(str(tmp_path / "result" / "b.png"), (~mask).astype(np.uint8) * 255)
    _result(tmp_path, "sam2", [{"name": name, "masks": ["b.png", "a.png"], "scores": [0.2, 0.9]}])
    best, other = segmenter.segment(case.image, case.objects)[name]
    assert best.score == pytest.approx(0.9)
    assert np.array_equal(best.mask, mask)
    assert np.array_equal(other.mask, ~mask)


def test_a_result_cannot_name_files_elsewhere(tmp_path):
    (tmp_path / "secret.glb").write_bytes(b"glTF")
    entry = {"name": "a", "mesh": "../secret.glb", "rotation": [1, 0, 0, 0]}
    _result(tmp_path, "sam3d", [entry | {"translation": [0, 0, 1], "scale": [1]}])
    with pytest.raises(InputError, match="is not in"):
        import_bodies(tmp_path, scene(4).camera)


@pytest.mark.parametrize("text", ["{", '{"version": 2, "kind": "sam3d", "objects": []}', "[NaN]"])
def test_a_damaged_result_is_told(tmp_path, text):
    (tmp_path / "result").mkdir()
    (tmp_path / "result" / "result.json").write_text(text)
    with pytest.raises(InputError, match="result"):
        read_result(tmp_path, "sam3d")


def test_a_job_holds_what_it_was_given(tmp_path):
    drawn = scene(4)
    grounding = Grounding(points=(Click(x=3, y=4),), box=(1.0, 2.0, 30.0, 40.0))
    write_job(tmp_path, "sam2", drawn.image, [("a", grounding)], {}, None)
    job = json.loads((tmp_path / "job.json").read_text())
    assert job["objects"] == [{"name": "a", "points": [[3.0, 4.0, 1]], "box": [1, 2, 30, 40]}]


def test_strokes_reach_sam2_as_points_and_its_masks_come_back(tmp_path):
    """A runner that fills the box of the points inside stands for the model."""
    drawn = scene(4)
    add = Stroke(radius=6, points=((40, 50), (60, 50), (80, 70)))
    erase = Stroke(radius=4, points=((100, 20),), effect="erase")
    cut = Stroke(tool="scissors", points=((200, 100), (260, 100), (230, 150)))
    beyond = Stroke(radius=4, points=((-20, -20),))
    grounding = Grounding(points=(Click(x=3, y=4),), strokes=(add, erase, cut, beyond))
    segmenter = Sam2Segmenter(tmp_path)
    with pytest.raises(BackendMissing):
        segmenter.segment(drawn.image, [("a", grounding)])
    (entry,) = json.loads((tmp_path / "job.json").read_text())["objects"]
    assert entry["points"][0] == [3, 4, 1]
    assert entry["points"][1:4] == [[40, 50, 1], [60, 50, 1], [80, 70, 1]]
    assert entry["points"][4] == [100, 20, 0]
    assert entry["points"][5][2] == 1
    assert len(entry["points"]) == 6
    inside = np.array([[x, y] for x, y, label in entry["points"] if label], int)
    mask = np.zeros(drawn.image.shape[:2], np.uint8)
    (x0, y0), (x1, y1) = inside.min(0), inside.max(0)
    mask[y0 : y1 + 1, x0 : x1 + 1] = 255
    (tmp_path / "result").mkdir()
    cv2.imwrite(str(tmp_path / "result" / "a.png"), mask)
    _result(tmp_path, "sam2", [{"name": "a", "masks": ["a.png"], "scores": [0.7]}])
    (found,) = segmenter.segment(drawn.image, [("a", grounding)])["a"]
    assert np.array_equal(found.mask, mask > 0)


def _huge_ply() -> bytes:
    head = b"ply\nformat ascii 1.0\nelement vertex 999999999\nproperty float x\nend_header\n"
    return head + b"0\n"


def _huge_glb() -> bytes:
    text = json.dumps({"asset": {"version": "2.0"}, "accessors": [{"count": 10**9}]}).encode()
    text += b" " * (-len(text) % 4)
    chunk = struct.pack("<II", len(text), 0x4E4F534A) + text
    return struct.pack("<4sII", b"glTF", 2, 12 + len(chunk)) + chunk


@pytest.mark.parametrize(
    ("name", "data", "words"),
    [
        ("a.glb", b"PK\x03\x04" + b"\0" * 90, "compressed"),
        ("a.ply", _huge_ply(), "at most"),
        ("a.glb", _huge_glb(), "at most"),
        ("a.glb", b"glTF" + b"\0" * 30, "damaged"),
        ("a.stl", b"\0" * 80 + struct.pack("<I", 50), "cut off"),
        ("a.obj", b"v 0 0 0\nv 1 0 0\n", "no faces"),
        ("a.obj", b"v 0 0 0\nv 1 0 0\nv 1 1 0\nf 1 2 99\n", "a corner that does not exist"),
        ("a.obj", b"v 0 0 0\nv 1 0 0\nv nan 1 0\nf 1 2 3\n", "not finite"),
        ("a.obj", b"v 0 0 0\nv 1 0 0\nv 1e9 1 0\nf 1 2 3\n", "farther than"),
        ("a.txt", b"hello", "no mesh file"),
    ],
)
def test_bad_meshes_are_refused(tmp_path, name, data, words):
    (tmp_path / name).write_bytes(data)
    with pytest.raises(InputError, match=words):
        read_mesh(tmp_path / name)


@pytest.mark.parametrize("kind", ["glb", "obj", "ply", "stl"])
def test_damaged_bytes_are_a_mesh_or_a_sentence(kind):
    made = trimesh.creation.icosphere(subdivisions=1).export(file_type=kind)
    assert isinstance(made, str | bytes)
    whole = made.encode() if isinstance(made, str) else made
    assert len(mesh_from(whole, f"ball.{kind}")[1]) == 80
    random = np.random.default_rng(7)
    for round_ in range(120):
        data = bytearray(whole)
        if round_ % 2:
            for _ in range(5):
                data[random.integers(len(data))] = random.integers(256)
        else:
            del data[random.integers(1, len(data)) :]
        try:
            vertices, faces = mesh_from(bytes(data), f"ball.{kind}")
        except InputError:
            continue
        assert np.isfinite(vertices).all()
        assert 0 <= faces.min() <= faces.max() < len(vertices)


def test_an_unknown_backend_lists_the_known_ones():
    with pytest.raises(InputError, match="embedded, sam3d, meshes"):
        backend("magic")
