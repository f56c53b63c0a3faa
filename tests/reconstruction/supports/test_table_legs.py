"""The height of a table from its legs, whether its mask has them or not."""

import math

import cv2
import numpy as np
import pytest

from physagent_studio.program.scene.camera import Camera
from physagent_studio.program.scene.state import Box, SceneState, Support
from physagent_studio.reconstruction import mesh_of
from physagent_studio.reconstruction.photo.line_segments import segments
from physagent_studio.reconstruction.shapes.silhouettes import look
from physagent_studio.reconstruction.supports.table_legs import rises_by_legs

SIZE = (832, 480)
WIDE, DEEP, BOARD, LEG = 0.5, 0.36, 0.03, 0.035
STATE = SceneState(supports=(Support(name="low_table"),))


def _camera(pitch: float) -> Camera:
    return Camera.from_horizon(SIZE, 240 - 620 * math.tan(math.radians(pitch)), 0.7, focal=620)


def _table(top: float, yaw: float) -> dict[str, tuple[np.ndarray, np.ndarray]]:
    """Board and legs of a table whose top is `top` m high, in the world."""
    cos, sin = math.cos(yaw), math.sin(yaw)
    parts = {"board": ((WIDE, DEEP, BOARD), (0.0, 0.0, top - BOARD / 2))}
    inset = LEG / 2 + 0.01
    for k, (x, y) in enumerate(((-1, -1), (1, -1), (1, 1), (-1, 1))):
        place = (x * (WIDE / 2 - inset), y * (DEEP / 2 - inset), (top - BOARD) / 2)
        parts[f"leg_{k}"] = ((LEG, LEG, top - BOARD), place)
    out = {}
    for name, (size, (x, y, z)) in parts.items():
        mesh = mesh_of(Box(size=size))
        points = mesh.vertices + np.array([x, y, z])
        flat = points[:, :2] @ np.array([[cos, sin], [-sin, cos]]) + (0.05, 1.25)
        out[name] = (np.column_stack([flat, points[:, 2]]), mesh.faces)
    return out


@pytest.mark.parametrize(("pitch", "top", "yaw"), [(16, 0.2, 0.1), (24, 0.3, -0.2)])
@pytest.mark.parametrize("whole", [True, False])
def test_legs_say_how_high_a_table_is(pitch, top, yaw, whole):
    camera = _camera(pitch)
    seen = look(camera, _table(top, yaw))
    board, legs = seen.owner == 0, seen.owner > 0
    image = np.full((SIZE[1], SIZE[0], 3), np.uint8(200))
    image[board], image[legs] = (150, 110, 70), (90, 60, 40)
    found = segments(np.asarray(cv2.GaussianBlur(image, (0, 0), 0.7), np.uint8))
    mask = board | legs if whole else board
    covered = np.zeros_like(board)
    rises = rises_by_legs(STATE, camera, {"low_table": (mask,)}, covered, found)
    assert rises["low_table"] * 0.7 == pytest.approx(top, rel=0.12)


def test_hidden_feet_and_bodies_without_legs_say_nothing():
    camera = _camera(16)
    seen = look(camera, _table(0.2, 0.1))
    mask = seen.owner >= 0
    blank = segments(np.full((SIZE[1], SIZE[0], 3), np.uint8(200)))
    feet = np.zeros_like(mask)
    feet[np.flatnonzero(mask.any(1))[-1] - 40 :] = True
    assert rises_by_legs(STATE, camera, {"low_table": (mask,)}, feet, blank) == {}
    board = {"low_table": (seen.owner == 0,)}
    assert rises_by_legs(STATE, camera, board, np.zeros_like(mask), blank) == {}
    solid = SceneState(supports=(Support(name="wooden_box"),))
    assert rises_by_legs(solid, camera, {"wooden_box": (mask,)}, np.zeros_like(mask), blank) == {}
