"""Another size of picture: what belongs together stays together."""

from __future__ import annotations

import numpy as np
import pytest

from physagent_studio.errors import InputError
from physagent_studio.exchange.prior.framing import Framing
from physagent_studio.rendering import Flow

SIZES = [(832, 480), (480, 832), (720, 480), (1280, 720)]


@pytest.mark.parametrize("after", SIZES)
@pytest.mark.parametrize("way", ["crop", "letterbox"])
def test_the_camera_stays_true(after, way):
    before = (416, 312)
    framing = Framing.of(before, after, way)
    matrix = np.array([[400.0, 0, 208], [0, 400, 156], [0, 0, 1]])
    picture = np.zeros((312, 416, 3), np.uint8)
    # A patch around where a point of space is seen.
    point = np.array([0.05, 0.1, 1.0])
    x, y = (matrix @ point)[:2]
    picture[int(y) - 3 : int(y) + 3, int(x) - 3 : int(x) + 3] = 255
    shown = framing.picture(picture)
    assert shown.shape == (after[1], after[0], 3)
    to_x, to_y, _ = framing.intrinsics(matrix) @ point
    rows, columns = np.nonzero(shown[..., 0] > 127)
    assert np.hypot(columns.mean() + 0.5 - to_x, rows.mean() + 0.5 - to_y) < 1.0
    ids = framing.labels((picture[..., 0] > 0).astype(np.uint8))
    rows, columns = np.nonzero(ids)
    assert np.hypot(columns.mean() + 0.5 - to_x, rows.mean() + 0.5 - to_y) < 1.0
    edge = shown[0] if framing.offset[1] > 1 else shown[:, 0]
    if way == "letterbox" and max(framing.offset) > 1:
        assert not edge.any()


def test_flow_is_in_pixels_of_the_new_picture():
    framing = Framing.of((416, 240), (832, 480))
    flow = Flow(np.full((240, 416, 2), (3.0, -1.0), np.float32), np.ones((240, 416), bool))
    found = framing.flow(flow)
    assert np.allclose(found.vectors, (6.0, -2.0))
    assert found.visible.all()


def test_sizes_that_no_clip_has_are_refused():
    with pytest.raises(InputError, match="even sides"):
        Framing.of((416, 240), (831, 480))
