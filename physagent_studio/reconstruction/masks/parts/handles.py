"""Handles: thin arches that stand with both feet on a thing and show what is behind through them.

An arch is a band of one width along half of a superellipse; it stands out from what is outside of
it and from what is inside, to the same side, and these two are alike. As with bars across poles
(`crossbars.py`) that is weighed against how much arches of that form, put anywhere around the
thing, stand out. Each third of an arch is asked for on its own, so that none is made of a single
edge that passes by.
"""

from __future__ import annotations

from dataclasses import dataclass, fields, replace

import cv2
import numpy as np
from numpy.typing import NDArray

from physagent_studio.reconstruction.masks.grabcut import side_by_side
from physagent_studio.reconstruction.photo.regions import BoolArray, grow

FloatArray = NDArray[np.float64]
WIDE = (0.05, 0.07, 0.1, 0.14, 0.19, 0.25, 0.32, 0.4)
HIGH = (0.45, 0.6, 0.8, 1.05, 1.4)
"""Half of the way between the feet as shares of the thing's side; heights over that."""
THICK, FORMS = (0.014, 0.02, 0.03, 0.045), (2.0, 3.5)
"""Thicknesses as shares of the thing's side; exponents of superellipses, from an ellipse on."""
THINNEST, OPEN = 2.2, 2.2
"""Pixels of a thickness at least, and height over thickness at least."""
STEPS, ROOTS = 24, 0.35
"""Places along an arch, and how far its legs go on into the thing, in heights."""
SPACED = 0.02
"""Way between bases along the outline, in sides of the thing."""
USUAL, SEED = 400, 4
"""How many arches anywhere tell what is usual, and what draws them."""
SPREAD = 3.0
"""Difference of colour (OpenCV's Lab, tints counted twice) that is not seen."""
COMMON, COMMON_PART = 97, 75
"""Per cent of the usual arches, and of thirds of them, that stand out less than the common one."""
TRIED, CLOSER = ((60, 30), (10, 80), (3, 160)), (0.5, 0.25, 0.12)
"""In each round, how many good arches are kept and tried around each; how far from it these are."""
CLEAR = 5.0
"""How much more than the common arch a handle stands out."""


@dataclass(frozen=True, eq=False, slots=True)
class Arches:
    """M arches. base, up: (M, 2) middle between the feet, and unit vector to the top.

    half, high, form, thick: (M,) half of the way between the feet, height, exponent, thickness.
    """

    base: FloatArray
    up: FloatArray
    half: FloatArray
    high: FloatArray
    form: FloatArray
    thick: FloatArray

    @classmethod
    def none(cls) -> Arches:
        """No arch at all."""
        flat, pair = np.zeros(0), np.zeros((0, 2))
        return cls(pair, pair, flat, flat, flat, flat)

    def kept(self, which: NDArray) -> Arches:
        """Some of them."""
        return Arches(**{one.name: getattr(self, one.name)[which] for one in fields(self)})

    def course(self) -> tuple[FloatArray, FloatArray]:
        """(M, N, 2) places along each from foot to foot, and the unit normals to its outside."""
        # Many have one form at different places.
        forms = np.stack([self.half, self.high, self.form], 1)
        forms, which = np.unique(forms, axis=0, return_inverse=True)
        local, normal = _forms(forms)
        frame = np.stack([np.stack([-self.up[:, 1], self.up[:, 0]], 1), self.up], 1)
        local, normal = local[which.ravel()], normal[which.ravel()]
        return self.base[:, None] + local @ frame, normal @ frame

    def drawn(self, shape: tuple[int, ...], wider: float = 0.0) -> BoolArray:
        """(H, W) where they are; wider: pixels by which they are thicker than they seem."""
        out = np.zeros(shape[:2], np.uint8)
        for places, thick in zip(self.course()[0], self.thick, strict=True):
            line = np.rint(places * 16).astype(np.int32)
            cv2.polylines(out, [line], False, 1, max(1, round(thick + wider)), shift=4)
        return out.astype(bool)


def _forms(forms: FloatArray) -> tuple[FloatArray, FloatArray]:
    """(M, N, 2) places aside and up along arches, (M, 3) half, high and form; outward normals."""
    half, high, form = (forms[:, k, None] for k in range(3))
    turn = np.linspace(0, np.pi, 4 * STEPS)
    x = -np.sign(np.cos(turn)) * np.abs(np.cos(turn)) ** (2 / form) * half
    y = np.sin(turn).clip(0) ** (2 / form) * high
    x, y = (
        np.concatenate(v, 1) for v in ((x[:, :1], x, x[:, -1:]), (-ROOTS * high, y, -ROOTS * high))
    )
    way = np.cumsum(np.hypot(np.diff(x, prepend=x[:, :1]), np.diff(y, prepend=y[:, :1])), 1)
    even = np.linspace(0, 1, STEPS)
    at = np.array([np.searchsorted(one, even * one[-1]) for one in way]).clip(0, x.shape[1] - 1)
    places = np.stack([np.take_along_axis(v, at, 1) for v in (x, y)], 2)
    along = np.gradient(places, axis=1)
    along /= np.linalg.norm(along, axis=2, keepdims=True) + 1e-9
    # From the left foot over the top to the right one: outside is on the left of the way.
    return places, np.stack([-along[..., 1], along[..., 0]], 2)


