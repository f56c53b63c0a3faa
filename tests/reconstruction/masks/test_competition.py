"""Who keeps the pixels that two masks cover."""

from __future__ import annotations

import numpy as np

from physagent_studio.program.scene.state import Click, Grounding
from physagent_studio.reconstruction.masks.competition import compete
from physagent_studio.reconstruction.masks.segmenter import apart
from physagent_studio.reconstruction.photo.regions import BoolArray

CUP = (30.0, 10.0, 70.0, 60.0)
SAUCER = (10.0, 45.0, 90.0, 70.0)


def filled(box: tuple[float, float, float, float]) -> BoolArray:
    mask = np.zeros((80, 100), bool)
    x0, y0, x1, y1 = (int(side) for side in box)
    mask[y0:y1, x0:x1] = True
    return mask


def test_the_smaller_one_keeps_what_both_cover() -> None:
    small, large = filled((20, 20, 40, 40)), filled((10, 10, 60, 60))
    found = compete({"large": large, "small": small})
    assert np.array_equal(found["small"], small)
    assert np.array_equal(found["large"], large & ~small)


def test_a_cup_stays_whole_on_a_saucer_whose_mask_is_smaller() -> None:
    """The saucer's mask took the foot of the cup that stands on it."""
    cup, saucer = filled(CUP), filled(SAUCER)
    assert saucer.sum() <= cup.sum()
    found = compete({"saucer": saucer, "cup": cup}, boxes={"saucer": SAUCER, "cup": CUP})
    assert np.array_equal(found["cup"], cup)
    assert np.array_equal(found["saucer"], saucer & ~cup)


def test_what_stands_before_a_larger_thing_is_smaller() -> None:
    """Its foot is seen below that of what it hides."""
    crate, ball = (10.0, 10.0, 90.0, 60.0), (30.0, 40.0, 60.0, 70.0)
    masks = {"crate": filled(crate), "ball": filled(ball)}
    found = compete(masks, boxes={"crate": crate, "ball": ball})
    assert np.array_equal(found["ball"], masks["ball"])


def test_what_a_person_gave_to_one_no_other_takes() -> None:
    cup, saucer = filled(CUP), filled(SAUCER)
    drawn = {"saucer": filled((40, 50, 60, 60))}
    found = compete({"saucer": saucer, "cup": cup}, drawn, {"saucer": SAUCER, "cup": CUP})
    assert not (found["cup"] & drawn["saucer"]).any()
    assert found["saucer"][drawn["saucer"]].all()


def test_a_click_on_another_thing_beside_a_box_says_nothing_of_what_is_in_it() -> None:
    boxed = Grounding(box=(10.0, 10.0, 50.0, 50.0))
    beside, within = (Grounding(points=(Click(x=x, y=30.0),)) for x in (60.0, 40.0))
    told = dict(apart([("lamp", boxed), ("desk", beside), ("cup", within)]))
    assert [(click.x, click.label) for click in told["lamp"].points] == [(40.0, 0)]
    assert [click.label for click in told["desk"].points] == [1, 0]
