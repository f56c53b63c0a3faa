"""A support that is seen whole and reaches the ground as one body: a box fitted to its outline.

The outline of a box that stands on a level ground fixes it up to the camera's height above that
ground: six numbers (place, turn, length, width, height) against a hexagon. Edges inside the
outline, where top and sides meet, settle what the outline leaves loose.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import cv2
import numpy as np
from numpy.typing import NDArray
from scipy.optimize import minimize

from physagent_studio.program.camera import Camera
from physagent_studio.program.scene import SceneState, Slab
from physagent_studio.reconstruction.geometry import on_plane
from physagent_studio.reconstruction.masks import BoolArray, border_share
from physagent_studio.reconstruction.names import support_kind
from physagent_studio.records.case import Image

FloatArray = NDArray[np.float64]

WORKING = 200
"""Longer side of the picture that a fit works on, pixels."""
LEAST_FILLED = 0.93
"""How much of its convex hull a region fills that is the outline of a box."""
LEAST_IOU = 0.95
"""A box fits whose outline covers the region this well. Parts of larger tops come to .94."""
LEAST_EDGES = 0.75
"""Share of its visible edges that must lie on edges of the picture. By chance it is .4 to .65."""
LEAST_AREA = 0.004
"""Share of the picture that a region must cover."""
LEAST_RISE = 0.08
"""Lower things (shares of the camera's height) may as well be a board on legs."""
LARGEST_CUT = 0.03
"""Share of the outline that may lie on the border of the picture: it has to be seen whole."""
EDGES = 0.4
"""Weight of the edges beside the overlap."""
REFINED = 6
"""How many of the best beginnings are refined."""
_CORNERS = np.array(list(itertools.product((-0.5, 0.5), (-0.5, 0.5), (0.0, 1.0))))
_FACES = (
    ((0, 0, 1), (1, 3, 7, 5)),
    ((1, 0, 0), (4, 6, 7, 5)),
    ((-1, 0, 0), (0, 2, 3, 1)),
    ((0, 1, 0), (2, 6, 7, 3)),
    ((0, -1, 0), (0, 4, 5, 1)),
)
"""Normal and corners, in turn, of every face but the bottom."""


@dataclass(frozen=True, slots=True)
class Block:
    """A box on the ground in camera heights: middle of its base, size (x, y, z), turn, radians."""

    x: float
    y: float
    size: tuple[float, float, float]
    yaw: float

    def slab(self, height: float) -> Slab:
        """The same in metres, for a camera `height` m above the ground."""
        size = (self.size[0] * height, self.size[1] * height, self.size[2] * height)
        return Slab(
            position=(self.x * height, self.y * height, size[2] / 2), size=size, yaw=self.yaw
        )


def blocks_of(
    image: Image,
    state: SceneState,
    camera: Camera,
    offers: Mapping[str, Sequence[BoolArray]],
    covered: BoolArray,
) -> dict[str, Block]:
    """The boxes of the supports with open shapes and without marks that are seen whole."""
    found: dict[str, Block] = {}
    for support in state.supports:
        wanted = support.shape is None and not support.grounding.marks
        if not wanted or support_kind(support.name) != "slab":
            continue
        block = best_block(camera, image, offers.get(support.name, ()), covered)
        if block is not None:
            found[support.name] = block
    return found


def best_block(
    camera: Camera, image: Image, masks: Sequence[BoolArray], covered: BoolArray
) -> Block | None:
    """The box that one of several masks of a support shows best, or None where none does.

    camera: any height; only directions count. masks: (H, W), the likeliest first.
    covered: (H, W) pixels of things in front of it, which may hide any of it.
    """
    best, least = None, math.inf
    for mask in masks:
        fit = _Fit.of(camera, image, mask & ~covered, covered)
        values = _fitted(fit) if _is_whole(mask & ~covered) else None
        if values is not None and fit.cost(values) < least:
            best, least = fit.block(values), fit.cost(values)
    return best


def _is_whole(region: BoolArray) -> bool:
    return region.mean() > LEAST_AREA and border_share(region) <= LARGEST_CUT


def _fitted(fit: _Fit) -> FloatArray | None:
    """The parameters that fit a region, or None where it is no box on the ground."""
    if fit.filled() < LEAST_FILLED:
        return None
    starts = sorted(fit.beginnings(), key=fit.cost)[:REFINED]
    if not starts:
        return None
    # Edges draw from far at first, then decide.
    rough = [_refined(replace(fit, reach=4.0), start, 250) for start in starts]
    best = min((_refined(fit, start, 400) for start in rough), key=fit.cost)
    block = fit.block(best)
    seen = fit.overlap(block) >= LEAST_IOU and fit.on_edges(block) >= LEAST_EDGES
    return best if seen and LEAST_RISE <= block.size[2] <= 0.97 else None


def _refined(fit: _Fit, start: FloatArray, runs: int) -> FloatArray:
    simplex = np.vstack([start, start + np.diag([0.1, 0.15, 0.12, 0.25, 0.2, 0.12])])
    options = {"maxfev": runs, "xatol": 1e-3, "fatol": 1e-4, "initial_simplex": simplex}
    return np.asarray(minimize(fit.cost, start, method="Nelder-Mead", options=options).x)


@dataclass(frozen=True, eq=False, slots=True)
class _Fit:
    """One region at working size.

    care: pixels that count. away: (h, w) distance to the next edge of the picture, pixels.
    reach: how near an edge is on it, pixels.
    """

    camera: Camera
    scale: float
    region: BoolArray
    care: BoolArray
    away: NDArray[np.float32]
    reach: float = 1.2

    @classmethod
    def of(cls, camera: Camera, image: Image, region: BoolArray, covered: BoolArray) -> _Fit:
        """The fit of a region, everything shrunk to working size; the camera at height 1."""
        scale = min(1.0, WORKING / max(region.shape))
        size = (round(region.shape[1] * scale), round(region.shape[0] * scale))
        small = cv2.resize(image, size, interpolation=cv2.INTER_AREA)
        edges = cv2.Canny(cv2.GaussianBlur(small, (3, 3), 0), 40, 100)
        away = cv2.distanceTransform(255 - edges, cv2.DIST_L2, 3)

        def shrunk(mask: BoolArray) -> BoolArray:
            area = cv2.resize(mask.astype(np.float32), size, interpolation=cv2.INTER_AREA)
            return np.asarray(area > 0.5)

        unit = camera.model_copy(update={"position": (0.0, 0.0, 1.0)})
        hidden = cv2.dilate(shrunk(covered).astype(np.uint8), np.ones((3, 3), np.uint8)) > 0
        return cls(unit, scale, shrunk(region), np.asarray(~hidden), np.asarray(away, np.float32))

    def filled(self) -> float:
        """How much of its convex hull the region fills; a box fills all of it."""
        points = np.argwhere(self.region)[:, ::-1].astype(np.float32) + 0.5
        hull = self._filled(np.asarray(cv2.convexHull(points), np.float32)) & self.care
        return float((self.region & hull).sum() / max(hull.sum(), 1))

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
        for turn, rise, depth in itertools.product(
            (-0.6, -0.35, -0.15, 0.0, 0.15, 0.35, 0.6), (0.12, 0.25, 0.45, 0.7), (0.4, 0.8, 1.6)
        ):
            # A box that is turned looks wider than it is.
            length = width / (math.cos(turn) + depth * abs(math.sin(turn)))
            found.append(
                np.array(
                    [
                        x, y + depth * length / 2, math.log(length), math.log(depth * length),
                        math.log(rise), turn,
                    ]
                )
            )  # fmt: skip
        return found

    def block(self, values: FloatArray) -> Block:
        """The box of six parameters: x, y, logarithms of the three sizes, turn."""
        x, y, length, width, rise, turn = (float(v) for v in values)
        size = (math.exp(length), math.exp(width), math.exp(rise))
        return Block(x, y, size, turn)

    def _pixels(self, block: Block) -> FloatArray | None:
        """(8, 2) corners in the working picture; None where one lies behind the camera."""
        local = _CORNERS * block.size
        cos, sin = math.cos(block.yaw), math.sin(block.yaw)
        world = np.column_stack(
            [
                block.x + cos * local[:, 0] - sin * local[:, 1],
                block.y + sin * local[:, 0] + cos * local[:, 1],
                local[:, 2],
            ]
        )
        pixels, depth = self.camera.project(world)
        return None if depth.min() < 0.02 else pixels * self.scale

    def cost(self, values: FloatArray) -> float:
        """1 − overlap, less what edges of the picture speak for it."""
        if np.abs(values[2:5]).max() > 4 or abs(values[5]) > 1.2:
            return 2.0
        block = self.block(values)
        return 1.0 - self.overlap(block) - EDGES * self.on_edges(block)

    def overlap(self, block: Block) -> float:
        """IoU of the box's outline and the region, where nothing stands in front."""
        pixels = self._pixels(block)
        if pixels is None or np.abs(pixels).max() > 20 * max(self.region.shape):
            return 0.0
        drawn = (
            self._filled(np.asarray(cv2.convexHull(pixels.astype(np.float32)), np.float32))
            & self.care
        )
        region = self.region & self.care
        return float((drawn & region).sum() / max((drawn | region).sum(), 1))

    def on_edges(self, block: Block) -> float:
        """Mean nearness of the visible edges of the box to edges of the picture, 0 … 1."""
        pixels = self._pixels(block)
        if pixels is None:
            return 0.0
        share = np.linspace(0.05, 0.95, 24)[:, None]
        pairs = self._visible(block)
        points = np.concatenate([pixels[a] * (1 - share) + pixels[b] * share for a, b in pairs])
        x, y = np.floor(points).astype(int).T
        height, width = self.region.shape
        inside = (x >= 0) & (x < width) & (y >= 0) & (y < height)
        x, y = x[inside], y[inside]
        seen = self.care[y, x]
        if not seen.any():
            return 0.0
        return float(np.exp(-0.5 * (self.away[y[seen], x[seen]] / self.reach) ** 2).mean())

    def _visible(self, block: Block) -> list[tuple[int, int]]:
        """Edges of the faces that look to the camera."""
        cos, sin = math.cos(block.yaw), math.sin(block.yaw)
        eye = np.array([-block.x, -block.y])
        own = np.array([cos * eye[0] + sin * eye[1], -sin * eye[0] + cos * eye[1], 1.0])
        found: dict[tuple[int, int], None] = {}
        for normal, corners in _FACES:
            reach = np.abs(np.array(normal)) @ (np.array(block.size) * (0.5, 0.5, 1.0))
            if float(np.array(normal) @ own) <= reach:
                continue
            for a, b in zip(corners, (*corners[1:], corners[0]), strict=True):
                found[(min(a, b), max(a, b))] = None
        return list(found) or [(0, 4)]
