"""What joins a mask next: patches and shafts beside it, weighed against what is asked of each.

A part bulges from the thing or prolongs it, so that the outline runs on smoothly: of such a patch
least is asked. Of what touches only what joined before, more is. What may be a shadow, is as
common as the ground or has no outline of its own is ruled out whatever else speaks for it.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from physagent_studio.reconstruction.masks.parts.evidence import (
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
from physagent_studio.reconstruction.masks.parts.focus import Focus
from physagent_studio.reconstruction.masks.parts.patches_beside import (
    Parted,
    ground_of,
    patches_beside,
)
from physagent_studio.reconstruction.masks.parts.shafts import Strips, runs_on, shafts_beside
from physagent_studio.reconstruction.photo.regions import BoolArray, bounds, grow
from physagent_studio.reconstruction.switches import at_work

CLEAR, CLEARER = 0.85, 0.25
"""Score from which a part joins, and how much more is asked of those that touch it only then."""
LEAST, LARGEST, LONGEST = 0.002, 0.26, 0.5
"""Share of the mask's area between which a part is, and below which a slender or prolonging one."""
SLENDER = 0.3
"""Width of a slender part over the side of a square of the mask's area."""
PROLONGING, LEAVING = -0.5, 0.35
"""Score from which a patch joins that prolongs the thing, and its outline at the mask at most."""
STRAIGHT, OF_POLES = 0.3, -1.5
"""Score from which a shaft joins that prolongs a thing, and one on a thing made of poles."""
POLE, END = 2.5, 0.55
"""Length over width of a pole at least, and share of a shaft's outline at the mask at most."""
CRUDER = 1.0
"""How much clearer a shaft is than a patch that it takes the place of, whose outline is finer."""
NEARLY, MUCH = 0.5, 3.0
"""How much less clear a patch may be than one inside of it that is so many times smaller."""
FRESH = 5
"""Pixels around what joined last within which others are weighed again."""
HIGH = 0.08
"""Lowness up to which a patch is no shadow."""
FOCUSED = 1.0
"""How much less is asked of a patch that is in focus before what is not."""
LOW = 0.4
"""Lowness from which it is the ground that softens a patch's outline."""
NARROW, SEAM, NECK = 4.2, 0.62, -0.22
"""Pixels across the widest place of a part, share of its outline at the mask, and contact (log, as
`Outline.neck`) by which it is but a seam along the outline, or hardly touches."""
UNSEEN, UNSEEN_LEAST = -7.0, 0.02
"""Log share of its colours elsewhere below which they are seen nowhere else, and share of the
mask's area from which that counts as much for a patch as prolonging does for a shaft."""
COMMON = -4.1
"""Log share of its colours elsewhere from which a patch is like what is around."""
ON_TOP, SEEN_AROUND, CAP, ALONG = 2.3, -3.7, 0.15, 0.4
"""Score from which a patch on the top joins though its colours are seen around, log share of these
elsewhere from which it does not, how far down the top goes, and share of the patch's outline at
the mask at least: a pale lid before a pale street."""
SHADE = 0.25
"""Shade (see `shade_of`) from which a patch may be a shadow."""
BLURRED, SOFT = 2.4, 1.9
"""Sharpness (log, as `Outline.sharp`) below which a patch, and one between two edges, has none."""


@dataclass(frozen=True, eq=False, slots=True)
class Around:
    """A mask and its surroundings at the size where parts are sought.

    part: (x0, y0, x1, y1) of the picture. lab (h, w, 3), steps, mask, barred (h, w), strips, focus:
    of that part. has_poles: whether things of its name do. within: whether
    the picture goes on to the left, above, to the right and below.
    """

    part: tuple[int, int, int, int]
    lab: NDArray[np.float32]
    steps: NDArray[np.float32]
    mask: BoolArray
    barred: BoolArray
    strips: Strips
    focus: Focus
    has_poles: bool
    within: tuple[bool, bool, bool, bool]


