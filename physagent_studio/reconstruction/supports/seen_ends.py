"""Where a top ends that no straight edge bounds: where its mask ends at a step of colour.

Below the near side of a table its front is seen, and the front's lower edge is often plainer than
the upper one. A top that reaches down to it has a corner beside the table, in front of the wall:
near sides are moved in until their corners are on the table.
"""

import math
from dataclasses import dataclass

import cv2
import numpy as np

from physagent_studio.arrays import FloatArray
from physagent_studio.program.scene.camera import Camera
from physagent_studio.program.scene.state import Slab
from physagent_studio.reconstruction.camera.rays import on_plane
from physagent_studio.reconstruction.photo.regions import BoolArray, grow
from physagent_studio.records.case import Image


@dataclass(frozen=True, slots=True)
class EndSettings:
    """When a top ends where its mask does."""

    # 0.001..0.02: over the longer side: what is looked at begins so far off a corner
    near_ratio: float = 0.004
    far_ratio: float = 0.016  # 0.005..0.05: and ends so far off, before another thing begins
    same_colour_lab: float = 10.0  # 4..20: steps up to which two places are of one surface
    # 1..5: how much farther it is from the top's colours than from the outside's
    min_farther_ratio: float = 2.0
    steps_count: int = 40  # 10..200: places of a side on the way in
    end_share: float = 0.08  # 0.02..0.3: of its reach: the part that is its end
    beside_px: float = 3.0  # 1..8: off the mask's outline, where colours are compared
    min_step_share: float = 0.6  # 0.4..1: of the end that must be a step of colour


END = EndSettings()


@dataclass(frozen=True, eq=False, slots=True)
class Shown:
    """The photo (H, W, 3) and the pixels (H, W) of all things in it."""

    image: Image
    covered: BoolArray


def to_seen_ends(
    shown: Shown, camera: Camera, slab: Slab, region: BoolArray, standing: FloatArray
) -> Slab:
    """The slab, its sides moved in to where the picture shows that it ends.

    region: (H, W) pixels of its top and its front. standing: (N, 2) places, m, that stay on it.
    """
    if not region.any():
        return slab
    soft = cv2.GaussianBlur(shown.image, (0, 0), 1.5)
    lab = cv2.cvtColor(soft, cv2.COLOR_RGB2LAB).astype(float)
    top = slab.position[2] + slab.size[2] / 2
    cos, sin = math.cos(slab.yaw), math.sin(slab.yaw)
    ways = np.array([(cos, sin), (-sin, cos), (-cos, -sin), (sin, -cos)])
    middle = np.array(slab.position[:2])
    limits = ways @ middle + np.tile(np.array(slab.size[:2]) / 2, 2)
    seen = _ends(lab, shown.covered, camera, top, region, ways)
    # Without anything on it a top keeps its middle.
    inner = (standing if len(standing) else middle[None]) @ ways.T
    limits = np.minimum(limits, np.maximum(seen, inner.max(0)))
    limits = _to_seen_corners(lab, camera, top, region, ways, limits, inner.max(0))
    size = (float(limits[0] + limits[2]), float(limits[1] + limits[3]), slab.size[2])
    centre = ((limits[:2] - limits[2:]) / 2) @ ways[:2]
    position = (float(centre[0]), float(centre[1]), slab.position[2])
    return slab.model_copy(update={"position": position, "size": size})