@dataclass(frozen=True, eq=False, slots=True)
class _Ground:
    """A picture where arches are sought: Lab (h, w, 3) smoothed for a thickness, and the mask."""

    lab: NDArray[np.float32]
    mask: BoolArray

    def standing_out(self, arches: Arches) -> tuple[FloatArray, BoolArray, BoolArray]:
        """(2, 4, M, 3) how far arches and thirds of them differ from outside and inside.

        Also (M,) which of them can be seen well enough, and which touch the mask nowhere.
        """
        places, normal = arches.course()
        gap = (0.85 * arches.thick + 1.2)[:, None, None]
        (own, free), *sides = (
            self._at(at) for at in (places, places + normal * gap, places - normal * gap)
        )
        third = STEPS // 3
        parts = [slice(0, STEPS), *(slice(k * third, (k + 1) * third) for k in range(3))]
        apart, seen = [], []
        for other, clear in sides:
            both = (free & clear).astype(np.float32)
            for part in parts:
                weight = both[:, part]
                much = weight.sum(1)
                step = ((own - other)[:, part] * weight[..., None]).sum(1)
                apart.append(step / np.maximum(much, 1)[:, None])
                seen.append(much / weight.shape[1])
        share = np.array(seen).reshape(2, 4, -1)
        enough = (share[0, 0] > 0.5) & (share[1, 0] > 0.35) & (share[0, 1:].min(0) > 0.2)
        alone = np.all([clear.all(1) for _, clear in sides], 0) & free.all(1)
        return np.array(apart).reshape(2, 4, -1, 3), enough, alone

    def _at(self, places: FloatArray) -> tuple[NDArray[np.float32], BoolArray]:
        """(M, N, 3) colours at places, and whether they are in the picture and off the mask."""
        x, y = np.rint(places[..., 0]).astype(int), np.rint(places[..., 1]).astype(int)
        height, width = self.mask.shape
        there = (x >= 0) & (y >= 0) & (x < width) & (y < height)
        x, y = x.clip(0, width - 1), y.clip(0, height - 1)
        return self.lab[y, x], there & ~self.mask[y, x]


@dataclass(frozen=True, eq=False, slots=True)
class _Usual:
    """What arches and thirds of them differ by anywhere: whitening (3, 3) and common strengths."""

    whole: FloatArray
    part: FloatArray
    common: float
    common_part: float

    @classmethod
    def of(cls, apart: FloatArray) -> _Usual:
        """apart: (2, 4, M, 3)."""
        whole, part = _whitening(apart[:, 0]), _whitening(apart[:, 1:])
        strong = np.percentile(_strength(apart[:, 0] @ whole), COMMON)
        strong_part = np.percentile(_strength(apart[:, 1:] @ part), COMMON_PART)
        return cls(whole, part, max(float(strong), 1.0), max(float(strong_part), 1.0))

    def whole_clear(self, apart: FloatArray) -> FloatArray:
        """(M,) how much more than the common one arches stand out, (2, 4, M, 3)."""
        return _strength(apart[:, 0] @ self.whole) / self.common

    def clear(self, apart: FloatArray) -> FloatArray:
        """(M,) the same, or less where a third of one stands out less."""
        part = _strength(apart[:, 1:] @ self.part).min(0) / self.common_part
        return np.minimum(self.whole_clear(apart), 1.6 * part)


def _whitening(apart: FloatArray) -> FloatArray:
    flat = apart.reshape(-1, 3)
    spread = flat.T @ flat / max(len(flat), 1) + SPREAD**2 * np.eye(3)
    return np.asarray(np.linalg.cholesky(np.linalg.inv(spread)), float)


def _strength(apart: FloatArray) -> FloatArray:
    """How far bands differ to the same side from both of theirs, (2, …, 3), if these are alike."""
    mean = apart.sum(0)
    mean = mean / (np.linalg.norm(mean, axis=-1, keepdims=True) + 1e-6)
    least = (apart * mean).sum(-1).min(0)
    unlike = np.linalg.norm(apart[0] - apart[1], axis=-1)
    return np.maximum(least - 0.5 * unlike, 0)


def handle_of(image: NDArray[np.uint8], mask: BoolArray, side: float) -> tuple[Arches, float]:
    """The clearest handle of a mask (h, w), as one arch or none, and how clear it is.

    image: (h, w, 3) the mask's surroundings. side: longer side of the mask, pixels.
    """
    lab = cv2.cvtColor(image, cv2.COLOR_RGB2LAB).astype(np.float32)
    lab[..., 1:] *= 2
    near = grow(mask, 2)

    def clearest(number: int) -> tuple[Arches, float]:
        thickness = max(THINNEST, THICK[number] * side)
        draw = np.random.default_rng((SEED, number))
        soft = cv2.GaussianBlur(lab, (0, 0), max(0.5, thickness / 4)).astype(np.float32)
        ground = _Ground(soft, near)
        arches = _beside(mask, side, thickness)
        apart, _, alone = ground.standing_out(_anywhere(arches, mask.shape, draw))
        if np.count_nonzero(alone) < 40:
            return Arches.none(), 0.0
        return _clearest(ground, arches, _Usual.of(apart[:, :, alone]), draw)

    return max(side_by_side(clearest, range(len(THICK))), key=lambda found: found[1])


