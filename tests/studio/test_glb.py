"""The textured mesh: a valid binary glTF whose colours survive the viewer's film curve."""

from __future__ import annotations

import io
from dataclasses import replace

import numpy as np
import trimesh
from hypothesis import given
from hypothesis import strategies as st

from physagent_studio.program import Support
from physagent_studio.program.scene import state as shapes
from physagent_studio.records import Mesh, Shading
from physagent_studio.studio.scene.glb import before_film_curve, glb_of
from physagent_studio.studio.scene.primitives import edges_of, mesh_of_support


def _film_curve(srgb: np.ndarray, strength: float) -> np.ndarray:
    """What three.js shows of an emissive texture: sRGB in, sRGB out, 0 … 1."""
    c = srgb / 255.0
    light = np.where(c <= 0.04045, c / 12.92, ((c + 0.055) / 1.055) ** 2.4) * strength / 0.6
    into = np.array(
        [[0.59719, 0.35458, 0.04823], [0.07600, 0.90834, 0.01566], [0.02840, 0.13383, 0.83777]]
    )
    out = np.array(
        [
            [1.60475, -0.53108, -0.07367],
            [-0.10208, 1.10813, -0.00605],
            [-0.00327, -0.07276, 1.07602],
        ]
    )
    v = light @ into.T
    shown = np.clip(
        ((v * (v + 0.0245786) - 0.000090537) / (v * (0.983729 * v + 0.4329510) + 0.238081)) @ out.T,
        0,
        1,
    )
    return np.where(shown <= 0.0031308, shown * 12.92, 1.055 * shown ** (1 / 2.4) - 0.055)


@given(st.tuples(*[st.integers(20, 215)] * 3))
def test_colours_survive_the_film_curve(color: tuple[int, int, int]) -> None:
    # Bright and fully saturated colours lie outside what the curve can show at all.
    image = np.array([[np.clip(color, max(color) * 3 // 4, 255)]], np.uint8)
    packed, strength = before_film_curve(image)
    shown = _film_curve(packed.astype(float), strength) * 255
    assert np.abs(shown - image).max() <= 4


def test_trimesh_reads_what_we_write() -> None:
    picture = np.random.default_rng(3).integers(0, 255, (40, 60, 3), np.uint8)
    vertices = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]], float)
    faces = np.array([[0, 2, 1], [0, 1, 3], [1, 2, 3], [0, 3, 2]], np.int32)
    uv = np.array([[0, 0], [60, 0], [0, 40], [30, 20]], float)
    data = glb_of(Mesh(vertices, faces, uv, picture))
    scene = trimesh.load(io.BytesIO(data), file_type="glb")
    (mesh,) = scene.geometry.values()  # type: ignore[union-attr]
    assert len(mesh.faces) == 4
    # trimesh turns v over on loading; glTF itself has its origin at the top left, as we do.
    np.testing.assert_allclose(mesh.visual.uv[:, 0], uv[:, 0] / 60, atol=1e-6)
    plain = glb_of(Mesh(vertices, faces, color=(200, 10, 10)))
    assert plain[:4] == b"glTF"
    assert len(plain) == int.from_bytes(plain[8:12], "little")


def test_the_light_that_a_texture_is_without_is_sent_with_the_vertices() -> None:
    vertices = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]], float)
    faces = np.array([[0, 2, 1], [0, 1, 3], [1, 2, 3], [0, 3, 2]], np.int32)
    uv = np.array([[0, 0], [60, 0], [0, 40], [30, 20]], float)
    # Brighter the more it faces up, red less than blue.
    rows = tuple((0.0, 0.0, 0.0, up, *[0.0] * 12) for up in (0.1, 0.2, 0.3))
    mesh = Mesh(vertices, faces, uv, np.full((40, 60, 3), 90, np.uint8))
    lit = replace(mesh, shading=Shading(rows, (0.0, 0.0, 1.0)))
    plain, sent = (trimesh.load(io.BytesIO(glb_of(m)), file_type="glb") for m in (mesh, lit))
    (one,), (other,) = plain.geometry.values(), sent.geometry.values()  # type: ignore[union-attr]
    assert "color" not in one.visual.vertex_attributes
    colours = np.asarray(other.visual.vertex_attributes["color"], float)
    assert colours.shape[0] == 4
    assert colours[3, 2] > colours[3, 0] > colours[0, 0]


def test_a_ramp_has_the_edges_of_a_wedge() -> None:
    shape = shapes.Ramp(toe=(0, 0, 0), yaw=0.3, run=1, rise=0.3, width=0.5)
    mesh = mesh_of_support(Support(name="ramp", shape=shape))
    assert mesh is not None
    assert len(edges_of(mesh)) == 9
    assert mesh.vertices[:, 2].max() == 0.3
