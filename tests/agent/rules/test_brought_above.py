"""What stands elsewhere is dropped from a hand, pulled from under, hit where it stands higher."""

from __future__ import annotations

import numpy as np
import pytest

from physagent_studio.agent.rules import RuleGenerator
from physagent_studio.contract.measure import measure
from physagent_studio.language import inventory, read
from physagent_studio.program import PhysicalProgram
from physagent_studio.program.scene.state import Box, Cylinder, Grounding, Ramp, Slab, Sphere
from physagent_studio.records import Rollout
from physagent_studio.simulation import simulate
from tests.agent.rules.scenes import Stage

DESK = Stage(
    "desk_with_fruit",
    {
        "cup": (Cylinder(radius=0.04, height=0.1), (-0.3, 3.1, 0.05), "floor"),
        "book": (Box(size=(0.2, 0.15, 0.04)), (0.35, 3.2, 0.02), "floor"),
        "ball": (Sphere(radius=0.035), (0.15, 2.7, 0.035), "floor"),
        "apple": (Sphere(radius=0.04), (0.37, 3.2, 0.08), "book"),
    },
)


def _run(prompt: str) -> tuple[PhysicalProgram, Rollout]:
    program = RuleGenerator().first(DESK.case(prompt), DESK.reconstruct)
    assert not program.contract.untested
    return program, simulate(program, {})


def _missed(prompt: str) -> list[str]:
    program, rollout = _run(prompt)
    checks = measure(program, rollout)
    return [c.text for c in checks if c.demanded and c.kind != "view" and not c.ok]


@pytest.mark.parametrize(
    "prompt",
    [
        "The ball is dropped from above onto the book.",
        "The ball drops into the cup.",
        "The apple falls into the cup.",
        "The book is pulled out from under the apple.",
        "The ball hits the apple.",
        "The ball rolls out of the picture.",
        "The ball bounces twice and rolls away to the left.",
    ],
)
def test_the_first_program_does_what_is_told(prompt: str) -> None:
    assert _missed(prompt) == []


def test_what_is_pulled_from_under_a_thing_leaves_it_where_it_was() -> None:
    _, rollout = _run("The book is pulled out from under the apple.")
    way = {n: rollout.positions[:, rollout.index(n)] for n in ("book", "apple")}
    gone = {name: float(np.linalg.norm((path[-1] - path[0])[:2])) for name, path in way.items()}
    assert gone["book"] > 2 * gone["apple"]
    assert way["apple"][-1, 2] < way["apple"][0, 2] - 0.03


LANE = Stage(
    "lane_with_a_car",
    {
        "toy_car": (Box(size=(0.12, 0.06, 0.05)), (-0.4, 3.1, 0.025), "floor"),
        "bottle": (Cylinder(radius=0.035, height=0.25), (0.1, 3.1, 0.125), "floor"),
    },
)


@pytest.mark.parametrize(
    "prompt",
    [
        "The toy car reverses, then drives straight into the bottle.",
        "The toy car backs up and then drives forward again.",
    ],
)
def test_what_backs_up_first_goes_on_front_first(prompt: str) -> None:
    program = RuleGenerator().first(LANE.case(prompt), LANE.reconstruct)
    rollout = simulate(program, {})
    x = rollout.positions[:, rollout.index("toy_car"), 0]
    assert x.min() < x[0] - 0.03
    assert x[-1] > x.min() + 0.05
    wheels = [c for c in measure(program, rollout) if "wheels" in c.id]
    assert wheels
    assert all(check.ok for check in wheels)


def test_what_has_wheels_does_not_fly_at_what_stands_higher() -> None:
    stage = Stage(
        "car_before_a_stack",
        {
            "toy_car": (Box(size=(0.12, 0.06, 0.05)), (-0.4, 3.1, 0.025), "floor"),
            "red_block": (Box(size=(0.1, 0.1, 0.1)), (0.1, 3.1, 0.05), "floor"),
            "blue_block": (Box(size=(0.1, 0.1, 0.1)), (0.1, 3.1, 0.15), "red_block"),
        },
    )
    program = RuleGenerator().first(
        stage.case("The toy car bumps into the blue block."), stage.reconstruct
    )
    rollout = simulate(program, {})
    height = rollout.positions[:, rollout.index("toy_car"), 2]
    assert height.max() < 0.06


def test_what_bounces_back_went_there_front_first() -> None:
    prompt = "The toy car crashes head-on into the bottle and bounces back."
    program = RuleGenerator().first(LANE.case(prompt), LANE.reconstruct)
    assert program.contract.backwards == ()


SHELF = Stage(
    "table_beside_a_ramp",
    {
        "ball": (Sphere(radius=0.05), (-0.3, 2.4, 0.8), "table"),
        "marble": (Sphere(radius=0.05), (0.856, 2.5, 0.265), "ramp"),
        "tin": (Cylinder(radius=0.04, height=0.12), (-0.95, 2.3, 0.06), "floor"),
        "box": (Box(size=(0.1, 0.1, 0.1)), (-0.95, 2.6, 0.05), "floor"),
    },
    {
        "table": Slab(position=(0.0, 2.5, 0.375), size=(1.2, 0.8, 0.75)),
        "ramp": Ramp(toe=(1.6, 2.5, 0.0), yaw=float(np.pi), run=1.0, rise=0.3, width=0.5),
    },
)


@pytest.mark.parametrize(
    ("prompt", "name"),
    [
        ("The ball jumps from the table onto the floor.", "ball"),
        ("The box is lifted and placed next to the tin.", "box"),
    ],
)
def test_it_comes_down_where_it_is_told(prompt: str, name: str) -> None:
    program = RuleGenerator().first(SHELF.case(prompt), SHELF.reconstruct)
    rollout = simulate(program, {})
    missed = [c for c in measure(program, rollout) if c.demanded and c.kind != "view" and not c.ok]
    assert not missed, [check.text for check in missed]
    assert rollout.positions[-1, rollout.index(name), 2] < 0.06


def test_what_lies_on_a_slope_and_is_told_nothing_of_stays_there() -> None:
    program = RuleGenerator().first(SHELF.case("The tin falls over."), SHELF.reconstruct)
    rollout = simulate(program, {})
    assert np.ptp(rollout.positions[:, rollout.index("marble")], axis=0).max() < 1e-3


def test_what_is_told_after_comes_first() -> None:
    things = [("bottle", Grounding())]
    said = read("The bottle rolls away after it has been knocked over.", inventory(things))
    assert [frame.sense for frame in said.frames] == ["knock_over", "roll"]
    assert said.frames[1].sequel
