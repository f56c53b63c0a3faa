"""How well an outline in the picture is that of a top that fills a box."""

import math
from dataclasses import dataclass
from typing import Self

import cv2
import numpy as np
from numpy.typing import NDArray

from physagent_studio.arrays import BoolArray, FloatArray
from physagent_studio.reconstruction.photo.regions import grow
from physagent_studio.reconstruction.supports.seen_ends import Shown

Box = tuple[float, float, float, float]
"""Left, top, right, bottom, pixels."""


@dataclass(frozen=True, slots=True)
class OutlineSettings:
    """What the outline of a top is like."""

    side_px: float = 400.0  # 200..1000: longer side of the picture as it is looked at
    step_lab: float = 15.0  # 6..30: from which a step of colour is an edge for sure
    beside_px: float = 2.0  # 1..4: off the outline, where colours are compared
    # 2..8: inside the outline, where the top is alike all around
    within_px: float = 4.0
    like_lab: float = 14.0  # 6..30: up to which two places of a top are alike
    directions_count: int = 16  # 8..32: across which steps are looked for
    places_count: int = 24  # 8..64: of each of four sides that are looked at
    unseen_share: float = 0.5  # share, 0..1: that a place which is not seen counts for
    weakest_weight: float = 0.5  # weight, 0..1: of the side that is least of an edge
    alike_weight: float = 0.5  # weight, 0..1: of being alike inside of all sides
    box_weight: float = 0.6  # weight, 0.2..1: of filling the box
    # weight, 0.5..4: of how far things stand beside it, in the width of the box
    standing_weight: float = 1.0
    # 0..0.1: over its sides: how much wider than the table a box is drawn, and its spread
    pad_ratio: float = 0.03
    pad_spread_ratio: float = 0.035  # 0.01..0.1: the spread of that

    @property
    def best_worth(self) -> float:
        """What an outline is worth at most."""
        return 1 + self.alike_weight + self.box_weight


OUTLINE = OutlineSettings()


