"""The camera from the edges of right-angled things and from the circles that cans stand on."""

import math

import cv2
import numpy as np
import pytest

from physagent_studio.knowledge import usual_size
from physagent_studio.language import hints
from physagent_studio.program.scene.camera import Camera
from physagent_studio.program.scene.state import Box, Cylinder, Sphere
from physagent_studio.reconstruction import mesh_of
from physagent_studio.reconstruction.camera import estimate as cues
from physagent_studio.reconstruction.camera.rays import on_plane
from physagent_studio.reconstruction.camera.right_angles import edges_by_thing
from physagent_studio.reconstruction.photo.line_segments import segments
from physagent_studio.reconstruction.shapes.creases import Creases
from physagent_studio.reconstruction.shapes.forms import forms
from physagent_studio.reconstruction.shapes.primitives import Base
from physagent_studio.reconstruction.shapes.silhouettes import look, silhouette
from physagent_studio.reconstruction.supports.stances import foot_of, read

SIZE = (832, 480)
BOXES = (((0.3, 0.2, 0.16), (-0.45, 0.1), 0.5), ((0.2, 0.14, 0.22), (0.1, -0.15), -0.35))
BOXES += (((0.14, 0.3, 0.1), (0.5, 0.25), 1.0),)


def _camera(pitch: float, focal: float) -> Camera:
    row = SIZE[1] / 2 - focal * math.tan(math.radians(pitch))
    return Camera.from_horizon(SIZE, row, 1.3 * math.sin(math.radians(pitch)), focal=focal)


def _placed(
    shape: Box | Cylinder | Sphere, place: tuple[float, float, float], yaw: float = 0.0
) -> tuple[np.ndarray, np.ndarray]:
    mesh = mesh_of(shape)
    turn = np.array([[math.cos(yaw), -math.sin(yaw)], [math.sin(yaw), math.cos(yaw)]])
    points = np.column_stack([mesh.vertices[:, :2] @ turn.T, mesh.vertices[:, 2]])
    return points + place, mesh.faces


def _boxes(camera: Camera) -> tuple[np.ndarray, list[np.ndarray]]:
    """Three shaded boxes, each turned its own way, in the middle of what the camera sees."""
    ray = camera.rays(np.array([[SIZE[0] / 2, SIZE[1] / 2]]))[0]
    ahead = float(-ray[1] / ray[2] * camera.position[2])
    bodies = {
        str(k): _placed(Box(size=size), (x, ahead + y, size[2] / 2), yaw)
        for k, (size, (x, y), yaw) in enumerate(BOXES)
    }
    seen = look(camera, bodies)
    image = np.full((SIZE[1], SIZE[0], 3), np.uint8(150))
    for k, (points, faces) in enumerate(bodies.values()):
        mine = seen.owner == k
        shade = np.full((SIZE[1], SIZE[0]), 0, np.uint8)
        corners = points[faces]
        normal = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
        toward = (normal * (np.array(camera.position) - corners[:, 0])).sum(1) > 0
        for triangle, out in zip(corners[toward], normal[toward], strict=True):
            light = out / np.linalg.norm(out) @ [0.5, -0.3, 0.8]
            outline = np.round(camera.project(triangle)[0] * 16 - 8).astype(np.int32)
            cv2.fillConvexPoly(shade, outline, int(60 + 50 * (light + 1)), shift=4)
        image[mine] = shade[mine][:, None]
    image = np.asarray(cv2.GaussianBlur(image, (0, 0), 0.8), np.uint8)
    return image, [seen.owner == k for k in range(len(bodies))]


@pytest.mark.parametrize(("pitch", "focal"), [(16, 560), (28, 800), (40, 500), (70, 1000)])
def test_boxes_that_are_turned_give_pitch_and_focal_length(pitch, focal):
    camera = _camera(pitch, focal)
    image, masks = _boxes(camera)
    found = segments(image)
    angles = edges_by_thing(found, SIZE, masks)
    assert len(angles) == len(BOXES)
    horizon = cues.estimate(SIZE, found, [], angles=angles)
    seen = math.degrees(math.atan2(SIZE[1] / 2 - horizon.row, horizon.focal))
    assert seen == pytest.approx(pitch, abs=2.5)
    assert horizon.focal == pytest.approx(focal, rel=0.12)
    assert abs(horizon.row - camera.horizon) < 2 * horizon.sigma


