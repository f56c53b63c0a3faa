"""Where a marked thing is, pixel by pixel, as a network sees it that has seen many.

The network (a U-Net, `assets/networks/thing_map.onnx`) is shown a square of the picture, what a
person marked there and what it saw before, and says of each pixel how likely it belongs to the
thing: first on the whole picture or around a box, then closer, around what it found. It was fitted
by `tools/thing_net` on generated pictures alone, two in five of their things made up by chance,
with colours turned, so that it learns how things stand out rather than what they look like.
"""

from __future__ import annotations

import hashlib
import math
from collections.abc import Sequence
from dataclasses import dataclass, field
from functools import cache, lru_cache

import cv2
import numpy as np
from numpy.typing import NDArray

from physagent_studio.assets import assets_dir
from physagent_studio.program.scene.state import Grounding
from physagent_studio.reconstruction.learned.network import Network
from physagent_studio.reconstruction.masks.task import View
from physagent_studio.reconstruction.photo.regions import BoolArray, bounds
from physagent_studio.records.case import Image

FloatArray = NDArray[np.float32]
Point = tuple[float, float]
Box = tuple[float, float, float, float]


@dataclass(frozen=True, slots=True)
class MapSettings:
    """What the network is shown of a picture, and how what it says is put together."""

    canvas_px: int = 128  # 64..512: sides of the square that the network sees, as it was fitted
    # count, 7..7: of it: red, green, blue, clicks on and off the thing, box, what was seen before
    canvas_layers: int = 7
    picture_px: int = 640  # 256..1280: the picture's longer side, reduced to it before looking
    mark_px: int = 3  # 1..8: of the square: radius of a click, as the network was fitted
    box_ratio: float = 1.4  # 1..2: side of the square that is looked at, over the box's longer one
    found_ratio: float = 1.5  # 1..2: the same over what was found, which may be too small
    # 0.05..1: over the picture's longer side: squares around clicks besides all of the picture
    nearer_ratios: tuple[float, ...] = (0.6, 0.36, 0.22, 0.14)
    # exponent, 0..3: of how looks agree, against how sure the network is at both sights of one
    agreement_power: float = 0.6
    # 0.3..1: over the box's longer side: overlapping squares, in which a thing is looked at piece
    # by piece at the end; what they show is averaged with what was seen of it as a whole
    piece_ratios: tuple[float, ...] = (0.8, 0.55)
    max_apart_ratio: float = 0.5  # 0.2..1: over their sides: steps between such squares
    inset_ratio: float = 0.9  # 0.5..1: over half of one, by which the outermost lie in the box
    # weight, 0.00001..0.1: of what was seen before, as squares fade to nothing at their rims
    before_weight: float = 1e-3
    min_spread_factor: float = 1.2  # 1..3: as wide as the clicks are apart a square has to be
    wider_ratio: float = 0.02  # 0..0.1: on each side, what is taken for a box is wider than found
    min_square_px: float = 24.0  # 8..64: of the picture: smaller ones show nothing more
    # count, 1..64: of maps kept, up to 8 MB each: of six things from their clicks and in their box
    kept_count: int = 12


MAP = MapSettings()


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
        side = max(share * max(box[2] - box[0], box[3] - box[1]), MAP.min_square_px)
        return cls((box[0] + box[2]) / 2, (box[1] + box[3]) / 2, side)

    @property
    def matrix(self) -> FloatArray:
        """(2, 3) from pixels of the picture to those of the canvas."""
        s, half = MAP.canvas_px / self.side, MAP.canvas_px / 2
        return np.array([[s, 0, half - s * self.x], [0, s, half - s * self.y]], np.float32)


@dataclass(frozen=True, eq=False, slots=True)
class ThingMap:
    """Where a thing is, on the picture with its longer side at most `picture_px`.

    chance: (h, w) the probability of each pixel that it belongs to the thing, 0 … 1. agreement: how
    much different looks at it show the same, 0 … 1. looks: maps (h, w) of each of them, and of its
    pieces.
    """

    chance: FloatArray
    agreement: float
    looks: tuple[FloatArray, ...] = ()


