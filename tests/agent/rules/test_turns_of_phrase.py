"""Plain turns of phrase: what they are read as, what they demand, what is said to be unread."""

from __future__ import annotations

import pytest

from physagent_studio.agent.rules import RuleGenerator
from physagent_studio.contract import measure
from physagent_studio.contract.words import claim
from physagent_studio.language import EventFrame, Reading, inventory, read
from physagent_studio.language.tokens.spelling import instead_of
from physagent_studio.program import Grounding, PhysicalProgram
from physagent_studio.simulation import simulate
from tests.agent.rules.everyday_scenes import EVERYDAY
from tests.agent.rules.scenes import STAGES
from tests.agent.rules.varied_scenes import VARIED

STAGED = {**STAGES, **EVERYDAY, **VARIED}
THINGS = ("car", "box", "cup", "tray", "ball", "truck")


def reading(prompt: str) -> Reading:
    things = [(name, Grounding()) for name in THINGS]
    return read(prompt, inventory(things, [("table", Grounding()), ("ramp", Grounding())]))


def one(prompt: str) -> EventFrame:
    (frame,) = reading(prompt).frames
    return frame


@pytest.mark.parametrize(
    ("prompt", "subjects"),
    [
        ("The box in front falls over.", ["front_box"]),
        ("The box behind tips over and the one in front stays.", ["back_box", "front_box"]),
        ("The closer box falls over.", ["front_box"]),
        ("The box in front is pushed until it hits the box behind.", ["front_box", "back_box"]),
        ("The car rolls into the one behind.", ["car"]),
        ("The car stops behind the front box.", ["car"]),
        ("The car leaves the front box behind.", ["front_box"]),
    ],
)
def test_which_of_two_is_meant_by_how_far_away_it_is(prompt: str, subjects: list[str]) -> None:
    things = [(name, Grounding()) for name in ("front_box", "back_box", "car")]
    told = read(prompt, inventory(things, [("table", Grounding())]))
    assert [frame.patient for frame in told.frames] == [(name,) for name in subjects]
    assert not told.not_understood


@pytest.mark.parametrize(
    ("prompt", "sense", "manner"),
    [
        ("The car creeps forward.", "move", {"slow"}),
        ("The car inches to the left.", "move", {"slow"}),
        ("The car nudges the box.", "push", {"gentle"}),
        ("The ball rolls a short way.", "roll", {"slight"}),
        ("The ball rolls a long way to the right.", "roll", {"far"}),
        ("The ball rolls far to the right.", "roll", {"far"}),
        ("The ball rolls far along the ramp.", "roll", {"far"}),
        ("The truck backs up into the box.", "move", {"backwards"}),
        ("The truck backs into the box.", "move", {"backwards"}),
        ("The truck backs up to the box.", "move", {"backwards"}),
        ("The truck reverses up to the top of the ramp.", "move", {"backwards"}),
        ("The car makes a U-turn.", "turn_around", set()),
        ("The car does a U-turn.", "turn_around", set()),
        ("The ball gets stuck halfway up the ramp.", "stop", set()),
        ("The ball glances off the box.", "bounce", set()),
        ("The ball is deflected by the box.", "bounce", set()),
        ("The car overtakes the truck.", "pass", set()),
        ("The cup stays put.", "stay", set()),
        ("The cup is placed down.", "set_down", set()),
        ("The car makes it up the ramp.", "move", set()),
    ],
)
def test_what_it_is_read_as(prompt: str, sense: str, manner: set[str]) -> None:
    frame = one(prompt)
    assert (frame.sense, set(frame.manner)) == (sense, manner)
    assert not reading(prompt).not_understood


def test_what_drops_off_the_back_at_the_top_drops_off_the_slope() -> None:
    frame = reading("The truck backs up to the top of the ramp and drops off the back.").frames[-1]
    place = frame.place("off")
    assert place is not None
    assert (place.name, place.part, frame.direction) == ("ramp", "upper_end", None)


def test_who_is_deflected_and_what_it_goes_off() -> None:
    frame = one("The ball is deflected by the box.")
    place = frame.place("off")
    assert (frame.patient, frame.agent, place and place.name) == (("ball",), (), "box")


def test_with_the_cup_on_it_is_along_with_it() -> None:
    slides, stays = reading("The tray slides to the left with the cup on it.").frames
    assert (slides.patient, stays.patient, stays.sense) == (("tray",), ("cup",), "stay")
    assert one("The tray tips over with the cup on it.").patient == ("tray",)


def test_the_back_of_a_truck_is_not_a_way_in_the_picture() -> None:
    frame = one("The box falls off the back of the truck.")
    assert frame.direction is None
    assert frame.place("off") is not None


def test_a_sentence_of_which_nothing_happens_is_not_passed_over() -> None:
    assert reading("The truck on the table.").not_understood


def program_of(stage: str, prompt: str) -> PhysicalProgram:
    return RuleGenerator().first(STAGED[stage].case(prompt), STAGED[stage].reconstruct)


def test_what_is_set_down_is_raised_first() -> None:
    for prompt in ("The mug is placed down gently.", "A hand sets the mug down."):
        program = program_of("kitchen", prompt)
        told = {claim(s, program) for s in program.contract.statements}
        assert {"mug moves up", "mug falls", "mug reaches table"} <= told
        checks = measure(program, simulate(program, {}))
        assert all(check.ok for check in checks if check.demanded and not check.always_on)


