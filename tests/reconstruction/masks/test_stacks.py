"""Stacks are parted along their seams where masks of single clicks do not part them."""

from __future__ import annotations

import cv2
import numpy as np
import pytest

from physagent_studio.benchmark.reconstruction.lookalikes import Lookalike, stack
from physagent_studio.program.scene.state import Click, Grounding
from physagent_studio.reconstruction.masks.segmenter import EmbeddedSegmenter, apart, choose
from physagent_studio.reconstruction.masks.stacks import METHOD, Mark, layers_of, stacked
from physagent_studio.reconstruction.photo.regions import BoolArray, grow, iou
from physagent_studio.records.scene import Candidate


def _middle(mask: BoolArray) -> tuple[float, float]:
    depth = cv2.distanceTransform(np.pad(mask, 1).astype(np.uint8), cv2.DIST_L2, 5)[1:-1, 1:-1]
    row, column = divmod(int(depth.argmax()), depth.shape[1])
    return column + 0.5, row + 0.5


def _clicked(drawn: Lookalike) -> list[tuple[str, Grounding]]:
    return [
        (name, Grounding(points=(Click(x=x, y=y, label=1),)))
        for name, mask in drawn.masks.items()
        for x, y in [_middle(mask)]
    ]


def _told_apart(seed: int) -> list[float]:
    """IoU of each layer's mask from one click on each."""
    drawn = stack(seed)
    said = _clicked(drawn)
    offers = EmbeddedSegmenter().segment(drawn.image, said)
    masks = choose(offers, said, drawn.image.shape[:2])
    return [iou(masks[name], drawn.masks[name]) for name in masks]


@pytest.mark.slow
def test_books_in_a_stack_are_told_apart_by_one_click_each() -> None:
    assert min(_told_apart(1)) > 0.85
    assert np.mean([one for seed in range(1, 7) for one in _told_apart(seed)]) > 0.9


@pytest.mark.parametrize("off", [0.0, 5.0])
def test_clicks_a_little_off_still_mean_the_layer_beside(off: float) -> None:
    drawn = stack(11)
    whole = np.any(list(drawn.masks.values()), axis=0)
    marks = [Mark(x, y - off) for x, y in map(_middle, drawn.masks.values())]
    layers = layers_of(drawn.image, whole, marks)
    assert layers is not None
    found = [iou(a, b) for a, b in zip(layers, drawn.masks.values(), strict=True)]
    assert min(found) > 0.8
    assert np.array_equal(np.any(layers, axis=0), whole)


def test_masks_that_part_the_stack_already_are_left_alone() -> None:
    drawn = stack(11)
    said = _clicked(drawn)
    offers = EmbeddedSegmenter().segment(drawn.image, apart(said[:2]))
    exact = {name: (Candidate(mask, 0.9, "truth"),) for name, mask in drawn.masks.items()}
    whole = np.any(list(drawn.masks.values()), axis=0)
    kept = stacked(drawn.image, said, exact, lambda _: whole)
    assert {own[0].method for own in kept.values()} == {"truth"}
    assert all(METHOD not in {c.method for c in own} for own in offers.values())
    blurred = {
        name: (Candidate(grow(c.mask, 40), c.score, c.method),) for name, (c,) in exact.items()
    }
    led = stacked(drawn.image, said, blurred, lambda _: whole)
    assert {own[0].method for own in led.values()} == {METHOD}


def test_boxes_of_layers_that_touch_are_parted_too() -> None:
    drawn = stack(11)
    said = []
    for name, mask in drawn.masks.items():
        rows, columns = np.nonzero(mask)
        box = (columns.min() - 2.0, rows.min() - 2.0, columns.max() + 3.0, rows.max() + 3.0)
        said.append((name, Grounding(box=box)))
    whole = np.any(list(drawn.masks.values()), axis=0)
    rough = {name: (Candidate(grow(m, 40), 0.5, "rough"),) for name, m in drawn.masks.items()}
    led = stacked(drawn.image, said, rough, lambda _: whole)
    assert min(iou(led[name][0].mask, mask) for name, mask in drawn.masks.items()) > 0.8
    # Layers that do not fill the boxes are not meant.
    wide = [
        (name, Grounding(box=(0.0, 10.0 * k, 800.0, 300.0 + 10 * k)))
        for k, (name, _) in enumerate(said)
    ]
    kept = stacked(drawn.image, wide, rough, lambda _: whole)
    assert {own[0].method for own in kept.values()} == {"rough"}


def test_names_without_letters_are_of_one_kind_each() -> None:
    drawn = stack(11)
    said = [(f"{k}", grounding) for k, (_, grounding) in enumerate(_clicked(drawn))]
    offers = {name: (Candidate(np.ones((2, 2), bool), 0.5, "any"),) for name, _ in said}
    assert stacked(drawn.image, said, offers, lambda _: None) == offers
