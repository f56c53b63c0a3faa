"""The body of what stands turned on a rectangle: its side, as long as it is, over all its width.

A car seen at an angle shows one side and one end. Its footprint is a rectangle whose turn the lower
rim of the mask tells (`footprint.py`) and whose corners are where the mask ends at the left and at
the right. Over it the body is as high as the far upper rim of the mask says, and its left half
is like its right one. All of it lies in the mask, so that the photo shows nothing else.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import cv2
import numpy as np
from numpy.typing import NDArray

from physagent_studio.arrays import FloatArray
from physagent_studio.program.scene.camera import Camera
from physagent_studio.reconstruction.camera.rays import on_plane
from physagent_studio.reconstruction.photo.regions import BoolArray, bounds, grow
from physagent_studio.reconstruction.shapes.footprint import footprint_of, rim_below
from physagent_studio.reconstruction.shapes.sheets import closed, sheet_of


@dataclass(frozen=True, slots=True)
class PrismSettings:
    """How a footprint is read, and a body stood on it."""

    overhang_share: float = 0.1  # 0..0.25: of its length, that an end reaches beyond its wheels
    usual_slim: float = 0.45  # ratio, 0.2..1: width over length of what drives
    slim_range: float = 1.3  # ratio, 1..2: by which that may differ from the usual one
    usual_aspect: float = 0.55  # ratio, 0.3..1: height over length where nothing is known
    unseen_share: float = 0.02  # 0..0.1: of its distance, below which a side is not seen
    unsure_ratio: float = 0.08  # 0..0.3: of a horizon, over the focal length, to be known
    heights_count: int = 48  # 16..200: of its outline, along its length
    samples_count: int = 48  # 16..200: places along a ray
    slim_log: float = 0.25  # 0.1..0.6: spread of width over length among things of a kind
    aspect_log: float = 0.35  # 0.1..0.6: the same of height over length
    # count, 0..12: how often depths in front and behind are made like those around them
    calm_counts: tuple[int, int] = (1, 6)
    spare_ratio: float = 0.035  # 0..0.1: of the longer side, by which its halves may be unlike


PRISM = PrismSettings()


@dataclass(frozen=True, eq=False, slots=True)
class Plan:
    """A rectangle on level ground one unit below the camera, whose place on it is the origin.

    axes: (2, 2) level unit vectors along and across it, toward the camera. low, high: (2,) its
    ends along them. strange: how far (log) its width over length is off the usual one. shown:
    whether enough of it is seen for a body to be stood on it.
    """

    axes: FloatArray
    low: FloatArray
    high: FloatArray
    strange: float = 0.0
    shown: bool = True

    @property
    def slim(self) -> float:
        """Width over length."""
        along, across = self.high - self.low
        return float(across / along)

    @property
    def turn(self) -> float:
        """Degrees, 0 … 180, of its length."""
        return math.degrees(math.atan2(self.axes[0, 1], self.axes[0, 0])) % 180


def plan_seen(
    mask: BoolArray, camera: Camera, height: float, slim: float | None, aspect: float | None
) -> Plan | None:
    """The footprint of what stands on ground at that height, m; None where it is not clear.

    slim: its usual width over length. aspect: its usual height over length.
    """
    seen = None if cut_off(mask) else footprint_of(mask, camera, height)
    if seen is None:
        return None
    usual, high = slim or PRISM.usual_slim, aspect or PRISM.usual_aspect
    side, end = (
        plan_of(mask, camera, seen.angle + by, usual, PRISM.slim_range) for by in (0.0, 90.0)
    )
    if side is None or end is None:
        chosen = side or end
    elif seen.across > 0:
        # Where two sides are seen, a plan that knows of one alone leaves the other unexplained.
        odd = [_oddness(mask, camera, plan, high) + (plan.strange == 0) for plan in (side, end)]
        chosen = side if odd[0] <= odd[1] else end
    else:
        x0, y0, x1, y1 = bounds(mask)
        # Halfway between a side and an end, both as high: what is seen of it alone is one of them.
        chosen = side if (y1 - y0) / (x1 - x0) < high / math.sqrt(usual) else end
    if chosen is None or chosen is end or seen.across > 0:
        return chosen
    # Where its roof begins above that side is told by how steeply one looks down, and by no corner.
    unsure = 0.0 if camera.confirmed else camera.horizon_sigma or 0.0
    return replace(chosen, shown=unsure <= PRISM.unsure_ratio * camera.focal)


def cut_off(mask: BoolArray) -> bool:
    """Whether a mask (H, W) is empty or ends at the picture's rim."""
    inner = mask[1:-1, 1:-1]
    return not inner.any() or bool(np.count_nonzero(inner) < np.count_nonzero(mask))


