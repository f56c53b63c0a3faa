"""How much a mask looks like a whole object: contrast at its outline, and agreement."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from physagent_studio.reconstruction.masks import (
    BoolArray,
    Pixel,
    border_share,
    iou,
    outline_length,
    solidity,
)

_SQUARE = np.ones((3, 3), np.uint8)


@dataclass(frozen=True, eq=False, slots=True)
class Draft:
    """A candidate before it is scored.

    method: short name. family: methods of one family fail together, so only agreement across
    families counts. window_share: share of the outline along an artificial window's sides.
    stability: IoU with the next scale.
    """

    mask: BoolArray
    method: str
    family: str
    window_share: float = 0.0
    stability: float = 0.55


def outline_contrast(lab: NDArray[np.float32], mask: BoolArray) -> tuple[float, float]:
    """Median and 20th percentile, along the outline, of the colour step across it."""
    solid = mask.astype(np.uint8)
    inner = mask & ~cv2.erode(solid, _SQUARE, iterations=3).astype(bool)
    core = cv2.erode(solid, _SQUARE).astype(bool)
    # A thin part has no core: its own pixels have to do.
    inner = np.where(cv2.boxFilter(core.astype(np.float32), -1, (5, 5)) > 0, inner & core, inner)
    outer = cv2.dilate(solid, _SQUARE, iterations=4).astype(bool)
    outer &= ~cv2.dilate(solid, _SQUARE).astype(bool)
    if np.count_nonzero(inner) < 8 or np.count_nonzero(outer) < 8:
        return 0.0, 0.0
    inside, some_inside = _local_mean(lab, inner)
    beyond, some_beyond = _local_mean(lab, outer)
    rim = mask & ~cv2.erode(solid, _SQUARE).astype(bool)
    rim[:2] = rim[-2:] = False
    rim[:, :2] = rim[:, -2:] = False
    rim &= some_inside & some_beyond
    if np.count_nonzero(rim) < 8:
        return 0.0, 0.0
    step = np.linalg.norm(inside - beyond, axis=2)[rim]
    return float(np.median(step)), float(np.percentile(step, 20))


def _local_mean(lab: NDArray[np.float32], region: BoolArray) -> tuple[NDArray, BoolArray]:
    weight = region.astype(np.float32)
    count = cv2.boxFilter(weight, -1, (9, 9), normalize=False)
    total = cv2.boxFilter(lab * weight[..., None], -1, (9, 9), normalize=False)
    return total / np.maximum(count, 1)[..., None], np.asarray(count > 0)


def score(lab: NDArray[np.float32], drafts: Sequence[Draft], inside: Sequence[Pixel]) -> list[float]:
    """A score of 0 … 1 for each draft of one object; `inside` are its clicks."""
    return [_score(lab, draft, drafts, inside) for draft in drafts]


def _score(
    lab: NDArray[np.float32], draft: Draft, drafts: Sequence[Draft], inside: Sequence[Pixel]
) -> float:
    mask = draft.mask
    rows, columns = mask.shape
    others = [iou(mask, other.mask) for other in drafts if other.family != draft.family]
    agreement = max(others, default=0.0)
    middle, weakest = outline_contrast(lab, mask)
    hits = [mask[int(min(rows - 1, y)), int(min(columns - 1, x))] for x, y in inside]
    covered = float(np.mean(hits)) if hits else 1.0
    area = np.count_nonzero(mask) / (rows * columns)
    contrast = 0.5 * np.tanh(middle / 25) + 0.5 * np.tanh(weakest / 10)
    consensus = 0.3 + 0.35 * draft.stability + 0.35 * agreement
    whole = max(0.05, 1 - 2 * border_share(mask)) * max(0.0, 1 - 3 * draft.window_share)
    compact = 0.4 + 0.6 * min(1.0, solidity(mask) / 0.85)
    sized = 1.0 if area < 0.4 else 0.4
    return float(contrast * consensus * whole * compact * sized * covered)


def window_share(mask: BoolArray, box: tuple[int, int, int, int]) -> float:
    """Share of the outline that runs along a window's sides that are not the picture's."""
    rows, columns = mask.shape
    x0, y0, x1, y1 = box
    touching = 0
    if y0 > 2:
        touching += np.count_nonzero(mask[y0 : y0 + 2, x0:x1].any(0))
    if y1 < rows - 2:
        touching += np.count_nonzero(mask[y1 - 2 : y1, x0:x1].any(0))
    if x0 > 2:
        touching += np.count_nonzero(mask[y0:y1, x0 : x0 + 2].any(1))
    if x1 < columns - 2:
        touching += np.count_nonzero(mask[y0:y1, x1 - 2 : x1].any(1))
    return float(touching) / max(outline_length(mask), 1.0)
