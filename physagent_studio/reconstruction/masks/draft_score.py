"""How much a draft mask looks like the whole clicked object.

A linear score of features that any picture has. Its weights were fitted (ridge regression of
the IoU with reference masks, leaving one picture out at a time) on path-traced scenes and
photographs; agreement between drafts that were made in different ways carries most of it.
`benchmark.ranker` measures anew how well they carry over to a photograph that was left out.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from physagent_studio.reconstruction.photo.regions import (
    BoolArray,
    Pixel,
    border_share,
    bounds,
    grow,
    outline_length,
)
from physagent_studio.reconstruction.photo.statistics import lengths, median, percentile

FloatArray = NDArray[np.float64]
_SQUARE = np.ones((3, 3), np.uint8)
REGION = "region"
"""Family of drafts that have no say in how much others are parts or wholes."""
ALIKE = 0.85
"""IoU from which two drafts say the same."""

WEIGHTS = {
    "constant": 0.067,
    "consensus": 0.721,
    "agreement": 0.316,
    "covered agreement": 0.087,
    "colour overlap": -0.198,
    "contrast": 0.101,
    "border": -0.262,
    "window": 0.036,
    "log area": -0.155,
    "log area squared": -0.022,
    "off centre": -0.281,
    "holds others": -0.197,
    "held by others": -0.158,
}


@dataclass(frozen=True, eq=False, slots=True)
class Draft:
    """A candidate before it is scored.

    method: short name. family: methods of one family fail together, so that agreement across
    families counts apart. window_share: share of the outline along an artificial window's sides.
    """

    mask: BoolArray
    method: str
    family: str
    window_share: float = 0.0


class Scorer:
    """Scores drafts of one object on one picture; what was found of a draft is kept."""

    def __init__(self, lab: NDArray[np.float32], inside: Sequence[Pixel]) -> None:
        self.lab = lab
        self.inside = inside
        self.palette = _palette(lab)
        self.known: dict[int, tuple[Draft, dict[str, float]]] = {}
        self.shared = _Shared()

    def likeness(self, drafts: Sequence[Draft]) -> FloatArray:
        """(N, N) IoU of any two drafts."""
        return _iou_of(self.shared.of(drafts))

    def scores(self, drafts: Sequence[Draft]) -> FloatArray:
        """(N,) estimated IoU of each draft with the object, 0 … 1."""
        weights = np.array(list(WEIGHTS.values()))
        return np.clip((self.features(drafts) * weights).sum(1), 0.0, 1.0)

    def features(self, drafts: Sequence[Draft]) -> FloatArray:
        """(N, F) what is weighed of each draft, in the order of `WEIGHTS`."""
        out = np.zeros((len(drafts), len(WEIGHTS)))
        if not drafts:
            return out
        shared = self.shared.of(drafts)
        area = np.diag(shared).astype(float)
        alike = _iou_of(shared)
        family = np.array([draft.family for draft in drafts])
        # A region of one colour is often a part, and none the more a whole for being steady.
        voters = family != REGION
        count = max(int(voters.sum()), 1)
        for k, draft in enumerate(drafts):
            own = self.alone(draft)
            agreement = float(alike[k][voters & (family != family[k])].max(initial=0.0))
            within = shared[k] / np.maximum(area, 1)
            around = shared[k] / max(area[k], 1)
            holds = float(((within > 0.95) & (area < 0.7 * area[k]))[voters].sum()) / count
            held = float(((around > 0.95) & (area > 1.4 * area[k]))[voters].sum()) / count
            like = float((alike[k] > ALIKE)[voters].sum() - voters[k]) / count
            values = own | {
                "consensus": like,
                "agreement": agreement,
                "covered agreement": own["covered"] * agreement,
                "holds others": holds * own["weakest"],
                "held by others": held,
            }
            out[k] = [values[name] for name in WEIGHTS]
        return out

    def alone(self, draft: Draft) -> dict[str, float]:
        """Features that do not depend on the other drafts."""
        if id(draft) not in self.known:
            local = _local(self.lab, self.palette, draft.mask)
            area = float(np.log(np.count_nonzero(draft.mask) / draft.mask.size + 1e-4))
            covered, off = _clicks(draft.mask, self.inside)
            values = {
                "constant": 1.0,
                "colour overlap": local.overlap,
                "contrast": float(np.tanh(local.middle / 25)),
                "border": min(2 * border_share(draft.mask), 1.0),
                "window": min(3 * draft.window_share, 1.0),
                "log area": area,
                "log area squared": area**2,
                "off centre": off,
                "covered": covered,
                "weakest": float(np.tanh(local.weakest / 10)),
            }
            # The draft is kept with its features, so that its id stays its own.
            self.known[id(draft)] = (draft, values)
        return self.known[id(draft)][1]


class _Shared:
    """How many pixels any two drafts share; what was counted once is kept."""

    def __init__(self) -> None:
        self.drafts: dict[int, tuple[int, Draft]] = {}
        self.packed: list[NDArray[np.uint64]] = []
        self.counts = np.zeros((0, 0), np.int64)

    def of(self, drafts: Sequence[Draft]) -> NDArray[np.int64]:
        """(N, N) number of pixels that two of so many drafts share."""
        before = len(self.packed)
        for draft in drafts:
            if id(draft) not in self.drafts:
                # The draft is kept, so that its id stays its own.
                self.drafts[id(draft)] = (len(self.packed), draft)
                self.packed.append(_packed(draft.mask))
        if len(self.packed) > before:
            self._count(before)
        index = np.array([self.drafts[id(draft)][0] for draft in drafts], np.int64)
        return self.counts[np.ix_(index, index)]

    def _count(self, before: int) -> None:
        """Counts what the drafts from number `before` on share with all."""
        every = np.stack(self.packed)
        rows = [np.bitwise_count(row & every).sum(1, dtype=np.int64) for row in every[before:]]
        counts = np.zeros((len(every), len(every)), np.int64)
        counts[:before, :before] = self.counts
        counts[before:] = rows
        counts[:, before:] = counts[before:].T
        self.counts = counts


def _packed(mask: BoolArray) -> NDArray[np.uint64]:
    """A mask's pixels as bits."""
    bits = np.packbits(mask.ravel())
    return np.pad(bits, (0, -len(bits) % 8)).view(np.uint64)


