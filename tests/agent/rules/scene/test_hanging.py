"""What hangs in the air: by the words, or by the clicks where a thing falls into another one."""

from __future__ import annotations

import pytest

from physagent_studio.agent.rules.generator import stock_of
from physagent_studio.agent.rules.scene.hanging import from_nowhere, in_the_air, may_hang
from physagent_studio.agent.rules.scene.measures import Layout
from physagent_studio.language import read
from physagent_studio.program.scene.state import (
    Box,
    Click,
    Floor,
    Grounding,
    SceneObject,
    SceneState,
    Support,
)
from physagent_studio.records import Case


def _at(x: float, y: float) -> Grounding:
    return Grounding(points=(Click(x=x, y=y),))


def _case(prompt: str, **more: Grounding) -> Case:
    objects = {"green_ball": _at(300, 60), "blue_bowl": _at(310, 300), "red_ball": _at(80, 310)}
    things = tuple((objects | more).items())
    table = Support(name="table", grounding=_at(320, 400))
    return Case("bowl", None, "", things, (table,), (), prompt)


@pytest.mark.parametrize(
    ("prompt", "expected"),
    [
        ("The green ball falls into the bowl.", {"green_ball"}),
        ("The green ball drops into the blue bowl and stays there.", {"green_ball"}),
        ("The green ball lands in the bowl.", {"green_ball"}),
        ("The green ball hangs above the bowl, then falls.", {"green_ball"}),
        ("The red ball falls into the bowl.", set()),
        ("The green ball falls to the floor.", set()),
        ("The blue bowl falls onto the table.", {"blue_bowl"}),
        ("The blue bowl falls off the table onto the floor.", set()),
        ("The red ball rolls to the right.", set()),
    ],
)
def test_what_falls_into_a_thing_below_it_hangs(prompt: str, expected: set[str]) -> None:
    case = _case(prompt)
    assert in_the_air(case, read(prompt, stock_of(case))) == expected


def test_with_something_in_between_it_may_stand_on_that() -> None:
    case = _case("The green ball falls into the bowl.", wooden_shelf=_at(302, 120))
    assert in_the_air(case, read(case.prompt, stock_of(case))) == frozenset()


@pytest.mark.parametrize(
    ("prompt", "hangs"),
    [
        ("The mug slips off its hook and falls onto the worktop.", True),
        ("The mug slips and falls onto the worktop.", True),
        ("The mug slides to the left and falls onto the worktop.", False),
    ],
)
def test_what_slips_from_what_is_not_marked_hangs_above_any_part_of_a_box(
    prompt: str, hangs: bool
) -> None:
    worktop = Grounding(points=(Click(x=384, y=707),), box=(0, 640, 768, 910))
    mug = Grounding(box=(107, 356, 205, 443))
    worktops = (Support(name="worktop", grounding=worktop),)
    case = Case("hook", None, "", (("mug", mug),), worktops, (), prompt)
    assert in_the_air(case, read(prompt, stock_of(case))) == ({"mug"} if hangs else frozenset())


BRICK, PILLAR = (0.2, 0.1, 0.06), (0.1, 0.1, 0.3)


@pytest.mark.parametrize(
    ("size", "prompt", "hung"),
    [
        (BRICK, "The box falls to the ground.", True),
        (BRICK, "The box falls.", True),
        (PILLAR, "The box falls to the ground.", False),
        (BRICK, "The box slides to the right and falls.", False),
        (BRICK, "The box does not fall.", False),
    ],
)
def test_what_falls_and_cannot_fall_over_hung(
    size: tuple[float, float, float], prompt: str, hung: bool
) -> None:
    box = SceneObject(
        name="box", shape=Box(size=size), position=(0, 4, size[2] / 2), support="floor"
    )
    state = SceneState(objects=(box,), supports=(Support(name="floor", shape=Floor()),))
    case = Case("box", None, "", (("box", _at(300, 60)),), (), (), prompt)
    reading = read(prompt, stock_of(case))
    assert from_nowhere(case, reading, Layout(state)) == ({"box"} if hung else set())


@pytest.mark.parametrize(
    ("prompt", "expected"),
    [
        ("The green ball flies in an arc to the right and lands beside the bowl.", {"green_ball"}),
        ("The green ball is thrown to the right and lands beside the bowl.", set()),
        ("The green ball flies to the right.", set()),
        ("The red ball flies in an arc to the right and lands beside the bowl.", set()),
    ],
)
def test_what_flies_off_over_a_thing_may_hang(prompt: str, expected: set[str]) -> None:
    case = _case(prompt)
    ground = Support(name="floor", shape=Floor())
    objects = tuple(
        SceneObject(
            name=name, shape=Box(size=(0.1, 0.1, 0.1)), position=(0.3 * k, 3, 0.05), support="floor"
        )
        for k, (name, _) in enumerate(case.objects)
    )
    layout = Layout(SceneState(objects=objects, supports=(ground,)))
    assert may_hang(case, read(prompt, stock_of(case)), layout) == expected
