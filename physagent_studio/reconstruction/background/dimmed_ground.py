"""Shade on ground of any pattern: how much of the light is left at each place.

A dark tile is no shade, and a light tile in shade is as dark as it. What tells them apart is which
colours the ground has where it is lit: for each place and each share of the light, the colour that
the place would have in full light is looked up among them. The shares are then chosen for all
places together, alike in neighbours (semi-global matching, Hirschmüller 2008, with levels of light
in place of disparities). What has less light and begins at a thing's foot is its shade.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import cv2
import numpy as np
from scipy.ndimage import gaussian_filter

from physagent_studio.arrays import BoolArray, FloatArray, FloatImage, IntArray
from physagent_studio.reconstruction.background.surfaces import reduced, under
from physagent_studio.reconstruction.photo.regions import bounds, grow
from physagent_studio.records.case import Image


@dataclass(frozen=True, slots=True)
class DimmedSettings:
    """How ground and its light are compared, and what of it is a thing's shade."""

    longer_px: int = 320  # 160..640: side of the picture in which it is looked for
    smallest_px: int = 40  # 0..100: size of the smallest thing in it, unless that is too large
    largest_factor: float = 2.0  # 1..4: over `longer_px`, how large it may get for that
    bin_log: float = 0.08  # log, 0.03..0.2: of each colour, by which ground's colours are counted
    common_share: float = 0.5  # 0.2..0.9: of lit ground, in its commonest colours: as good as any
    rare_ratio: float = 0.01  # 1e-4..0.1: over those, of a colour that lit ground does not have
    step_log: float = 0.1  # log, 0.05..0.2: from one level of light to the next
    deepest_log: float = 1.6  # log, 0.7..2.5: of the deepest shade
    dim_nats: float = 0.12  # nats, 0..0.5: price of a place that is not in full light
    step_nats: float = 2.0  # nats, 0.1..5: price between neighbours that are one level apart
    jump_nats: float = 10.0  # nats, 0.5..20: the same where they are farther apart
    near_sizes: float = 0.35  # own sizes, 0.1..1: around a foot, not taken for lit
    around_sizes: float = 2.5  # own sizes, 1..6: around a thing, whose ground tells its lit colours
    reach_sizes: float = 1.8  # own sizes, 0.5..4: how far shade reaches in the picture
    level_sizes: float = 2.0  # own sizes, 1..8: the same over the ground
    foot_share: float = 0.35  # 0.1..0.6: of its height, from below, beside which shade begins
    gap_px: int = 4  # 1..8: between a thing and its shade
    min_ground_px: int = 150  # 50..1000: of ground that tells its lit colours
    max_unlike_nats: float = 2.0  # nats, 0.5..3: by which shade is unlike lit ground
    min_gain_nats: float = 0.45  # nats, 0.2..1.5: mean by which less light explains a shade better
    max_spread_log: float = 0.3  # log, 0.1..0.6: of the light in one shade: things are rounded
    edge_log: float = 0.15  # log, 0.05..0.4: within three pixels, by which light jumps
    edge_px: int = 3  # 1..8: to each side of a jump, which is no more told by its light
    smooth_px: float = 3.0  # 1..10: spread over which the levels of light run into one another
    # 0.4..2: over the light that is missing, of one of its colours
    tint_ratios: tuple[float, ...] = (0.7, 0.8, 0.9, 1.0, 1.1, 1.2, 1.3)
    min_within_share: float = 0.6  # 0.5..1: of a shade that lies within reach of its thing
    # log, 0.005..0.1: usual stray of lit ground's light: on smoother ground shade is dark by itself
    min_rough_log: float = 0.025
    median_px: int = 5  # odd, 1..9: side of the squares in which the usual level is taken
    min_solid_share: float = 0.6  # 0..0.9: of a shade that is wider than five pixels
    brightest_share: float = 0.99  # 0.8..1: of lit ground that is no brighter than shade once lit
    rounds_count: int = 2  # count, 1..3: each without the shade that was found before it


DIMMED = DimmedSettings()