@dataclass(frozen=True, eq=False, slots=True)
class View:
    """A picture, made smaller, in which outlines are looked at.

    steps: (K, H, W) steps of colour, 0 … 1, across K directions of the half circle. lab: (H, W, 3).
    free: (H, W) where no thing is in front. factor: its pixels over the photo's. box: in its own
    pixels, as standing (M, 2): the middles of what stands on the top.
    """

    steps: NDArray[np.float32]
    lab: NDArray[np.float32]
    free: BoolArray
    factor: float
    box: Box
    standing: FloatArray

    @classmethod
    def of(cls, shown: Shown, box: Box, standing: FloatArray) -> Self:
        """box, standing: in pixels of the photo."""
        height, width = shown.covered.shape
        factor = min(1.0, OUTLINE.side_px / max(height, width))
        size = (max(round(width * factor), 8), max(round(height * factor), 8))
        small = cv2.resize(shown.image, size, interpolation=cv2.INTER_AREA)
        lab = cv2.cvtColor(cv2.GaussianBlur(small, (0, 0), 0.8), cv2.COLOR_RGB2LAB)
        lab = (lab * np.array([0.5, 1, 1])).astype(np.float32)
        hidden = cv2.resize(shown.covered.astype(np.uint8), size) > 0
        count = OUTLINE.directions_count
        steps = np.array([_steps(lab, math.pi * k / count) for k in range(count)])
        left, top, right, bottom = (side * factor for side in box)
        own = (left, top, right, bottom)
        return cls(steps, lab, ~grow(hidden, 2), factor, own, standing * factor)

    def worth(self, outlines: FloatArray) -> FloatArray:
        """(P,) of outlines (P, 4, N, 2), sides one after the other, 0 … `OUTLINE.best_worth`."""
        ring = outlines.reshape(len(outlines), -1, 2)
        along = np.roll(ring, -1, 1) - np.roll(ring, 1, 1)
        fills, off = self._fills(ring), self._off(ring)
        return (
            self._edge(ring, along)
            + OUTLINE.alike_weight * self._alike(ring, along)
            + OUTLINE.box_weight * fills
            - OUTLINE.standing_weight * off
        )

    def _edge(self, ring: FloatArray, along: FloatArray) -> FloatArray:
        """(P,) how much of outlines (P, 4 N, 2) is an edge, and of their weakest side."""
        x, y, seen = self._at(ring)
        across = np.arctan2(along[..., 0], -along[..., 1]) % math.pi
        number = np.round(np.nan_to_num(across) / math.pi * OUTLINE.directions_count).astype(int)
        step = self.steps[number % OUTLINE.directions_count, y, x]
        each = _sides(np.where(seen, step, OUTLINE.unseen_share))
        weak = OUTLINE.weakest_weight
        return (each.mean(1) + weak * each.min(1)) / (1 + weak)

    def _alike(self, ring: FloatArray, along: FloatArray) -> FloatArray:
        """(P,) how much of the side that is least so is inside like most of the outline is."""
        inward = np.stack([along[..., 1], -along[..., 0]], -1) * -_turn(ring)[:, None, None]
        inward /= np.maximum(np.linalg.norm(inward, axis=2, keepdims=True), 1e-9)
        x, y, seen = self._at(ring + OUTLINE.within_px * inward)
        own = np.where(seen[..., None], self.lab[y, x], np.nan)
        nothing = ~seen.any(1)
        own[nothing] = 0.0
        off = np.linalg.norm(own - np.nanmedian(own, axis=1)[:, None], axis=2)
        like = np.nan_to_num(off, nan=np.inf) < OUTLINE.like_lab
        return _sides(np.where(seen, like, OUTLINE.unseen_share)).min(1)

    def _at(self, ring: FloatArray) -> tuple[NDArray[np.intp], NDArray[np.intp], BoolArray]:
        """Columns and rows (P, M) of places (P, M, 2), and whether the picture shows them."""
        height, width = self.free.shape
        rim = 3
        at = np.floor(np.nan_to_num(np.clip(ring, -9, 2 * OUTLINE.side_px), nan=-9)).astype(np.intp)
        x, y = at[..., 0], at[..., 1]
        seen = (x >= rim) & (y >= rim) & (x < width - rim) & (y < height - rim)
        x, y = np.clip(x, 0, width - 1), np.clip(y, 0, height - 1)
        return x, y, seen & self.free[y, x]

    def _fills(self, ring: FloatArray) -> FloatArray:
        """(P,) 0 … 1 how well outlines reach the left, the right and the upper side of the box.

        Where the box ends with the picture the top may go on, but it does not end before.
        """
        left, top, right, bottom = self.box
        low, high = ring.min(1), ring.max(1)
        wide = right - left
        ends = (
            (left > 2, (low[:, 0] - left) / wide),
            (right < self.free.shape[1] - 3, (right - high[:, 0]) / wide),
            (top > 2, (low[:, 1] - top) / min(bottom - top, wide)),
        )
        pad = OUTLINE.pad_ratio
        short = np.array([off - pad if known else np.maximum(off, 0) for known, off in ends])
        return np.exp(-0.5 * (short / OUTLINE.pad_spread_ratio) ** 2).mean(0)

    def _off(self, ring: FloatArray) -> FloatArray:
        """(P,) how far outside of outlines things stand at most, over the width of the box."""
        along = np.roll(ring, -1, 1) - ring
        length = np.maximum(np.linalg.norm(along, axis=2), 1e-9)
        worst = np.zeros(len(ring))
        for place in self.standing:
            to = place - ring
            inside = along[..., 0] * to[..., 1] - along[..., 1] * to[..., 0]
            worst = np.maximum(worst, -(inside / length * _turn(ring)[:, None]).min(1))
        return worst / max(self.box[2] - self.box[0], 1.0)


def _sides(each: FloatArray) -> FloatArray:
    """(P, 4) means of the four sides of what there is at the places (P, 4 N) of outlines."""
    return each.reshape(len(each), 4, -1).mean(2)


def _turn(ring: FloatArray) -> FloatArray:
    """(P,) which way round outlines (P, M, 2) go, 1 or −1."""
    x, y = ring[..., 0], ring[..., 1]
    return np.sign((x * np.roll(y, -1, 1) - y * np.roll(x, -1, 1)).sum(1))


def _steps(lab: NDArray[np.float32], angle: float) -> NDArray[np.float32]:
    """(H, W) steps of colour across a direction, 0 … 1, and less of them some pixels beside."""
    by = OUTLINE.beside_px * np.array([math.cos(angle), math.sin(angle)])
    size = (lab.shape[1], lab.shape[0])
    ahead, behind = (
        cv2.warpAffine(
            lab,
            np.array([[1, 0, sign * by[0]], [0, 1, sign * by[1]]]),
            size,
            borderMode=cv2.BORDER_REPLICATE,
        )
        for sign in (1, -1)
    )
    step = np.clip(np.linalg.norm(ahead - behind, axis=2) / OUTLINE.step_lab, 0, 1)
    # A search finds its way to an edge only where something tells that it is near.
    near = ((3, 1.0), (7, 0.75), (15, 0.5))
    wider = [share * cv2.dilate(step, np.ones((w, w), np.uint8)) for w, share in near]
    return np.max(wider, axis=0).astype(np.float32)
