"""Edges of what stays, kept where they are seen right beside a thing and drawn where it hid them.

A hole is wider than its thing, and a little deeper at its foot: an edge that runs into that margin
and looks there as it does outside needs no filling. Behind the thing pieces that are copied, and
smooth fills, meet an edge's line but seldom show the edge: joints of tiles break off, the rim of a
sheet of glass fades. So its colours are measured where it is seen, and laid over the fill.
"""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from physagent_studio.arrays import FloatArray, FloatImage
from physagent_studio.reconstruction.photo.line_segments import Segments
from physagent_studio.reconstruction.photo.regions import BoolArray, grow
from physagent_studio.records.case import Image


@dataclass(frozen=True, slots=True)
class ThroughSettings:
    """How an edge is measured beside a hole."""

    across_px: int = 5  # 3..10: to either side of it
    before_px: int = 22  # 8..60: of it, right before the hole, that are looked at
    least_px: int = 10  # 4..40: of it that have to be seen
    clear_levels: float = 12.0  # 4..40: by which it stands out or steps, at least


THROUGH = ThroughSettings()


def seen_beside(photo: Image, things: BoolArray, hole: BoolArray, found: Segments) -> BoolArray:
    """(H, W) strips of the hole (H, W) along edges that look there as they do outside of it.

    things: (H, W) the things themselves. found: the picture's edges.
    """
    soft = cv2.GaussianBlur(photo, (0, 0), 0.7).astype(np.float32)
    off_px = 2  # 1..5: beside a thing, where its soft outline is
    closed = grow(things, off_px)
    out = np.zeros(hole.shape, np.uint8)
    farther = float(np.count_nonzero(hole)) ** 0.5
    for one, other in found.ends:
        length = float(np.linalg.norm(other - one))
        way = (other - one) / max(length, 1e-9)
        for start, ahead in ((one, way), (other, -way)):
            run = _seen_on(soft, closed, hole, start, ahead, length + farther)
            if run is not None:
                ends = np.round(start + np.array(run)[:, None] * ahead).astype(int)
                kept_px = 7  # 1..13: width of what stays of an edge
                cv2.line(out, ends[0].tolist(), ends[1].tolist(), 1, kept_px)
    return (out > 0) & hole & ~closed


def _seen_on(
    soft: FloatImage,
    closed: BoolArray,
    hole: BoolArray,
    start: FloatArray,
    way: FloatArray,
    length: float,
) -> tuple[int, int] | None:
    """From where to where, pixels from its start, an edge is in the hole and looks as before."""
    x, y = _strip(start, way, np.arange(0.0, length), THROUGH.across_px)
    inside = (x[:, [0, -1]] > 0) & (x[:, [0, -1]] < hole.shape[1] - 1)
    inside &= (y[:, [0, -1]] > 0) & (y[:, [0, -1]] < hole.shape[0] - 1)
    count = len(x) if inside.all() else int(np.argmin(inside.all(1)))
    middle = _at(hole, x[:count, THROUGH.across_px], y[:count, THROUGH.across_px])
    into = int(np.argmax(middle)) if middle.any() else 0
    if into < THROUGH.least_px:
        return None
    look = cv2.remap(soft, x[:count], y[:count], cv2.INTER_LINEAR)
    usual = np.median(look[max(0, into - THROUGH.before_px) : into], axis=0)
    if float(np.ptp(usual.mean(-1))) < THROUGH.clear_levels:
        return None
    free = ~_at(closed, x[:count], y[:count])
    off = (look - usual).mean(-1) * free / np.maximum(free.sum(1, keepdims=True), 1)
    # 3..30 and 1..10: by which it may look different in the hole, and darker: in shade
    unlike_levels, darker_levels = 8.0, 4.0
    same = (np.abs(off).sum(1) < unlike_levels) & (off.sum(1) > -darker_levels)
    same &= free.sum(1) > THROUGH.across_px
    # It may be lost for two pixels.
    lost = cv2.dilate(same[into:].astype(np.uint8)[:, None], np.ones((5, 1), np.uint8))[:, 0] == 0
    last = into + (int(np.argmax(lost)) if lost.any() else len(lost)) - 1
    return (into, last) if last - into > 1 else None


