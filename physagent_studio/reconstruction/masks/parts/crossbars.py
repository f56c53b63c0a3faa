"""Bars across the free end of a pole: handlebars, the heads of hammers and rakes, signs' arms.

Such a bar is thin, of other colours than its pole, often of several, and only its middle touches
the mask: patches of one colour do not show it. But it is a band, alike on both sides of the pole,
that stands out from what is above and below it more than any band of that form stands out from
the surroundings elsewhere, and it ends on both sides. How much bands of the surroundings stand out
is measured, so that the same is asked before a hedge and before a plain wall.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from physagent_studio.reconstruction.masks.parts.pole_ends import PoleEnd
from physagent_studio.reconstruction.photo.regions import BoolArray
from physagent_studio.records.case import Image

FloatArray = NDArray[np.float64]
UNIT = 6.0
"""Pixels of a pole's width where bars are sought."""
REACH, ALONG = 9.0, 5.0
"""How far bars are sought to both sides of the pole and along it, in widths of the pole."""
TURNS = tuple(range(-20, 21, 5))
"""Degrees by which a bar may be off a right angle to its pole."""
THICK, LONG = (0.6, 0.9, 1.3, 1.9), (2.0, 3.5, 5.5)
"""Thicknesses of bands and lengths of one side of them, in widths of the pole."""
BEYOND, SHORT_OF = 1.8, 1.0
"""How far beyond the pole's end and short of it a bar's middle may be, in widths of the pole."""
LEVEL = 0.6
"""How far the middles of both sides may be apart across the bar, in widths of the pole."""
SPREAD = 3.0
"""Difference of colour (OpenCV's Lab, tints counted twice) that is not seen."""
COMMON, PLAIN = 90, 97
"""Per cent of the bands around, and of short pieces, that stand out less than usual ones."""
CLEAR = 2.8
"""How much more than the usual band a bar stands out on both of its sides."""
FADED, STEP = 0.35, 1.2
"""Share of a bar's standing out at which it has ended; length of the piece that shows it, and
of a gap that it may have, in widths of the pole."""
GAP = 0.8
SHORTEST, LONGEST, UNEVEN = 1.5, 8.0, 2.5
"""Lengths of a bar's sides from the pole's middle, in its widths, and how unequal they may be."""
CORE, LIKELY = (0.2, 0.15, 0.5), (0.6, 1.5)
"""Shares of thickness, length and the pole's half width that are no sure part of a bar; half widths
of the pole by which it may be thicker and longer than it seems."""
DISTINCT = 0.45
"""Share of a bar's difference from what is beside it down to which rows belong to it."""


@dataclass(frozen=True, eq=False, slots=True)
class _View:
    """The surroundings of a pole's end turned so that its bar would lie level, outward being up.

    lab (h, w, 3), the mask (h, w) and what is in the picture (h, w). to_picture: (2, 3) affine map
    of the view's pixels. unit: pixels of the pole's width.
    """

    lab: NDArray[np.float32]
    mask: BoolArray
    there: BoolArray
    to_picture: FloatArray
    unit: float

    @property
    def middle(self) -> tuple[int, int]:
        """Column and row of the pole's end."""
        return self.lab.shape[1] // 2, self.lab.shape[0] // 2


@dataclass(frozen=True, slots=True)
class _Arm:
    """One side of a bar: how clear it is, its middle row and its length in pixels of the view."""

    clear: float
    row: int
    length: float


@dataclass(frozen=True, eq=False, slots=True)
class Bar:
    """A bar across a pole's end as seen on a view.

    thick: its thickness in the pole's widths. weight: by which it comes before others.
    """

    view: _View
    arms: tuple[_Arm, _Arm]
    thick: float
    weight: float

    def drawn(self, shape: tuple[int, ...], *, likely: bool) -> BoolArray:
        """(H, W) the core of the bar and of the pole up to it, or all that may belong to it."""
        out = np.zeros(shape[:2], np.uint8)
        column, row = self.view.middle
        half = self.view.unit / 2
        for way, arm in zip((-1, 1), self.arms, strict=True):
            top, low = _rows_of(self, arm, way)
            inset = -LIKELY[0] * half if likely else CORE[0] * (low - top)
            longer = LIKELY[1] * half if likely else -CORE[1] * arm.length
            top, low = top + inset, low - inset
            x0, x1 = column - way * half, column + way * (arm.length + longer)
            side = half if likely else CORE[2] * half
            for left, right, high, deep in (
                (x0, x1, top, low),
                # The pole goes on up to the bar.
                (column - side, column + side, low, row),
            ):
                quad = [(left, high), (right, high), (right, deep), (left, deep)]
                points = np.array(quad) @ self.view.to_picture[:, :2].T + self.view.to_picture[:, 2]
                cv2.fillPoly(out, [np.rint(points * 16).astype(np.int32)], 1, shift=4)
        return out.astype(bool)


