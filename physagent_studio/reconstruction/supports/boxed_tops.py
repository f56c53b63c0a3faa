"""A table that a person drew a box around: its top is as wide as the box and as high up.

The top is the widest part of a table, a desk or a counter, so the box tells where it ends, and its
outline is seen as steps of colour all around, whatever lies on it. Of all rectangles on the plane
of the top, and of all ellipses, which is what round tops are seen as, the one is sought whose
outline lies on such steps, has the same colour inside all around, and fills the box.
"""

import math
from collections.abc import Callable
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from scipy.optimize import differential_evolution

from physagent_studio.arrays import FloatArray
from physagent_studio.program.scene.camera import Camera
from physagent_studio.program.scene.state import Slab
from physagent_studio.reconstruction.camera.rays import on_plane
from physagent_studio.reconstruction.photo.ellipses import Ellipse
from physagent_studio.reconstruction.supports.seen_ends import Shown
from physagent_studio.reconstruction.supports.top_outlines import OUTLINE, Box, View


@dataclass(frozen=True, slots=True)
class BoxedSettings:
    """How the outline of a top is sought in a box."""

    # worth, 0.05..0.4: by which another outline has to be better than the one that is known
    min_gain: float = 0.2
    min_worth: float = 1.6  # worth, 1..1.9: below it no outline is seen
    min_depth_ratio: float = 0.35  # 0.15..0.6: shorter over longer side: below it tops are rare
    slender_weight: float = 0.3  # weight, 0..1: of the logarithm of how far below it a top is
    round_gain: float = 0.03  # worth, 0..0.1: as good as a rectangle is round
    rounds_count: int = 110  # 40..400: rounds of a search
    crowd_count: int = 10  # 6..40: outlines that each draws from, for each number that is sought
    # 1e-6..1e-2: over their mean: spread of what its outlines are worth, at which a search ends
    tolerance_ratio: float = 1e-4
    crossing_share: float = 0.9  # 0.5..1: of the numbers of an outline that a round changes
    # 1..6: parts of the turns of a rectangle, each searched by itself: the best of one hides others
    turns_count: int = 3
    # 0.7..1: of the way to a round top's rim: the sides of the slab that stands for it
    chord_ratio: float = 0.93
    max_off_ratio: float = 0.6  # 0.5..0.95: over its radius: how far off its middle things stand
    # 0..0.4: over the sides of a box: how near to them the middle of a top is
    edge_ratio: float = 0.1
    # 0.1..0.4: over half the width of a box: half the shorter side of a top, at least
    min_half_ratio: float = 0.2
    max_half_ratio: float = 1.4  # 1..2: half its side across, at most
    max_deep_ratio: float = 2.7  # 1.5..4: half its side away from the camera, at most
    # 0.1..0.4: over a box's width: how far off its middle a round top's is
    middle_ratio: float = 0.2
    max_down_ratio: float = 0.5  # 0.3..1: and how far below the upper side
    # 0.3..0.5: over a box's width: half a round top's width
    min_wide_ratio: float = 0.35
    max_wide_ratio: float = 0.6  # 0.5..0.8: the same, of one that the picture's side cuts
    min_flat_ratio: float = 0.03  # 0.01..0.1: half its height in the picture, seen from beside
    max_flat_ratio: float = 0.5  # 0.4..0.6: the same, seen from above
    # worth, 1.6..2.1: of an ellipse that no rectangle is taken for
    sure_worth: float = 1.9
    max_turn_rad: float = 0.1  # 0..0.3: how far its long axis is from level


BOXED = BoxedSettings()


def within_box(shown: Shown, camera: Camera, slab: Slab, box: Box, standing: FloatArray) -> Slab:
    """The slab, or one whose top fits its box in the picture much better.

    box: left, top, right, bottom, pixels of the photo. standing: (N, 2) pixels of the middles of
    what stands on it.
    """
    height = slab.position[2] + slab.size[2] / 2
    if camera.position[2] <= height:
        return slab  # seen from below, it has no top in the picture
    view = View.of(shown, box, standing)
    tops = _Tops(view, camera, height)
    # A top that goes on behind the camera has no outline.
    known = float(np.nan_to_num(view.worth(tops.of_slab(slab)[None]))[0])
    least = max(known + BOXED.min_gain, BOXED.min_worth)
    if least > OUTLINE.best_worth:
        return slab
    square, square_worth = _best_square(tops)
    oval, oval_worth = _best_oval(view)
    if max(square_worth, oval_worth) < least:
        return slab
    if oval_worth + BOXED.round_gain > square_worth:
        return tops.slab_of_oval(oval, slab)
    return _moved(slab, tops.rectangles_of(square[None])[0])


