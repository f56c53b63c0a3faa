"""Lines painted on the ground: straight stripes that differ from what is on both of their sides."""

from collections.abc import Sequence
from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from physagent_studio.arrays import FloatArray
from physagent_studio.reconstruction.photo.line_segments import joined, segments
from physagent_studio.reconstruction.photo.regions import BoolArray, grow
from physagent_studio.records.case import Image


@dataclass(frozen=True, slots=True)
class StripeSettings:
    """What a painted line looks like."""

    longest_side_px: int = 720  # 360..1440: of the picture in which stripes are looked for
    # 1..30: of stripes there, each about 1.4 times the one before
    widths_px: tuple[float, ...] = (2.0, 3.0, 4.5, 6.5, 9.0, 13.0)
    min_step_levels: float = 8.0  # 3..30: of Lab, to either side
    min_seen_share: float = 0.7  # 0.4..1: of its length on which it shows; the rest may be worn
    max_stripes: int = 12  # count, 4..40: the clearest; the rest is pattern
    samples_count: int = 48  # 16..200: along a stripe


STRIPE = StripeSettings()


@dataclass(frozen=True, slots=True)
class Stripe:
    """ends: (x, y) twice, pixels. width: pixels. strength: 0 … 1 by contrast and length.

    color: RGB in the middle.
    """

    ends: tuple[tuple[float, float], tuple[float, float]]
    width: float
    strength: float
    color: tuple[int, int, int]


def painted_lines(image: Image, covered: BoolArray | None = None) -> list[Stripe]:
    """Stripes in a picture, the clearest first, each once.

    covered: pixels (H, W) of objects, whose own stripes do not count.
    """
    factor = min(1.0, STRIPE.longest_side_px / max(image.shape[:2]))
    small = cv2.resize(image, None, fx=factor, fy=factor, interpolation=cv2.INTER_AREA)
    small = np.ascontiguousarray(small).astype(np.uint8)
    taken = np.zeros(small.shape[:2], bool)
    if covered is not None:
        size = (small.shape[1], small.shape[0])
        taken = grow(cv2.resize(covered.astype(np.uint8), size).astype(bool), 4)
    lab = cv2.cvtColor(cv2.GaussianBlur(small, (0, 0), 0.7), cv2.COLOR_RGB2LAB).astype(np.float32)
    ends, lengths = joined(segments(small, 0.05))
    found: list[Stripe] = []
    for pair, length in zip(ends, lengths, strict=True):
        stripe = _stripe(small, lab, taken, pair, float(length))
        if stripe is not None:
            found.append(stripe)
    found.sort(key=lambda stripe: -stripe.strength)
    return [_scaled(stripe, 1 / factor) for stripe in _each_once(found)[: STRIPE.max_stripes]]


def _stripe(
    small: Image,
    lab: NDArray[np.float32],
    taken: BoolArray,
    ends: FloatArray,
    length: float,
) -> Stripe | None:
    """The stripe of which a straight edge is one side; None where it is no stripe's."""
    start, way = ends[0], ends[1] - ends[0]
    reach = float(np.hypot(*way))
    if reach < 12:
        return None
    normal = np.array([-way[1], way[0]]) / reach
    middle = start + np.linspace(0.03, 0.97, STRIPE.samples_count)[:, None] * way
    column = np.clip(middle[:, 0].round().astype(int), 0, taken.shape[1] - 1)
    row = np.clip(middle[:, 1].round().astype(int), 0, taken.shape[0] - 1)
    free = ~taken[row, column]
    if free.mean() < 0.5:
        return None
    best: tuple[float, float, float] | None = None
    for width in STRIPE.widths_px:
        for side in (-1, 1):
            step = _steps(lab, middle[free], normal, side * width / 2, width)
            seen = float((step > STRIPE.min_step_levels).mean())
            value = float(np.median(step)) * seen
            if seen > STRIPE.min_seen_share and (best is None or value > best[0]):
                best = value, side * width / 2, width
    if best is None:
        return None
    value, off, width = best
    share = min(length / reach, 1.0)
    strength = min(value / 50.0, 1.0) * share * min(reach / (0.25 * max(small.shape)), 1.0)
    line = ends + off * normal
    inside = _sampled(small.astype(np.float32), middle[free] + off * normal)
    red, green, blue = (int(v) for v in np.median(inside, axis=0))
    (x0, y0), (x1, y1) = line.tolist()
    return Stripe(((x0, y0), (x1, y1)), width, float(strength), (red, green, blue))


def _steps(
    lab: NDArray[np.float32], middle: FloatArray, normal: FloatArray, off: float, width: float
) -> FloatArray:
    """(N,) how much a stripe differs from both sides, less by how much the sides differ."""
    inside = _sampled(lab, middle + off * normal)
    beside = width / 2 + max(1.5, 0.35 * width)
    first = _sampled(lab, middle + (off + beside) * normal)
    other = _sampled(lab, middle + (off - beside) * normal)
    step = np.minimum(
        np.linalg.norm(inside - first, axis=1), np.linalg.norm(inside - other, axis=1)
    )
    return np.asarray(step - 0.5 * np.linalg.norm(first - other, axis=1), float)


def _sampled(picture: NDArray[np.float32], points: FloatArray) -> NDArray[np.float32]:
    x, y = points[None, :, 0].astype(np.float32), points[None, :, 1].astype(np.float32)
    found = cv2.remap(picture, x, y, cv2.INTER_LINEAR, borderMode=cv2.BORDER_REPLICATE)
    return found[0].astype(np.float32)


def _each_once(found: Sequence[Stripe]) -> list[Stripe]:
    """Both edges of a stripe say the same."""
    kept: list[Stripe] = []
    for stripe in found:
        if not any(_same(stripe, other) for other in kept):
            kept.append(stripe)
    return kept


def _same(one: Stripe, other: Stripe) -> bool:
    a, b = np.array(one.ends), np.array(other.ends)
    way = b[1] - b[0]
    normal = np.array([-way[1], way[0]]) / max(float(np.hypot(*way)), 1e-9)
    return bool(np.abs((a - b[0]) @ normal).max() < max(one.width, other.width) + 3)


def _scaled(stripe: Stripe, by: float) -> Stripe:
    (x0, y0), (x1, y1) = stripe.ends
    ends = ((x0 * by, y0 * by), (x1 * by, y1 * by))
    return Stripe(ends, stripe.width * by, stripe.strength, stripe.color)
