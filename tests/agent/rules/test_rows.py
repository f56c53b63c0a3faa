"""Things that fall one after another, and what is brought down by the first of them."""

import pytest

from physagent_studio.language import inventory, read
from physagent_studio.program.scene.state import Grounding

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