@dataclass(frozen=True, slots=True)
class _Picture:
    """A reduced picture (H, W, 3) that is known by its content."""

    digest: bytes
    pixels: Image = field(compare=False)


def thing_map(image: Image, grounding: Grounding) -> ThingMap | None:
    """Where a marked thing is; None where nothing was marked.

    What was seen last is kept: the same photo is looked at again for every other sentence.
    """
    factor = min(1.0, MAP.picture_px / max(image.shape[:2]))
    sized = cv2.resize(image, None, fx=factor, fy=factor, interpolation=cv2.INTER_AREA)
    small = np.ascontiguousarray(sized, np.uint8)
    named = _Picture(str(small.shape).encode() + hashlib.sha256(small.tobytes()).digest(), small)
    return _seen(named, Marks.of(grounding, factor))


@lru_cache(maxsize=MAP.kept_count)
def _seen(picture: _Picture, marks: Marks) -> ThingMap | None:
    found = _found(picture.pixels, marks)
    for one in () if found is None else (found.chance, *found.looks):
        one.setflags(write=False)
    return found


def _found(small: Image, marks: Marks) -> ThingMap | None:
    if marks.box is not None:
        square = Square.around(marks.box, MAP.box_ratio)
        first = _looked(small, marks, square, None)
        second = _looked(small, marks, square, first)
        return _in_pieces(small, marks, ThingMap(second, soft_iou(first, second)), marks.box)
    if not marks.inside:
        return None
    far = [_looked(small, marks, square, None) for square in _squares(small, marks)]
    near = [_closer(small, marks, found) for found in far]
    agreement = [float(np.mean([soft_iou(one, other) for other in near])) for one in near]
    sure = [expected_iou(a) * expected_iou(b) for a, b in zip(far, near, strict=True)]
    best = int(np.argmax(np.array(agreement) ** MAP.agreement_power * sure))
    last = _closer(small, marks, near[best])
    found = ThingMap(last, agreement[best], tuple(near))
    return _in_pieces(small, marks, found, _extent(last, marks))


@dataclass(frozen=True, eq=False, slots=True)
class Seen:
    """What is seen at one point of a picture: its mask (h, w), the IoU that it is likely to have
    with a thing that is there, and how looks at it agree, 0 … 1 both."""

    mask: BoolArray
    expected_iou: float
    agreement: float


def at_point(small: Image, point: tuple[float, float]) -> Seen:
    """What is at a point of a picture that is no longer than `picture_px`, in fewer looks.

    What is not marked is small beside the picture: it is looked for from near.
    """
    marks = Marks((point,), (), None)
    near_looks = 2  # count, 1..5: of the squares around a click, from the smallest
    squares = _squares(small, marks)[-near_looks:]
    far = [_looked(small, marks, square, None) for square in squares]
    near = [_closer(small, marks, found) for found in far]
    agreement = [float(np.mean([soft_iou(one, other) for other in near])) for one in near]
    sure = [expected_iou(a) * expected_iou(b) for a, b in zip(far, near, strict=True)]
    best = int(np.argmax(np.array(agreement) ** MAP.agreement_power * sure))
    labels = cv2.connectedComponents((near[best] > 0.5).astype(np.uint8))[1]
    own = labels[int(point[1]), int(point[0])]
    mask = (labels == own) if own else np.zeros(labels.shape, bool)
    return Seen(np.asarray(mask), expected_iou(near[best]), agreement[best])


def extent_of(chance: FloatArray, grounding: Grounding, shape: tuple[int, ...]) -> Box:
    """A person's box, or bounds of what is likely the thing, in pixels of the picture (H, W)."""
    if grounding.box is not None:
        return grounding.box
    factor = max(shape[:2]) / max(chance.shape)
    marks = Marks.of(grounding, 1 / factor)
    x0, y0, x1, y1 = (factor * v for v in _extent(chance, marks))
    wide = MAP.wider_ratio * max(x1 - x0, y1 - y0)
    return x0 - wide, y0 - wide, x1 + wide, y1 + wide