def _oddness(mask: BoolArray, view: Camera, plan: Plan, aspect: float) -> float:
    """How far what stands on a plan is off its like: half a sum of squared deviations."""
    high = float(_Prism.over(mask, view, plan).heights.max() / (plan.high - plan.low)[0])
    tall = math.log(max(high, 1e-3) / aspect) / PRISM.aspect_log
    return float((plan.strange / PRISM.slim_log) ** 2 + tall**2) / 2


def plan_of(
    mask: BoolArray, camera: Camera, turn: float, slim: float, most: float = 1.0
) -> Plan | None:
    """The footprint of a mask (H, W) that is turned by `turn` degrees.

    slim: its usual width over length, and most: by which it may differ.
    """
    rim = rim_below(mask)
    if rim is None:
        return None
    places = on_plane(camera, rim, camera.position[2] - 1.0)[:, :2] - camera.position[:2]
    if not np.isfinite(places).all():
        return None
    angle = math.radians(turn)
    axes = np.array([[math.cos(angle), math.sin(angle)], [-math.sin(angle), math.cos(angle)]])
    axes *= np.where(axes @ np.median(places, axis=0) > 0, -1.0, 1.0)[:, None]
    near = (places @ axes.T).max(0)
    return _rectangle(axes, near, _tangents(mask, camera, axes, near), slim, most)


def _tangents(mask: BoolArray, camera: Camera, axes: FloatArray, near: FloatArray) -> FloatArray:
    """(2, 2) level directions in those axes to where a mask ends on either side of the near corner:

    first on the side to which its length goes back from there, then that of its width.
    """
    outlines, _ = cv2.findContours(mask.astype(np.uint8), cv2.RETR_EXTERNAL, cv2.CHAIN_APPROX_NONE)
    pixels = np.vstack(outlines)[:, 0].astype(float) + 0.5
    rays = camera.rays(pixels)[:, :2] @ axes.T
    beside = np.arctan2(near[0] * rays[:, 1] - near[1] * rays[:, 0], rays @ near)
    # Both axes look toward the camera, so that its length goes back on this side and no other.
    return rays[[int(beside.argmin()), int(beside.argmax())]]


def _rectangle(
    axes: FloatArray, near: FloatArray, ends: FloatArray, slim: float, most: float
) -> Plan | None:
    """The rectangle with that near corner, as the two directions bound it."""
    back, aside = ends
    along, across = (float(value) for value in near)
    far, corner = _met(back, 1, across), _met(back, 0, along)
    tiny = PRISM.unseen_share * math.hypot(along, across)
    if far is not None and (corner is None or corner > across + tiny):
        along = _end(along, along - far, across, aside, slim)
    elif corner is None:
        return None
    else:
        far, across = None, corner
        along += PRISM.overhang_share * (across - (_met(aside, 0, along) or across)) / slim
    turned, thin = _met(aside, 1, across), _met(aside, 0, along)
    short_seen = thin is not None and (turned is None or turned > along)
    if not short_seen:
        if turned is None or far is None:
            return None
        along = turned
    length = along - far if far is not None else 0.0
    width = across - thin if thin is not None and short_seen else 0.0
    strange = 0.0
    if length > 0 and width > 0:
        strange = abs(math.log(width / length / slim))
        ratio = min(max(width / length, slim / most), slim * most)
        wider = abs(near[0] * back[1] - near[1] * back[0]) / math.hypot(*back)
        if wider > abs(near[0] * aside[1] - near[1] * aside[0]) / math.hypot(*aside):
            width = ratio * length
        else:
            length = width / ratio
    length, width = length or width / slim, width or length * slim
    if not (length > 0 and width > 0):
        return None
    high = np.array([along, across])
    return Plan(axes, high - (length, width), high, strange)


