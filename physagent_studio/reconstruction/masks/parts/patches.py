"""Patches: a picture cut along its edges into pieces of one colour, and these put together again.

The finest patches are the basins of a watershed (Meyer 1992), one for each place where the colour
stands still. From them larger ones are made step by step: of all neighbours, the two that are most
alike become one, until all that are left differ by more than is asked for. Their outlines follow
the edges of the picture closely, whatever a thing's form and colours are.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from physagent_studio.reconstruction.photo.statistics import lengths

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int64]
FAINT = 2.5
"""Step of colour over two pixels (OpenCV's Lab, 0 … 255) below which there is no edge."""
TINT = np.array([0.7, 1.2, 1.2])
"""How much lightness and the two tints count in what makes patches unlike."""
SMALL = 25.0
"""Pixels below which a patch is joined the sooner."""
_SQUARE = np.ones((3, 3), np.uint8)


def steps_of(lab: NDArray[np.float32]) -> NDArray[np.float32]:
    """(H, W) step of colour over two pixels; lab (H, W, 3)."""
    soft = cv2.GaussianBlur(lab, (0, 0), 0.8)
    across = cv2.Sobel(soft, cv2.CV_32F, 1, 0, ksize=3) / 8
    down = cv2.Sobel(soft, cv2.CV_32F, 0, 1, ksize=3) / 8
    return (2 * np.sqrt((across**2 + down**2).sum(2))).astype(np.float32)


def patches_of(lab: NDArray[np.float32], steps: NDArray[np.float32]) -> IntArray:
    """(H, W) number of the finest patch that each pixel belongs to."""
    height = np.clip(np.log(np.maximum(steps, FAINT) / FAINT) * 45, 0, 255).astype(np.uint8)
    height = height // 6 * 6
    still = (height == cv2.erode(height, _SQUARE)).astype(np.uint8)
    _, seeds = cv2.connectedComponents(still, connectivity=8)
    colours = np.clip(lab, 0, 255).astype(np.uint8)
    flooded = cv2.watershed(colours, np.ascontiguousarray(seeds, np.int32))
    return renumbered(_without_lines(np.asarray(flooded, np.int64), lab))


def renumbered(labels: IntArray) -> IntArray:
    """The labels with no number left out."""
    low = int(labels.min())
    used = np.bincount((labels - low).ravel()) > 0
    return (np.cumsum(used) - 1)[labels - low]


def _without_lines(labels: IntArray, lab: NDArray[np.float32]) -> IntArray:
    """The pixels of the lines between basins given to the neighbour most like them."""
    out = labels.copy()
    for _ in range(3):
        rows, columns = np.nonzero(out <= 0)
        if not len(rows):
            break
        known = np.pad(out, 1, constant_values=-1)
        colours = np.pad(lab, ((1, 1), (1, 1), (0, 0)), mode="edge")
        least = np.full(len(rows), np.inf)
        chosen = out[rows, columns]
        for dy, dx in ((0, 1), (1, 0), (1, 2), (2, 1), (0, 0), (0, 2), (2, 0), (2, 2)):
            other = known[rows + dy, columns + dx]
            unlike = lengths(colours[rows + dy, columns + dx] - lab[rows, columns])
            better = (other > 0) & (unlike < least)
            least[better], chosen[better] = unlike[better], other[better]
        out[rows, columns] = chosen
    return out


@dataclass(frozen=True, eq=False, slots=True)
class _Graph:
    """N patches and where they meet: areas (N,), colour sums (N, 3), pairs (E,) and their edges.

    first, second: (E,) the patches of each pair. step: (E,) sum of the steps along their border.
    length: (E,) pixels of it.
    """

    area: FloatArray
    colour: FloatArray
    first: IntArray
    second: IntArray
    step: FloatArray
    length: FloatArray

    @classmethod
    def of(cls, labels: IntArray, lab: NDArray[np.float32], steps: NDArray[np.float32]) -> _Graph:
        count = int(labels.max()) + 1
        flat = labels.ravel()
        area = np.bincount(flat, minlength=count).astype(float)
        sums = [_sums(flat, lab[..., k].ravel(), count) for k in range(3)]
        one = np.concatenate([labels[:, :-1].ravel(), labels[:-1].ravel()])
        other = np.concatenate([labels[:, 1:].ravel(), labels[1:].ravel()])
        step = np.concatenate(
            [
                np.maximum(steps[:, :-1], steps[:, 1:]).ravel(),
                np.maximum(steps[:-1], steps[1:]).ravel(),
            ]
        )
        apart = one != other
        graph = cls(
            area, np.stack(sums, 1), one[apart], other[apart], step[apart], np.ones(apart.sum())
        )
        return graph.summed(np.arange(count), count)

    def summed(self, number: IntArray, count: int) -> _Graph:
        """The graph after every patch has got a new number, which several may share."""
        area = _sums(number, self.area, count)
        colour = np.stack([_sums(number, self.colour[:, k], count) for k in range(3)], 1)
        a, b = number[self.first], number[self.second]
        apart = a != b
        key = (np.minimum(a, b) * count + np.maximum(a, b))[apart]
        pairs, index = np.unique(key, return_inverse=True)
        step = _sums(index, self.step[apart], len(pairs))
        length = _sums(index, self.length[apart], len(pairs))
        return _Graph(area, colour, pairs // count, pairs % count, step, length)

    def unlike(self) -> FloatArray:
        """(E,) how unlike the two patches of each pair are; less if one of them is small."""
        mean = self.colour / self.area[:, None]
        far = lengths((mean[self.first] - mean[self.second]) * TINT)
        small = np.minimum(self.area[self.first], self.area[self.second])
        weight = np.minimum(1.0, 0.5 * np.sqrt(small / SMALL) + 0.25)
        return 0.5 * (self.step / self.length + far) * weight


def _sums(number: IntArray, values: NDArray[np.floating], count: int) -> FloatArray:
    return np.bincount(number, values, count).astype(np.float64)


def joined(
    labels: IntArray,
    lab: NDArray[np.float32],
    steps: NDArray[np.float32],
    levels: Sequence[float],
) -> list[IntArray]:
    """The patches (H, W) that are left where all that are less unlike than a level are joined."""
    graph = _Graph.of(labels, lab, steps)
    number = np.arange(len(graph.area))
    out: list[IntArray] = []
    for level in levels:
        while True:
            unlike = graph.unlike()
            nearest = np.full(len(graph.area), np.inf)
            np.minimum.at(nearest, graph.first, unlike)
            np.minimum.at(nearest, graph.second, unlike)
            both = (unlike <= nearest[graph.first]) & (unlike <= nearest[graph.second])
            both &= unlike < level
            if not both.any():
                break
            count, group = _groups(graph.first[both], graph.second[both], len(graph.area))
            number, graph = group[number], graph.summed(group, count)
        out.append(number[labels])
    return out


def _groups(one: IntArray, other: IntArray, count: int) -> tuple[int, IntArray]:
    """How many groups pairs make of so many patches, and the number of each patch's group."""
    group = np.arange(count)
    group[np.maximum(one, other)] = np.minimum(one, other)
    while True:
        further = group[group]
        if np.array_equal(further, group):
            break
        group = further
    kept = group == np.arange(count)
    return int(kept.sum()), (np.cumsum(kept) - 1)[group]
