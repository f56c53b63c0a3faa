"""A level top that things are seen to stand on: bounded by its edges, and else by its colour.

What fills most of a picture, a table or a counter seen from near by, is no region that grows from
a click: grain, light and reflections divide it. Its edges are found instead. A line of the
picture ends the top where the side towards the things looks like what is around their feet and the
other side does not, along most of the line: joints between boards, and the edges of what lies
on the top, have the top on both sides of them somewhere on their way. Where no edge is seen to end
it, it goes as far as it looks like that, shaded or lit.
"""

import itertools
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import partial

import cv2
import numpy as np
from numpy.typing import NDArray

from physagent_studio.arrays import FloatArray
from physagent_studio.reconstruction.photo.line_segments import Segments
from physagent_studio.reconstruction.photo.regions import BoolArray, grow
from physagent_studio.reconstruction.supports.stances import Stance
from physagent_studio.records.case import Image


@dataclass(frozen=True, slots=True)
class TopSettings:
    """Which lines of the picture end a top, and what looks like it."""

    # 0.02..0.2: over the longer side: shorter edges are grain and things
    min_edge_ratio: float = 0.06
    max_bend_rad: float = 0.12  # 0.05..0.4: of an edge as long as the next field says
    # 0.05..0.5: over the longer side: longer edges may bend the more
    bend_length_ratio: float = 0.15
    spacing_px: float = 3.0  # 1..10: between the places along a line that are looked at
    lightness_weight: float = 0.5  # weight, 0..1: of steps in lightness: one top is lit and shaded
    like_lab: float = 14.0  # 6..30: up to which a pixel is like the top
    min_step_lab: float = 6.0  # 2..15: from which a line is an edge there
    ring_ratio: float = 0.1  # 0.03..0.4: over a thing's width: what is around its foot
    # 0.1..0.6: of the colours there that one has to be like: bits of floor are not
    min_common_share: float = 0.3
    # 0.5..1: of a line that is an edge, where the top is on its near side
    min_end_share: float = 0.7
    min_own_share: float = 0.5  # 0.3..1: of the segment itself that is an edge
    # 0.03..0.3: over the longer side: length of the edge along its line
    min_line_ratio: float = 0.09
    # 0.01..0.1: the same, where the edge is all that is left of its line
    min_whole_ratio: float = 0.04
    whole_share: float = 0.6  # 0.4..1: of what other lines have left, from which it is
    # 0..0.3: over a thing's width: of its base's middle, seen past an edge
    max_overhang_ratio: float = 0.1
    min_alike_share: float = 0.1  # 0.02..0.4: of the colours at a foot that are those of a click
    click_ratio: float = 0.012  # 0.004..0.04: over the longer side: what is around a click
    max_slope_lab: float = 1.0  # 0.3..3: from pixel to pixel: light fades on the top
    min_lit_share: float = 0.25  # 0.1..0.6: of an even part that looks like the top's other parts
    # 0.002..0.02: over the longer side: gaps in the colour of the top, and bits of others like it
    gap_ratio: float = 0.008


TOP = TopSettings()


@dataclass(frozen=True, eq=False, slots=True)
class Top:
    """region: (H, W) pixels of the top, without the things on it. edges: those that end it."""

    region: BoolArray
    edges: Segments


def top_around(
    image: Image,
    found: Segments,
    stances: Sequence[Stance],
    bases: FloatArray,
    covered: BoolArray,
    clicks: FloatArray | None = None,
    box: tuple[float, float, float, float] | None = None,
) -> Top | None:
    """The level top on which things stand, as far as the picture shows it.

    found: edges of the picture. stances: of the things. bases: (N, 2) pixels of the middles of
    what they stand with. covered: (H, W) pixels of all things. clicks: (M, 2) pixels of the top or
    of its front; where they are given, what stands elsewhere may be among the things. box: left,
    top, right, bottom, pixels, what a person has drawn around it. None where the ground around
    their feet is not seen, or of what is marked too little is.
    """
    lab = _smooth_lab(image)
    feet = [_around_foot(lab, stance, covered) for stance in stances]
    widths = np.array([float(s.width) for s in stances])
    if clicks is not None and len(clicks):
        own = _around_clicks(lab, clicks)
        on = np.array([_alike(foot, own) for foot in feet], bool)
        feet = [foot for foot, there in zip(feet, on, strict=True) if there]
        # A click may lie on the front below the top: it bounds nothing.
        bases, widths = bases[on], widths[on]
    looks = np.concatenate(feet) if feet else np.zeros((0, 3))
    if not len(looks):
        return None
    inside = _inside(box, covered.shape)
    edges, inside = _bounded(lab, looks, found, (bases, widths), ~grow(covered, 3), inside)
    region = _like(lab, looks, inside, covered, bases)
    if not region.any():
        marked = box is not None or (clicks is not None and len(clicks) > 0)
        return None if marked else Top(inside & ~covered, edges)
    return Top(region & ~covered, edges)


