"""The reader: who does what to whom, where, how, in which order, and what it does not know."""

from __future__ import annotations

import pytest

from physagent_studio.language import EventFrame, Inventory, Reading, inventory, read
from physagent_studio.language.reader import NOT_ENGLISH
from physagent_studio.program import Click, Grounding

GAME = (("red_ball", 100, 300), ("blue_box", 300, 300), ("green_cup", 500, 300))
PINS = (
    ("ball", 400, 400),
    ("left_pin", 200, 200),
    ("middle_pin", 300, 200),
    ("right_pin", 400, 200),
)
BOOKS = (("book_a", 300, 100), ("book_b", 300, 150), ("book_c", 300, 200), ("book_d", 300, 250))


def stock(things: tuple[tuple[str, int, int], ...], *supports: str) -> Inventory:
    clicks = [(name, Grounding(points=(Click(x=x, y=y),))) for name, x, y in things]
    return inventory(clicks, [(name, Grounding()) for name in supports])


def named(*names: str) -> tuple[tuple[str, int, int], ...]:
    return tuple((name, 100 * i, 200) for i, name in enumerate(names))


def one(prompt: str, things=GAME, supports: tuple[str, ...] = ("table",)) -> EventFrame:
    frames = read(prompt, stock(things, *supports)).frames
    assert len(frames) == 1, frames
    return frames[0]


@pytest.mark.parametrize("size", ["big", "small"])
def test_an_adjective_that_is_part_of_a_name_tells_two_things_apart(size: str) -> None:
    coins = (("coin", 200, 200), ("big_coin", 300, 200))
    frames = read(f"The {size} coin slides to the right.", stock(coins)).frames
    assert frames[0].patient == ("big_coin" if size == "big" else "coin",)
    frame = one("The coin hits the big coin.", coins)
    assert (frame.agent, frame.patient) == (("coin",), ("big_coin",))


def test_a_position_that_a_kind_is_called_by_is_no_position() -> None:
    top = (("spinning_top", 200, 200), ("wooden_block", 300, 200))
    frame = one("The spinning top spins in place.", top)
    assert (frame.sense, frame.patient) == ("spin", ("spinning_top",))
    frame = one("The spinning top hits the wooden block.", top)
    assert (frame.agent, frame.patient) == (("spinning_top",), ("wooden_block",))
    frame = one("The top book slides to the right.", (("top_book", 200, 100), ("book", 200, 200)))
    assert frame.patient == ("top_book",)


@pytest.mark.parametrize(
    "joint", [", and after that the", ". After that, the", ", after which the", "; after this the"]
)
def test_after_that_is_afterwards(joint: str) -> None:
    said = f"The red ball rolls to the right{joint} green cup falls over."
    first, second = read(said, stock(GAME)).frames
    assert (first.patient, second.patient) == (("red_ball",), ("green_cup",))
    assert second.sequel
    other = read("After that ball hits it, the green cup falls over.", stock(GAME)).frames
    assert not any(frame.sequel for frame in other)


def senses(reading: Reading) -> list[str]:
    return [frame.sense for frame in reading.frames]


@pytest.mark.parametrize(
    ("prompt", "sense", "agent", "patient"),
    [
        ("The ball hits the box.", "hit", ("red_ball",), ("blue_box",)),
        ("The box is hit by the ball.", "hit", ("red_ball",), ("blue_box",)),
        ("The ball knocks over the cup.", "knock_over", ("red_ball",), ("green_cup",)),
        ("The ball knocks the cup over.", "knock_over", ("red_ball",), ("green_cup",)),
        ("The box falls off the table.", "fall", (), ("blue_box",)),
        ("Someone pushes the box.", "push", (), ("blue_box",)),
        ("The box gets a push.", "push", (), ("blue_box",)),
        ("A strong kick sends the ball rolling.", "roll", (), ("red_ball",)),
        ("The ball bumps into the cup.", "hit", ("red_ball",), ("green_cup",)),
        ("Both the box and the cup tip over.", "topple", (), ("blue_box", "green_cup")),
        ("The wind blows the cup away.", "wind", (), ("green_cup",)),
        ("The cup is blown away by the wind.", "wind", (), ("green_cup",)),
        ("The ball rolls into the box.", "roll", (), ("red_ball",)),
        ("The cup turns around.", "turn_around", (), ("green_cup",)),
        ("The cup slides and comes to a stop.", "slide", (), ("green_cup",)),
    ],
)
def test_roles(prompt: str, sense: str, agent: tuple[str, ...], patient: tuple[str, ...]) -> None:
    frame = read(prompt, stock(GAME, "table")).frames[0]
    assert (frame.sense, frame.agent, frame.patient) == (sense, agent, patient)


