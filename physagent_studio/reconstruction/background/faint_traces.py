"""What is left of shade, light and mirror images once the hole is filled: soft, faint, of no edge.

Around the place where a thing stood the ground has the tone that it has farther off, and keeps its
texture. Only what is faint is evened out: what stands out clearly is paint, or something else.
"""

from __future__ import annotations

from collections.abc import Sequence

import cv2
import numpy as np
from numpy.typing import NDArray

from physagent_studio.reconstruction.background.ground_tones import Tones
from physagent_studio.reconstruction.background.surfaces import BEYOND, under
from physagent_studio.reconstruction.photo.regions import BoolArray, bounds
from physagent_studio.records.case import Image

FloatImage = NDArray[np.float32]
LONGER_SIDE = 208
"""Longer side of the picture in which traces are looked for, pixels: they are soft."""
REACH_IN_SIZES = (0.7, 1.5)
"""Up to where traces are taken off whole, and where none are any more, in sizes of the thing
(roots of its area)."""
TEXTURE_SIGMA = 0.06
"""Standard deviation of the blur that leaves traces and takes texture away, in sizes."""
TONE_SIGMA = 0.9
"""The same of the blur in which the tone of the ground farther off is taken over, in sizes."""
FAINT, CLEAR = 9.0, 18.0
"""Traces up to the first are taken off whole, from the second on they are something else, L*a*b*.
What `cast_shadows` takes for shade is darker than 7."""
LOW = (0.3, 0.7)
"""Traces lie below the first share of the thing's height, from below, and none above the second."""
BORDER = 0.15
"""Where traces end at the border of the face on which the thing stands, in sizes of the thing."""
STACKED, SOLE = 0.3, 3
"""Share of a thing's width below which there is another one, within so many pixels."""
NATURAL = 80.0
"""Percentile of the unevenness of all ground around; no more than that is no trace, and what is
there on more of the ground neither."""
TOLD = 0.01
"""Share of ground farther off in that blur, at least, for its tone to be taken over whole."""
LEAST_GROUND = 60
"""Pixels of ground farther off that have to be seen."""


def without_traces(plate: Image, masks: Sequence[BoolArray], faces: NDArray[np.int64]) -> Image:
    """The plate (H, W, 3) with the ground evened out around the feet of the masked things.

    faces: (H, W) numbers of the faces on which things stand, as `surfaces` gives them.
    """
    factor = min(1.0, LONGER_SIDE / max(faces.shape))
    size = (max(8, round(faces.shape[1] * factor)), max(8, round(faces.shape[0] * factor)))
    kinds = cv2.resize(faces.astype(np.int32), size, interpolation=cv2.INTER_NEAREST_EXACT)
    small = cv2.resize(plate, size, interpolation=cv2.INTER_AREA).astype(np.float32) / 255
    before = np.asarray(cv2.cvtColor(small, cv2.COLOR_RGB2LAB), np.float32)
    things = [cv2.resize(m.astype(np.uint8), size, interpolation=cv2.INTER_AREA) > 0 for m in masks]
    lab = before
    for own in things:
        if own.any() and not _stacked(own, things):
            face = under(own, kinds.astype(np.int64)) & (kinds != BEYOND)
            lab = lab + _missing_tone(lab, own, face)
    if lab is before:
        return plate
    gain = cv2.cvtColor(lab, cv2.COLOR_LAB2RGB) + 0.02
    gain = gain / (np.asarray(cv2.cvtColor(before, cv2.COLOR_LAB2RGB)) + 0.02)
    whole = cv2.resize(gain, faces.shape[::-1], interpolation=cv2.INTER_CUBIC)
    return np.clip(np.round(plate * whole), 0, 255).astype(np.uint8)


def _stacked(own: BoolArray, things: Sequence[BoolArray]) -> bool:
    """Whether a thing (h, w) stands on one of the others: it leaves no traces on the ground."""
    x0, _, x1, y1 = bounds(own)
    below = np.any([thing[y1 : y1 + SOLE, x0:x1] for thing in things if thing is not own], axis=0)
    return bool(np.any(below) and np.any(below, axis=0).mean() > STACKED)


def _missing_tone(lab: FloatImage, own: BoolArray, face: BoolArray) -> FloatImage:
    """What has to be added to a picture (h, w, 3) in L*a*b* for a thing's traces to be gone.

    own: (h, w) where the thing stood. face: (h, w) what it stood on.
    """
    _, y0, _, y1 = bounds(own)
    side = float(np.count_nonzero(own)) ** 0.5
    away = cv2.distanceTransform((~own).astype(np.uint8), cv2.DIST_L2, 5) / side
    inner, outer = REACH_IN_SIZES
    low = (np.arange(len(own))[:, None] - y1) / (y1 - y0) + LOW[1]
    within = cv2.distanceTransform(np.pad(face, 1, mode="edge").astype(np.uint8), cv2.DIST_L2, 5)
    window = _eased((outer - away) / (outer - inner)) * _eased(low / (LOW[1] - LOW[0]))
    window *= _eased(within[1:-1, 1:-1] / (side * BORDER))
    around = face & (away < 2 * outer) & (low > 0)
    beyond = around & (away > outer)
    if np.count_nonzero(beyond) < LEAST_GROUND:
        return np.zeros_like(lab)
    tones = Tones.of(lab, around & (away > inner), own)
    off = tones.lit - lab
    out = np.zeros_like(lab)
    fine = max(1.0, TEXTURE_SIGMA * side)
    for kind in np.unique(tones.which[(window > 0) & (tones.which >= 0)]):
        here = (face & (tones.which == kind)).astype(np.float32)
        fair = here * _like(off)
        usual, told = _mean_of(off, fair * beyond, TONE_SIGMA * side)
        rest = off - usual
        trace, share = _mean_of(rest, here * _like(rest), fine)
        known = here.astype(bool) & around & (share > 0.5)
        if np.count_nonzero(known) >= LEAST_GROUND:
            out += _beyond_natural(trace, known) * (share * window * _eased(told / TOLD))[..., None]
    return out


def _like(off: FloatImage) -> FloatImage:
    """(h, w) how surely ground that is off by so much (h, w, 3) is the same ground, 0 … 1."""
    return _eased((CLEAR - np.linalg.norm(off, axis=-1)) / (CLEAR - FAINT))


def _beyond_natural(trace: FloatImage, known: BoolArray) -> FloatImage:
    """What a trace (h, w, 3) is beyond the unevenness of the ground where that is known (h, w).

    Lightness and colour each by itself: concrete is uneven in the one alone.
    """
    out = trace.copy()
    for part in (slice(0, 1), slice(1, 3)):
        size = np.linalg.norm(trace[..., part], axis=-1)
        natural = float(np.percentile(size[known], NATURAL))
        out[..., part] *= np.maximum(1 - (natural / np.maximum(size, 1e-3)) ** 2, 0)[..., None]
    return out


def _eased(share: NDArray) -> FloatImage:
    """A smooth step from 0 to 1."""
    part = np.clip(share, 0, 1)
    return np.asarray(part * part * (3 - 2 * part), np.float32)


def _mean_of(values: FloatImage, weight: FloatImage, sigma: float) -> tuple[FloatImage, FloatImage]:
    """Values (h, w, 3) blurred over where they have weight (h, w), and how much weight that is."""
    total = cv2.GaussianBlur(values * weight[..., None], (0, 0), sigma)
    count = np.asarray(cv2.GaussianBlur(weight, (0, 0), sigma), np.float32)
    return np.asarray(total / (count[..., None] + 1e-3), np.float32), count