def _end(along: float, length: float, across: float, aside: FloatArray, slim: float) -> float:
    """How near an end is whose wheels are there: beyond them by as much, within what is usual, as

    makes the side beside it, seen up to that direction, most as wide as is usual for the length.
    """
    least, most = along, along + PRISM.overhang_share * length
    thin = _met(aside, 0, along)
    if thin is None:
        return most
    usual = (across + slim * (along - length)) / (thin / along + slim)
    return min(max(usual, least), most)


def _met(way: FloatArray, axis: int, level: float) -> float | None:
    """Where a direction comes to that level of an axis, along the other one; None for never."""
    return float(level / way[axis] * way[1 - axis]) if way[axis] * level > 0 else None


def prism_mesh(mask: BoolArray, camera: Camera, plan: Plan) -> tuple[FloatArray, NDArray[np.int64]]:
    """World vertices (V, 3) around ground one unit below the camera, and faces."""
    sheet = sheet_of(mask)
    body = _Prism.over(mask, camera, plan)
    near, far = body.depths(sheet.pixels)
    near, far = (
        _calm(near, sheet.faces, PRISM.calm_counts[0]),
        _calm(far, sheet.faces, PRISM.calm_counts[1]),
    )
    far = np.maximum(near, far)
    rays = camera.rays(sheet.pixels)
    eye = np.asarray(camera.position)
    ends = np.vstack([eye + rays * near[:, None], eye + rays * far[:, None]])
    return closed(ends, sheet, far - near)


def _calm(values: FloatArray, faces: NDArray[np.int64], times: int) -> FloatArray:
    """Values (V,) as those around them are, over and over."""
    count = np.bincount(faces.ravel(), minlength=len(values))
    for _ in range(times):
        mean = np.repeat(values[faces].mean(1), 3)
        around = np.bincount(faces.ravel(), mean, minlength=len(values))
        values = np.where(count > 0, around / np.maximum(count, 1), values)
    return values


