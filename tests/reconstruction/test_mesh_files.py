"""Mesh files: read within bounds, refused with a sentence."""

import json
import struct

import numpy as np
import pytest
import trimesh

from physagent_studio.errors import InputError
from physagent_studio.reconstruction.backends.mesh_files import textured_from


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
def test_bad_meshes_are_refused(name, data, words):
    with pytest.raises(InputError, match=words):
        textured_from(data, name)


@pytest.mark.parametrize("kind", ["glb", "obj", "ply", "stl"])
def test_damaged_bytes_are_a_mesh_or_a_sentence(kind):
    made = trimesh.creation.icosphere(subdivisions=1).export(file_type=kind)
    assert isinstance(made, str | bytes)
    whole = made.encode() if isinstance(made, str) else made
    assert len(textured_from(whole, f"ball.{kind}").faces) == 80
    random = np.random.default_rng(7)
    for round_ in range(120):
        data = bytearray(whole)
        if round_ % 2:
            for _ in range(5):
                data[random.integers(len(data))] = random.integers(256)
        else:
            del data[random.integers(1, len(data)) :]
        try:
            mesh = textured_from(bytes(data), f"ball.{kind}")
        except InputError:
            continue
        assert np.isfinite(mesh.vertices).all()
        assert 0 <= mesh.faces.min() <= mesh.faces.max() < len(mesh.vertices)
