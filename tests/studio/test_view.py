"""The playhead: where it goes while playing, and where it stops."""

from __future__ import annotations

from dataclasses import replace

import pytest
from hypothesis import given
from hypothesis import strategies as st

from physagent_studio.program import Clip
from physagent_studio.program.timing import clip_at
from physagent_studio.studio.view import View, advance

CLIP = Clip()


def test_real_time_at_speed_one() -> None:
    view = View(playing=True)
    assert advance(view, CLIP, 1.0).step == round(1.0 / CLIP.step_seconds)
    assert advance(replace(view, speed=0.25), CLIP, 1.0).step == 25


def test_slow_motion_plays_as_it_is_shown() -> None:
    slow = clip_at(CLIP, 0.4)
    after = advance(View(playing=True), slow, 1.0)
    # A second of the video is as many frames as it has in a second.
    assert after.frame(slow) == slow.playback_fps
    assert after.step * slow.step_seconds == pytest.approx(0.4)


def test_it_stops_at_the_end_or_begins_again() -> None:
    near = View(step=CLIP.steps - 5, playing=True)
    assert advance(replace(near, loop=False), CLIP, 1.0) == replace(
        near, loop=False, step=CLIP.steps, playing=False
    )
    again = advance(near, CLIP, 0.1)
    assert again.playing
    assert again.step == 5


def test_a_part_is_repeated() -> None:
    view = View(step=60, playing=True, loop_start=10, loop_end=20)
    assert advance(view, CLIP, 0.3).step == 50


@given(st.integers(-5, 400))
def test_a_frame_outside_is_brought_inside(frame: int) -> None:
    view = View().at_frame(frame, CLIP)
    assert 0 <= view.frame(CLIP) < CLIP.frames
    assert view.step <= CLIP.steps


@given(st.integers(0, 320), st.floats(0, 20), st.sampled_from([0.125, 1, 4]), st.booleans())
def test_never_outside_the_clip(step: int, seconds: float, speed: float, loop: bool) -> None:
    view = View(step=step, playing=True, speed=speed, loop=loop)
    assert 0 <= advance(view, CLIP, seconds).step <= CLIP.steps
