"""Which masks are doubted: all that no person has settled."""

from __future__ import annotations

import numpy as np
import pytest

from physagent_studio.program.scene.state import Grounding, Stroke
from physagent_studio.reconstruction.masks.sureness import sureness

PHOTO = np.full((120, 160, 3), 90, np.uint8)
PHOTO[40:80, 60:110] = (200, 60, 40)
MASK = np.zeros((120, 160), bool)
MASK[40:80, 60:110] = True


@pytest.mark.parametrize(
    ("marks", "doubted"),
    [
        ({}, True),
        ({"candidate": 2}, True),  # as the planner takes another mask
        ({"candidate": 2, "settled": True}, False),
        ({"strokes": (Stroke(radius=3.0, points=((70.0, 50.0),)),)}, False),
    ],
)
def test_only_what_a_person_settled_has_no_probability(marks: dict, doubted: bool) -> None:
    own = Grounding(box=(58.0, 38.0, 112.0, 82.0)).model_copy(update=marks)
    sure = sureness(PHOTO, {"block": MASK}, {}, [("block", own)])
    assert ("block" in sure) == doubted
