"""Where a marked thing is, pixel by pixel, as a network sees it that has seen many.

The network (a U-Net, `assets/networks/thing_map.onnx`) is shown a square of the picture, what a
person marked there and what it saw before, and says of each pixel how likely it belongs to the
thing: first on the whole picture or around a box, then closer, around what it found. It was fitted
by `tools/thing_net` on generated pictures alone, two in five of their things made up by chance,
with colours turned, so that it learns how things stand out rather than what they look like.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache

import cv2
import numpy as np
from numpy.typing import NDArray

from physagent_studio.assets import assets_dir
from physagent_studio.program.scene.state import Grounding
from physagent_studio.reconstruction.learned.network import Network
from physagent_studio.reconstruction.masks.choice import Scored
from physagent_studio.reconstruction.masks.task import View
from physagent_studio.reconstruction.photo.regions import BoolArray, bounds
from physagent_studio.records.case import Image

FloatArray = NDArray[np.float32]
Point = tuple[float, float]
Box = tuple[float, float, float, float]
CANVAS = 128
"""Sides in pixels of the square that the network sees."""
LAYERS = 7
"""Layers of it: red, green, blue, clicks on the thing and off it, the box, what was seen before."""
WORKED_ON = 640
"""Longest side in pixels to which a picture is reduced before it is looked at."""
MARK_RADIUS = 3
"""Radius of a click as the network is shown it, pixels of the square."""
AROUND_BOX, AROUND_FOUND = 1.4, 1.5
"""Sides of the squares that are looked at, in longer sides of the box and of what was found."""
NEARER = (0.6, 0.36, 0.22, 0.14)
"""Sides of squares around clicks, as shares of the picture's longer one, that are looked at besides
all of the picture; that leads in which the network is sure and which agrees with the others."""
AGREED = 0.6
"""How much it counts that looks agree, against how sure the network is at both sights of one."""
PIECES = (0.8, 0.55)
"""Sides of overlapping squares, in longer sides of the box, in which a thing is looked at piece by
piece at the end; what they show is averaged with what was seen of it as a whole."""
APART, REACH = 0.5, 0.9
"""Steps between such squares, in their sides, at most, and by how much of half of one the outermost
lie within the box."""
FAINT = 1e-3
"""Weight of what was seen before among what squares show, which fades to nothing at their rims."""
SPREAD = 1.2
"""How many times as wide as the clicks are apart a square has to be."""
WIDER = 0.02
"""By how much what is taken for a thing's box is wider than it, on each side."""
MAP_SHARE = 0.4
"""What the map says of a draft, as a share of its score."""
SMALLEST = 24.0
"""Least side of a square, pixels of the picture."""


@dataclass(frozen=True, slots=True)
class Marks:
    """Clicks on a thing and off it, and a box (x0, y0, x1, y1), in pixels of a picture."""

    inside: tuple[Point, ...]
    outside: tuple[Point, ...]
    box: tuple[float, ...] | None

    @classmethod
    def of(cls, grounding: Grounding, factor: float) -> Marks:
        """What a person marked, on the picture brought to `factor` of its size."""
        on, off = (
            tuple((click.x * factor, click.y * factor) for click in grounding.points if said(click))
            for said in (lambda click: click.label == 1, lambda click: click.label == 0)
        )
        if grounding.box is None:
            return cls(on, off, None)
        (x0, x1), (y0, y1) = sorted(grounding.box[::2]), sorted(grounding.box[1::2])
        return cls(on, off, tuple(factor * v for v in (x0, y0, x1, y1)))


@dataclass(frozen=True, slots=True)
class Square:
    """A part of a picture: its middle and its side, pixels. It may reach beyond the picture."""

    x: float
    y: float
    side: float

    @classmethod
    def around(cls, box: Sequence[float], share: float) -> Square:
        """Around x0, y0, x1, y1, so many of its longer sides wide."""
        side = max(share * max(box[2] - box[0], box[3] - box[1]), SMALLEST)
        return cls((box[0] + box[2]) / 2, (box[1] + box[3]) / 2, side)

    @property
    def matrix(self) -> FloatArray:
        """(2, 3) from pixels of the picture to those of the canvas."""
        s, half = CANVAS / self.side, CANVAS / 2
        return np.array([[s, 0, half - s * self.x], [0, s, half - s * self.y]], np.float32)


@dataclass(frozen=True, eq=False, slots=True)
class ThingMap:
    """Where a thing is, on the picture with its longer side at most `WORKED_ON`.

    chance: (h, w) the probability of each pixel that it belongs to the thing, 0 … 1. agreement: how
    much different looks at it show the same, 0 … 1. looks: maps (h, w) of each of them, and of its
    pieces.
    """

    chance: FloatArray
    agreement: float
    looks: tuple[FloatArray, ...] = ()


