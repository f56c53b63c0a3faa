"""Things found without a click: what stands out is held against what the words ask for.

Blobs come from the colours that are asked for and from what differs from the picture's rim; each
is graded for each thing, and the best assignment is proposed. A proposal is clear only where it
fits well and nothing else fits about as well; otherwise a person has to say.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import combinations

import cv2
import numpy as np
from numpy.typing import NDArray
from scipy.optimize import linear_sum_assignment

from physagent_studio.knowledge import kind_of, material_words, materials, usual_size
from physagent_studio.language.sought import Sought
from physagent_studio.reconstruction.grounding.blobs import Blob, blobs_of
from physagent_studio.reconstruction.photo.colours import likeness
from physagent_studio.reconstruction.photo.regions import (
    FloatArray,
    grow,
)
from physagent_studio.records.case import Image


@dataclass(frozen=True, slots=True)
class ProposalSettings:
    """When a place is proposed without a question."""

    longest_side_px: int = 200  # 100..400: of so small a picture texture is gone
    min_grade: float = 0.6  # grade, 0.3..0.9: of a clear proposal
    min_lead: float = 0.15  # grade, 0.05..0.5: by which the next free place must be worse
    max_shown: int = 4  # count, 1..9: places on offer for a thing: a person looks at all of them


PROPOSAL = ProposalSettings()


@dataclass(frozen=True, slots=True)
class Spot:
    """Where a thing may be: a pixel well inside it, its box (x0, y0, x1, y1), grade 0 … 1."""

    x: float
    y: float
    box: tuple[float, float, float, float]
    grade: float


@dataclass(frozen=True, slots=True)
class Proposed:
    """Where a thing may be, best first; clear: whether the first can be used unasked."""

    name: str
    spots: tuple[Spot, ...]
    clear: bool


def propose(image: Image, wanted: Sequence[Sought]) -> tuple[Proposed, ...]:
    """Where each wanted thing may be; no two get the same first place.

    Repeats to the bit.

    Spots are in pixels of `image`.
    """
    if not wanted:
        return ()
    factor = min(1.0, PROPOSAL.longest_side_px / max(image.shape[:2]))
    small = cv2.resize(image, None, fx=factor, fy=factor, interpolation=cv2.INTER_AREA)
    small = np.ascontiguousarray(small).astype(np.uint8)
    lab = cv2.cvtColor(cv2.GaussianBlur(small, (0, 0), 1.0), cv2.COLOR_RGB2LAB).astype(np.float32)
    maps = {item.name: likeness(small, _colours(item)) for item in wanted if _colours(item)}
    blobs = blobs_of(lab, maps)
    if not blobs:
        return tuple(Proposed(item.name, (), False) for item in wanted)
    grades = np.array([[_grade(item, blob, maps, lab.shape) for blob in blobs] for item in wanted])
    _by_order(grades, wanted, blobs, lab.shape)
    chosen = _assigned(grades)
    _by_base(grades, wanted, blobs, chosen)
    chosen = _assigned(grades)
    return tuple(_all_or_none(_told_apart(wanted, grades, blobs, chosen, factor), wanted))


def _told_apart(
    wanted: Sequence[Sought],
    grades: NDArray,
    blobs: Sequence[Blob],
    chosen: Mapping[int, int],
    factor: float,
) -> list[Proposed]:
    """The proposals; only the place of a thing that is clear is none for the others."""
    clear = set(chosen)
    while True:
        taken = {chosen[k] for k in clear}
        made = [
            _proposed(item, row, blobs, chosen.get(index), taken, factor)
            for index, (item, row) in enumerate(zip(wanted, grades, strict=True))
        ]
        still = {k for k in clear if made[k].clear}
        still -= _mixed_up(grades, {k: chosen[k] for k in still})
        if still == clear:
            return [replace(one, clear=k in clear) for k, one in enumerate(made)]
        clear = still


def _colours(item: Sought) -> tuple[str, ...]:
    """Colour words for a thing: said, or suggested by its name or what it is made of."""
    if item.colours:
        return item.colours
    for word in item.name.split("_"):
        made = materials().get(material_words().get(word, ""))
        if made is not None and made.colours:
            return made.colours
    kind = kind_of(item.head)
    return () if kind is None else kind.colours


# --- grades ------------------------------------------------------------------------------------


def _grade(
    item: Sought, blob: Blob, maps: Mapping[str, FloatArray], shape: tuple[int, ...]
) -> float:
    """How well a blob fits a thing, 0 … 1."""
    parts = [(0.3, blob.contrast), (0.12, _size_fit(blob.area))]
    found = maps.get(item.name)
    if found is not None:
        said = 0.45 if item.colours else 0.25
        ring = grow(blob.mask, 4) & ~grow(blob.mask, 1)
        inside = float(found[blob.mask].mean())
        beyond = float(found[ring].mean()) if ring.any() else 0.0
        parts.append((said, inside * (1 - 0.6 * beyond)))
    usual = usual_size(item.head).shapes[:1]
    if usual == ("sphere",):
        parts.append((0.25, blob.round))
    elif usual == ("capsule",):
        parts.append((0.25, blob.long))
    if item.side:
        parts.append((0.15, _side_fit(item.side, blob, shape)))
    return sum(weight * value for weight, value in parts) / sum(weight for weight, _ in parts)


def _size_fit(area: float) -> float:
    """Things that a sentence speaks of take about a hundredth of the picture, more or less."""
    return float(np.exp(-0.5 * (np.log(area / 0.015) / 1.4) ** 2))


def _side_fit(side: str, blob: Blob, shape: tuple[int, ...]) -> float:
    x = (blob.box[0] + blob.box[2]) / 2 / shape[1]
    y = (blob.box[1] + blob.box[3]) / 2 / shape[0]
    middle = 1 - 2 * abs(x - 0.5)
    return {"left": 1 - x, "right": x, "top": 1 - y, "bottom": y, "middle": middle}[side]


def _by_order(
    grades: NDArray, wanted: Sequence[Sought], blobs: Sequence[Blob], shape: tuple[int, ...]
) -> None:
    """The large, the small, the left one of a kind: in order, of those that fit about as well."""
    for row, item in zip(grades, wanted, strict=True):
        near = [int(k) for k in np.flatnonzero(row > row.max() - 0.15)]
        if item.size:
            _ranked(row, sorted(near, key=lambda k: blobs[k].area * item.size), 0.1)
        if item.side:
            _ranked(row, sorted(near, key=lambda k: _side_fit(item.side, blobs[k], shape)), 0.15)


def _ranked(row: NDArray, order: Sequence[int], most: float) -> None:
    """Grades raised by up to `most`, the last of `order` by all of it."""
    for rank, k in enumerate(order):
        row[k] += most * rank / max(len(order) - 1, 1)


def _by_base(
    grades: NDArray, wanted: Sequence[Sought], blobs: Sequence[Blob], chosen: Mapping[int, int]
) -> None:
    """Things that rest on another: those blobs gain that stand on where it was found."""
    for index, item in enumerate(wanted):
        base = next(
            (k for k, other in enumerate(wanted) if item.on and other.head == item.on), None
        )
        if base is None or base == index or base not in chosen:
            continue
        x0, y0, x1, _ = blobs[chosen[base]].box
        for k, blob in enumerate(blobs):
            middle = (blob.box[0] + blob.box[2]) / 2
            above = abs(blob.box[3] - y0) < 0.4 * (blob.box[3] - blob.box[1]) + 4
            grades[index, k] += 0.2 if above and x0 <= middle <= x1 else -0.1


def _assigned(grades: NDArray) -> dict[int, int]:
    """The blob of each thing such that all fit best together."""
    things, blobs = linear_sum_assignment(-grades)
    return {int(a): int(b) for a, b in zip(things, blobs, strict=True)}


def _proposed(
    item: Sought,
    row: NDArray,
    blobs: Sequence[Blob],
    first: int | None,
    taken: set[int],
    factor: float,
) -> Proposed:
    """One thing's places. first: the blob that it got. taken: blobs that are clearly others."""
    if first is None:
        return Proposed(item.name, (), False)
    order = [int(k) for k in np.argsort(-row, kind="stable") if int(k) != first]
    free = [k for k in order if k not in taken and not _same_place(blobs[k], blobs[first])]
    rest = float(row[free[0]]) if free else 0.0
    clear = bool(
        _is_told(item) and row[first] > PROPOSAL.min_grade and row[first] - rest > PROPOSAL.min_lead
    )
    shown = [first]
    for k in free:
        if not any(_same_place(blobs[k], blobs[other]) for other in shown):
            shown.append(k)
    spots = (_spot(blobs[k], float(row[k]), factor) for k in shown[: PROPOSAL.max_shown])
    return Proposed(item.name, tuple(spots), clear)


