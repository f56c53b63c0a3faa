"""What else stands where a thing's shade seems to lie: it is nobody's shade, and stays.

Shade is found by its colour, and a dark thing near by looks like it. So the network that finds
marked things (`masks.thing_map`) is asked about each piece of what would be taken out beside the
marked things. What it sees there that stands out all around and reaches beyond that is a thing.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import cv2
import numpy as np

from physagent_studio.arrays import FloatImage
from physagent_studio.reconstruction.masks.thing_map import MAP, Seen, at_point
from physagent_studio.reconstruction.photo.regions import BoolArray, grow, shrink
from physagent_studio.records.case import Image


@dataclass(frozen=True, slots=True)
class BystanderSettings:
    """What of a hole beside the marked things is taken for a thing of its own."""

    colours_count: int = 6  # count, 2..10: into which a hole is cut
    least_ratio: float = 2e-4  # 5e-5..2e-3: of the picture's area: smaller pieces are not looked at
    asked_count: int = 12  # count, 2..20: of pieces that are looked at, the roundest first
    rim_px: int = 4  # 1..10: around marked things, in which nothing is looked for
    max_own_share: float = 0.4  # 0..0.5: of it that lies on a marked thing
    max_area_ratio: float = 0.12  # 0.02..0.4: of the picture: larger is the ground, or a wall
    min_expected_iou: float = 0.7  # IoU, 0.5..0.95: as the network's map says of itself
    edge_lab: float = 10.0  # 4..25: by which colours differ across its outline where it stands out
    min_edge_share: float = 0.7  # 0.4..0.9: of its outline where they do
    # 0.03..0.6: of it that is beyond what would be taken out; where all of its outline stands out;
    # and where looks at it agree as well, unless it touches no marked thing
    min_beyond_shares: tuple[float, float, float] = (0.45, 0.25, 0.1)
    clear_edge_share: float = 0.9  # 0.7..0.98: of its outline: all of it stands out
    clear_agreement: float = 0.8  # mean IoU, 0.6..0.95: of looks at it that agree
    flat_ratio: float = 0.6  # 0.2..1: height over width in the picture, below which it lies flat
    # 0.3..0.9: of it that is beyond: less of it stands in what is taken out
    max_shading_share: float = 0.6
    shade_ratio: float = 0.5  # 0.1..2: over the root of its area, around it: shade there is its own
    foot_share: float = 0.2  # 0.05..0.5: of a marked thing's height, which is its foot
    # 0.1..0.6: of what is around a foot: more of it is what that stands on, or painted there
    max_under_share: float = 0.25


BYSTANDER = BystanderSettings()


def bystanders(photo: Image, things: BoolArray, hole: BoolArray) -> BoolArray:
    """(H, W) what stands within a hole and is no part of it.

    things: (H, W) the marked things themselves. hole: (H, W) what would be taken out with them.
    """
    factor = min(1.0, MAP.picture_px / max(hole.shape))
    sized = cv2.resize(photo, None, fx=factor, fy=factor, interpolation=cv2.INTER_AREA)
    small = np.ascontiguousarray(sized, np.uint8)
    size = (small.shape[1], small.shape[0])
    taken, own = (
        cv2.resize(what.astype(np.uint8), size, interpolation=cv2.INTER_NEAREST) > 0
        for what in (hole, things)
    )
    own = grow(own, BYSTANDER.rim_px)
    feet = _feet(own)
    _, labels = cv2.connectedComponents((taken & ~own).astype(np.uint8))
    joined = np.isin(labels, np.unique(labels[grow(own, 2) & ~own])) & (labels > 0)
    lab = np.asarray(cv2.cvtColor(cv2.GaussianBlur(small, (0, 0), 0.8), cv2.COLOR_RGB2LAB), "f4")
    found = np.zeros_like(own)
    asked = 0
    for x, y in _pieces(lab, joined):
        if asked == BYSTANDER.asked_count:
            break
        if not found[y, x]:
            asked += 1
            seen = at_point(small, (x, y))
            under = any(seen.mask[foot].mean() > BYSTANDER.max_under_share for foot in feet)
            if not under and _is_thing(seen, lab, own, taken, feet):
                found |= seen.mask
    # What lies by itself is the shadow of what hangs: nothing tells it from a thing for sure.
    found &= joined | ~taken
    wide = cv2.resize(found.astype(np.float32), hole.shape[::-1], interpolation=cv2.INTER_LINEAR)
    return np.asarray(wide > 0.5)


def about_them(others: BoolArray, things: BoolArray, hole: BoolArray) -> BoolArray:
    """(H, W) what of a hole is bystanders' shade, and they themselves: what is around them, nearer
    to them than to the marked things, and what hangs together with those only through it.

    What does not reach beyond the hole may be a piece of a thing's own shade, and has none; what
    hardly reaches into it has its shade elsewhere.
    """
    out = others.copy()
    to_things = _away(things)
    number, labels, stats, _ = cv2.connectedComponentsWithStats(others.astype(np.uint8))
    for one in range(1, number):
        own, area = labels == one, stats[one, cv2.CC_STAT_AREA]
        beyond = np.count_nonzero(own & ~hole) / area
        if not BYSTANDER.min_beyond_shares[2] < beyond < BYSTANDER.max_shading_share:
            continue
        away, reach = _away(own), BYSTANDER.shade_ratio * float(np.sqrt(area))
        near = (away < to_things) & (away < reach) & ~things
        _, parts, sizes, _ = cv2.connectedComponentsWithStats((hole & ~near).astype(np.uint8))
        beside, mine = (np.unique(parts[grow(what, 1) & hole & ~near]) for what in (near, things))
        # More than it is large is rather the thing's own, with the bystander in its middle.
        small = np.flatnonzero(sizes[:, cv2.CC_STAT_AREA] < area)
        cut_off = np.setdiff1d(np.intersect1d(beside, small), [0, *mine])
        out |= near | np.isin(parts, cut_off)
    return out


def _away(region: BoolArray) -> FloatImage:
    """(H, W) pixels to the nearest of a region."""
    return np.asarray(cv2.distanceTransform((~region).astype(np.uint8), cv2.DIST_L2, 5), np.float32)


def _feet(own: BoolArray) -> list[BoolArray]:
    """(H, W) what is right around the foot of each marked thing, apart from others."""
    number, labels, stats, _ = cv2.connectedComponentsWithStats(own.astype(np.uint8))
    found = []
    for one in range(1, number):
        end = stats[one, cv2.CC_STAT_TOP] + stats[one, cv2.CC_STAT_HEIGHT]
        low = labels == one
        low[: end - max(2, round(BYSTANDER.foot_share * stats[one, cv2.CC_STAT_HEIGHT]))] = False
        ring = grow(low, BYSTANDER.rim_px) & ~own
        if ring.any():
            found.append(ring)
    return found


def _pieces(lab: FloatImage, region: BoolArray) -> list[tuple[int, int]]:
    """Middles (column, row) of the pieces of about one colour into which a region falls."""
    least = max(25, round(BYSTANDER.least_ratio * region.size))
    count = np.count_nonzero(region)
    if count < least:
        return []
    kinds = min(BYSTANDER.colours_count, max(2, int(count) // least))
    colours = lab[region]
    cv2.setRNGSeed(1)
    ends = (3, 20, 0.5)
    sample = np.ascontiguousarray(colours[:: max(1, count // 4000)])
    start = np.zeros((len(sample), 1), np.int32)
    *_, middles = cv2.kmeans(sample, kinds, start, ends, 2, cv2.KMEANS_PP_CENTERS)
    kind = np.full(region.shape, -1)
    off = np.square(colours[:, None] - np.asarray(middles)[None]).sum(-1)
    kind[region] = off.argmin(-1)
    found: list[tuple[float, int, int]] = []
    for k in range(kinds):
        part = cv2.morphologyEx((kind == k).astype(np.uint8), cv2.MORPH_OPEN, np.ones((3, 3)))
        number, labels, stats, _ = cv2.connectedComponentsWithStats(part, connectivity=4)
        for one in range(1, number):
            if stats[one, cv2.CC_STAT_AREA] >= least:
                inner = cv2.distanceTransform((labels == one).astype(np.uint8), cv2.DIST_L2, 5)
                row, column = np.unravel_index(int(inner.argmax()), inner.shape)
                found.append((float(inner.max()), int(column), int(row)))
    return [(x, y) for _, x, y in sorted(found, reverse=True)]


def _is_thing(
    seen: Seen, lab: FloatImage, own: BoolArray, taken: BoolArray, feet: Sequence[BoolArray]
) -> bool:
    """Whether what the network sees there stands out all around, and is no shade."""
    area = np.count_nonzero(seen.mask)
    if not area or area > BYSTANDER.max_area_ratio * own.size:
        return False
    if seen.expected_iou < BYSTANDER.min_expected_iou:
        return False
    on_own = np.count_nonzero(seen.mask & own) / area
    beyond = np.count_nonzero(seen.mask & ~taken & ~own) / area
    stands_out = _stands_out(lab, seen.mask)
    if on_own > BYSTANDER.max_own_share or stands_out < BYSTANDER.min_edge_share:
        return False
    clear = stands_out > BYSTANDER.clear_edge_share
    sure = clear and seen.agreement > BYSTANDER.clear_agreement
    # What lies flat at a foot is rather the shadow itself, however clear that is.
    flat = _lies_flat(seen.mask) and any((seen.mask & foot).any() for foot in feet)
    least = BYSTANDER.min_beyond_shares[0 if flat else int(clear) + int(sure)]
    return bool(beyond > least or (sure and on_own == 0))


def _lies_flat(mask: BoolArray) -> bool:
    """Whether it is much wider than high in the picture, as shadows on the ground are."""
    rows, columns = mask.nonzero()
    return bool(np.ptp(rows) < BYSTANDER.flat_ratio * np.ptp(columns))


def _stands_out(lab: FloatImage, mask: BoolArray) -> float:
    """The share of an outline across which colours differ."""
    inside, around = shrink(mask, 1), grow(mask, 3) & ~grow(mask, 1)
    means, seen = [], mask & ~shrink(mask, 1)
    for side in (inside, around):
        weight = cv2.blur(side.astype(np.float32), (9, 9))
        means.append(cv2.blur(lab * side[..., None], (9, 9)) / np.maximum(weight, 1e-4)[..., None])
        seen = seen & (weight > 1e-3)
    off = np.linalg.norm(means[0] - means[1], axis=-1)[seen]
    return float((off > BYSTANDER.edge_lab).mean()) if len(off) > 7 else 0.0
