"""Sentences of people who saw the program for the first time, and what each demands."""

from __future__ import annotations

import pytest

from physagent_studio.agent.rules import RuleGenerator
from physagent_studio.contract.measure import measure
from physagent_studio.contract.words import claim
from physagent_studio.program import PhysicalProgram
from physagent_studio.program.actions import ApplyForce, Directed, OnContact
from physagent_studio.program.scene.state import Box, Cylinder, Sphere
from physagent_studio.simulation import simulate
from tests.agent.rules.everyday_scenes import EVERYDAY
from tests.agent.rules.scenes import STAGES, Stage
from tests.agent.rules.varied_scenes import VARIED

_OWN = (
    Stage("picnic", {
        "lemon": (Sphere(radius=0.035), (-0.5, 2.4, 0.035), "floor"),
        "orange": (Sphere(radius=0.04), (-0.2, 2.2, 0.04), "floor"),
        "basket": (Cylinder(radius=0.15, height=0.2), (0.3, 2.6, 0.1), "floor"),
    }),
    Stage("lawn", {
        "wooden_ball": (Sphere(radius=0.1), (-0.8, 2.2, 0.1), "floor"),
        "front_skittle": (Cylinder(radius=0.05, height=0.3), (0.6, 2.5, 0.15), "floor"),
        "left_skittle": (Cylinder(radius=0.05, height=0.3), (0.4, 2.8, 0.15), "floor"),
        "right_skittle": (Cylinder(radius=0.05, height=0.3), (0.8, 2.8, 0.15), "floor"),
    }),
    Stage("nursery", {
        "pig": (Box(size=(0.2, 0.1, 0.15)), (-0.3, 2.5, 0.075), "floor"),
        "cork_box": (Box(size=(0.2, 0.15, 0.1)), (0.25, 2.5, 0.05), "floor"),
        "green_marble": (Sphere(radius=0.01), (0.05, 2.4, 0.01), "floor"),
        "chair": (Box(size=(0.45, 0.45, 0.9)), (0.7, 3.4, 0.45), "floor"),
    }),
)  # fmt: skip
PLACES = {**STAGES, **EVERYDAY, **VARIED, **{stage.name: stage for stage in _OWN}}


def first(place: str, prompt: str) -> PhysicalProgram:
    """The first program of a sentence over a scene."""
    stage = PLACES[place]
    return RuleGenerator().first(stage.case(prompt), stage.reconstruct)


def claims(program: PhysicalProgram) -> list[str]:
    """What its contract demands, without the parts of other demands."""
    contract = program.contract
    return [claim(s, program) for s in contract.statements if s.id not in contract.serving]


def unread(program: PhysicalProgram) -> list[str]:
    """What is said to be not understood or untested."""
    contract = program.contract
    return [*contract.not_understood, *(clause.text for clause in contract.untested)]


@pytest.mark.parametrize(
    ("place", "prompt", "demands"),
    [
        (
            "picnic",
            "The basket gets knocked onto its side.",
            ["basket topples"],
        ),
        (
            "picnic",
            "A gust blows the basket onto its side.",
            ["basket topples"],
        ),
        (
            "picnic",
            "Someone pushes the basket onto its back.",
            ["basket topples", "basket moves away from the camera"],
        ),
        ("kitchen", "The mug falls onto its side.", ["mug topples"]),
        (
            "kitchen",
            "The mug falls off the table onto its side.",
            ["mug falls", "mug leaves table for good", "mug topples"],
        ),
        (
            "lawn",
            "The left skittle is bowled over by the wooden ball.",
            [
                "wooden_ball touches left_skittle",
                "left_skittle topples",
                "wooden_ball touches left_skittle, before left_skittle topples",
            ],
        ),
        (
            "lawn",
            "The wooden ball rolls past the front skittle and the left one.",
            [
                "wooden_ball moves",
                "wooden_ball passes by front_skittle",
                "wooden_ball passes by left_skittle",
                "wooden_ball turns",
                "wooden_ball does not fly free of any contact",
            ],
        ),
        (
            "nursery",
            "The green marble hits the cork box and bounces back.",
            ["green_marble touches cork_box", "green_marble turns back"],
        ),
        (
            "nursery",
            "The green marble rolls to the chair and bumps against its leg.",
            [
                "green_marble moves towards chair",
                "green_marble turns",
                "green_marble does not fly free of any contact",
                "green_marble touches chair",
            ],
        ),
        (
            "nursery",
            "The green marble hits the leg of the chair.",
            ["green_marble touches chair"],
        ),
        ("nursery", "The chair falls over with a loud crash.", ["chair topples"]),
        (
            "court",
            "The basketball bounces up and down three times on the spot.",
            ["basketball bounces off floor 3 times"],
        ),
        (
            "lamp",
            "The lamp swings to and fro on its chain.",
            ["lamp sways", "lamp does not topple", "lamp sways"],
        ),
        (
            "nursery",
            "The pig leaps on top of the cork box.",
            [
                "pig moves up",
                "pig flies free of any contact",
                "pig rests on cork_box at the end",
                "pig is above cork_box at the end",
                "pig does not topple",
                "pig stands upright at the end",
            ],
        ),
        (
            "slope",
            "The toy car ends up on the floor.",
            ["toy_car rests on floor at the end", "toy_car leaves ramp for good"],
        ),
        (
            "slope",
            "The toy car stops on the ground.",
            ["toy_car stops", "toy_car rests on floor at the end", "toy_car leaves ramp for good"],
        ),
        (
            "boxes",
            "Someone pulls the box b out sideways.",
            ["box_b moves to the left or right"],
        ),
        ("eraser", "The ruler is taken out.", ["ruler moves"]),
        (
            "office",
            "The coffee cup is slid slowly to the left until it touches the stapler.",
            [
                "coffee_cup moves to the left",
                "coffee_cup has the right top speed",
                "coffee_cup does not move up",
                "coffee_cup touches stapler",
                "coffee_cup stands upright at the end",
            ],
        ),
        (
            "fruit_bowl",
            "The pear spins on the spot and then comes to rest.",
            ["pear turns", "pear does not move", "pear rests on table at the end"],
        ),
        (
            "kitchen",
            "The teapot is lifted up a little and then set back down.",
            [
                "teapot moves up",
                "teapot does not move up",
                "teapot falls",
                "teapot reaches table",
            ],
        ),
        (
            "nursery",
            "The chair tips a little to the left.",
            ["chair flips to the left", "chair does not turn"],
        ),
        (
            "kitchen",
            "The teapot is knocked off the table onto its side.",
            ["teapot moves", "teapot leaves table for good", "teapot topples"],
        ),
        (
            "picnic",
            "The basket rolls onto its side.",
            ["basket topples"],
        ),
    ],
)
def test_what_is_demanded(place: str, prompt: str, demands: list[str]) -> None:
    program = first(place, prompt)
    assert claims(program) == demands
    assert not unread(program)


