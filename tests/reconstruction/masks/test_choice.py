"""What a person is offered beside the first mask."""

import numpy as np

from physagent_studio.reconstruction.masks.choice import CHOICE, agreed
from physagent_studio.reconstruction.masks.draft_score import Draft

ROWS, COLUMNS = np.mgrid[:90, :120]
GREY = np.full((90, 120, 3), 128, np.float32)


def _disc(radius, x=60.0):
    return np.hypot(ROWS - 45, COLUMNS - x) < radius


def _scored(masks):
    return [(Draft(mask, f"draft-{k}", "colour"), value) for k, (mask, value) in enumerate(masks)]


def test_less_likely_readings_of_another_size_come_before_more_of_the_same():
    # Several readings of a part, each a little off, then the whole and a group, both less likely.
    parts = [(_disc(18, 60 + 0.6 * k), 0.8 - 0.01 * k) for k in range(4)]
    ranked = _scored([*parts, (_disc(30), 0.7), (_disc(42), 0.66)])
    offered = agreed(ranked, GREY)
    assert len(offered) <= CHOICE.max_offers_count
    methods = [draft.method for draft, _ in offered]
    assert methods[:2] == ["draft-0", "draft-4"]
    assert "draft-5" in methods
    values = [value for _, value in offered]
    assert values == sorted(values, reverse=True)


def test_where_all_agree_variants_of_the_first_are_offered():
    ranked = _scored([(_disc(20 + 0.01 * k), 0.9) for k in range(5)])
    offered = agreed(ranked, GREY)
    assert [draft.method for draft, _ in offered] == ["draft-0", "tighter", "wider"]
    assert agreed([], GREY) == []
