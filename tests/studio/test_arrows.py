"""Arrows begin where a thing ends, and a dragged tip gives the vector it shows."""

from __future__ import annotations

import numpy as np
import pytest

from physagent_studio.studio.scene.arrows import Arrow
from physagent_studio.studio.scene.marks import tip_of


def _arrow(vector: tuple[float, float, float], gap: float) -> Arrow:
    reach = (gap, 2 * gap, 3 * gap)
    return Arrow("a", np.array([1.0, 2.0, 3.0]), np.array(vector), 0.25, "", "action", reach)


def test_it_begins_at_the_surface_and_keeps_its_length() -> None:
    one = _arrow((0.5, 0, 0), 0.1)
    assert one.foot == pytest.approx([1.1, 2, 3])
    assert one.tip == pytest.approx([1.6, 2, 3])
    assert np.linalg.norm(one.tip - one.foot) == pytest.approx(0.5)


@pytest.mark.parametrize("tip", [(1.9, 2.0, 3.0), (1.0, 1.2, 3.4), (0.2, 2.0, 3.0)])
def test_a_dragged_tip_stays_under_the_hand(tip: tuple[float, float, float]) -> None:
    one = _arrow((0.5, 0, 0), 0.1)
    vector = one.vector_to(np.array(tip))
    moved = Arrow("a", one.middle, vector, 0.25, "", "action", one.reach)
    assert moved.tip == pytest.approx(tip)


def test_nothing_has_no_direction() -> None:
    one = _arrow((0, 0, 0), 0.1)
    assert one.foot == pytest.approx(one.middle)
    assert np.isfinite(one.vector_to(one.middle)).all()


def test_a_pointer_beside_the_world_is_refused() -> None:
    middle, eye = np.zeros(3), np.array([0.0, -5.0, 2.0])
    assert tip_of(middle, eye, np.array([0.0, -4.0, 2.0]), free=False) is None
    assert tip_of(middle, eye, np.full(3, np.inf), free=True) is None
    level = tip_of(middle, eye, np.array([1.0, -2.5, 1.0]), free=False)
    assert level is not None
    assert level[2] == pytest.approx(0)
