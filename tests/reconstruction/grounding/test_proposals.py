"""Things found by their words: on scenes with known truth, and what a sentence asks for."""

import cv2
import numpy as np
import pytest

from physagent_studio.assets import assets_dir
from physagent_studio.benchmark.reconstruction.synthetic import scene
from physagent_studio.exchange import load_case
from physagent_studio.language.sought import sought_by, things_in
from physagent_studio.reconstruction.grounding.proposals import propose
from physagent_studio.reconstruction.photo.colours import said_of

NOUNS = {"sphere": "ball", "box": "block", "cylinder": "can", "ellipsoid": "stone"}


@pytest.mark.parametrize(
    ("prompt", "names"),
    [
        (
            "The red ball rolls to the right, passes the wooden block and hits the green cube.",
            ["red_ball", "wooden_block", "green_cube"],
        ),
        ("A small yellow cube slips off the edge of the table.", ["small_yellow_cube"]),
        ("The left bowling pin topples.", ["left_bowling_pin"]),
        ("Three oranges fall off the conveyor.", ["orange_1", "orange_2", "orange_3"]),
        ("The gizmo rolls down the ramp.", ["gizmo"]),
        ("It falls.", []),
    ],
)
def test_what_a_sentence_speaks_of(prompt, names):
    assert [item.name for item in things_in(prompt)] == names


def test_words_of_a_name():
    item = sought_by(
        "large_left_orange_ball", "The large left orange ball rests on a wooden stool."
    )
    assert item.head == "ball"
    assert item.colours == ("orange",)
    assert (item.side, item.size, item.on) == ("left", 1, "stool")
    assert sought_by("orange").colours == ()


def test_what_is_clear_is_right():
    """Colour words that fit one object of a scene each; its noun is that of its shape."""
    right = clear = total = 0
    for seed in range(8):
        drawn = scene(seed)
        large = {n: m for n, m in drawn.masks.items() if np.count_nonzero(m) > 300}
        words = {name: said_of(drawn.image, mask) for name, mask in large.items()}
        alone = [name for name in words if list(words.values()).count(words[name]) == 1]
        kinds = {o.name: o.shape.kind for o in drawn.objects if o.shape is not None}
        names = {f"{words[n]}_{NOUNS.get(kinds[n], 'thing')}": n for n in alone}
        for one in propose(drawn.image, [sought_by(name) for name in names]):
            total += 1
            clear += one.clear
            spot = one.spots[0] if one.spots else None
            hit = spot and drawn.masks[names[one.name]][int(spot.y), int(spot.x)]
            right += bool(one.clear and hit)
    assert total >= 12
    assert clear >= 0.6 * total
    assert right == clear


def test_sides_tell_alike_things_apart():
    image = np.full((200, 320, 3), 170, np.uint8)
    yy, xx = np.mgrid[:200, :320]
    for x in (60, 160, 260):
        image[(xx - x) ** 2 + (yy - 120) ** 2 < 20**2] = (200, 40, 40)
    wanted = [sought_by(f"{side}_red_ball") for side in ("left", "middle", "right")]
    places = [one.spots[0].x for one in propose(image, wanted)]
    assert places == pytest.approx([60, 160, 260], abs=8)
    # Which of three alike a plain "red ball" is does not show.
    assert not propose(image, [sought_by("red_ball")])[0].clear


def test_nothing_there_is_nothing_proposed():
    flat = np.full((120, 160, 3), 128, np.uint8)
    (one,) = propose(flat, [sought_by("red_ball")])
    assert not one.clear
    assert one.spots == ()


@pytest.mark.parametrize(
    ("name", "place"),
    [("left_ball", 150), ("right_ball", 460), ("largest_ball", 300), ("smallest_ball", 150)],
)
def test_of_like_things_the_words_of_place_and_size_tell_which(name: str, place: int) -> None:
    rng = np.random.default_rng(4)
    image = np.full((360, 600, 3), (150, 148, 140), np.float64)
    for x, radius in ((150, 26), (300, 52), (460, 34)):
        cv2.circle(image, (x, 230), radius, (190, 60, 50), -1)
    image = cv2.GaussianBlur(image, (0, 0), 1.0) + rng.normal(0, 2, image.shape)
    (found,) = propose(np.clip(image, 0, 255).astype(np.uint8), [sought_by(name)])
    assert abs(found.spots[0].x - place) < 20


def _drawn(*boxes):
    """A grey picture with upright boxes (x0, y0, x1, y1, colour)."""
    image = np.full((240, 400, 3), 170, np.uint8)
    for x0, y0, x1, y1, colour in boxes:
        image[y0:y1, x0:x1] = colour
    return image


def test_things_that_fit_each_others_places_are_asked_for():
    image = _drawn((60, 90, 110, 160, (60, 130, 60)), (260, 80, 320, 160, (60, 130, 60)))
    both = propose(image, [sought_by("tree"), sought_by("plant")])
    assert len({one.spots[0].x for one in both}) == 2
    assert not any(one.clear for one in both)


def test_a_place_counts_as_taken_only_where_that_is_clear():
    # A robot may be either; what is green is then not known to be the only green thing.
    image = _drawn((60, 90, 110, 160, (60, 150, 60)), (260, 80, 320, 160, (70, 150, 60)))
    green, robot = propose(image, [sought_by("green_box"), sought_by("robot")])
    assert not green.clear
    assert not robot.clear
    image[80:160, 260:320] = (190, 50, 50)
    green, robot = propose(image, [sought_by("green_box"), sought_by("robot")])
    assert green.clear


def test_a_pen_is_long():
    blue = (50, 70, 170)
    image = _drawn((60, 90, 130, 140, blue), (240, 120, 330, 129, blue))
    (pen,) = propose(image, [sought_by("blue_pen")])
    assert 240 < pen.spots[0].x < 330


def test_no_place_is_on_offer_twice():
    image = load_case(assets_dir() / "demo", "knocks_block_over").image
    assert image is not None
    for one in propose(image, [sought_by("block"), sought_by("pebble")]):
        assert len({(round(spot.x, -1), round(spot.y, -1)) for spot in one.spots}) == 4