@pytest.mark.parametrize(
    ("prompt", "patient"),
    [
        ("The top three books fall.", ("book_a", "book_b", "book_c")),
        ("The bottom book falls.", ("book_d",)),
        ("The top and bottom books fall.", ("book_a", "book_d")),
        ("All books fall.", ("book_a", "book_b", "book_c", "book_d")),
        ("The two upper books fall.", ("book_a", "book_b")),
    ],
)
def test_which_of_several(prompt: str, patient: tuple[str, ...]) -> None:
    assert one(prompt, BOOKS).patient == patient


@pytest.mark.parametrize(
    ("prompt", "patient"),
    [
        ("The right pin falls over.", ("right_pin",)),
        ("The rightmost pin falls over.", ("right_pin",)),
        ("The right-hand pin falls over.", ("right_pin",)),
        ("The pin on the right falls over.", ("right_pin",)),
        ("The pin in the middle falls over.", ("middle_pin",)),
        ("The left and right pins fall over.", ("left_pin", "right_pin")),
    ],
)
def test_positions(prompt: str, patient: tuple[str, ...]) -> None:
    assert one(prompt, PINS).patient == patient


def test_one_of_several_is_any() -> None:
    frame = one("One of the pins falls over.", PINS)
    assert frame.any_one
    assert frame.patient == ("left_pin", "middle_pin", "right_pin")


def test_only_and_others() -> None:
    reading = read(
        "The ball hits only the left pin and leaves the other pins standing.", stock(PINS)
    )
    hit, stay = reading.frames
    assert hit.only
    assert (hit.agent, hit.patient) == (("ball",), ("left_pin",))
    assert (stay.sense, stay.posture) == ("stay", "upright")
    assert stay.patient == ("middle_pin", "right_pin")


def test_pronouns() -> None:
    reading = read(
        "The ball rolls toward the box, hits it and it falls over, then the ball stops.",
        stock(GAME),
    )
    assert senses(reading) == ["roll", "hit", "topple", "stop"]
    assert [frame.patient for frame in reading.frames] == [
        ("red_ball",), ("blue_box",), ("blue_box",), ("red_ball",)
    ]  # fmt: skip


@pytest.mark.parametrize(
    ("prompt", "direction"),
    [
        ("The ball rolls to the left.", "left"),
        ("The ball rolls rightward.", "right"),
        ("The ball rolls forward.", "forward"),
        ("The ball rolls toward the camera.", "toward_camera"),
        ("The ball rolls away from the viewer.", "away"),
        ("The box is pushed sideways.", "sideways"),
        ("The box receives a sideways force.", "sideways"),
        ("The box flies upward.", "up"),
    ],
)
def test_directions(prompt: str, direction: str) -> None:
    assert one(prompt).direction == direction


def test_from_the_left_is_an_origin() -> None:
    assert one("The box is pushed from the left.").origin == "right"


@pytest.mark.parametrize(
    ("prompt", "manner"),
    [
        ("The ball rolls slowly.", "slow"),
        ("The box is pushed gently.", "gentle"),
        ("The box lands heavily on the table.", "hard"),
        ("The ball quickly rolls to the left.", "fast"),
    ],
)
def test_manner(prompt: str, manner: str) -> None:
    assert manner in one(prompt).manner


