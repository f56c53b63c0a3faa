"""Small things that are doubtful are looked at once more, from closer."""

import numpy as np
import pytest

from physagent_studio.program.scene.state import Click, Grounding
from physagent_studio.reconstruction.masks.closeup import (
    Look,
    is_doubtful,
    merged,
    piece_around,
)
from physagent_studio.reconstruction.masks.draft_score import Draft
from physagent_studio.reconstruction.masks.task import View
from physagent_studio.reconstruction.masks.variants import VARIANT
from physagent_studio.reconstruction.photo.regions import iou

SHAPE = (480, 800, 3)


def _view(part, factor):
    size = (round((part[3] - part[1]) * factor), round((part[2] - part[0]) * factor))
    return View(part, factor, np.zeros((*size, 3), np.uint8), np.zeros((*size, 3), np.float32))


FAR = _view((0, 0, 800, 480), 0.3)
NEAR = _view((220, 60, 580, 420), 0.6)


def _seen(view, x, y, radius):
    """A disc given in pixels of the picture."""
    rows, columns = np.mgrid[: view.lab.shape[0], : view.lab.shape[1]]
    a, b = view.inward(x, y)
    return np.hypot(columns - a, rows - b) < radius * view.factor


def _look(view, *discs, family="colour", method="draft"):
    found = [(Draft(_seen(view, *disc), f"{method}-{k}", family), v) for k, (disc, v) in
             enumerate(discs)]  # fmt: skip
    return Look(view, found)


def _clicks(*points):
    return Grounding(points=tuple(Click(x=x, y=y, label=1) for x, y in points))


@pytest.mark.parametrize(
    ("radius", "value", "again"),
    [(40, 0.5, True), (40, 0.9, False), (200, 0.5, False)],
    ids=["small", "sure", "large"],
)
def test_only_what_is_small_and_doubtful_is_looked_at_again(radius, value, again):
    assert is_doubtful(_look(FAR, ((400, 240, radius), value))) == again
    assert not is_doubtful(Look(FAR, []))


@pytest.mark.parametrize(
    ("points", "piece"),
    [
        ([(400, 240)], (220, 60, 580, 420)),
        ([(60, 240), (700, 240)], None),  # clicks too far apart
        ([(30, 20)], (0, 0, 210, 200)),
        ([], None),
    ],
)
def test_the_piece_that_is_looked_at_again_lies_around_the_clicks(points, piece):
    assert piece_around(_clicks(*points), SHAPE) == piece


def test_a_thin_thing_on_a_large_ground_that_came_first_is_looked_at_again():
    look = _look(FAR, ((400, 240, 200), 0.5), ((400, 240, 30), 0.4))
    assert is_doubtful(look)


def test_the_surer_look_leads_and_both_have_a_say():
    far = _look(FAR, ((400, 240, 20), 0.5), ((400, 240, 70), 0.4), method="far")
    near = _look(NEAR, ((400, 240, 40), 0.7), ((400, 240, 30), 0.6), method="near")
    led = merged(far, near)
    assert [draft.method for (draft, _), _ in led] == ["near-0", "near-1", "far-0", "far-1"]
    assert [view for _, view in led] == [NEAR, NEAR, FAR, FAR]
    values = [value for (_, value), _ in led]
    assert values == sorted(values, reverse=True)
    sure = _look(FAR, ((400, 240, 20), 0.71), ((400, 240, 70), 0.4), method="far")
    methods = [draft.method for (draft, _), _ in merged(sure, near)]
    assert methods == ["far-0", "near-0", "near-1", "far-1"]
    assert merged(far, Look(NEAR, [])) == [(item, FAR) for item in far.found]


def test_what_both_looks_see_is_offered_once_and_the_shadow_keeps_its_place():
    far = _look(FAR, ((400, 240, 40), 0.5), ((400, 240, 90), 0.4), ((400, 240, 60), 0.3))
    near = _look(NEAR, ((400, 240, 40), 0.7), ((400, 240, 25), 0.6))
    near.found.append((Draft(_seen(NEAR, 430, 250, 75), "with shadow", VARIANT), 0.35))
    led = merged(far, near)
    assert len(led) == 4
    assert led[-1][0][0].method == "with shadow"
    assert iou(led[0][0][0].mask, near.found[0][0].mask) == 1.0
    assert sum(item[0] is far.found[0] for item in led) == 0
