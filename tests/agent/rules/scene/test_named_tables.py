"""Tables that the prompt alone names: a support where something leaves them, else the ground."""

import pytest

from physagent_studio.agent.rules.generator import open_scene, stock_of
from physagent_studio.agent.rules.scene.named_tables import surface_left
from physagent_studio.language import read
from physagent_studio.program.scene.state import Click, Grounding, Support
from physagent_studio.records import Case

CLICKED = Grounding(points=(Click(x=10, y=10),))


def case(prompt: str, *supports: str, things: tuple[str, ...] = ("red_ball", "cup")) -> Case:
    objects = tuple((name, CLICKED) for name in things)
    given = tuple(Support(name=name, grounding=CLICKED) for name in supports)
    return Case("x", None, "", objects, given, (), prompt)


@pytest.mark.parametrize(
    ("prompt", "surface"),
    [
        ("The cup is pushed off the table.", "table"),
        ("The cup slides across the desk and falls to the floor.", "desk"),
        ("The red ball rolls off the edge of the counter.", "counter"),
        ("The red ball rolls to the table edge and falls.", "table"),
        ("The red ball leaves the shelf.", "shelf"),
        ("A gust blows the cup from the windowsill.", "windowsill"),
        ("The cup tips over on the table.", None),
        ("The red ball rolls across the table to the right.", None),
        ("The red ball bounces off the table.", None),
        ("The cup falls over onto the floor.", None),
    ],
)
def test_what_is_left_is_a_support(prompt: str, surface: str | None):
    assert surface_left(case(prompt)) == surface


def test_a_support_of_the_case_needs_no_second_one():
    assert surface_left(case("The cup is pushed off the table.", "kitchen_table")) is None
    assert surface_left(case("The cup slides down the ramp and off the table.", "ramp")) is None
    assert surface_left(case("The cup is pushed off the table.", "wooden_floor")) == "table"


def test_a_table_that_is_itself_a_thing_is_no_support():
    prompt = "The cup is pushed off the table."
    assert surface_left(case(prompt, things=("cup", "small_table"))) is None


def test_the_scene_has_the_table_and_the_ground_below_it():
    asked = case("The cup is pushed off the table.")
    stock = stock_of(asked)
    state = open_scene(asked, read(asked.prompt, stock), stock)
    assert [item.name for item in state.supports] == ["table", "floor"]
    place = read(asked.prompt, stock).frames[0].place("off")
    assert place is not None
    assert place.name == "table"