def round_top(shown: Shown, box: Box) -> Ellipse | None:
    """The top of a table in a box, pixels, where it is seen for sure to be round."""
    view = View.of(shown, box, np.zeros((0, 2)))
    numbers, worth = _best_oval(view)
    if worth < BOXED.sure_worth:
        return None
    left, top, right, _ = box
    x, y, a, b = (float(number) * (right - left) for number in numbers[:4])
    return Ellipse(left + x, top + y, 2 * a, 2 * b)


def _best_square(tops: "_Tops") -> tuple[FloatArray, float]:
    """The numbers of the rectangle of greatest worth, and that."""
    turns = np.linspace(-math.pi / 4, math.pi / 4, BOXED.turns_count + 1)
    least = math.log(BOXED.min_half_ratio)
    sides = (
        (BOXED.edge_ratio, 1 - BOXED.edge_ratio),
        (0.0, 1.0),
        (least, math.log(BOXED.max_half_ratio)),
        (least, math.log(BOXED.max_deep_ratio)),
    )
    found = [
        _sought(lambda n: tops.view.worth(tops.squares(n)) - _slender(n), (*sides, turn))
        for turn in pairwise(turns.tolist())
    ]
    return max(found, key=lambda one: one[1])


def _best_oval(view: View) -> tuple[FloatArray, float]:
    """The numbers of the ellipse of greatest worth, and that."""
    bounds = (
        (0.5 - BOXED.middle_ratio, 0.5 + BOXED.middle_ratio),
        (0.0, BOXED.max_down_ratio),
        (BOXED.min_wide_ratio, BOXED.max_wide_ratio),
        (BOXED.min_flat_ratio, BOXED.max_flat_ratio),
        (-BOXED.max_turn_rad, BOXED.max_turn_rad),
    )
    return _sought(lambda n: view.worth(_ovals(view, n)), bounds)


def _ovals(view: View, numbers: FloatArray) -> FloatArray:
    """Outlines (P, 4, N, 2) of ellipses (P, 5): middle and half axes, parts of the width of the
    box, and turn; in the pixels of the view."""
    left, top, right, _ = view.box
    x, y, a, b = (number[:, None] * (right - left) for number in numbers[:, :4].T)
    start, count = math.pi / 4, 4 * OUTLINE.places_count
    angle = start + np.linspace(0, 2 * math.pi, count, endpoint=False)
    u, v = a * np.cos(angle), b * np.sin(angle)
    cos, sin = np.cos(numbers[:, 4:]), np.sin(numbers[:, 4:])
    ring = np.stack([left + x + u * cos - v * sin, top + y + u * sin + v * cos], -1)
    return ring.reshape(len(numbers), 4, OUTLINE.places_count, 2)


def _slender(numbers: FloatArray) -> FloatArray:
    """(P,) what rectangles by their numbers (P, 5) lose for being slender as no table is."""
    ratio = np.abs(numbers[:, 2] - numbers[:, 3])
    return BOXED.slender_weight * np.maximum(ratio + math.log(BOXED.min_depth_ratio), 0)


def _sought(
    worth: Callable[[FloatArray], FloatArray], bounds: tuple[tuple[float, float], ...]
) -> tuple[FloatArray, float]:
    """The numbers (K,) within bounds of greatest worth, and that."""
    found = differential_evolution(
        lambda numbers: -np.nan_to_num(worth(numbers.T), nan=-1.0),
        bounds,
        rng=0,
        strategy="currenttobest1bin",
        recombination=BOXED.crossing_share,
        vectorized=True,
        updating="deferred",
        polish=False,
        maxiter=BOXED.rounds_count,
        popsize=BOXED.crowd_count,
        tol=BOXED.tolerance_ratio,
    )
    return np.asarray(found.x), -float(found.fun)


