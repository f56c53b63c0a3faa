"""Boards of one shelf are above one another, each as high as it is seen."""

import numpy as np
import pytest

from physagent_studio.knowledge import Usual
from physagent_studio.program.scene.camera import Camera
from physagent_studio.program.scene.state import Click, Grounding, SceneState, Support
from physagent_studio.reconstruction.supports.shelves import boards_of, on_boards, shelf_rises
from physagent_studio.reconstruction.supports.stances import Stance

CAMERA = Camera.from_horizon((640, 480), 100.0, 1.0, focal=600.0)
FAR, HEIGHTS = 2.4, {"lower_shelf": 0.25, "middle_shelf": 0.7, "top_shelf": 1.2}


def _pixel(x, z, y=FAR):
    return CAMERA.project(np.array([[x, y, z]]))[0][0]


def _state():
    clicks = {name: _pixel(0.1, z) for name, z in HEIGHTS.items()}
    return SceneState(
        supports=tuple(
            Support(name=name, grounding=Grounding(points=(Click(x=x, y=y),)))
            for name, (x, y) in reversed(clicks.items())
        )
    )


def _stance(name, foot, extent):
    x, y = (float(v) for v in foot)
    box = (round(x - extent / 2), round(y - extent), round(x + extent / 2), round(y))
    return Stance(name, box, (x, y))


def test_boards_and_what_stands_on_them():
    boards = boards_of(_state(), 480)
    assert list(boards) == list(HEIGHTS)
    # Things of 0.2 m: one on the top board, one on the ground at half the way.
    size = 0.2 * CAMERA.focal
    jar = _stance("jar", _pixel(0.3, 1.2), round(size / 2.3))
    ball = _stance("ball", _pixel(-0.2, 0.0, 1.2), round(size / 1.5))
    stances = {"jar": jar, "ball": ball}
    on = on_boards(boards, _state(), stances, dict.fromkeys(stances, "floor"))
    assert on == {"jar": "top_shelf", "ball": "floor"}
    usual = dict.fromkeys(stances, Usual(0.2, 0.1))
    shares = shelf_rises(boards, CAMERA, stances, on, usual)
    assert list(shares.values()) == pytest.approx(list(HEIGHTS.values()), abs=0.2)
    apart = np.diff(list(shares.values()))
    assert apart[0] / apart[1] == pytest.approx(0.45 / 0.5, rel=0.03)


def test_without_sizes_the_lowest_is_as_high_as_they_are_apart():
    shares = list(shelf_rises(boards_of(_state(), 480), CAMERA, {}, {}, {}).values())
    assert shares[0] == pytest.approx(shares[1] - shares[0], rel=1e-6)
    assert shares == sorted(shares)


def test_one_shelf_or_two_at_one_height_are_no_shelf():
    state = _state()
    alone = state.model_copy(update={"supports": state.supports[:1]})
    assert boards_of(alone, 480) == {}
    twin = state.supports[0].model_copy(update={"name": "other_shelf"})
    assert boards_of(state.model_copy(update={"supports": (*state.supports, twin)}), 480) == {}
