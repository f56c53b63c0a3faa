"""Blobs: connected parts of a small picture that have a colour asked for, or stand out."""

from collections.abc import Mapping
from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from physagent_studio.reconstruction.photo.regions import (
    BoolArray,
    FloatArray,
    border_share,
    bounds,
    grow,
    iou,
    without_pinholes,
)


@dataclass(frozen=True, eq=False, slots=True)
class Blob:
    """A part of the picture: mask (H, W), box (x0, y0, x1, y1), its share of the picture, its look.

    contrast, round, long: 0 … 1, its colour step to what is around it and its form.
    """

    mask: BoolArray
    box: tuple[int, int, int, int]
    area: float
    contrast: float
    round: float
    long: float


def blobs_of(lab: NDArray[np.float32], maps: Mapping[str, FloatArray]) -> list[Blob]:
    """Connected parts of one colour, or that stand out; overlapping ones once, best first."""
    masks: list[BoolArray] = []
    for found in maps.values():
        for level in (0.35, 0.7):
            masks += _parts(np.asarray(found > level))
    salient = _salience(lab)
    for level in (0.25, 0.4, 0.55, 0.7):
        masks += _parts(np.asarray(salient > level))
    made = sorted((_blob(lab, mask) for mask in masks), key=lambda blob: -blob.contrast)
    kept: list[Blob] = []
    max_blobs = 40  # count, 10..200: those after them stand out too little to be graded
    for blob in made:
        if all(iou(blob.mask, other.mask) < 0.6 for other in kept):
            kept.append(blob)
        if len(kept) == max_blobs:
            break
    return kept


def _parts(mask: BoolArray) -> list[BoolArray]:
    """Connected parts of a sensible size that are no frame around the picture."""
    kernel = np.ones((3, 3), np.uint8)
    opened = cv2.morphologyEx(mask.astype(np.uint8), cv2.MORPH_OPEN, kernel)
    count, labels, stats, _ = cv2.connectedComponentsWithStats(opened)
    out: list[BoolArray] = []
    for label in range(1, count):
        share = stats[label, cv2.CC_STAT_AREA] / mask.size
        if not 0.0006 < share < 0.3:
            continue
        part = without_pinholes(labels == label, 0.5)
        if border_share(part) < 0.3:
            out.append(part)
    return out


def _salience(lab: NDArray[np.float32]) -> FloatArray:
    """(H, W) 0 … 1: distance in colour from what the picture's rim and its rows show."""
    rows, columns = lab.shape[:2]
    rim = max(3, min(rows, columns) // 12)
    frame = np.ones((rows, columns), bool)
    frame[rim:-rim, rim:-rim] = False
    cv2.setRNGSeed(20)
    stop = (cv2.TERM_CRITERIA_EPS + cv2.TERM_CRITERIA_MAX_ITER, 20, 0.5)
    samples = lab[frame][:: max(1, int(frame.sum()) // 4000)]
    start = np.zeros((len(samples), 1), np.int32)
    _, labels, centres = cv2.kmeans(samples, 6, start, stop, 2, cv2.KMEANS_PP_CENTERS)
    share = np.bincount(labels.ravel(), minlength=6) / len(labels)
    far = np.full((rows, columns), np.inf, np.float32)
    for centre, weight in zip(centres, share, strict=True):
        if weight > 0.04:
            far = np.minimum(far, np.linalg.norm((lab - centre) * (0.7, 1.3, 1.3), axis=2))
    far = cv2.GaussianBlur(far.astype(np.float32), (0, 0), 1.5)
    return np.asarray(far / max(float(np.percentile(far, 99.5)), 12.0), np.float32)


def _blob(lab: NDArray[np.float32], mask: BoolArray) -> Blob:
    x0, y0, x1, y1 = bounds(mask)
    area = int(np.count_nonzero(mask))
    ring = grow(mask, max(2, round(0.15 * float(np.sqrt(area))))) & ~grow(mask, 1)
    step = np.linalg.norm(lab[mask].mean(0) - lab[ring].mean(0)) if ring.any() else 0.0
    width, height = x1 - x0, y1 - y0
    full = area / max(np.pi / 4 * width * height, 1.0)
    evenness = min(width, height) / max(width, height)
    roundness = max(0.0, 1 - 2.5 * abs(full - 1)) * evenness
    return Blob(
        mask,
        (x0, y0, x1, y1),
        area / mask.size,
        float(np.tanh(step / 35)),
        float(roundness),
        _length(mask),
    )


def _length(mask: BoolArray) -> float:
    """0 … 1: 0 up to two and a half times as long as wide, 1 from seven times."""
    _, size, _ = cv2.minAreaRect(cv2.findNonZero(mask.astype(np.uint8)))
    ratio = (max(size) + 1) / (min(size) + 1)
    return float(np.clip(np.log(ratio / 2.5) / np.log(7 / 2.5), 0, 1))
