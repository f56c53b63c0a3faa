"""The rows on new pictures: chances are held against what came."""

import numpy as np

from physagent_studio.benchmark.reconstruction.many_parts import (
    Cut,
    calibration_error,
    doubt_rows,
    many_part_rows,
)


def test_chances_that_come_true_have_hardly_an_error() -> None:
    rng = np.random.default_rng(1)
    chance = rng.random(20000)
    good = rng.random(20000) < chance
    assert calibration_error(chance, good) < 0.02
    assert calibration_error(np.ones(100), np.zeros(100, bool)) == 1.0
    assert calibration_error(chance, rng.random(20000) < chance / 2) > 0.2


def test_shares_are_told_apart() -> None:
    cuts = [Cut("click", 0.9, 0.95)] * 3 + [Cut("box", 0.9, 0.3)] + [Cut("click", 0.4, 0.2)] * 2
    cuts += [Cut("box", 0.5, 0.9)]
    found = {row.name.removeprefix("doubt: "): row.value for row in doubt_rows(cuts)}
    assert found["sure masks that are good"] == 3 / 4
    assert found["poor masks that are doubted"] == 2 / 3
    assert found["good masks that are doubted"] == 1 / 4
    assert found["good masks that are sure"] == 3 / 4


def test_one_picture_gives_all_rows() -> None:
    rows = {row.name: row.value for row in many_part_rows([3])}
    assert float(rows["many parts: things"]) >= 1
    for way in ("click", "box"):
        assert 0 <= float(rows[f"many parts, {way}: mask IoU, median"]) <= 1