def _inside(box: tuple[float, float, float, float] | None, size: tuple[int, ...]) -> BoolArray:
    """(H, W) the pixels in a box, or all of them."""
    if box is None:
        return np.ones(size, bool)
    rows, columns = np.indices(size)
    return (columns >= box[0]) & (columns < box[2]) & (rows >= box[1]) & (rows < box[3])


def _bounded(
    lab: FloatArray,
    looks: FloatArray,
    found: Segments,
    standing: tuple[FloatArray, FloatArray],
    free: BoolArray,
    inside: BoolArray,
) -> tuple[Segments, BoolArray]:
    """The edges that end a top, and (H, W) what lies inside them all.

    standing: (N, 2) places that are on it, and (N,) how wide what stands there is, pixels.
    """
    bases, widths = standing
    past = -TOP.max_overhang_ratio * widths
    lines = {k: _line(found.ends[k], bases) for k in _able(found, free)}
    lines = {k: v for k, v in lines.items() if not ((bases @ v[:2] + v[2]) < past).any()}
    tally = partial(_tally, lab, looks=looks, free=free)
    kept: list[int] = []
    # A short side is seen to be whole only once the long ones have cut off the rest of its line.
    for k in [*lines, *lines]:
        if k not in kept and tally(lines[k], found.ends[k], inside=inside).ends_top():
            kept.append(k)
            inside = inside & _side(lines[k], inside.shape)
    # Nor are two sides before what looks like the top, until each has cut off the other's rest.
    left = {
        k: _side(lines[k], inside.shape)
        for k in lines
        if k not in kept and tally(lines[k], found.ends[k], inside=inside).shown
    }
    for a, b in itertools.combinations(left, 2):
        if a in kept or b in kept:
            continue
        one = tally(lines[a], found.ends[a], inside=inside & left[b])
        if one.ends_with(tally(lines[b], found.ends[b], inside=inside & left[a])):
            kept += [a, b]
            inside = inside & left[a] & left[b]
    return found.only(np.array(kept, int)), inside


def _able(found: Segments, free: BoolArray) -> list[int]:
    """Edges that may be looked at, longest first: straight, long, and not those of things."""
    side = max(free.shape)
    straight = found.bend < TOP.max_bend_rad * np.maximum(
        1.0, found.length / (TOP.bend_length_ratio * side)
    )
    able = straight & (found.length > TOP.min_edge_ratio * side) & _clear(found.ends, free)
    order = np.argsort(-found.length, kind="stable")
    return [int(k) for k in order if able[k]]


def _smooth_lab(image: Image) -> FloatArray:
    """(H, W, 3) colours without grain, lightness weighted."""
    sigma = 0.002 * max(image.shape[:2])
    lab = cv2.cvtColor(cv2.GaussianBlur(image, (0, 0), sigma), cv2.COLOR_RGB2LAB).astype(float)
    return lab * (TOP.lightness_weight, 1.0, 1.0)