def test_what_falls_onto_its_side_on_a_table_is_tipped_there() -> None:
    (action,) = first("kitchen", "The mug falls onto its side.").event.actions
    assert action.id == "tip_mug"


def test_both_that_are_bowled_over_fall() -> None:
    told = "The wooden ball rolls off and bowls over the front skittle and the left one."
    contract = first("lawn", told).contract
    over = {s.subject for s in contract.statements if s.kind == "topples"}
    assert over == {"front_skittle", "left_skittle"}
    assert not unread(first("fruit_bowl", "Someone pushes the bowl over the edge of the table."))


@pytest.mark.parametrize(
    ("place", "prompt", "told"),
    [
        ("bar", "No: the wine bottle falls over.", ["no"]),
        ("slope", "The toy car rolls up and down the ramp.", ["up … down"]),
    ],
)
def test_what_is_said_to_be_unread(place: str, prompt: str, told: list[str]) -> None:
    assert unread(first(place, prompt)) == told


@pytest.mark.parametrize(
    ("prompt", "least"),
    [
        ("Someone pulls the cushion to the right.", 0.15),
        ("Someone pulls the cushion out to the right.", 0.32),
        ("Someone removes the cushion.", 0.24),
    ],
)
def test_what_is_pulled_out_moves_by_its_own_extent(prompt: str, least: float) -> None:
    (moved,) = first("living", prompt).contract.statements
    assert moved.kind == "moves"
    assert moved.distance == pytest.approx(least, abs=0.01)


def test_sideways_is_where_there_is_room() -> None:
    push = first("boxes", "Someone pulls the box b out sideways.").event.actions[0]
    assert isinstance(push, ApplyForce)
    assert isinstance(push.force, Directed)
    assert push.force.direction == "right"


def test_what_slides_slowly_until_it_touches_is_led_there() -> None:
    told = "The box a is slid slowly to the right until it touches the box b."
    program = first("boxes", told)
    push = program.event.actions[0]
    assert isinstance(push, ApplyForce)
    assert push.point is not None
    assert push.duration > 60
    (pace,) = program.contract.paces
    assert pace.verb == "slide"
    assert pace.high < 1


@pytest.mark.parametrize(
    ("shape", "height"),
    [
        (Cylinder(radius=0.08, height=0.25), 0.25),
        (Cylinder(radius=0.04, height=0.1), 0.1),
        (Box(size=(0.45, 0.45, 0.9)), 0.9),
        (Box(size=(0.4, 0.4, 0.4)), 0.4),
    ],
)
def test_what_rocks_is_seen_to_tilt_and_stays_upright(shape: Box | Cylinder, height: float) -> None:
    yard = Stage("yard", {"crate": (shape, (0.0, 2.5, height / 2), "floor")})
    told = "The crate rocks from side to side but stays upright."
    program = RuleGenerator().first(yard.case(told), yard.reconstruct)
    demanded = [c for c in measure(program, simulate(program, {})) if c.demanded]
    assert all(check.ok for check in demanded if not check.always_on), demanded


