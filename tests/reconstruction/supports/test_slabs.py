"""How far a level top goes where no edge of it is seen: no farther than a box drawn around it."""

from __future__ import annotations

import numpy as np

from physagent_studio.program.scene.camera import Camera
from physagent_studio.program.scene.state import Slab
from physagent_studio.reconstruction.camera.rays import on_plane
from physagent_studio.reconstruction.photo.line_segments import segments
from physagent_studio.reconstruction.supports.slabs import fit_slab

SIZE = (640, 480)
CAMERA = Camera.from_horizon(SIZE, 60.0, 1.2, focal=700)
TOP = 0.4
PLAIN = segments(np.full((SIZE[1], SIZE[0], 3), 200, np.uint8))


def _slab(left: int, right: int, *, boxed: bool) -> Slab:
    region = np.zeros((SIZE[1], SIZE[0]), bool)
    region[250:330, left:right] = True
    foot = [((left + right) / 2, 300.0)]
    slab = fit_slab(CAMERA, TOP, region, PLAIN, foot, [10.0], (), 0.05, boxed=boxed)
    assert slab is not None
    return slab


def _sides(slab: Slab) -> tuple[float, float]:
    middle, half = slab.position[0], slab.size[0] / 2
    return middle - half, middle + half


def test_a_top_in_a_box_ends_with_what_is_seen_of_it_in_the_box() -> None:
    columns = [(240.0, 250.5), (400.0, 250.5)]
    left, right = on_plane(CAMERA, columns, TOP)[:, 0]
    found = _sides(_slab(240, 400, boxed=True))
    np.testing.assert_allclose(found, (left, right), atol=0.1 * (right - left))
    wider = _sides(_slab(240, 400, boxed=False))
    assert wider[0] < left - 0.3 * (right - left)
    assert wider[1] > right + 0.3 * (right - left)


def test_a_box_at_the_border_of_the_picture_says_nothing_of_what_lies_outside() -> None:
    (edge,) = on_plane(CAMERA, [(640.0, 250.5)], TOP)[:, 0]
    _, right = _sides(_slab(400, 640, boxed=True))
    assert right > edge + 0.2
