"""What things fall into is hollow: by its name, or because the sentence has something go in."""

import numpy as np
import pytest

from physagent_studio.benchmark.physics.scenes import ground, program, thing
from physagent_studio.language import hints
from physagent_studio.program.base import IDENTITY
from physagent_studio.program.preflight.mechanics import volume_of
from physagent_studio.program.scene.camera import Camera
from physagent_studio.program.scene.state import (
    Box,
    Click,
    Cylinder,
    Frustum,
    Grounding,
    Revolved,
    SceneState,
    Sphere,
    Support,
    Vessel,
)
from physagent_studio.reconstruction import photo_hash, reconstruct
from physagent_studio.reconstruction.shapes.forms import Form
from physagent_studio.reconstruction.shapes.meshes import mesh_of, volume_and_centre
from physagent_studio.reconstruction.shapes.silhouettes import silhouette
from physagent_studio.reconstruction.shapes.vessels import opened
from physagent_studio.records.case import Case
from physagent_studio.simulation import simulate
from physagent_studio.simulation.bodies.solids import solid_of

pytestmark = pytest.mark.usefixtures("unfilled")

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
        ("red_can", "The ball rolls into the pyramid of cans.", False),
        ("pumpkin", "The knife is stuck in the pumpkin.", False),
    ],
)
def test_names_and_sentences(name, prompt, hollow):
    assert (name in hints(prompt, [name]).hollow) is hollow


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


CAMERA = Camera.from_horizon((416, 312), -40.0, 0.45, focal=330.0, source="given", confirmed=True)
BELLY = np.linspace(0.0, 1.0, 14)
BASINS = {
    "green_bowl": Revolved(
        profile=tuple((0.09 * z - 0.05, 0.05 + 0.06 * (1 - (1 - z) ** 2) ** 0.5) for z in BELLY)
    ),
    "green_bucket": Frustum(bottom_radius=0.06, top_radius=0.085, height=0.14),
    "green_tray": Box(size=(0.34, 0.22, 0.05)),
}


def _drawn(shape, place):
    """A picture of a green thing on a grey ground, noise on both."""
    mesh = mesh_of(shape)
    low = float(mesh.vertices[:, 2].min())
    mask = silhouette(CAMERA, mesh.vertices + np.array((*place, -low)), mesh.faces)
    image = np.where(mask[..., None], (40, 140, 60), (150, 150, 155)).astype(float)
    image += np.random.default_rng(3).normal(0, 4, image.shape)
    return mask, np.clip(image, 0, 255).astype(np.uint8)


@pytest.mark.parametrize("name", BASINS)
def test_a_vessel_that_is_a_support_holds_what_falls_into_it(name):
    place = (0.05, 0.8)
    mask, image = _drawn(BASINS[name], place)
    y, x = (float(v) for v in np.argwhere(mask).mean(0))
    support = Support(name=name, grounding=Grounding(points=(Click(x=x, y=y),)))
    prompt = "The ball falls into the vessel."
    case = Case("t", image, photo_hash(image), (), (support,), (), prompt)
    found = reconstruct(case, SceneState(supports=(support,), camera=CAMERA)).state.support(name)
    assert found is not None
    assert isinstance(found.shape, Vessel)
    made, true = mesh_of(found.shape.body).vertices, mesh_of(BASINS[name]).vertices
    edges, true_edges = np.ptp(made, axis=0), np.ptp(true, axis=0)
    if isinstance(BASINS[name], Box):
        assert isinstance(found.shape.body, Box)
        assert np.abs(np.sin(2 * found.shape.yaw)) < 0.1
        edges = np.sort(edges)[::-1]
    assert edges == pytest.approx(true_edges, rel=0.12)
    assert found.shape.position[:2] == pytest.approx(place, abs=0.04 * place[1])
    assert found.shape.position[2] + made[:, 2].min() == pytest.approx(0, abs=1e-4)
    ball = thing("ball", Sphere(radius=0.025), (place[0] + 0.01, place[1], 0.4), density=300)
    end = simulate(program([ball], [ground(), found], seconds=1.5)).positions[-1][0]
    assert np.hypot(end[0] - place[0], end[1] - place[1]) < true_edges[:2].min() / 2
    assert 0.025 < end[2] < 0.025 + true_edges[2]
