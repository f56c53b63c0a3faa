"""A ball's mask is led to its circle, and only where it has one."""

from __future__ import annotations

import cv2
import numpy as np
import pytest

from physagent_studio.language import hints
from physagent_studio.program.scene.state import Grounding, SceneObject, Stroke
from physagent_studio.reconstruction.masks.foot_spill import sound_masks
from physagent_studio.reconstruction.masks.round_outlines import (
    as_ball,
    round_outline,
    rounder_first,
)
from physagent_studio.reconstruction.photo.regions import BoolArray, iou
from physagent_studio.records.scene import Candidate

NONE = np.zeros((240, 320), bool)


def _ball(x: int = 150, y: int = 110, axes: tuple[int, int] = (50, 50)) -> BoolArray:
    return cv2.ellipse(NONE.astype(np.uint8), (x, y), axes, 0, 0, 360, 1, -1).astype(bool)


def _shade(mask: BoolArray) -> BoolArray:
    x, foot = int(mask.nonzero()[1].mean()), int(mask.nonzero()[0].max())
    drawn = cv2.ellipse(mask.astype(np.uint8), (x + 12, foot - 3), (42, 8), 0, 0, 360, 1, -1)
    return drawn.astype(bool)


def test_shade_leaves_and_a_lost_panel_comes_back() -> None:
    ball = _ball()
    lost = ball.copy()
    lost[:, :118] = False
    for spoilt in (_shade(ball), lost, _shade(lost)):
        assert iou(spoilt, ball) < 0.94
        assert iou(as_ball(spoilt, NONE), ball) > 0.96


def test_what_is_in_front_of_a_ball_stays_in_front() -> None:
    ball, front = _ball(), NONE.copy()
    front[:, :115] = True
    assert not (as_ball(ball & ~front, front) & front).any()


def test_more_than_a_panel_was_hidden_and_is_not_filled() -> None:
    ball = _ball()
    seen = ball.copy()
    seen[:, :135] = False
    assert not (as_ball(seen, NONE) & ~seen).any()


def test_a_clean_oval_and_what_is_not_round_stay() -> None:
    box = NONE.copy()
    box[60:170, 100:200] = True
    for mask in (_ball(axes=(50, 42)), box):
        assert as_ball(mask, NONE) is mask


def test_of_equally_likely_masks_of_a_ball_the_round_one_leads() -> None:
    ball, half = _ball(), _ball()
    half[:110] = False
    offers = (Candidate(half, 0.77, "cut"), Candidate(ball, 0.76, "map"))
    assert rounder_first(offers)[0].mask is ball
    surer = (Candidate(half, 0.9, "cut"), Candidate(ball, 0.6, "map"))
    assert rounder_first(surer)[0].mask is half


@pytest.mark.parametrize("x", [60, 265])
def test_a_wide_lens_stretches_a_ball_beside_the_middle(x: int) -> None:
    ball = _ball(x, 120, (49, 45))
    found = round_outline(_shade(ball))
    assert found is not None
    assert found.stretch > 1
    assert iou(as_ball(_shade(ball), NONE), ball) > 0.97


def test_a_panel_that_another_mask_has_taken_comes_back() -> None:
    """Its colour is the ball's; what is really in front of it has colours of its own."""
    ball, box = _ball(), NONE.copy()
    box[110:200, 40:300] = True
    box &= ~ball
    photo = np.full((240, 320, 3), 90, np.uint8)
    photo[box], photo[ball] = (170, 120, 70), (200, 30, 30)
    photo[ball & (np.indices(ball.shape)[1] > 150)] = (30, 60, 190)
    taken = ball & (np.indices(ball.shape)[1] < 118)
    objects = [SceneObject(name="ball"), SceneObject(name="box")]
    told = hints("The ball rolls off the box.", ("ball", "box"))
    found = sound_masks(photo, {"ball": ball & ~taken, "box": box | taken}, objects, told)
    assert found["ball"][taken].mean() > 0.75
    assert not (found["ball"] & found["box"]).any()
    photo[taken] = (170, 120, 70)
    found = sound_masks(photo, {"ball": ball & ~taken, "box": box | taken}, objects, told)
    assert not found["ball"][taken].any()


def test_what_a_person_has_drawn_gives_nothing_back() -> None:
    ball, box = _ball(), NONE.copy()
    photo = np.full((240, 320, 3), 90, np.uint8)
    photo[ball] = (200, 30, 30)
    taken = ball & (np.indices(ball.shape)[1] < 118)
    box[110:200, 40:300] = True
    box = (box & ~ball) | taken
    stroke = Stroke(points=((100.0, 110.0),))
    objects = [
        SceneObject(name="ball"),
        SceneObject(name="box", grounding=Grounding(strokes=(stroke,))),
    ]
    told = hints("The ball rolls off the box.", ("ball", "box"))
    found = sound_masks(photo, {"ball": ball & ~taken, "box": box}, objects, told)
    assert found["box"] is box
    assert not (found["ball"] & box).any()


@pytest.mark.parametrize("rows", [0, 1, 2])
def test_a_mask_of_nothing_or_of_a_line_stays(rows: int) -> None:
    mask = NONE.copy()
    mask[50 : 50 + rows, 20:100] = True
    assert as_ball(mask, NONE) is mask
    assert round_outline(mask) is None


def test_plain_bodies_have_no_openings() -> None:
    dial, photo = _ball(axes=(30, 30)), np.full((240, 320, 3), 90, np.uint8)
    ring, egg = _ball() & ~dial, _ball(axes=(12, 12))
    whole = {}
    for name in ("clock", "jug", "bicycle", "swim_ring", "toy_car"):
        told = hints(f"The {name} slides to the left.", (name,))
        whole[name] = sound_masks(photo, {name: ring}, [SceneObject(name=name)], told)[name]
    for name in ("clock", "toy_car"):
        assert np.array_equal(whole.pop(name), _ball())
    assert all(np.array_equal(mask, ring) for mask in whole.values())
    # What stands in front of it is not its dial.
    objects = [SceneObject(name="clock"), SceneObject(name="egg")]
    told = hints("The clock slides to the left.", ("clock", "egg"))
    found = sound_masks(photo, {"clock": ring, "egg": egg}, objects, told)
    assert np.array_equal(found["clock"], _ball() & ~egg)