def _moved(slab: Slab, numbers: FloatArray) -> Slab:
    """The slab with its top where a rectangle (5,) is: middle, half sizes, m, and turn."""
    x, y, a, b, yaw = (float(number) for number in numbers)
    position, size = (x, y, slab.position[2]), (2 * a, 2 * b, slab.size[2])
    return slab.model_copy(update={"position": position, "size": size, "yaw": yaw})


@dataclass(frozen=True, eq=False, slots=True)
class _Tops:
    """Outlines (P, 4, N, 2) of tops on the plane at height `top`, m, in the pixels of a view."""

    view: View
    camera: Camera
    top: float

    def of_slab(self, slab: Slab) -> FloatArray:
        """(4, N, 2) outline of a slab's top."""
        half = np.array(slab.size[:2]) / 2
        return self._rectangles(np.array([[*slab.position[:2], *half, slab.yaw]]))[0]

    def _rectangles(self, numbers: FloatArray) -> FloatArray:
        """Of rectangles (P, 5): middle, half sizes, m, and turn."""
        share = np.linspace(-1, 1, OUTLINE.places_count, endpoint=False)
        one = np.ones_like(share)
        sides = ((share, -one), (one, share), (-share, one), (-one, -share))
        local = np.stack([np.stack(side, 1) for side in sides])
        x, y, a, b, yaw = (number[:, None, None] for number in numbers.T)
        u, v = local[None, ..., 0] * a, local[None, ..., 1] * b
        cos, sin = np.cos(yaw), np.sin(yaw)
        places = np.stack([x + u * cos - v * sin, y + u * sin + v * cos], -1)
        flat = places.reshape(-1, 2)
        pixels, depth = self.camera.project(np.column_stack([flat, np.full(len(flat), self.top)]))
        ahead = np.where((depth > 1e-3)[:, None], pixels, np.nan)
        return ahead.reshape(places.shape) * self.view.factor

    def rectangles_of(self, numbers: FloatArray) -> FloatArray:
        """Rectangles (P, 5) from numbers (P, 5): the middle in parts of the box, logarithms of the
        half sizes over half the width of the box there, and the turn."""
        left, top, right, bottom = (side / self.view.factor for side in self.view.box)
        across = left + numbers[:, 0] * (right - left)
        middle = np.stack([across, top + numbers[:, 1] * (bottom - top)], 1)
        places = on_plane(self.camera, middle, self.top)[:, :2]
        beside = on_plane(self.camera, middle + np.array([1.0, 0.0]), self.top)[:, :2]
        wide = np.linalg.norm(beside - places, axis=1) * (right - left) / 2
        return np.column_stack([places, wide[:, None] * np.exp(numbers[:, 2:4]), numbers[:, 4]])

    def squares(self, numbers: FloatArray) -> FloatArray:
        """Of rectangles by their numbers (P, 5): see `rectangles_of`."""
        return self._rectangles(self.rectangles_of(numbers))

    def slab_of_oval(self, numbers: FloatArray, slab: Slab) -> Slab:
        """The slab that ends where what stands on a round top goes over its rim.

        Its corners lie beyond the rim, where nothing gets to on the way from there to a side.
        """
        rim = _ovals(self.view, numbers[None]).reshape(-1, 2) / self.view.factor
        places = on_plane(self.camera, rim, self.top)[:, :2]
        if not np.isfinite(places).all():
            return slab
        low, high = places.min(0), places.max(0)
        middle, radius = (low + high) / 2, (high - low) / 2
        standing = on_plane(self.camera, self.view.standing / self.view.factor, self.top)[:, :2]
        standing = standing[np.isfinite(standing).all(1)]
        off = (standing.mean(0) - middle) / radius if len(standing) else np.zeros(2)
        off = np.clip(off, -BOXED.max_off_ratio, BOXED.max_off_ratio)
        half = BOXED.chord_ratio * radius * np.sqrt(1 - off[::-1] ** 2)
        return _moved(slab, np.array([*middle, *half, 0.0]))
