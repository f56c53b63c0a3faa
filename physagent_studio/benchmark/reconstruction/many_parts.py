"""Masks of many-coloured things of many parts on new pictures, and how well doubts about them hold.

The pictures are those of `benchmark.scenes` from seed 2000 on, which nothing was fitted to.
"""

from collections.abc import Iterable, Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from physagent_studio.arrays import FloatArray
from physagent_studio.benchmark.reconstruction.ledger import WAYS, plain_cuts
from physagent_studio.benchmark.rows import Row, at_least, at_most, shown
from physagent_studio.benchmark.scenes import Pictured, scene
from physagent_studio.reconstruction.masks.segmenter import EmbeddedSegmenter, choose
from physagent_studio.reconstruction.masks.sureness import sureness
from physagent_studio.reconstruction.photo.regions import iou
from physagent_studio.records.doubts import DOUBTED_BELOW, SURE_FROM

SEEDS = range(2000, 2060)
"""Pictures that are only measured on."""
POOR = 0.6
"""IoU below which a mask should be doubted."""
BINS = 5
"""Groups of equally many masks in which chances are held against what came."""


@dataclass(frozen=True, slots=True)
class Cut:
    """One thing cut out: how it was marked, the IoU of its mask, and how sure that mask was."""

    way: str
    overlap: float
    chance: float


def many_part_rows(seeds: Iterable[int] = SEEDS) -> list[Row]:
    """What one click and one box give, plain GrabCut beside, and what doubts are worth."""
    cuts: list[Cut] = []
    plain: list[float] = []
    for seed in seeds:
        drawn = scene(seed)
        plain += plain_cuts(drawn)
        for way in WAYS:
            cuts += _cut(drawn, way)
    rows = [shown("many parts: things", len(plain))]
    for way, middle, lower in (("click", 0.85, 0.70), ("box", 0.95, 0.90)):
        found = [cut.overlap for cut in cuts if cut.way == way]
        rows += [
            at_least(f"many parts, {way}: mask IoU, median", float(np.median(found)), middle),
            at_least(f"many parts, {way}: lower quarter", float(np.percentile(found, 25)), lower),
        ]
    rows += [
        shown("many parts, plain GrabCut in the box: median", float(np.median(plain))),
        shown("many parts, plain GrabCut: lower quarter", float(np.percentile(plain, 25))),
    ]
    return rows + doubt_rows(cuts)


def _cut(drawn: Pictured, way: str) -> Iterator[Cut]:
    said = [(s.name, s.click if way == "click" else s.box) for s in drawn.subjects]
    offers = EmbeddedSegmenter().segment(drawn.image, said)
    masks = choose(offers, said, drawn.image.shape[:2], drawn.image)
    chances = sureness(drawn.image, masks, offers, said)
    for subject in drawn.subjects:
        overlap = iou(masks[subject.name], subject.mask)
        yield Cut(way, overlap, chances.get(subject.name, 0.0))


def doubt_rows(cuts: Iterable[Cut]) -> list[Row]:
    """Whether chances come true, of masks however they were marked."""
    every = list(cuts)
    overlap = np.array([cut.overlap for cut in every])
    chance = np.array([cut.chance for cut in every])
    good, poor = overlap > SURE_FROM, overlap < POOR
    sure, doubted = chance >= SURE_FROM, chance < DOUBTED_BELOW
    return [
        at_most("doubt: calibration error", calibration_error(chance, good), 0.08),
        at_least("doubt: sure masks that are good", _share(good, sure), 0.92),
        at_least("doubt: poor masks that are doubted", _share(doubted, poor), 0.90),
        at_most("doubt: good masks that are doubted", _share(doubted, good), 0.15),
        at_least("doubt: good masks that are sure", _share(sure, good), 0.60),
    ]


def calibration_error(chance: FloatArray, good: NDArray[np.bool_]) -> float:
    """Mean difference of the chances (N,) and the share that is good, over equal groups."""
    groups = np.array_split(np.argsort(chance, kind="stable"), BINS)
    off = [abs(chance[k].mean() - good[k].mean()) * len(k) for k in groups if len(k)]
    return float(sum(off) / max(len(chance), 1))


def _share(of: NDArray[np.bool_], among: NDArray[np.bool_]) -> float:
    return float(of[among].mean()) if among.any() else 0.0