@pytest.mark.parametrize(
    ("prompt", "path"),
    [
        ("The ball moves in an arc.", "curve"),
        ("The ball rolls along a curved path.", "curve"),
        ("The ball rolls in a straight line.", "straight"),
        ("The ball moves in a circular path.", "circle"),
    ],
)
def test_path(prompt: str, path: str) -> None:
    assert one(prompt).path == path


def test_negation() -> None:
    assert one("The ball does not touch the box.").negated
    reading = read("The ball rolls past the cup without touching it.", stock(GAME))
    assert [frame.negated for frame in reading.frames] == [False, True]


def test_before_reaching_is_linked() -> None:
    reading = read("The ball stops before reaching the edge of the table.", stock(GAME, "table"))
    assert senses(reading) == ["stop", "reach"]
    assert reading.frames[1].link == "before"
    place = reading.frames[1].place("object")
    assert place is not None
    assert (place.name, place.part) == ("table", "edge")


def test_relative_clause() -> None:
    reading = read("The ball hits the cup, which falls over, and stops.", stock(GAME))
    assert [(f.sense, f.patient) for f in reading.frames] == [
        ("hit", ("green_cup",)), ("topple", ("green_cup",)), ("stop", ("red_ball",))
    ]  # fmt: skip


def test_counts_and_lengths() -> None:
    assert one("The box flips twice.").count == 2
    assert one("The cup spins three times.").count == 3
    frame = one("The cup slides 20 cm to the left.")
    assert frame.distance == pytest.approx(0.2)
    assert frame.direction == "left"


def test_needed_landmarks() -> None:
    reading = read("The ball crosses the finish line and rolls into the hole.", stock(GAME))
    places = {place.name: place.landmark_kind for place in reading.places()}
    assert places == {"finish_line": "line", "hole": "opening"}


def test_unknown_words_are_listed() -> None:
    reading = read("The zorgle frobnicates the ball quixotically.", stock(GAME))
    assert not reading.frames
    assert "zorgle" in reading.not_understood


@pytest.mark.parametrize(
    ("prompt", "unread"),
    [
        ("The red ball gribbles.", ("gribbles",)),
        ("The ball gribbles to the right.", ("gribbles",)),
        ("The red ball on the table gribbles to the right.", ("gribbles",)),
        ("The ball gribbles the green cup.", ("gribbles",)),
        ("The ball will gribble.", ("will", "gribble")),
        ("The ball gribbles and falls off the table.", ("gribbles",)),
        ("The cup sings a song.", ("sings", "song")),
    ],
)
def test_an_unknown_verb_is_listed_though_its_subject_is_known(
    prompt: str, unread: tuple[str, ...]
) -> None:
    reading = read(prompt, stock((("ball", 100, 300), *GAME[1:]), "table"))
    told = read(prompt, stock(GAME, "table"))
    for found in (reading, told):
        assert set(unread) <= set(found.not_understood)
    assert reading.not_understood == unread


@pytest.mark.parametrize(
    ("prompt", "unread"),
    [
        ("La bille roule vers la droite.", ("la", "roule", "vers", "droite")),
        ("La bille tourne vers la droite.", ("la", "tourne", "vers", "droite")),
        ("Die Dose fällt um.", ("dose", "fällt", "um")),
        ("球向右滚动。", ("球向右滚动",)),
    ],
)
def test_another_language_is_not_guessed_at(prompt: str, unread: tuple[str, ...]) -> None:
    """ "Vers" is one letter from "veers"."""
    reading = read(prompt, stock((("bille", 100, 300), *GAME)))
    assert not reading.frames
    assert set(unread) <= set(reading.not_understood)
    assert reading.not_understood[0] == NOT_ENGLISH


@pytest.mark.parametrize(
    ("prompt", "still"),
    [
        ("Nothing happens.", ("red_ball", "green_cup")),
        ("Nothing happens to the cup.", ("green_cup",)),
        ("The ball rolls to the left and nothing happens to the cup.", ("green_cup",)),
    ],
)
def test_what_nothing_happens_to_does_not_move(prompt: str, still: tuple[str, ...]) -> None:
    reading = read(prompt, stock(GAME))
    assert not reading.not_understood
    frame = reading.frames[-1]
    assert (frame.sense, frame.negated) == ("move", True)
    assert set(still) <= set(frame.patient)


