"""The photo on a ball, an egg or a fruit, of which it shows less than half.

The rim of that is seen at too flat an angle to be of use when the thing has rolled. The body is
covered by the six sides of a cube around it: the first looks at the camera and is the photo, the
others are painted by `ball.Ball`; where they meet they pass into one another.
"""

from __future__ import annotations

from enum import IntEnum

import numpy as np
from numpy.typing import NDArray

from physagent_studio.arrays import BoolArray, FloatArray
from physagent_studio.program.rotations import matrix_of
from physagent_studio.program.scene.camera import Camera
from physagent_studio.program.scene.state import SceneObject
from physagent_studio.reconstruction.switches import at_work
from physagent_studio.reconstruction.texture.ball import BALL, FOLDS, Ball
from physagent_studio.reconstruction.texture.round_light import radii_of
from physagent_studio.records.case import Image
from physagent_studio.records.scene import Mesh


class _Side(IntEnum):
    """What belongs to no side of the body: stems and leaves."""

    PART = -1


def round_textured(
    camera: Camera,
    item: SceneObject,
    mesh: Mesh,
    mask: BoolArray,
    crop: tuple[Image, tuple[int, int]],
    lit: bool = True,
) -> Mesh | None:
    """The mesh of a ball or an ellipsoid with the photo on all its sides.

    None for others. crop: the photo around the thing (h, w, 3) and its top left corner (x, y) in
    the photo. lit: whether its light is on it.
    """
    radii = radii_of(item) if at_work("round bodies") else None
    if radii is None:
        return None
    away = np.linalg.norm(mesh.vertices / radii, axis=1)
    beside = away - 1 > BALL.max_off_ratio
    shown = BALL.shown_deg if lit or not at_work("rim shade") else BALL.unlit_shown_deg
    ball = Ball.of(camera, item, radii, crop, shown).lit(mask)
    if beside.any() and ball.strange > BALL.many_colours_log:
        # A body of several colours with a handle on it: its front says little of its other sides.
        return None
    turned = mesh.vertices @ matrix_of(item.rotation).T
    ways = np.linalg.solve(ball.stretch, turned.T).T @ ball.frame
    ways /= np.maximum(np.linalg.norm(ways, axis=1, keepdims=True), 1e-12)
    middle = ways[mesh.faces].mean(1)
    side = np.argmax([(middle @ fold.T)[:, 2] for fold in FOLDS], 0)
    # Stems and leaves are as thin as they are seen, and show the same from behind.
    side = np.where(beside[mesh.faces].sum(1) > 1, _Side.PART, side)
    return _laid_out(ball, mesh, ways, turned, side)


def _laid_out(
    ball: Ball,
    mesh: Mesh,
    ways: FloatArray,
    turned: FloatArray,
    side: NDArray[np.intp],
) -> Mesh:
    """Every side's faces with vertices of their own, and the sides' pictures beside the crop.

    turned: (V, 3) vertices from the middle, world.
    """
    rows, columns = ball.photo.shape[:2]
    across = int(np.clip(0.8 * min(rows, columns), *BALL.side_px))
    texture = np.zeros((max(rows, across), columns + across * (len(FOLDS) - 1), 3), np.uint8)
    texture[:rows, :columns] = ball.photo
    vertices, faces, places = [], [], []
    count = 0
    for number, fold in enumerate([*FOLDS, FOLDS[0]]):
        number = _Side.PART if number == len(FOLDS) else number
        own = mesh.faces[side == number]
        used, compact = np.unique(own, return_inverse=True)
        vertices.append(mesh.vertices[used])
        faces.append(compact.reshape(-1, 3) + count)
        count += len(used)
        if number == 0:
            places.append(ball.pixels(ways[used]))
            continue
        if number == _Side.PART:
            places.append(ball.camera.project(ball.place + turned[used])[0] - ball.origin)
            continue
        left = columns + across * (number - 1)
        texture[:across, left : left + across] = _picture(ball, fold, across)
        local = ways[used] @ fold.T
        flat = local[:, :2] / np.maximum(local[:, 2:], 0.2)
        spot = (
            (np.clip(flat, -BALL.side_half_ratio, BALL.side_half_ratio) / BALL.side_half_ratio + 1)
            / 2
            * across
        )
        places.append(np.clip(spot, 0.5, across - 0.5) + np.array([left, 0]))
    uv = np.concatenate(places)
    edge = np.array([texture.shape[1], texture.shape[0]])
    return Mesh(
        np.concatenate(vertices),
        np.concatenate(faces).astype(np.int32),
        np.clip(uv, 0.5, edge - 0.5),
        texture,
        mesh.color,
    )


def _picture(ball: Ball, fold: FloatArray, across: int) -> Image:
    """What a side shows, (across, across, 3)."""
    y, x = ((np.indices((across, across)) + 0.5) / across * 2 - 1) * BALL.side_half_ratio
    local = np.stack([x.ravel(), y.ravel(), np.ones(across * across)], 1)
    local /= np.linalg.norm(local, axis=1, keepdims=True)
    colours = ball.colours(local @ fold)  # The folds are their own inverses but for a transpose.
    return np.clip(colours + 0.5, 0, 255).reshape(across, across, 3).astype(np.uint8)
