"""A support that is seen whole and reaches the ground as one body: a box or wedge by its outline.

The outline of a box that stands on a level ground fixes it up to the camera's height above that
ground: six numbers (place, turn, length, width, height) against a hexagon; likewise that of a
ramp, which is a box with one upper edge missing. Edges inside the outline, where faces meet,
settle what the outline leaves loose.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cache

import cv2
import numpy as np
from numpy.typing import NDArray

from physagent_studio.program.scene.camera import Camera
from physagent_studio.reconstruction.camera.rays import on_plane
from physagent_studio.reconstruction.photo.regions import BoolArray
from physagent_studio.reconstruction.shapes.contour_fitting import drawn_to, least_near, rim_of
from physagent_studio.reconstruction.supports.block import (
    BOX,
    CORNERS,
    FACES,
    WEDGE,
    Block,
    FloatArray,
    Kind,
    placed,
)
from physagent_studio.records.case import Image


@dataclass(frozen=True, slots=True)
class FitSettings:
    """How the outline of a box or a wedge is fitted."""

    # 100..400: of the picture that a fit works on; time grows with its square
    longest_side_px: int = 200
    min_rise_ratio: float = 0.08  # 0.02..0.3: over the camera's height: less may be a board on legs
    # weight, 0..1: of the edges beside the overlap: outlines alone are ambiguous
    edge_weight: float = 0.4
    min_four_sided_share: float = 0.88  # 0.7..1: of a slope's hull that four of its corners span
    refined_count: int = 6  # 2..20: beginnings that are refined, the best ones
    finished_count: int = 4  # 1..10: of them, those that are refined at full sharpness
    # -0.8..0.8: tried from each side, since a fit turns no farther by itself
    turns_rad: tuple[float, ...] = (-0.6, -0.35, -0.15, 0.0, 0.15, 0.35, 0.6)
    # -3.2..3.2: in which a wedge may rise
    ways_rad: tuple[float, float, float, float] = (0.0, math.pi, math.pi / 2, -math.pi / 2)


FIT = FitSettings()

_ALONG = np.linspace(0.05, 0.95, 24)[:, None]
"""Where on an edge it is looked at."""
_MIDDLES = {"box": BOX.mean(0), "wedge": WEDGE.mean(0), "slope": WEDGE.mean(0)}
_QUARTERS: dict[Kind, tuple[float, ...]] = {
    "box": (0.0,),
    "wedge": FIT.ways_rad,
    "slope": FIT.ways_rad,
}


def fitted(fit: Fit, least: tuple[float, float]) -> FloatArray | None:
    """The parameters that fit a region, or None where it is no box on the ground."""
    if fit.filled() < least[0] - 0.02 or (
        fit.kind == "slope" and fit.four_sided() < FIT.min_four_sided_share
    ):
        return None
    starts = sorted(fit.beginnings(), key=fit.cost)[: FIT.refined_count]
    if not starts:
        return None
    coarse = replace(fit, reach=4.0)
    starts += _snug(fit, coarse, starts)
    # Edges draw from far at first, then decide.
    rough = sorted((_refined(coarse, start, 250) for start in starts), key=coarse.cost)
    best = min((_refined(fit, start, 400) for start in rough[: FIT.finished_count]), key=fit.cost)
    block = fit.block(best)
    seen = fit.overlap(block) >= least[0] and fit.on_edges(block) >= least[1]
    return best if seen and FIT.min_rise_ratio <= block.size[2] <= 0.97 else None


def _snug(fit: Fit, coarse: Fit, starts: Sequence[FloatArray]) -> list[FloatArray]:
    """The best beginning with its outline drawn to the region's; that of a slope is not told."""
    if fit.kind == "slope":
        return []
    rim, free = rim_of(fit.region, fit.care), np.arange(6)
    drawn = [drawn_to(rim, fit.outline, lambda _: 0.0, start, free) for start in starts]
    return [min(drawn, key=coarse.cost)]


def _refined(fit: Fit, start: FloatArray, runs: int) -> FloatArray:
    steps = np.array([0.1, 0.15, 0.12, 0.25, 0.2, 0.12])
    return least_near(fit.cost, start, steps, runs, fine=1e-3)[1]


