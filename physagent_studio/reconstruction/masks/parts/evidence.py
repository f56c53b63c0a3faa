"""What speaks for a patch beside a mask being a part of the thing: its edges, contact and colours.

A linear score of what any picture shows, clear cases against ruled out before. Its weights were
fitted (logistic regression, none of them below zero) on which patches belong to the reference
masks of photographs and of rendered scenes, and hold for a picture that was left out.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import correlate1d

from physagent_studio.reconstruction.photo.regions import BoolArray, bounds, disc, grow
from physagent_studio.reconstruction.photo.statistics import bell, lengths, medians, percentile

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int64]
BINS = (12, 20, 20)
"""Bins of lightness and the two tints in a histogram."""
RARE = 2e-4
"""Share of a histogram's bin below which its colour counts as not there."""
NEAR = 3
"""Pixels between a patch and the mask within which they touch."""
SHARP, TINTED, BRIGHTER = 3.3, 12.0, 15.0
"""Sharpness, and step of tint or of lightness upwards, from which a patch is no shadow."""
LONG, ENDING, ENDINGS = 4.0, 0.3, 0.45
"""Length over width from which a patch is a pole or a handle, which touch with their ends; share
of its outline at the mask that counts as much as touching with one end, and with both."""
TALL = 0.26
"""Log of height over width from which a patch stands rather than lies."""
LIKE = 25.0
"""Step of colour (OpenCV's Lab, 0 … 255) within which two pixels mirror one another."""
WEIGHTS = {
    "constant": -7.01,
    "share": 0.32,
    "touching": 5.45,
    "neck": 1.82,
    "unlike beside": 0.88,
    "low": 6.0,
    "shade": 2.15,
    "symmetric": 2.99,
    "before ground": 0.9,
    "sharp": 0.23,
    "sharp before ground": 0.34,
    "like the mask": 0.18,
    "rarer than beside": 0.18,
}
_SQUARE = np.ones((3, 3), np.uint8)
_SOFT = (bell(0.8), bell(1.0), bell(1.0))
"""How histograms are smoothed along each axis."""


@dataclass(frozen=True, eq=False)
class Surroundings:
    """A mask (H, W) in a picture, lab (H, W, 3), and what is looked up of both again and again.

    steps: (H, W) step of colour at each pixel. ground: (H, W) what is around, joined coarsely,
    and reaches the rim of the picture or is large.
    """

    lab: NDArray[np.float32]
    steps: NDArray[np.float32]
    mask: BoolArray
    ground: BoolArray

    @cached_property
    def area(self) -> int:
        """Pixels of the mask."""
        return int(np.count_nonzero(self.mask))

    @cached_property
    def size(self) -> float:
        """Side of a square of the mask's area."""
        return float(np.sqrt(self.area))

    @cached_property
    def bounds(self) -> tuple[int, int, int, int]:
        """(x0, y0, x1, y1) of the mask."""
        return bounds(self.mask)

    @cached_property
    def near(self) -> BoolArray:
        """(H, W) the mask and what touches it."""
        return grow(self.mask, NEAR)

    @cached_property
    def about(self) -> BoolArray:
        """(H, W) the mask and what is close to it for its size."""
        side = 2 * int(0.12 * self.size) + 7
        return cv2.dilate(self.mask.astype(np.uint8), np.ones((side, side), np.uint8)).astype(bool)

    @cached_property
    def axis(self) -> float:
        """Column about which the mask is mirrored."""
        columns = np.nonzero(self.mask)[1]
        return float(np.percentile(columns, 2) + np.percentile(columns, 98)) / 2

    @cached_property
    def strongest(self) -> NDArray[np.float32]:
        """(H, W) the largest step of colour within a pixel."""
        return cv2.dilate(self.steps, _SQUARE).astype(np.float32)

    @cached_property
    def bin_of(self) -> IntArray:
        """(H, W) the bin of each pixel's colour."""
        index = np.clip((self.lab / 256 * BINS).astype(int), 0, np.array(BINS) - 1)
        return (index[..., 0] * BINS[1] + index[..., 1]) * BINS[2] + index[..., 2]

    @cached_property
    def own(self) -> FloatArray:
        """Smoothed share of each bin in the mask."""
        return self.counts(self.bin_of[self.mask]) / self.area

    @cached_property
    def others(self) -> FloatArray:
        """Smoothed pixels in each bin outside of the mask."""
        return self.counts(self.bin_of[~self.mask])

    def counts(self, bins: IntArray) -> FloatArray:
        """Smoothed number of pixels in each bin, of pixels whose bins (N,) are given."""
        count = np.bincount(bins, minlength=int(np.prod(BINS))).reshape(BINS)
        soft: NDArray[Any] = count.astype(np.float32)
        for axis, weights in enumerate(_SOFT):
            soft = correlate1d(soft, weights, axis)
        return soft.ravel()

    @cached_property
    def how_own(self) -> FloatArray:
        """Log share of each bin in the mask."""
        return np.log(self.own + RARE)


