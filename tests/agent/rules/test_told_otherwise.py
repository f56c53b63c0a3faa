"""Sentences that tell things apart by where they are, and what is told of nothing stays calm."""

from __future__ import annotations

import numpy as np
import pytest

from physagent_studio.agent.rules import RuleGenerator
from physagent_studio.contract import measure
from physagent_studio.language import EventFrame, hints, inventory, read
from physagent_studio.program import Click, Grounding, PhysicalProgram
from physagent_studio.program.scene.state import Box, Cylinder, Slab, Sphere
from physagent_studio.simulation import simulate
from tests.agent.rules.scenes import STAGES, Stage

PLUMS = {"left_plum": 100, "middle_plum": 300, "right_plum": 600, "box": 650, "red_car": 700}
ON = (("left_plum", "shelf"), ("middle_plum", "shelf"), ("right_plum", "floor"))


def frames(prompt: str) -> tuple[EventFrame, ...]:
    things = [(name, Grounding(points=(Click(x=x, y=200),))) for name, x in PLUMS.items()]
    return read(prompt, inventory(things, [("shelf", Grounding())], on=ON)).frames


@pytest.mark.parametrize(
    ("prompt", "agent", "patient"),
    [
        ("The right plum on the shelf rolls to the right.", (), "middle_plum"),
        ("The right plum rolls to the right.", (), "right_plum"),
        ("The plum next to the box rolls to the left.", (), "right_plum"),
        ("The left plum bumps into the plum next to it.", ("left_plum",), "middle_plum"),
    ],
)
def test_which_of_several_is_meant(prompt: str, agent: tuple[str, ...], patient: str) -> None:
    (frame,) = frames(prompt)
    assert (frame.agent, frame.patient) == (agent, (patient,))
    assert not any(place.name == "box" for _, place in frame.places)


@pytest.mark.parametrize(
    ("prompt", "sense", "direction"),
    [
        ("The red car backs up.", "move", "backward"),
        ("The red car drives in reverse.", "move", "backward"),
        ("The left plum rolls back toward the camera.", "move", "toward_camera"),
        ("The red car makes a U-turn.", "turn_around", None),
        ("The box is lowered.", "descend", None),
    ],
)
def test_ways_back_and_down(prompt: str, sense: str, direction: str | None) -> None:
    (frame,) = frames(prompt)
    assert (frame.sense, frame.direction) == (sense, direction)


def test_what_went_before_comes_back() -> None:
    first, second = frames("The red car drives to the left and then backs up.")
    assert (first.direction, second.sense) == ("left", "reverse")


def test_what_slides_has_a_flat_base() -> None:
    told = hints("The grey stone slides to the left.", ["grey_stone", "ball"])
    assert "ellipsoid" not in told.usual("grey_stone").shapes
    assert "ellipsoid" in hints("The grey stone rolls.", ["grey_stone"]).usual("grey_stone").shapes
    for fruit in ("ball", "orange"):
        said = f"The {fruit} slides off the table."
        assert hints(said, [fruit]).usual(fruit) == hints("", [fruit]).usual(fruit)


TOWER = Stage(
    "tower",
    {
        "top_box": (Box(size=(0.1, 0.1, 0.1)), (0.0, 2.5, 0.25), "middle_box"),
        "middle_box": (Box(size=(0.1, 0.1, 0.1)), (0.0, 2.5, 0.15), "bottom_box"),
        "bottom_box": (Box(size=(0.1, 0.1, 0.1)), (0.0, 2.5, 0.05), "floor"),
    },
)
ALONE = Stage("alone", {"ball": (Sphere(radius=0.1), (0.0, 3.0, 0.1), "floor")})
LAMP = Stage("lamp", {"lamp": (Cylinder(radius=0.1, height=0.3), (0.0, 3.0, 1.2), "air")})
BELT = Stage(
    "belt",
    {"can": (Cylinder(radius=0.04, height=0.1), (0.3, 2.5, 0.65), "belt")},
    {"belt": Slab(position=(0.0, 2.5, 0.55), size=(1.2, 0.3, 0.1))},
)


def first(stage: Stage, prompt: str) -> PhysicalProgram:
    return RuleGenerator().first(stage.case(prompt), stage.reconstruct)


def still(program: PhysicalProgram) -> set[str]:
    return {s.subject for s in program.contract.statements if s.kind == "stays"}


