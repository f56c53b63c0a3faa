"""Brush strokes and scissors: honoured exactly, edges beside them found, others' pixels kept."""

import cv2
import numpy as np
import pytest

from physagent_studio.program.scene.state import Click, Grounding, Stroke
from physagent_studio.reconstruction.masks.segmenter import (
    EmbeddedSegmenter,
    apart,
    choose,
    settled,
)
from physagent_studio.reconstruction.masks.strokes import corrected, covered
from physagent_studio.records.scene import Candidate

SHAPE = (160, 200)


@pytest.fixture(scope="module")
def picture():
    """Two flat squares, side by side, on a mottled ground."""
    rng = np.random.default_rng(1)
    image = rng.normal(120, 6, (*SHAPE, 3))
    image[50:110, 30:90] = (200, 60, 50)
    image[50:110, 110:170] = (60, 80, 200)
    return np.clip(cv2.GaussianBlur(image, (0, 0), 0.8), 0, 255).astype(np.uint8)


def square(x0: int, x1: int, y0: int = 50, y1: int = 110) -> np.ndarray:
    mask = np.zeros(SHAPE, bool)
    mask[y0:y1, x0:x1] = True
    return mask


def test_what_a_stroke_covers():
    line = Stroke(points=((20.5, 20.5), (60.5, 20.5)), radius=3)
    area = covered(line, SHAPE)
    assert area[20, 20:61].all()
    assert area[18:23, 40].all()
    assert not area[26, 40]
    polygon = Stroke(tool="scissors", points=((10, 10), (50, 10), (50, 40), (10, 40)))
    inside = covered(polygon, SHAPE)
    assert inside[11:39, 11:49].all()
    assert not inside[:8].any()


def test_strokes_are_honoured_exactly_and_later_ones_win(picture):
    mask = square(30, 90)
    add = Stroke(points=((95.0, 80.0), (100.0, 80.0)), radius=4)
    erase = Stroke(effect="erase", points=((97.0, 80.0), (97.0, 82.0)), radius=2)
    out = corrected(picture, mask, (add, erase))
    gone = covered(erase, SHAPE)
    assert not out[gone].any()
    assert out[covered(add, SHAPE) & ~gone].all()


def test_the_neighbourhood_of_a_stroke_snaps_to_the_edge(picture):
    half = square(30, 60)
    brush = Stroke(points=((70.0, 60.0), (70.0, 100.0)), radius=9)
    out = corrected(picture, half, (brush,))
    rows = slice(66, 94)
    # The brush reaches column 79; the square's edge at 90 is within its reach, and no further.
    assert out[rows, 81:88].mean() > 0.95
    assert out[rows, 92:].mean() < 0.02
    assert not corrected(None, half, (brush,))[rows, 84:].any()


def test_scissors_say_all(picture):
    polygon = Stroke(tool="scissors", effect="only", points=((40, 60), (80, 60), (80, 100)))
    out = corrected(picture, square(30, 90), (polygon,))
    assert np.array_equal(out, covered(polygon, SHAPE))


def test_strokes_alone_are_enough_to_segment(picture):
    brush = Stroke(points=((45.0, 70.0), (75.0, 90.0)), radius=4)
    grounding = Grounding(strokes=(brush,))
    offers = EmbeddedSegmenter().segment(picture, [("square", grounding)])
    mask = choose(offers, [("square", grounding)], SHAPE, picture)["square"]
    truth = square(30, 90)
    assert (mask & truth).sum() / (mask | truth).sum() > 0.9


def test_a_painted_pixel_belongs_to_who_painted_it():
    masks = {"small": square(60, 90), "large": square(30, 120)}
    brush = Stroke(points=((75.0, 80.0),), radius=5)
    groundings = [("small", Grounding()), ("large", Grounding(strokes=(brush,)))]
    offers = {name: (Candidate(mask, 1.0, ""),) for name, mask in masks.items()}
    chosen = choose(offers, groundings, SHAPE)
    painted = covered(brush, SHAPE)
    assert chosen["large"][painted].all()
    assert not (chosen["small"] & chosen["large"]).any()
    assert chosen["small"].any()