@dataclass(frozen=True, slots=True)
class Outline:
    """How a patch meets the mask and the rest: pixels, widths and steps of colour.

    touching: share of its outline at the mask. neck: that over its own width (log, + 0.2). sharp:
    step that four fifths of the rest of its outline exceed (log, + 2). width: of the widest place,
    pixels. ends: at how many separate places it touches the mask.
    """

    touching: float
    neck: float
    sharp: float
    width: float
    ends: int


@dataclass(frozen=True, slots=True)
class Colours:
    """How common a patch's colours are in the mask and elsewhere, and those beside it (log).

    darker: lightness that it lies below what is beside it. tint: step of the tints (0 … 255).
    before: share of what is beside it that is the ground.
    """

    own: float
    others: float
    beside: float
    darker: float
    tint: float
    before: float


@dataclass(frozen=True, eq=False, slots=True)
class Patch:
    """A patch beside a mask: its pixels, rows and columns (N,), and the window that holds it."""

    region: BoolArray
    rows: IntArray
    columns: IntArray
    window: tuple[slice, slice]

    @classmethod
    def at(cls, rows: IntArray, columns: IntArray, shape: tuple[int, ...]) -> Patch:
        """The patch of some pixels, rows and columns (N,), of a picture of this shape."""
        region = np.zeros(shape[:2], bool)
        region[rows, columns] = True
        around = 7
        window = (
            slice(max(0, int(rows.min()) - around), int(rows.max()) + around + 1),
            slice(max(0, int(columns.min()) - around), int(columns.max()) + around + 1),
        )
        return cls(region, rows, columns, window)

    @property
    def tall(self) -> float:
        """Log of its height over its width."""
        return float(np.log((np.ptp(self.rows) + 1) / (np.ptp(self.columns) + 1)))


def outline_of(patch: Patch, here: Surroundings) -> Outline:
    """How the patch's outline runs."""
    inside = patch.region[patch.window].astype(np.uint8)
    ring = cv2.dilate(inside, _SQUARE).astype(bool) & ~inside.astype(bool)
    touching = ring & here.near[patch.window]
    free = ring & ~touching
    steps = here.strongest[patch.window]
    apart = cv2.copyMakeBorder(inside, 1, 1, 1, 1, cv2.BORDER_CONSTANT, value=0)
    reach = float(cv2.distanceTransform(apart, cv2.DIST_L2, 3).max())
    count = int(np.count_nonzero(touching))
    sharp = percentile(np.sort(steps[free]), 20) if free.any() else 0.0
    return Outline(
        count / max(1, int(np.count_nonzero(ring))),
        float(np.log(count / (2 * reach) + 0.2)),
        float(np.log(sharp + 2)),
        2 * reach,
        cv2.connectedComponents(touching.astype(np.uint8), connectivity=8)[0] - 1,
    )


