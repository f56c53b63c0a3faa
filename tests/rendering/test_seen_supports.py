"""What of a support the photo shows."""

from __future__ import annotations

import cv2
import numpy as np
import pytest

from physagent_studio.rendering import Compositor
from physagent_studio.rendering.compositor import initial_poses
from physagent_studio.rendering.seen_supports import margins_of
from tests.rendering.scenes import ball, scene_of, table

WALL, WOOD = (190, 184, 176), (132, 92, 60)


def picture(mask, inside=WOOD, outside=WALL, seed=2):
    """A picture that shows one colour in a mask (H, W) and another around it, with some grain."""
    plain = np.where(mask[..., None], np.array(inside), np.array(outside))
    grain = np.random.default_rng(seed).normal(0, 5, mask.shape)[..., None]
    return np.clip(plain + grain, 0, 255).astype(np.uint8)


def quad(points, size=(416, 240)):
    """(H, W) a filled polygon."""
    mask = np.zeros(size[::-1], np.uint8)
    cv2.fillPoly(mask, [np.array(points, np.int32)], 1)
    return mask > 0


SEEN = quad([(120, 90), (415, 70), (415, 180), (120, 200)])
COMPUTED = quad([(108, 88), (415, 68), (415, 180), (108, 202)])


@pytest.mark.parametrize("size", [(416, 240), (832, 480)])
def test_a_margin_beyond_the_seen_outline_is_found(size):
    seen, computed = (
        cv2.resize(mask.astype(np.uint8), size, interpolation=cv2.INTER_NEAREST) > 0
        for mask in (SEEN, COMPUTED)
    )
    margins = margins_of(picture(seen), np.where(computed, 0, -1).astype(np.int16))
    true = computed & ~seen
    assert (margins & true).sum() > 0.9 * true.sum()
    assert (margins & seen).sum() < 0.02 * seen.sum()


def test_a_support_that_is_as_computed_keeps_its_outline():
    margins = margins_of(picture(SEEN), np.where(SEEN, 0, -1).astype(np.int16))
    assert margins.sum() < 0.005 * SEEN.sum()


def test_without_a_line_in_the_picture_nothing_is_cut_off():
    solid = np.where(COMPUTED, 0, -1).astype(np.int16)
    assert not margins_of(picture(SEEN, WOOD, WOOD), solid).any()
    assert not margins_of(picture(SEEN), np.full_like(solid, -1)).any()


def test_the_same_picture_gives_the_same_margins():
    solid = np.where(COMPUTED, 0, -1).astype(np.int16)
    first, second = (margins_of(picture(SEEN), solid) for _ in range(2))
    assert (first == second).all()


def test_a_margin_hides_nothing():
    item, mesh = ball((0.62, 4.6, 0.2), 0.25)
    narrow, narrow_mesh = table(size=(0.94, 0.8, 0.5))
    wide, wide_mesh = table(size=(1.04, 0.8, 0.5))
    shown = Compositor(scene_of([item], {"ball": mesh}, [narrow], {"table": narrow_mesh}))
    seen = np.isfinite(shown.background_depth)
    plate = picture(seen)

    def pixels(support, support_mesh, plate):
        scene = scene_of([item], {"ball": mesh}, [support], {"table": support_mesh}, plate=plate)
        return (Compositor(scene).frame(*initial_poses(scene)).ids == 0).sum()

    true = pixels(narrow, narrow_mesh, plate)
    cut = pixels(wide, wide_mesh, picture(np.zeros_like(seen)))
    assert cut < 0.95 * true
    assert pixels(wide, wide_mesh, plate) == pytest.approx(true, rel=0.02)
