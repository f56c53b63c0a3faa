"""Patches beside a mask that might be parts of the thing: alone, or together before the ground."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import cv2
import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import find_objects

from physagent_studio.reconstruction.masks import BoolArray
from physagent_studio.reconstruction.segmentation_evidence import Patch, Surroundings

IntArray = NDArray[np.int64]
LARGE = 0.6
"""Share of the mask's area from which a patch is ground."""
RARE = -5.0
"""Log share of its colours elsewhere below which a patch is unlike what is around."""


def patches_beside(
    barred: BoolArray, here: Surroundings, levels: Sequence[IntArray], least: float, most: float
) -> Iterator[Patch]:
    """Different patches that touch the mask and are neither too small nor too large, nor barred.

    least, most: pixels. barred: (h, w) what may not be in any. levels: patches of growing size.
    """
    free = ~here.mask
    known: set[tuple[int, int, int]] = set()
    for labels in [*levels, *_islands(here, levels)]:
        count = int(labels.max()) + 1
        area = np.bincount(labels[free], minlength=count)
        left_out = _at_rim(labels, free, count)
        left_out[labels[barred]] = True
        touching = np.bincount(labels[here.near & free], minlength=count)
        wanted = (touching > 5) & (area >= max(14, least)) & (area <= most)
        places = find_objects(labels + 1)
        for number in np.flatnonzero(wanted & ~left_out):
            place = places[int(number)]
            piece = (labels[place] == number) & free[place]
            rows, columns = np.nonzero(piece)
            rows, columns = rows + place[0].start, columns + place[1].start
            same = (len(rows), int(rows[0]), int(columns[0]))
            if same not in known:
                known.add(same)
                yield Patch.at(rows, columns, labels.shape)


def _at_rim(labels: IntArray, free: BoolArray, count: int) -> BoolArray:
    """(N,) which patches reach the rim of the picture."""
    out = np.zeros(count, bool)
    for line in (np.s_[0], np.s_[-1], np.s_[:, 0], np.s_[:, -1]):
        out[labels[line][free[line]]] = True
    return out


def ground_of(labels: IntArray, mask: BoolArray) -> BoolArray:
    """(h, w) the patches that reach the rim or are large, for the mask."""
    count = int(labels.max()) + 1
    area = np.bincount(labels[~mask], minlength=count)
    large = area > LARGE * np.count_nonzero(mask)
    return (large | _at_rim(labels, np.ones_like(mask), count))[labels] & ~mask


def _islands(here: Surroundings, levels: Sequence[IntArray]) -> Iterator[IntArray]:
    """(h, w) numbers of what stands out from the ground together; that of the ground is at a rim.

    At every level but the finest; then without the patches whose colours are those around.
    """
    fine = levels[0]
    count = int(fine.max()) + 1
    area = np.bincount(fine.ravel(), minlength=count)
    common = np.log(here.others / max(float(here.others.sum()), 1.0) + 1e-4)[here.bin_of]
    own = np.log(here.own + 1e-4)[here.bin_of]
    common, own = (np.bincount(fine.ravel(), v.ravel(), count) / area for v in (common, own))
    plain = ((common < RARE) | (own > common))[fine]
    for labels in levels[1:]:
        island = ~ground_of(labels, here.mask) & ~here.mask
        for some in (island, island & plain):
            _, numbers = cv2.connectedComponents(some.astype(np.uint8), connectivity=4)
            yield np.where(some, numbers, 0).astype(np.int64)
