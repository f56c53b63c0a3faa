"""The network's map: where it puts the thing, what it is shown, and how it weighs drafts."""

import cv2
import numpy as np
import pytest

from physagent_studio.program.scene.state import Click, Grounding
from physagent_studio.reconstruction.masks.box_drafts import found_in
from physagent_studio.reconstruction.masks.draft_score import Draft
from physagent_studio.reconstruction.masks.ranking import Seen, ranked
from physagent_studio.reconstruction.masks.segmenter import EmbeddedSegmenter
from physagent_studio.reconstruction.masks.task import Task, view_of
from physagent_studio.reconstruction.masks.thing_map import (
    MAP,
    Marks,
    Square,
    _seen,
    expected_iou,
    extent_of,
    seen_in,
    shown,
    soft_iou,
    thing_map,
)
from physagent_studio.reconstruction.photo.regions import bounds, iou
from physagent_studio.reconstruction.switches import without

SIZE = (240, 180)


def two_colours() -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """A picture of a red and blue disc before grey, the disc's mask, and that of its red half."""
    rng = np.random.default_rng(4)
    image = np.full((SIZE[1], SIZE[0], 3), 150, np.uint8)
    disc = cv2.circle(np.zeros(image.shape[:2], np.uint8), (120, 90), 45, 1, -1).astype(bool)
    half = disc & (np.arange(SIZE[0]) < 120)
    image[disc] = (40, 60, 200)
    image[half] = (200, 40, 40)
    noisy = np.clip(image + rng.normal(0, 5, image.shape), 0, 255).astype(np.uint8)
    return noisy, disc, half


@pytest.mark.parametrize(
    "own",
    [
        Grounding(box=(73.0, 43.0, 167.0, 137.0)),
        Grounding(points=(Click(x=105, y=90),)),
        Grounding(points=(Click(x=135, y=80), Click(x=20, y=20, label=0))),
    ],
    ids=["box", "click", "click and one outside"],
)
def test_the_map_covers_both_halves_of_what_is_marked(own: Grounding) -> None:
    image, disc, half = two_colours()
    seen = thing_map(image, own)
    assert seen is not None
    chance = seen.chance
    assert soft_iou(disc, chance) > soft_iou(half, chance)
    assert chance[disc].mean() > 0.7
    assert chance[~disc].mean() < 0.1
    assert expected_iou(chance) > 0.7
    assert 0.5 < seen.agreement <= 1


def test_a_map_is_kept_for_the_next_sentence_about_the_photo() -> None:
    image, own = two_colours()[0], Grounding(box=(73.0, 43.0, 167.0, 137.0))
    seen = thing_map(image, own)
    assert seen is not None
    assert thing_map(image.copy(), own) is seen
    _seen.cache_clear()
    again = thing_map(image, own)
    assert again is not None
    assert again is not seen
    np.testing.assert_array_equal(seen.chance, again.chance)
    other = image.copy()
    other[90, 120] ^= 255
    changed = thing_map(other, own)
    assert changed is not None
    assert not np.array_equal(seen.chance, changed.chance)


def test_a_click_on_one_colour_finds_all_of_the_thing() -> None:
    image, disc, _ = two_colours()
    offers = EmbeddedSegmenter().segment(image, [("disc", Grounding(points=(Click(x=105, y=90),)))])
    first, *others = offers["disc"]
    assert iou(first.mask, disc) > 0.9
    assert all(first.score >= other.score for other in others)


def test_where_nothing_is_marked_there_is_no_map() -> None:
    image, _, _ = two_colours()
    assert thing_map(image, Grounding()) is None
    assert thing_map(image, Grounding(points=(Click(x=5, y=5, label=0),))) is None


def test_what_the_network_is_shown() -> None:
    image, disc, _ = two_colours()
    marks = Marks(((120.0, 90.0),), ((20.0, 20.0),), (70.0, 40.0, 170.0, 140.0))
    square = Square(120, 90, 240)
    layers = shown(image, marks, square, disc.astype(np.float32))
    middle = MAP.canvas_px // 2
    assert layers.shape == (MAP.canvas_layers, MAP.canvas_px, MAP.canvas_px)
    assert layers[3, middle, middle] == 1
    assert layers[4].sum() > 0
    assert layers[4, middle, middle] == 0
    assert layers[5].mean() == pytest.approx((100 / 240) ** 2, abs=0.02)
    assert layers[6].mean() == pytest.approx(disc.sum() / 240**2, abs=0.01)
    # The square reaches beyond the picture above and below: nothing is there.
    assert not layers[:3, :10].any()


