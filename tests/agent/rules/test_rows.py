"""Things that fall one after another, and what is brought down by the first of them."""

import pytest

from physagent_studio.agent.rules import RuleGenerator
from physagent_studio.agent.rules.scene.measures import Layout
from physagent_studio.language import inventory, read
from physagent_studio.program import PhysicalProgram
from physagent_studio.program.scene.state import Box, Grounding, Sphere
from tests.agent.rules.scenes import Stage
from tests.agent.rules.varied_scenes import VARIED

DOMINOES = ("first_domino", "second_domino", "third_domino", "last_domino")


def _frames(prompt, names=DOMINOES):
    stock = inventory([(name, Grounding()) for name in names], [], [])
    reading = read(prompt, stock)
    assert not reading.not_understood
    return [(f.sense, f.agent, f.patient) for f in reading.frames[:2]]


@pytest.mark.parametrize(
    "prompt",
    [
        "Somebody pushes the first domino and they topple one after another.",
        "The first domino is pushed and they all fall down one by one.",
        "Someone tips the first domino and the rest follow.",
    ],
)
def test_the_first_of_a_row_brings_the_others_down(prompt):
    first, others = DOMINOES[:1], DOMINOES[1:]
    assert _frames(prompt) == [("topple", (), first), ("topple", first, others)]


def test_they_after_two_single_things_are_those_two():
    frames = _frames("The cup stands by the box and they fall over.", ("cup", "box", "ball"))
    assert set(frames[-1][2]) == {"cup", "box"}


def test_what_follows_without_an_object_does_the_same():
    frames = _frames("The hammer falls and the can follows.", ("hammer", "can"))
    assert frames == [("fall", (), ("hammer",)), ("fall", (), ("can",))]


@pytest.mark.parametrize(
    ("prompt", "hops"),
    [
        ("The ping pong ball bounces twice and then hits the middle cup.", True),
        ("The ping pong ball rolls to the middle cup, hits it and bounces back.", False),
        ("The ping pong ball hits the middle cup without bouncing.", False),
    ],
)
def test_only_what_bounces_before_it_hits_something_hops_there(prompt, hops):
    stage = VARIED["cups"]
    program = RuleGenerator().first(stage.case(prompt), stage.reconstruct)
    labels = [action.id for action in program.event.actions]
    assert any(label.startswith("jump") for label in labels) == hops, labels


ROW = Stage(
    "row",
    {"ball": (Sphere(radius=0.03), (-0.4, 3.0, 0.03), "floor")}
    | {
        name: (Box(size=(0.02, depth, 0.1)), (0.05 * k - 0.1, 3.0, 0.05), "floor")
        for k, (name, depth) in enumerate(zip(DOMINOES, (0.05, 0.046, 0.05, 0.02), strict=True))
    },
)


@pytest.mark.parametrize(
    ("prompt", "order"),
    [
        (
            "The ball rolls to the right and knocks over the first domino, and the dominoes fall "
            "one after another.",
            DOMINOES,
        ),
        ("The dominoes topple one after another.", DOMINOES),
        (
            "The last domino is pushed to the left, and the dominoes fall one after another.",
            DOMINOES[::-1],
        ),
    ],
)
def test_a_row_goes_over_from_the_one_that_is_struck(prompt, order):
    program = RuleGenerator().first(ROW.case(prompt), ROW.reconstruct)
    wave = next(s for s in program.contract.statements if s.kind == "in_turn")
    parts = {s.id: s.subject for s in program.contract.statements if s.kind == "topples"}
    assert tuple(parts[one] for one in wave.of) == order
    assert wave.ordered
    assert wave.apart < 0.03


def _depth(program: PhysicalProgram, name: str) -> float:
    item = program.scene.object(name)
    assert item is not None
    assert isinstance(item.shape, Box)
    return item.shape.size[1]


def test_blocks_of_one_kind_are_equally_deep_as_far_as_their_looks_allow():
    program = RuleGenerator().first(ROW.case("The dominoes fall."), ROW.reconstruct)
    layout = Layout(program.scene)
    # The last one would look taller from above.
    depths = [_depth(program, name) for name in DOMINOES]
    assert depths == [0.05, 0.05, 0.05, 0.02]
    # Their fronts stay where they are seen.
    fronts = [layout.position(n)[1] - d / 2 for n, d in zip(DOMINOES, depths, strict=True)]
    assert fronts == pytest.approx([2.975, 2.977, 2.975, 2.99])


def test_what_is_no_copy_of_another_block_keeps_its_depth():
    stage = Stage(
        "blocks",
        {
            "red_block": (Box(size=(0.1, 0.1, 0.1)), (-0.5, 3.0, 0.05), "floor"),
            "blue_block": (Box(size=(0.2, 0.04, 0.1)), (0.1, 3.0, 0.05), "floor"),
            "box": (Box(size=(0.1, 0.05, 0.1)), (0.6, 3.0, 0.05), "floor"),
        },
    )
    program = RuleGenerator().first(stage.case("The box slides to the left."), stage.reconstruct)
    depths = {item.name: _depth(program, item.name) for item in program.scene.objects}
    assert depths == {"red_block": 0.1, "blue_block": 0.04, "box": 0.05}


def test_what_strikes_a_row_and_is_none_of_it_need_not_fall_over():
    stage = Stage(
        "lane",
        {
            "marble": (Sphere(radius=0.02), (-0.6, 2.6, 0.02), "floor"),
            **{
                f"domino_{k + 1}": (
                    Box(size=(0.02, 0.06, 0.12)), (-0.3 + 0.07 * k, 2.6, 0.06), "floor"
                )
                for k in range(4)
            },
        },
    )  # fmt: skip
    prompt = "The marble rolls into the first domino and starts a chain reaction."
    program = RuleGenerator().first(stage.case(prompt), stage.reconstruct)
    fallen = {s.subject for s in program.contract.statements if s.kind == "topples"}
    assert fallen
    assert "marble" not in fallen
