"""Nothing penetrates: bodies that would stand in one another are moved apart along the ground."""

from collections.abc import Mapping
from itertools import combinations

import cv2
import numpy as np

from physagent_studio.arrays import FloatArray
from physagent_studio.program.scene.boards import is_hollow
from physagent_studio.program.scene.state import SceneObject
from physagent_studio.reconstruction.shapes.silhouettes import in_world
from physagent_studio.records.scene import Mesh


def moved_apart(
    items: Mapping[str, SceneObject], meshes: Mapping[str, Mesh], free: frozenset[str]
) -> dict[str, tuple[float, float]]:
    """How far (x, y), m, objects have to move so that none stands in another.

    items: by name, in place. meshes: body frame. free: names that may be moved. What stands on a
    thing moves with it. Of two, the farther one moves: it is the one whose place is less sure.
    """
    shifts = {name: np.zeros(2) for name in items}
    worlds = {name: in_world(items[name], meshes[name]) for name in items}
    max_rounds = 4  # count, 1..20: each may push a thing into the next
    for _ in range(max_rounds):
        settled = True
        for one, other in combinations(items, 2):
            far, near = (one, other) if _depth(items[one]) > _depth(items[other]) else (other, one)
            mover = far if far in free else near
            if mover not in free or other in _carried(items, one) or one in _carried(items, other):
                continue
            if _is_in(items, worlds, one, other) or _is_in(items, worlds, other, one):
                continue
            fixed = near if mover == far else far
            push = _push(worlds[mover], worlds[fixed])
            if push is None:
                continue
            settled = False
            for name in (mover, *_carried(items, mover)):
                shifts[name] += push
                worlds[name] = worlds[name] + [push[0], push[1], 0.0]
        if settled:
            break
    return {name: (float(s[0]), float(s[1])) for name, s in shifts.items() if s.any()}


def _depth(item: SceneObject) -> float:
    return item.position[1] if item.position is not None else 0.0


def _carried(items: Mapping[str, SceneObject], name: str) -> list[str]:
    """Names of what stands on a thing, and on that."""
    found, below = [], [name]
    for carrier in below:
        for item in items.values():
            if item.support == carrier and item.name not in below:
                below.append(item.name)
                found.append(item.name)
    return found


def _is_in(
    items: Mapping[str, SceneObject], worlds: Mapping[str, FloatArray], one: str, vessel: str
) -> bool:
    """Whether the middle of a thing lies within a vessel or a ring, seen from above."""
    if not is_hollow(items[vessel].shape):
        return False
    low, high = worlds[one].min(0), worlds[one].max(0)
    rim = cv2.convexHull(worlds[vessel][:, :2].astype(np.float32))
    x, y = (float(value) for value in (low[:2] + high[:2]) / 2)
    return cv2.pointPolygonTest(rim, (x, y), False) >= 0


def _push(mover: FloatArray, fixed: FloatArray) -> FloatArray | None:
    """The shortest way (2,) on which a body (V, 3) gets out of another; None where it is out."""
    low = max(float(mover[:, 2].min()), float(fixed[:, 2].min()))
    high = min(float(mover[:, 2].max()), float(fixed[:, 2].max()))
    if high - low < 1e-3:
        return None
    flat = [world[:, :2].astype(np.float32) for world in (mover, fixed)]
    hulls = [cv2.convexHull(points)[:, 0].astype(float) for points in flat]
    best: tuple[float, FloatArray] | None = None
    for hull in hulls:
        edges = np.roll(hull, -1, axis=0) - hull
        normals = np.stack([edges[:, 1], -edges[:, 0]], 1)
        lengths = np.hypot(normals[:, 0], normals[:, 1])
        for normal in normals[lengths > 1e-9] / lengths[lengths > 1e-9, None]:
            own, others = hulls[0] @ normal, hulls[1] @ normal
            for sign, depth in ((1.0, others.max() - own.min()), (-1.0, own.max() - others.min())):
                if depth <= 0:
                    return None
                if best is None or depth < best[0]:
                    best = (float(depth), sign * normal)
    narrow = min(float(np.ptp(hull, axis=0).min()) for hull in hulls)
    slight_share = 0.02  # 0..0.1: of the narrower width: round things tuck in under others
    if best is None or best[0] < slight_share * narrow:
        return None
    gap_m = 1e-3  # 1e-5..0.01: that things moved apart keep
    return best[1] * (best[0] + gap_m)