def test_the_extent_of_a_map_is_what_the_click_is_on() -> None:
    chance = np.zeros((90, 120), np.float32)
    chance[20:40, 30:50] = chance[60:85, 80:110] = 0.9
    own = Grounding(points=(Click(x=80, y=60),))
    x0, y0, x1, y1 = extent_of(chance, own, (180, 240))
    assert np.allclose((x0, y0, x1, y1), (60, 40, 100, 80), atol=2)
    assert extent_of(chance, Grounding(box=(1.0, 2.0, 3.0, 4.0)), (180, 240)) == (1, 2, 3, 4)


def test_a_view_of_the_map_is_of_the_same_places() -> None:
    image, disc, _ = two_colours()
    view = view_of(image, (60, 30, 180, 150), 120)
    seen = seen_in(disc.astype(np.float32), view, image.shape)
    assert seen.shape == view.lab.shape[:2]
    assert iou(seen > 0.5, disc[30:150, 60:180]) > 0.97


@pytest.mark.parametrize("sure", [1.0, 0.0])
def test_drafts_that_agree_with_a_sure_map_lead(sure: float) -> None:
    image, disc, half = two_colours()
    view = view_of(image, (0, 0, image.shape[1], image.shape[0]), max(image.shape))
    drafts = [Draft(disc, "box", "colour"), Draft(half, "map", "map")]
    x0, y0, x1, y1 = bounds(disc)
    box = (float(x0), float(y0), float(x1), float(y1))
    seen = Seen(half.astype(np.float32), sure)
    (first, _), _ = ranked(view.lab, drafts, Task((), (), box), box, seen)
    assert (first.method == "map") == (sure == 1.0)


def test_soft_overlap_is_the_overlap_where_the_map_is_certain() -> None:
    _, disc, half = two_colours()
    assert np.isclose(soft_iou(half, disc.astype(np.float32)), iou(half, disc))


def test_a_box_that_a_person_drew_ends_where_the_thing_ends() -> None:
    image, disc, half = two_colours()
    view = view_of(image, (0, 0, image.shape[1], image.shape[0]), max(image.shape))
    drafts = [Draft(disc, "box", "colour"), Draft(half, "map", "map")]
    x0, y0, x1, y1 = bounds(disc)
    box = (float(x0), float(y0), float(x1), float(y1))
    seen = Seen(half.astype(np.float32), 1.0)
    tight = Task((), (), box, tight=True)
    # The map is sure of one half, which ends in the middle of what the person drew.
    assert ranked(view.lab, drafts, tight, box, seen)[0][0].method == "box"
    with without(["tight boxes"]):
        assert ranked(view.lab, drafts, tight, box, seen)[0][0].method == "map"
    # Drawn too wide by a twelfth of it on every side, nothing is held against a thing.
    wide = (x0 - 0.1 * (x1 - x0), y0 - 0.1 * (y1 - y0), x1 + 0.1 * (x1 - x0), y1 + 0.1 * (y1 - y0))
    values = [
        ranked(view.lab, drafts[:1], Task((), (), wide, tight=one), wide, seen)[0][1]
        for one in (True, False)
    ]
    assert values[0] == values[1]


def test_two_parts_that_different_drafts_show_are_offered_as_one() -> None:
    """A map that is sure of the left half, beside colours that part both halves from the ground."""
    image, disc, half = two_colours()
    view = view_of(image, (0, 0, image.shape[1], image.shape[0]), max(image.shape))
    x0, y0, x1, y1 = bounds(disc)
    maps = [one.astype(np.float32) for one in (half, disc & ~half)]
    task = Task((), (), (float(x0), float(y0), float(x1), float(y1)), tight=True)
    best = found_in(view, task, maps, 1.0)[0][0]
    assert iou(best.mask, disc) > 0.95
    with without(["unions of drafts"]):
        assert not any("+" in one.method for one, _ in found_in(view, task, maps, 1.0))
