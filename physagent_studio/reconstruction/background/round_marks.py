"""Round marks on level ground that go on behind what is taken out of a picture: rings, circles.

Found by what is seen of their outlines: on the level plane these are circles, and the normals of
any two of their edges meet in the middle (as in the Hough transform for circles).
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Self

import cv2
import numpy as np
from numpy.typing import NDArray

from physagent_studio.reconstruction.photo.regions import BoolArray, bounds, grow
from physagent_studio.records.case import Image

FloatArray = NDArray[np.float64]
SIDE = 400
"""Longer side of the picture in which edges are looked for."""
AROUND = 1.2
"""How far around the hole, in extents of it."""
EDGES = 1600
"""Edge pixels that vote, at most."""
PAIRS = 40000
"""Pairs of them that are tried."""
COUNTED = 3000
"""Pairs that agree on a circle of their own and are counted, at most."""
ALIKE = 0.06
"""How far two radii, or two middles, may differ and be of one circle, in radii."""
LEAST = 0.05
"""Least radius, as a share of the picture's longer side."""
VOTES = 0.0015
"""Share of the pairs that have to agree on a circle for it to be looked at."""
TRIED = 4
NEAR = 2.0
"""How far from an outline its edge pixels lie, pixels of the small picture."""
ALIGNED = math.cos(math.radians(15.0))
SEEN = 0.3
"""Share of the outline that has to be in view."""
SHOWN = 0.7
"""Share of that along which there has to be an edge."""
ROUGHLY = 0.25
"""Share of a whole ring around the same middle at which edges make it worth a look."""
RINGS = (0.25, 2.5)
"""Sizes of rings around the same middle as one that was found."""
BETTER = 1.6
"""How much more often than along rings that are a little larger or smaller."""
BINS = 72
TURNS = (30, 60, 90, 135, 180, 225, 270, 300, 330)
"""By how many degrees what lies on it may be turned."""
FAR = 1e9
SEED = 3


@dataclass(frozen=True, eq=False, slots=True)
class RoundMark:
    """A circle on level ground. disc: (3, 3) from pixels to the plane in which it is the unit
    circle around the origin."""

    disc: FloatArray

    def scaled(self, x: float, y: float) -> Self:
        """The same in a picture x times as wide and y times as high."""
        return type(self)(self.disc @ np.diag([1 / x, 1 / y, 1.0]))

    def moved(self, x: float, y: float) -> Self:
        """The same in a part of the picture whose corner is at (x, y)."""
        return type(self)(self.disc @ np.array([[1, 0, x], [0, 1, y], [0, 0, 1.0]]))

    def within(self, shape: tuple[int, ...]) -> BoolArray:
        """(H, W) which pixels lie in the circle."""
        y, x = np.indices(shape) + 0.5
        spots = np.stack([x, y, np.ones_like(x)], -1) @ self.disc.T
        return np.asarray((spots[..., :2] ** 2).sum(-1) < spots[..., 2] ** 2)

    def outline(self, count: int = BINS) -> FloatArray:
        """(count, 2) pixels on it."""
        turn = np.arange(count) * (2 * np.pi / count)
        unit = np.stack([np.cos(turn), np.sin(turn), np.ones(count)], 1)
        spots = unit @ np.linalg.inv(self.disc).T
        return spots[:, :2] / spots[:, 2:]

    def turns(self) -> list[FloatArray]:
        """Copies (3, 3) of the picture that turn it about the middle of the circle."""
        back = np.linalg.inv(self.disc)
        out = []
        for degrees in TURNS:
            cos, sin = math.cos(math.radians(degrees)), math.sin(math.radians(degrees))
            copy = back @ np.array([[cos, -sin, 0], [sin, cos, 0], [0, 0, 1]]) @ self.disc
            out.append(copy / copy[2, 2])
        return out


