"""Covered shares of pixels against closed forms."""

from __future__ import annotations

import numpy as np
import trimesh

from physagent_studio.rendering.batch import Batch
from physagent_studio.rendering.coverage import partial_pixels
from physagent_studio.rendering.raster import Lens, rasterise
from tests.rendering.scenes import mesh_of

LENS = Lens(80, 60, 100.0, 40, 30)


def shares(shape: trimesh.Trimesh, lens: Lens = LENS):
    """(H, W) covered share, whole pixels from the hard picture, and the hard picture."""
    batch = Batch.of([mesh_of(shape)])
    hits = rasterise(batch.vertices, batch.faces, lens, batch.one_sided)
    hard = np.zeros(lens.width * lens.height)
    hard[hits.pixel] = 1
    soft = hard.copy()
    (partial,) = partial_pixels(batch, batch.vertices, lens)
    soft[partial.pixel] = partial.share
    return soft.reshape(lens.height, lens.width), hard.reshape(lens.height, lens.width)


def test_ball_covers_the_area_of_its_projection():
    shape = trimesh.creation.icosphere(4, 0.5)
    shape.apply_translation([0, 0, 3.0])
    soft, hard = shares(shape)
    # The outline of a centred ball is a circle of radius f·r / √(z² − r²).
    radius = 100 * 0.5 / np.sqrt(3.0**2 - 0.25)
    assert abs(soft.sum() / (np.pi * radius**2) - 1) < 0.003
    assert np.abs(soft - hard).max() < 0.6


def test_slanted_edge_is_exact():
    shape = trimesh.creation.box([0.4, 0.4, 0.01])
    shape.apply_transform(trimesh.transformations.rotation_matrix(0.3, [0, 0, 1]))
    shape.apply_translation([0.013, 0.007, 2.0])
    soft, _ = shares(shape)
    front = 100 * 0.4 / (2.0 - 0.005)
    assert abs(soft.sum() - front**2) < 1e-3


def test_hole_of_a_ring_stays_open():
    shape = trimesh.creation.torus(0.6, 0.15, major_sections=64, minor_sections=24)
    shape.apply_translation([0, 0, 3.5])
    soft, hard = shares(shape)
    assert soft[30, 40] == 0
    assert abs(soft.sum() / hard.sum() - 1) < 0.02
    assert ((soft > 0.02) & (soft < 0.98)).sum() > 40


def test_partly_out_of_the_picture():
    shape = trimesh.creation.icosphere(3, 0.8)
    shape.apply_translation([-1.2, -0.8, 3.0])
    soft, hard = shares(shape)
    assert hard.sum() > 100
    assert np.abs(soft - hard).max() < 0.7
    assert abs(soft.sum() / hard.sum() - 1) < 0.02


def test_behind_the_camera_there_is_none():
    shape = trimesh.creation.icosphere(3, 1.0)
    batch = Batch.of([mesh_of(shape)])
    (partial,) = partial_pixels(batch, batch.vertices, LENS)
    assert len(partial.pixel) == 0


def test_meshes_are_told_open_from_closed():
    closed = mesh_of(trimesh.creation.box([1, 1, 1]))
    opened = trimesh.creation.box([1, 1, 1])
    opened.update_faces(np.arange(10))
    batch = Batch.of([closed, mesh_of(opened)])
    assert batch.one_sided[:12].all()
    assert not batch.one_sided[12:].any()
