"""Rings have a real hole: they fall over pegs, hang on beams, lie, stand and roll."""

import math

import numpy as np
import pytest

from physagent_studio.benchmark.physics.scenes import ground, program, thing
from physagent_studio.program import SceneObject, Support
from physagent_studio.program.actions import FixObject, SetVelocity
from physagent_studio.program.preflight.mechanics import volume_of
from physagent_studio.program.scene.state import (
    Box,
    Cylinder,
    Floor,
    Frustum,
    Ramp,
    Slab,
    Sphere,
    Torus,
)
from physagent_studio.reconstruction.shapes.meshes import mesh_of
from physagent_studio.simulation import simulate
from physagent_studio.simulation.bodies.solids import ring
from physagent_studio.simulation.surfaces import is_closed, mass_properties

RADIUS, TUBE = 0.2, 0.04
SHAPE = Torus(radius=RADIUS, tube=TUBE)
UPRIGHT = (math.sqrt(0.5), math.sqrt(0.5), 0.0, 0.0)


def test_the_mass_of_a_ring_is_that_of_its_fine_mesh():
    mesh = mesh_of(SHAPE)
    surface = (mesh.vertices, mesh.faces)
    assert is_closed(surface)
    fine = mass_properties(surface)
    made = ring(RADIUS, TUBE)
    assert made.volume == pytest.approx(volume_of(SHAPE))
    assert made.volume == pytest.approx(fine.volume, rel=0.03)
    moments = np.array(made.moments) * made.volume
    assert moments == pytest.approx(np.diag(fine.inertia), rel=0.04)


@pytest.mark.parametrize("tube", [0.002, 0.04, 0.15, 0.3])
def test_thin_thick_and_closed_rings_are_chains_that_close(tube):
    pieces = ring(0.2, tube).pieces
    half = pieces[0].size[1]
    places = np.array([piece.place for piece in pieces])
    away = np.linalg.norm(places - np.roll(places, -1, axis=0), axis=1)
    assert len(pieces) >= 12
    assert away.max() <= 2 * half


def test_a_ring_falls_over_a_peg():
    peg = thing("peg", Cylinder(radius=0.05, height=0.6), (0, 0, 0.3), density=7000)
    over = thing("ring", SHAPE, (0.05, 0, 0.9))
    end = simulate(program([over, peg], [ground()], seconds=1.5)).positions[-1]
    assert end[0, 2] == pytest.approx(TUBE, abs=1e-3)
    assert end[1] == pytest.approx([0, 0, 0.3], abs=0.01)


def test_a_ring_hangs_on_a_beam():
    beam = ground("beam", Slab(position=(0, 0, 1.0), size=(0.05, 1.0, 0.05)))
    top = 1.025 - (RADIUS - TUBE)
    hung = thing("ring", SHAPE, (0, 0, top), rotation=UPRIGHT)
    end = simulate(program([hung], [beam, ground()], seconds=2.0)).positions[-1, 0]
    assert end[2] == pytest.approx(top, abs=0.01)
    assert np.hypot(*end[:2]) < 0.05


def test_a_ball_flies_through_a_held_hoop_and_hits_its_tube():
    hoop = thing("hoop", SHAPE, (0, 0, 1), rotation=UPRIGHT)
    fix = FixObject(id="hold", name="hoop", duration=60)
    for x, passes in ((0.0, True), (0.2, False)):
        ball = thing("ball", Sphere(radius=0.08), (x, -1, 1))
        go = SetVelocity(id="go", name="ball", velocity=(0, 5, 1.0))
        path = simulate(program([hoop, ball], [ground()], [fix, go], seconds=0.6)).positions
        assert (path[-1, 1, 1] > 1.5) == passes


def test_a_ring_rolls_down_a_slope_as_a_ring_does():
    lean, length = math.atan(0.1), 4.0
    outer = RADIUS + TUBE
    place = (1 - outer * math.sin(lean), 0.0, 0.3 + outer * math.cos(lean))
    shape = Ramp(toe=(-2, 0, 0), yaw=0, run=length, rise=0.1 * length, width=2)
    rolling = thing("ring", SHAPE, place, rotation=UPRIGHT, friction=0.9)
    run = simulate(program([rolling], [ground("slope", shape, friction=0.9)], seconds=1.5))
    share = (RADIUS**2 + 0.75 * TUBE**2) / outer**2
    seconds = (len(run.positions) - 1) * run.step_seconds
    exact = 0.5 * 9.81 * math.sin(lean) / (1 + share) * seconds**2
    gone = float(np.linalg.norm(run.positions[-1, 0] - run.positions[0, 0]))
    assert gone == pytest.approx(exact, rel=0.01)


@pytest.mark.parametrize("degrees", [2, 10, 30])
@pytest.mark.parametrize("material", ["plastic", "metal", "rubber"])
def test_a_ring_that_falls_askew_comes_to_rest_and_gains_nothing(degrees, material):
    half = math.radians(degrees) / 2
    falls = SceneObject(
        name="ring",
        shape=Torus(radius=0.15, tube=0.03),
        position=(0, 0, 0.7),
        rotation=(math.cos(half), math.sin(half), 0, 0),
        material=material,
    )
    run = simulate(program([falls], [Support(name="floor", shape=Floor())], seconds=3.2))
    total = (run.kinetic + run.potential)[:, 0]
    # What goes into the contacts at an impact comes back within some steps.
    late = np.diff(total[150:])
    assert late[late > 0].sum() < 0.03 * total[0]
    assert np.diff(total).max() < 0.03 * total[0]
    assert run.positions[-1, 0, 2] < 0.06


def test_a_ring_lies_and_stands_still_and_carries_a_box():
    lying = thing("ring", SHAPE, (0, 0, TUBE))
    box = thing("box", Box(size=(0.4, 0.4, 0.1)), (0, 0, 2 * TUBE + 0.05))
    standing = thing("hoop", SHAPE, (2, 0, RADIUS + TUBE), rotation=UPRIGHT)
    path = simulate(program([lying, box, standing], [ground()], seconds=2.0)).positions
    assert np.abs(path[-1] - path[0]).max() < 1e-3


@pytest.mark.parametrize("shift", [0.0, 0.005, 0.012])
def test_a_ring_that_falls_over_a_cone_sits_still_on_it(shift):
    shape = Frustum(bottom_radius=0.08, top_radius=0.0, height=0.2)
    cone = thing("cone", shape, (0, 0, 0.05), density=950, friction=0.35, restitution=0.45)
    hoop = thing("hoop", Torus(radius=0.06, tube=0.01), (shift, 0, 0.3), restitution=0.45)
    rollout = simulate(program([cone, hoop], [ground(restitution=0.4)], seconds=2.0))
    whole = (rollout.kinetic + rollout.potential).sum(axis=1)
    assert np.diff(whole[20:]).max() < 0.01 * whole[0]
    assert rollout.kinetic[120:].sum(axis=1).max() < 1e-6
    assert 0.05 < rollout.positions[-1, 1, 2] < 0.2
