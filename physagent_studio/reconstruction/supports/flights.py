"""A flight of steps by its outline: equal steps that join, whether clicked as one thing or singly.

Six numbers (place, turn, depth and height of a step, width) against the outline of all steps, the
masks of the single ones where they were clicked, and the edges of the picture. In camera heights.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import cv2
import numpy as np
from numpy.typing import NDArray

from physagent_studio.knowledge import (
    is_stairs,
    is_step,
)
from physagent_studio.language.hints import told_steps
from physagent_studio.program.scene.camera import Camera
from physagent_studio.program.scene.state import Ramp, SceneState
from physagent_studio.reconstruction.camera.rays import on_plane
from physagent_studio.reconstruction.photo.regions import BoolArray, border_share
from physagent_studio.reconstruction.shapes.contour_fitting import least_near
from physagent_studio.reconstruction.supports.block import BOX, Block, FloatArray, placed
from physagent_studio.reconstruction.supports.block_fit import FIT, Fit, edges_of
from physagent_studio.records.case import Image


@dataclass(frozen=True, slots=True)
class FlightSettings:
    """How a flight of steps is fitted."""

    # 2..12: of steps, where nobody has told it: the likeliest first
    guesses_count: tuple[int, int, int, int] = (3, 4, 5, 2)
    max_steps: int = 12  # count, 4..40: single steps that were clicked; more are no single steps
    min_overlap: float = 0.8  # IoU, 0.6..0.95: with the outline of all steps
    max_cut_share: float = 0.15  # 0..0.3: of the outline on the picture's border
    refined_count: int = 4  # 1..12: beginnings that are refined for each number of steps
    turns_rad: tuple[float, float, float] = (-0.45, 0.0, 0.45)  # -0.8..0.8: tried from each side
    # 0.1..1.5: heights tried, over what the outline says
    rise_ratios: tuple[float, float] = (0.4, 0.8)
    # 0.2..4: depths tried, over the width
    depth_ratios: tuple[float, float, float] = (0.5, 1.0, 2.0)


FLIGHT = FlightSettings()


@dataclass(frozen=True, slots=True)
class Flight:
    """x, y: middle of the toe. tread, riser, width: of each step. yaw: the way uphill, radians."""

    x: float
    y: float
    tread: float
    riser: float
    width: float
    yaw: float
    steps: int

    def block(self, index: int) -> Block:
        """The step of that number, from the lowest, down to the ground."""
        along = (index + 0.5) * self.tread
        x, y = self.x + along * math.cos(self.yaw), self.y + along * math.sin(self.yaw)
        return Block(x, y, (self.tread, self.width, (index + 1) * self.riser), self.yaw)

    def carries(self, camera: Camera, pixel: tuple[float, float]) -> bool:
        """Whether a pixel shows one of its treads; only the camera's directions count."""
        return any(self.block(index).carries(camera, pixel) for index in range(self.steps))

    def ramp(self, height: float) -> Ramp:
        """All of it as stairs in metres, for a camera `height` m above the ground."""
        return Ramp(
            toe=(self.x * height, self.y * height, 0.0),
            yaw=math.atan2(math.sin(self.yaw), math.cos(self.yaw)),
            run=max(self.steps - 1, 1) * self.tread * height,
            rise=self.steps * self.riser * height,
            width=self.width * height,
            plateau=self.tread * height,
            steps=self.steps,
        )


def flights_of(
    image: Image,
    state: SceneState,
    camera: Camera,
    offers: Mapping[str, Sequence[BoolArray]],
    covered: BoolArray,
    told: int | None,
) -> tuple[dict[str, Block], dict[str, Flight]]:
    """Single steps as blocks by name, and the flights of supports that are stairs as a whole.

    camera: any height; only directions count. offers: masks (H, W) of each support, the likeliest
    first. covered: pixels of objects. told: how many steps stairs have,
    where the sentence says it and their own name does not; else the likeliest.
    """
    unit = camera.model_copy(update={"position": (0.0, 0.0, 1.0)})
    names = single_steps(state, offers)
    blocks: dict[str, Block] = {}
    if names:
        masks = [offers[name][0] for name in names]
        flight = flight_of(unit, image, masks, covered, (len(names),))
        if flight is not None:
            blocks = {name: flight.block(index) for index, name in enumerate(names)}
    whole: dict[str, Flight] = {}
    for item in state.supports:
        marked = item.grounding.marks or sum(c.label for c in item.grounding.points) == 3
        if item.shape is None and is_stairs(item.name) and not marked and offers.get(item.name):
            steps = told_steps(item.name) or told
            counts = (steps,) if steps is not None else FLIGHT.guesses_count
            flight = flight_of(unit, image, offers[item.name][:1], covered, counts)
            if flight is not None:
                whole[item.name] = flight
    return blocks, whole


