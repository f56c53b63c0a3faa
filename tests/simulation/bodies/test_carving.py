"""Concave bodies collide in pieces: what their silhouette shows open is open."""

import math
from collections.abc import Sequence

import numpy as np
import pytest

from physagent_studio.benchmark.physics.bodies import ring_mesh
from physagent_studio.benchmark.physics.scenes import ground, program, thing
from physagent_studio.program.actions import SetVelocity
from physagent_studio.program.scene.state import Inflated, Sphere
from physagent_studio.records import Mesh
from physagent_studio.simulation import simulate
from physagent_studio.simulation.bodies.carving import carved
from physagent_studio.simulation.bodies.solids import solid_of
from physagent_studio.simulation.surfaces import box_surface, mass_properties, welded

Box3 = tuple[tuple[float, float, float], tuple[float, float, float]]


def _joined(boxes: Sequence[Box3]) -> Mesh:
    """Boxes (centre, size) as one mesh of several closed parts."""
    vertices, faces, count = [], [], 0
    for centre, size in boxes:
        own, triangles = box_surface(size)
        vertices.append(own + np.array(centre))
        faces.append(triangles + count)
        count += len(own)
    return Mesh(np.concatenate(vertices), np.concatenate(faces).astype(np.int32))


def _arch() -> Mesh:
    """A table from the front as one closed surface: 0.6 m wide, 0.4 m high, 0.3 m deep."""
    outline = [(-0.3, -0.2), (-0.24, -0.2), (-0.24, 0.12), (0.24, 0.12), (0.24, -0.2), (0.3, -0.2)]
    outline += [(0.3, 0.2), (-0.3, 0.2)]
    front = [(x, -0.15, z) for x, z in outline]
    back = [(x, 0.15, z) for x, z in outline]
    caps = [(0, 1, 2), (0, 2, 7), (7, 2, 3), (7, 3, 6), (6, 3, 5), (5, 3, 4)]
    faces = [*caps, *[(c + 8, b + 8, a + 8) for a, b, c in caps]]
    for k in range(8):
        after = (k + 1) % 8
        faces += [(k, k + 8, after), (after, k + 8, after + 8)]
    return Mesh(np.array(front + back), np.array(faces, np.int32))


def test_an_arch_is_two_legs_and_a_beam():
    mesh = _arch()
    surface = (mesh.vertices, mesh.faces)
    pieces = carved(surface)
    assert len(pieces) == 3
    own = mass_properties(surface).volume
    assert sum(mass_properties(piece).volume for piece in pieces) == pytest.approx(own, rel=0.12)
    again = carved(surface)
    assert all(np.array_equal(one[0], other[0]) for one, other in zip(pieces, again, strict=True))


def test_what_is_convex_stays_one_piece():
    assert len(carved(box_surface((0.2, 0.3, 0.4)))) == 1


def test_a_ring_keeps_its_hole():
    ring = ring_mesh(0.1, 0.03)
    pieces = carved((np.asarray(ring.vertices), np.asarray(ring.faces)))
    middle = np.zeros(3)
    for vertices, faces in pieces:
        a, b, c = (vertices[faces[:, k]] for k in range(3))
        normals = np.cross(b - a, c - a)
        assert (np.einsum("fi,fi->f", normals, middle - a) > 0).any()


def test_a_mesh_that_was_cut_for_its_texture_weighs_what_it_encloses():
    mesh = _arch()
    half = len(mesh.faces) // 2
    faces = mesh.faces.copy()
    faces[half:] += len(mesh.vertices)
    split = Mesh(np.concatenate([mesh.vertices, mesh.vertices]), faces)
    solid = solid_of("table", Inflated(size=(0.6, 0.3, 0.4)), split, lambda surface: None)
    exact = mass_properties((mesh.vertices, mesh.faces))
    assert solid.note == ""
    assert solid.mass.volume == pytest.approx(exact.volume)
    assert solid.mass.inertia == pytest.approx(exact.inertia, abs=1e-9)
    assert len(welded((split.vertices, split.faces))[0]) == len(mesh.vertices)


def test_a_ball_rolls_through_under_the_table_and_not_through_its_leg():
    mesh = _arch()
    centre = mass_properties((mesh.vertices, mesh.faces)).centre
    own = Mesh(mesh.vertices - centre, mesh.faces)
    table = thing("table", Inflated(size=(0.6, 0.3, 0.4)), (0, 0, 0.2 + centre[2]), density=700)
    go = SetVelocity(id="go", name="ball", velocity=(0, 2.0, 0))
    for x, passes in ((0.0, True), (0.27, False)):
        ball = thing("ball", Sphere(radius=0.08), (x, -0.6, 0.08), density=100)
        run = simulate(program([table, ball], [ground()], [go], seconds=1.0), {"table": own})
        assert (run.positions[-1, 1, 1] > 0.6) == passes
        if passes:
            assert np.abs(run.positions[-1, 0] - run.positions[0, 0]).max() < 1e-3


def test_what_is_drawn_thin_collides_as_deep_as_it_is():
    block, thin = box_surface((0.2, 0.2, 0.2)), box_surface((0.2, 0.01, 0.2))
    look = Mesh(*thin, solid=block)
    item = thing("block", Inflated(size=(0.2, 0.2, 0.2)), (0, 0, 0.1), density=700)
    ball = thing("ball", Sphere(radius=0.05), (0, -0.6, 0.05), density=100)
    go = SetVelocity(id="go", name="ball", velocity=(0, 1.0, 0))
    scene = program([item, ball], [ground()], [go], seconds=1.0)
    runs = [simulate(scene, {"block": mesh}) for mesh in (look, Mesh(*block), Mesh(*thin))]
    assert np.array_equal(runs[0].positions, runs[1].positions)
    nearest = [float(run.positions[:, 1, 1].max()) for run in runs]
    assert nearest[0] < -0.14 < nearest[2]


def test_parts_that_share_nothing_are_pieces_of_their_own():
    mesh = _joined([((0, 0, 0.2), (0.6, 0.3, 0.04)), ((-0.25, -0.1, 0), (0.04, 0.04, 0.36))])
    assert len(carved((mesh.vertices, mesh.faces))) == 2
    assert math.isclose(mass_properties((mesh.vertices, mesh.faces)).volume, 0.0072 + 0.000576)
