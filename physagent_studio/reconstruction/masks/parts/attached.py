"""Attached parts: stems, necks, caps, poles and cuffs that are another colour than the thing.

Where a thing was clicked its colour is found, and a part of another colour is left out; a thin one
is lost on the small picture. So the picture around the best mask is cut into patches once more,
at a size at which the thing itself is as large as it can be, and patches that touch the mask, on
their own or several that stand out from the ground together, are weighed: those join that are
clearly a part. With them others may come to touch the mask, which have to be the clearer.
"""

from __future__ import annotations

from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor

import cv2
import numpy as np
from numpy.typing import NDArray

from physagent_studio.program.scene.state import Grounding
from physagent_studio.reconstruction.masks.choice import CANDIDATES
from physagent_studio.reconstruction.masks.parts.focus import Focus
from physagent_studio.reconstruction.masks.parts.joining import LEAST, Around, Grown, joining
from physagent_studio.reconstruction.masks.parts.patches import (
    joined,
    patches_of,
    renumbered,
    steps_of,
)
from physagent_studio.reconstruction.masks.parts.patches_beside import Parted
from physagent_studio.reconstruction.masks.parts.shafts import WIDE, edges_of, strips_of
from physagent_studio.reconstruction.masks.task import (
    looks_for_poles,
    snapped,
)
from physagent_studio.reconstruction.photo.regions import (
    BoolArray,
    bounds,
    disc,
    grow,
    iou,
    resized,
)
from physagent_studio.reconstruction.switches import at_work
from physagent_studio.records.case import Image
from physagent_studio.records.scene import Candidate

Usual = tuple[float, float] | None
IntArray = NDArray[np.int64]
SIDE, REACH = 150, 0.9
"""Longer side of the mask where it is looked at, pixels, and how far around it, in sides."""
FINE, LEVELS = 3.5, (5.0, 8.0, 12.0, 17.0)
"""How unlike patches are that the mask snaps to, and that parts are made of."""
ROUNDS, MOST = 5, 1.5
"""How often parts join, and how much larger the mask becomes at most."""
BAND, UNFRAYED = (4, 0.02), 0.55
"""Pixels, and share of the mask's longer side, by which the outline is off with parts at most, and
share of the mask (IoU) that is left at least where it is settled."""
SAME = 0.95
"""IoU from which two masks need not both be offered."""
COARSE = 500
"""Longer side of masks in pixels that are compared to one another."""
ODD = 0.3
"""Spreads by which parts may make a thing's proportions more unusual for its name."""


def led_by(
    found: BoolArray | None, offers: Sequence[Candidate], usual: Usual = None
) -> tuple[Candidate, ...]:
    """Up to four candidates: led by the first with its parts, where it has any.

    found: what `with_attached` has found for the first. usual: height over width of things of that
    name, and its spread (log).
    """
    if found is None or _odder(offers[0].mask, found, usual):
        return tuple(offers)
    first = offers[0]
    led = Candidate(found, first.score, f"{first.method} and parts")
    unlike = [iou(_coarse(other.mask), _coarse(found)) < SAME for other in offers[1:]]
    others = [other for other, kept in zip(offers[1:], unlike, strict=True) if kept]
    # The last one is the mask with its shadow, where it has one.
    others = [*others[: CANDIDATES - 3], *others[CANDIDATES - 3 :][-1:]]
    # Masks that hardly differ come where there are not enough others.
    alike = [other for other, kept in zip(offers[1:], unlike, strict=True) if not kept]
    alike = alike[: CANDIDATES - 2 - len(others)]
    return (led, first, *others[:-1], *alike, *others[-1:])


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
    return off[1] > off[0] + ODD and off[1] > 1.0 and at_work("unusual parts")


def with_attached(
    image: Image, mask: BoolArray, grounding: Grounding, name: str = ""
) -> BoolArray | None:
    """The mask (H, W) with the parts attached to the thing; None where there is none to be seen.

    What holds a click outside, or lies outside of a box, is no part of it. name: of the thing;
    poles are looked for where things of it have some.
    """
    if not at_work("attached parts"):
        return None
    for_poles = looks_for_poles(name)
    for_poles = for_poles if for_poles and at_work("poles") else 0
    first = mask
    for _ in range(max(1, for_poles)):
        prepared = _around(image, mask, grounding, for_poles > 0)
        found = None if prepared is None else _grown(*prepared)
        if prepared is None or found is None:
            break
        mask = mask | _placed(found, prepared[0], mask.shape)
    return None if mask is first else _settled(image, mask)


def _settled(image: Image, mask: BoolArray) -> BoolArray:
    """The mask (H, W) with its outline, found on a small picture, moved to where colours part."""
    if not at_work("settled parts"):
        return mask
    x0, y0, x1, y1 = bounds(mask)
    band = max(BAND[0], round(BAND[1] * max(x1 - x0, y1 - y0)))
    return snapped(image, mask, band, UNFRAYED)


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


def _around(
    image: Image, mask: BoolArray, grounding: Grounding, has_poles: bool = False
) -> tuple[Around, IntArray] | None:
    """What lies around a mask, and the fine patches (h, w) of it; None for too small a mask."""
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
    # Edges are sought outside of Python, while the patches are put together.
    with ThreadPoolExecutor(1) as pool:
        edges = pool.submit(edges_of, colours)
        steps = steps_of(colours)
        fine = joined(patches_of(colours, steps), colours, steps, [FINE])[0]
        strips = strips_of(edges.result(), WIDE * float(np.sqrt(np.count_nonzero(own))))
    within = (left > 0, top > 0, right < mask.shape[1], low < mask.shape[0])
    own = np.asarray(own)
    focus = Focus(image[crop], own)
    around = Around(part, colours, steps, own, barred, strips, focus, has_poles, within)
    return around, fine


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


def _grown(around: Around, fine: IntArray) -> BoolArray | None:
    """The mask with its parts, at the size of the surroundings; None where it has none."""
    mask, fine = _snapped(fine, around.mask)
    if not mask.any():
        return None
    levels = [Parted.of(level) for level in joined(fine, around.lab, around.steps, LEVELS)]
    first = np.count_nonzero(mask)
    grown = Grown(mask, np.zeros_like(mask))
    while grown.turn < ROUNDS and np.count_nonzero(grown.mask) <= MOST * first:
        found = joining(around, grown, levels, LEAST * first)
        if found is None:
            break
        grown = grown.joined_by(found)
    return _closed(around.mask, grown.parts) if grown.turn else None


def _snapped(fine: IntArray, mask: BoolArray) -> tuple[BoolArray, IntArray]:
    """The mask as fine patches, and these: cut along it only where much lies on both sides."""
    count = int(fine.max()) + 1
    flat = fine.ravel()
    share = np.bincount(flat, mask.ravel(), count) / np.bincount(flat, minlength=count)
    wide = []
    for side in (mask, ~mask):
        reach = cv2.distanceTransform(side.astype(np.uint8), cv2.DIST_L2, 3)
        wide.append(np.bincount(flat[reach.ravel() > 2.5], minlength=count) > 0)
    cut = wide[0] & wide[1] & (share > 0.03) & (share < 0.97)
    out = np.where(cut[fine], mask, (share > 0.5)[fine])
    return out, renumbered(fine * 2 + out)


def _closed(mask: BoolArray, parts: BoolArray) -> BoolArray:
    """The mask and its parts, with what is between them where they nearly touch."""
    out = mask | parts
    closed = cv2.morphologyEx(out.astype(np.uint8), cv2.MORPH_CLOSE, disc(3)).astype(bool)
    return out | (closed & grow(mask, 3) & grow(parts, 3))
