"""Stairs: steps from clicks and names, bodies on their treads, balls that bounce down them."""

import math
from itertools import pairwise

import cv2
import numpy as np
import pytest

from physagent_studio.benchmark.physics.scenes import ground, program, thing
from physagent_studio.benchmark.reconstruction.synthetic import TrueMasks
from physagent_studio.knowledge import is_stairs, support_kind
from physagent_studio.program.actions import SetVelocity
from physagent_studio.program.scene.camera import Camera
from physagent_studio.program.scene.shapes import depth_inside, gap, place_object, place_support
from physagent_studio.program.scene.stairs import treads_of
from physagent_studio.program.scene.state import (
    Box,
    Click,
    Grounding,
    Mark,
    Ramp,
    SceneObject,
    SceneState,
    Slab,
    Sphere,
    Support,
)
from physagent_studio.reconstruction import photo_hash, reconstruct
from physagent_studio.reconstruction.shapes.meshes import mesh_of, support_mesh, volume_and_centre
from physagent_studio.reconstruction.shapes.silhouettes import silhouette
from physagent_studio.reconstruction.supports.block import BOX, FACES, placed
from physagent_studio.reconstruction.supports.flights import Flight, flight_of
from physagent_studio.reconstruction.supports.ramps import height_at
from physagent_studio.reconstruction.supports.stairs import with_steps
from physagent_studio.records.case import Case
from physagent_studio.simulation import simulate

pytestmark = pytest.mark.usefixtures("unfilled")

STAIRS = Ramp(toe=(0, 2.5, 0), yaw=0.0, run=0.9, rise=0.64, width=1.0, plateau=0.5, steps=4)
CAMERA = Camera.from_horizon((640, 480), 90.0, 1.3, focal=600.0, source="given", confirmed=True)


def test_names():
    assert is_stairs("front_steps")
    assert is_stairs("staircase")
    assert support_kind("stairs") == "ramp"
    assert not is_stairs("step")
    assert support_kind("step") == "slab"


def test_treads_are_equal_and_the_uppermost_edge_is_where_the_run_ends():
    treads = treads_of(STAIRS)
    assert [tread.top for tread in treads] == pytest.approx([0.16, 0.32, 0.48, 0.64])
    assert [tread.start for tread in treads] == pytest.approx([0, 0.3, 0.6, 0.9])
    assert treads[-1].end == pytest.approx(1.4)
    assert treads_of(STAIRS.model_copy(update={"steps": 0})) == ()
    for x, height in ((-0.01, None), (0.01, 0.16), (0.31, 0.32), (1.3, 0.64), (1.5, None)):
        found = height_at(STAIRS, x, 2.5)
        assert found is None if height is None else found == pytest.approx(height)


def test_mesh_and_outline():
    mesh = support_mesh(STAIRS, 5.0)
    volume, _ = volume_and_centre(mesh.vertices, mesh.faces)
    exact = sum(0.16 * (1.4 - tread.start) for tread in treads_of(STAIRS))
    assert volume == pytest.approx(exact)
    placed = place_support(STAIRS)
    ball = place_object(Sphere(radius=0.1), [(1.1, 2.5, 0.94)], [(1, 0, 0, 0)])
    assert gap(ball, placed)[0] == pytest.approx(0.2, abs=0.01)
    assert depth_inside(np.array([[1.1, 2.5, 0.5]]), placed)[0] == pytest.approx(0.14, abs=1e-6)


def test_steps_from_clicks_names_and_height():
    bare = STAIRS.model_copy(update={"steps": 0})
    marks = tuple(Mark(role="top", x=10.0 * k, y=5.0) for k in range(5))
    clicked = Support(name="stairs", grounding=Grounding(marks=marks))
    assert with_steps(clicked, bare).steps == 5
    assert with_steps(Support(name="three_steps"), bare).steps == 3
    assert with_steps(Support(name="steps"), bare).steps == 4
    assert with_steps(Support(name="ramp"), bare) is bare