@dataclass(frozen=True, eq=False, slots=True)
class Grown:
    """The mask (h, w) so far, those of its parts that joined, the last of them, and how often."""

    mask: BoolArray
    parts: BoolArray
    last: BoolArray | None = None
    turn: int = 0

    def joined_by(self, found: BoolArray) -> Grown:
        """With further parts."""
        return Grown(self.mask | found, self.parts | found, found, self.turn + 1)


def joining(
    around: Around, so_far: Grown, levels: Sequence[Parted], least: float
) -> BoolArray | None:
    """(h, w) the clearest parts that touch the mask, none beside another; None without any.

    levels: patches of growing size. least: pixels of a part.
    """
    mask = so_far.mask
    here = Surroundings(around.lab, around.steps, mask, ground_of(levels[-1].labels, mask))
    kept, values = [], []
    # What has been weighed and does not touch what joined since is no clearer than it was.
    fresh = None if so_far.last is None else grow(so_far.last, FRESH)
    for patch, is_shaft in _beside(around, here, levels, least, fresh):
        value = _weighed(patch, is_shaft, around, here, so_far)
        if value is not None and (not is_shaft or at_work("shafts")):
            kept.append(patch.region)
            values.append(value)
    out = np.zeros_like(mask)
    for k in np.argsort(-_for_larger(kept, np.array(values)), kind="stable"):
        if not (out & grow(kept[int(k)], 2)).any():
            out |= kept[int(k)]
    return out if out.any() else None


def _beside(
    around: Around,
    here: Surroundings,
    levels: Sequence[Parted],
    least: float,
    about: BoolArray | None,
) -> Iterator[tuple[Patch, bool]]:
    """Each patch and shaft beside the mask, and whether it is a shaft.

    about: (h, w) where those are that are wanted; None for everywhere.
    """
    sizes = (least, LONGEST * here.area)
    for patch in patches_beside(around.barred, here, levels, sizes, about):
        yield patch, False
    # A pole may leave what is looked at, if not the picture.
    open_ = around.within if around.has_poles else (False, False, False, False)
    for shaft in shafts_beside(around.strips, here.mask, around.barred, open_, about):
        if len(shaft.rows) >= least:
            yield shaft, True


def _weighed(
    patch: Patch, is_shaft: bool, around: Around, here: Surroundings, so_far: Grown
) -> float | None:
    """By how much a patch or shaft comes before others; None for what is no part.

    Whether the outline runs on is looked at last, and only where it decides.
    """
    outline = outline_of(patch, here)
    if _no_form(outline, SOFT if is_shaft and around.has_poles else BLURRED):
        return None
    leaves = outline.touching < LEAVING and lowness(patch, here) < HIGH
    share = len(patch.rows) / here.area
    large = share > (LONGEST if outline.width < SLENDER * here.size else LARGEST)
    if share > LONGEST or (large and not leaves):
        return None
    colours = colours_of(patch, here)
    pole = is_shaft and around.has_poles and _is_pole(patch, outline)
    ruled_out = not pole and _ruled_out(patch, here, outline, colours)
    if ruled_out and not (outline.touching > ALONG and _is_on_top(patch, here, colours)):
        return None
    found = features_of(patch, here, outline, colours)
    value = float(scores([found])[0])
    if ruled_out and value < ON_TOP:
        return None
    if large and not runs_on(patch, here.mask):
        return None
    if is_shaft:
        joins = _shaft_joins(value, patch, outline, found["low"], around.has_poles, so_far)
        value -= CRUDER
    else:
        unseen = colours.others < UNSEEN and share > UNSEEN_LEAST
        unseen = unseen and at_work("rare colours")
        asked = STRAIGHT if unseen else _of_patch(patch, outline, here, so_far)
        joins = value > asked or (
            leaves
            and value > PROLONGING
            and (large or runs_on(patch, here.mask))
            and at_work("prolonging parts")
        )
        if not joins and share > UNSEEN_LEAST and value > asked - FOCUSED:
            joins = around.focus.stands_out(patch) and at_work("focus")
    # Where a thing stands on the ground, its shadow softens every edge.
    lost = joins and lowness(patch, here) < LOW and around.focus.is_lost(patch)
    return value if joins and not (lost and at_work("focus")) else None