def restored(photo: Image, plate: Image, kept: BoolArray) -> Image:
    """The plate (H, W, 3) with what is kept (H, W) of the photo; it fades in at its rim."""
    share = cv2.GaussianBlur(kept.astype(np.float32), (0, 0), 1.2)
    share = (2 * share - 0.5).clip(0, 1)[..., None] * kept[..., None]
    return np.round(plate * (1 - share) + photo * share).astype(np.uint8)


def running_in(hole: BoolArray, found: Segments) -> FloatArray:
    """Lines (N, 2, 2), pixels, from where edges run into the hole (H, W) to their ends in it."""
    out = []
    for one, other in found.ends:
        share = np.linspace(0, 1, int(np.linalg.norm(other - one)) + 1)[:, None]
        within = _at(hole, *(one + share * (other - one)).T)
        if within.sum() > 4 and (~within).sum() >= THROUGH.least_px:
            out.append(one + share[np.flatnonzero(within)[[0, -1]]] * (other - one))
    return np.array(out).reshape(-1, 2, 2)


def drawn(photo: Image, plate: Image, hole: BoolArray, lines: FloatArray) -> Image:
    """The plate (H, W, 3) with lines (N, 2, 2), pixels, drawn through the hole (H, W)."""
    soft = cv2.GaussianBlur(photo, (0, 0), 0.6).astype(np.float32)
    out = plate.astype(np.float32)
    least_likeness = 0.6  # 0..1: between what is seen of an edge at its two ends
    for one, other in lines:
        length = float(np.linalg.norm(other - one))
        way = (other - one) / max(length, 1e-9)
        first, last = _look(soft, hole, one, way), _look(soft, hole, other, -way)
        # Seen the other way, left is right.
        looks = [v for v in (first, None if last is None else last[::-1]) if v is not None]
        if not looks or (
            len(looks) == 2 and _like(looks[0][None], looks[1][None])[0] < least_likeness
        ):
            continue
        along = np.arange(-2.0, length + 2)
        x, y = _strip(one, way, along, THROUGH.across_px)
        share = np.clip(along / max(length, 1e-9), 0, 1).astype(np.float32)[:, None, None]
        look = np.asarray((1 - share) * looks[0] + share * looks[-1], np.float32)
        below = cv2.remap(out, x, y, cv2.INTER_LINEAR, borderMode=cv2.BORDER_REPLICATE)
        _lay(out, hole, _change(look, np.asarray(below, np.float32)), one, way)
    return np.where(hole[..., None], np.clip(np.round(out), 0, 255).astype(np.uint8), plate)


def _strip(
    start: FloatArray, way: FloatArray, along: FloatArray, wide: int
) -> tuple[FloatImage, FloatImage]:
    """x and y (S, T) of a strip around a line, so far along it and to either side."""
    off = np.arange(-wide, wide + 1.0)[:, None] * np.array([-way[1], way[0]])
    spots = (start + along[:, None, None] * way + off).astype(np.float32)
    return np.ascontiguousarray(spots[..., 0]), np.ascontiguousarray(spots[..., 1])


def _at(mask: BoolArray, x: NDArray, y: NDArray) -> BoolArray:
    """Which places are in a mask (H, W)."""
    column, row = (np.asarray(v).round().astype(int) for v in (x, y))
    return mask[row.clip(0, mask.shape[0] - 1), column.clip(0, mask.shape[1] - 1)]


def _look(soft: FloatImage, hole: BoolArray, end: FloatArray, way: FloatArray) -> FloatImage | None:
    """(T, 3) colours across a line right before it runs into the hole; None if it is not clear."""
    farthest_px = 60.0  # 20..150: before the line's end, where it has to be seen
    x, y = _strip(end, -way, np.arange(-6.0, farthest_px), THROUGH.across_px)
    beyond = (x < 0) | (y < 0) | (x > hole.shape[1] - 1) | (y > hole.shape[0] - 1)
    free = np.flatnonzero(~(_at(hole, x, y) | beyond)[:, 1:-1].any(1))
    free = free[free < free[0] + THROUGH.before_px] if len(free) else free
    if len(free) < THROUGH.least_px:
        return None
    # Seen away from the hole, left is right.
    colours = cv2.remap(soft, x[free, ::-1], y[free, ::-1], cv2.INTER_LINEAR)
    look = np.median(colours, axis=0)
    stray_levels = 7.0  # 3..30: by which its colours may vary along it
    clear = float(np.ptp(look.mean(-1))) > THROUGH.clear_levels
    return look if clear and float(np.abs(colours - look).mean()) < stray_levels else None