def test_it_leans_on_what_it_touches_in_the_end() -> None:
    program = program_of("bar", "The wine bottle falls over and leans against the wine glass.")
    told = {claim(s, program) for s in program.contract.statements}
    assert {"wine_bottle touches wine_glass", "wine_bottle stops near wine_glass"} <= told


def test_where_it_teeters_has_to_be_there() -> None:
    assert program_of("kitchen", "The teapot teeters on the edge of the table.").contract.untested
    assert not program_of("kitchen", "The teapot teeters on the table.").contract.untested


@pytest.mark.parametrize(
    ("prompt", "sense", "patient"),
    [
        ("The ball rolls into the cup, which then falls off the tray.", "fall", "cup"),
        ("The car crashes head-on into the box.", "hit", "box"),
        ("The box is knocked off balance by the car.", "knock_over", "box"),
        ("The truck falls over and takes the cup down with it.", "knock_over", "cup"),
        ("The cup is laid down on its side.", "topple", "cup"),
        ("The ball rolls to the left and gets faster and faster.", "accelerate", "ball"),
        ("The car drives off and disappears behind the box.", "move", "car"),
    ],
)
def test_whom_the_last_thing_said_happens_to(prompt: str, sense: str, patient: str) -> None:
    read_as = reading(prompt)
    assert (read_as.frames[-1].sense, read_as.frames[-1].patient) == (sense, (patient,))
    assert not read_as.not_understood


@pytest.mark.parametrize(
    ("amount", "degrees"),
    [
        ("by ninety degrees", 90.0),
        ("forty-five degrees", 45.0),
        ("one hundred and eighty degrees", 180.0),
        ("by a quarter turn", 90.0),
        ("by half a turn", 180.0),
    ],
)
def test_how_far_it_turns_in_words(amount: str, degrees: float) -> None:
    assert one(f"The box rotates {amount}.").angle == degrees
    assert not reading(f"The box rotates {amount}.").not_understood


def test_they_are_the_subject_and_what_was_named_with_it() -> None:
    said = reading("The cup drops off the tray and rolls toward the ball until they touch.")
    assert ({*said.frames[-1].agent, *said.frames[-1].patient}) == {"cup", "ball"}


def test_what_it_only_looks_like_is_no_event() -> None:
    said = reading("The box slides to the left as if the table were tilted.")
    assert [frame.sense for frame in said.frames] == ["slide"]
    assert not said.not_understood


def test_what_comes_in_from_a_side_goes_into_nothing() -> None:
    assert one("The ball rolls in from the right.").places == ()


@pytest.mark.parametrize(
    ("prompt", "word"),
    [
        ("The cup next to the kettle slides to the right.", "kettle"),
        ("The ball hanging from the ceiling swings.", "ceiling"),
    ],
)
def test_what_only_tells_where_it_was_is_no_doubt(prompt: str, word: str) -> None:
    said = reading(prompt)
    assert (said.not_understood, said.unmarked) == ((), (word,))


@pytest.mark.parametrize(
    ("prompt", "plain"),
    [
        ("A close-up of a car driving towards the camera.", "The car drives towards the camera."),
        ("The camera stays still while the ball rolls left.", "The ball rolls left."),
        (
            "The ball hits the cup hard enough to knock it over.",
            "The ball hits the cup and knocks it over.",
        ),
        ("The cup tilts and returns to its upright position.", "The cup tilts and stays upright."),
        ("The box slides at a constant speed.", "The box slides steadily."),
        ("Realistic physics: the ball rolls left.", "The ball rolls left."),
        ("I want the box to fall over.", "The box falls over."),
    ],
)
def test_what_captions_say_of_the_event(prompt: str, plain: str) -> None:
    def said(text: str) -> list[tuple[str, object]]:
        return [(frame.sense, frame.direction) for frame in reading(text).frames]

    assert said(prompt) == said(plain)
    assert not reading(prompt).not_understood


@pytest.mark.parametrize(
    ("word", "instead"),
    [
        ("sings", "did you mean “swings”?"),
        ("drawer", "mark it too, if it takes part"),
        ("evaporates", "say it in other words"),
        ("like a dream", "say it in other words"),
    ],
)
def test_what_to_do_about_a_word_that_is_not_understood(word: str, instead: str) -> None:
    assert instead_of(word) == instead


@pytest.mark.parametrize(
    ("prompt", "frames"),
    [
        (
            "The ball rolls off the tray, then the cup slides after it, and both end up on the "
            "table.",
            [("roll", ("ball",), "tray"), ("slide", ("cup",), "ball"),
             ("end", ("ball", "cup"), "table")],
        ),
        (
            "The ball rolls off the tray, the cup slides to the left, and both stop.",
            [("roll", ("ball",), "tray"), ("slide", ("cup",), ""), ("stop", ("ball", "cup"), "")],
        ),
        (
            "The ball hits the box and both fall off the table.",
            [("hit", ("box",), ""), ("fall", ("ball", "box"), "table")],
        ),
        (
            "The ball rolls off the tray and hits it.",
            [("roll", ("ball",), "tray"), ("hit", ("tray",), "")],
        ),
    ],
)  # fmt: skip
def test_what_a_thing_only_leaves_is_not_what_goes_on(prompt: str, frames: list[tuple]) -> None:
    told = [
        (f.sense, tuple(sorted(f.patient)), f.places[0][1].name if f.places else "")
        for f in reading(prompt).frames
    ]
    assert told == frames
