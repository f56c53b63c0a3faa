"""Things that fall one after another, and what is brought down by the first of them."""

import pytest

from physagent_studio.agent.rules import RuleGenerator
from physagent_studio.language import inventory, read
from physagent_studio.program.scene.state import Grounding
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
