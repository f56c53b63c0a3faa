"""What a wind does to what gives way: plants, flags and curtains, in one round."""

from __future__ import annotations

import numpy as np
import pytest

from physagent_studio.agent.rules import RuleGenerator
from physagent_studio.contract import measure
from physagent_studio.program import PhysicalProgram
from physagent_studio.program.scene.state import Box, Ellipsoid
from physagent_studio.simulation import simulate
from tests.agent.rules.scenes import Stage

THINGS = {
    "tree": (Ellipsoid(radii=(1.5, 1.5, 1.6)), (0.0, 9.0, 1.6), "floor"),
    "flower": (Ellipsoid(radii=(0.06, 0.06, 0.2)), (0.6, 3.0, 0.2), "floor"),
    "flag": (Box(size=(0.9, 0.01, 0.6)), (-1.0, 6.0, 1.5), "air"),
    "curtain": (Box(size=(0.8, 0.02, 1.2)), (1.5, 6.0, 0.9), "air"),
}


def written(prompt: str) -> tuple[PhysicalProgram, str]:
    """The first program for the thing that the prompt speaks of, and its name."""
    name = next(name for name in THINGS if name in prompt)
    stage = Stage("garden", {name: THINGS[name]})
    return RuleGenerator().first(stage.case(prompt), stage.reconstruct), name


@pytest.mark.parametrize(
    ("prompt", "least"),
    [
        ("A strong gust of wind makes the tree sway.", 0.1),
        ("The tree sways gently in the breeze.", 0.0),
        ("The flower bends in the wind.", 0.05),
        ("The flag waves in a strong wind.", 0.1),
    ],
)
def test_the_wind_moves_what_gives_way(prompt: str, least: float) -> None:
    program, name = written(prompt)
    rollout = simulate(program, {})
    checks = measure(program, rollout)
    assert all(check.ok for check in checks), [check.text for check in checks if not check.ok]
    moved = rollout.positions[:, rollout.index(name)]
    assert np.linalg.norm(moved - moved[0], axis=1).max() > least


@pytest.mark.parametrize(
    ("prompt", "material", "pinned"),
    [
        ("The tree bends in the wind.", "foliage", "bottom"),
        ("The flag waves in the wind to the left.", "fabric", "right"),
        ("The curtain sways in the wind.", "fabric", "top"),
        ("The tree falls over.", "wood", None),
    ],
)
def test_a_plant_is_light_and_a_flag_is_held_at_its_pole(
    prompt: str, material: str, pinned: str | None
) -> None:
    program, name = written(prompt)
    item = program.scene.object(name)
    assert item is not None
    assert item.material == material
    assert getattr(item.body, "pinned", None) == pinned
    if name in ("flag", "curtain"):
        ways = [getattr(action, "direction", "") for action in program.event.actions]
        assert ways == ["left" if name == "flag" else "away"]


def test_a_wind_knocks_all_over_to_one_side_at_once() -> None:
    cones = {
        "left_cone": (Box(size=(0.2, 0.2, 0.5)), (-0.7, 4.0, 0.25), "floor"),
        "right_cone": (Box(size=(0.2, 0.2, 0.5)), (0.1, 4.5, 0.25), "floor"),
    }
    stage = Stage("road", cones)
    program = RuleGenerator().first(stage.case("Wind knocks both cones over."), stage.reconstruct)
    starts = {action.start_step for action in program.event.actions}
    rollout = simulate(program, {})
    sides = {np.sign(rollout.positions[-1, i, 0] - rollout.positions[0, i, 0]) for i in (0, 1)}
    assert len(starts) == len(sides) == 1


@pytest.mark.parametrize(
    ("prompt", "side"),
    [
        (
            "A gust blows the man off his feet and he falls flat on the grass, to the right.",
            1,
        ),
        ("A gust of wind pushes the man to the left until he falls over.", -1),
        ("A gust of wind blows and the man topples to the right.", 1),
    ],
)
def test_what_the_wind_shall_fell_is_tipped_at_its_top(prompt: str, side: int) -> None:
    man = (Box(size=(0.5, 0.3, 1.7)), (-0.5, 6.0, 0.85), "floor")
    stage = Stage("field", {"man": man})
    program = RuleGenerator().first(stage.case(prompt), stage.reconstruct)
    assert [action.id for action in program.event.actions] == ["tip_man"]
    rollout = simulate(program, {})
    checks = [c for c in measure(program, rollout) if c.demanded and not c.always_on]
    assert all(check.ok for check in checks), checks
    assert side * (rollout.positions[-1, 0, 0] - rollout.positions[0, 0, 0]) > 0.3


def test_the_wind_still_carries_what_it_does_not_fell() -> None:
    things = {
        "cone": (Box(size=(0.2, 0.2, 0.5)), (-0.7, 4.0, 0.25), "floor"),
        "leaf": (Box(size=(0.2, 0.2, 0.05)), (0.3, 4.0, 0.025), "floor"),
    }
    stage = Stage("road", things)
    prompt = "The wind blows, the leaf drifts to the right and the cone topples."
    program = RuleGenerator().first(stage.case(prompt), stage.reconstruct)
    assert {action.id for action in program.event.actions} == {"wind_leaf", "tip_cone"}