def colours_of(patch: Patch, here: Surroundings) -> Colours:
    """How the patch's colours compare to the mask's, and to those beside it and elsewhere."""
    inside = patch.region[patch.window]
    solid = inside.astype(np.uint8)
    core = cv2.erode(solid, _SQUARE).astype(bool)
    core = core if core.any() else inside
    beside = cv2.dilate(solid, disc(5)).astype(bool) & ~cv2.dilate(solid, disc(2)).astype(bool)
    beside &= ~here.mask[patch.window]
    bins, lab = here.bin_of[patch.window], here.lab[patch.window]
    elsewhere = np.maximum(here.others - here.counts(here.bin_of[patch.rows, patch.columns]), 0)
    elsewhere /= max(float(elsewhere.sum()), 1.0)
    # Logarithms of all bins are fewer than those of all pixels.
    common = np.log(elsewhere + RARE)
    middle = medians(lab[core])
    around = medians(lab[beside]) if beside.any() else middle
    return Colours(
        float(here.how_own[bins[core]].mean()),
        float(common[bins[core]].mean()),
        float(common[bins[beside]].mean()) if beside.any() else -8.0,
        float(around[0] - middle[0]),
        float(np.hypot(*(middle - around)[1:])),
        float(here.ground[patch.window][beside].mean()) if beside.any() else 0.0,
    )


def lowness(patch: Patch, here: Surroundings) -> float:
    """0 … 1: how far down a patch is, from half the mask's size above its lowest row.

    Shadows and reflections are there; legs and stems, which are tall, are as well.
    """
    down = (float(patch.rows.mean()) - here.bounds[3]) / here.size
    return float(np.clip(down + 0.5, 0, 1))


def symmetry(patch: Patch, here: Surroundings) -> float:
    """0 … 1: how much of the patch is mirrored, in the mask, in itself or in its twin."""
    across = np.round(2 * here.axis - patch.columns).astype(int)
    held = (across >= 0) & (across < here.mask.shape[1])
    if held.mean() <= 0.7:
        return 0.0
    rows, columns = patch.rows[held], across[held]
    own = here.lab[rows, patch.columns[held]]
    like = lengths(here.lab[rows, columns] - own) < LIKE
    twin = like.mean() if here.about[rows, columns].mean() > 0.3 else 0.0
    mirrored = (here.mask[rows, columns] & like).mean()
    return float(max(mirrored, patch.region[rows, columns].mean(), twin))


def shade_of(colours: Colours) -> float:
    """0 … 1: how much darker than what is beside it, in the same tint, a patch is."""
    return float(np.clip(colours.darker, 0, 60) / 60 * np.exp(-colours.tint / 10))


def _ending(patch: Patch, outline: Outline) -> float:
    """What touching with its ends counts for a patch many times as long as wide; 0 for others."""
    if len(patch.rows) < LONG * outline.width**2:
        return 0.0
    return ENDINGS if outline.ends > 1 else ENDING


def scores(features: Sequence[dict[str, float]]) -> FloatArray:
    """(N,) how clearly each patch is a part of the thing; above 0 it is rather than not."""
    values = np.array([[each[name] for name in WEIGHTS] for each in features])
    return values.reshape(len(features), len(WEIGHTS)) @ np.array(list(WEIGHTS.values()))


def features_of(
    patch: Patch, here: Surroundings, outline: Outline, colours: Colours
) -> dict[str, float]:
    """What is weighed of a patch."""
    share = float(np.log(len(patch.rows) / here.area))
    step = float(np.hypot(colours.darker, 1.3 * colours.tint))
    low = lowness(patch, here) * float(np.clip(1 - patch.tall / TALL, 0, 1))
    if outline.sharp > SHARP and (colours.tint > TINTED or colours.darker < -BRIGHTER):
        low *= 0.4
    sharp = float(np.clip(outline.sharp - 3, -1, 1.2))
    return {
        "constant": 1.0,
        "share": share,
        "touching": max(outline.touching, _ending(patch, outline)),
        "neck": float(np.clip(outline.neck, -0.2, 1)),
        "unlike beside": float(np.clip(np.log(step + 3), 1.5, 4.3)),
        "low": -low,
        "shade": -shade_of(colours) if low > 0 else 0.0,
        "symmetric": symmetry(patch, here),
        "before ground": colours.before,
        "sharp": sharp,
        "sharp before ground": colours.before * sharp,
        "rarer than beside": float(np.clip(colours.beside - colours.others, -2, 2)),
        "like the mask": float(np.clip(colours.own - colours.others, -1, 1.5)),
    }
