from functools import cache

import numpy as np
import pytest

from physagent_studio.benchmark.scenes import Pictured, scene


@cache
def drawn_once(seed: int) -> Pictured:
    return scene(seed)


@pytest.mark.parametrize("seed", [1, 4])
def test_a_seed_gives_the_same_bits_twice(seed: int) -> None:
    one, other = drawn_once(seed), scene(seed)
    np.testing.assert_array_equal(one.image, other.image)
    assert [s.name for s in one.subjects] == [s.name for s in other.subjects]
    for mine, theirs in zip(one.subjects, other.subjects, strict=True):
        np.testing.assert_array_equal(mine.mask, theirs.mask)
        assert (mine.click, mine.box) == (theirs.click, theirs.box)


@pytest.mark.parametrize("seed", [1, 4])
def test_every_thing_is_clicked_on_and_boxed(seed: int) -> None:
    drawn = drawn_once(seed)
    assert drawn.subjects
    for subject in drawn.subjects:
        (click,) = subject.click.points
        assert subject.mask[int(click.y), int(click.x)]
        box = subject.box.box
        assert box is not None
        rows, columns = subject.mask.nonzero()
        assert box[0] < columns.min()
        assert columns.max() < box[2]
        assert box[1] < rows.min()
        assert rows.max() < box[3]
    owners = sum(subject.mask.astype(int) for subject in drawn.subjects)
    assert np.max(owners) == 1


@pytest.mark.parametrize("seed", [4, 36])
def test_a_picture_is_emptied_also_where_nothing_else_stands(seed: int) -> None:
    drawn = drawn_once(seed)
    assert bool(drawn.stage.others) == (seed != 36)
    empty, covered = drawn.emptied(), np.any([s.mask for s in drawn.subjects], axis=0)
    off = np.abs(empty.astype(float) - drawn.image).mean(-1)
    assert np.median(off[covered]) > 20
    assert np.median(off[~covered]) < 5
