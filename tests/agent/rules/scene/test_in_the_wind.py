"""What the wind takes off a thing is not held to it; what it only moves is."""

from __future__ import annotations

import pytest

from physagent_studio.agent.rules import RuleGenerator
from physagent_studio.contract import measure
from physagent_studio.language import inventory, read
from physagent_studio.program import Grounding
from physagent_studio.program.scene.state import Box, Frustum, Slab
from physagent_studio.simulation import simulate
from tests.agent.rules.scenes import Stage

STAGE = Stage(
    "terrace",
    {
        "potted_plant": (
            Frustum(bottom_radius=0.06, top_radius=0.09, height=0.3),
            (0.2, 2.5, 0.9),
            "table",
        ),
        "flag": (Box(size=(0.5, 0.01, 0.3)), (-0.9, 2.5, 0.15), "floor"),
    },
    {"table": Slab(position=(0.0, 2.5, 0.375), size=(1.2, 0.7, 0.75))},
)


@pytest.mark.parametrize(
    ("prompt", "name", "held"),
    [
        ("A gust of wind blows the potted plant off the table.", "potted_plant", False),
        ("The wind carries the potted plant away.", "potted_plant", False),
        ("The potted plant sways in the wind.", "potted_plant", True),
        ("The wind blows on the potted plant.", "potted_plant", True),
        ("The wind from the table moves the potted plant.", "potted_plant", True),
        ("The wind carries the flag away to the right.", "flag", False),
        ("The flag flutters in the wind.", "flag", True),
    ],
)
def test_the_wind_takes_off_what_is_not_held(prompt: str, name: str, held: bool) -> None:
    program = RuleGenerator().first(STAGE.case(prompt), STAGE.reconstruct)
    item = program.scene.object(name)
    assert item is not None
    assert (getattr(item.body, "pinned", "none") != "none") == held


def test_a_pot_that_is_not_held_is_moved_by_a_gust() -> None:
    case = STAGE.case("A gust of wind blows the potted plant off the table.")
    program = RuleGenerator().first(case, STAGE.reconstruct)
    rollout = simulate(program)
    told = [check for check in measure(program, rollout) if check.clause is not None]
    assert told
    moved = rollout.positions[-1, 0] - rollout.positions[0, 0]
    assert abs(moved[0]) > 0.05


@pytest.mark.parametrize(
    ("prompt", "way"),
    [
        ("The wind blows the flag to the right and the potted plant topples over.", "right"),
        ("A gust from the right moves the flag, and the potted plant tips over.", "left"),
        (
            "The wind blows the flag to the right and the potted plant tips over to the left.",
            "left",
        ),
        ("The wind moves the flag and the potted plant topples over.", None),
    ],
)
def test_what_goes_over_in_the_wind_goes_its_way(prompt: str, way: str | None) -> None:
    things = [("flag", Grounding()), ("potted_plant", Grounding())]
    frame = next(f for f in read(prompt, inventory(things)).frames if f.sense == "topple")
    assert (frame.direction or frame.origin) == way