def likeness(drafts: Sequence[Draft]) -> FloatArray:
    """(N, N) IoU of any two drafts."""
    return _iou_of(_Shared().of(drafts))


def _iou_of(shared: NDArray[np.int64]) -> FloatArray:
    area = np.diag(shared).astype(float)
    return shared / np.maximum(area[:, None] + area[None] - shared, 1)


@dataclass(frozen=True, slots=True)
class _Local:
    """middle, weakest: colour step across the outline (median, 20th percentile).

    overlap: of the colours inside and around, 0 … 1.
    """

    middle: float
    weakest: float
    overlap: float


def _local(lab: NDArray[np.float32], palette: NDArray, mask: BoolArray) -> _Local:
    x0, y0, x1, y1 = bounds(mask)
    crop = (slice(max(0, y0 - 12), y1 + 12), slice(max(0, x0 - 12), x1 + 12))
    own = np.ascontiguousarray(mask[crop])
    middle, weakest = outline_contrast(np.ascontiguousarray(lab[crop]), own)
    area = int(np.count_nonzero(own))
    ring = grow(own, max(3, int(np.sqrt(area) * 0.12))) & ~grow(own, 1)
    inside = np.bincount(palette[crop][own], minlength=2048) / max(area, 1)
    around = np.bincount(palette[crop][ring], minlength=2048) / max(np.count_nonzero(ring), 1)
    return _Local(middle, weakest, float(np.sqrt(inside * around).sum()))


def _palette(lab: NDArray[np.float32]) -> NDArray[np.int64]:
    """Each pixel's colour as one of 2048 bins."""
    q = np.clip((lab / 256 * (8, 16, 16)).astype(int), 0, (7, 15, 15))
    return (q[..., 0] * 16 + q[..., 1]) * 16 + q[..., 2]


def _clicks(mask: BoolArray, inside: Sequence[Pixel]) -> tuple[float, float]:
    """Share of the clicks that the mask covers, and how far off its middle they are, in x."""
    if not inside:
        return 1.0, 0.0
    rows, columns = mask.shape
    hits = [mask[int(min(rows - 1, y)), int(min(columns - 1, x))] for x, y in inside]
    x0, _, x1, _ = bounds(mask)
    off = abs(float(np.mean([x for x, _ in inside])) - (x0 + x1) / 2) / max(x1 - x0, 1)
    return float(np.mean(hits)), min(off, 0.6)


def outline_contrast(lab: NDArray[np.float32], mask: BoolArray) -> tuple[float, float]:
    """Median and 20th percentile, along the outline, of the colour step across it."""
    solid = mask.astype(np.uint8)
    inner = mask & ~cv2.erode(solid, _SQUARE, iterations=3).astype(bool)
    core = cv2.erode(solid, _SQUARE).astype(bool)
    # A thin part has no core: its own pixels have to do.
    inner = np.where(cv2.boxFilter(core.astype(np.float32), -1, (5, 5)) > 0, inner & core, inner)
    outer = cv2.dilate(solid, _SQUARE, iterations=4).astype(bool)
    outer &= ~cv2.dilate(solid, _SQUARE).astype(bool)
    if np.count_nonzero(inner) < 8 or np.count_nonzero(outer) < 8:
        return 0.0, 0.0
    within, beyond = (_sums_about(lab, region) for region in (inner, outer))
    rim = mask & ~core
    rim[:2] = rim[-2:] = False
    rim[:, :2] = rim[:, -2:] = False
    rim &= (within[1] > 0) & (beyond[1] > 0)
    if np.count_nonzero(rim) < 8:
        return 0.0, 0.0
    inside, outside = (total[rim] / count[rim][:, None] for total, count in (within, beyond))
    step = np.sort(lengths(inside - outside))
    return median(step), percentile(step, 20)


def _sums_about(lab: NDArray[np.float32], region: BoolArray) -> tuple[NDArray, NDArray]:
    """Sum (H, W, 3) of the colours of a region near each pixel, and how many (H, W) they are."""
    weight = region.astype(np.float32)
    count = cv2.boxFilter(weight, -1, (9, 9), normalize=False)
    own = cv2.copyTo(lab, region.view(np.uint8))
    total = cv2.boxFilter(own, -1, (9, 9), normalize=False)
    return np.asarray(total), np.asarray(count)


def window_share(mask: BoolArray, box: tuple[int, int, int, int]) -> float:
    """Share of the outline that runs along a window's sides that are not the picture's."""
    rows, columns = mask.shape
    x0, y0, x1, y1 = box
    touching = 0
    if y0 > 2:
        touching += np.count_nonzero(mask[y0 : y0 + 2, x0:x1].any(0))
    if y1 < rows - 2:
        touching += np.count_nonzero(mask[y1 - 2 : y1, x0:x1].any(0))
    if x0 > 2:
        touching += np.count_nonzero(mask[y0:y1, x0 : x0 + 2].any(1))
    if x1 < columns - 2:
        touching += np.count_nonzero(mask[y0:y1, x1 - 2 : x1].any(1))
    return float(touching) / max(outline_length(mask), 1.0)
