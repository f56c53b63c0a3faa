"""Unmarked things that look like a marked one: its colours, about its size and its proportions.

Where there are some beside a thing, what is filled in behind it may go over them.
"""

from collections.abc import Mapping
from dataclasses import dataclass

import cv2
import numpy as np

from physagent_studio.reconstruction.photo.regions import BoolArray, bounds, grow, shrink
from physagent_studio.records.case import Image

Box = tuple[int, int, int, int]
"""Left, top, right and bottom, pixels."""

SHADED = np.array([0.5, 1.0, 1.0], np.float32)
"""What differences of L*, a* and b* count for: sides of a thing are lit differently."""


@dataclass(frozen=True, slots=True)
class LikenessSettings:
    """What looks like a marked thing."""

    max_ground_share: float = 0.6  # 0.2..0.9: of the way from its colour to the ground's
    max_distance_lab: float = 30.0  # 10..60: from its colour, where the ground's is far off
    min_ground_lab: float = 12.0  # 4..30: what is nearer to the ground's colour is ground
    spot_ratio: float = 0.14  # 0..0.4: over the thing's side: spots so wide are closed
    thread_ratio: float = 0.1  # 0..0.4: over the thing's side: threads between things are cut
    area_ratios: tuple[float, float] = (0.3, 2.5)  # 0.1..5: area over the thing's own
    # 0.3..3: width over height, over the thing's own
    aspect_ratios: tuple[float, float] = (0.6, 1.6)
    # 0.3..3: share of its box that it fills, likewise
    filled_ratios: tuple[float, float] = (0.65, 1.35)
    canny_levels: tuple[int, int] = (30, 80)  # 10..200: steps of red, green or blue at edges
    min_sharp_share: float = 0.75  # 0.4..1: of an outline on edges; a reflection has fewer
    longest_side_px: int = 900  # 400..2000: more pixels show no more of colours and outlines
    max_found: int = 12  # count, 4..50: for one thing; more of them are a texture
    changed_levels: int = 12  # 4..40: a pixel so unlike the photo was filled in anew
    said_share: float = 0.04  # 0.01..0.2: of a thing that is filled over, before it is said


LIKE = LikenessSettings()


def similar(image: Image, name: str, masks: Mapping[str, BoolArray]) -> tuple[Box, ...]:
    """Boxes around what looks like the thing of that name and is no part of any mask, nearest
    first.
    """
    step, image, masks = _smaller(image, masks)
    return tuple(_box(found, step) for found in _found(image, name, masks))


def covered(
    image: Image, background: Image, masks: Mapping[str, BoolArray]
) -> dict[str, tuple[Box, ...]]:
    """Boxes of unmarked things like a marked one that its fill goes over, by its name."""
    step, image, masks = _smaller(image, masks)
    free = ~np.any([*masks.values(), np.zeros(image.shape[:2], bool)], axis=0)
    filling = background[::step, ::step]
    apart = np.abs(image.astype(np.int16) - filling.astype(np.int16)).max(axis=-1)
    filled = free & (apart > LIKE.changed_levels)
    told: dict[str, tuple[Box, ...]] = {}
    for name, mask in masks.items():
        x0, y0, x1, y1 = bounds(mask) if mask.any() else (0, 0, 0, 0)
        near = _within(mask, max(4, x1 - x0, y1 - y0))
        over = [
            _box(found, step)
            for found in _found(image, name, masks)
            if np.count_nonzero(found & filled & near) > LIKE.said_share * np.count_nonzero(found)
        ]
        if over:
            told[name] = tuple(over)
    return told