def single_steps(state: SceneState, offers: Mapping[str, Sequence[BoolArray]]) -> list[str]:
    """Supports that are single steps of one flight, the lowest first; none of fewer than two.

    The upper side of a higher step is higher in the picture, from wherever one can see it.
    """
    names = [
        item.name
        for item in state.supports
        if item.shape is None
        and not item.grounding.marks
        and offers.get(item.name)
        and is_step(item.name)
    ]
    if not 2 <= len(names) <= FLIGHT.max_steps:
        return []
    return sorted(names, key=lambda name: -float(np.argwhere(offers[name][0])[:, 0].mean()))


def flight_of(
    camera: Camera,
    image: Image,
    masks: Sequence[BoolArray],
    covered: BoolArray,
    counts: Sequence[int],
) -> Flight | None:
    """The flight that masks (H, W) show: one for each step from the lowest, or one of them all.

    covered: (H, W) pixels of things in front. counts: numbers of steps that come into question.
    None where no flight covers them.
    """
    labels = np.zeros(covered.shape, np.uint8)
    for index, mask in enumerate(masks):
        labels[mask & ~covered & (labels == 0)] = index + 1
    if not labels.any() or border_share(labels > 0) > FLIGHT.max_cut_share:
        return None
    rough: list[tuple[float, _FlightFit, FloatArray]] = []
    for count in counts:
        fit = _FlightFit.of(camera, image, labels, covered, count, len(masks) > 1)
        far = replace(fit, reach=4.0)
        for start in sorted(fit.beginnings(), key=far.cost)[: FLIGHT.refined_count]:
            values = _refined(far, start, 160)
            rough.append((fit.cost(values), fit, values))
    if not rough:
        return None
    rough.sort(key=lambda one: one[0])
    sharp = [(fit, _refined(fit, values, 400)) for _, fit, values in rough[:2]]
    fit, best = min(sharp, key=lambda one: one[0].cost(one[1]))
    found = fit.flight(best)
    return found if fit.drawn(found)[1] >= FLIGHT.min_overlap else None


def _refined(fit: _FlightFit, start: FloatArray, runs: int) -> FloatArray:
    steps = np.array([0.1, 0.15, 0.15, 0.15, 0.2, 0.12])
    return least_near(fit.cost, start, steps, runs, fine=1e-3)[1]


