"""What is hit goes on by the blow: nothing else pushes it, and the blow is as hard as it needs."""

from __future__ import annotations

import math

import pytest

from physagent_studio.agent.rules import RuleGenerator
from physagent_studio.agent.rules.scene.measures import Layout
from physagent_studio.contract import measure
from physagent_studio.language import inventory, read
from physagent_studio.program.actions import Directed
from physagent_studio.program.scene.state import (
    Box,
    Click,
    Cylinder,
    Frustum,
    Grounding,
    SceneObject,
    SceneState,
    Sphere,
)
from physagent_studio.simulation import simulate
from tests.agent.rules.everyday_scenes import EVERYDAY
from tests.agent.rules.scenes import STAGES, Stage


def _driven(stage_name: str, prompt: str) -> dict[str, float]:
    """Names of what is pushed, with the speeds."""
    stage = STAGES[stage_name]
    program = RuleGenerator().first(stage.case(prompt), stage.reconstruct)
    return {
        a.name: getattr(getattr(a, "force", None), "magnitude", 0.0) for a in program.event.actions
    }


@pytest.mark.parametrize(
    "prompt",
    [
        "The bowling ball hits the middle pin, which slides a little.",
        "The bowling ball bumps into the middle pin and the pin slides away.",
        "The bowling ball hits the middle pin, making it roll to the right.",
        "The bowling ball hits the middle pin and it falls over.",
        "The bowling ball hits the left pin and only the first two pins fall.",
    ],
)
def test_what_is_hit_is_not_pushed_as_well(prompt: str) -> None:
    assert set(_driven("lane", prompt)) == {"bowling_ball"}


def test_a_group_is_hit_in_its_middle() -> None:
    """The first of three stands aside of the line to the middle of them all."""
    spots = {"red_pin": (0.3, 3.0), "blue_pin": (0.0, 3.3), "green_pin": (0.3, 3.6)}
    pins = {
        name: (Cylinder(radius=0.05, height=0.3), (x, y, 0.15), "floor")
        for name, (x, y) in spots.items()
    }
    stage = Stage("lawn", {"ball": (Sphere(radius=0.1), (0.0, 2.0, 0.1), "floor"), **pins})
    prompt = "The ball rolls into the pins and they all fall."
    program = RuleGenerator().first(stage.case(prompt), stage.reconstruct)
    force = getattr(program.event.actions[0], "force", None)
    assert isinstance(force, Directed)
    aims = [math.degrees(math.atan2(x, y - 2)) for x, y in (spots[str(force.toward)], (0.2, 3.3))]
    assert force.azimuth == pytest.approx(aims[0] - aims[1], abs=0.01)


@pytest.mark.parametrize(
    ("ball", "said", "meant"),
    [
        (100, "the first two dominoes", ("red_domino", "blue_domino")),
        (900, "the first two dominoes", ("green_domino", "blue_domino")),
        (100, "the last two dominoes", ("blue_domino", "green_domino")),
        (900, "the last two dominoes", ("blue_domino", "red_domino")),
    ],
)
def test_a_row_is_counted_from_what_hits_it(ball: int, said: str, meant: tuple[str, ...]) -> None:
    places = {"green_domino": 580, "red_domino": 400, "blue_domino": 460, "ball": ball}
    clicks = [(n, Grounding(points=(Click(x=x, y=200),))) for n, x in places.items()]
    reading = read(f"The ball rolls and knocks over {said}.", inventory(clicks, [], []))
    assert set(reading.frames[-1].patient) == set(meant)


@pytest.mark.parametrize(
    "prompt",
    [
        "The scooter rolls toward the trash can, hits it, and both fall over.",
        "The scooter hits the trash can and they both topple.",
    ],
)
def test_what_strikes_is_pushed_though_it_falls_as_well(prompt: str) -> None:
    assert set(_driven("yard", prompt)) == {"scooter"}


def test_what_moves_before_it_is_hit_is_pushed() -> None:
    prompt = "The middle pin slides to the left and is then hit by the bowling ball."
    assert set(_driven("lane", prompt)) == {"middle_pin", "bowling_ball"}


def test_a_touch_is_gentler_than_a_knock() -> None:
    touched = _driven("lane", "The bowling ball rolls slowly and touches the middle pin.")
    knocked = _driven("lane", "The bowling ball rolls slowly and knocks over the middle pin.")
    assert touched["bowling_ball"] < knocked["bowling_ball"]