@dataclass(frozen=True, eq=False, slots=True)
class _Thing:
    """A marked thing (H, W), the ground it stands on, its distance, rows, size, and its foot."""

    own: BoolArray
    ground: BoolArray
    away: FloatImage
    low: BoolArray
    size: int
    end: int

    @classmethod
    def of(cls, own: BoolArray, inside: BoolArray, faces: IntArray) -> _Thing:
        x0, y0, x1, y1 = bounds(own)
        rows = np.arange(own.shape[0])[:, None] * np.ones(own.shape[1])
        low = rows >= y1 - DIMMED.foot_share * (y1 - y0)
        ground = under(own, faces) & ~inside & grow(low, 6)
        away = cv2.distanceTransform((~own).astype(np.uint8), cv2.DIST_L2, 5)
        return cls(own, ground, np.asarray(away, np.float32), low, max(x1 - x0, y1 - y0), y1 - 1)

    @property
    def near(self) -> BoolArray:
        """(H, W) what its shade may well cover."""
        return (self.away < DIMMED.near_sizes * self.size) & self.low

    @property
    def around(self) -> BoolArray:
        """(H, W) ground that tells what is usual there."""
        return self.ground & (self.away < DIMMED.around_sizes * self.size)

    def reach(self, level: FloatArray) -> BoolArray:
        """(H, W) how far its shade may lie, in the picture and over the ground. level: (3, 3) as
        `to_level` gives it."""
        y, x = np.indices(self.own.shape)
        mapped = np.stack([x + 0.5, y + 0.5, np.ones(x.shape)], -1) @ level.T
        below = mapped[..., 2] > 1e-9
        places = mapped[..., :2] / np.where(below, mapped[..., 2], 1)[..., None]
        columns = np.flatnonzero(self.own[self.end])
        column = min(max(int(np.median(columns)), 1), self.own.shape[1] - 2)
        before, foot, after = places[self.end, column - 1 : column + 2]
        pixel = float(np.linalg.norm(after - before)) / 2
        far = np.linalg.norm(places - foot, axis=-1)
        within = below & (far < DIMMED.level_sizes * self.size * pixel)
        return np.asarray(within & (self.away < DIMMED.reach_sizes * self.size))


@dataclass(frozen=True, eq=False, slots=True)
class Shade:
    """The shade of things on ground. dims: (H, W, 3) log of the light that is missing, 0 where
    none is. edges: (H, W) where it changes so much that what is there is not told by it.
    brightest: (3,) grey levels that hardly any lit ground around the things exceeds.
    """

    dims: FloatImage
    edges: BoolArray
    brightest: FloatArray

    @property
    def places(self) -> BoolArray:
        """(H, W) where it is."""
        return np.asarray((self.dims > 0).any(-1) | self.edges)

    def outside(self, things: BoolArray) -> Shade:
        """The shade but for what is none: other things (H, W), dark themselves."""
        return replace(
            self, dims=np.where(things[..., None], 0, self.dims), edges=self.edges & ~things
        )

    def lifted(self, photo: Image) -> Image:
        """The photo (H, W, 3) in full light."""
        lit = (photo.astype(np.float32) + 4) * np.exp(self.dims) - 4
        # Light has levels, and on white ground one too many shows.
        lit = np.maximum(np.minimum(lit, self.brightest), photo)
        return np.where(self.dims > 0, np.round(lit), photo).astype(np.uint8)


def dimmed(
    photo: Image,
    masks: Sequence[BoolArray],
    hole: BoolArray,
    level: FloatArray,
    faces: IntArray,
) -> Shade:
    """Ground beside the masked things that has less light than the ground around it.

    hole: (H, W) what is taken out anyway. level: (3, 3) from pixels to a level plane, as
    `to_level` gives it. faces: (H, W) as `surfaces` gives them.
    """
    masks = [mask for mask in masks if mask.any()]
    if not masks:
        return Shade(
            np.zeros(photo.shape, np.float32), np.zeros(hole.shape, bool), np.ones(3) * 255
        )
    factor = _factor(masks, max(hole.shape))
    size = (max(8, round(hole.shape[1] * factor)), max(8, round(hole.shape[0] * factor)))
    small = cv2.resize(photo, size, interpolation=cv2.INTER_AREA)
    inside, *owns = (reduced(what, size) > 0 for what in (hole, *masks))
    kinds = reduced(faces, size)
    things = [_Thing.of(own, inside, kinds) for own in owns if own[1:-1, 1:-1].any()]
    logs = np.log(cv2.GaussianBlur(small, (0, 0), 0.7).astype(np.float32) + 4)
    level = level @ np.diag([1 / factor, 1 / factor, 1.0])
    dims = np.zeros(small.shape, np.float32)
    beside = np.any([thing.near for thing in things] + [np.zeros_like(inside)], axis=0)
    for _ in range(DIMMED.rounds_count):
        # Its own shade and that of others is no lit ground.
        lit = ~beside & ~dims.any(-1)
        found = [_of_one(logs, thing, thing.around & lit, inside, level) for thing in things]
        dims = np.max([dims, *found], axis=0)
    around = np.any([thing.around for thing in things], axis=0) & ~beside & ~dims.any(-1)
    return _at_full_size(dims, inside, hole, _brightest(photo, around))


