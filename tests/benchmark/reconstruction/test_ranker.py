"""What is fitted to some photographs is judged on the one that was left out."""

from __future__ import annotations

import numpy as np

from physagent_studio.benchmark.reconstruction.lookalikes import scooter, stack
from physagent_studio.benchmark.reconstruction.ranker import (
    Thing,
    chosen,
    fitted,
    left_out,
    ranking_rows,
    things_of,
)
from physagent_studio.program.scene.state import Click, Grounding
from physagent_studio.reconstruction.masks.draft_score import WEIGHTS
from physagent_studio.records.case import Case

COUNT = len(WEIGHTS)


def _things(rng: np.random.Generator, photo: str, feature: int, many: int = 3) -> list[Thing]:
    """Things whose drafts are as good as one feature says."""
    out = []
    for _ in range(many):
        features = rng.uniform(0, 1, (8, COUNT))
        features[:, 0] = 1.0
        out.append(Thing(photo, features, features[:, feature].copy()))
    return out


def test_what_holds_on_all_photographs_carries_over() -> None:
    rng = np.random.default_rng(1)
    things = [thing for name in "abcd" for thing in _things(rng, name, 3)]
    every = list(range(COUNT))
    best = [float(thing.ious.max()) for thing in things]
    assert np.allclose(left_out(things, every), best)
    assert np.argmax(fitted(things, every)) == 3


def test_what_holds_on_one_photograph_alone_is_not_learned_from_it() -> None:
    rng = np.random.default_rng(2)
    odd = _things(rng, "odd", 5, 6)
    things = [thing for name in "abc" for thing in _things(rng, name, 3, 6)] + odd
    every = list(range(COUNT))
    seen = chosen(odd, fitted(odd, every))
    unseen = left_out(things, every)[-len(odd) :]
    assert sorted({thing.photo for thing in things})[-1] == "odd"
    assert np.mean(seen) > np.mean(unseen) + 0.2


def test_columns_left_out_weigh_nothing() -> None:
    weights = fitted(_things(np.random.default_rng(3), "a", 2), [0, 2])
    assert np.count_nonzero(weights) == 2


def test_drafts_of_a_picture_are_compared_with_the_truth() -> None:
    drawn = scooter(4)
    rows, columns = np.nonzero(drawn.masks["scooter"])
    click = Click(x=float(columns[len(columns) // 2]), y=float(rows[len(rows) // 2]))
    objects = (("scooter", Grounding(points=(click,))),)
    case = Case("drawn", drawn.image, "", objects, (), (), "")
    (thing,) = things_of("drawn", case, drawn.masks)
    assert thing.features.shape == (len(thing.ious), COUNT)
    assert 0 <= thing.ious.min() <= thing.ious.max() <= 1
    assert thing.ious.max() > 0.2
    assert ranking_rows([thing]) == []


def test_lookalikes_are_the_same_each_time_and_apart() -> None:
    for make in (stack, scooter):
        one, again = make(3), make(3)
        assert np.array_equal(one.image, again.image)
        assert np.stack(list(one.masks.values())).sum(0).max() == 1
        assert not np.array_equal(one.image, make(4).image)
