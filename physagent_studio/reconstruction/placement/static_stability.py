"""What is seen at rest stays at rest: centres of mass lie over what carries them."""

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass

import cv2
import numpy as np

from physagent_studio.arrays import FloatArray
from physagent_studio.program.scene.state import SceneObject, Slab
from physagent_studio.reconstruction.shapes.silhouettes import in_world
from physagent_studio.reconstruction.switches import at_work
from physagent_studio.records.scene import Mesh


@dataclass(frozen=True, slots=True)
class StabilitySettings:
    """When what is seen at rest would stay."""

    inside_share: float = 0.08  # 0..0.3: of what carries it: how far in a centre of mass has to lie
    top_share: float = 0.03  # 0.005..0.1: of a body's height, from above, that carries
    max_overhang_share: float = 0.5  # 0..1: of a thing's width, over a seen edge


STABILITY = StabilitySettings()


def nudged(
    item: SceneObject,
    below: SceneObject,
    mesh: Mesh,
    beside: Sequence[tuple[SceneObject, Mesh]] = (),
) -> tuple[float, float, float]:
    """The position of an object with its centre of mass over the top of what carries it.

    mesh: of `below`, body frame. beside: what carries it too (a can on two others). It is moved
    level and no farther than needed; one that lies well is left where it is.
    """
    assert item.position is not None
    x, y, z = item.position
    if not at_work("nudged"):
        return item.position
    tops = [_top(in_world(one, body)) for one, body in ((below, mesh), *beside)]
    top = np.vstack(tops).astype(np.float32)
    hull = cv2.convexHull(top)
    narrow = float(min(cv2.minAreaRect(top)[1]))
    if len(hull) < 3 or narrow <= 0:
        return item.position
    need = STABILITY.inside_share * narrow
    middle = hull[:, 0].mean(0).astype(float)
    spot = np.array([x, y])
    if cv2.pointPolygonTest(hull, (x, y), True) >= need:
        return item.position
    # Towards the middle of the top: the first place that is far enough inside.
    for share in np.linspace(0, 1, 41)[1:]:
        place = spot + share * (middle - spot)
        if cv2.pointPolygonTest(hull, (float(place[0]), float(place[1])), True) >= need:
            return float(place[0]), float(place[1]), z
    return float(middle[0]), float(middle[1]), z


def _top(world: FloatArray) -> FloatArray:
    high = float(world[:, 2].max())
    return world[world[:, 2] > high - STABILITY.top_share * float(np.ptp(world[:, 2]))][:, :2]


def beyond(item: SceneObject, mesh: Mesh, slab: Slab) -> FloatArray:
    """(2,) how far a thing would have to be moved level, x and y of the world, to lie on a slab.

    mesh: body frame. Zero where its middle is far enough within the edges.
    """
    assert item.position is not None
    cos, sin = math.cos(slab.yaw), math.sin(slab.yaw)
    axes = np.array([[cos, sin], [-sin, cos]])
    own = (in_world(item, mesh)[:, :2] - slab.position[:2]) @ axes.T
    place = (np.asarray(item.position[:2]) - slab.position[:2]) @ axes.T
    reach = np.array(slab.size[:2]) / 2
    room = reach - np.minimum(STABILITY.inside_share * np.ptp(own, axis=0), reach)
    return (np.clip(place, -room, room) - place) @ axes


def moved_in(item: SceneObject, mesh: Mesh, slab: Slab) -> tuple[float, float, float]:
    """The position of a thing on a slab whose edges are known, its middle over the slab.

    It is moved by half its width at most; what is seen farther out is left there.
    """
    assert item.position is not None
    x, y, z = item.position
    step = beyond(item, mesh, slab)
    wide = float(np.ptp(in_world(item, mesh)[:, :2], axis=0).max())
    if float(np.hypot(*step)) > STABILITY.max_overhang_share * wide:
        return item.position
    return x + float(step[0]), y + float(step[1]), z


def reaching(slab: Slab, standing: Iterable[tuple[SceneObject, Mesh]]) -> Slab:
    """The slab, with its edges moved out to carry what is seen to stand near them.

    standing: what stands on it, with meshes in the body frame. An edge moves by half a thing's
    width at most: what lies farther out does not stand on this slab.
    """
    cos, sin = math.cos(slab.yaw), math.sin(slab.yaw)
    axes = np.array([[cos, sin], [-sin, cos]])
    low, high = -np.array(slab.size[:2]) / 2, np.array(slab.size[:2]) / 2
    for item, mesh in standing:
        own = (in_world(item, mesh)[:, :2] - slab.position[:2]) @ axes.T
        width = np.ptp(own, axis=0)
        assert item.position is not None
        place = (np.asarray(item.position[:2]) - slab.position[:2]) @ axes.T
        wanted_low, wanted_high = (
            place - STABILITY.inside_share * width,
            place + STABILITY.inside_share * width,
        )
        near = STABILITY.max_overhang_share * width
        low = np.where((wanted_low < low) & (low - wanted_low < near), wanted_low, low)
        high = np.where((wanted_high > high) & (wanted_high - high < near), wanted_high, high)
    if np.allclose(high - low, slab.size[:2], rtol=0, atol=1e-12):
        return slab
    x, y = np.asarray(slab.position[:2]) + (low + high) / 2 @ axes
    size = high - low
    return slab.model_copy(
        update={
            "position": (float(x), float(y), slab.position[2]),
            "size": (float(size[0]), float(size[1]), slab.size[2]),
        }
    )
