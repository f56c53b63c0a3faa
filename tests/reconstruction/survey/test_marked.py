"""Masks of what is marked: a surface is looked for by its clicks, within the box around it."""

from __future__ import annotations

import numpy as np

from physagent_studio.program.scene.state import Click, Grounding, SceneState, Support
from physagent_studio.reconstruction.survey.marked import candidates_of
from physagent_studio.records import Case
from physagent_studio.records.scene import Candidate


class _Everything:
    """Takes all of the picture for whatever is asked for, and keeps what that was."""

    def __init__(self) -> None:
        self.asked: dict[str, Grounding] = {}

    def segment(self, image, groundings, cancelled=None):
        self.asked = dict(groundings)
        return {n: (Candidate(np.ones(image.shape[:2], bool), 0.5, "all"),) for n, _ in groundings}


def test_a_surface_is_no_larger_than_the_box_around_it() -> None:
    image = np.full((80, 120, 3), 128, np.uint8)
    said = Grounding(points=(Click(x=60, y=60),), box=(10, 50, 110, 76))
    table = Support(name="table", grounding=said)
    case = Case("table", image, "", (), (table,), (), "The ball rolls off the table.")
    segmenter = _Everything()
    state = SceneState(supports=(table,))
    offers = candidates_of(case, state, None, segmenter, lambda: None, None)
    mask = offers["table"][0].mask
    assert segmenter.asked["table"].box is None
    assert mask[50:76, 10:110].all()
    assert mask.sum() == 26 * 100