def test_an_open_vessel_weighs_as_its_walls() -> None:
    cup = Frustum(bottom_radius=0.05, top_radius=0.07, height=0.1, wall=0.005)
    crate = Box(size=(0.3, 0.3, 0.2), wall=0.01)
    things = tuple(
        SceneObject(name=name, shape=shape, position=(0, 0, 0), material="ceramic")
        for name, shape in (
            ("cup", cup), ("solid", cup.model_copy(update={"wall": None})),
            ("crate", crate), ("block", crate.model_copy(update={"wall": None})),
        )
    )  # fmt: skip
    layout = Layout(SceneState(objects=things))
    assert layout.mass("cup") < 0.3 * layout.mass("solid")
    boards = 0.3 * 0.3 * 0.01 + 2 * (0.3 + 0.28) * 0.01 * 0.19
    assert layout.mass("crate") / layout.mass("block") == pytest.approx(boards / 0.018)


def test_a_blow_carries_over_the_edge_what_shall_roll_off() -> None:
    stage = EVERYDAY["pool"]
    speeds = {}
    for said in ("rolls away", "rolls off the table"):
        prompt = f"The white ball hits the black ball, which {said}."
        program = RuleGenerator().first(stage.case(prompt), stage.reconstruct)
        checks = measure(program, simulate(program, {}))
        assert all(c.ok for c in checks if c.demanded and not c.always_on), said
        # As fast as that takes is no faster than the verb allows.
        assert all(c.ok for c in checks if c.id.startswith("view.amount")), said
        (push,) = program.event.actions
        speeds[said] = push.model_dump()["force"]["magnitude"]
    assert speeds["rolls off the table"] > speeds["rolls away"]


def test_two_that_roll_off_go_no_faster_than_rolling_takes() -> None:
    stage = STAGES["fruit"]
    prompt = "The two apples both roll off the table."
    program = RuleGenerator().first(stage.case(prompt), stage.reconstruct)
    assert all(check.ok for check in measure(program, simulate(program, {})))


def test_what_stands_on_a_table_bounces_there() -> None:
    stage = EVERYDAY["pool"]
    prompt = "The white ball bounces twice and hits the black ball."
    program = RuleGenerator().first(stage.case(prompt), stage.reconstruct)
    (bounce,) = (s for s in program.contract.statements if s.kind == "bounces")
    assert bounce.other == "pool_table"


def test_what_goes_on_over_the_edge_may_fly_there() -> None:
    stage = STAGES["fruit"]
    for said, flies in (("both roll off the table", True), ("pushes it off the table", False)):
        prompt = f"The left apple rolls into the right apple and {said}."
        program = RuleGenerator().first(stage.case(prompt), stage.reconstruct)
        kept = [s for s in program.contract.statements if s.kind == "airborne" and s.negated]
        assert any(s.subject == "left_apple" for s in kept) is not flies


@pytest.mark.parametrize(
    "prompt",
    [
        "The phone shoots backwards across the table and knocks over the glass.",
        "The phone slides backwards into the glass.",
    ],
)
def test_backwards_of_what_has_no_front_is_to_what_it_shall_meet(prompt: str) -> None:
    things = {
        "phone": (Box(size=(0.08, 0.15, 0.01)), (-0.1, 2.3, 0.755), "table"),
        "glass": (Cylinder(radius=0.03, height=0.12), (0.0, 2.7, 0.81), "table"),
    }
    stage = Stage("desk", things, STAGES["desk"].supports)
    program = RuleGenerator().first(stage.case(prompt), stage.reconstruct)
    (action,) = program.event.actions
    assert isinstance(force := getattr(action, "force", None), Directed)
    assert (force.toward, force.direction, force.elevation) == ("glass", None, 0.0)
    assert program.contract.backwards == ()
    checks = [c for c in measure(program, simulate(program, {})) if c.clause is not None]
    assert all(check.ok for check in checks), checks


def test_backwards_without_an_aim_is_towards_who_looks_at_it() -> None:
    stage = STAGES["desk"]
    program = RuleGenerator().first(stage.case("The red cube slides backwards."), stage.reconstruct)
    ways = {getattr(s, "direction", None) for s in program.contract.statements if s.kind == "moves"}
    assert "toward_camera" in ways