def _like(one: FloatImage, other: FloatImage) -> FloatArray:
    """(S,) how like two edges (S, T, 3) are in their steps of colour, up to 1."""
    a, b = (v - v.mean(1, keepdims=True) for v in (one, other))
    size = np.maximum((a * a).sum((1, 2)), (b * b).sum((1, 2)))
    return (a * b).sum((1, 2)) / np.maximum(size, 1e-6)


def _change(look: FloatImage, below: FloatImage) -> FloatImage:
    """(S, T, 3) what the fill lacks of an edge, where its sides are as beside the hole."""
    even = _evened(below)
    t = np.linspace(0, 1, look.shape[1])[None, :, None]
    rest = look - ((1 - t) * look[:, :1] + t * look[:, -1:])
    line, step = (rest + rest[:, ::-1]) / 2, (rest - rest[:, ::-1]) / 2
    own, theirs = (v[:, -1:] - v[:, :1] for v in (look, even))
    ratio = (own * theirs).sum(-1, keepdims=True)
    ratio /= np.maximum((own * own).sum(-1, keepdims=True), 25.0)
    wanted = (1 - t) * even[:, :1] + t * even[:, -1:] + line + np.clip(ratio, 0, 1.3) * step
    here = np.asarray(cv2.blur(below, (1, 5)), np.float32).reshape(below.shape)
    beside_levels = 28.0  # 10..100: from which the fill's sides are of other colours
    off = np.abs(here[:, [0, -1]] - look[:, [0, -1]]).mean((1, 2)) / beside_levels
    lacking = np.clip(2 - 2 * off, 0, 1) * np.clip((0.7 - _like(look, here)) / 0.3, 0, 1)
    lacking = cv2.blur(lacking.astype(np.float32), (1, 9)).reshape(-1, 1, 1)
    changed = below + lacking * (wanted - even)
    low, high = look.min(1, keepdims=True) - 6, look.max(1, keepdims=True) + 6
    changed = np.clip(changed, np.minimum(low, below), np.maximum(high, below))
    return (changed - below).astype(np.float32)


def _evened(below: FloatImage) -> FloatImage:
    """The fill (S, T, 3) evened out along a line."""
    half_px = 7  # 2..15: of it
    padded = np.pad(below, ((half_px, half_px), (0, 0), (0, 0)), mode="edge")
    windows = np.lib.stride_tricks.sliding_window_view(padded, 2 * half_px + 1, 0)
    return np.asarray(np.median(windows, -1), np.float32)


def _lay(
    out: FloatImage, hole: BoolArray, change: FloatImage, one: FloatArray, way: FloatArray
) -> None:
    """Adds a change (S, T, 3) along a line to the picture's hole."""
    ends = one + np.array([[-2.0], [len(change) - 3.0]]) * way
    x0, y0 = np.floor(ends.min(0) - THROUGH.across_px).astype(int).clip(0).tolist()
    x1, y1 = np.ceil(ends.max(0) + THROUGH.across_px + 1).astype(int).clip(0).tolist()
    window = slice(y0, y1), slice(x0, x1)
    rows, columns = np.indices(hole[window].shape).astype(np.float32)
    x, y = columns + (x0 - one[0]), rows + (y0 - one[1])
    along, aside = x * way[0] + y * way[1] + 2, y * way[0] - x * way[1] + THROUGH.across_px
    if along.size:
        laid = cv2.remap(change, aside.astype("f4"), along.astype("f4"), cv2.INTER_LINEAR)
        out[window] += laid * hole[window][..., None]
