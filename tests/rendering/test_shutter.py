"""Motion blur adds up light while a shutter is open; where nothing moves it changes nothing."""

from __future__ import annotations

import numpy as np
import pytest

from physagent_studio.errors import InputError
from physagent_studio.records.clip_look import ClipLook
from physagent_studio.rendering import render_clip
from tests.rendering.scenes import rollout_of


def moving(scene, speed: float):
    """Two frames a step apart, 4 frames; the first thing goes to the right by `speed` each, m."""
    names = [item.name for item in scene.state.objects]
    start = np.array([item.position for item in scene.state.objects])
    positions = np.repeat(start[None], 4, axis=0)
    positions[:, 0, 0] += speed * np.arange(4)
    rotations = np.tile([1.0, 0, 0, 0], (4, len(names), 1))
    return rollout_of(names, positions, rotations)


def test_what_stands_still_keeps_its_bits(two_things):
    rollout = moving(two_things, 0.0)
    plain = [frame.rgb for frame in render_clip(two_things, rollout)]
    blurred = [frame.rgb for frame in render_clip(two_things, rollout, shutter=1.0)]
    assert all(np.array_equal(a, b) for a, b in zip(plain, blurred, strict=True))


def test_what_moves_is_drawn_out_along_its_way_and_keeps_its_light(two_things):
    rollout = moving(two_things, 0.08)
    plain = next(render_clip(two_things, rollout, [1]))
    blurred = next(render_clip(two_things, rollout, [1], shutter=1.0))
    later = next(render_clip(two_things, rollout, [2]))
    changed = np.abs(blurred.rgb.astype(int) - plain.rgb).max(axis=2) > 16
    # Only where the thing is in this frame or comes to by the next, its shadow with it.
    own = (plain.ids == 0) | (later.ids == 0)
    assert np.count_nonzero(changed & own) > 0.6 * np.count_nonzero(changed)
    assert np.count_nonzero(changed) > 100
    assert np.array_equal(plain.ids, blurred.ids)
    light = [((f.rgb / 255.0) ** 2.2).sum() for f in (plain, blurred, later)]
    assert min(light[0], light[2]) * 0.995 < light[1] < max(light[0], light[2]) * 1.005


def test_half_a_shutter_reaches_half_as_far(two_things):
    rollout = moving(two_things, 0.08)
    plain = next(render_clip(two_things, rollout, [1]))
    rows = np.flatnonzero((plain.ids == 0).any(1))
    upper = slice(int(rows.min()), int(rows.mean()))  # shadows lie below it
    widths = []
    for shutter in (0.5, 1.0):
        frame = next(render_clip(two_things, rollout, [1], shutter=shutter))
        changed = np.abs(frame.rgb.astype(int) - plain.rgb).max(2) > 4
        columns = np.flatnonzero(changed[upper].any(0))
        widths.append(columns.max())
    right = np.flatnonzero((plain.ids == 0)[upper].any(0)).max()
    assert 0.3 < (widths[0] - right) / (widths[1] - right) < 0.8


def test_a_shutter_longer_than_a_frame_is_refused():
    with pytest.raises(InputError, match="0 to 1 of a frame"):
        ClipLook(shutter=1.5)
