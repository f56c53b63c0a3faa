"""The small dose of `physagent bench motion-prior`: what has no clock in it."""

from __future__ import annotations

import cv2
import numpy as np
import pytest

from physagent_studio.benchmark.hostile import _files, refusal
from physagent_studio.benchmark.motion_prior.bench import _frames, _truth, against_truth, occlusions
from physagent_studio.benchmark.motion_prior.scenes import MOTIONS
from physagent_studio.rendering import flow_between


def test_flow_and_occlusion_hold_against_closed_forms():
    rows = [*against_truth(), *occlusions()]
    assert [row.name for row in rows if not row.ok] == []
    assert len(rows) == 5


def test_truth_tells_a_wrong_flow_from_a_right_one():
    motion = MOTIONS[0]
    first, second = _frames(motion)
    truth, inner = _truth(motion)
    right = flow_between(first, second).vectors
    # Forward taken for backward, and x for y, as mistakes go.
    for wrong in (-right, right[..., ::-1], flow_between(second, first).vectors):
        assert np.linalg.norm(wrong - truth, axis=-1)[inner].mean() > 1
    grey = [cv2.cvtColor(frame.rgb, cv2.COLOR_RGB2GRAY) for frame in (first, second)]
    assert np.abs(grey[0].astype(int) - grey[1])[inner].mean() > 1


@pytest.mark.slow
def test_hostile_files_of_every_kind_are_refused_in_a_sentence():
    kinds = set()
    for name, data, reader in _files():
        said = refusal(name, data, reader)
        assert said is not None, name
        assert 0 < len(said) < 600, name
        assert "Traceback" not in said, name
        kinds.add(name)
    assert len(kinds) >= 16