def _beside(mask: BoolArray, side: float, thickness: float) -> Arches:
    """Arches of many forms all around the outline of a mask."""
    base, up = _outline(mask, SPACED * side)
    forms = [
        (half * side, high * half * side, form)
        for half in WIDE
        for high in HIGH
        for form in FORMS
        if high * half * side > OPEN * thickness + 2 and half * side > 1.6 * thickness
    ]
    if not forms or not len(base):
        return Arches.none()
    half, high, form = np.array(forms, float).T
    count = len(forms)
    return Arches(
        np.repeat(base, count, 0),
        np.repeat(up, count, 0),
        np.tile(half, len(base)),
        np.tile(high, len(base)),
        np.tile(form, len(base)),
        np.full(len(base) * count, thickness),
    )


def _outline(mask: BoolArray, spaced: float) -> tuple[FloatArray, FloatArray]:
    """(K, 2) places along the outline of a mask, and unit normals to its outside there."""
    found, _ = cv2.findContours(mask.astype(np.uint8), cv2.RETR_EXTERNAL, cv2.CHAIN_APPROX_NONE)
    if not found:
        return np.zeros((0, 2)), np.zeros((0, 2))
    line = max(found, key=cv2.contourArea)[:, 0].astype(float)
    if len(line) < 16:
        return np.zeros((0, 2)), np.zeros((0, 2))
    reach = max(2, round(1.5 * spaced))
    around = np.concatenate([line[-reach:], line, line[:reach]])
    kernel = np.ones(2 * reach + 1) / (2 * reach + 1)
    soft = np.stack([np.convolve(around[:, k], kernel, "valid") for k in (0, 1)], 1)
    along = np.roll(soft, -reach, 0) - np.roll(soft, reach, 0)
    along /= np.linalg.norm(along, axis=1, keepdims=True) + 1e-9
    normal = np.stack([along[:, 1], -along[:, 0]], 1)
    every = max(1, round(spaced))
    base, normal = line[::every], normal[::every]
    x, y = np.clip(np.rint(base + 3 * normal), 0, np.array(mask.shape[::-1]) - 1).astype(int).T
    return base, -normal if mask[y, x].mean() > 0.5 else normal


def _anywhere(arches: Arches, shape: tuple[int, ...], draw: np.random.Generator) -> Arches:
    """Some of the arches, put anywhere."""
    if not len(arches.half):
        return arches
    some = arches.kept(draw.integers(len(arches.half), size=USUAL))
    return replace(some, base=draw.uniform((0, 0), shape[1::-1], (USUAL, 2)))


def _clearest(
    ground: _Ground, arches: Arches, usual: _Usual, draw: np.random.Generator
) -> tuple[Arches, float]:
    """The clearest arch near one of some, and how clear it is."""
    apart, enough, _ = ground.standing_out(arches)
    # A third of an arch that is a little off may miss what the whole still shows.
    whole = np.where(enough, usual.whole_clear(apart), 0)
    found = arches.kept(np.argsort(-whole, kind="stable")[: TRIED[0][0]])
    clear = np.zeros(len(found.half))
    for (kept, tries), far in zip(TRIED, CLOSER, strict=True):
        found = found.kept(np.argsort(-clear, kind="stable")[:kept])
        tried = _around(found, far, tries, draw)
        apart, enough, _ = ground.standing_out(tried)
        values = np.where(enough, usual.clear(apart), 0).reshape(-1, tries)
        best = values.argmax(1) + tries * np.arange(len(values))
        found, clear = tried.kept(best), values.max(1)
    first = int(np.argmax(clear)) if len(clear) else 0
    return found.kept(np.array([first])) if len(clear) else found, float(clear.max(initial=0))


def _around(arches: Arches, far: float, tries: int, draw: np.random.Generator) -> Arches:
    """So many arches like each, the first of them the same."""
    one = arches.kept(np.repeat(np.arange(len(arches.half)), tries))
    unit = draw.uniform(-1, 1, (6, len(one.half)))
    unit[:, ::tries] = 0
    turn, sideways, upwards, wider, higher, fuller = far * unit
    aside = np.stack([-one.up[:, 1], one.up[:, 0]], 1)
    moved = aside * (sideways * one.half)[:, None] + one.up * (0.5 * upwards * one.high)[:, None]
    turned = one.up * np.cos(0.5 * turn)[:, None] + aside * np.sin(0.5 * turn)[:, None]
    return Arches(
        one.base + moved,
        turned,
        one.half * np.exp(0.6 * wider),
        one.high * np.exp(0.6 * higher),
        np.clip(one.form * np.exp(fuller), 1.6, 8.0),
        one.thick,
    )