def round_marks(photo: Image, hole: BoolArray, level: FloatArray) -> list[RoundMark]:
    """Circles on level ground whose outlines run behind the hole (H, W) of a photo (H, W, 3).

    level: (3, 3) from pixels to a level plane.
    """
    if not hole.any():
        return []
    window, factor = _window(hole)
    size = [max(8, round(factor * (s.stop - s.start))) for s in window[::-1]]
    part = cv2.resize(photo[window], size, interpolation=cv2.INTER_AREA).astype(np.uint8)
    closed = cv2.resize(hole[window].astype(np.uint8), size, interpolation=cv2.INTER_AREA) > 0
    x, y = (n / (s.stop - s.start) for n, s in zip(size, window[::-1], strict=True))
    corner = np.array([[1, 0, window[1].start], [0, 1, window[0].start], [0, 0, 1.0]])
    spots, normals = _edges(part, grow(np.asarray(closed), 2))
    if len(spots) < 60:
        return []
    plane = level @ corner @ np.diag([1 / x, 1 / y, 1.0])
    least = LEAST * max(hole.shape) * factor
    found: list[RoundMark] = []
    for mark in _voted(spots, normals, plane, least):
        if not _holds(mark, spots, normals, closed):
            continue
        # Where there is one ring there are others around the same middle.
        for own in (mark, *_concentric(mark, spots, normals, closed)):
            if not any(_same(own, other) for other in found):
                found.append(own)
    return [mark.scaled(1 / x, 1 / y).moved(*(-corner[:2, 2])) for mark in found]


def _window(hole: BoolArray) -> tuple[tuple[slice, slice], float]:
    """Where edges are looked for, and how much smaller that is made."""
    x0, y0, x1, y1 = bounds(hole)
    margin = max(30, round(AROUND * max(x1 - x0, y1 - y0)))
    rows = slice(max(0, y0 - margin), min(hole.shape[0], y1 + margin))
    columns = slice(max(0, x0 - margin), min(hole.shape[1], x1 + margin))
    longer = max(rows.stop - rows.start, columns.stop - columns.start)
    return (rows, columns), min(1.0, SIDE / longer)


def _edges(part: Image, closed: BoolArray) -> tuple[FloatArray, FloatArray]:
    """Edge pixels (N, 2) outside of the hole (h, w), and unit normals (N, 2) to the lighter side.

    Of the channel of L*a*b* that changes most.
    """
    lab = cv2.cvtColor(cv2.GaussianBlur(part, (0, 0), 1.2), cv2.COLOR_RGB2LAB).astype(np.float32)
    right, down = (cv2.Sobel(lab, cv2.CV_32F, *way, ksize=3) for way in ((1, 0), (0, 1)))
    size = np.hypot(right, down) * np.array([1.0, 1.6, 1.6], np.float32)
    most = size.argmax(-1)[..., None]
    right, down, size = (np.take_along_axis(v, most, -1)[..., 0] for v in (right, down, size))
    clear = size > max(40.0, float(np.percentile(size[~closed], 85)) if (~closed).any() else 40.0)
    ridge = _ridge(right, down, size) & clear & ~closed
    rows, columns = np.nonzero(ridge)
    if len(rows) > EDGES:
        kept = np.sort(np.random.default_rng(SEED).choice(len(rows), EDGES, replace=False))
        rows, columns = rows[kept], columns[kept]
    way = np.stack([right[rows, columns], down[rows, columns]], 1).astype(float)
    way /= np.maximum(np.linalg.norm(way, axis=1, keepdims=True), 1e-9)
    return np.stack([columns + 0.5, rows + 0.5], 1).astype(np.float64), way


def _ridge(right: NDArray, down: NDArray, size: NDArray) -> BoolArray:
    """Which pixels step more than those before and behind them."""
    y, x = np.indices(size.shape).astype(np.float32)
    long = np.maximum(np.hypot(right, down), 1e-6)
    u, v = (right / long).astype(np.float32), (down / long).astype(np.float32)
    image = size.astype(np.float32)
    beside = [cv2.remap(image, x + s * u, y + s * v, cv2.INTER_LINEAR) for s in (1, -1)]
    return np.asarray((size >= beside[0]) & (size > beside[1]))


