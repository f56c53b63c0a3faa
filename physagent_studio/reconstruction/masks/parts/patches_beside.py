"""Patches beside a mask that might be parts of the thing: alone, or together before the ground."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import chain

import cv2
import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import find_objects

from physagent_studio.reconstruction.masks.parts.evidence import Patch, Surroundings
from physagent_studio.reconstruction.photo.regions import BoolArray
from physagent_studio.reconstruction.switches import at_work

IntArray = NDArray[np.int64]
LARGE = 0.6
"""Share of the mask's area from which a patch is ground."""
RARE = -5.0
"""Log share of its colours elsewhere below which a patch is unlike what is around."""


@dataclass(frozen=True, eq=False, slots=True)
class Parted:
    """A picture cut into N patches: the number of each pixel's patch (h, w), and where each is.

    places: (N, 4) left, top, width and height of the patch in pixels.
    """

    labels: NDArray[np.integer]
    places: NDArray[np.integer]

    @classmethod
    def of(cls, labels: IntArray) -> Parted:
        """The places looked up for patches (h, w) of which none is missing."""
        found = find_objects(labels + 1)
        places = [(x.start, y.start, x.stop - x.start, y.stop - y.start) for y, x in found]
        return cls(labels, np.array(places, np.int64).reshape(-1, 4))

    def window(self, number: int) -> tuple[slice, slice]:
        """Rows and columns of a patch."""
        x, y, width, height = (int(value) for value in self.places[number])
        return slice(y, y + height), slice(x, x + width)


def patches_beside(
    barred: BoolArray,
    here: Surroundings,
    levels: Sequence[Parted],
    sizes: tuple[float, float],
    about: BoolArray | None = None,
) -> Iterator[Patch]:
    """Different patches that touch the mask and are neither too small nor too large, nor barred.

    sizes: least and most pixels. barred: (h, w) what may not be in any. levels: patches of growing
    size. about: (h, w) where those are that are wanted; None for everywhere.
    """
    least, most = sizes
    free = ~here.mask
    spots, close = np.flatnonzero(free), np.flatnonzero(here.near & free)
    known: set[tuple[int, int, int]] = set()
    together = _islands(here, levels) if at_work("islands") else ()
    for parted in chain(levels, together):
        labels, count = parted.labels, len(parted.places)
        flat = labels.ravel()
        area = np.bincount(flat[spots], minlength=count)
        left_out = _at_rim(labels, free, count)
        left_out[labels[barred]] = True
        touching = np.bincount(flat[close], minlength=count)
        wanted = (touching > 5) & (area >= max(14, least)) & (area <= most)
        if about is not None:
            wanted &= np.bincount(labels[about & free], minlength=count) > 0
        for number in np.flatnonzero(wanted & ~left_out):
            place = parted.window(int(number))
            piece = (labels[place] == number) & free[place]
            rows, columns = np.nonzero(piece)
            rows, columns = rows + place[0].start, columns + place[1].start
            same = (len(rows), int(rows[0]), int(columns[0]))
            if same not in known:
                known.add(same)
                yield Patch.at(rows, columns, labels.shape)


def _at_rim(labels: NDArray[np.integer], free: BoolArray, count: int) -> BoolArray:
    """(N,) which patches reach the rim of the picture."""
    out = np.zeros(count, bool)
    for line in (np.s_[0], np.s_[-1], np.s_[:, 0], np.s_[:, -1]):
        out[labels[line][free[line]]] = True
    return out


def ground_of(labels: NDArray[np.integer], mask: BoolArray) -> BoolArray:
    """(h, w) the patches that reach the rim or are large, for the mask."""
    count = int(labels.max()) + 1
    area = np.bincount(labels[~mask], minlength=count)
    large = area > LARGE * np.count_nonzero(mask)
    return (large | _at_rim(labels, np.ones_like(mask), count))[labels] & ~mask


def _islands(here: Surroundings, levels: Sequence[Parted]) -> Iterator[Parted]:
    """What stands out from the ground together, numbered; the ground is number 0, at a rim.

    At every level but the finest; then without the patches whose colours are those around.
    """
    fine, count = levels[0].labels, len(levels[0].places)
    area = np.bincount(fine.ravel(), minlength=count)
    common = np.log(here.others / max(float(here.others.sum()), 1.0) + 1e-4)[here.bin_of]
    own = np.log(here.own + 1e-4)[here.bin_of]
    common, own = (np.bincount(fine.ravel(), v.ravel(), count) / area for v in (common, own))
    plain = ((common < RARE) | (own > common))[fine]
    for level in levels[1:]:
        island = ~ground_of(level.labels, here.mask) & ~here.mask
        for some in (island, island & plain):
            _, numbers, places, _ = cv2.connectedComponentsWithStats(
                some.view(np.uint8), connectivity=4
            )
            yield Parted(np.asarray(numbers, np.int32), np.asarray(places, np.int32)[:, :4])