def test_what_is_not_understood_is_said_once() -> None:
    said = read("The ball rolls, and nothing happens.", stock(GAME)).not_understood
    assert said == ("nothing happens",)


def test_an_unknown_noun_behind_a_known_one_is_no_verb_where_there_is_one() -> None:
    pot = (("flower", 100, 300), *GAME)
    reading = read("The flower pot falls over and the ball rolls to the left.", stock(pot))
    assert [frame.patient for frame in reading.frames] == [("flower",), ("red_ball",)]
    assert not reading.not_understood


def test_a_wrong_colour_names_nothing() -> None:
    reading = read("The yellow ball rolls to the left.", stock(GAME))
    assert not reading.frames
    assert "ball" in reading.not_understood


def test_clauses_keep_the_wording() -> None:
    reading = read("The ball rolls left, and the cup falls over.", stock(GAME))
    assert [c.text for c in reading.clauses] == ["The ball rolls left", "and the cup falls over"]


def test_long_prompts_are_cut_and_said() -> None:
    reading = read("the ball rolls " * 500, stock(GAME))
    assert reading.not_understood


CANS = (("red_can", 100, 300), ("blue_can", 300, 300), ("green_can", 500, 300))


@pytest.mark.parametrize(
    "prompt",
    [
        "The red can hits the can.",
        "The red can rolls into the can.",
        "The red can rolls to the right and knocks the can over.",
        "The can is hit by the red can.",
    ],
)
def test_a_noun_beside_the_subject_means_another_thing(prompt: str) -> None:
    frames = read(prompt, stock(CANS[:2], "table")).frames
    told = [(*f.agent, *f.patient, *(place.name for _, place in f.places)) for f in frames]
    assert {name for names in told for name in names} == {"red_can", "blue_can"}
    assert all(not set(frame.agent) & set(frame.patient) for frame in frames)


def test_of_several_others_any_one_may_be_meant() -> None:
    frame = one("The red can hits the can.", CANS)
    assert (frame.agent, frame.patient) == (("red_can",), ("blue_can", "green_can"))
    assert frame.any_one
    # What another clause is about is meant as before.
    later = read("The red can rolls to the left. A person pushes the can.", stock(CANS, "table"))
    assert later.frames[-1].patient == ("red_can",)


@pytest.mark.parametrize(
    ("prompt", "word"),
    [
        ("The red can hits the can.", "can"),
        ("The red can rolls into the can.", "can"),
        ("The red can pushes the can to the right.", "can"),
        ("The red can hits the red can.", "red can"),
        ("The red can hits itself.", "itself"),
        ("The red can hits it.", "it"),
        ("The red can bumps into itself.", "bumps"),
    ],
)
def test_nothing_acts_on_itself_and_that_is_said(prompt: str, word: str) -> None:
    reading = read(prompt, stock((*CANS[:1], ("white_mug", 300, 300)), "table"))
    assert word in reading.not_understood
    assert not any("red_can" in frame.agent for frame in reading.frames)


TABLES = (("high_table", 200, 240), ("low_table", 480, 310))


@pytest.mark.parametrize(
    ("prompt", "table"),
    [
        ("The ball rolls off the low table.", "low_table"),
        ("The ball rolls off the high table.", "high_table"),
        ("The ball rolls off the table.", "high_table"),
        ("The cube slides off the table.", "low_table"),
        ("The cube slides off the edge.", "low_table"),
        ("The ball rolls off the high table and lands on the other table.", "low_table"),
        ("The cube slides off the high table and stops beside the table.", "high_table"),
    ],
)
def test_which_of_two_tables_is_meant(prompt: str, table: str) -> None:
    """By its name, as the other one, as the one spoken of, or the nearest to what acts."""
    things = [(n, Grounding(points=(Click(x=x, y=y),))) for n, x, y in
              (("ball", 280, 210), ("cube", 570, 290), *TABLES)]  # fmt: skip
    frame = read(prompt, inventory(things[:2], things[2:])).frames[-1]
    assert [place.name for _, place in frame.places] == [table]