def thing_map(image: Image, grounding: Grounding) -> ThingMap | None:
    """Where a marked thing is; None where nothing was marked."""
    factor = min(1.0, WORKED_ON / max(image.shape[:2]))
    sized = cv2.resize(image, None, fx=factor, fy=factor, interpolation=cv2.INTER_AREA)
    small = np.asarray(sized, np.uint8)
    marks = Marks.of(grounding, factor)
    if marks.box is not None:
        square = Square.around(marks.box, AROUND_BOX)
        first = _looked(small, marks, square, None)
        second = _looked(small, marks, square, first)
        return _in_pieces(small, marks, ThingMap(second, soft_iou(first, second)), marks.box)
    if not marks.inside:
        return None
    far = [_looked(small, marks, square, None) for square in _squares(small, marks)]
    near = [_closer(small, marks, found) for found in far]
    agreement = [float(np.mean([soft_iou(one, other) for other in near])) for one in near]
    sure = [expected_iou(a) * expected_iou(b) for a, b in zip(far, near, strict=True)]
    best = int(np.argmax(np.array(agreement) ** AGREED * sure))
    last = _closer(small, marks, near[best])
    found = ThingMap(last, agreement[best], tuple(near))
    return _in_pieces(small, marks, found, _extent(last, marks))


def extent_of(chance: FloatArray, grounding: Grounding, shape: tuple[int, ...]) -> Box:
    """A person's box, or bounds of what is likely the thing, in pixels of the picture (H, W)."""
    if grounding.box is not None:
        return grounding.box
    factor = max(shape[:2]) / max(chance.shape)
    marks = Marks.of(grounding, 1 / factor)
    x0, y0, x1, y1 = (factor * v for v in _extent(chance, marks))
    wide = WIDER * max(x1 - x0, y1 - y0)
    return x0 - wide, y0 - wide, x1 + wide, y1 + wide


def seen_in(chance: FloatArray, view: View, shape: tuple[int, ...]) -> FloatArray:
    """(h, w) the map on a view of the picture (H, W)."""
    factor = max(chance.shape) / max(shape[:2])
    x0, y0, x1, y1 = (v * factor for v in view.part)
    rows, columns = view.lab.shape[:2]
    scale = np.array([[columns / (x1 - x0), 0, 0], [0, rows / (y1 - y0), 0]], np.float32)
    scale[:, 2] = -scale[0, 0] * x0, -scale[1, 1] * y0
    return np.asarray(cv2.warpAffine(chance, scale, (columns, rows)), np.float32)


def weighed(drafts: Sequence[Scored], chance: FloatArray, share: float = MAP_SHARE) -> list[Scored]:
    """Drafts, best first, each by its own score and by its IoU with the map (h, w)."""
    again = [
        (draft, (1 - share) * value + share * soft_iou(draft.mask, chance))
        for draft, value in drafts
    ]
    return sorted(again, key=lambda scored: -scored[1])


def soft_iou(one: BoolArray | FloatArray, other: FloatArray) -> float:
    """IoU of two masks or maps (h, w), taken as sets to which pixels belong in part, 0 … 1."""
    return float(np.minimum(one, other).sum() / max(float(np.maximum(one, other).sum()), 1e-6))


def expected_iou(chance: FloatArray) -> float:
    """The IoU that the likelier half of a map has with the thing, if its chances are true."""
    return soft_iou(chance > 0.5, chance)


def shown(image: Image, marks: Marks, square: Square, before: FloatArray | None) -> FloatArray:
    """(7, S, S) what the network is shown of a square of a picture (H, W, 3)."""
    height, width = image.shape[:2]
    matrix, canvas, scale = square.matrix, (CANVAS, CANVAS), CANVAS / square.side
    soft = cv2.GaussianBlur(image, (0, 0), 0.45 / scale) if scale < 0.8 else image
    colours = cv2.warpAffine(soft, matrix, canvas).astype(np.float32) / 255
    held = cv2.warpAffine(np.ones((height, width), np.float32), matrix, canvas) > 0.5
    out = np.zeros((LAYERS, CANVAS, CANVAS), np.float32)
    out[:3] = (colours.transpose(2, 0, 1) - 0.5) * held
    out[3], out[4] = _spots(marks.inside, matrix), _spots(marks.outside, matrix)
    if marks.box is not None:
        corners = np.reshape(marks.box, (2, 2)) @ matrix[:, :2].T + matrix[:, 2]
        low = np.clip(corners[0], 0, CANVAS).astype(int)
        high = np.clip(np.ceil(corners[1]), 0, CANVAS).astype(int)
        out[5, low[1] : high[1], low[0] : high[0]] = 1
    if before is not None:
        out[6] = cv2.warpAffine(before, matrix, canvas) * held
    return out


