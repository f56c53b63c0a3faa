"""PhysGen's cases and the CSV files of Force Prompting and Goal Force."""

from __future__ import annotations

from pathlib import Path

import cv2
import numpy as np
import pytest

from physagent_studio.errors import InputError
from physagent_studio.exchange import load_peer
from physagent_studio.exchange.peer_config import PeerSetup
from physagent_studio.program import PhysicalProgram, SceneObject, SceneState, apply
from physagent_studio.program.actions import SetVelocity
from physagent_studio.program.scene.camera import Camera
from physagent_studio.program.scene.state import Sphere

SIZE = (160, 120)
FORCE = "image,angle,force,coordx,coordy,width,height,caption\n"
SIM = """\
cat: pool
size: [160, 120]
num_steps: 100
gravity: 980
init_velocity:
  3: [-80, 0]
init_acc:
edge_list: [[[0, 110], [160, 110]]]
obj_info:
  3:
    label: white ball
    mass: 170
    density:
    friction: 0.3
    elasticity: 0.7
    primitive: circle
  7:
    label: white ball
    mass:
    density: 2.5
    friction: 0.5
    elasticity: 0.01
    primitive: polygon
"""


def picture(path: Path) -> None:
    noise = np.random.default_rng(0).integers(0, 255, (*SIZE[::-1], 3), np.uint8)
    cv2.imwrite(str(path), noise)


def setup_of(path: Path, **said: str) -> PeerSetup:
    found = load_peer(path, **said)  # pyright: ignore[reportArgumentType]
    assert found is not None
    return found


def moved_by(setup: PeerSetup) -> tuple[PhysicalProgram, np.ndarray]:
    """The program with the peer's motion, and how its first thing moves on the picture in it."""
    camera = Camera.from_horizon(SIZE, 40, 1.2)
    things = [
        SceneObject(name=name, shape=Sphere(radius=0.1), position=(0.2 * n, 2.5, 0.1))
        for n, (name, _) in enumerate(setup.case.objects)
    ]
    program = PhysicalProgram(scene=SceneState(objects=tuple(things), camera=camera))
    made = apply(program, setup.edits_of_scheduled(program))
    action = made.event.actions[0]
    assert isinstance(action, SetVelocity)
    place = np.array(things[0].position)
    velocity = np.array(action.velocity, float)
    ends = camera.project(np.stack([place, place + 1e-4 * velocity]))[0]
    return made, (ends[1] - ends[0]) / 1e-4


def test_a_force_is_a_way_on_the_picture(tmp_path: Path) -> None:
    picture(tmp_path / "car.png")
    (tmp_path / "car.csv").write_text(FORCE + 'car.png,225.0,0.5,40,20,160,120,"A car, rolls."\n')
    setup = setup_of(tmp_path / "car.csv")
    assert setup.case.prompt == "A car, rolls."
    ((_, grounding),) = setup.case.objects
    # From the lower left corner there, from the upper left here.
    assert (grounding.points[0].x, grounding.points[0].y) == (40.5, 99.5)
    made, way = moved_by(setup)
    far = SIZE[0] * (1 / 8 + 0.5 * 3 / 8) * np.array([-1, 1]) / np.sqrt(2)
    assert way * made.clip.seconds == pytest.approx(far, rel=1e-3)


def test_goal_force_keeps_the_goal_in_words(tmp_path: Path) -> None:
    (tmp_path / "images").mkdir()
    picture(tmp_path / "images/ball.png")
    head = (
        "image,projectile_force_angle,projectile_force_magnitude,projectile_coordx,"
        "projectile_coordy,projectile_mass,target_indirect_force_angle,"
        "target_indirect_force_magnitude,target_coordx,target_coordy,target_mass,width,height,"
        "caption\n"
    )
    row = "ball.png,0,200,30,60,-1,175,350,90,60,3.5,160,120,One ball hits another.\n"
    (tmp_path / "ball.csv").write_text(head + row)
    setup = setup_of(tmp_path / "ball.csv")
    assert [name for name, _ in setup.case.objects] == ["projectile", "target"]
    assert [one.name for one in setup.motion.pushes] == ["projectile"]
    assert any("the goal" in line for line in setup.left_out)
    assert any("target_mass" in line for line in setup.left_out)


@pytest.mark.parametrize(
    ("row", "told"),
    [
        ("../car.png,0,1,4,4,160,120,a", "file name"),
        ("car.png,nan,1,4,4,160,120,a", "must be a number"),
        ("car.png,0,1,400,4,160,120,a", "outside"),
        ("other.png,0,1,4,4,160,120,a", "there is no picture"),
        ('car.png,0,1,4,4,160,120,"a', "no valid CSV"),
    ],
)
def test_broken_rows_are_refused(row: str, told: str, tmp_path: Path) -> None:
    picture(tmp_path / "car.png")
    (tmp_path / "car.csv").write_text(FORCE + row)
    with pytest.raises(InputError, match=told):
        load_peer(tmp_path / "car.csv")


def physgen(folder: Path, text: str = SIM) -> Path:
    picture(folder / "original.png")
    mask = np.zeros(SIZE[::-1], np.uint8)
    cv2.circle(mask, (50, 60), 20, 3, -1)
    mask[80:100, 100:140] = 7
    cv2.imwrite(str(folder / "mask.png"), mask)
    (folder / "sim.yaml").write_text(text)
    return folder / "sim.yaml"


def test_physgen_has_its_things_numbers_and_speeds(tmp_path: Path) -> None:
    setup = setup_of(physgen(tmp_path))
    (first, ball), (second, box) = setup.case.objects
    assert (first, second) == ("white_ball_1", "white_ball_2")
    assert np.hypot(ball.points[0].x - 50.5, ball.points[0].y - 60.5) < 3
    assert box.box == (100, 80, 140, 100)
    assert (setup.objects[1].density, setup.objects[1].restitution) == (2500.0, 0.01)
    assert setup.gravity == pytest.approx((0, 0, -9.81))
    assert set(setup.left_out) == {"num_steps", "edge_list", "obj_info.3.mass"}
    assert setup.case.prompt == "The white ball 1 moves."
    made, way = moved_by(setup)
    assert way[0] < 0
    assert abs(way[1]) < 1e-6 * abs(way[0])
    # v² over g and length is theirs: 80² / (980 · 40 pixels across).
    action = made.event.actions[0]
    assert isinstance(action, SetVelocity)
    speed = float(np.linalg.norm(np.array(action.velocity, float)))
    pixel = speed / float(np.hypot(*way))
    assert speed**2 / (9.81 * 40 * pixel) == pytest.approx(80**2 / (980 * 40), rel=1e-6)


@pytest.mark.parametrize(
    ("before", "after", "told"),
    [
        ("  7:", "  9:", "grey level 9"),
        ("gravity: 980", "gravity: .nan", "must be a number"),
        ("3: [-80, 0]", "3: [-80]", r"must be \[x, y\]"),
        ("  7:", "  900:", "grey levels 1"),
    ],
)
def test_broken_physgen_is_refused(before: str, after: str, told: str, tmp_path: Path) -> None:
    with pytest.raises(InputError, match=told):
        load_peer(physgen(tmp_path, SIM.replace(before, after)))
