"""What stands over a turned footprint: what the photo does not show is like what lies opposite.

The left half of a car is like its right one. Where the opposite side is hardly seen either, as of
its far end, what is seen beside that comes around its corners; along its top and its bottom, which
bend away from it, the rim is carried along.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TypeAlias

import numpy as np

from physagent_studio.arrays import BoolArray, FloatArray
from physagent_studio.program.rotations import matrix_of
from physagent_studio.program.scene.camera import Camera
from physagent_studio.program.scene.state import Inflated, SceneObject
from physagent_studio.records.scene import Mesh


@dataclass(frozen=True, slots=True)
class OppositeSettings:
    """What of a turned body the photo shows well."""

    # sine, 0..0.2: of face and view, below which the photo tells nothing of it
    min_facing_sine: float = math.sin(math.radians(4.0))
    # 0.2..1: of what comes around a corner, over how far it goes there: less is drawn out
    fold_ratio: float = 0.5
    calm_count: int = 3  # count, 0..10: how often normals are made like those around them


OPPOSITE = OppositeSettings()

Shown: TypeAlias = tuple[BoolArray, FloatArray]
"""Which faces (F,), and where (V, 3) in the body frame what they show is."""


def opposite_parts(camera: Camera, item: SceneObject, mesh: Mesh) -> tuple[Shown, ...]:
    """Faces that show themselves, those that show what lies across, those along which something is
    carried, and the ends around which a side is folded.

    () for what does not stand over a turned footprint.
    """
    shape = item.shape
    if not isinstance(shape, Inflated) or shape.turn is None:
        return ()
    angle = math.radians(shape.turn)
    axes = np.array([[math.cos(angle), math.sin(angle), 0], [-math.sin(angle), math.cos(angle), 0]])
    eye = (np.asarray(camera.position) - np.asarray(item.position)) @ matrix_of(item.rotation)
    reach = mesh.vertices @ axes.T
    low, high = reach.min(0), reach.max(0)
    centre = (low + high) / 2
    normal, middle = _faced(mesh)

    def over(points: FloatArray, about: float) -> FloatArray:
        """Points (N, 3) mirrored across its width."""
        return points - 2 * (points @ axes[1] - about)[:, None] * axes[1]

    def facing(normal: FloatArray, places: FloatArray) -> FloatArray:
        """(F,) how squarely one looks at each face, as a sine."""
        view = eye - places
        return (normal * view).sum(1) / np.maximum(np.linalg.norm(view, axis=1), 1e-12)

    own = facing(normal, middle) > OPPOSITE.min_facing_sine
    opposite = facing(over(normal, 0.0), over(middle, centre[1])) > OPPOSITE.min_facing_sine
    rest = ~own & ~opposite
    # The side that one looks at more squarely tells of what is beside it.
    side = int(np.abs(axes @ eye).argmax())
    near = high[side] if axes[side] @ eye > centre[side] else low[side]
    deep = near - reach[:, side]
    carried = mesh.vertices + deep[:, None] * axes[side]
    end = rest & (np.abs(normal @ axes[1 - side]) > np.abs(normal @ axes[side]))
    end &= np.abs(normal @ axes[1 - side]) > np.abs(normal[:, 2])
    folded = carried + folded_in(reach[:, 1 - side], np.abs(deep))[:, None] * axes[1 - side]
    return (
        (own, mesh.vertices),
        (~own & opposite, over(mesh.vertices, centre[1])),
        (rest & ~end, carried),
        (end, folded),
    )


def folded_in(along: FloatArray, deep: FloatArray) -> FloatArray:
    """(V,) how far along a side lies what comes around its ends, at vertices so far along it (V,)

    and behind it (V,): from both corners of an end to its middle, drawn out, and to no more than
    the side's.
    """
    low, high, wide = along.min(), along.max(), max(float(deep.max()), 1e-12)
    into = np.minimum(deep, wide - deep) * min(OPPOSITE.fold_ratio, (high - low) / wide)
    return np.asarray(into * np.sign((low + high) / 2 - along))


def _faced(mesh: Mesh) -> tuple[FloatArray, FloatArray]:
    """(F, 3) unit normals of faces as those around them have them, and places.

    A side that is seen at a grazing angle is ragged, and its faces would look any way.
    """
    corners = mesh.vertices[mesh.faces]
    own = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    for _ in range(OPPOSITE.calm_count):
        at = np.zeros_like(mesh.vertices)
        for k in range(3):
            np.add.at(at, mesh.faces[:, k], own)
        own = at[mesh.faces].mean(1)
    own /= np.maximum(np.linalg.norm(own, axis=1, keepdims=True), 1e-12)
    return own, corners.mean(1)
