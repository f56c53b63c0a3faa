"""Tables whose front shows below their top: the top ends where its corners are seen."""

import math

import cv2
import numpy as np
import pytest

from physagent_studio.program.scene.camera import Camera
from physagent_studio.program.scene.state import Box, Slab
from physagent_studio.reconstruction import mesh_of
from physagent_studio.reconstruction.shapes.silhouettes import look
from physagent_studio.reconstruction.supports.seen_ends import Shown, to_seen_ends

SIZE = (832, 480)
CAMERA = Camera.from_horizon(SIZE, -90.0, 1.0, focal=900)
TABLE = Slab(position=(0.0, 1.9, 0.35), size=(0.6, 0.4, 0.1), yaw=0.5)


def _photo(wall: tuple[int, int, int]) -> tuple[np.ndarray, np.ndarray]:
    """A picture of the table before a plain wall, and its pixels, top and front."""
    mesh = mesh_of(Box(size=TABLE.size))
    cos, sin = math.cos(TABLE.yaw), math.sin(TABLE.yaw)
    points = mesh.vertices @ np.array([[cos, sin, 0], [-sin, cos, 0], [0, 0, 1]])
    mask = look(CAMERA, {"table": (points + TABLE.position, mesh.faces)}).owner == 0
    image = np.full((SIZE[1], SIZE[0], 3), wall, np.uint8)
    image[mask] = (170, 120, 70)
    return np.asarray(cv2.GaussianBlur(image, (0, 0), 1.0), np.uint8), mask


def _grown(by: float, side: int) -> Slab:
    """The table with its near side (1) or its far side (-1) farther out, m."""
    out = -side * by / 2 * np.array([-math.sin(TABLE.yaw), math.cos(TABLE.yaw)])
    x, y, z = TABLE.position
    size = (TABLE.size[0], TABLE.size[1] + by, TABLE.size[2])
    return TABLE.model_copy(update={"position": (x + out[0], y + out[1], z), "size": size})


STANDING = np.array([TABLE.position[:2]])


def _found(slab: Slab, image: np.ndarray, mask: np.ndarray, covered: np.ndarray) -> Slab:
    return to_seen_ends(Shown(image, covered), CAMERA, slab, mask & ~covered, STANDING)


@pytest.mark.parametrize("by", [0.06, 0.3])
@pytest.mark.parametrize("side", [1, -1])
def test_a_side_is_moved_in_to_where_the_table_is_seen_to_end(by, side):
    image, mask = _photo((190, 190, 200))
    found = _found(_grown(by, side), image, mask, np.zeros_like(mask))
    assert found.size == pytest.approx(TABLE.size, abs=0.045)
    assert found.position == pytest.approx(TABLE.position, abs=0.025)


def test_what_is_right_or_not_told_stays():
    image, mask = _photo((190, 190, 200))
    nothing = np.zeros_like(mask)
    assert _found(TABLE, image, mask, nothing).size == pytest.approx(TABLE.size, abs=0.01)
    plain, _ = _photo((170, 120, 70))
    wide = _grown(0.1, 1)
    assert _found(wide, plain, mask, nothing).size == pytest.approx(wide.size)
    assert _found(wide, image, nothing, nothing) == wide


def test_a_top_goes_on_behind_what_hides_its_end():
    image, mask = _photo((190, 190, 200))
    far = np.argwhere(mask)[:, 0].min()
    covered = np.zeros_like(mask)
    covered[: far + 25] = True
    wide = _grown(0.1, -1)
    assert _found(wide, image, mask, covered).size[1] > wide.size[1] - 0.02