@dataclass(frozen=True, eq=False, slots=True)
class _Prism:
    """What is inside: over the plan, below `heights` (K,) along it, in the mask mirrored across.

    alike: (H, W) where the mirror image may lie.
    """

    camera: Camera
    plan: Plan
    alike: BoolArray
    heights: FloatArray

    @staticmethod
    def over(mask: BoolArray, camera: Camera, plan: Plan) -> _Prism:
        """The prism whose far upper rim is seen as that of the mask."""
        x0, y0, x1, y1 = bounds(mask)
        spare = max(1, round(PRISM.spare_ratio * max(x1 - x0, y1 - y0)))
        open_ = _Prism(camera, plan, grow(mask, spare), np.full(PRISM.heights_count, np.inf))
        return _Prism(camera, plan, open_.alike, open_.heights_of(mask))

    def heights_of(self, mask: BoolArray) -> FloatArray:
        """(K,) how high it is along its length, from its far end on, for the mask's upper rim."""
        columns = np.flatnonzero(mask.any(0))
        pixels = np.column_stack(
            [columns.astype(float) + 0.5, mask.argmax(0)[columns].astype(float)]
        )
        rays, low, high = self._crossed(pixels)
        # A ray that goes down is lowest where it leaves, one that goes up where it enters.
        at = np.where(rays[:, 2] < 0, high, low)
        share = (at * rays[:, 0] - self.plan.low[0]) / (self.plan.high - self.plan.low)[0]
        place = np.clip(share * PRISM.heights_count, 0, PRISM.heights_count - 1).astype(int)
        found = np.full(PRISM.heights_count, -np.inf)
        np.maximum.at(found, place, 1.0 + at * rays[:, 2])
        known = np.flatnonzero(np.isfinite(found))
        return np.interp(np.arange(PRISM.heights_count), known, found[known])

    def _crossed(self, pixels: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Rays (N, 3) of pixels along the plan's axes and up; where they enter and leave it."""
        world = self.camera.rays(pixels)
        rays = np.column_stack([world[:, :2] @ self.plan.axes.T, world[:, 2]])
        flat = np.where(np.abs(rays[:, :2]) < 1e-9, 1e-9, rays[:, :2])
        ends = np.stack([self.plan.low / flat, self.plan.high / flat])
        low, high = ends.min(0).max(1), ends.max(0).min(1)
        # Beside the plan a ray is where it comes nearest to it.
        middle = np.maximum((low + high) / 2, 1e-6)
        missed = low >= high
        return rays, np.where(missed, middle, np.maximum(low, 1e-6)), np.where(missed, middle, high)

    def depths(self, pixels: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Where the rays of pixels (N, 2) enter and leave the body, (N,) along them."""
        rays, low, high = self._crossed(pixels)
        ground = np.where(rays[:, 2] < 0, -1.0 / np.minimum(rays[:, 2], -1e-9), np.inf)
        high = np.maximum(np.minimum(high, ground), low)
        share = np.linspace(0.0, 1.0, PRISM.samples_count)
        along = low[:, None] + share * (high - low)[:, None]
        over = self._over(rays, along)
        inside = over <= 0
        none = ~inside.any(1)
        inside[none, over[none].argmin(1)] = True
        rows = np.arange(len(rays))
        first, last = inside.argmax(1), along.shape[1] - 1 - inside[:, ::-1].argmax(1)
        start = self._edge(rays, along[rows, np.maximum(first - 1, 0)], along[rows, first])
        stop = self._edge(
            rays, along[rows, np.minimum(last + 1, along.shape[1] - 1)], along[rows, last]
        )
        start, stop = (np.where(none, along[rows, first], one) for one in (start, stop))
        return start, np.maximum(start, stop)

    def _edge(self, rays: FloatArray, outside: FloatArray, inside: FloatArray) -> FloatArray:
        """(N,) where rays cross the body's surface between two places on them."""
        for _ in range(8):
            middle = (outside + inside) / 2
            within = self._over(rays, middle[:, None])[:, 0] <= 0
            inside, outside = np.where(within, middle, inside), np.where(within, outside, middle)
        return inside

    def _over(self, rays: FloatArray, along: FloatArray) -> FloatArray:
        """(N, K) how far places on rays lie above the body; 1 and more where it is open."""
        a, b = along * rays[:, :1], along * rays[:, 1:2]
        z = 1.0 + along * rays[:, 2:]
        share = (a - self.plan.low[0]) / (self.plan.high - self.plan.low)[0]
        count = PRISM.heights_count
        top = np.interp(share * count - 0.5, np.arange(count), self.heights)
        mirrored = (self.plan.low + self.plan.high)[1] - b
        level = np.stack([a, mirrored], -1) @ self.plan.axes
        places = np.concatenate([level, (z - 1.0)[..., None]], -1) + self.camera.position
        pixels = self.camera.project(places.reshape(-1, 3))[0].reshape(*a.shape, 2).astype(int)
        rows, columns = self.alike.shape
        x, y = np.clip(pixels[..., 0], 0, columns - 1), np.clip(pixels[..., 1], 0, rows - 1)
        return np.where(self.alike[y, x], 0.0, 1.0) + np.maximum(z - top, 0.0)