def test_what_wobbles_and_then_topples_does_one_after_the_other() -> None:
    program = first("lawn", "The front skittle wobbles, then topples to the right.")
    assert [action.id for action in program.event.actions][-1] == "tip_front_skittle"
    demanded = [c for c in measure(program, simulate(program, {})) if c.demanded]
    assert all(check.ok for check in demanded if not check.always_on), demanded
    sways = next(s for s in program.contract.statements if s.kind == "sways")
    assert sways.to_step == program.clip.steps // 2


def test_what_is_told_to_go_another_way_after_the_blow_is_sent_there() -> None:
    told = "First the lemon rolls into the orange, then the orange rolls up against the basket."
    program = first("picnic", told)
    *_, push = program.event.actions
    assert isinstance(push, ApplyForce)
    assert push.name == "orange"
    assert isinstance(push.when, OnContact)
    assert {push.when.a, push.when.b} == {"lemon", "orange"}
    assert "lemon touches orange, before orange touches basket" in claims(program)


@pytest.mark.parametrize(
    ("prompt", "driven"),
    [
        ("The lemon rolls into the orange, which rolls to the left.", {"lemon"}),
        ("First the lemon rolls into the orange, then the orange rolls to the right.", {"lemon"}),
        (
            "First the lemon rolls into the orange, then the orange rolls away from the camera.",
            {"lemon", "orange"},
        ),
    ],
)
def test_what_the_blow_itself_brings_about_is_left_to_it(prompt: str, driven: set[str]) -> None:
    assert {action.name for action in first("picnic", prompt).event.actions} == driven


def test_of_a_pyramid_that_falls_down_the_top_does() -> None:
    tin = Cylinder(radius=0.04, height=0.11)
    pile = Stage("pile", {
        "top_tin": (tin, (0.0, 2.5, 0.165), "left_tin"),
        "left_tin": (tin, (-0.045, 2.5, 0.055), "floor"),
        "right_tin": (tin, (0.045, 2.5, 0.055), "floor"),
    })  # fmt: skip
    for told in (
        "The pile of tins collapses.",
        "The stack of tins falls down.",
        "A pyramid of tins tumbles down.",
    ):
        program = RuleGenerator().first(pile.case(told), pile.reconstruct)
        assert {*claims(program)} - {"top_tin leaves left_tin for good"} == {"top_tin falls"}


def test_what_is_flicked_is_let_go_at_once_and_may_twirl_as_it_goes() -> None:
    (push,) = first("office", "Someone flicks the stapler to the left.").event.actions
    assert isinstance(push, ApplyForce)
    assert push.duration < 20
    both = first("office", "Somebody flicks the stapler; it twirls around twice and stops.")
    operators = {action.operator for action in both.event.actions}
    assert operators == {"ApplyForce", "SetAngularVelocity"}


def test_what_something_hangs_by_is_no_place_that_needs_a_test() -> None:
    kitchen = Stage("kitchen", {
        "pan": (Box(size=(0.25, 0.03, 0.4)), (0.0, 2.8, 1.4), "air"),
        "hook": (Box(size=(0.03, 0.05, 0.03)), (0.0, 2.8, 1.62), "air"),
    })  # fmt: skip
    told = "The pan swings to and fro on its hook."
    assert not unread(RuleGenerator().first(kitchen.case(told), kitchen.reconstruct))


def test_a_leap_onto_a_thing_comes_down_steeply_and_stays_there() -> None:
    yard = Stage("yard", {
        "crate": (Box(size=(0.9, 0.4, 0.5)), (-0.56, 3.57, 0.25), "floor"),
        "box": (Box(size=(0.55, 0.5, 0.25)), (0.67, 3.65, 0.125), "floor"),
    })  # fmt: skip
    program = RuleGenerator().first(yard.case("The crate jumps onto the box."), yard.reconstruct)
    demanded = [c for c in measure(program, simulate(program, {})) if c.demanded]
    assert all(check.ok for check in demanded if not check.always_on), demanded


@pytest.mark.parametrize(
    "prompt", ["The box a is slowly pushed to the left.", "The box a is pushed slowly to the left."]
)
def test_how_is_read_between_the_parts_of_a_verb(prompt: str) -> None:
    both = (first("boxes", told) for told in (prompt, prompt.replace("slowly ", "")))
    slow, plain = (program.contract.paces[0].high for program in both)
    assert slow < plain


def test_what_is_thrown_at_a_tower_brings_it_down() -> None:
    told = claims(first("toys", "The toy truck is thrown at the tower and it collapses."))
    assert {"toy_truck touches red_block", "green_block falls", "blue_block falls"} <= set(told)
    told = claims(first("living", "Someone throws the ball at the tall vase and it falls over."))
    assert {"tennis_ball touches tall_vase", "tall_vase topples"} <= set(told)
