"""What things fall into is hollow: by its name, or because the sentence has something go in."""

import numpy as np
import pytest

from physagent_studio.benchmark.physics_scenes import ground, program, thing
from physagent_studio.program.base import IDENTITY
from physagent_studio.program.scene import Box, Cylinder, Frustum, Revolved, Sphere
from physagent_studio.program.volumes import volume_of
from physagent_studio.reconstruction.forms import Form
from physagent_studio.reconstruction.meshes import mesh_of, volume_and_centre
from physagent_studio.reconstruction.vessels import is_vessel, opened
from physagent_studio.simulation import simulate
from physagent_studio.simulation.solids import solid_of

FALLS = "The ball falls into the {}."


@pytest.mark.parametrize(
    ("name", "prompt", "hollow"),
    [
        ("salad_bowl", "The bowl slides off the table.", True),
        ("basket_2", "", True),
        ("cardboard_box", FALLS.format("cardboard box"), True),
        ("cardboard_box", "The cardboard box slides to the left.", False),
        ("trash_can", "The scooter crashes into the trash can.", False),
        ("trash_can", "The paper ball drops into the old trash can.", True),
        ("box", "The ball bumps into the box.", False),
        ("red_box", "An orange lands in the red box and stays there.", True),
        ("ball", "The ball falls into the cup.", False),
        ("cup", "The ball falls into the cup.", True),
        ("pumpkin", "The knife is stuck in the pumpkin.", False),
    ],
)
def test_names_and_sentences(name, prompt, hollow):
    assert is_vessel(name, prompt) is hollow


def _form(shape):
    return Form(shape.kind, shape, mesh_of(shape), (0, 0, 0), IDENTITY, 1.0, 1.0)


SHAPES = {
    "cylinder": Cylinder(radius=0.1, height=0.2),
    "frustum": Frustum(bottom_radius=0.08, top_radius=0.12, height=0.2),
    "revolved": Revolved(profile=((-0.1, 0.06), (0.0, 0.11), (0.1, 0.12))),
    "box": Box(size=(0.3, 0.25, 0.2)),
}


@pytest.mark.parametrize("kind", SHAPES)
def test_a_ball_falls_in_and_stays_in(kind):
    made = opened(_form(SHAPES[kind]))
    shape = made.shape
    assert isinstance(shape, Frustum | Revolved | Box)
    assert shape.wall is not None
    bottom = float(made.mesh.vertices[:, 2].min())
    vessel = thing("vessel", shape, (0, 0, -bottom), density=800)
    ball = thing("ball", Sphere(radius=0.04), (0.01, 0, 0.4), density=300)
    end = simulate(program([vessel, ball], [ground()], seconds=1.5)).positions[-1]
    assert np.hypot(*(end[1] - end[0])[:2]) < 0.1
    assert 0.04 < end[1, 2] < 0.08
    assert np.abs(end[0] - (0, 0, -bottom)).max() < 0.01


@pytest.mark.parametrize("kind", SHAPES)
def test_the_mesh_of_a_vessel_has_the_volume_of_its_walls(kind):
    made = opened(_form(SHAPES[kind]))
    volume, centre = volume_and_centre(made.mesh.vertices, made.mesh.faces)
    solid = solid_of("vessel", made.shape, None, lambda surface: None)
    assert volume == pytest.approx(solid.mass.volume, rel=0.02)
    assert volume_of(made.shape) == pytest.approx(volume, rel=0.05)
    assert centre == pytest.approx(solid.mass.centre, abs=2e-3)
    whole = volume_and_centre(mesh_of(SHAPES[kind]).vertices, mesh_of(SHAPES[kind]).faces)[0]
    assert volume < 0.6 * whole


def test_what_cannot_be_hollow_stays():
    ball = _form(Sphere(radius=0.1))
    cone = _form(Frustum(bottom_radius=0.1, top_radius=0.01, height=0.2))
    assert opened(ball) is ball
    assert opened(cone) is cone
