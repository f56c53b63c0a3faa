"""Samples for the network: a square of a picture, what a person marked there, and the mask."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import cv2
import numpy as np
from numpy.typing import NDArray

from physagent_studio.reconstruction.masks.thing_map import MAP, Marks, Square, shown

Floats = NDArray[np.float32]
Bools = NDArray[np.bool_]
LEAST = 220
"""Pixels of a mask from which a thing is learned."""
CLICKED, BOXED = 0.6, 0.9
"""Shares of samples with clicks alone, and of those and samples with a box alone."""
NEAR_CLICK, CLOSE = 0.3, 0.72
"""Shares of looks for a click: around it, and of those and looks around what was found before."""
BESIDE = 0.25
"""Share of samples in which another thing is pasted beside or before the one that is asked for."""


@dataclass(frozen=True, eq=False, slots=True)
class Drawn:
    """A picture (H, W, 3), a thing's mask (H, W) in it, whose and of which part each pixel is."""

    image: NDArray[np.uint8]
    mask: Bools
    thing: NDArray[np.int8]
    part: NDArray[np.int16]


class Pictures:
    """Pictures in memory, a file of fifty at a time, and the things in them by their weight."""

    def __init__(self, folder: Path) -> None:
        self.folder, self.files, self.loaded = folder, set[Path](), list[tuple[NDArray, ...]]()
        self.things: list[tuple[int, int, int, float]] = []
        self.scan()

    def scan(self) -> None:
        """Takes in the files that are new; what a picture is of counts twice as much as others."""
        for file in sorted(set(self.folder.glob("[0-9]*.npz")) - self.files):
            self.files.add(file)
            held = np.load(file)
            self.loaded.append((held["image"], held["thing"], held["part"]))
            for number, thing in enumerate(held["thing"]):
                labels, sizes = np.unique(thing, return_counts=True)
                for label, size in zip(labels, sizes, strict=True):
                    if label >= 0 and size >= LEAST:
                        weight = 2.0 if label < held["asked"][number] else 1.0
                        self.things.append((len(self.loaded) - 1, number, int(label), weight))
        self.until = np.cumsum([weight for *_, weight in self.things])

    def drawn(self, rng: np.random.Generator) -> Drawn:
        """A picture and one thing in it."""
        k = int(np.searchsorted(self.until, rng.random() * self.until[-1]))
        file, number, label, _ = self.things[k]
        image, thing, part = (one[number] for one in self.loaded[file])
        return Drawn(image, thing == label, thing, part)


@dataclass(frozen=True, eq=False, slots=True)
class Sample:
    """seen: (7, S, S) what the network is shown. truth, inside: (S, S) mask, and the picture."""

    seen: Floats
    truth: Floats
    inside: Floats


def sample(pictures: Pictures, rng: np.random.Generator) -> Sample:
    """One thing, marked and looked at as a person and the program might."""
    while (found := _sample(pictures, rng)) is None:
        pass
    return found


def _sample(pictures: Pictures, rng: np.random.Generator) -> Sample | None:
    drawn = pictures.drawn(rng)
    if rng.random() < BESIDE:
        drawn = _pasted(rng, drawn, pictures.drawn(rng))
    mask = drawn.mask
    marks, before = _marked(rng, mask, drawn.thing, drawn.part), None
    look = 1.0 if marks.box else rng.random()
    if look < NEAR_CLICK:
        square = _near(rng, mask, marks.inside[0])
    else:
        close = marks.box is not None or look < CLOSE
        square = _around(rng, mask) if close else _wide(rng, mask)
        if close and rng.random() < (0.3 if marks.box else 0.85):
            before = _degraded(rng, mask)
    return _turned(rng, square, drawn, marks, before)


def _pasted(rng: np.random.Generator, drawn: Drawn, other: Drawn) -> Drawn:
    """The picture with a thing of another one in it, unless that covers too much of this one."""
    moved = np.array([[1, 0, rng.integers(-60, 61)], [0, 1, rng.integers(-60, 61)]], np.float32)
    size = (drawn.mask.shape[1], drawn.mask.shape[0])
    over = cv2.warpAffine(other.mask.astype(np.float32), moved, size)
    left = drawn.mask & (over < 0.5)
    if left.sum() < max(LEAST, 0.6 * drawn.mask.sum()):
        return drawn
    share = cv2.GaussianBlur(over, (0, 0), 0.7)[..., None]
    joined = drawn.image * (1 - share) + cv2.warpAffine(other.image, moved, size) * share
    part = np.where(over > 0.5, 999, drawn.part).astype(np.int16)
    return replace(drawn, image=joined.astype(np.uint8), mask=left, part=part)