@dataclass(frozen=True, eq=False, slots=True)
class _FlightFit:
    """A flight at working size. labels: (h, w) number of the step from 1, 0 elsewhere.

    single: the labels tell the steps apart. care, away: as in `block_fit.Fit`.
    """

    camera: Camera
    scale: float
    labels: NDArray[np.uint8]
    care: BoolArray
    away: NDArray[np.float32]
    steps: int
    single: bool
    reach: float = 1.2

    @classmethod
    def of(
        cls,
        camera: Camera,
        image: Image,
        labels: NDArray[np.uint8],
        covered: BoolArray,
        steps: int,
        single: bool,
    ) -> _FlightFit:
        """Everything shrunk to working size; the camera at height 1."""
        small = Fit.of(camera, image, labels > 0, covered, "box")
        size = (small.region.shape[1], small.region.shape[0])
        shrunk = np.asarray(cv2.resize(labels, size, interpolation=cv2.INTER_NEAREST), np.uint8)
        return cls(small.camera, small.scale, shrunk, small.care, small.away, steps, single)

    def beginnings(self) -> list[FloatArray]:
        """Parameters to begin from: four ways uphill, turned a little, low and high."""
        rows, columns = np.nonzero(self.labels)
        left, right, top, foot = columns.min(), columns.max() + 1, rows.min(), rows.max() + 1
        corners = [(x / self.scale, foot / self.scale) for x in (left, right)]
        ends = on_plane(self.camera, corners, 0.0)
        if not np.isfinite(ends).all():
            return []
        wide = float(ends[1, 0] - ends[0, 0])
        middle = ends.mean(0)
        tall = wide * (foot - top) / max(right - left, 1)
        found = []
        for quarter, turn, rise, deep in itertools.product(
            range(4), FLIGHT.turns_rad, FLIGHT.rise_ratios, FLIGHT.depth_ratios
        ):
            yaw = quarter * math.pi / 2 + turn
            length, width = (wide, deep * wide) if quarter % 2 == 0 else (deep * wide, wide)
            shrink = 1 / (math.cos(turn) + abs(math.sin(turn)) * min(width, length) / wide)
            length, width = length * shrink, width * shrink
            centre = middle[:2] + np.array([0.0, (width if quarter % 2 == 0 else length) / 2])
            x, y = centre - np.array([math.cos(yaw), math.sin(yaw)]) * length / 2
            logs = [length / self.steps, rise * tall / self.steps, width]
            found.append(np.array([x, y, *(math.log(max(v, 1e-4)) for v in logs), yaw]))
        return found

    def flight(self, values: FloatArray) -> Flight:
        """The flight of six parameters: x, y, logarithms of the three sizes, turn."""
        x, y, tread, riser, width, yaw = (float(v) for v in values)
        return Flight(x, y, math.exp(tread), math.exp(riser), math.exp(width), yaw, self.steps)

    def cost(self, values: FloatArray) -> float:
        """1 − overlap, less what edges of the picture speak for it."""
        if np.abs(values[2:5]).max() > 7 or abs(values[5]) > 3 * math.pi:
            return 2.0
        edges, whole, apart = self.drawn(self.flight(values))
        overlap = 0.5 * (whole + apart) if self.single else whole
        return 1.0 - overlap - FIT.edge_weight * edges

    def drawn(self, flight: Flight) -> tuple[float, float, float]:
        """Share of edges on edges of the picture, overlap (IoU) of all, and of each step."""
        toward = math.cos(flight.yaw) * -flight.x + math.sin(flight.yaw) * -flight.y
        order = sorted(range(flight.steps), key=lambda k: -abs((k + 0.5) * flight.tread - toward))
        canvas = np.zeros(self.labels.shape, np.uint8)
        outlines: list[tuple[int, FloatArray, Block]] = []
        for place, index in enumerate(order):
            block = flight.block(index)
            pixels, depth = self.camera.project(placed(BOX, block))
            pixels = pixels * self.scale
            if depth.min() < 0.02 or np.abs(pixels).max() > 20 * max(self.labels.shape):
                return 0.0, 0.0, 0.0
            hull = np.asarray(cv2.convexHull(pixels.astype(np.float32)), np.float32)
            points = np.round((hull - 0.5) * 16).astype(np.int32)
            cv2.fillConvexPoly(canvas, points, place + 1, shift=4)
            outlines.append((place + 1, pixels, block))
        seen, shown = (canvas > 0) & self.care, (self.labels > 0) & self.care
        whole = float((seen & shown).sum() / max((seen | shown).sum(), 1))
        number = np.array([0, *(index + 1 for index in order)], np.uint8)[canvas]
        same = (number == self.labels) & shown
        apart = float(same.sum() / max((seen | shown).sum(), 1)) if self.single else whole
        return self._on_edges(canvas, outlines), whole, apart

    def _on_edges(
        self, canvas: NDArray[np.uint8], outlines: list[tuple[int, FloatArray, Block]]
    ) -> float:
        share = np.linspace(0.06, 0.94, 14)[:, None]
        nearness: list[FloatArray] = []
        height, width = self.labels.shape
        for place, pixels, block in outlines:
            ends = pixels[_edges(block)]
            points = np.concatenate([a * (1 - share) + b * share for a, b in ends])
            x, y = np.floor(points).astype(int).T
            inside = (x >= 2) & (x < width - 2) & (y >= 2) & (y < height - 2)
            x, y = x[inside], y[inside]
            # What lies well inside of a nearer step is hidden.
            around = [canvas[y + j, x + i] for i, j in ((0, 0), (2, 0), (-2, 0), (0, 2), (0, -2))]
            open_ = self.care[y, x] & ~np.all([one > place for one in around], axis=0)
            nearness.append(np.exp(-0.5 * (self.away[y[open_], x[open_]] / self.reach) ** 2))
        together = np.concatenate(nearness)
        return float(together.mean()) if len(together) else 0.0


def _edges(block: Block) -> NDArray[np.int64]:
    """(N, 2) corners that the edges of the faces of a step join that look to the camera."""
    cos, sin = math.cos(block.yaw), math.sin(block.yaw)
    own = (-block.x * cos - block.y * sin, block.x * sin - block.y * cos)
    half_length, half_width = block.size[0] / 2, block.size[1] / 2
    # Faces of the unit box: top, uphill end, downhill end, left, right of the way uphill.
    looks = (True, own[0] > half_length, own[0] < -half_length, own[1] > half_width)
    looks = (*looks, own[1] < -half_width)
    return edges_of("box", tuple(k for k, visible in enumerate(looks) if visible))
