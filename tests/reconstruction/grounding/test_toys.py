"""Whether a large thing's name means the thing itself or a model of it."""

from __future__ import annotations

import pytest

from physagent_studio.knowledge import usual_size
from physagent_studio.reconstruction.grounding.toys import TOY, as_toys


def sizes(extents: dict[str, float]) -> dict[str, float]:
    usual = {name: usual_size(name) for name in extents}
    return {name: found.metres for name, found in as_toys(usual, extents).items()}


@pytest.mark.parametrize(
    ("extents", "toy"),
    [
        ({"red_car": 40.0, "blue_block": 35.0}, True),
        ({"red_car": 90.0, "mug": 60.0}, True),
        ({"car": 300.0, "trash_can": 60.0}, False),
        ({"car": 300.0, "soccer_ball": 15.0}, False),
    ],
)
def test_what_stands_beside_it_tells(extents: dict[str, float], toy: bool) -> None:
    name = next(iter(extents))
    found = sizes(extents)
    assert (found[name] == TOY.size_m) == toy
    if not toy:
        assert found[name] == usual_size(name).metres


def test_alone_it_is_what_its_name_says() -> None:
    assert sizes({"car": 100.0})["car"] == usual_size("car").metres
