"""A hole filled with a few large pieces of the picture, joined by their gradients."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Self

import cv2
import numpy as np
from numpy.typing import NDArray

from physagent_studio.arrays import FloatArray, FloatImage, IntArray
from physagent_studio.reconstruction.background.graph_cut import CUT, Grid, choose
from physagent_studio.reconstruction.background.harmonic_fill import nearest_along
from physagent_studio.reconstruction.background.poisson_blend import (
    View,
    blocked,
    joined,
    sources,
    taken,
)
from physagent_studio.reconstruction.background.shift_map import (
    bent,
    level_shifts,
    rescaled,
    shift,
    shifts_in,
)
from physagent_studio.reconstruction.background.smooth_fill import smooth_fill
from physagent_studio.reconstruction.background.structure import Structure
from physagent_studio.reconstruction.photo.regions import BoolArray, bounds, grow
from physagent_studio.reconstruction.switches import at_work


@dataclass(frozen=True, slots=True)
class MosaicSettings:
    """What pieces are chosen from, and what each costs, in grey levels of three colours."""

    max_places: int = 3200  # count, 500..10000: on which pieces are chosen
    max_copies: int = 40  # count, 10..100: that are weighed against one another
    # price, 20..300: of the smooth fill, however rough the photo is
    max_smooth_price: float = 110.0
    # 0.1..2: of the hole's extent, by which copies are shifted along lines
    along_shares: tuple[float, float, float] = (0.3, 0.6, 1.05)
    rim_factor: float = 3.0  # 1..10: of a mismatch at the rim beside one at a seam
    max_rim_price: float = 900.0  # price, 200..3000: something there may not belong
    # 1..5: spread, in places, of the blur in which colours are held against what is expected
    soft_count: float = 2.0
    # 0.05..0.5: of the hole's extent, along rows and across, that tell how rough it is
    broad_shares: tuple[float, float] = (0.25, 0.1)
    # 0.005..0.1: of what is around, on its own side, to be counted alone
    little_share: float = 0.02
    stray_levels: float = 16.0  # 4..40: by which colours may be off on bare ground at no cost
    max_stray_levels: float = 100.0  # 40..200: the same on patterned ground
    off_factor: float = 2.0  # 0.5..5: of a difference in brightness, and of one in colour beyond it
    max_strayed_price: float = 80.0  # price, 20..300: of colours that are farther off
    # price, 10..200: of what is copied over a line: it is part of something else
    beyond_price: float = 60.0
    # 0.5..5: of the photo's roughness beside, for the price of the smooth fill
    smooth_factor: float = 3.0
    unusual_factor: float = 3.0  # 1.5..10: of what is usual around, for a thing that stands out
    # price, 40..600: of what is copied from another face of a table or ramp that the picture shows
    other_face_price: float = 250.0
    far_price: float = 6.0  # price, 0..20: of a copy from one hole's size away
    # price, 0..30: from above or below: walls, floors and tables run across pictures
    height_price: float = 8.0
    # price, 0..50: of a copy sheared or stretched by its own extent: grass would be combed
    bent_price: float = 10.0
    little_bent_ratio: float = 0.4  # 0..1: by which it may be at no cost
    # price, 0..100: beyond the next: what stands up is drawn out to wedges
    torn_price: float = 40.0
    much_bent_ratio: float = 1.5  # 0.5..3: by which it is torn
    coarser_price: float = 12.0  # price, 0..40: of a copy that has to be enlarged twice


MOSAIC = MosaicSettings()


def mosaic(
    part: FloatImage,
    missing: BoolArray,
    barred: BoolArray,
    structure: Structure,
    level: FloatArray | None,
    share: float = 1.0,
    faces: IntArray | None = None,
) -> FloatImage:
    """The picture (H, W, 3) with its hole (H, W) filled.

    barred: (H, W) the hole and what else shall not be copied. structure: what is known
    to go on behind the hole. level: (3, 3) from pixels to a level plane, None for unknown. share:
    how much care it may take, 1 for a lone hole. faces: (H, W) as `surfaces` gives them.
    """
    finding_px = 220  # 100..500: longer side of the picture in which candidates are looked for
    picture = View.of(part, missing, barred, finding_px)
    guess = nearest_along(picture.image, picture.barred, structure.scaled(picture.ratio))
    wide = cv2.resize(guess, missing.shape[::-1], interpolation=cv2.INTER_LINEAR)
    part = np.where(barred[..., None], wide, part).astype(np.float32)
    copies = _candidates(picture, missing, structure, level)
    even = smooth_fill(part, missing, barred, structure)
    if not copies:
        return even
    fine = View.of(part, missing, barred, _fine(missing, share))
    label, used = _laid(fine, even, structure, copies, faces)
    chosen = [copies[k] if k < len(copies) else None for k in used]
    return joined(part, missing, barred, label, chosen, even)


def _fine(missing: BoolArray, share: float) -> float:
    """The longer side of a picture in which the hole is as many places as pieces are chosen on."""
    return max(missing.shape) * min(
        1.0, (MOSAIC.max_places * share / np.count_nonzero(missing)) ** 0.5
    )


def _candidates(
    view: View,
    missing: BoolArray,
    structure: Structure,
    level: FloatArray | None,
) -> list[FloatArray]:
    """Copies (3, 3), in pixels."""
    if not view.missing.any() or view.barred.all():
        return []
    x, y = 1 / view.ratio
    found = [shift(*by) for by in shifts_in(view.image, view.missing, view.barred)]
    if level is not None:
        small = level @ np.diag([x, y, 1.0])
        found += level_shifts(view.image, view.missing, view.barred, small)
    out = [rescaled(copy, x, y) for copy in found]
    x0, _, x1, _ = bounds(missing)
    out += [
        shift(sign * share * (x1 - x0), 0.0) for sign in (1, -1) for share in MOSAIC.along_shares
    ]
    lines = structure.lines if at_work("shifts along lines") else structure.lines[:0]
    spans = np.array([_hidden(line, missing) for line in lines]).reshape(-1, 2)
    for span in spans[np.argsort(-np.linalg.norm(spans, axis=1), kind="stable")]:
        out += [shift(*(sign * share * span)) for sign in (1, -1) for share in MOSAIC.along_shares]
    return _distinct(out, missing)


def _hidden(line: FloatArray, missing: BoolArray) -> FloatArray:
    """(2,) from where a line (2, 2) runs into the hole (H, W) to where it comes out; else all."""
    spots_count = 80  # 20..200: of a line on which it is asked whether it is hidden
    share = np.linspace(0, 1, spots_count)
    x, y = (line[0] + share[:, None] * (line[1] - line[0])).astype(int).T
    inside = missing[y.clip(0, missing.shape[0] - 1), x.clip(0, missing.shape[1] - 1)]
    within = share[inside] if inside.any() else share
    return (within[-1] - within[0]) * (line[1] - line[0])


def _distinct(copies: Sequence[FloatArray], missing: BoolArray) -> list[FloatArray]:
    """Without those that copy from nearly the same places as an earlier one."""
    x0, y0, x1, y1 = bounds(missing)
    spots = np.array([[x0, y0, 1], [x1, y0, 1], [x0, y1, 1], [x1, y1, 1]], float)
    near = 0.012 * max(missing.shape)
    out: list[FloatArray] = []
    seen: list[FloatArray] = []
    for copy in copies:
        mapped = spots @ copy.T
        place = mapped[:, :2] / np.where(np.abs(mapped[:, 2:]) < 1e-9, 1e-9, mapped[:, 2:])
        if np.abs(place - spots[:, :2]).max() < 3:
            continue
        if all(np.abs(place - other).max() > near for other in seen):
            out.append(copy)
            seen.append(place)
    return out


def _laid(
    view: View,
    even: FloatImage,
    structure: Structure,
    copies: Sequence[FloatArray],
    faces: IntArray | None,
) -> tuple[NDArray[np.int64], list[int]]:
    """Which piece (h, w) lies where on a coarse grid, -1 outside, and the copies in use.

    even: (H, W, 3) the smooth fill; it is the piece after the last copy. faces: as for `mosaic`.
    """
    rim_count = 2  # 1..4: width, in places, of the rim on which a copy is held against the photo
    places = grow(view.missing, rim_count)
    rim = places & ~view.barred
    smooth = cv2.resize(even, places.shape[::-1], interpolation=cv2.INTER_AREA)
    smooth = np.where(view.barred[..., None], smooth, view.image).astype(np.float32)
    side = structure.scaled(view.ratio).clear(view.missing).sides(places.shape)
    face = _sure_faces(faces, places.shape)
    expected = _Expected.of(view, smooth, side)
    feature = _features(view.image)
    soft = cv2.GaussianBlur(smooth, (0, 0), MOSAIC.soft_count)
    rows, columns = np.nonzero(places)
    looks, prices = [], []
    for copy in copies:
        own = rescaled(copy, *view.ratio)
        shown, price = _shown(feature, view.barred, own, places)
        off = np.abs(shown - feature[places]).sum(-1) * MOSAIC.rim_factor
        x, y, _ = sources(own, columns, rows)
        if at_work("expected colours"):
            price += expected.price(taken(np.asarray(soft, np.float32), x, y), places, view.missing)
        price += np.where(rim[places], np.minimum(off, MOSAIC.max_rim_price), 0)
        price += _elsewhere(side, face, places, (x, y))
        looks.append(shown)
        prices.append(price)
    asked = np.array(prices, np.float32)
    fitting = _fitting(asked[:, rim[places]])
    looks = [*(looks[k] for k in fitting), _features(smooth)[places]]
    bare = np.where(
        view.missing[places],
        np.minimum(MOSAIC.smooth_factor * expected.rough[places], MOSAIC.max_smooth_price),
        0,
    )
    if not at_work("smooth fill"):
        bare = bare + np.float32(500.0)
    asked = np.concatenate([asked[fitting], bare[None]]).astype(np.float32)
    fitting = np.append(fitting, len(copies))
    chosen = fitting[choose(Grid.of(places), np.array(looks, np.float32), asked)]
    used = sorted(set(chosen.tolist()))
    label = np.full(places.shape, -1)
    label[places] = np.searchsorted(used, chosen)
    return label, used


def _elsewhere(
    side: NDArray[np.int64],
    face: NDArray[np.int64] | None,
    places: BoolArray,
    source: tuple[FloatImage, FloatImage],
) -> FloatArray:
    """(N,) what it costs to take places (h, w) from beyond a line or from another face.

    side, face: (h, w) numbers. source: x and y (N,) of what is copied.
    """
    column, row = (
        np.clip(np.round(at).astype(int), 0, last - 1)
        for at, last in zip(source, side.shape[::-1], strict=True)
    )
    price = np.zeros(len(row))
    if at_work("sides of lines"):
        price += MOSAIC.beyond_price * (side[row, column] != side[places])
    if face is not None:
        own, other = face[places], face[row, column]
        price += MOSAIC.other_face_price * ((own != other) & (own >= 0) & (other >= 0))
    return price


def _sure_faces(faces: IntArray | None, shape: tuple[int, ...]) -> NDArray[np.int64] | None:
    """(h, w) the faces, 0 for whatever is none, -1 where one begins and the next one ends."""
    if faces is None or not (faces > 0).any() or not at_work("own faces"):
        return None
    whole = np.maximum(faces, 0).astype(np.float32)
    small = cv2.resize(whole, shape[::-1], interpolation=cv2.INTER_NEAREST)
    square = np.ones((3, 3), np.uint8)
    same = cv2.dilate(small, square) == cv2.erode(small, square)
    return np.where(same, small, -1).astype(np.int64)


@dataclass(frozen=True, eq=False, slots=True)
class _Expected:
    """What is looked for in the hole: colour (h, w, 3), how far it may stray (h, w), and how

    rough (h, w) the photo is where that comes from; grey levels of three colours.
    """

    colour: FloatImage
    stray: FloatImage
    rough: FloatImage

    @classmethod
    def of(cls, view: View, smooth: FloatImage, side: NDArray[np.int64]) -> Self:
        """side: (h, w) numbers of the parts into which the picture is divided."""
        soft = cv2.GaussianBlur(smooth, (0, 0), MOSAIC.soft_count)
        broad = cv2.GaussianBlur(smooth, (0, 0), 3 * MOSAIC.soft_count)
        fine = np.abs(view.image - soft).sum(-1)
        wide = np.abs(soft - broad).sum(-1)
        rough = _around(_median(fine), view, side)
        # A thing that stands out beside the hole leaves the ground beside it one of one colour.
        stray = _around(_usual(_median(wide), view), view, side)
        return cls(
            np.asarray(soft, np.float32),
            np.asarray(
                np.clip(MOSAIC.stray_levels + 2 * stray, 0, MOSAIC.max_stray_levels), np.float32
            ),
            np.asarray(rough + stray, np.float32),
        )

    def price(self, shown: FloatImage, places: BoolArray, missing: BoolArray) -> FloatImage:
        """(N,) what it costs to show these colours (N, 3) at the places (h, w)."""
        off = shown - self.colour[places]
        level = off.mean(-1, keepdims=True)
        # Brightness is levelled when pieces are joined, colour shows.
        wrong = MOSAIC.off_factor * np.abs(level[:, 0]) + MOSAIC.off_factor * np.abs(
            off - level
        ).sum(-1)
        wrong = np.minimum(np.maximum(wrong - self.stray[places], 0), MOSAIC.max_strayed_price)
        return np.where(missing[places], wrong, 0).astype(np.float32)


def _around(values: FloatImage, view: View, side: NDArray[np.int64]) -> FloatImage:
    """Values (h, w) of the known part, in the hole their mean beside it, along rows above all.

    Of what lies on the same side (h, w) of all that divides the hole, where some of that is near.
    """
    known = (~view.barred).astype(np.float32)
    x0, y0, x1, y1 = bounds(view.missing)
    across, down = (max(2.0, share * max(x1 - x0, y1 - y0)) for share in MOSAIC.broad_shares)

    def blurred(image: FloatImage) -> FloatImage:
        out = cv2.GaussianBlur(image, (0, 0), sigmaX=across, sigmaY=down)
        return np.asarray(out, np.float32)

    total, count = blurred(values * known), blurred(known)
    mean = total / np.maximum(count, 1e-4)
    numbers = np.unique(side[view.missing])
    if len(numbers) < 2:
        return np.asarray(mean, np.float32)
    out = mean.copy()
    for number in numbers:
        here = side == number
        count = blurred(known * here)
        own = blurred(values * known * here) / np.maximum(count, 1e-4)
        share = np.clip(count / MOSAIC.little_share, 0, 1)
        out[here] = (share * own + (1 - share) * mean)[here]
    return np.asarray(out, np.float32)


def _usual(values: FloatImage, view: View) -> FloatImage:
    """Values (h, w) capped at several times what is usual around the hole."""
    x0, y0, x1, y1 = bounds(view.missing)
    reach = round(0.5 * max(x1 - x0, y1 - y0))
    beside = np.zeros(values.shape, bool)
    beside[max(0, y0 - reach) : y1 + reach, max(0, x0 - reach) : x1 + reach] = True
    beside &= ~view.barred
    if not beside.any():
        return values
    return np.minimum(values, MOSAIC.unusual_factor * float(np.median(values[beside])))


def _median(values: FloatImage) -> FloatImage:
    """Values (h, w) of up to 255 without those of thin lines."""
    whole = np.clip(np.round(values), 0, 255).astype(np.uint8)
    return np.asarray(cv2.medianBlur(whole, 5), np.float32)


def _fitting(prices: FloatImage) -> NDArray[np.int64]:
    """The copies that are among the best somewhere on the rim; prices: (K, R) there."""
    if len(prices) <= MOSAIC.max_copies or not prices.shape[1]:
        return np.arange(len(prices))
    best = np.argsort(prices, axis=0, kind="stable")[:4]
    votes = np.bincount(best.ravel(), minlength=len(prices))
    return np.sort(np.argsort(-votes, kind="stable")[: MOSAIC.max_copies])


def _features(image: FloatImage) -> FloatImage:
    """(H, W, 5) colours and steps of lightness to the right and below."""
    grey = image.mean(-1)
    right = np.diff(grey, axis=1, append=grey[:, -1:])
    down = np.diff(grey, axis=0, append=grey[-1:])
    return np.dstack([image, right, down]).astype(np.float32)


def bent_price(by: FloatArray) -> FloatArray:
    """(N,) what it costs that a copy is bent by so much there."""
    return MOSAIC.bent_price * np.clip(
        by - MOSAIC.little_bent_ratio, 0, 1
    ) + MOSAIC.torn_price * np.clip(by - MOSAIC.much_bent_ratio, 0, 1)


def _shown(
    feature: FloatImage, barred: BoolArray, copy: FloatArray, places: BoolArray
) -> tuple[FloatImage, FloatArray]:
    """What a copy shows at the places (N, C) and what it costs to take it there (N,)."""
    rows, columns = np.nonzero(places)
    x, y, finer = sources(copy, columns, rows)
    shown = taken(feature[..., :4], x, y)
    last = taken(feature[..., 4], x, y)
    size = max(np.ptp(rows), np.ptp(columns), 1)
    away = MOSAIC.far_price * np.hypot(x - columns, y - rows) / size
    if copy[2, 1] == 0:
        away += (MOSAIC.height_price - MOSAIC.far_price) * np.abs(y - rows) / size
    coarse = np.log2(1 / np.maximum(finer, 1e-3)) / 2
    price = away + MOSAIC.coarser_price * np.maximum(coarse - 0.3, 0)
    if at_work("bent copies"):
        price += bent_price(bent(copy, columns, rows, x, y))
    price = np.where(blocked(barred, x, y), CUT.never_levels, price)
    return np.column_stack([shown, last]).astype(np.float32), price
