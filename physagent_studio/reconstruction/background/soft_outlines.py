"""How far the colours of a thing reach beyond its mask.

Out of focus, in fur, or behind a soft lens, an outline fades over more pixels than a mask is
widened by: what is left of it is a ring on the plate. Across the outline the photo goes from the
colour just inside to the colour well outside; where it has arrived there, the thing has faded out.
"""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from physagent_studio.reconstruction.photo.regions import BoolArray, bounds
from physagent_studio.records.case import Image

FloatArray = NDArray[np.float32]


@dataclass(frozen=True, slots=True)
class SoftSettings:
    """Where an outline has faded out."""

    reach_factor: float = 3.0  # 1..5: farthest, over the usual width of an outline
    inside_px: float = 3.0  # 1..6: behind the outline, where the thing has its own colour
    smooth_px: float = 0.7  # 0..2: sigma, against noise
    faded_share: float = 0.06  # 0.02..0.2: of the thing's colour in the median, where it has faded
    min_contrast_lab: float = 10.0  # 4..30: between inside and outside; less tells nothing
    max_places: int = 20000  # count, 2000..100000: pixels beside the outline that are looked at


SOFT = SoftSettings()


def soft_width(photo: Image, mask: BoolArray, usual: int) -> int:
    """Pixels by which a thing's colours reach beyond its mask (H, W): `usual` or more of them.

    photo: (H, W, 3). Never more than `reach_factor` times as many.
    """
    reach = round(SOFT.reach_factor * usual)
    if not mask.any():
        return usual
    x0, y0, x1, y1 = bounds(mask)
    crop = np.s_[max(y0 - 2 * reach, 0) : y1 + 2 * reach, max(x0 - 2 * reach, 0) : x1 + 2 * reach]
    beside = (~mask[crop]).astype(np.uint8)
    off = np.asarray(cv2.distanceTransform(beside, cv2.DIST_L2, cv2.DIST_MASK_5), np.float32)
    rows, columns = np.nonzero((off > 0) & (off <= reach))
    each = max(1, len(rows) // SOFT.max_places)
    rows, columns = rows[::each], columns[::each]
    away, share = off[rows, columns], _shares(photo[crop], off, rows, columns, float(reach))
    width = usual
    while width < reach:
        ring = share[(away > width - 0.5) & (away <= width + 0.5) & np.isfinite(share)]
        if not len(ring) or np.median(ring) <= SOFT.faded_share:
            break
        width += 1
    return width


def _shares(
    photo: Image, off: FloatArray, rows: NDArray[np.int64], columns: NDArray[np.int64], reach: float
) -> FloatArray:
    """(N,) how much of a thing's colour is seen at pixels beside it; NaN where it hardly differs.

    off: (H, W) pixels from the thing.
    """
    lab = cv2.cvtColor(photo.astype(np.float32) / 255, cv2.COLOR_RGB2LAB)
    lab = np.asarray(cv2.GaussianBlur(lab, (0, 0), SOFT.smooth_px), np.float32)
    even = cv2.GaussianBlur(off, (0, 0), 1.5)
    out = np.stack([cv2.Sobel(even, cv2.CV_32F, *way)[rows, columns] for way in ((1, 0), (0, 1))])
    out /= np.maximum(np.linalg.norm(out, axis=0), 1e-6)
    away = off[rows, columns]

    def at(steps: FloatArray) -> FloatArray:
        x = np.clip(np.round(columns + out[0] * steps), 0, lab.shape[1] - 1).astype(int)
        y = np.clip(np.round(rows + out[1] * steps), 0, lab.shape[0] - 1).astype(int)
        return lab[y, x]

    outside = at(reach + SOFT.inside_px - away)
    differs = at(-away - SOFT.inside_px) - outside
    length = (differs**2).sum(axis=1)
    share = ((lab[rows, columns] - outside) * differs).sum(axis=1) / np.maximum(length, 1e-6)
    return np.where(length > SOFT.min_contrast_lab**2, share, np.nan).astype(np.float32)
