"""What the ground around a thing is made of: a few colours, each lit smoothly."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Self

import cv2
import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import distance_transform_edt

from physagent_studio.arrays import BoolArray, FloatArray, FloatImage
from physagent_studio.reconstruction.photo.regions import grow
from physagent_studio.reconstruction.switches import at_work


@dataclass(frozen=True, slots=True)
class ToneSettings:
    """How the colours of ground are told apart, and what lies on them."""

    tint_lab: float = 9.0  # 3..20: a*, b*, of a pixel from a ground's colour for its lightness
    # 0..3: the same for each L* of darkness: there it is light thrown back
    bounce_ratio: float = 1.0
    # 5..40: a*, b*, by which the thing's light may colour ground that is not dark
    max_shine_lab: float = 14.0
    # 1..6: of the usual stray of the ground's own colour, taken off the thing's
    grain_factor: float = 3.0
    darkest_percent: float = 95.0  # 80..100: of ground by its darkness: that of its pattern
    least_shade_lab: float = 15.0  # 8..30: L*, by which ground in a deep shade is darker than lit
    shade_tint_lab: float = 7.0  # 3..10: a*, b*, by which its colour may be off the lit one's
    black_lab: float = 10.0  # 3..20: L*, below which a place shows no colour of its own
    # cosine, 0.5..1: between what a colour is off and the thing's, for light from it
    aligned_cosine: float = 0.8


TONE = ToneSettings()


@dataclass(frozen=True, eq=False, slots=True)
class Tones:
    """The ground without the thing's shade, at every pixel by the colour that it is nearest to.

    which: (H, W) that colour's number, -1 where the ground has none like it. darker: (H, W) how
    much darker than lit ground, L*. uneven: (H, W) how uneven lit ground is itself, L*. darkest:
    (H, W) how dark what is painted or laid on it gets, L*.
    glow: (H, W) how much of the thing's own colour lies on it, in a*, b*.
    """

    which: NDArray[np.int64]
    darker: FloatImage
    uneven: FloatImage
    darkest: FloatImage
    glow: FloatImage

    @classmethod
    def of(
        cls, lab: FloatImage, ground: BoolArray, own: BoolArray, parts: Sequence[BoolArray]
    ) -> Self:
        """Read off the pixels `ground` (H, W) of a picture in L*a*b*, which fall into `parts` by
        colour; own: (H, W) the thing."""
        least = np.full(ground.shape, np.inf, np.float32)
        which = np.full(ground.shape, -1)
        darker, uneven, darkest, glow = (np.zeros(ground.shape, np.float32) for _ in range(4))
        coarse = _patterned(lab[..., 0], ground)
        for number, part in enumerate(parts):
            lit, spread = _lit(lab, part)
            spread = max(spread, coarse)
            dark = lit[..., 0] - lab[..., 0]
            # With less light L* + 16, a* and b* all shrink as its cube root.
            share = ((lab[..., :1] + 16) / np.maximum(lit[..., :1] + 16, 1)).clip(0, 1)
            off = lab[..., 1:] - lit[..., 1:] * share
            far = np.abs(off).max(-1)
            tint = _own_tint(lab, own, lit)
            toward = off @ tint
            # Ground that is of more than one colour itself is not lit by the thing for that.
            toward -= TONE.grain_factor * float(np.median(np.abs(toward[part])))
            aligned = off @ tint > TONE.aligned_cosine * np.linalg.norm(off, axis=-1)
            # Light from one coloured board onto another is of a deeper colour still.
            own_way = (
                lit[..., 1:]
                / np.maximum(np.linalg.norm(lit[..., 1:], axis=-1), TONE.tint_lab)[..., None]
            )
            deeper = (off * own_way).sum(-1) > TONE.aligned_cosine * np.linalg.norm(off, axis=-1)
            most = TONE.tint_lab + TONE.bounce_ratio * dark
            fits = (far < TONE.tint_lab) | (deeper & (far < most))
            fits |= aligned & (far < np.maximum(most, TONE.max_shine_lab))
            # A colour that is lit there is likelier than one that would be in deep shade.
            cost = far + 0.25 * np.abs(dark)
            better = fits & (cost < least)
            least = np.where(better, cost, least)
            which = np.where(better, number, which)
            darker = np.where(better, dark, darker)
            uneven = np.where(better, np.float32(spread), uneven)
            deep = np.float32(np.percentile(dark[part], TONE.darkest_percent))
            darkest = np.where(better, deep, darkest)
            glow = np.where(better, np.where(aligned, np.maximum(toward, 0), 0), glow)
        tones = cls(which, darker, uneven, darkest, glow)
        return tones._with_black(lab, ground, parts) if at_work("black shade") else tones

    def _with_black(self, lab: FloatImage, ground: BoolArray, parts: Sequence[BoolArray]) -> Self:
        """Black places (H, W) taken for the ground beside them, in deep shade."""
        black = lab[..., 0] < TONE.black_lab
        soft_px = 3  # 1..6: around black places, where it is neither black nor lit
        sure = ground & ~grow(black, soft_px) & (self.which >= 0)
        count = np.count_nonzero(black & ground)
        # Where most of the ground is black, that is its own colour.
        if not count or 2 * count > np.count_nonzero(ground) or not sure.any():
            return self
        nearest = distance_transform_edt(~sure, return_distances=False, return_indices=True)
        row, column = np.asarray(nearest)
        which = self.which[row, column]
        lit = np.stack([_lit(lab, part & ~black)[0][..., 0] for part in parts])
        darker = np.take_along_axis(lit, which[None], 0)[0] - lab[..., 0]
        return replace(
            self,
            which=np.where(black, which, self.which),
            darker=np.where(black, darker, self.darker).astype(np.float32),
            uneven=np.where(black, self.uneven[row, column], self.uneven),
            darkest=np.where(black, self.darkest[row, column], self.darkest),
            glow=np.where(black, 0, self.glow).astype(np.float32),
        )


def _patterned(light: FloatImage, ground: BoolArray) -> float:
    """How far the lightness (H, W) of ground strays from what it is around each place, in L*."""
    known = ground.astype(np.float32)
    around_px = 4.0  # 2..10: spread of what ground is around a place
    mean = cv2.GaussianBlur(light * known, (0, 0), around_px)
    mean /= np.maximum(cv2.GaussianBlur(known, (0, 0), around_px), 1e-3)
    return 1.5 * float(np.median(np.abs(light - mean)[ground]))


def parts_of(lab: FloatImage, ground: BoolArray) -> list[BoolArray]:
    """The ground (H, W) apart by colour, the largest part first."""
    if at_work("black shade"):
        coloured = ground & (lab[..., 0] >= TONE.black_lab)
        ground = coloured if 2 * coloured.sum() > ground.sum() else ground
    colours = lab[ground, 1:].astype(np.float64)
    centres = [np.median(colours, 0)]
    least_share = 0.08  # 0.02..0.3: of the ground that a colour has
    apart_lab = 12.0  # 5..30: a*, b*, between two of them at least
    max_colours = 3  # count, 1..6: that are told apart
    while len(centres) < max_colours:
        away = np.min([np.linalg.norm(colours - c, axis=1) for c in centres], 0)
        other = away > apart_lab
        if np.count_nonzero(other) < least_share * len(colours):
            break
        # The densest of what is like none of them so far.
        bins = np.round(colours[other] / 6).astype(int)
        values, count = np.unique(bins, axis=0, return_counts=True)
        centres.append(values[count.argmax()] * 6.0)
    for _ in range(5):
        nearest = _nearest(colours, centres)
        kept = [
            k for k in range(len(centres)) if (nearest == k).sum() > least_share / 2 * len(colours)
        ]
        centres = [np.median(colours[nearest == k], 0) for k in kept]
    nearest = _nearest(colours, centres)
    out = []
    for k in range(len(centres)):
        part = np.zeros(ground.shape, bool)
        part[ground] = nearest == k
        out.append(part)
    return sorted(out, key=lambda part: -int(part.sum()))


def lit_ones(lab: FloatImage, parts: Sequence[BoolArray]) -> list[BoolArray]:
    """The parts (H, W) without those that are what a larger one is in shade, by their colours."""
    kept: list[BoolArray] = []
    middles: list[FloatImage] = []
    for part in parts:
        middle = np.median(lab[part], axis=0)
        if not any(_is_shade_of(middle, lit) for lit in middles):
            kept.append(part)
            middles.append(middle)
    return kept


def _is_shade_of(dark: FloatImage, lit: FloatImage) -> bool:
    """Whether a colour (3,) in L*a*b* is what another one is in less light."""
    share = (dark[0] + 16) / (lit[0] + 16)
    off = np.abs(dark[1:] - lit[1:] * share).max()
    return bool(lit[0] - dark[0] > TONE.least_shade_lab and off < TONE.shade_tint_lab)


def _nearest(colours: FloatArray, centres: list[FloatArray]) -> NDArray[np.int64]:
    return np.argmin([np.linalg.norm(colours - c, axis=1) for c in centres], 0)


def _own_tint(lab: FloatImage, own: BoolArray, lit: FloatImage) -> FloatImage:
    """The direction (a*, b*) from the ground's colour to the thing's; zero where they are alike."""
    apart = lab[own, 1:].mean(0) - lit[own, 1:].mean(0)
    far = float(np.hypot(*apart))
    return (apart / far if far > TONE.tint_lab else apart * 0).astype(np.float32)


def _lit(lab: FloatImage, ground: BoolArray) -> tuple[FloatImage, float]:
    """(H, W, 3) the ground without shade, a smooth surface through its lighter half.

    Also how uneven the lit ground is, in L*.
    """
    rows, columns = np.nonzero(ground)
    scale = float(max(ground.shape))
    terms = np.stack([np.ones(len(rows)), columns / scale, rows / scale], 1)
    values = lab[rows, columns].astype(float)
    weight = np.ones(len(rows))
    fit = np.zeros((3, 3))
    for _ in range(8):
        root = np.sqrt(weight)[:, None]
        fit = np.linalg.lstsq(terms * root, values * root, rcond=None)[0]
        rest = values[:, 0] - terms @ fit[:, 0]
        spread = max(1.5 * float(np.median(np.abs(rest))), 2.0)
        weight = 1 / (1 + (rest / np.where(rest < 0, spread, 2 * spread)) ** 2)
    rest = values[:, 0] - terms @ fit[:, 0]
    # Shade makes the dark side of the spread wide, so it is the light side that tells.
    uneven = 1.5 * float(np.median(np.abs(rest[rest > 0]))) if (rest > 0).any() else 0.0
    y, x = np.indices(ground.shape) / scale
    return (np.stack([np.ones_like(x), x, y], -1) @ fit).astype(np.float32), uneven