PLATE = (("plate", 450, 300), ("bottle", 330, 220), ("orange", 510, 286))


@pytest.mark.parametrize(
    ("prompt", "way", "place"),
    [
        ("The orange rolls off the back of the plate.", "away", ("off", "plate")),
        ("The orange rolls off the front of the plate.", "toward_camera", ("off", "plate")),
        ("The orange rolls off the plate on the right.", "right", ("off", "plate")),
        ("The orange rolls to the back of the plate.", "away", None),
        ("The orange bumps into the back of the bottle.", None, None),
    ],
)
def test_a_side_of_a_thing_is_no_other_thing(
    prompt: str, way: str | None, place: tuple[str, str] | None
) -> None:
    """Nothing stands farther back than the bottle, which is not spoken of."""
    frame = one(prompt, PLATE)
    assert frame.direction == way
    assert [(relation, p.name) for relation, p in frame.places] == ([place] if place else [])
    if place is None and way is None:
        assert frame.patient == ("bottle",)


@pytest.mark.parametrize(
    "prompt",
    [
        "The orange rolls out of the picture on the right.",
        "The orange rolls out of view.",
        "The bottle falls and the orange leaves the frame.",
    ],
)
def test_what_leaves_the_picture_is_understood(prompt: str) -> None:
    reading = read(prompt, stock(PLATE, "table"))
    assert reading.not_understood == ()
    assert reading.frames[-1].patient == ("orange",)
    assert "offscreen" in reading.frames[-1].manner
    assert all("offscreen" not in frame.manner for frame in reading.frames[:-1])
    assert ("right" in prompt) == (reading.frames[-1].direction == "right")


SHELF = (("red_can", 333, 137), ("blue_ball", 482, 285), ("yellow_cube", 496, 153))
BOARDS = (("lower_shelf", 322, 306), ("upper_shelf", 266, 174))


@pytest.mark.parametrize(
    ("prompt", "patient", "places", "unread"),
    [
        ("The red can falls from the top shelf.", ("red_can",), [("from", "upper_shelf")], ()),
        ("The ball falls from the bottom shelf.", ("blue_ball",), [("from", "lower_shelf")], ()),
        ("Everything on the upper shelf falls off it.", ("red_can", "yellow_cube"), None, ()),
        ("The can hits the ball and falls outside.", ("red_can",), [], ("outside",)),
        ("The can falls away from the wall.", ("red_can",), [], ("wall",)),
    ],
)
def test_which_board_and_what_nothing_stands_for(
    prompt: str,
    patient: tuple[str, ...],
    places: list[tuple[str, str]] | None,
    unread: tuple[str, ...],
) -> None:
    things, boards = (
        [(name, Grounding(points=(Click(x=x, y=y),))) for name, x, y in rows]
        for rows in (SHELF, BOARDS)
    )
    reading = read(prompt, inventory(things, boards))
    frame = reading.frames[-1]
    assert frame.patient == patient
    assert reading.not_understood == unread
    if places is not None:
        assert [(relation, place.name) for relation, place in frame.places] == places


@pytest.mark.parametrize(
    ("prompt", "word"),
    [
        ("The ball hits the crate and tips it over.", "it"),
        ("The ball tips the crate over.", "crate"),
        ("The ball pushes the crate to the left.", "crate"),
    ],
)
def test_what_is_fixed_is_not_moved_by_another_thing(prompt: str, word: str) -> None:
    """It was the ball that toppled, or was pushed."""
    reading = read(prompt, stock((("ball", 100, 300),), "crate"))
    assert word in reading.not_understood
    assert all(frame.sense == "strike" for frame in reading.frames)


