"""The rasteriser against closed forms, trimesh and a brute-force ray caster."""

from __future__ import annotations

import numpy as np
import trimesh

from physagent_studio.rendering.batch import corner_normals
from physagent_studio.rendering.raster import Lens, rasterise

LENS = Lens(96, 64, 80.0, 47.3, 31.6)


def rays(lens: Lens) -> np.ndarray:
    """(H·W, 3) through pixel centres, z = 1."""
    y, x = np.mgrid[0 : lens.height, 0 : lens.width]
    d = np.stack([(x + 0.5 - lens.cx) / lens.focal, (y + 0.5 - lens.cy) / lens.focal], -1)
    return np.concatenate([d, np.ones((*d.shape[:2], 1))], -1).reshape(-1, 3)


def brute(points, faces, lens, cull):
    """Möller–Trumbore over every ray and face: (face or −1, depth)."""
    d = rays(lens)
    best, which = np.full(len(d), np.inf), np.full(len(d), -1)
    for index, (a, b, c) in enumerate(points[faces]):
        e1, e2 = b - a, c - a
        if cull and np.dot(np.cross(e1, e2), a) >= 0:
            continue
        p = np.cross(d, e2)
        det = p @ e1
        with np.errstate(divide="ignore", invalid="ignore"):
            u = (p @ -a) / det
            q = np.cross(-a, e1)
            v = (d @ q) / det
            t = (e2 @ q) / det
        hit = (u >= 0) & (v >= 0) & (u + v <= 1) & (t > 1e-4) & (t < best)
        best[hit], which[hit] = t[hit], index
    return which, best


def images(hits, lens):
    face, depth = np.full(lens.width * lens.height, -1), np.full(lens.width * lens.height, np.inf)
    face[hits.pixel], depth[hits.pixel] = hits.face, hits.depth
    return face, depth


def one_sided(faces, value=True):
    return np.full(len(faces), value)


def test_sphere_depth_and_area_match_the_closed_form():
    centre, radius = np.array([0.1, -0.05, 3.0]), 0.8
    shape = trimesh.creation.icosphere(5, radius)
    faces = np.asarray(shape.faces, np.int32)
    hits = rasterise(shape.vertices + centre, faces, LENS, one_sided(faces))
    d = rays(LENS)
    b, a, c = d @ centre, (d * d).sum(1), centre @ centre - radius**2
    inside = b * b - a * c
    truth = np.where(inside > 0, (b - np.sqrt(np.maximum(inside, 0))) / a, np.inf)
    face, depth = images(hits, LENS)
    assert abs((face >= 0).sum() / np.isfinite(truth).sum() - 1) < 0.01
    both = (face >= 0) & (inside > 0.05)
    assert both.sum() > 1000
    assert np.abs(depth[both] - truth[both]).max() < 2e-3


def test_box_matches_slab_test_at_every_pixel():
    size, centre = np.array([0.8, 0.6, 0.5]), np.array([0.2, 0.1, 2.0])
    turn = trimesh.transformations.rotation_matrix(0.7, [0.3, 1, 0.2])[:3, :3]
    shape = trimesh.creation.box(size)
    faces = np.asarray(shape.faces, np.int32)
    hits = rasterise(shape.vertices @ turn.T + centre, faces, LENS, one_sided(faces))
    d, origin = rays(LENS) @ turn, -centre @ turn
    near, far = (-size / 2 - origin) / d, (size / 2 - origin) / d
    enter, leave = np.minimum(near, far).max(1), np.maximum(near, far).min(1)
    truth = np.where(enter < leave, enter, np.inf)
    _, depth = images(hits, LENS)
    clear = np.abs(enter - leave) > 1e-6
    assert np.array_equal(np.isfinite(depth)[clear], np.isfinite(truth)[clear])
    hit = np.isfinite(truth) & clear
    assert np.abs(depth[hit] - truth[hit]).max() < 1e-9


class _EveryTriangle:
    """Takes the place of the search tree (a further dependency): every triangle is a candidate."""

    def __init__(self, count: int) -> None:
        self.every = list(range(count))
        self.bounds = np.array([-10.0, -10, -10, 10, 10, 10])

    def intersection(self, bounds: object) -> list[int]:
        return self.every


