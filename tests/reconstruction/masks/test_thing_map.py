"""The network's map: where it puts the thing, what it is shown, and how it weighs drafts."""

import cv2
import numpy as np

from physagent_studio.program.scene.state import Click, Grounding
from physagent_studio.reconstruction.masks.box_drafts import box_drafts
from physagent_studio.reconstruction.masks.draft_score import Draft, Scorer
from physagent_studio.reconstruction.masks.ranking import ranked
from physagent_studio.reconstruction.masks.task import task_of, view_of
from physagent_studio.reconstruction.masks.thing_map import (
    CANVAS,
    shown,
    soft_iou,
    thing_map,
    weighed,
)
from physagent_studio.reconstruction.photo.regions import iou
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


def test_the_map_covers_both_halves_of_what_is_boxed() -> None:
    image, disc, half = two_colours()
    own = Grounding(box=(73.0, 43.0, 167.0, 137.0))
    view = view_of(image, (0, 0, *SIZE), 240)
    task = task_of("disc", own, view)
    assert task.box is not None
    scorer = Scorer(view.lab, task.inside)
    made = box_drafts(view.small, view.lab, task, task.box, scorer)
    drafts = ranked(scorer, made, task)
    chance = thing_map(view, task, drafts)
    assert chance.shape == disc.shape
    assert soft_iou(disc, chance) > soft_iou(half, chance)
    assert chance[disc].mean() > 0.7
    assert chance[~disc].mean() < 0.1
    best, *_, last = weighed(view, task, drafts)
    assert iou(best[0].mask, disc) > 0.9
    assert best[1] >= last[1]
    np.testing.assert_array_equal(chance, thing_map(view, task, drafts))


def test_what_the_network_is_shown_fills_its_canvas() -> None:
    image, disc, _ = two_colours()
    view = view_of(image, (0, 0, *SIZE), 240)
    own = Grounding(points=(Click(x=120, y=90), Click(x=20, y=20, label=0)))
    layers = shown(view.lab, task_of("disc", own, view), [(Draft(disc, "a", "colour"), 0.7)])
    assert layers.shape == (10, CANVAS * 3 // 4, CANVAS)
    assert layers.min() >= 0
    assert layers.max() <= 1
    inside, outside = layers[8], layers[9]
    assert inside[42, 56] == 1
    assert outside[42, 56] == 0
    assert outside[9, 9] > 0.5
    assert layers[7].max() == 0


def test_left_out_it_changes_nothing() -> None:
    image, disc, half = two_colours()
    view = view_of(image, (0, 0, *SIZE), 240)
    task = task_of("disc", Grounding(points=(Click(x=100, y=90),)), view)
    drafts = [(Draft(half, "a", "colour"), 0.9), (Draft(disc, "b", "contour"), 0.2)]
    with without(["thing map"]):
        assert weighed(view, task, drafts) == drafts
    assert weighed(view, task, []) == []


def test_soft_overlap_is_the_overlap_where_the_map_is_certain() -> None:
    _, disc, half = two_colours()
    assert np.isclose(soft_iou(half, disc.astype(np.float32)), iou(half, disc))