def _ends(
    lab: FloatArray,
    covered: BoolArray,
    camera: Camera,
    top: float,
    region: BoolArray,
    ways: FloatArray,
) -> FloatArray:
    """(4,) how far the mask reaches each way, m, where it ends at a step of colour; else inf.

    It does not where it leaves the picture or goes on behind a thing.
    """
    outlines, _ = cv2.findContours(
        region.astype(np.uint8), cv2.RETR_EXTERNAL, cv2.CHAIN_APPROX_NONE
    )
    points = max(outlines, key=len)[:, 0].astype(float)
    after = np.roll(points, -2, axis=0) - np.roll(points, 2, axis=0)
    across = np.stack([after[:, 1], -after[:, 0]], 1)
    across /= np.maximum(np.linalg.norm(across, axis=1, keepdims=True), 1e-9)
    rows, columns = region.shape
    x, y = points.T
    leaves = (x <= 3) | (y <= 3) | (x >= columns - 4) | (y >= rows - 4)
    free = ~leaves & ~grow(covered, 4)[y.astype(int), x.astype(int)]
    sides = [points + sign * END.beside_px * across for sign in (1, -1)]
    clipped = [np.clip(side, 0, (columns - 1, rows - 1)).astype(int) for side in sides]
    step = np.linalg.norm(
        lab[clipped[0][:, 1], clipped[0][:, 0]] - lab[clipped[1][:, 1], clipped[1][:, 0]], axis=1
    )
    is_end = free & (step > END.same_colour_lab)
    places = on_plane(camera, points + 0.5, top)[:, :2]
    fine = np.isfinite(places).all(1)
    out = np.full(4, np.inf)
    for k, way in enumerate(ways):
        along = places[fine] @ way
        reach = float(np.percentile(along, 99.5)) if len(along) else math.inf
        last = along > reach - END.end_share * float(np.ptp(along)) if len(along) else along > 0
        if (
            last.any()
            and not leaves[fine][last].any()
            and is_end[fine][last].mean() > END.min_step_share
        ):
            out[k] = reach
    return out


def _to_seen_corners(
    lab: FloatArray,
    camera: Camera,
    top: float,
    region: BoolArray,
    ways: FloatArray,
    limits: FloatArray,
    inner: FloatArray,
) -> FloatArray:
    """Limits (4,), m, the near ones moved in until their corners in the picture are on the top."""
    out = limits.copy()
    own = lab[region][:: max(1, int(region.sum()) // 5000)]
    is_near = ways @ np.array(camera.position[:2]) > limits
    for k in np.flatnonzero(is_near):
        for j in ((k + 1) % 4, (k + 3) % 4):
            if is_near[j]:
                continue
            for place in np.linspace(out[k], inner[k], END.steps_count, endpoint=False):
                corner = np.append(place * ways[k] + limits[j] * ways[j], top)
                if not _is_beside(lab, own, camera, corner, ways[[k, j]]):
                    out[k] = place
                    break
    return out


def _is_beside(
    lab: FloatArray, own: FloatArray, camera: Camera, corner: FloatArray, ways: FloatArray
) -> bool:
    """Whether a corner lies beside the top: inside it the picture goes on as outside.

    own: (N, 3) colours of the top. corner: m. ways: (2, 2) outward across the sides that meet.
    """
    back = corner - 0.01 * np.pad(ways, ((0, 0), (0, 1)))
    pixels = camera.project(np.vstack([corner[None], back]))[0]
    inward = pixels[1:] - pixels[0]
    inward = (inward / np.linalg.norm(inward, axis=1, keepdims=True)).sum(0)
    inward /= max(float(np.hypot(*inward)), 1e-9)
    off = np.linspace(END.near_ratio, END.far_ratio, 8)[:, None] * max(camera.size) * inward
    inside, outside = _colours(lab, pixels[0] + off), _colours(lab, pixels[0] - off)
    if not len(inside) or not len(outside):
        return False
    apart = float(np.linalg.norm(inside.mean(0) - outside.mean(0)))
    strange = float(np.quantile(np.linalg.norm(own - inside.mean(0), axis=1), 0.2))
    return apart < END.same_colour_lab < strange and strange > END.min_farther_ratio * apart


def _colours(lab: FloatArray, places: FloatArray) -> FloatArray:
    """Colours (N, 3) at places (N, 2) in pixels; none where one is outside the picture."""
    x, y = np.floor(places).astype(int).T
    rows, columns = lab.shape[:2]
    if ((x < 0) | (y < 0) | (x >= columns) | (y >= rows)).any():
        return np.zeros((0, 3))
    return lab[y, x]