def test_what_stood_below_stays_there() -> None:
    assert still(first(TOWER, "The top box slides off to the right.")) == {
        "middle_box",
        "bottom_box",
    }
    told = first(TOWER, "The top box falls off, and the middle box falls too.")
    assert "middle_box" not in still(told)
    assert not still(first(TOWER, "The tower falls over to the right."))


def test_what_hangs_swings_to_and_fro_without_falling() -> None:
    program = first(LAMP, "The hanging lamp swings from side to side.")
    rollout = simulate(program, {})
    checks = measure(program, rollout)
    assert all(check.ok for check in checks if check.kind != "view")
    path = rollout.positions[:, rollout.index("lamp")]
    assert np.ptp(path[:, 2]) < 0.05 < np.ptp(path[:, 0])


@pytest.mark.parametrize("far", [3.0, 3.6])
def test_what_swings_hits_what_stands_beside_it(far: float) -> None:
    # How far away the lamp hangs no picture tells: as far as what it hits.
    post = (Box(size=(0.06, 0.06, 1.3)), (0.2 * far / 3.0, far, 0.65), "floor")
    stage = Stage("lamp", {**LAMP.objects, "post": post})
    program = first(stage, "The hanging lamp swings to the right and hits the post.")
    lamp = program.scene.object("lamp")
    assert lamp is not None
    assert lamp.position is not None
    assert lamp.position[1] == pytest.approx(far, abs=0.1)
    contacts = [c for c in measure(program, simulate(program, {})) if c.kind == "contacts"]
    assert contacts
    assert all(check.ok for check in contacts), contacts


@pytest.mark.parametrize("near", [1.0, 1.3])
def test_what_falls_from_the_air_lands_where_it_is_seen(near: float) -> None:
    stage = Stage("lamp", {"lamp": (Sphere(radius=0.05), (0.0, near, 1.2), "air")})
    program = first(stage, "The lamp falls down and lands on the floor.")
    camera, lamp = program.scene.camera, program.scene.object("lamp")
    assert camera is not None
    assert lamp is not None
    x, y, _ = lamp.position or (0.0, 0.0, 0.0)
    assert y > near
    # It is seen in the same place, as large, and so is the floor below it.
    before = camera.project(np.array([[0.0, near, 1.2], [0.05, near, 1.2]]))[0]
    assert isinstance(lamp.shape, Sphere)
    after = camera.project(np.add([[0, 0, 0], [lamp.shape.radius, 0, 0]], lamp.position or 0))[0]
    assert np.allclose(before, after, atol=0.5)
    assert camera.project(np.array([[x, y, 0.0]]))[0][0, 1] < camera.size[1]
    # What does not fall stays as far away as it was.
    there = first(stage, "The lamp swings.").scene.object("lamp")
    assert there is not None
    assert there.position == (0.0, near, 1.2)


def test_what_falls_is_no_larger_than_such_things_are() -> None:
    # An apple of twenty centimetres would land in the picture, one of nine falls out of it.
    stage = Stage("apple", {"apple": (Sphere(radius=0.045), (0.0, 1.0, 1.2), "air")})
    apple = first(stage, "The apple falls down.").scene.object("apple")
    assert apple is not None
    assert isinstance(apple.shape, Sphere)
    assert apple.shape.radius < 0.06


def test_what_is_set_down_is_at_rest_where_it_stood() -> None:
    program = first(STAGES["desk"], "The red cube is lifted up and set down again.")
    rollout = simulate(program, {})
    path = rollout.positions[:, rollout.index("red_cube")]
    assert path[:, 2].max() > path[0, 2] + 0.05
    assert np.allclose(path[-1], path[0], atol=5e-3)


def test_off_the_end_is_across_the_length() -> None:
    program = first(BELT, "The can slides off the end of the belt.")
    path = simulate(program, {}).positions[:, 0]
    # It may roll back below the belt, once it has come down beyond its end.
    falling = path[path[:, 2] < 0.5]
    assert falling[0, 0] > 0.6
    assert program.scene.landmark("belt_end") is not None


def test_a_ball_that_spins_in_place_is_seen_to_move() -> None:
    program = first(ALONE, "The ball spins in place.")
    checks = {check.id: check for check in measure(program, simulate(program, {}))}
    assert checks["view.something"].ok
    assert checks["view.fills"].ok