def test_edges_of_tilted_things_are_left_out():
    image, masks = _boxes(_camera(28, 800))
    found = segments(image)
    kept = edges_by_thing(found, SIZE, masks[:2], masks[2:])
    assert len(kept) == 2
    assert len(edges_by_thing(found, SIZE, [], masks)) == 0


def test_round_things_change_nothing():
    camera = _camera(20, 580)
    image = np.full((SIZE[1], SIZE[0], 3), 170, np.uint8)
    masks = []
    for place in ((-0.5, 2.4, 0.2), (0.2, 2.0, 0.15), (0.7, 3.0, 0.25)):
        points, faces = _placed(Sphere(radius=place[2]), place)
        masks.append(silhouette(camera, points, faces))
        image[masks[-1]] = (40, 60, 160)
    image = np.asarray(cv2.GaussianBlur(image, (0, 0), 0.8), np.uint8)
    found = segments(image)
    assert len(found.length) > 0
    assert edges_by_thing(found, SIZE, masks) == []
    assert cues.estimate(SIZE, found, [], angles=[]) == cues.estimate(image.shape[1::-1], found, [])


def test_a_known_focal_length_is_kept():
    camera = _camera(28, 800)
    image, masks = _boxes(camera)
    found = segments(image)
    angles = edges_by_thing(found, SIZE, masks)
    assert cues.estimate(
        image.shape[1::-1], found, [], focal=700.0, angles=angles
    ).focal == pytest.approx(700)


def test_what_is_said_to_lean_is_not_upright():
    masks = {name: np.zeros((100, 200), bool) for name in ("wooden_plank", "red_ball")}
    masks["wooden_plank"][10:80, 30:60] = True
    masks["red_ball"][60:80, 120:140] = True
    stances = read(
        masks, hints("The red ball rolls into the plank leaning against the wall.", list(masks))
    )
    assert stances["wooden_plank"].leans
    assert not stances["red_ball"].leans


def test_boxes_are_turned_as_their_faces_meet():
    camera = _camera(28, 800)
    image, masks = _boxes(camera)
    found = segments(image)
    for mask, (size, _, yaw) in zip(masks, BOXES, strict=True):
        foot = foot_of(mask)
        place = on_plane(camera, [foot], 0.0)[0]
        base = Base(float(place[0]), float(place[1]), 0.0)
        best = forms(camera, mask, base, usual_size("box"), "box", found=found)[0]
        w, _, _, z = best.rotation
        turn = math.degrees(2 * math.atan2(z, w) - yaw)
        assert (turn + 45) % 90 - 45 == pytest.approx(0, abs=1.5)
        assert isinstance(best.shape, Box)
        edges = best.shape.size if round(turn / 90) % 2 == 0 else best.shape.size[1::-1]
        assert (*edges[:2], best.shape.size[2]) == pytest.approx(size, rel=0.08)


def test_creases_of_a_box_lie_on_edges_within_its_mask():
    camera = _camera(28, 800)
    image, masks = _boxes(camera)
    creases = Creases.within(masks[0], segments(image))
    assert creases is not None
    turns = [math.degrees(turn - BOXES[0][2]) for turn in creases.turns(camera)]
    assert min(abs((turn + 45) % 90 - 45) for turn in turns) < 3
    blank = np.full((SIZE[1], SIZE[0], 3), np.uint8(150))
    assert Creases.within(masks[0], segments(blank)) is None


def test_without_cues_the_lens_is_a_normal_one():
    """50 mm on film of 36 by 24 mm, however the picture is turned."""
    assert cues.usual_focal((3600, 2400)) == pytest.approx(5000, rel=0.001)
    assert cues.usual_focal((2400, 3600)) == pytest.approx(5000, rel=0.001)
    bare = np.full((480, 720, 3), 128, np.uint8)
    alone = cues.Standing(300.0, 60.0, 0.1, 0.2, "floor")
    found = cues.estimate((720, 480), segments(bare), [alone])
    assert found.focal == pytest.approx(cues.usual_focal((720, 480)), rel=0.15)
