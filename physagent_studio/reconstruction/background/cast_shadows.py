"""Shade that things keep around their foot: dark ground beside them that fills should not copy."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from physagent_studio.arrays import FloatImage
from physagent_studio.reconstruction.background.ground_tones import Tones, lit_ones, parts_of
from physagent_studio.reconstruction.background.surfaces import reduced, under
from physagent_studio.reconstruction.photo.regions import BoolArray, bounds, grow
from physagent_studio.reconstruction.switches import at_work
from physagent_studio.records.case import Image


@dataclass(frozen=True, slots=True)
class ShadeSettings:
    """What is taken for the shade of a thing."""

    # 0.5..6: over how uneven lit ground is itself, of the darkness of shade and of its faint rim
    grain_ratios: tuple[float, float] = (3.0, 1.0)
    # 1..20: of the thing's colour on ground that it shines on, and at its faint rim
    glow_lab: tuple[float, float] = (6.0, 3.0)


SHADE = ShadeSettings()


def shaded(
    photo: Image,
    masks: Sequence[BoolArray],
    hole: BoolArray,
    faces: NDArray[np.int64] | None = None,
) -> BoolArray:
    """(H, W) ground around the feet of the masked things that looks as if they shaded it.

    faces: (H, W) numbers of the faces on which things stand, as `surfaces` gives them.
    """
    out = np.zeros(hole.shape, bool)
    for mask, top in zip(masks, tops_of(masks), strict=True):
        if mask.any():
            out |= _of_one(photo, mask, hole, faces, top)
    return out


def _of_one(
    photo: Image,
    mask: BoolArray,
    hole: BoolArray,
    faces: NDArray[np.int64] | None,
    top: int,
) -> BoolArray:
    """(H, W) shade of one thing, looked for in a smaller picture in which it is not too small."""
    x0, y0, x1, y1 = bounds(mask)
    longer_px = 208  # 100..400: side of the picture in which shade is looked for
    # 0..100: size of a thing in it: what is smaller there throws no shade to be seen
    smallest_px = 40
    factor = min(1.0, max(longer_px / max(hole.shape), smallest_px / max(x1 - x0, y1 - y0)))
    size = (max(8, round(hole.shape[1] * factor)), max(8, round(hole.shape[0] * factor)))
    small = cv2.resize(photo, size, interpolation=cv2.INTER_AREA).astype(np.float32) / 255
    lab = np.asarray(cv2.cvtColor(cv2.GaussianBlur(small, (0, 0), 1.0), cv2.COLOR_RGB2LAB), "f4")
    inside = cv2.resize(hole.astype(np.uint8), size, interpolation=cv2.INTER_NEAREST) > 0
    kinds = np.zeros(inside.shape, np.int64) if faces is None else reduced(faces, size)
    own = cv2.resize(mask.astype(np.uint8), size, interpolation=cv2.INTER_AREA) > 0
    if not own.any():
        return np.zeros_like(hole)
    found = _around(lab, own, inside, under(own, kinds), round(top * factor)).astype(np.float32)
    wide = cv2.resize(found, hole.shape[::-1], interpolation=cv2.INTER_LINEAR)
    return np.asarray(cv2.GaussianBlur(wide, (0, 0), 0.7 / factor) > 0.4)


def tops_of(masks: Sequence[BoolArray]) -> list[int]:
    """The highest row of each mask and of all that stands on it: stacks shade the ground as one.

    A thing stands on another where it touches it from above, over most of the narrower one's width.
    """
    tops = [bounds(mask)[1] if mask.any() else 0 for mask in masks]
    if not at_work("shade of stacks"):
        return tops
    order = sorted((k for k in range(len(masks)) if masks[k].any()), key=tops.__getitem__)
    for k in order:
        for other in order:
            if other != k and tops[k] < tops[other] and _stands_on(masks[k], masks[other]):
                tops[other] = tops[k]
    return tops


def _stands_on(upper: BoolArray, lower: BoolArray) -> bool:
    x0, _, x1, y1 = bounds(upper)
    left, _, right, _ = bounds(lower)
    gap_ratio = 0.01  # 0.002..0.05: over the longer side, between a thing and what it stands on
    gap = max(3, round(gap_ratio * max(upper.shape)))
    sole = upper.copy()
    # 0.1..1: over its width, how much of a thing, from below, may touch what it stands on
    sole_ratio = 0.4
    sole[: y1 - max(1, round(sole_ratio * (x1 - x0)))] = False
    beneath = np.zeros_like(lower)
    beneath[gap:] = sole[:-gap]
    touching = (beneath & lower).any(0)
    on_share = 0.4  # 0.1..0.9: of the narrower one's width over which it does, at least
    return bool(touching.sum() > on_share * min(x1 - x0, right - left))


def _around(
    lab: FloatImage, own: BoolArray, inside: BoolArray, theirs: BoolArray, top: int
) -> BoolArray:
    """Shade of one thing: dark, of the ground's colour, and joined to the thing at its foot.

    theirs: (H, W) the face that it stands on. top: the highest row of it and what it carries.
    """
    x0, y0, x1, y1 = bounds(own)
    side = max(x1 - x0, y1 - y0)
    rows = np.arange(own.shape[0])[:, None] * np.ones(own.shape[1])
    # 0.1..2: of a thing's height over its foot, where shade begins, and ends
    above_shares = (0.3, 1.0)
    low = rows >= y1 - round(above_shares[0] * (y1 - y0))
    ground = (rows >= y1 - round(above_shares[1] * (y1 - top))) & theirs
    reach_ratio = 1.5  # 0.5..4: over a thing's size, how far from it its shade is looked for
    reach = round(reach_ratio * max(side, y1 - top))
    near = ground & grow(own, reach) & ~inside
    far = low & theirs & grow(own, round(1.2 * side)) & ~grow(own, round(0.25 * side)) & ~inside
    if np.count_nonzero(far) < 30 or not near.any():
        return np.zeros_like(own)
    place = _Place(own, inside, near, ground & ~inside, low)
    floor = far | (near & low)
    parts = parts_of(lab, floor)
    lit = lit_ones(lab, parts) if at_work("deep shade") else parts
    if len(lit) < len(parts):
        deep = _deep(place, Tones.of(lab, floor, own, lit))
        if deep.any():
            return deep
    tones = Tones.of(lab, floor, own, parts)
    # 1..5: of darkness, from one try to the next: painted patches may have shade
    deeper_ratios = (1.0, 1.7, 2.6)
    # 0.1..1: of a shade's rim that has the ground's colour, at least, in each try
    bare_shares = (0.7, 0.4, 0.4)
    for times, bare in zip(deeper_ratios, bare_shares, strict=True):
        if times > 1 and not at_work("deeper shade"):
            break
        found = _shade(place, tones, times)
        if not found.any() or _ends_lit(found, tones, place.ground, bare):
            return found if times == 1 or not found.any() else _faded(found, place, tones)
    return np.zeros_like(own)


def _deep(place: _Place, tones: Tones) -> BoolArray:
    """Shade of the sun, as dark as if it were ground of another colour: where all around is lit.

    A tree or a rug that is dark goes on beyond where shade is looked for.
    """
    found = _shade(place, tones, 1.0)
    rim = grow(found, 3) & ~grow(found, 1) & ~place.inside & ~place.own
    if not found.any() or not rim.any():
        return np.zeros_like(found)
    lit_share = 0.8  # 0.5..1: of what is around it that is less than half as dark
    half = float(np.median(tones.darker[found])) / 2
    lit = (tones.which[rim] >= 0) & (tones.darker[rim] < half)
    return found if float(lit.mean()) > lit_share else np.zeros_like(found)


@dataclass(frozen=True, eq=False, slots=True)
class _Place:
    """A thing, what is filled in, the ground near the thing, all ground, and what is low; (H, W)
    each."""

    own: BoolArray
    inside: BoolArray
    near: BoolArray
    ground: BoolArray
    low: BoolArray


def _shade(place: _Place, tones: Tones, times: float) -> BoolArray:
    """Shade of one thing that is so many times as dark as shade is at least."""
    own, near = place.own, place.near
    x0, y0, x1, y1 = bounds(own)
    side = max(x1 - x0, y1 - y0)
    theirs = near & (tones.which >= 0)
    darker_lab = 7.0  # 3..20: L*, by which shade is darker than lit ground at least
    # No tile is darker than the dark ones of a pattern, but in shade.
    pattern = np.minimum(SHADE.grain_ratios[0] * tones.uneven, tones.darkest + darker_lab)
    deep = tones.darker > times * np.maximum(darker_lab, pattern)
    deep |= tones.glow > times * SHADE.glow_lab[0]
    # Pixels along an edge are of both its colours, and like neither in shade: thin lines are none.
    wide = ((theirs & deep) | place.inside).astype(np.uint8)
    wide = cv2.morphologyEx(wide, cv2.MORPH_OPEN, np.ones((3, 3), np.uint8)) > 0
    mine = _joined_to(theirs & deep & wide, own | place.inside, own, place.low)
    seed_px = 5  # count, 2..30: that are surely shade, for there to be any
    if np.count_nonzero(mine) < seed_px:
        return np.zeros_like(own)
    # Shade fades out: its faint rim belongs to it.
    faint = theirs & _faint(tones)
    wide = mine
    for _ in range(max(2, side // 4) if times == 1 else 2):
        wide = mine | (grow(wide, 1) & faint)
    return grow(wide, 1) & near


def _faint(tones: Tones) -> BoolArray:
    """(H, W) where it is as dark as the faint rim of a shade at least."""
    smooth, tinged = (np.asarray(cv2.blur(v, (3, 3))) for v in (tones.darker, tones.glow))
    faint_lab = 1.6  # 0.5..5: L*, of its faint rim
    dark = smooth > np.maximum(faint_lab, SHADE.grain_ratios[1] * tones.uneven)
    return np.asarray(dark | (tinged > SHADE.glow_lab[1]))


def _faded(shade: BoolArray, place: _Place, tones: Tones) -> BoolArray:
    """What may be painted, with its rim as far as that fades: paint does not, shade does."""
    smooth = np.asarray(cv2.blur(tones.darker, (3, 3)), np.float32)
    main = np.bincount(tones.which[shade] + 1, minlength=2)[1:].argmax()
    faint = place.near & _faint(tones) & (tones.which == main)
    x0, y0, x1, y1 = bounds(place.own)
    out = shade
    # 0.8..1: by which it gets fainter from pixel to pixel where it is told from paint
    fades_ratio = 0.94
    for _ in range(max(x1 - x0, y1 - y0) // 4):
        count = cv2.blur(out.astype(np.float32), (3, 3))
        beside = cv2.blur(np.where(out, smooth, 0).astype(np.float32), (3, 3))
        out = out | (grow(out, 1) & faint & (smooth * count < fades_ratio * beside))
    return out


def _ends_lit(shade: BoolArray, tones: Tones, ground: BoolArray, bare: float) -> bool:
    """Whether shade ends on ground of its own colour; what ends at another one is paint."""
    rim = grow(shade, 3) & ~grow(shade, 1) & ground
    if not rim.any():
        return False
    counts = np.bincount(tones.which[shade] + 1, minlength=2)
    main = int(counts[1:].argmax())
    return float((tones.which[rim] == main).mean()) > bare


def _joined_to(dark: BoolArray, through: BoolArray, own: BoolArray, low: BoolArray) -> BoolArray:
    """What is dark and hangs together with the thing at its foot."""
    joined = dark | ((grow(own, 2) | through) & low)
    _, labels = cv2.connectedComponents(joined.astype(np.uint8))
    return np.isin(labels, np.unique(labels[own & low])) & dark
