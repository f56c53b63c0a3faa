"""Attached parts: stems, necks, caps, poles and cuffs that are another colour than the thing.

Where a thing was clicked its colour is found, and a part of another colour is left out; a thin one
is lost on the small picture. So the picture around the best mask is cut into patches once more,
at a size at which the thing itself is as large as it can be, and patches that touch the mask, on
their own or several that stand out from the ground together, are weighed: those join that are
clearly a part. With them others may come to touch the mask, which have to be the clearer.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from physagent_studio.program.scene import Grounding
from physagent_studio.reconstruction.masks import (
    BoolArray,
    bounds,
    disc,
    grow,
    iou,
    resized,
)
from physagent_studio.reconstruction.segmentation_beside import ground_of, patches_beside
from physagent_studio.reconstruction.segmentation_choice import CANDIDATES
from physagent_studio.reconstruction.segmentation_evidence import (
    TALL,
    Colours,
    Outline,
    Patch,
    Surroundings,
    colours_of,
    features_of,
    lowness,
    outline_of,
    scores,
    shade_of,
)
from physagent_studio.reconstruction.segmentation_patches import (
    joined,
    patches_of,
    renumbered,
    steps_of,
)
from physagent_studio.records.case import Image
from physagent_studio.records.scene import Candidate

Usual = tuple[float, float] | None
IntArray = NDArray[np.int64]
SIDE, REACH = 150, 0.9
"""Longer side of the mask where it is looked at, pixels, and how far around it, in sides."""
FINE, LEVELS = 3.5, (5.0, 8.0, 12.0, 17.0)
"""How unlike patches are that the mask snaps to, and that parts are made of."""
CLEAR, CLEARER = 0.85, 0.25
"""Score from which a part joins, and how much more is asked of those that touch it only then."""
ROUNDS, MOST = 5, 1.5
"""How often parts join, and how much larger the mask becomes at most."""
LEAST, LARGEST, LONGEST = 0.002, 0.26, 0.5
"""Share of the mask's area between which a part is, and below which a slender one is."""
SLENDER = 0.3
"""Width of a slender part over the side of a square of the mask's area."""
NARROW, SEAM, NECK = 4.2, 0.62, -0.22
"""Pixels across the widest place of a part, share of its outline at the mask, and contact (log, as
`Outline.neck`) by which it is but a seam along the outline, or hardly touches."""
COMMON = -4.1
"""Log share of its colours elsewhere from which a patch is like what is around."""
BLURRED = 2.4
"""Sharpness (log, as `Outline.sharp`) below which a patch has no outline."""
SAME = 0.95
"""IoU from which two masks need not both be offered."""
COARSE = 500
"""Longer side of masks in pixels that are compared to one another."""
ODD = 0.3
"""Spreads by which parts may make a thing's proportions more unusual for its name."""


@dataclass(frozen=True, eq=False, slots=True)
class Around:
    """A mask and its surroundings at the size where parts are sought.

    part: (x0, y0, x1, y1) of the picture. lab (h, w, 3), steps, mask, barred (h, w): of that part.
    """

    part: tuple[int, int, int, int]
    lab: NDArray[np.float32]
    steps: NDArray[np.float32]
    mask: BoolArray
    barred: BoolArray


def with_parts(
    image: Image, offers: Sequence[Candidate], grounding: Grounding, usual: Usual = None
) -> tuple[Candidate, ...]:
    """Up to four candidates: led by the first with the parts attached to it, where it has any.

    usual: height over width of things of that name, and its spread (log).
    """
    found = None if not offers else with_attached(image, offers[0].mask, grounding)
    if found is None or _odder(offers[0].mask, found, usual):
        return tuple(offers)
    first = offers[0]
    led = Candidate(found, first.score, f"{first.method} and parts")
    others = [other for other in offers[1:] if iou(_coarse(other.mask), _coarse(found)) < SAME]
    # The last one is the mask with its shadow, where it has one.
    return (led, first, *others[: CANDIDATES - 3], *others[CANDIDATES - 3 :][-1:])