def _brightest(photo: Image, lit: BoolArray) -> FloatArray:
    """(3,) grey levels of a photo (H, W, 3) that hardly any of the lit ground (h, w) exceeds, in
    none of its colours, with its grain."""
    size = photo.shape[1], photo.shape[0]
    wide = cv2.resize(lit.astype(np.uint8), size, interpolation=cv2.INTER_NEAREST) > 0
    if not wide.any():
        return np.full(3, 255.0)
    return np.quantile(photo[wide], DIMMED.brightest_share, axis=0)


def _roughness(logs: FloatImage, lit: BoolArray) -> float:
    """How far the light of ground strays from what it is around each place, log."""
    light = logs.mean(-1)
    square = cv2.blur(np.square(light), (7, 7)) - np.square(cv2.blur(light, (7, 7)))
    return float(np.median(np.sqrt(np.maximum(square[lit], 0)))) if lit.any() else 0.0


def _at_full_size(
    dims: FloatImage, inside: BoolArray, hole: BoolArray, brightest: FloatArray
) -> Shade:
    """Smooth where the light changes little by little, open where it jumps."""
    mean = dims.mean(-1)
    near = np.ones((3, 3), np.uint8)
    # What is taken out anyway has the light of what is beside it.
    known = np.where(inside, 0, mean)
    highest = cv2.dilate(known, near)
    lowest = cv2.erode(np.where(inside, highest, mean).astype(np.float32), near)
    edges = grow((highest - lowest > DIMMED.edge_log) & (highest > 0), DIMMED.edge_px)
    dark = mean > 0
    weight = np.maximum(cv2.GaussianBlur(dark.astype(np.float32), (0, 0), DIMMED.smooth_px), 1e-3)
    smooth = cv2.GaussianBlur(dims, (0, 0), DIMMED.smooth_px) / weight[..., None]
    smooth[~dark] = 0
    full = hole.shape[::-1]
    wide = np.asarray(cv2.resize(edges.astype(np.float32), full) > 0.4)
    sized = np.asarray(cv2.resize(smooth, full, interpolation=cv2.INTER_LINEAR), np.float32)
    sized[wide | hole] = 0
    return Shade(sized, wide & ~hole, brightest)


def _factor(masks: Sequence[BoolArray], longer: int) -> float:
    """By how much the picture is reduced, its longer side given."""
    boxes = [bounds(mask) for mask in masks]
    smallest = min(max(x1 - x0, y1 - y0) for x0, y0, x1, y1 in boxes)
    usual = DIMMED.longer_px / longer
    return min(1.0, max(usual, min(DIMMED.smallest_px / smallest, DIMMED.largest_factor * usual)))


