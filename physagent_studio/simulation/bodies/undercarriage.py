"""The wheels under a body that would not stand without them.

What is inflated from its outline stands on what of it is lowest in the picture. A car that is seen
at an angle has its far wheels higher there, so that its body would fall over where the car stands.
"""

import math
from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from physagent_studio.arrays import FloatArray
from physagent_studio.program.rotations import cross, matrix_of
from physagent_studio.program.scene.state import SceneObject, Wheels
from physagent_studio.simulation.bodies.solids import Hull, Primitive, Solid

UPRIGHT = math.cos(math.radians(40))
"""Least cosine between its own up and the normal of what carries it, standing on its wheels."""
ARM = 0.3
"""Half a wheelbase over the length: axles are about three fifths of the length apart."""
TRACK = 0.4
"""Half the distance across between wheels, over the width: they are near its sides."""
TYRE = 0.05
"""Radius of what stands for a wheel where it meets the ground, over the body's height."""
MARGIN = 0.12
"""Least distance of the centre of mass from the rim of the base, over the base's width."""
BEARING = np.radians(np.arange(0.0, 360.0, 5.0))


def axes_of(given: Wheels, rotation: Sequence[float]) -> tuple[FloatArray, FloatArray]:
    """Its own up and the way its front points, unit vectors (3,) in the body frame."""
    turn = matrix_of(list(rotation))
    # Its own up is the axis of its body that is: what stands on a slope is turned with it.
    axis = int(np.argmax(np.abs(turn[2])))
    own = math.copysign(1.0, turn[2, axis]) * np.eye(3)[axis]
    up = own if abs(turn[2, axis]) > UPRIGHT else turn.T @ (0.0, 0.0, 1.0)
    x, y, z = turn @ up
    angle = math.radians(given.heading)
    ahead = np.array([math.cos(angle), math.sin(angle), 0.0])
    # Seen from above it points along the heading, and lies across its own up.
    ahead[2] = -(ahead[0] * x + ahead[1] * y) / z
    return up, turn.T @ (ahead / math.hypot(*ahead))


def on_wheels(solid: Solid, item: SceneObject) -> Solid:
    """The solid with four wheels under it, where its own base does not carry its centre of mass."""
    if item.wheels is None or not all(isinstance(piece, Hull) for piece in solid.pieces):
        return solid
    points = np.concatenate([piece.vertices for piece in solid.pieces if isinstance(piece, Hull)])
    up, ahead = axes_of(item.wheels, item.rotation)
    frame = np.stack([ahead, np.array(cross(up, ahead)), up])
    own = points @ frame.T
    if _stands(own, frame @ solid.mass.centre):
        return solid
    low, high = own.min(0), own.max(0)
    middle, size = (low + high) / 2, high - low
    radius = TYRE * float(size[2])
    spots = [
        (middle[0] + along * ARM * size[0], middle[1] + side * TRACK * size[1], low[2] + radius)
        for along in (-1, 1)
        for side in (-1, 1)
    ]
    places = [tuple(float(v) for v in np.array(spot) @ frame) for spot in spots]
    tyres = tuple(Primitive("sphere", (radius, 0.0, 0.0), (x, y, z)) for x, y, z in places)
    return replace(solid, rims=(*solid.rims, *tyres))


def _stands(points: FloatArray, centre: FloatArray) -> bool:
    """Whether a body (V, 3), z up, rests on its lowest points with its centre of mass over them."""
    low = float(points[:, 2].min())
    base = points[points[:, 2] < low + 1e-3 * float(np.ptp(points[:, 2])), :2] - centre[:2]
    reach = (base @ np.stack([np.cos(BEARING), np.sin(BEARING)])).max(0)
    width = reach + np.roll(reach, len(BEARING) // 2)
    return bool(reach.min() > MARGIN * width.min() > 0)