def seen_in(chance: FloatArray, view: View, shape: tuple[int, ...]) -> FloatArray:
    """(h, w) the map on a view of the picture (H, W)."""
    factor = max(chance.shape) / max(shape[:2])
    x0, y0, x1, y1 = (v * factor for v in view.part)
    rows, columns = view.lab.shape[:2]
    scale = np.array([[columns / (x1 - x0), 0, 0], [0, rows / (y1 - y0), 0]], np.float32)
    scale[:, 2] = -scale[0, 0] * x0, -scale[1, 1] * y0
    return np.asarray(cv2.warpAffine(chance, scale, (columns, rows)), np.float32)


def soft_iou(one: BoolArray | FloatArray, other: FloatArray) -> float:
    """IoU of two masks or maps (h, w), taken as sets to which pixels belong in part, 0 … 1."""
    return float(np.minimum(one, other).sum() / max(float(np.maximum(one, other).sum()), 1e-6))


def expected_iou(chance: FloatArray) -> float:
    """The IoU that the likelier half of a map has with the thing, if its chances are true."""
    return soft_iou(chance > 0.5, chance)


def shown(image: Image, marks: Marks, square: Square, before: FloatArray | None) -> FloatArray:
    """(7, S, S) what the network is shown of a square of a picture (H, W, 3)."""
    height, width = image.shape[:2]
    matrix, canvas, scale = (
        square.matrix,
        (MAP.canvas_px, MAP.canvas_px),
        MAP.canvas_px / square.side,
    )
    soft = cv2.GaussianBlur(image, (0, 0), 0.45 / scale) if scale < 0.8 else image
    colours = cv2.warpAffine(soft, matrix, canvas).astype(np.float32) / 255
    held = cv2.warpAffine(np.ones((height, width), np.float32), matrix, canvas) > 0.5
    out = np.zeros((MAP.canvas_layers, MAP.canvas_px, MAP.canvas_px), np.float32)
    out[:3] = (colours.transpose(2, 0, 1) - 0.5) * held
    out[3], out[4] = _spots(marks.inside, matrix), _spots(marks.outside, matrix)
    if marks.box is not None:
        corners = np.reshape(marks.box, (2, 2)) @ matrix[:, :2].T + matrix[:, 2]
        low = np.clip(corners[0], 0, MAP.canvas_px).astype(int)
        high = np.clip(np.ceil(corners[1]), 0, MAP.canvas_px).astype(int)
        out[5, low[1] : high[1], low[0] : high[0]] = 1
    if before is not None:
        out[6] = cv2.warpAffine(before, matrix, canvas) * held
    return out


def _looked(image: Image, marks: Marks, square: Square, before: FloatArray | None) -> FloatArray:
    """(H, W) what the network says of a square; nothing of what lies beyond it."""
    seen = shown(image, marks, square, before)
    (found,) = _network().run({"": seen[None]}, {"": (1, 1, MAP.canvas_px, MAP.canvas_px)})
    chance = 1.0 / (1.0 + np.exp(-np.clip(found[0, 0], -12.0, 12.0)))
    size, back = (image.shape[1], image.shape[0]), cv2.INTER_LINEAR | cv2.WARP_INVERSE_MAP
    return np.asarray(cv2.warpAffine(chance, square.matrix, size, flags=back), np.float32)