def test_a_ball_bounces_down_step_by_step_and_a_box_stays():
    stairs = ground("stairs", STAIRS, friction=0.6, restitution=0.5)
    ball = thing("ball", Sphere(radius=0.08), (1.1, 2.4, 0.72), restitution=0.6)
    box = thing("box", Box(size=(0.2, 0.2, 0.1)), (0.45, 2.8, 0.37), friction=0.6)
    go = SetVelocity(id="go", name="ball", velocity=(-0.7, 0, 0))
    run = simulate(program([ball, box], [stairs, ground()], [go], seconds=2.5))
    path = run.positions[:, 0]
    assert path[-1, 0] < -0.2
    assert path[-1, 2] < 0.4
    # It touches treads on the way rather than sliding down a slope.
    for tread in treads_of(STAIRS)[1:3]:
        over = (path[:, 0] > tread.start) & (path[:, 0] < tread.end)
        assert path[over, 2].min() > tread.top + 0.07
    assert np.abs(run.positions[-1, 1] - run.positions[0, 1]).max() < 2e-3


def test_a_reconstructed_ball_stands_on_its_tread():
    rng = np.random.default_rng(0)
    image = rng.integers(0, 255, (480, 640, 3), dtype=np.uint8)
    ball = mesh_of(Sphere(radius=0.09))
    place = np.array([0.42, 2.3, 0.41])
    masks = {"ball": silhouette(CAMERA, ball.vertices + place, ball.faces)}
    front = 2.5 - STAIRS.width / 2
    corners = [(0.0, front, 0.0), *((t.start, front, t.top) for t in treads_of(STAIRS))]
    toe, *tops = CAMERA.project(np.array(corners))[0]
    foot = CAMERA.project(np.array([[0.9, front, 0.0]]))[0][0]
    far = CAMERA.project(np.array([[0.0, 2.5 + STAIRS.width / 2, 0.0]]))[0][0]
    marks = (
        *(Mark(role="toe", x=float(x), y=float(y)) for x, y in (toe, far)),
        *(Mark(role="top", x=float(x), y=float(y)) for x, y in tops),
        Mark(role="foot", x=float(foot[0]), y=float(foot[1])),
    )
    clicked = Grounding(points=(Click(x=1, y=1),))
    case = Case(
        name="stairs",
        image=image,
        image_hash=photo_hash(image),
        objects=(("ball", clicked),),
        supports=(),
        landmarks=(),
        prompt="The ball bounces down the stairs.",
    )
    state = SceneState(
        camera=CAMERA,
        objects=(SceneObject(name="ball", grounding=clicked, support="stairs"),),
        supports=(Support(name="stairs", grounding=Grounding(marks=marks)),),
    )
    scene = reconstruct(case, state, segmenter=TrueMasks(masks))
    stairs, found = scene.state.support("stairs"), scene.state.object("ball")
    assert stairs is not None
    assert isinstance(stairs.shape, Ramp)
    assert stairs.shape.steps == 4
    assert stairs.shape.rise == pytest.approx(0.64, abs=0.02)
    assert stairs.shape.run == pytest.approx(0.9, abs=0.03)
    assert stairs.shape.width == pytest.approx(1.0, abs=0.05)
    assert math.isclose(stairs.shape.yaw, 0.0, abs_tol=0.02)
    assert found is not None
    assert found.position is not None
    assert np.abs(np.array(found.position) - place).max() < 0.05
    assert all(one.ok for one in scene.findings if one.name == "contact")


FLIGHTS = {
    "from the side": Flight(x=0.30, y=2.1, tread=0.30, riser=0.15, width=0.8, yaw=math.pi, steps=3),
    "from the front": Flight(x=0.1, y=1.9, tread=0.28, riser=0.13, width=0.9, yaw=1.75, steps=4),
}