@pytest.mark.parametrize(
    ("prompt", "sense"),
    [
        ("The red ball rolls slower and slower and stops.", "slow"),
        ("The red ball rolls faster and faster.", "accelerate"),
    ],
)
def test_more_and_more_so_is_a_change_of_speed(prompt: str, sense: str) -> None:
    reading = read(prompt, stock(GAME))
    assert [f.sense for f in reading.frames][:2] == ["roll", sense]
    assert not reading.not_understood


@pytest.mark.parametrize("words", ["10 cm per second", "about 10 cm a second", "0.1 m per second"])
def test_a_speed_may_be_written_out(words: str) -> None:
    frame = one(f"The red ball rolls to the left at {words}.")
    assert frame.speed == pytest.approx(0.1)


def test_what_is_hauled_back_to_a_side_goes_there_and_what_bounces_back_turns_round() -> None:
    assert one("The blue box is dragged back to the right.").direction == "right"
    assert one("The red ball bounces back to the left.").direction == "backward"


@pytest.mark.parametrize(
    ("prompt", "direction"),
    [
        ("The red ball rolls forward to the right.", "right"),
        ("The red ball rolls to the left and forwards.", "left"),
        ("The red ball rolls backwards to the left.", "left"),
        ("The red ball leaves the picture on the left side.", "left"),
        ("The red ball flies up into the sky.", "up"),
    ],
)
def test_a_side_of_the_picture_says_more_than_the_things_own_way(
    prompt: str, direction: str
) -> None:
    frame = one(prompt)
    assert frame.direction == direction
    assert ("backwards" in frame.manner) == ("backwards" in prompt)


@pytest.mark.parametrize(
    ("prompt", "sense"),
    [
        ("The blue box starts to swing.", "sway"),
        ("The blue box begins to pass the red ball.", "pass"),
        ("The blue box is given a gentle push to the right.", "push"),
        ("The blue box is given a quick spin.", "spin"),
        ("The blue box sways to the left and then to the right.", "sway"),
        ("The blue box spins counterclockwise.", "spin"),
        ("The blue box is knocked over to the right.", "knock_over"),
        ("The red ball rolls over to the blue box.", "roll"),
        ("The leaves of the blue box rustle.", "sway"),
        ("The blue box's branches sway.", "sway"),
        ("The blue box, gathering speed, slides to the left.", "accelerate"),
    ],
)
def test_everyday_turns_are_read_whole(prompt: str, sense: str) -> None:
    reading = read(prompt, stock(GAME))
    assert not reading.not_understood
    assert sense in [frame.sense for frame in reading.frames]


def test_there_and_on_is_no_rhythm_of_what_rolls_and_in_turn_is_one_thing() -> None:
    asked = "The red ball rolls to the left and then to the right."
    ways = [(frame.sense, frame.direction) for frame in read(asked, stock(GAME)).frames]
    assert ways == [("roll", "left"), ("roll", "right")]
    prompt = "The red ball hits the blue box, which in turn knocks over the green cup."
    reading = read(prompt, stock(GAME))
    assert senses(reading) == ["hit", "knock_over"]
    assert not any(frame.timing for frame in reading.frames)


@pytest.mark.parametrize(
    "prompt",
    [
        "The tray with the cup on it slides to the left.",
        "The tray, with two cups on top, slides to the left.",
        "The tray with the cups inside slides to the left.",
        "The tray with the left cup inside the right cup slides to the left.",
        "The tray with the left cup on top of the right cup slides to the left.",
    ],
)
def test_what_a_thing_is_laden_with_goes_along_unsaid(prompt: str) -> None:
    frame = one(prompt, named("tray", "left_cup", "right_cup"))
    assert (frame.sense, frame.patient, frame.direction) == ("slide", ("tray",), "left")
    assert not frame.places


def test_a_name_may_have_words_that_a_sentence_uses() -> None:
    things = named("block_on_top", "left_block", "man_with_hat")
    frame = one("The block on top falls on the floor.", things)
    assert frame.patient == ("block_on_top",)
    place = frame.place("on")
    assert place is not None
    assert place.name == "floor"
    assert one("The man with hat slides to the left.", things).patient == ("man_with_hat",)