def test_a_settled_mask_does_not_hear_of_later_clicks():
    def click(x: float, label: int = 1) -> Click:
        return Click(x=x, y=80, label=1 if label else 0)

    before = [("a", Grounding(points=(click(60),))), ("b", Grounding(points=(click(140),)))]
    said = dict(apart(before))["a"]
    fixed = settled("a", before)
    later = [("a", fixed), ("b", Grounding(points=(click(140), click(100))))]
    assert dict(apart(later))["a"] == said
    open_still = [before[0], later[1]]
    assert dict(apart(open_still))["a"] != said


def test_a_mask_is_led_to_all_sides_of_its_box():
    """A pole in another colour than the body that it stands on, as a scooter or a stool has."""
    rng = np.random.default_rng(2)
    image = rng.normal(150, 5, (*SHAPE, 3))
    truth = square(60, 140, 100, 140)
    truth[30:100, 98:104] = True
    image[truth] = (60, 70, 80)
    image[60:66, 98:104] = (200, 60, 60)
    image = np.clip(cv2.GaussianBlur(image, (0, 0), 0.7), 0, 255).astype(np.uint8)
    grounding = Grounding(points=(Click(x=100, y=120),), box=(57, 27, 143, 143))
    offers = EmbeddedSegmenter().segment(image, [("thing", grounding)])
    mask = choose(offers, [("thing", grounding)], SHAPE)["thing"]
    assert mask[36:96, 101].mean() > 0.9
    assert (mask & truth).sum() / (mask | truth).sum() > 0.85


def test_a_click_outside_counts_in_a_box(picture):
    """Two squares in one box; the click outside says which one is not meant."""
    points = (Click(x=60, y=80), Click(x=140, y=80, label=0))
    grounding = Grounding(points=points, box=(24, 44, 176, 116))
    offers = EmbeddedSegmenter().segment(picture, [("red", grounding)])
    mask = choose(offers, [("red", grounding)], SHAPE)["red"]
    assert mask[60:100, 40:80].mean() > 0.9
    assert mask[78:83, 138:143].mean() == 0


def test_there_is_a_choice_of_masks(picture):
    grounding = Grounding(points=(Click(x=60, y=80),))
    offers = EmbeddedSegmenter().segment(picture, [("red", grounding)])["red"]
    assert 3 <= len(offers) <= 4
    scores = [offer.score for offer in offers]
    assert scores == sorted(scores, reverse=True)


def test_the_shadow_is_offered_apart():
    image = np.full((*SHAPE, 3), (170, 160, 140), np.uint8)
    image[110:125, 40:150] = (110, 103, 90)
    image[50:110, 60:120] = (200, 60, 50)
    image = cv2.GaussianBlur(image, (0, 0), 0.8).astype(np.uint8)
    offers = EmbeddedSegmenter().segment(image, [("box", Grounding(points=(Click(x=90, y=80),)))])
    shade = np.zeros(SHAPE, bool)
    shade[112:123, 62:118] = True
    own = square(60, 120)
    masks = [one.mask for one in offers["box"]]
    assert any((m & own).sum() / (m | own).sum() > 0.9 and m[shade].mean() < 0.1 for m in masks)
    assert any(m[shade].mean() > 0.9 and m[own].mean() > 0.9 for m in masks)


def test_a_large_photo_gives_the_mask_of_a_small_one(picture):
    large = cv2.resize(picture, None, fx=8, fy=8, interpolation=cv2.INTER_CUBIC).astype(np.uint8)
    for image, by in ((picture, 1), (large, 8)):
        said = [("red", Grounding(points=(Click(x=60.0 * by, y=80.0 * by),)))]
        mask = EmbeddedSegmenter().segment(image, said)["red"][0].mask
        shrunk = cv2.resize(mask.astype(np.uint8), SHAPE[::-1]).astype(bool)
        own = square(30, 90)
        # Within the pixel over which the picture is blurred.
        assert (own & shrunk).sum() / (own | shrunk).sum() > 0.93