def _steps_drawn(flight):
    """A picture of a flight on the unit camera, faces in three tones, and the mask of each step."""
    eye = CAMERA.model_copy(update={"position": (0.0, 0.0, 1.0)})
    image = np.full((480, 640, 3), 118, np.uint8)
    numbers = np.zeros((480, 640), np.uint8)
    far = sorted(range(flight.steps), key=lambda k: -np.hypot(flight.block(k).x, flight.block(k).y))
    for index in far:
        pixels, _ = eye.project(placed(BOX, flight.block(index)))
        turned = flight.block(index).yaw
        sides = [(-1, 0, 2), (1, 0, 1), (0, 1, 3), (0, -1, 4)]
        own = (-flight.block(index).x, -flight.block(index).y)
        seen = [(0, 210)]
        for along, across, face in sides:
            way = turned if along else turned + math.pi / 2
            sign = along or across
            half = flight.block(index).size[0 if along else 1] / 2
            if sign * (own[0] * math.cos(way) + own[1] * math.sin(way)) > half:
                seen.append((face, 170 if along else 140))
        for face, tone in seen:
            corners = np.round(pixels[list(FACES["box"][face])]).astype(np.int32)
            cv2.fillConvexPoly(image, corners, (tone, tone - 20, tone - 50))
            cv2.fillConvexPoly(numbers, corners, index + 1)
    noise = np.random.default_rng(1).normal(0, 2, image.shape)
    image = np.clip(image + noise, 0, 255).astype(np.uint8)
    return eye, image, [numbers == k + 1 for k in range(flight.steps)]


@pytest.mark.parametrize("true", FLIGHTS.values(), ids=FLIGHTS)
def test_steps_clicked_singly_are_one_flight(true):
    eye, image, masks = _steps_drawn(true)
    nothing = np.zeros(image.shape[:2], bool)
    found = flight_of(eye, image, masks, nothing, (true.steps,))
    assert found is not None
    assert (found.tread, found.riser) == pytest.approx((true.tread, true.riser), rel=0.08)
    assert found.width == pytest.approx(true.width, rel=0.12)
    assert abs(np.angle(np.exp(1j * (found.yaw - true.yaw)))) < math.radians(3)
    assert (found.x, found.y) == pytest.approx((true.x, true.y), abs=0.03 * true.y)


def test_the_number_of_steps_is_seen():
    true = FLIGHTS["from the side"]
    eye, image, masks = _steps_drawn(true)
    whole = [np.any(masks, axis=0)]
    found = flight_of(eye, image, whole, np.zeros(image.shape[:2], bool), (2, 3, 4))
    assert found is not None
    assert found.steps == true.steps
    assert found.riser == pytest.approx(true.riser, rel=0.06)


def test_single_steps_carry_and_join():
    true = FLIGHTS["from the side"]
    eye, image, masks = _steps_drawn(true)
    names = ["step_1", "step_2", "step_3"]
    spots = [np.argwhere(mask).mean(0) for mask in masks]
    supports = tuple(
        Support(name=name, grounding=Grounding(points=(Click(x=float(x), y=float(y)),)))
        for name, (y, x) in zip(names, spots, strict=True)
    )
    foot = eye.project(np.array([[true.block(2).x, true.block(2).y, true.block(2).size[2]]]))[0][0]
    y, x = np.indices(image.shape[:2])
    ball = np.hypot(x - foot[0], y - (foot[1] - 22)) < 22
    image = np.where(ball[..., None], np.array([200, 40, 40], np.uint8), image)
    seen = {name: mask & ~ball for name, mask in zip(names, masks, strict=True)} | {"ball": ball}
    click = Grounding(points=(Click(x=float(foot[0]), y=float(foot[1] - 22)),))
    case = Case("t", image, photo_hash(image), (("ball", click),), supports, (), "It rolls.")
    state = SceneState(
        camera=CAMERA, supports=supports, objects=(SceneObject(name="ball", grounding=click),)
    )
    done = reconstruct(case, state, segmenter=TrueMasks(seen)).state
    slabs = [item.shape for item in done.supports if isinstance(item.shape, Slab)]
    tops = [slab.position[2] + slab.size[2] / 2 for slab in slabs]
    assert tops == pytest.approx([1.3 * 0.15 * k for k in (1, 2, 3)], rel=0.07)
    for one, other in pairwise(slabs):
        apart = np.hypot(*np.subtract(other.position, one.position)[:2])
        assert apart == pytest.approx((one.size[0] + other.size[0]) / 2, rel=1e-6)
    assert [item.support for item in done.objects] == ["step_3"]