def _mixed_up(grades: NDArray, chosen: Mapping[int, int]) -> set[int]:
    """Things that fit the places of one another about as well as their own: a tree and a plant."""
    found: set[int] = set()
    for (one, a), (other, b) in combinations(chosen.items(), 2):
        kept, swapped = grades[one, a] + grades[other, b], grades[one, b] + grades[other, a]
        if kept - swapped < PROPOSAL.min_lead:
            found |= {one, other}
    return found


def _all_or_none(made: Sequence[Proposed], wanted: Sequence[Sought]) -> list[Proposed]:
    """Things that are called alike are clear together: else they may be mixed up."""
    kinds = [(item.head, item.colours) for item in wanted]
    unclear = {kind for one, kind in zip(made, kinds, strict=True) if not one.clear}
    return [
        replace(one, clear=one.clear and kind not in unclear)
        for one, kind in zip(made, kinds, strict=True)
    ]


def _is_told(item: Sought) -> bool:
    """Whether the words say enough to know the thing by: a colour, or a kind that has one."""
    return bool(item.colours or getattr(kind_of(item.head), "colours", ()))


def _same_place(one: Blob, other: Blob) -> bool:
    """Whether two blobs are readings of the same thing: one holds most of the other."""
    shared = int(np.count_nonzero(one.mask & other.mask))
    smaller = min(np.count_nonzero(one.mask), np.count_nonzero(other.mask))
    return bool(shared > 0.6 * smaller)


def _spot(blob: Blob, grade: float, factor: float) -> Spot:
    depth = cv2.distanceTransform(np.pad(blob.mask, 1).astype(np.uint8), cv2.DIST_L2, 5)[1:-1, 1:-1]
    row, column = divmod(int(depth.argmax()), depth.shape[1])
    x0, y0, x1, y1 = (round(value / factor, 1) for value in blob.box)
    return Spot(
        round((column + 0.5) / factor, 1),
        round((row + 0.5) / factor, 1),
        (x0, y0, x1, y1),
        round(float(np.clip(grade, 0, 1)), 3),
    )