def _squares(image: Image, marks: Marks) -> list[Square]:
    """All of the picture, and smaller and smaller squares around the clicks and within it."""
    height, width = image.shape[:2]
    low, high = np.min(marks.inside, axis=0), np.max(marks.inside, axis=0)
    out = [Square(width / 2, height / 2, max(width, height))]
    for share in MAP.nearer_ratios:
        half = share * max(width, height) / 2
        if 2 * half > MAP.min_spread_factor * float((high - low).max()):
            x, y = (
                float(np.clip(at, min(half, length / 2), max(length - half, length / 2)))
                for at, length in zip((low + high) / 2, (width, height), strict=True)
            )
            out.append(Square(x, y, 2 * half))
    return out


def _closer(image: Image, marks: Marks, found: FloatArray) -> FloatArray:
    """What is seen when what was found is looked at again from close by."""
    return _looked(image, marks, Square.around(_extent(found, marks), MAP.found_ratio), found)


def _in_pieces(image: Image, marks: Marks, seen: ThingMap, box: Sequence[float]) -> ThingMap:
    """The map of a thing in a box (x0, y0, x1, y1), with its pieces looked at from closer by."""
    maps = [seen.chance]
    for share in MAP.piece_ratios:
        side = max(share * max(box[2] - box[0], box[3] - box[1]), MAP.min_square_px)
        across, down = (_middles(box[k], box[k + 2], side) for k in (0, 1))
        squares = [Square(x, y, side) for x in across for y in down]
        maps.append(_put_together(image, marks, squares, maps[-1]))
    chance = np.asarray(np.mean(maps, axis=0), np.float32)
    return ThingMap(chance, seen.agreement, (*seen.looks, maps[1]))


def _middles(low: float, high: float, side: float) -> list[float]:
    """Middles of squares of a side that cover a stretch, the outer ones a little beyond it."""
    inset = MAP.inset_ratio * min(side, high - low) / 2
    count = (
        math.ceil((high - low) / (MAP.max_apart_ratio * side))
        if high - low > MAP.inset_ratio * side
        else 1
    )
    return (
        [float(x) for x in np.linspace(low + inset, high - inset, count)]
        if count > 1
        else [(low + high) / 2]
    )


def _put_together(
    image: Image, marks: Marks, squares: Sequence[Square], before: FloatArray
) -> FloatArray:
    """(H, W) what squares show, each by its middle more than by its rim; `before` beside them."""
    total, weights = before * MAP.before_weight, np.full_like(before, MAP.before_weight)
    rows, columns = np.ogrid[: before.shape[0], : before.shape[1]]
    for square in squares:
        near = [
            np.clip(1 - 2 * np.abs(at - middle) / square.side, 0, 1)
            for at, middle in ((rows, square.y), (columns, square.x))
        ]
        weight = near[0] * near[1]
        total += weight * _looked(image, marks, square, before)
        weights += weight
    return np.where(weights < 20 * MAP.before_weight, before, total / weights).astype(np.float32)


def _extent(chance: FloatArray, marks: Marks) -> Box:
    """Bounds of what was found where clicks are, else of the largest that was found."""
    likely = (chance > 0.5).astype(np.uint8)
    count, labels, stats, _ = cv2.connectedComponentsWithStats(likely)
    rows, columns = labels.shape
    at = [(int(np.clip(y, 0, rows - 1)), int(np.clip(x, 0, columns - 1))) for x, y in marks.inside]
    if count == 1:
        (y, x), half = at[0], MAP.min_square_px / 2
        return (x - half, y - half, x + half, y + half)
    own = {int(labels[pixel]) for pixel in at} - {0}
    own = own or {1 + int(stats[1:, cv2.CC_STAT_AREA].argmax())}
    return bounds(np.isin(labels, list(own)))


def _spots(points: Sequence[Point], matrix: FloatArray) -> FloatArray:
    out = np.zeros((MAP.canvas_px, MAP.canvas_px), np.float32)
    for x, y in points:
        at = matrix @ np.array([x, y, 1.0])
        cv2.circle(out, (round(float(at[0])), round(float(at[1]))), MAP.mark_px, 1.0, -1)
    return out


@cache
def _network() -> Network:
    return Network((assets_dir() / "networks" / "thing_map.onnx").read_bytes())
