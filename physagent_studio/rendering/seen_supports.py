"""What of a support the photo shows: only there can it hide an object.

A support is a box, a slab or a ramp, and reaches a little beyond what it stands for: past rounded
corners, under the apron of a table, or because the camera is off by a degree. An object that falls
behind such a margin would have a piece cut out of it in front of the bare wall. So the outline of
each support is drawn back to where the picture changes, by a cut between the colours inside and
outside of it (GrabCut; Rother, Kolmogorov and Blake 2004), where there is such a line near by.
"""

import cv2
import numpy as np
from numpy.typing import NDArray

from physagent_studio.rendering.frame import Picture

_REACH = 0.045
"""How far within its outline the true one is sought, parts of the picture's longer side."""
_UNDECIDED = 0.1
"""Share of a cut that may run as far within as is sought, and no farther: there is no line then."""
_CONTRAST = 8.0
"""By how much the colours on both sides of a line differ at least, of 255 in L*a*b*."""
_SIDE = 416
"""Longer side of the picture that is cut, pixels: half of a usual one, four times as quick."""
_LEAST = 20
"""Pixels of a margin, and of what a support is seen by, at least."""
_ROUNDS = 2
_OUTSIDE, _INSIDE, _MAYBE_OUT, _MAYBE_IN = 0, 1, 2, 3
"""The labels of `cv2.grabCut`."""


def margins_of(plate: Picture, solid: NDArray[np.int16]) -> NDArray[np.bool_]:
    """(H, W) where a support is computed and the plate (H, W, 3) shows what is behind it.

    solid: (H, W) index of the support that each pixel is computed to show, −1 for none.
    """
    height, width = solid.shape
    scale = min(1.0, _SIDE / max(height, width))
    small = (max(1, round(width * scale)), max(1, round(height * scale)))
    shrunk = cv2.resize(plate, small, interpolation=cv2.INTER_AREA)
    colors = np.asarray(cv2.cvtColor(shrunk, cv2.COLOR_RGB2LAB), np.uint8)
    coarse = cv2.resize(solid, small, interpolation=cv2.INTER_NEAREST)
    found = np.zeros((height, width), bool)
    for index in range(int(coarse.max(initial=-1)) + 1):
        margin = _margin(colors, coarse == index, coarse >= 0)
        if margin.any():
            # What it borders on beside the support is none either, or its rim would stay.
            rim = cv2.dilate(margin.astype(np.uint8), _disc(1)) > 0
            whole = margin | (rim & (coarse != index))
            fine = cv2.resize(whole.astype(np.float32), (width, height))
            found |= (fine > 0.5) & (solid == index)
    return found


def _margin(
    colors: Picture, own: NDArray[np.bool_], any_solid: NDArray[np.bool_]
) -> NDArray[np.bool_]:
    """(h, w) what of a support's own pixels looks like what is beside it."""
    reach = max(2, round(_REACH * max(own.shape)))
    core = cv2.erode(own.astype(np.uint8), _disc(reach), borderValue=1) > 0
    near = cv2.dilate(own.astype(np.uint8), _disc(reach)) > 0
    beside = near & ~any_solid
    none = np.zeros_like(own)
    if min(np.count_nonzero(core), np.count_nonzero(beside)) < _LEAST:
        return none
    labels = np.full(own.shape, _OUTSIDE, np.uint8)
    labels[beside] = _MAYBE_OUT
    labels[own] = _MAYBE_IN
    labels[core | (any_solid & ~own)] = _INSIDE
    # As far again around it: what lies farther away has other colours.
    window = cv2.boundingRect(cv2.dilate(near.astype(np.uint8), _disc(reach)))
    here = np.s_[window[1] : window[1] + window[3], window[0] : window[0] + window[2]]
    cut = np.ascontiguousarray(labels[here])
    if not (cut == _OUTSIDE).any():
        return none
    cv2.setRNGSeed(0)
    models = np.zeros((1, 65)), np.zeros((1, 65))
    cv2.grabCut(
        np.ascontiguousarray(colors[here]),
        cut,
        (0, 0, 1, 1),
        *models,
        _ROUNDS,
        cv2.GC_INIT_WITH_MASK,
    )
    outside = none.copy()
    outside[here] = (cut == _OUTSIDE) | (cut == _MAYBE_OUT)
    return _decided(colors, own & outside, own, core)


def _decided(
    colors: Picture, gone: NDArray[np.bool_], own: NDArray[np.bool_], core: NDArray[np.bool_]
) -> NDArray[np.bool_]:
    """The pieces of what is cut off that end at a line, not just where the search ended."""
    kept = np.zeros_like(gone)
    count, pieces = cv2.connectedComponents(gone.astype(np.uint8), connectivity=4)
    limit = cv2.dilate(core.astype(np.uint8), _disc(1)) > 0
    for index in range(1, count):
        piece = pieces == index
        around = cv2.dilate(piece.astype(np.uint8), _disc(2)) > 0
        line = around & own & ~gone
        undecided = np.count_nonzero(line & limit) > _UNDECIDED * np.count_nonzero(line)
        if undecided or np.count_nonzero(piece) < _LEAST:
            continue
        if line.any() and _apart(colors[piece], colors[line]) > _CONTRAST:
            kept |= piece
    return kept


def _apart(one: NDArray[np.uint8], other: NDArray[np.uint8]) -> float:
    """How far the medians of two sets of colours (K, 3) are apart."""
    return float(np.linalg.norm(np.median(one, axis=0) - np.median(other, axis=0)))


def _disc(radius: int) -> NDArray[np.uint8]:
    side = 2 * radius + 1
    return np.asarray(cv2.getStructuringElement(cv2.MORPH_ELLIPSE, (side, side)), np.uint8)