def bar_at(image: Image, mask: BoolArray, end: PoleEnd) -> Bar | None:
    """The clearest bar at the end of a pole of a mask (H, W); None where none is clear.

    image: (H, W, 3) of a size at which the pole is about as wide as `UNIT`, or wider.
    """
    factor = UNIT / end.width
    soft = cv2.GaussianBlur(image, (0, 0), 0.4 / factor).astype(np.uint8) if factor < 1 else image
    bars = [bar for turn in TURNS for bar in _bars_on(_view(soft, mask, end, turn))]
    return max(bars, key=lambda bar: bar.weight, default=None)


def _view(image: Image, mask: BoolArray, end: PoleEnd, turn: float) -> _View:
    factor = min(1.0, UNIT / end.width)
    unit = end.width * factor
    width, height = int(2 * REACH * unit) | 1, int(2 * ALONG * unit) | 1
    angle = np.deg2rad(turn)
    up = end.outward * np.cos(angle) + end.aside * np.sin(angle)
    right = end.aside * np.cos(angle) - end.outward * np.sin(angle)
    to_picture = np.zeros((2, 3))
    to_picture[:, 0], to_picture[:, 1] = right / factor, -up / factor
    to_picture[:, 2] = end.tip - to_picture[:, :2] @ (width // 2, height // 2)

    def turned(picture: NDArray, how: int, rim: int) -> NDArray:
        flags = how | cv2.WARP_INVERSE_MAP
        return cv2.warpAffine(picture, to_picture, (width, height), flags=flags, borderMode=rim)

    rgb = turned(image, cv2.INTER_LINEAR, cv2.BORDER_REPLICATE).astype(np.uint8)
    lab = cv2.cvtColor(rgb, cv2.COLOR_RGB2LAB).astype(np.float32)
    lab[..., 1:] *= 2
    own = turned(mask.astype(np.uint8) * 255, cv2.INTER_LINEAR, cv2.BORDER_CONSTANT) > 127
    there = turned(np.ones(mask.shape, np.uint8), cv2.INTER_NEAREST, cv2.BORDER_CONSTANT) > 0
    return _View(lab, own, there, to_picture, unit)


def _mean(picture: NDArray[np.float32], length: float, thick: float) -> NDArray[np.float32]:
    """The mean of the pixels around each within a level band."""
    size = (max(3, round(length)), max(2, round(thick)))
    return np.asarray(cv2.blur(picture, size, borderType=cv2.BORDER_REPLICATE), np.float32)


def _apart(
    lab: NDArray[np.float32], length: float, thick: float
) -> tuple[NDArray[np.float32], NDArray[np.float32], int]:
    """(h, w, 3) how far bands differ from those above and below; rows at the rim without any."""
    thickness = max(2, round(thick))
    beside = max(2, round(0.7 * thickness))
    own, other = _mean(lab, length, thickness), _mean(lab, length, beside)
    far = (thickness + beside) // 2 + 1
    return own - np.roll(other, far, 0), own - np.roll(other, -far, 0), far + thickness


def _bars_on(view: _View) -> Iterator[Bar]:
    """The bars at the middle of a view that stand out from it as nothing else does."""
    held, there = view.mask.astype(np.float32), view.there.astype(np.float32)
    row = view.middle[1]
    for thick in THICK:
        for long in LONG:
            length, thickness = long * view.unit, thick * view.unit
            above, below, rim = _apart(view.lab, length, thickness)
            usual = (_mean(held, length, 3 * thickness) <= 0) & (
                _mean(there, length, 3 * thickness) > 0.999
            )
            usual[:rim] = usual[-rim:] = False
            usual[int(row - 1.6 * view.unit) : int(row + 1.6 * view.unit)] = False
            if np.count_nonzero(usual) < 50:
                continue
            white = _whitening(np.concatenate([above[usual], below[usual]]))
            out = _standing_out(above, below, rim, white)
            most = max(float(np.percentile(out[usual], COMMON)), 1.0)
            pieces = _standing_out(*_apart(view.lab, STEP * view.unit, thickness), white)
            plain = float(np.percentile(pieces[usual], PLAIN))
            left, right = (_arm(view, out, pieces, (length, plain), way) for way in (-1, 1))
            bar = Bar(view, (left, right), thick, min(left.clear, right.clear) / most * long**0.25)
            if min(left.clear, right.clear) > CLEAR * most and _is_even(bar):
                yield bar


def _whitening(differences: NDArray[np.float32]) -> FloatArray:
    """(3, 3) that makes differences of colours (N, 3) as large as they are unusual."""
    spread = differences.T @ differences / len(differences) + SPREAD**2 * np.eye(3)
    return np.asarray(np.linalg.cholesky(np.linalg.inv(spread)), float)


def _standing_out(
    above: NDArray[np.float32], below: NDArray[np.float32], rim: int, white: FloatArray
) -> FloatArray:
    """(h, w) how unusual it is how far bands differ from both what is above and below."""
    one, other = (np.linalg.norm(side @ white, axis=2) for side in (above, below))
    out = np.minimum(one, other)
    out[:rim] = out[-rim:] = 0
    return out


def _arm(
    view: _View, out: FloatArray, pieces: FloatArray, about: tuple[float, float], way: int
) -> _Arm:
    """The clearest arm to one side (-1 left, 1 right) of the pole.

    out, pieces: (h, w) how much bands and short ones stand out. about: pixels of a band, and how
    much pieces of the surroundings stand out.
    """
    length, plain = about
    column, row = view.middle
    at = round(column + way * (0.5 * view.unit + length / 2))
    if not 0 <= at < out.shape[1]:
        return _Arm(0, row, 0)
    rows = np.arange(int(row - BEYOND * view.unit), int(row + SHORT_OF * view.unit) + 1)
    best = int(rows[np.argmax(out[rows, at])])
    start = round(column + way * 0.6 * view.unit)
    line = pieces[max(0, best - 1) : best + 2].max(0)[start::way]
    faded = line < min(FADED * float(out[best, at]), plain)
    gap = max(1, round(GAP * view.unit))
    runs = np.convolve(faded, np.ones(gap), "valid") >= gap
    end = int(np.argmax(runs)) if runs.any() else len(line)
    return _Arm(float(out[best, at]), best, end + 0.6 * view.unit)


def _is_even(bar: Bar) -> bool:
    """Whether both arms lie in one line, end, and are of like length."""
    left, right = bar.arms
    unit = bar.view.unit
    short, long = sorted((left.length / unit, right.length / unit))
    in_line = abs(left.row - right.row) < LEVEL * unit
    return in_line and short > SHORTEST and long < min(LONGEST, UNEVEN * short)


def _rows_of(bar: Bar, arm: _Arm, way: int) -> tuple[int, int]:
    """First and last row of an arm: as far as rows differ from what is above and below it."""
    view = bar.view
    unit = view.unit
    column = view.middle[0]
    near = min(1.2 * unit, 0.5 * arm.length)
    x0, x1 = sorted((column + way * near, column + way * arm.length))
    columns = slice(max(0, int(x0)), int(x1) + 1)
    line = view.lab[:, columns].mean(axis=1)
    rows = np.arange(len(line))
    far = np.abs(rows - arm.row)
    around = (far > (0.5 * bar.thick + 1.0) * unit) & (far < 3.5 * unit)
    noise = _whitening(line[around] - line[around].mean(0))
    ends = []
    for side in (-1, 1):
        beside = around & ((rows - arm.row) * side > 0)
        reference = np.median(line[beside], axis=0)
        unlike = np.linalg.norm((line - reference) @ noise, axis=1)
        least = DISTINCT * min(unlike[arm.row], 6.0)
        at = arm.row
        while abs(at + side - arm.row) < 1.3 * unit and unlike[at + side] > least:
            at += side
        ends.append(at)
    return ends[0], ends[1] + 1