def _looked(image: Image, marks: Marks, square: Square, before: FloatArray | None) -> FloatArray:
    """(H, W) what the network says of a square; nothing of what lies beyond it."""
    seen = shown(image, marks, square, before)
    (found,) = _network().run({"": seen[None]}, {"": (1, 1, CANVAS, CANVAS)})
    chance = 1.0 / (1.0 + np.exp(-np.clip(found[0, 0], -12.0, 12.0)))
    size, back = (image.shape[1], image.shape[0]), cv2.INTER_LINEAR | cv2.WARP_INVERSE_MAP
    return np.asarray(cv2.warpAffine(chance, square.matrix, size, flags=back), np.float32)


def _squares(image: Image, marks: Marks) -> list[Square]:
    """All of the picture, and smaller and smaller squares around the clicks and within it."""
    height, width = image.shape[:2]
    low, high = np.min(marks.inside, axis=0), np.max(marks.inside, axis=0)
    out = [Square(width / 2, height / 2, max(width, height))]
    for share in NEARER:
        half = share * max(width, height) / 2
        if 2 * half > SPREAD * float((high - low).max()):
            x, y = (
                float(np.clip(at, min(half, length / 2), max(length - half, length / 2)))
                for at, length in zip((low + high) / 2, (width, height), strict=True)
            )
            out.append(Square(x, y, 2 * half))
    return out


def _closer(image: Image, marks: Marks, found: FloatArray) -> FloatArray:
    """What is seen when what was found is looked at again from close by."""
    return _looked(image, marks, Square.around(_extent(found, marks), AROUND_FOUND), found)


def _in_pieces(image: Image, marks: Marks, seen: ThingMap, box: Sequence[float]) -> ThingMap:
    """The map of a thing in a box (x0, y0, x1, y1), with its pieces looked at from closer by."""
    maps = [seen.chance]
    for share in PIECES:
        side = max(share * max(box[2] - box[0], box[3] - box[1]), SMALLEST)
        across, down = (_middles(box[k], box[k + 2], side) for k in (0, 1))
        squares = [Square(x, y, side) for x in across for y in down]
        maps.append(_put_together(image, marks, squares, maps[-1]))
    chance = np.asarray(np.mean(maps, axis=0), np.float32)
    return ThingMap(chance, seen.agreement, (*seen.looks, maps[1]))


def _middles(low: float, high: float, side: float) -> list[float]:
    """Middles of squares of a side that cover a stretch, the outer ones a little beyond it."""
    inset = REACH * min(side, high - low) / 2
    count = math.ceil((high - low) / (APART * side)) if high - low > REACH * side else 1
    return (
        [float(x) for x in np.linspace(low + inset, high - inset, count)]
        if count > 1
        else [(low + high) / 2]
    )


def _put_together(
    image: Image, marks: Marks, squares: Sequence[Square], before: FloatArray
) -> FloatArray:
    """(H, W) what squares show, each by its middle more than by its rim; `before` beside them."""
    total, weights = before * FAINT, np.full_like(before, FAINT)
    rows, columns = np.ogrid[: before.shape[0], : before.shape[1]]
    for square in squares:
        near = [
            np.clip(1 - 2 * np.abs(at - middle) / square.side, 0, 1)
            for at, middle in ((rows, square.y), (columns, square.x))
        ]
        weight = near[0] * near[1]
        total += weight * _looked(image, marks, square, before)
        weights += weight
    return np.where(weights < 20 * FAINT, before, total / weights).astype(np.float32)


def _extent(chance: FloatArray, marks: Marks) -> Box:
    """Bounds of what was found where clicks are, else of the largest that was found."""
    likely = (chance > 0.5).astype(np.uint8)
    count, labels, stats, _ = cv2.connectedComponentsWithStats(likely)
    rows, columns = labels.shape
    at = [(min(int(y), rows - 1), min(int(x), columns - 1)) for x, y in marks.inside]
    if count == 1:
        (y, x), half = at[0], SMALLEST / 2
        return (x - half, y - half, x + half, y + half)
    own = {int(labels[pixel]) for pixel in at} - {0}
    own = own or {1 + int(stats[1:, cv2.CC_STAT_AREA].argmax())}
    return bounds(np.isin(labels, list(own)))


def _spots(points: Sequence[Point], matrix: FloatArray) -> FloatArray:
    out = np.zeros((CANVAS, CANVAS), np.float32)
    for x, y in points:
        at = matrix @ np.array([x, y, 1.0])
        cv2.circle(out, (round(float(at[0])), round(float(at[1]))), MARK_RADIUS, 1.0, -1)
    return out


@cache
def _network() -> Network:
    return Network((assets_dir() / "networks" / "thing_map.onnx").read_bytes())
