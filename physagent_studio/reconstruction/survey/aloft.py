"""Things seen against what is behind the ground: where no ground is seen, nothing stands on it."""

from __future__ import annotations

from collections.abc import Mapping

import cv2
import numpy as np

from physagent_studio.reconstruction.photo.line_segments import level_transitions
from physagent_studio.reconstruction.photo.regions import BoolArray
from physagent_studio.reconstruction.supports.stances import Stance
from physagent_studio.records.case import Image


def before_no_ground(
    image: Image, stances: Mapping[str, Stance], covered: BoolArray
) -> frozenset[str]:
    """Things over another one whose surroundings at the foot are what is behind the ground.

    covered: (H, W) pixels of objects. The end of the ground is a line across the picture between
    the feet of the two, with other colours above than below; a stripe has the same on both sides.
    """
    pairs = [(s, stances[s.over]) for s in stances.values() if s.over and s.over in stances]
    if not pairs:
        return frozenset()
    # 0..0.1: over the picture's height: feet nearer to that end are on the ground
    margin_ratio = 0.02
    step = margin_ratio * image.shape[0]
    # 0.4..1: of the picture, along which the far end of the ground has to show
    min_width_share = 0.7
    lines = [y for y, strength in level_transitions(image) if strength > min_width_share]
    lab = cv2.cvtColor(image.astype(np.float32) / 255, cv2.COLOR_RGB2LAB)
    found = set()
    min_step_lab = 5.0  # 2..20: between the ground and what is behind it
    for upper, lower in pairs:
        foot = upper.foot[1] + step
        for line in (y for y in lines if foot < y < lower.foot[1]):
            bands = ((line - 4 * step, line - step / 2), (line + step / 2, line + 3 * step))
            behind, ground = (_colour(lab, covered, upper, *band) for band in bands)
            around = _colour(lab, covered, upper, upper.foot[1] - step, foot)
            if behind is None or ground is None or around is None:
                continue
            apart = float(np.linalg.norm(behind - ground))
            if apart > min_step_lab and np.linalg.norm(around - behind) < 0.5 * apart:
                found.add(upper.name)
    return frozenset(found)


def _colour(
    lab: np.ndarray, covered: BoolArray, stance: Stance, high: float, low: float
) -> np.ndarray | None:
    """Median colour between two rows on both sides of a thing; None where objects cover them."""
    wide = max(stance.width, 8)
    columns = slice(max(0, stance.box[0] - wide), stance.box[2] + wide)
    band = slice(max(0, round(high)), max(0, round(low)) + 1)
    free = ~covered[band, columns]
    return np.median(lab[band, columns][free], axis=0) if free.sum() > 20 else None