@dataclass(frozen=True, eq=False, slots=True)
class Fit:
    """One region at working size.

    care: pixels that count, `area` of them in the region. away: (h, w) distance to the next edge
    of the picture, pixels. reach: how near an edge is on it, pixels.
    """

    kind: Kind

    camera: Camera
    scale: float
    region: BoolArray
    care: BoolArray
    away: NDArray[np.float32]
    area: int
    reach: float = 1.2

    @classmethod
    def of(
        cls, camera: Camera, image: Image, region: BoolArray, covered: BoolArray, kind: Kind
    ) -> Fit:
        """The fit of a region, everything shrunk to working size; the camera at height 1."""
        scale = min(1.0, FIT.longest_side_px / max(region.shape))
        size = (round(region.shape[1] * scale), round(region.shape[0] * scale))
        small = cv2.resize(image, size, interpolation=cv2.INTER_AREA)
        edges = cv2.Canny(cv2.GaussianBlur(small, (3, 3), 0), 40, 100)
        away = cv2.distanceTransform(255 - edges, cv2.DIST_L2, 3)

        def shrunk(mask: BoolArray) -> BoolArray:
            area = cv2.resize(mask.astype(np.float32), size, interpolation=cv2.INTER_AREA)
            return np.asarray(area > 0.5)

        unit = camera.model_copy(update={"position": (0.0, 0.0, 1.0)})
        hidden = cv2.dilate(shrunk(covered).astype(np.uint8), np.ones((3, 3), np.uint8)) > 0
        small_region, care = shrunk(region), np.asarray(~hidden)
        area = int(np.count_nonzero(small_region & care))
        return cls(kind, unit, scale, small_region, care, np.asarray(away, np.float32), area)

    def filled(self) -> float:
        """How much of its convex hull the region fills; a box fills all of it."""
        points = np.argwhere(self.region)[:, ::-1].astype(np.float32) + 0.5
        hull = self._filled(np.asarray(cv2.convexHull(points), np.float32)) & self.care
        return float((self.region & hull).sum() / max(hull.sum(), 1))

    def four_sided(self) -> float:
        """How much of its convex hull the best of its four-cornered outlines fills."""
        points = np.argwhere(self.region)[:, ::-1].astype(np.float32) + 0.5
        hull = cv2.convexHull(points)
        length = cv2.arcLength(hull, True)
        for share in np.linspace(0.005, 0.1, 20):
            corners = cv2.approxPolyDP(hull, float(share) * length, True)
            if len(corners) <= 4:
                return float(cv2.contourArea(corners) / max(cv2.contourArea(hull), 1e-9))
        return 0.0

    def _filled(self, hull: NDArray[np.float32]) -> BoolArray:
        canvas = np.zeros(self.region.shape, np.uint8)
        # Corners lie between pixels; a sixteenth of one is told apart.
        cv2.fillConvexPoly(canvas, np.round((hull - 0.5) * 16).astype(np.int32), 1, shift=4)
        return canvas.astype(bool)

    def beginnings(self) -> list[FloatArray]:
        """Parameters to begin from: turns, heights and depths over the lowest edge."""
        rows, columns = np.nonzero(self.region)
        left, right, foot = columns.min(), columns.max() + 1, rows.max() + 1
        ends = on_plane(
            self.camera, [(x / self.scale, foot / self.scale) for x in (left, right)], 0.0
        )
        if not np.isfinite(ends).all():
            return []
        width = float(ends[1, 0] - ends[0, 0])
        x, y = float(ends[:, 0].mean()), float(ends[:, 1].mean())
        found = []
        for quarter, turn, rise, depth in itertools.product(
            _QUARTERS[self.kind], FIT.turns_rad, (0.12, 0.25, 0.45, 0.7), (0.4, 0.8, 1.6)
        ):
            # A box that is turned looks wider than it is.
            length = width / (math.cos(turn) + depth * abs(math.sin(turn)))
            sides = (length, depth * length)
            if abs(quarter) == math.pi / 2:
                sides = sides[::-1]
            logs = [math.log(side) for side in (*sides, rise)]
            found.append(np.array([x, y + depth * length / 2, *logs, quarter + turn]))
        return found

    def block(self, values: FloatArray) -> Block:
        """The box of six parameters: x, y, logarithms of the three sizes, turn."""
        x, y, length, width, rise, turn = (float(v) for v in values)
        size = (math.exp(length), math.exp(width), math.exp(rise))
        return Block(x, y, size, turn, self.kind)

    def _pixels(self, block: Block) -> FloatArray | None:
        """(N, 2) corners in the working picture; None where one lies behind the camera."""
        world = placed(CORNERS[self.kind], block)
        pixels, depth = self.camera.project(world)
        return None if depth.min() < 0.02 else pixels * self.scale

    def outline(self, values: FloatArray) -> FloatArray | None:
        """(N, 2) corners in the working picture, pixel (0, 0) with its middle at (0, 0)."""
        if np.abs(values[2:5]).max() > 4:
            return None
        pixels = self._pixels(self.block(values))
        return None if pixels is None else pixels - 0.5

    def cost(self, values: FloatArray) -> float:
        """1 − overlap, less what edges of the picture speak for it."""
        if np.abs(values[2:5]).max() > 4 or abs(values[5]) > 2 * math.pi:
            return 2.0
        block = self.block(values)
        pixels = self._pixels(block)
        return 1.0 - self._overlap(pixels) - FIT.edge_weight * self._on_edges(block, pixels)

    def overlap(self, block: Block) -> float:
        """IoU of the box's outline and the region, where nothing stands in front."""
        return self._overlap(self._pixels(block))

    def _overlap(self, pixels: FloatArray | None) -> float:
        if pixels is None or np.abs(pixels).max() > 20 * max(self.region.shape):
            return 0.0
        hull = cv2.convexHull(pixels.astype(np.float32))
        drawn = self._filled(np.asarray(hull, np.float32)) & self.care
        both = int(np.count_nonzero(drawn & self.region))
        either = int(np.count_nonzero(drawn)) + self.area - both
        return both / max(either, 1)

    def on_edges(self, block: Block) -> float:
        """Mean nearness of the visible edges of the box to edges of the picture, 0 … 1."""
        return self._on_edges(block, self._pixels(block))

    def _on_edges(self, block: Block, pixels: FloatArray | None) -> float:
        if pixels is None:
            return 0.0
        ends = pixels[edges_of(self.kind, self._visible(block))]
        points = (ends[:, :1] * (1 - _ALONG) + ends[:, 1:] * _ALONG).reshape(-1, 2)
        x, y = np.floor(points).astype(int).T
        height, width = self.region.shape
        inside = (x >= 0) & (x < width) & (y >= 0) & (y < height)
        x, y = x[inside], y[inside]
        seen = self.care[y, x]
        if not seen.any():
            return 0.0
        return float(np.exp(-0.5 * (self.away[y[seen], x[seen]] / self.reach) ** 2).mean())

    def _visible(self, block: Block) -> tuple[int, ...]:
        """The faces that look to the camera, by their place in `FACES`."""
        cos, sin = math.cos(block.yaw), math.sin(block.yaw)
        own = (-cos * block.x - sin * block.y, sin * block.x - cos * block.y, 1.0)
        local = (CORNERS[self.kind] * block.size).tolist()
        inside = (_MIDDLES[self.kind] * block.size).tolist()
        found = []
        for k, corners in enumerate(FACES[self.kind]):
            first, second, third = (local[corner] for corner in corners[:3])
            normal = _normal(first, second, third)
            outward = _dot(normal, _less(first, inside)) > 0
            faces = _dot(normal, _less(own, first))
            if (faces if outward else -faces) > 0:
                found.append(k)
        return tuple(found)


# Vectors of three numbers: for these few, arrays would cost more than what is reckoned.
_Vector = Sequence[float]


def _less(one: _Vector, other: _Vector) -> _Vector:
    return (one[0] - other[0], one[1] - other[1], one[2] - other[2])


def _dot(one: _Vector, other: _Vector) -> float:
    return one[0] * other[0] + one[1] * other[1] + one[2] * other[2]


def _normal(first: _Vector, second: _Vector, third: _Vector) -> _Vector:
    """Across the plane of three points."""
    a, b = _less(second, first), _less(third, second)
    return (a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0])


@cache
def edges_of(kind: Kind, faces: tuple[int, ...]) -> NDArray[np.int64]:
    """(N, 2) corners that the edges of some faces join, each edge once."""
    found: dict[tuple[int, int], None] = {}
    for face in faces:
        corners = FACES[kind][face]
        for a, b in zip(corners, (*corners[1:], corners[0]), strict=True):
            found[(min(a, b), max(a, b))] = None
    return np.array(list(found) or [(0, 1)])