def _voted(
    spots: FloatArray, normals: FloatArray, plane: FloatArray, least: float
) -> list[RoundMark]:
    """Circles on the plane (3, 3) on which most pairs of edges agree, the best first."""
    ground = _through(plane, spots)
    tangent = np.stack([-normals[:, 1], normals[:, 0]], 1)
    along = _through(plane, spots + 0.5 * tangent) - _through(plane, spots - 0.5 * tangent)
    ahead = (np.abs(ground) < FAR / 2).all(1) & (np.abs(along) < FAR / 2).all(1)
    if np.count_nonzero(ahead) < 60:
        return []
    ground, along = ground[ahead], along[ahead]
    grain = np.linalg.norm(along, axis=1)
    upright = np.stack([along[:, 1], -along[:, 0]], 1) / np.maximum(grain, 1e-12)[:, None]
    one, other = np.random.default_rng(SEED).integers(0, len(ground), (2, PAIRS))
    gap = ground[other] - ground[one]
    u, v = upright[one], upright[other]
    turn = u[:, 0] * v[:, 1] - u[:, 1] * v[:, 0]
    steep = np.abs(turn) > 0.2
    turn = np.where(steep, turn, 1.0)
    first = (gap[:, 0] * v[:, 1] - gap[:, 1] * v[:, 0]) / turn
    second = (gap[:, 0] * u[:, 1] - gap[:, 1] * u[:, 0]) / turn
    radius = (first + second) / 2
    fine = np.maximum(grain[one], grain[other])
    agree = steep & (np.abs(first - second) < ALIKE * np.abs(radius))
    agree &= np.abs(radius) > least * fine
    middle = ground[one] + first[:, None] * u
    rows = np.column_stack([middle, radius])[agree]
    rows = rows[:: max(1, len(rows) // COUNTED)]
    least_votes = VOTES * PAIRS * min(1.0, COUNTED / max(np.count_nonzero(agree), 1))
    out = []
    for _ in range(TRIED):
        if len(rows) < least_votes:
            break
        tried = rows[:: max(1, len(rows) // 120)]
        off = np.abs(tried[:, None] - rows[None]).max(-1) < ALIKE * np.abs(tried[:, None, 2])
        best = int(off.sum(1).argmax())
        if off[best].sum() < least_votes:
            break
        circle = np.median(rows[off[best]], axis=0)
        out.append(_fitted(circle, plane, spots, normals))
        rows = rows[~(np.abs(rows - circle).max(-1) < 3 * ALIKE * abs(circle[2]))]
    return out


def _fitted(
    circle: FloatArray, plane: FloatArray, spots: FloatArray, normals: FloatArray
) -> RoundMark:
    """The circle (3,) of middle and radius on the plane, drawn to the edges beside it."""
    x, y, radius = circle[0], circle[1], abs(circle[2])
    mark = RoundMark(np.array([[1, 0, -x], [0, 1, -y], [0, 0, radius]]) @ plane)
    return _drawn(mark, spots, normals)


def _drawn(mark: RoundMark, spots: FloatArray, normals: FloatArray) -> RoundMark:
    """A circle drawn to the edges beside it."""
    for reach in (3 * NEAR, 2 * NEAR, NEAR):
        near = _beside(mark, spots, normals, reach)
        if np.count_nonzero(near) < 12:
            break
        unit = _through(mark.disc, spots[near])
        # On the plane an ellipse rather than a circle: the camera is only roughly known.
        terms = np.column_stack([unit**2, unit[:, :1] * unit[:, 1:], unit])
        a, b, c, d, e = np.linalg.lstsq(terms, np.ones(len(unit)), rcond=None)[0]
        form = np.array([[a, c / 2], [c / 2, b]])
        values, axes = np.linalg.eigh(form)
        if values.min() < 0.25 * values.max():
            break
        centre = -np.linalg.solve(2 * form, [d, e])
        scale = 1 + centre @ form @ centre
        root = axes @ np.diag(np.sqrt(values / max(scale, 1e-9))) @ axes.T
        own = np.eye(3)
        own[:2, :2], own[:2, 2] = root, -root @ centre
        mark = RoundMark(own @ mark.disc)
    return mark


def _beside(mark: RoundMark, spots: FloatArray, normals: FloatArray, reach: float) -> BoolArray:
    """(N,) which edges run along the circle, all stepping the same way in or out."""
    unit = _through(mark.disc, spots)
    away = np.linalg.norm(unit, axis=1) - 1
    outward = np.linalg.norm(_through(mark.disc, spots + normals), axis=1) - 1 - away
    back = mark.outline()
    turn = np.round(np.arctan2(unit[:, 1], unit[:, 0]) / (2 * np.pi) * BINS).astype(int) % BINS
    step = np.roll(back, -1, 0) - np.roll(back, 1, 0)
    step = step / np.maximum(np.linalg.norm(step, axis=1, keepdims=True), 1e-9)
    along = np.abs((normals * np.stack([-step[turn, 1], step[turn, 0]], 1)).sum(1)) > ALIGNED
    # One pixel along the normal is worth so much of the radius.
    near = np.abs(away) < reach * np.maximum(np.abs(outward), 1e-9)
    near &= along
    inward = np.count_nonzero(near & (outward < 0)) > np.count_nonzero(near & (outward > 0))
    return near & ((outward < 0) == inward)


def _holds(mark: RoundMark, spots: FloatArray, normals: FloatArray, closed: BoolArray) -> bool:
    """Whether there is an edge along nearly all of the circle that is in view."""
    line = mark.outline()
    x, y = line.astype(int).T
    inside = (x >= 0) & (y >= 0) & (x < closed.shape[1]) & (y < closed.shape[0])
    hidden = inside & closed[y.clip(0, closed.shape[0] - 1), x.clip(0, closed.shape[1] - 1)]
    seen = inside & ~hidden
    if not hidden.any() or seen.mean() < SEEN:
        return False
    shown = _share(mark, spots, normals, seen)
    rings = [RoundMark(np.diag([s, s, 1.0]) @ mark.disc) for s in (0.86, 0.93, 1.08, 1.16)]
    beside = float(np.median([_share(ring, spots, normals, seen) for ring in rings]))
    return shown > SHOWN and shown > BETTER * beside


def _concentric(
    mark: RoundMark, spots: FloatArray, normals: FloatArray, closed: BoolArray
) -> list[RoundMark]:
    """Other circles around the middle of one, along which there are edges."""
    out = []
    for size in np.arange(*RINGS, 2 * NEAR * _pixel(mark)):
        ring = RoundMark(np.diag([1, 1, size]) @ mark.disc)
        if abs(size - 1) < 3 * ALIKE or not _roughly(ring, spots, normals):
            continue
        ring = _drawn(ring, spots, normals)
        if _holds(ring, spots, normals, closed) and not any(_same(ring, other) for other in out):
            out.append(ring)
    return out


def _roughly(mark: RoundMark, spots: FloatArray, normals: FloatArray) -> bool:
    """Whether there are edges along enough of a circle for a look at it."""
    return float(_turned(mark, spots[_beside(mark, spots, normals, 2 * NEAR)]).mean()) > ROUGHLY


def _pixel(mark: RoundMark) -> float:
    """About how much of the radius one pixel is."""
    line = mark.outline()
    return 2 * math.pi / max(float(np.linalg.norm(line - np.roll(line, 1, 0), axis=1).sum()), 1e-9)


def _share(mark: RoundMark, spots: FloatArray, normals: FloatArray, seen: BoolArray) -> float:
    """Along what share of the part (BINS,) of a circle that is in view there is an edge."""
    there = _turned(mark, spots[_beside(mark, spots, normals, NEAR)])
    there |= np.roll(there, 1) & np.roll(there, -1)
    return float((there & seen).sum() / max(seen.sum(), 1))


def _turned(mark: RoundMark, spots: FloatArray) -> BoolArray:
    """(BINS,) at which places of a circle there are any of the spots (N, 2)."""
    unit = _through(mark.disc, spots)
    turn = np.round(np.arctan2(unit[:, 1], unit[:, 0]) / (2 * np.pi) * BINS).astype(int) % BINS
    there = np.zeros(BINS, bool)
    there[turn] = True
    return there


def _same(one: RoundMark, other: RoundMark) -> bool:
    away = np.linalg.norm(_through(other.disc, one.outline()), axis=1)
    return bool(np.abs(away - 1).max() < 2 * ALIKE)


def _through(copy: FloatArray, points: FloatArray) -> FloatArray:
    """Points (N, 2) through a map (3, 3); far away where they are beyond its horizon."""
    mapped = np.column_stack([points, np.ones(len(points))]) @ copy.T
    ahead = mapped[:, 2:] > 0
    return np.where(ahead, mapped[:, :2] / np.where(ahead, mapped[:, 2:], 1.0), FAR)