def _smaller(
    image: Image, masks: Mapping[str, BoolArray]
) -> tuple[int, Image, dict[str, BoolArray]]:
    """Every n-th pixel of the picture and its masks, so that no side is too long; and n."""
    step = -(-max(image.shape[:2]) // LIKE.longest_side_px)
    parts = {name: np.ascontiguousarray(mask[::step, ::step]) for name, mask in masks.items()}
    return step, np.ascontiguousarray(image[::step, ::step]), parts


def _box(found: BoolArray, step: int) -> Box:
    x0, y0, x1, y1 = bounds(found)
    return x0 * step, y0 * step, x1 * step, y1 * step


def _found(image: Image, name: str, masks: Mapping[str, BoolArray]) -> list[BoolArray]:
    mask = masks.get(name)
    if mask is None or np.count_nonzero(mask) < 60:
        return []
    taken = grow(np.any([*masks.values()], axis=0), 2)
    like = _alike(image, mask, taken)
    count, labels, stats, middles = cv2.connectedComponentsWithStats(like.astype(np.uint8))
    x0, y0, x1, y1 = bounds(mask)
    own = np.array([np.count_nonzero(mask), (x1 - x0) / (y1 - y0), _fill(mask)])
    centre = np.array([(x0 + x1) / 2, (y0 + y1) / 2])
    near = sorted(range(1, count), key=lambda k: float(np.linalg.norm(middles[k] - centre)))
    smooth = cv2.GaussianBlur(image, (0, 0), 1.0)
    edges = grow(
        np.any([cv2.Canny(one, *LIKE.canny_levels) > 0 for one in cv2.split(smooth)], axis=0), 2
    )
    out: list[BoolArray] = []
    for k in near:
        if (
            not LIKE.area_ratios[0] * own[0]
            < stats[k, cv2.CC_STAT_AREA]
            < LIKE.area_ratios[1] * own[0]
        ):
            continue
        part = labels == k
        wide, high = stats[k, cv2.CC_STAT_WIDTH], stats[k, cv2.CC_STAT_HEIGHT]
        beside = np.array([wide / high, _fill(part)]) / own[1:]
        shaped = (
            LIKE.aspect_ratios[0] < beside[0] < LIKE.aspect_ratios[1]
            and LIKE.filled_ratios[0] < beside[1] < LIKE.filled_ratios[1]
        )
        if shaped and float(edges[grow(part, 1) & ~shrink(part, 1)].mean()) > LIKE.min_sharp_share:
            out.append(part)
        if len(out) == LIKE.max_found:
            break
    return out


def _alike(image: Image, mask: BoolArray, taken: BoolArray) -> BoolArray:
    """Pixels outside of all masks that are nearer to the thing's main colour than to the ground."""
    lab = cv2.cvtColor(cv2.GaussianBlur(image, (0, 0), 1.0), cv2.COLOR_RGB2LAB).astype(np.float32)
    lab *= SHADED
    side = float(np.sqrt(np.count_nonzero(mask)))
    ring = _within(mask, max(6.0, side)) & ~taken
    ground = np.median(lab[ring], axis=0) if ring.any() else np.zeros(3)
    unlike = mask & (np.linalg.norm(lab - ground, axis=-1) > LIKE.min_ground_lab)
    if np.count_nonzero(unlike) < np.count_nonzero(mask) / 4:
        return np.zeros_like(mask)
    own = np.median(lab[unlike], axis=0)
    reach = min(LIKE.max_ground_share * float(np.linalg.norm(own - ground)), LIKE.max_distance_lab)
    like = (np.linalg.norm(lab - own, axis=-1) < reach) & ~taken
    # Spots on a thing are closed, threads between things are cut.
    for how, share in ((cv2.MORPH_CLOSE, LIKE.spot_ratio), (cv2.MORPH_OPEN, LIKE.thread_ratio)):
        edge = 2 * round(share * side / 2) + 1
        shape = cv2.getStructuringElement(cv2.MORPH_ELLIPSE, (edge, edge))
        like = cv2.morphologyEx(like.astype(np.uint8), how, shape) > 0
    return like & ~taken


def _within(mask: BoolArray, far: float) -> BoolArray:
    """Pixels at most so far from a mask."""
    return cv2.distanceTransform((~mask).astype(np.uint8), cv2.DIST_L2, 5) <= far


def _fill(mask: BoolArray) -> float:
    x0, y0, x1, y1 = bounds(mask)
    return np.count_nonzero(mask) / max((x1 - x0) * (y1 - y0), 1)