def _around_foot(lab: FloatArray, stance: Stance, covered: BoolArray) -> FloatArray:
    """(N, 3) colours of what lies around the foot of a thing, level with it or nearer."""
    x0, _, x1, y1 = stance.box
    reach = max(8, round(TOP.ring_ratio * (x1 - x0)))
    ring = np.zeros(covered.shape, bool)
    top = max(0, y1 - max(4, round(0.15 * stance.height)))
    ring[top : y1 + reach, max(0, x0 - reach) : x1 + reach] = True
    ring &= ~grow(covered, 3)
    own = lab[ring]
    return _usual(own[:: max(1, len(own) // 64)])


def _around_clicks(lab: FloatArray, clicks: FloatArray) -> FloatArray:
    """(M, 3) mean colours around clicks (M, 2) on the top."""
    reach = max(2, round(TOP.click_ratio * max(lab.shape[:2])))
    spots = np.round(clicks).astype(int)
    parts = [
        lab[max(0, y - reach) : y + reach + 1, max(0, x - reach) : x + reach + 1] for x, y in spots
    ]
    return np.array([part.reshape(-1, 3).mean(0) for part in parts])


def _alike(looks: FloatArray, own: FloatArray) -> bool:
    """Whether some of the colours around a foot (N, 3) are those of the top (M, 3)."""
    if not len(looks):
        return False
    near = np.linalg.norm(looks[:, None] - own[None], axis=2).min(1) < TOP.like_lab
    return bool(near.mean() > TOP.min_alike_share)


def _like(
    lab: FloatArray, looks: FloatArray, inside: BoolArray, covered: BoolArray, bases: FloatArray
) -> BoolArray:
    """(H, W) of what lies inside the edges the part that looks like the top, around the bases; none
    where too little of it is seen.

    An end of the top that no edge shows is where its colour stops; shade, reflections and what lies
    on it do not part it, and what is seen of a level top has no hollows.
    """
    off = np.min([np.linalg.norm(lab - look, axis=2) for look in _few(looks)], axis=0)
    own = (off < TOP.like_lab) & inside & ~covered
    own |= _shaded(lab, own, inside & ~covered)
    size = 2 * max(1, round(TOP.gap_ratio * max(inside.shape))) + 1
    disc = cv2.getStructuringElement(cv2.MORPH_ELLIPSE, (size, size))
    like = (own | (covered & inside)).astype(np.uint8)
    like = cv2.morphologyEx(cv2.morphologyEx(like, cv2.MORPH_CLOSE, disc), cv2.MORPH_OPEN, disc)
    _, parts = cv2.connectedComponents(like)
    x, y = np.clip(np.round(bases).astype(int).T, 0, np.array(inside.shape[::-1])[:, None] - 1)
    held = set(parts[y, x].tolist()) - {0}
    seen = np.isin(parts, list(held)) & ~grow(covered, size)
    whole = np.zeros(inside.shape, np.uint8)
    if not seen.any():
        return whole > 0
    points = cv2.findNonZero(seen.astype(np.uint8))
    cv2.fillConvexPoly(whole, cv2.convexHull(points), 1)
    return inside & (whole > 0)


def _shaded(lab: FloatArray, own: BoolArray, inside: BoolArray) -> BoolArray:
    """(H, W) where light fades so gently from what looks like the top that it is still the top."""
    slope = np.hypot(*(np.gradient(lab, axis=axis) for axis in (0, 1))).max(2)
    gentle = ((slope < TOP.max_slope_lab) & inside).astype(np.uint8)
    count, parts = cv2.connectedComponents(gentle)
    sizes = np.bincount(parts.ravel(), minlength=count)
    share = np.bincount(parts.ravel(), own.ravel(), count) / np.maximum(sizes, 1)
    share[0] = 0.0
    return (share > TOP.min_lit_share)[parts]


def _few(looks: FloatArray) -> FloatArray:
    """Of colours (N, 3) at most sixteen."""
    return looks[:: max(1, -(-len(looks) // 16))]


def _usual(looks: FloatArray) -> FloatArray:
    """Of colours (N, 3) those that many others are like: a bit of floor seen there is no top."""
    off = np.linalg.norm(looks[:, None] - looks[None], axis=2)
    return looks[(off < TOP.like_lab).mean(1) > TOP.min_common_share] if len(looks) else looks


def _clear(ends: FloatArray, free: BoolArray) -> NDArray[np.bool_]:
    """(N,) whether most of each edge (N, 2, 2) is no edge of a thing."""
    share = np.linspace(0.05, 0.95, 16)[None, :, None]
    spots = (ends[:, :1] * (1 - share) + ends[:, 1:] * share).astype(int)
    x = np.clip(spots[..., 0], 0, free.shape[1] - 1)
    y = np.clip(spots[..., 1], 0, free.shape[0] - 1)
    return free[y, x].mean(1) > 0.5


def _line(ends: FloatArray, bases: FloatArray) -> FloatArray:
    """(3,) a, b, c of the line through an edge (2, 2), a x + b y + c > 0 towards the bases, px."""
    way = ends[1] - ends[0]
    normal = np.array([-way[1], way[0]]) / max(float(np.hypot(*way)), 1e-9)
    line = np.array([*normal, -float(normal @ ends[0])])
    return line if float(np.median(bases @ line[:2] + line[2])) > 0 else -line


@dataclass(frozen=True, slots=True)
class _Tally:
    """Places along a line that have the top on their near side: `edge` where something else lies
    beyond, `on` where the top goes on; seen: places where the near side is seen; shown: whether
    most of the edge itself is such an edge; side: longer side of the picture, pixels."""

    edge: int
    on: int
    seen: int
    shown: bool
    side: int

    @property
    def whole(self) -> bool:
        """Whether nearly all that is seen of the line is an edge."""
        return self.edge >= TOP.min_end_share * (self.edge + self.on)

    def is_long(self, ratio: float) -> bool:
        """Whether the edge is longer along its line than that part of the picture's side."""
        return self.edge * TOP.spacing_px > ratio * self.side

    def ends_top(self) -> bool:
        """Whether the top ends at the line by itself."""
        # A side of a top that is seen flat is short: it does where it is all that is left of it.
        short = self.edge > TOP.whole_share * self.seen
        return (
            self.shown
            and self.whole
            and self.is_long(TOP.min_whole_ratio if short else TOP.min_line_ratio)
        )

    def ends_with(self, other: "_Tally") -> bool:
        """Whether the top ends at both of two lines, each tallied as far as the other lets it."""
        both = replace(self, edge=self.edge + other.edge, on=self.on + other.on)
        each = all(t.shown and t.is_long(TOP.min_whole_ratio) for t in (self, other))
        return each and both.whole and both.is_long(TOP.min_line_ratio)


def _tally(
    lab: FloatArray,
    line: FloatArray,
    ends: FloatArray,
    looks: FloatArray,
    free: BoolArray,
    inside: BoolArray,
) -> _Tally:
    """What lies beside a line, wherever the top is seen on the near side of it.

    ends: (2, 2) of the edge itself. free: (H, W) pixels of no thing. inside: those where the top
    may still be.
    """
    side = max(free.shape)
    spots = _across_picture(line, free.shape)
    if not len(spots):
        return _Tally(0, 0, 0, False, side)
    strip = np.linspace(0.004, 0.016, 5) * side
    near, seen = _beside(lab, spots, line[:2], strip, free & inside)
    far, beyond = _beside(lab, spots, -line[:2], strip, np.ones_like(free))
    off = np.linalg.norm(near[:, None] - looks[None], axis=2).min(1)
    step = np.linalg.norm(near - far, axis=1)
    seen &= beyond
    edge = seen & (off < TOP.like_lab) & (step > TOP.min_step_lab)
    on = seen & (off < TOP.min_step_lab) & (step < TOP.min_step_lab)
    share = ((spots - ends[0]) @ (ends[1] - ends[0])) / float(np.sum((ends[1] - ends[0]) ** 2))
    own = (share > 0) & (share < 1) & _beside(lab, spots, line[:2], strip, free)[1]
    shown = bool((edge & own).sum() > TOP.min_own_share * own.sum())
    return _Tally(int(edge.sum()), int(on.sum()), int(seen.sum()), shown, side)


def _side(line: FloatArray, size: tuple[int, ...]) -> BoolArray:
    """(H, W) the pixels on the side of a line where the bases are."""
    rows, columns = np.indices(size)
    return line[0] * columns + line[1] * rows + line[2] > 0


def _across_picture(line: FloatArray, size: tuple[int, ...]) -> FloatArray:
    """(N, 2) places along a line from border to border of the picture."""
    height, width = size
    a, b, c = line
    crossings = []
    if abs(b) > 1e-9:
        crossings += [(x, -(a * x + c) / b) for x in (0.0, width - 1.0)]
    if abs(a) > 1e-9:
        crossings += [(-(b * y + c) / a, y) for y in (0.0, height - 1.0)]
    inside = [p for p in crossings if -1 <= p[0] <= width and -1 <= p[1] <= height]
    if len(inside) < 2:
        return np.zeros((0, 2))
    first = np.array(inside[0])
    last = np.array(max(inside, key=lambda p: float(np.hypot(*(np.array(p) - first)))))
    count = max(2, int(np.hypot(*(last - first)) / TOP.spacing_px))
    return first + np.linspace(0.01, 0.99, count)[:, None] * (last - first)


def _beside(
    lab: FloatArray, spots: FloatArray, way: FloatArray, strip: FloatArray, free: BoolArray
) -> tuple[FloatArray, BoolArray]:
    """(N, 3) mean colour beside each place, at the distances `strip` along `way`; and (N,)

    whether all of that is in the picture and free.
    """
    places = np.round(spots[:, None] + strip[None, :, None] * way).astype(int)
    x, y = places[..., 0], places[..., 1]
    height, width = free.shape
    fine = (x >= 0) & (y >= 0) & (x < width) & (y < height)
    x, y = np.clip(x, 0, width - 1), np.clip(y, 0, height - 1)
    return lab[y, x].mean(1), (fine & free[y, x]).all(1)