def _of_one(
    logs: FloatImage, thing: _Thing, lit: BoolArray, inside: BoolArray, level: FloatArray
) -> FloatImage:
    """(H, W, 3) the shade of one thing. logs: (H, W, 3) colours. lit: (H, W) ground that is lit."""
    out = np.zeros(logs.shape, np.float32)
    if np.count_nonzero(lit) < DIMMED.min_ground_px or _roughness(logs, lit) < DIMMED.min_rough_log:
        return out
    reach = thing.reach(level)
    x0, y0, x1, y1 = bounds(thing.ground & grow(reach, thing.size // 2) | thing.own)
    window = slice(y0, y1), slice(x0, x1)
    palette = _Palette.of(logs, lit)
    prices = _prices(logs[window], palette)
    usual = float(prices[..., 0][lit[window]].mean()) if lit[window].any() else 0.0
    prices[~thing.ground[window]] = 0
    levels = semi_global(prices, DIMMED.step_nats, DIMMED.jump_nats)
    levels = cv2.medianBlur(levels.astype(np.uint8), DIMMED.median_px).astype(np.int64)
    price = np.take_along_axis(prices, levels[..., None], -1)[..., 0]
    gain = prices[..., 0] - price
    unlike = cv2.blur(price, (5, 5)) > usual + DIMMED.max_unlike_nats
    dark = (levels > 0) & thing.ground[window] & ~unlike
    begins = grow(thing.own, DIMMED.gap_px) | grow(inside & (thing.away < 3), 2)
    begins = (begins & thing.low)[window]
    _, labels = cv2.connectedComponents(dark.astype(np.uint8))
    dims, within = (levels * DIMMED.step_log).astype(np.float32), reach[window]
    for number in np.unique(labels[begins & dark]):
        part = labels == number
        # What goes on beyond where a shade may lie is ground of another colour, or a wall.
        ends = np.count_nonzero(part & within) > DIMMED.min_within_share * np.count_nonzero(part)
        solid = cv2.morphologyEx(part.astype(np.uint8), cv2.MORPH_OPEN, np.ones((5, 5)))
        whole = np.count_nonzero(solid) > DIMMED.min_solid_share * np.count_nonzero(part)
        even = float(dims[part].std()) < DIMMED.max_spread_log
        if ends and whole and even and float(gain[part].mean()) > DIMMED.min_gain_nats:
            part &= within
            tint = _tint(logs[window][part], dims[part], palette)
            out[window][part] = dims[part, None] * tint
    return out


def _tint(logs: FloatImage, dims: FloatImage, palette: _Palette) -> FloatImage:
    """(3,) by how much the missing light (K,) of each colour is multiplied to fit best.

    Where the sun does not get, the sky is blue. logs: (K, 3).
    """
    best = np.ones(3, np.float32)
    for _ in range(2):
        for colour in range(3):
            tried = np.repeat(best[None], len(DIMMED.tint_ratios), 0)
            tried[:, colour] = DIMMED.tint_ratios
            prices = [
                float(palette.of_colours(logs + dims[:, None] * tint).mean()) for tint in tried
            ]
            best = tried[int(np.argmin(prices))]
    return best


@dataclass(frozen=True, eq=False, slots=True)
class _Palette:
    """What each colour costs on lit ground, nats, by its bins (N, N, N)."""

    prices: FloatImage

    @classmethod
    def of(cls, logs: FloatImage, lit: BoolArray) -> _Palette:
        count = int(np.ceil(np.log(260 / 4) / DIMMED.bin_log)) + 1
        bins = np.round((logs[lit] - np.log(4)) / DIMMED.bin_log).astype(int)
        counts = np.zeros((count, count, count), np.float32)
        np.add.at(counts, tuple(bins.T), 1)
        counts = gaussian_filter(counts, 1.0)
        each = np.sort(counts[tuple(bins.T)])
        common = each[int((1 - DIMMED.common_share) * len(each))]
        shares = np.minimum(counts / common, 1) + DIMMED.rare_ratio
        return cls(-np.log(shares).astype(np.float32))

    def of_colours(self, logs: FloatImage) -> FloatImage:
        """(H, W) nats of colours (H, W, 3); nothing is lighter than white."""
        bins = np.round((logs - np.log(4)) / DIMMED.bin_log).astype(int)
        last = len(self.prices) - 1
        known = self.prices[tuple(np.moveaxis(bins.clip(0, last), -1, 0))]
        return np.where((bins > last).any(-1), -np.log(DIMMED.rare_ratio), known)


def _prices(logs: FloatImage, palette: _Palette) -> FloatImage:
    """(H, W, L) nats of each level of light at each place, full light first."""
    dims = np.arange(0.0, DIMMED.deepest_log, DIMMED.step_log)
    prices = np.stack([palette.of_colours(logs + np.float32(dim)) for dim in dims], -1)
    prices = np.stack([cv2.blur(one, (3, 3)) for one in np.moveaxis(prices, -1, 0)], -1)
    prices[..., 1:] += DIMMED.dim_nats
    return np.asarray(prices, np.float32)


def semi_global(prices: FloatImage, step: float, jump: float) -> IntArray:
    """(H, W) the level of each place, from the prices (H, W, L) of them all.

    step, jump: price between neighbours one level apart, and farther apart. Summed over four
    paths to each place (Hirschmüller, Stereo processing by semiglobal matching, 2008, eq. 13).
    """
    total = np.zeros_like(prices)
    for across in (False, True):
        rows, sums = (np.swapaxes(p, 0, 1) if across else p for p in (prices, total))
        for way in (slice(None), slice(None, None, -1)):
            before = np.zeros_like(rows[0])
            for own, sum_of in zip(rows[way], sums[way], strict=True):
                least = before.min(-1, keepdims=True)
                best = np.minimum(before, least + jump)
                best[:, 1:] = np.minimum(best[:, 1:], before[:, :-1] + step)
                best[:, :-1] = np.minimum(best[:, :-1], before[:, 1:] + step)
                before = own + best - least
                sum_of += before
    return np.asarray(total.argmin(-1), np.int64)
