"""Free words to the planner: what they do, what they offer, and that nothing is done silently."""

from __future__ import annotations

from pathlib import Path

import pytest
import yaml

from physagent_studio.agent.rules.planner.asked import SAID, Change, as_said, understood
from physagent_studio.agent.rules.planner.overruled import demands
from physagent_studio.agent.rules.planner.parameters import (
    action_knobs,
    material_knobs,
    time_knobs,
)
from physagent_studio.benchmark.events.words import bench, outcome, program_of
from physagent_studio.language.wishes import wishes
from physagent_studio.program.edits import apply
from physagent_studio.records import Case

FILE = Path(__file__).parents[3] / "data" / "free_words.yaml"


@pytest.fixture(scope="module")
def told():
    return yaml.safe_load(FILE.read_text(encoding="utf-8"))


def test_most_words_do_what_is_meant_or_offer_it_and_none_does_something_else() -> None:
    rows = bench(FILE)
    assert all(row.ok for row in rows if row.bound), [row for row in rows if not row.ok]


def test_every_offer_is_understood_as_just_itself(told) -> None:
    for name, one in told["programs"].items():
        program = program_of(one)
        for knob in (*action_knobs(program), *material_knobs(program), *time_knobs(program)):
            if knob.factor not in SAID:
                continue
            action = knob.path.split(".")[2] if knob.path.startswith("event") else knob.target
            owner = "" if knob.factor == "pace" else action
            for sign in (1, -1):
                said = as_said(Change(knob, owner, sign))
                found = understood(program, said).changes
                assert [(x.knob.path, x.sign) for x in found] == [(knob.path, sign)], (name, said)


@pytest.mark.parametrize(
    ("words", "quantity", "sign"),
    [
        ("later", "time", 1),
        ("too late", "time", -1),
        ("not so late", "time", -1),
        ("not late enough", "time", 1),
        ("a little later", "time", 1),
        ("less force", "strength", -1),
        ("too much force", "strength", -1),
        ("increase the force", "strength", 1),
        ("it is slow", "speed", 0),
        ("the floor is slippery", "friction", -1),
    ],
)
def test_degrees_and_their_ways(words: str, quantity: str, sign: int) -> None:
    assert [(one.quantity, one.sign) for one in wishes(words)] == [(quantity, sign)]


def test_what_is_recognised_as_nothing_does_nothing(told) -> None:
    program = program_of(told["programs"]["brake"])
    assert outcome(program, "qwerty uiop", "nothing") == "offered"
    assert not understood(program, "qwerty uiop").heard


def test_the_brake_of_the_example_starts_later(told) -> None:
    found = understood(program_of(told["programs"]["brake"]), "make the brake start later")
    assert found.line == "later: the start of brake red ball"


LEFT, RIGHT = "more to the left: the direction of", "more to the right: the direction of"


@pytest.mark.parametrize(
    ("name", "words", "line", "meant"),
    [
        ("desk", "push the mug to the left", "to the left: the direction of slide coffee mug", []),
        ("desk", "push the mug away from me",
         "away from the camera: the direction of slide coffee mug", []),
        ("desk", "the mug slides forward", "",
         ["away from the camera: the direction of slide coffee mug",
          "towards the camera: the direction of slide coffee mug"]),
        ("kick", "it curves to the left", "",
         [f"{LEFT} kick football", f"{RIGHT} kick football"]),
        ("kick", "it flies too far left", f"{RIGHT} kick football", []),
        ("kick", "let it fly a bit more to the left", f"{LEFT} kick football", []),
        ("kick", "brake harder", "", ["stronger: the strength of kick football"]),
        ("car", "let the wind blow to the right", "to the right: the direction of wind paper house",
         []),
    ],
)  # fmt: skip
def test_ways_are_followed_where_they_are_asked_for(
    told, name: str, words: str, line: str, meant: list[str]
) -> None:
    found = understood(program_of(told["programs"][name]), words)
    assert (found.line, [text for text, _ in found.meant]) == (line, meant)
    for text, said in found.meant:
        assert understood(program_of(told["programs"][name]), said).line == text


@pytest.mark.parametrize(
    ("name", "words", "demanded"),
    [
        ("kick", "the chair wobbles but it has to remain standing",
         [("upright", False)]),
        ("desk", "the book gets knocked over, it should not", [("topples", True)]),
        ("desk", "the book is not allowed to fall over", [("topples", True)]),
        ("desk", "the book falls over first, the mug should follow later", []),
    ],
)  # fmt: skip
def test_what_is_only_told_is_not_demanded(
    told, name: str, words: str, demanded: list[tuple[str, bool]]
) -> None:
    program = program_of(told["programs"][name])
    case = Case("words", None, "", tuple((o.name, o.grounding) for o in program.scene.objects),
                (), (), "")  # fmt: skip
    made = apply(program, demands(case, program, words)).contract.statements
    assert [(one.kind, one.negated) for one in made] == demanded