def _coarse(mask: BoolArray) -> BoolArray:
    """Some pixels of a mask, enough to compare it."""
    every = max(1, max(mask.shape) // COARSE)
    return mask[::every, ::every]


def _odder(before: BoolArray, after: BoolArray, usual: Usual) -> bool:
    """Whether parts make a thing less like others of its name."""
    if usual is None:
        return False
    off = []
    for mask in (before, after):
        x0, y0, x1, y1 = bounds(_coarse(mask))
        ratio = np.log(max(y1 - y0, 1) / max(x1 - x0, 1) / usual[0])
        off.append(abs(float(ratio)) / (usual[1] + 0.1))
    return off[1] > off[0] + ODD and off[1] > 1.0


def with_attached(image: Image, mask: BoolArray, grounding: Grounding) -> BoolArray | None:
    """The mask (H, W) with the parts attached to the thing; None where there is none to be seen.

    What holds a click outside, or lies outside of a box, is no part of it.
    """
    around = _around(image, mask, grounding)
    if around is None:
        return None
    found = _grown(around)
    if found is None:
        return None
    return mask | _placed(found, around, mask.shape)


def _placed(found: BoolArray, around: Around, shape: tuple[int, ...]) -> BoolArray:
    """(H, W) what is new in a mask of the surroundings, in its place in the picture."""
    new = found & ~around.mask
    left, top, right, low = around.part
    by = np.array([(right - left) / found.shape[1], (low - top) / found.shape[0]] * 2)
    x0, y0, x1, y1 = bounds(new)
    x0, y0 = max(0, x0 - 4), max(0, y0 - 4)
    x1, y1 = min(found.shape[1], x1 + 4), min(found.shape[0], y1 + 4)
    a, b, c, d = (int(v) for v in np.rint(np.array([x0, y0, x1, y1]) * by))
    out = np.zeros(shape[:2], bool)
    window = (slice(top + b, top + d), slice(left + a, left + c))
    joint = grow(new, 2) & found
    out[window] = resized(joint[y0:y1, x0:x1], (c - a, d - b))
    return out


def _around(image: Image, mask: BoolArray, grounding: Grounding) -> Around | None:
    x0, y0, x1, y1 = bounds(mask)
    side = max(x1 - x0, y1 - y0)
    if side < 12:
        return None
    reach = int(REACH * side) + 6
    left, top = max(0, x0 - reach), max(0, y0 - reach)
    right, low = min(mask.shape[1], x1 + reach), min(mask.shape[0], y1 + reach)
    crop = (slice(top, low), slice(left, right))
    factor = min(2.0, SIDE / side)
    how = cv2.INTER_AREA if factor < 1 else cv2.INTER_CUBIC
    small = cv2.resize(image[crop], None, fx=factor, fy=factor, interpolation=how)
    small = np.ascontiguousarray(small).astype(np.uint8)
    lab = cv2.cvtColor(cv2.bilateralFilter(small, 5, 30, 3), cv2.COLOR_RGB2LAB)
    size = (small.shape[1], small.shape[0])
    plain = cv2.INTER_AREA if factor < 1 else cv2.INTER_LINEAR
    own = cv2.resize(mask[crop].astype(np.uint8) * 255, size, interpolation=plain) > 127
    part = (left, top, right, low)
    barred = _barred(grounding, part, factor, own.shape)
    colours = lab.astype(np.float32)
    return Around(part, colours, steps_of(colours), np.asarray(own), barred)


def _barred(
    grounding: Grounding,
    part: tuple[int, int, int, int],
    factor: float,
    shape: tuple[int, ...],
) -> BoolArray:
    """(h, w) what cannot be a part: spots at clicks outside, and what is outside of a box."""
    out = np.zeros(shape[:2], np.uint8)
    for click in grounding.points:
        if not click.label:
            x, y = (click.x - part[0]) * factor, (click.y - part[1]) * factor
            cv2.circle(out, (int(x), int(y)), 2, 1, -1)
    if grounding.box is not None:
        x0, x1 = sorted(round((x - part[0]) * factor) for x in grounding.box[::2])
        y0, y1 = sorted(round((y - part[1]) * factor) for y in grounding.box[1::2])
        within = np.zeros(shape[:2], bool)
        within[max(0, y0 - 2) : max(0, y1 + 3), max(0, x0 - 2) : max(0, x1 + 3)] = True
        out[~within] = 1
    return out.astype(bool)


def _grown(around: Around) -> BoolArray | None:
    """The mask with its parts, at the size of the surroundings; None where it has none."""
    finest = patches_of(around.lab, around.steps)
    mask, fine = _snapped(joined(finest, around.lab, around.steps, [FINE])[0], around.mask)
    if not mask.any():
        return None
    levels = joined(fine, around.lab, around.steps, LEVELS)
    first = np.count_nonzero(mask)
    parts = np.zeros_like(mask)
    for turn in range(ROUNDS):
        found = _joining(around, mask, parts, levels, CLEAR + CLEARER * turn, LEAST * first)
        if found is None:
            break
        mask, parts = mask | found, parts | found
        if np.count_nonzero(mask) > MOST * first:
            break
    return _closed(around.mask, parts) if parts.any() else None


def _snapped(fine: IntArray, mask: BoolArray) -> tuple[BoolArray, IntArray]:
    """The mask as fine patches, and these: cut along it only where much lies on both sides."""
    count = int(fine.max()) + 1
    flat = fine.ravel()
    share = np.bincount(flat, mask.ravel(), count) / np.bincount(flat, minlength=count)
    wide = []
    for side in (mask, ~mask):
        depth = np.zeros(count)
        reach = cv2.distanceTransform(side.astype(np.uint8), cv2.DIST_L2, 3)
        np.maximum.at(depth, flat, reach.ravel())
        wide.append(depth > 2.5)
    cut = wide[0] & wide[1] & (share > 0.03) & (share < 0.97)
    out = np.where(cut[fine], mask, (share > 0.5)[fine])
    return out, renumbered(fine * 2 + out)


def _joining(
    around: Around,
    mask: BoolArray,
    parts: BoolArray,
    levels: Sequence[IntArray],
    clear: float,
    least: float,
) -> BoolArray | None:
    """The clearest parts that touch the mask, none of them beside another; None without any.

    parts: of the mask, those that joined before. A slender one that goes on need be no clearer.
    """
    here = Surroundings(around.lab, around.steps, mask, ground_of(levels[-1], mask))
    kept, features, asked = [], [], []
    for patch in patches_beside(around.barred, here, levels, least, LONGEST * here.area):
        outline = outline_of(patch, here)
        if _no_form(patch, here, outline):
            continue
        colours = colours_of(patch, here)
        if _ruled_out(patch, here, outline, colours):
            continue
        kept.append(patch.region)
        goes_on = outline.width < SLENDER * here.size / 2 and _hangs_on(patch.region, mask, parts)
        asked.append(CLEAR if goes_on else clear)
        features.append(features_of(patch, here, outline, colours))
    out = np.zeros_like(mask)
    values = scores(features)
    for k in np.argsort(-values, kind="stable"):
        if values[k] > asked[int(k)] and not (out & grow(kept[int(k)], 2)).any():
            out |= kept[int(k)]
    return out if out.any() else None


def _hangs_on(region: BoolArray, mask: BoolArray, parts: BoolArray) -> bool:
    """Whether a part touches the mask where another part has joined it."""
    contact = grow(region, 2) & mask
    shared = int(np.count_nonzero(contact & parts))
    return shared > 0.8 * max(int(np.count_nonzero(contact)), 1)


def _no_form(patch: Patch, here: Surroundings, outline: Outline) -> bool:
    """Whether a patch is a seam, hardly touches, has no outline or is too large for a part."""
    if outline.touching > SEAM or outline.neck < NECK or outline.width < NARROW:
        return True
    slender = outline.width < SLENDER * here.size
    too_large = len(patch.rows) > (LONGEST if slender else LARGEST) * here.area
    return too_large or outline.sharp < BLURRED


def _ruled_out(patch: Patch, here: Surroundings, outline: Outline, colours: Colours) -> bool:
    """Whether a patch is what is seen all around, or may be a shadow."""
    more = colours.own - colours.others
    if (colours.others > COMMON and more < 0.15) or (colours.others > -5.2 and more < -1.2):
        return True
    if lowness(patch, here) <= 0.08:
        return False
    # A shadow is soft, darker than the ground in its own tint, and lies flat.
    seen = colours.tint > 12 or colours.darker < -8 or patch.tall > TALL
    flat = shade_of(colours) > 0.25 and patch.tall < TALL
    return outline.sharp < 2.9 or not seen or flat


def _closed(mask: BoolArray, parts: BoolArray) -> BoolArray:
    """The mask and its parts, with what is between them where they nearly touch."""
    out = mask | parts
    closed = cv2.morphologyEx(out.astype(np.uint8), cv2.MORPH_CLOSE, disc(3)).astype(bool)
    return out | (closed & grow(mask, 3) & grow(parts, 3))
