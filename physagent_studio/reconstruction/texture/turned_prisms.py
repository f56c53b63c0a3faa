"""What stands over a turned footprint: what the photo does not show is like what lies opposite.

The left half of a car is like its right one, and its far end has the colours of the near one.
Where the opposite side is hardly seen either, what is seen beside it is carried along.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TypeAlias

import numpy as np

from physagent_studio.arrays import FloatArray
from physagent_studio.program.rotations import matrix_of
from physagent_studio.program.scene.camera import Camera
from physagent_studio.program.scene.state import Inflated, SceneObject
from physagent_studio.reconstruction.photo.regions import BoolArray
from physagent_studio.records.scene import Mesh


@dataclass(frozen=True, slots=True)
class OppositeSettings:
    """What of a turned body the photo shows well."""

    # sine, 0..0.2: of face and view, below which the photo tells nothing of it
    min_own_sine: float = math.sin(math.radians(4.0))
    # sine, 0.05..0.5: below which it tells too little to be shown elsewhere
    min_facing_sine: float = math.sin(math.radians(8.0))
    wall_cosine: float = 0.8  # cosine, 0.6..0.95: of a face and a side, to be of that side
    side_share: float = 0.9  # 0.7..1: of the way from its middle to a side, where that begins
    calm_count: int = 3  # count, 0..10: how often normals are made like those around them


OPPOSITE = OppositeSettings()

Shown: TypeAlias = tuple[BoolArray, FloatArray]
"""Which faces (F,), and where (V, 3) in the body frame what they show is."""


def opposite_parts(camera: Camera, item: SceneObject, mesh: Mesh) -> tuple[Shown, ...]:
    """Faces that show what lies across, behind, both, and what is carried there; () for others."""
    shape = item.shape
    if not isinstance(shape, Inflated) or shape.turn is None:
        return ()
    angle = math.radians(shape.turn)
    axes = np.array([[math.cos(angle), math.sin(angle), 0], [-math.sin(angle), math.cos(angle), 0]])
    eye = (np.asarray(camera.position) - np.asarray(item.position)) @ matrix_of(item.rotation)
    reach = mesh.vertices @ axes.T
    low, high = reach.min(0), reach.max(0)
    centre = (low + high) / 2
    normal, middle = _faced(mesh, axes)

    def over(points: FloatArray, which: tuple[int, ...], about: FloatArray) -> FloatArray:
        """Points (N, 3) mirrored along these axes."""
        away = points @ axes.T - about
        return points - 2 * away[:, which] @ axes[list(which)]

    def facing(which: tuple[int, ...]) -> FloatArray:
        """(F,) how squarely one looks at the mirror image of each face."""
        view = eye - over(middle, which, centre)
        towards = (over(normal, which, np.zeros(2)) * view).sum(1)
        return towards / np.maximum(np.linalg.norm(view, axis=1), 1e-12)

    open_ = facing(()) <= OPPOSITE.min_own_sine
    found: list[Shown] = []
    for which in ((1,), (0,), (0, 1)):
        chosen = open_ & (facing(which) > OPPOSITE.min_facing_sine)
        found.append((chosen, over(mesh.vertices, which, centre)))
        open_ &= ~chosen
    # The rim of the side that one looks at more squarely is carried along.
    side = int(np.abs(axes @ eye).argmax())
    near = high[side] if axes[side] @ eye > centre[side] else low[side]
    carried = mesh.vertices + (near - reach[:, side])[:, None] * axes[side]
    return (*found, (open_, carried))


def _faced(mesh: Mesh, axes: FloatArray) -> tuple[FloatArray, FloatArray]:
    """(F, 3) unit normals of faces as those around them have them, and places: on its sides, both

    of the side. One that is seen at a grazing angle is ragged, and its faces would look any way.
    """
    corners = mesh.vertices[mesh.faces]
    own = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    for _ in range(OPPOSITE.calm_count):
        at = np.zeros_like(mesh.vertices)
        for k in range(3):
            np.add.at(at, mesh.faces[:, k], own)
        own = at[mesh.faces].mean(1)
    own /= np.maximum(np.linalg.norm(own, axis=1, keepdims=True), 1e-12)
    along = own @ axes.T
    reach = mesh.vertices @ axes.T
    low, high = reach.min(0), reach.max(0)
    at = (2 * corners.mean(1) @ axes.T - low - high) / np.maximum(high - low, 1e-12)
    upright = np.abs(own[:, 2:]) < OPPOSITE.wall_cosine
    beside = (np.abs(at) > OPPOSITE.side_share) & upright & (at * along > 0)
    squarely = np.abs(along) + beside
    axis = squarely.argmax(1)
    rows = np.arange(len(own))
    sign = np.sign(along[rows, axis])
    wall = sign[:, None] * axes[axis]
    middle, half = corners.mean(1), (high - low)[axis] / 2
    # The middle of its side, as high as the face.
    inner = (low + high) / 2 @ axes
    place = np.column_stack([(inner + half[:, None] * wall)[:, :2], middle[:, 2]])
    is_wall = (squarely.max(1) > OPPOSITE.wall_cosine)[:, None]
    return np.where(is_wall, wall, own), np.where(is_wall, place, middle)