def _of_patch(patch: Patch, outline: Outline, here: Surroundings, so_far: Grown) -> float:
    """The score that is asked of a patch that does not prolong the thing."""
    if outline.width < SLENDER * here.size / 2 and _hangs_on(patch.region, so_far):
        return CLEAR
    return CLEAR + CLEARER * so_far.turn


def _shaft_joins(
    value: float, patch: Patch, outline: Outline, low: float, has_poles: bool, so_far: Grown
) -> bool:
    """Whether a shaft of that score is a part.

    low: 0, or less for what lies low. has_poles: whether things of that name do.
    """
    if low < 0:
        return False
    if not has_poles:
        return outline.touching < END and value > STRAIGHT and runs_on(patch, so_far.mask)
    if value > CLEAR + CLEARER * so_far.turn:
        return True
    # Once some have joined, what is behind comes close to them: others go on from these.
    pole = value > OF_POLES and _is_pole(patch, outline)
    return pole and (not so_far.parts.any() or runs_on(patch, so_far.mask))


def _is_pole(patch: Patch, outline: Outline) -> bool:
    """Whether a shaft is long and touches the mask with its end."""
    return outline.touching < END and len(patch.rows) > POLE * outline.width**2


def _for_larger(regions: Sequence[BoolArray], values: NDArray[np.float64]) -> NDArray[np.float64]:
    """Values (N,) by which a patch comes before small ones inside of it that are hardly clearer."""
    area = [int(np.count_nonzero(region)) for region in regions]
    out = values.copy()
    for large in np.argsort(values, kind="stable"):
        for small in range(len(regions)):
            nearly = 0 < values[small] - values[large] < NEARLY and area[large] > MUCH * area[small]
            if nearly and (regions[small] & regions[large]).sum() > 0.8 * area[small]:
                out[large] = max(out[large], values[small] + 1e-9 * area[large])
    return out


def _hangs_on(region: BoolArray, so_far: Grown) -> bool:
    """Whether a part touches the mask where another part has joined it."""
    contact = grow(region, 2) & so_far.mask
    shared = int(np.count_nonzero(contact & so_far.parts))
    return shared > 0.8 * max(int(np.count_nonzero(contact)), 1)


def _no_form(outline: Outline, blurred: float) -> bool:
    """Whether a patch is a seam, hardly touches or has no outline."""
    if outline.touching > SEAM or outline.neck < NECK or outline.width < NARROW:
        return True
    return outline.sharp < blurred


def _is_on_top(patch: Patch, here: Surroundings, colours: Colours) -> bool:
    """Whether a patch lies on the top of the thing and is no shade of the ground."""
    left, top, right, low = bounds(here.mask)
    within = patch.columns.min() >= left - 2 and patch.columns.max() < right + 2
    on_top = within and patch.rows.max() < top + CAP * (low - top)
    seen = colours.others < SEEN_AROUND and shade_of(colours) <= SHADE
    return bool(on_top) and seen and at_work("caps")


def _ruled_out(patch: Patch, here: Surroundings, outline: Outline, colours: Colours) -> bool:
    """Whether a patch is what is seen all around, or may be a shadow."""
    more = colours.own - colours.others
    if (colours.others > COMMON and more < 0.15) or (colours.others > -5.2 and more < -1.2):
        return True
    if lowness(patch, here) <= HIGH:
        return False
    # A shadow is soft, darker than the ground in its own tint, and lies flat.
    seen = colours.tint > 12 or colours.darker < -8 or patch.tall > TALL
    flat = shade_of(colours) > SHADE and patch.tall < TALL
    return outline.sharp < 2.9 or not seen or flat