def _marked(
    rng: np.random.Generator, mask: Bools, thing: NDArray[np.int8], part: NDArray[np.int16]
) -> Marks:
    """Clicks, a box as a hand draws it, or both."""
    kind, rows, columns = rng.random(), *mask.nonzero()
    inside: list[tuple[float, float]] = []
    outside: list[tuple[float, float]] = []
    if kind < CLICKED or kind > BOXED:
        count = 1 if rng.random() < 0.75 else int(rng.integers(2, 4))
        inside = [_click(rng, mask, part) for _ in range(count)]
        if rng.random() < 0.15:
            near = cv2.dilate(mask.astype(np.uint8), np.ones((25, 25), np.uint8)) > 0
            y, x = (near & ~mask).nonzero()
            if len(x):
                k = int(rng.integers(len(x)))
                outside.append((float(x[k]), float(y[k])))
        if rng.random() < 0.4:
            outside += _on_others(rng, mask, thing, part)
    if kind < CLICKED:
        return Marks(tuple(inside), tuple(outside), None)
    low, high = (columns.min(), rows.min()), (columns.max() + 1, rows.max() + 1)
    return Marks(tuple(inside), tuple(outside), _box(rng, np.array([*low, *high], float)))


def _on_others(
    rng: np.random.Generator, mask: Bools, thing: NDArray[np.int8], part: NDArray[np.int16]
) -> list[tuple[float, float]]:
    """Clicks on up to three other things, which lie outside of this one."""
    labels = np.unique(thing[(thing >= 0) & ~mask])
    chosen = rng.permutation(labels)[: int(rng.integers(1, 4))]
    masks = [(thing == label) & ~mask for label in chosen]
    return [_click(rng, other, part) for other in masks if other.sum() > 60]


def _box(rng: np.random.Generator, bounds: NDArray[np.float64]) -> tuple[float, ...]:
    """A box a little wide, at some sides a little narrow."""
    longer = max(bounds[2:] - bounds[:2])
    pad = np.abs(rng.normal(0, 0.045, 4)) * longer * np.where(rng.random(4) < 0.12, -0.5, 1)
    pad += rng.uniform(0, 1.5, 4)
    return tuple(float(v) for v in (*(bounds[:2] - pad[:2]), *(bounds[2:] + pad[2:])))


def _click(rng: np.random.Generator, mask: Bools, part: NDArray[np.int16]) -> tuple[float, float]:
    """Most near the middle and well within the part that is nearest to it."""
    rows, columns = mask.nonzero()
    y, x = np.array([rows.mean(), columns.mean()]) + rng.normal(0, 0.12 * math.sqrt(len(rows)), 2)
    near = int(np.hypot(rows - y, columns - x).argmin())
    if rng.random() >= 0.65:
        near = int(rng.integers(len(rows)))
    if rng.random() < 0.8:
        own = mask & (part == part[rows[near], columns[near]])
        depth = cv2.distanceTransform(np.pad(own, 1).astype(np.uint8), cv2.DIST_L2, 3)[1:-1, 1:-1]
        within = (depth >= min(3.0, 0.6 * float(depth.max()))).nonzero()
        k = int(np.hypot(within[0] - rows[near], within[1] - columns[near]).argmin())
        return float(within[1][k]), float(within[0][k])
    return float(columns[near]), float(rows[near])


def _around(rng: np.random.Generator, mask: Bools) -> Square:
    rows, columns = mask.nonzero()
    side = max(np.ptp(columns), np.ptp(rows)) * math.exp(rng.uniform(math.log(1.15), math.log(2.4)))
    middle = np.array([np.mean((columns.min(), columns.max())), np.mean((rows.min(), rows.max()))])
    x, y = middle + rng.normal(0, 0.06, 2) * side
    return Square(float(x), float(y), float(side))


def _near(rng: np.random.Generator, mask: Bools, click: tuple[float, float]) -> Square:
    """A square around a click that holds all of the thing."""
    rows, columns = mask.nonzero()
    size = max(np.ptp(columns), np.ptp(rows))
    share = math.exp(rng.uniform(math.log(0.22), math.log(0.8)))
    side = max(max(mask.shape) * share, 1.1 * size)
    middle = []
    wished = np.array(click) + rng.normal(0, 0.06, 2) * side
    for at, places in zip(wished, (columns, rows), strict=True):
        low, high = places.max() + 1 - side / 2 + 3, places.min() + side / 2 - 3
        middle.append(float(np.clip(at, low, high)) if low < high else float(places.mean()))
    return Square(middle[0], middle[1], float(side))


def _wide(rng: np.random.Generator, mask: Bools) -> Square:
    """Most of the picture, with all of the thing in it."""
    rows, columns = mask.nonzero()
    height, width = mask.shape
    side = max(width, height) * math.exp(rng.uniform(-0.5, 0.12))
    middle = []
    for places, length in ((columns, width), (rows, height)):
        low, high = places.max() + 1 - side / 2 + 4, places.min() + side / 2 - 4
        at = length / 2 + rng.normal(0, 0.1) * length
        middle.append(float(np.clip(at, low, high)) if low < high else float(places.mean()))
    return Square(middle[0], middle[1], float(side))


