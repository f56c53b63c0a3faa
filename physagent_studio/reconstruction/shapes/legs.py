"""Legs and wheels in a silhouette: narrow parts side by side below an opening, down to the foot.

A deep thing on legs stands on posts, not on walls: each leg that is seen from the front has one
behind it, and what is low enough passes between them.
"""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np

from physagent_studio.reconstruction.photo.regions import BoolArray, bounds, grow


@dataclass(frozen=True, slots=True)
class SplitSettings:
    """Which narrow parts of a silhouette are legs."""

    max_covered_share: float = 0.5  # 0.2..0.8: of a row's width, by all legs together
    max_width_share: float = 0.3  # 0.1..0.5: of the silhouette; a wider part is a body
    min_opening_share: float = 0.14  # 0.05..0.4: of the height; less is a notch
    # 0..0.2: of the height from below: feet and rims end at different rows
    ragged_share: float = 0.15
    into_share: float = 0.08  # 0..0.3: of the height, that a leg reaches into the body
    thin_share: float = 0.35  # 0.1..0.6: of half a body's depth, that half a leg is wide at most
    # 0.05..0.4: of half the depth over the width, from which on it stands on more than one row
    min_deep_ratio: float = 0.15
    several_share: float = 0.3  # 0.1..0.7: of its rows, in which more than two legs are seen


SPLIT = SplitSettings()


def split_legs(mask: BoolArray) -> tuple[BoolArray, list[BoolArray]]:
    """The body (H, W) without its legs, and each leg with its end in the body; none is ()."""
    x0, y0, x1, y1 = bounds(mask)
    width, height = x1 - x0, y1 - y0
    top = _opening(mask, (x0, y0, x1, y1))
    if top is None or y1 - top < SPLIT.min_opening_share * height:
        return mask, []
    below = np.zeros_like(mask)
    below[top:] = mask[top:]
    count, labels, stats, _ = cv2.connectedComponentsWithStats(below.astype(np.uint8))
    legs = []
    for label in range(1, count):
        _, _, wide, tall, area = (int(value) for value in stats[label])
        if area < 0.002 * np.count_nonzero(mask):
            continue
        if wide > SPLIT.max_width_share * width or tall < 0.5 * (y1 - top):
            return mask, []
        legs.append(labels == label)
    if len(legs) < 2:
        return mask, []
    body = mask & ~below
    reach = max(2, round(SPLIT.into_share * height))
    return body, [leg | (_column(leg, top, reach) & mask) for leg in legs]


def thin_legs(mask: BoolArray, half: float) -> tuple[BoolArray, list[BoolArray]]:
    """The body (H, W) of what is 2 · half pixels deep, and the thin parts that carry something wide

    and have another beside them, as a pole has not; none is ().
    """
    x0, y0, x1, y1 = bounds(mask)
    if half < SPLIT.min_deep_ratio * (x1 - x0):
        return mask, []
    reach = 2 * max(1, round(SPLIT.thin_share * half)) + 1
    around = cv2.getStructuringElement(cv2.MORPH_ELLIPSE, (reach, reach))
    own = np.pad(mask[y0:y1, x0:x1], reach).astype(np.uint8)
    wide = cv2.morphologyEx(own, cv2.MORPH_OPEN, around)[reach:-reach, reach:-reach] > 0
    rows = mask[y0:y1, x0:x1]
    runs = (np.diff(np.pad(rows, ((0, 0), (1, 1))).astype(np.int8), axis=1) == 1).sum(1)
    thin = np.zeros_like(mask)
    thin[y0:y1, x0:x1] = rows & ~wide & (runs >= 2)[:, None]
    under = np.zeros_like(mask)
    under[y0:y1, x0:x1] = grow(rows & wide, max(2, reach // 2))
    low = y1 - SPLIT.ragged_share * (y1 - y0)
    count, labels, stats, _ = cv2.connectedComponentsWithStats(thin.astype(np.uint8))
    legs = [
        labels == k
        for k in range(1, count)
        if stats[k, cv2.CC_STAT_TOP] + stats[k, cv2.CC_STAT_HEIGHT] > low
        and (under & (labels == k)).any()
    ]
    if not legs:
        return mask, []
    into = max(2, reach // 2)
    return mask & ~np.any(legs, axis=0), [grow(leg, into) & mask for leg in legs]


def several_rows(legs: list[BoolArray]) -> bool:
    """Whether legs (H, W) are seen that stand behind the front ones: more than two side by side."""
    below = np.any(legs, axis=0)
    rows = below[below.any(1)]
    runs = (np.diff(np.pad(rows, ((0, 0), (1, 1))).astype(np.int8), axis=1) == 1).sum(1)
    return bool((runs > 2).mean() > SPLIT.several_share)


def _opening(mask: BoolArray, box: tuple[int, int, int, int]) -> int | None:
    """The uppermost row of the opening between legs; None without one."""
    x0, y0, x1, y1 = box
    rows = mask[y0:y1, x0:x1]
    covered = rows.sum(1)
    spread = np.where(
        covered > 0, rows.shape[1] - rows[:, ::-1].argmax(1) - rows.argmax(1), rows.shape[1]
    )
    runs = (np.diff(np.pad(rows, ((0, 0), (1, 1))).astype(np.int8), axis=1) == 1).sum(1)
    leggy = (
        (runs >= 2)
        & (covered <= SPLIT.max_covered_share * spread)
        & (spread > SPLIT.max_width_share * rows.shape[1])
    )
    last = len(rows) - 1
    ragged = round(SPLIT.ragged_share * len(rows))
    while last > len(rows) - 1 - ragged and not leggy[last]:
        last -= 1
    if not leggy[last]:
        return None
    first = last
    while first > 0 and leggy[first - 1]:
        first -= 1
    return y0 + first


def _column(leg: BoolArray, top: int, reach: int) -> BoolArray:
    """The pixels right above the upper end of a leg."""
    out = np.zeros_like(leg)
    out[max(0, top - reach) : top] = leg[top : top + 3].any(0)
    return out
