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

from physagent_studio.reconstruction.masks import BoolArray, grow
from physagent_studio.reconstruction.segmentation_beside import Parted, ground_of, patches_beside
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
from physagent_studio.reconstruction.segmentation_shafts import Strips, runs_on, shafts_beside

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
HIGH = 0.08
"""Lowness up to which a patch is no shadow."""
NARROW, SEAM, NECK = 4.2, 0.62, -0.22
"""Pixels across the widest place of a part, share of its outline at the mask, and contact (log, as
`Outline.neck`) by which it is but a seam along the outline, or hardly touches."""
UNSEEN, UNSEEN_LEAST = -7.0, 0.02
"""Log share of its colours elsewhere below which they are seen nowhere else, and share of the
mask's area from which that counts as much for a patch as prolonging does for a shaft."""
COMMON = -4.1
"""Log share of its colours elsewhere from which a patch is like what is around."""
BLURRED, SOFT = 2.4, 1.9
"""Sharpness (log, as `Outline.sharp`) below which a patch, and one between two edges, has none."""


@dataclass(frozen=True, eq=False, slots=True)
class Around:
    """A mask and its surroundings at the size where parts are sought.

    part: (x0, y0, x1, y1) of the picture. lab (h, w, 3), steps, mask, barred (h, w), strips: of
    that part. slender: whether things of its name are made of poles or have one. within: whether
    the picture goes on to the left, above, to the right and below.
    """

    part: tuple[int, int, int, int]
    lab: NDArray[np.float32]
    steps: NDArray[np.float32]
    mask: BoolArray
    barred: BoolArray
    strips: Strips
    slender: bool
    within: tuple[bool, bool, bool, bool]


@dataclass(frozen=True, eq=False, slots=True)
class Grown:
    """The mask (h, w) so far, those of its parts that joined, and how often some did."""

    mask: BoolArray
    parts: BoolArray
    turn: int = 0

    def joined_by(self, found: BoolArray) -> Grown:
        """With further parts."""
        return Grown(self.mask | found, self.parts | found, self.turn + 1)


def joining(
    around: Around, so_far: Grown, levels: Sequence[Parted], least: float
) -> BoolArray | None:
    """(h, w) the clearest parts that touch the mask, none beside another; None without any.

    levels: patches of growing size. least: pixels of a part.
    """
    mask = so_far.mask
    here = Surroundings(around.lab, around.steps, mask, ground_of(levels[-1].labels, mask))
    kept, values = [], []
    for patch, is_shaft in _beside(around, here, levels, least):
        outline = outline_of(patch, here)
        if _no_form(outline, SOFT if is_shaft and around.slender else BLURRED):
            continue
        prolongs = outline.touching < LEAVING and lowness(patch, here) < HIGH
        prolongs = prolongs and runs_on(patch, mask)
        slender = prolongs or outline.width < SLENDER * here.size
        if len(patch.rows) > (LONGEST if slender else LARGEST) * here.area:
            continue
        colours = colours_of(patch, here)
        pole = is_shaft and around.slender and _is_pole(patch, outline)
        if not pole and _ruled_out(patch, here, outline, colours):
            continue
        found = features_of(patch, here, outline, colours)
        if is_shaft:
            asked = _of_shaft(patch, outline, found["low"], around.slender, so_far)
        else:
            slim = outline.width < SLENDER * here.size / 2
            asked = _of_patch(patch, slim, prolongs, so_far)
            if colours.others < UNSEEN and len(patch.rows) > UNSEEN_LEAST * here.area:
                asked = min(asked, STRAIGHT)
        value = float(scores([found])[0])
        if asked is not None and value > asked:
            kept.append(patch.region)
            values.append(value - CRUDER * is_shaft)
    out = np.zeros_like(mask)
    for k in np.argsort(-_for_larger(kept, np.array(values)), kind="stable"):
        if not (out & grow(kept[int(k)], 2)).any():
            out |= kept[int(k)]
    return out if out.any() else None


def _beside(
    around: Around, here: Surroundings, levels: Sequence[Parted], least: float
) -> Iterator[tuple[Patch, bool]]:
    """Each patch and shaft beside the mask, and whether it is a shaft."""
    for patch in patches_beside(around.barred, here, levels, least, LONGEST * here.area):
        yield patch, False
    # A pole may leave what is looked at, if not the picture.
    open_ = around.within if around.slender else (False, False, False, False)
    for shaft in shafts_beside(around.strips, here.mask, around.barred, open_):
        if len(shaft.rows) >= least:
            yield shaft, True


def _of_patch(patch: Patch, slim: bool, prolongs: bool, so_far: Grown) -> float:
    """The score that is asked of a patch: less where it prolongs the thing or a slender part."""
    if prolongs:
        return PROLONGING
    if slim and _hangs_on(patch.region, so_far):
        return CLEAR
    return CLEAR + CLEARER * so_far.turn


def _of_shaft(
    patch: Patch, outline: Outline, low: float, slender: bool, so_far: Grown
) -> float | None:
    """The score that is asked of a shaft; None where it is no part however clear.

    low: 0, or less for what lies low. slender: whether the thing is made of poles.
    """
    leaves = outline.touching < END
    if low < 0 or not (slender or leaves):
        return None
    straight_on = leaves and runs_on(patch, so_far.mask)
    if not slender:
        return STRAIGHT if straight_on else None
    # Once some have joined, what is behind comes close to them: others go on from these.
    pole = _is_pole(patch, outline) and (straight_on or not so_far.parts.any())
    return OF_POLES if pole else CLEAR + CLEARER * so_far.turn


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


def _ruled_out(patch: Patch, here: Surroundings, outline: Outline, colours: Colours) -> bool:
    """Whether a patch is what is seen all around, or may be a shadow."""
    more = colours.own - colours.others
    if (colours.others > COMMON and more < 0.15) or (colours.others > -5.2 and more < -1.2):
        return True
    if lowness(patch, here) <= HIGH:
        return False
    # A shadow is soft, darker than the ground in its own tint, and lies flat.
    seen = colours.tint > 12 or colours.darker < -8 or patch.tall > TALL
    flat = shade_of(colours) > 0.25 and patch.tall < TALL
    return outline.sharp < 2.9 or not seen or flat