def _degraded(rng: np.random.Generator, mask: Bools) -> Floats:
    """A mask that a first look may have given: too wide or narrow, with bits lost and added."""
    size = max(3, int(math.sqrt(mask.sum())))
    reach = 1 + 2 * int(rng.integers(1, max(2, size // 12) + 1))
    kernel = cv2.getStructuringElement(cv2.MORPH_ELLIPSE, (reach, reach))
    out = mask.astype(np.float32)
    out = cv2.dilate(out, kernel) if rng.random() < 0.5 else cv2.erode(out, kernel)
    rows, columns = cv2.dilate(mask.astype(np.uint8), np.ones((5, 5), np.uint8)).nonzero()
    for _ in range(int(rng.integers(0, 4))):
        k, axes = int(rng.integers(len(rows))), np.maximum(2, size * rng.uniform(0.08, 0.5, 2))
        at, sides = (int(columns[k]), int(rows[k])), (int(axes[0]), int(axes[1]))
        add = float(rng.random() < 0.5)
        cv2.ellipse(out, at, sides, float(rng.uniform(0, 180)), 0, 360, add, -1)
    coarse = max(2, int(size * rng.uniform(0.05, 0.2)))
    small = (max(4, mask.shape[1] // coarse), max(4, mask.shape[0] // coarse))
    soft = cv2.resize(
        cv2.GaussianBlur(out, (0, 0), coarse / 2), small, interpolation=cv2.INTER_AREA
    )
    out = cv2.resize(soft, mask.shape[::-1], interpolation=cv2.INTER_LINEAR)
    return np.clip((out - 0.5) * rng.uniform(1, 4) + 0.5 + rng.normal(0, 0.1), 0, 1)


def _turned(
    rng: np.random.Generator, square: Square, drawn: Drawn, marks: Marks, before: Floats | None
) -> Sample | None:
    """The square mirrored or not, turned a little, in other colours and light; None where nothing
    of the thing is left in the picture."""
    angle, mirror = math.radians(rng.normal(0, 6)), -1.0 if rng.random() < 0.5 else 1.0
    cos, sin = math.cos(angle), math.sin(angle)
    turn = np.array([[mirror * cos, -mirror * sin], [sin, cos]])
    middle = np.array([square.x, square.y])
    matrix = np.hstack([turn, (middle - turn @ middle)[:, None]]).astype(np.float32)
    mask = drawn.mask
    size = (mask.shape[1], mask.shape[0])
    coloured = (_photometric(rng, drawn.image) * 255).astype(np.uint8)
    turned = cv2.warpAffine(coloured, matrix, size)
    held = cv2.warpAffine(np.ones(mask.shape, np.float32), matrix, size)
    cut = cv2.warpAffine(mask.astype(np.float32), matrix, size)
    was = None if before is None else cv2.warpAffine(before.astype(np.float32), matrix, size)
    rows, columns = (cut > 0.4).nonzero()
    if not len(rows):
        return None
    box = marks.box
    if box is not None:
        bounds = (columns.min(), rows.min(), columns.max() + 1, rows.max() + 1)
        box = _box(rng, np.array(bounds, float))
    moved = Marks(_moved(matrix, marks.inside), _moved(matrix, marks.outside), box)
    seen = shown(turned, moved, square, was)
    to = square.matrix
    truth = cv2.warpAffine(cut, to, (MAP.canvas_px, MAP.canvas_px))
    inside = cv2.warpAffine(held, to, (MAP.canvas_px, MAP.canvas_px))
    return Sample(seen, truth, inside)


def _moved(
    matrix: Floats, points: Sequence[tuple[float, float]]
) -> tuple[tuple[float, float], ...]:
    places = [matrix @ np.array([x, y, 1.0]) for x, y in points]
    return tuple((float(x), float(y)) for x, y in places)


def _photometric(rng: np.random.Generator, image: NDArray[np.uint8]) -> Floats:
    """Other light, colours turned about grey, so that none belongs to a kind of thing; noise."""
    out = np.clip(image.astype(np.float32) / 255, 1e-3, 1) ** np.exp(rng.normal(0, 0.25))
    if rng.random() < 0.6:
        turn, _ = cv2.Rodrigues(np.full(3, rng.uniform(0, 2 * np.pi) / np.sqrt(3)))
        out = out @ turn.T.astype(np.float32)
    grey = out.mean(2, keepdims=True)
    out = grey + (out - grey) * rng.uniform(0.2, 1.3)
    out = (out - 0.5) * rng.uniform(0.7, 1.25) + 0.5 + rng.normal(0, 0.06, 3)
    if rng.random() < 0.3:
        out = cv2.GaussianBlur(out, (0, 0), rng.uniform(0.3, 1.2))
    if rng.random() < 0.5:
        out = out + rng.normal(0, rng.uniform(0, 0.05), out.shape)
    return np.clip(out, 0, 1).astype(np.float32)