def test_agrees_with_trimesh_ray_casting():
    shape = trimesh.creation.torus(0.6, 0.25, major_sections=24, minor_sections=12)
    shape.apply_transform(trimesh.transformations.rotation_matrix(1.1, [1, 0.4, 0]))
    shape.apply_translation([0.1, 0, 2.5])
    faces = np.asarray(shape.faces, np.int32)
    lens = Lens(40, 30, 35.0, 20, 15)
    hits = rasterise(np.asarray(shape.vertices), faces, lens, one_sided(faces))
    d = rays(lens)
    triangle, ray, place = trimesh.ray.ray_triangle.ray_triangle_id(
        shape.triangles, np.zeros_like(d), d, tree=_EveryTriangle(len(faces))
    )
    truth = np.full(len(d), -1)
    farthest_first = np.argsort(-place[:, 2])
    truth[ray[farthest_first]] = triangle[farthest_first]
    face, _ = images(hits, lens)
    assert (truth >= 0).sum() > 100
    # Rays through a shared edge may be given to either face.
    assert (face == truth).mean() > 0.995
    assert ((face >= 0) == (truth >= 0)).mean() > 0.998


def test_faces_that_reach_behind_the_camera():
    rng = np.random.default_rng(3)
    points = rng.normal(0, 1.0, (60, 3)) + np.array([0, 0, 0.6])
    faces = np.arange(60, dtype=np.int32).reshape(-1, 3)
    assert ((points[faces][:, :, 2] < 0).any(1) & (points[faces][:, :, 2] > 0).any(1)).sum() > 5
    hits = rasterise(points, faces, LENS, one_sided(faces, False))
    face, depth = images(hits, LENS)
    truth, distance = brute(points, faces, LENS, cull=False)
    assert (truth >= 0).sum() > 1000
    assert (face == truth).mean() > 0.999
    same = (face == truth) & (truth >= 0)
    assert np.allclose(depth[same], distance[same], rtol=1e-6)


def test_weights_give_back_the_pixel():
    shape = trimesh.creation.icosphere(2, 0.7)
    points = np.asarray(shape.vertices) + np.array([0.2, 0.1, 1.6])
    faces = np.asarray(shape.faces, np.int32)
    hits = rasterise(points, faces, LENS, one_sided(faces))
    surface = np.einsum("ki,kij->kj", hits.weights, points[faces[hits.face]])
    y, x = np.divmod(hits.pixel, LENS.width)
    assert np.abs(LENS.project(surface) - np.stack([x + 0.5, y + 0.5], 1)).max() < 1e-9
    assert np.abs(surface[:, 2] - hits.depth).max() < 1e-9
    assert hits.weights.min() > -1e-6


def test_neighbours_leave_no_crack():
    # A wall of many slanted triangles that fills the picture.
    grid = trimesh.creation.icosphere(4, 50.0)
    faces = np.asarray(grid.faces, np.int32)
    hits = rasterise(np.asarray(grid.vertices), faces, LENS, one_sided(faces, False))
    assert len(hits.pixel) == LENS.width * LENS.height


def test_no_faces():
    none = np.zeros((0, 3), np.int32)
    assert len(rasterise(np.zeros((0, 3)), none, LENS, one_sided(none)).pixel) == 0


def test_corners_have_the_normals_of_the_faces_around_that_bend_little():
    mesh = trimesh.creation.cylinder(1.0, 2.0, sections=12)
    faces = np.asarray(mesh.faces)
    a, b, c = (np.asarray(mesh.vertices)[faces[:, i]] for i in range(3))
    flat = np.cross(b - a, c - a)
    unit = flat / np.linalg.norm(flat, axis=1, keepdims=True)
    found = corner_normals(np.asarray(mesh.vertices), faces, faces)
    for face, corners in enumerate(faces):
        for corner, vertex in enumerate(corners):
            around = (faces == vertex).any(1) & (unit @ unit[face] > np.cos(np.radians(40)))
            wanted = flat[around].sum(0)
            assert np.allclose(found[face, corner], wanted / np.linalg.norm(wanted))
    up = np.abs(found[..., 2])
    assert ((up < 1e-9) | (up > 1 - 1e-9)).all(), "edges stay edges"
