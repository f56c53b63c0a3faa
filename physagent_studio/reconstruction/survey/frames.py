"""Upright frames in the picture: a goal, a gate, a doorway."""

import math
from dataclasses import dataclass

import numpy as np

from physagent_studio.arrays import BoolArray, FloatArray
from physagent_studio.reconstruction.photo.line_segments import joined, segments
from physagent_studio.records.case import Image


@dataclass(frozen=True, slots=True)
class Frame:
    """Two posts and a bar. corners: left foot, right foot, right top, left top, pixels."""

    corners: tuple[tuple[float, float], ...]
    strength: float

    @property
    def foot(self) -> float:
        """Row of the posts' feet."""
        return (self.corners[0][1] + self.corners[1][1]) / 2

    @property
    def height(self) -> float:
        """Length of the posts, pixels."""
        return self.foot - (self.corners[2][1] + self.corners[3][1]) / 2


def find_frame(image: Image, ignore: BoolArray) -> Frame | None:
    """The strongest frame: a level bar with a post under each of its ends.

    ignore: pixels (H, W) of objects, whose edges do not count.
    """
    # 0.005..0.05: over the diagonal: posts are thin and broken by what is behind
    min_edge_ratio = 0.015
    found = segments(image, min_edge_ratio)
    found = found.only(found.contrast > 15)
    size = (image.shape[1], image.shape[0])
    free = ~_on(found.ends.mean(1), ignore) if len(found.length) else np.zeros(0, bool)
    level = found.only(free & (np.abs(found.angle) < math.radians(8)))
    upright = found.only(free & (np.abs(found.angle) > math.radians(80)))
    bars, bar_length = joined(level, 60)
    posts, post_length = joined(upright, 90)
    best: Frame | None = None
    reach = 0.02 * max(size)
    for bar, length in zip(bars, bar_length, strict=True):
        left, right = bar[bar[:, 0].argsort(kind="stable")]
        width = float(right[0] - left[0])
        if width < 0.08 * size[0]:
            continue
        post_l = _post_under(left, posts, post_length, width, reach)
        post_r = _post_under(right, posts, post_length, width, reach)
        if post_l is None or post_r is None:
            continue
        (foot_l, share_l), (foot_r, share_r) = post_l, post_r
        heights = (foot_l[1] - left[1], foot_r[1] - right[1])
        if min(heights) < 0.85 * max(heights):
            continue
        strength = length + share_l + share_r
        if best is None or strength > best.strength:
            # Both posts stand on one level: the lower foot is the one seen whole.
            low = max(float(foot_l[1]), float(foot_r[1]))
            feet = [(float(foot_l[0]), low), (float(foot_r[0]), low)]
            corners = (*feet, *((float(p[0]), float(p[1])) for p in (right, left)))
            best = Frame(corners, float(strength))
    return best


def _on(spots: FloatArray, region: BoolArray) -> BoolArray:
    x = np.clip(spots[:, 0].astype(int), 0, region.shape[1] - 1)
    y = np.clip(spots[:, 1].astype(int), 0, region.shape[0] - 1)
    return region[y, x]


def _post_under(
    corner: FloatArray, posts: FloatArray, lengths: FloatArray, width: float, reach: float
) -> tuple[FloatArray, float] | None:
    """Foot and covered length of the longest post that starts at a bar's end."""
    best: tuple[FloatArray, float] | None = None
    for ends, length in zip(posts, lengths, strict=True):
        top, foot = ends[ends[:, 1].argsort(kind="stable")]
        drop = float(foot[1] - corner[1])
        near = abs(top[0] - corner[0]) < reach and abs(top[1] - corner[1]) < 2 * reach
        if near and 0.15 * width < drop < 2.5 * width and (best is None or length > best[1]):
            best = (foot, float(length))
    return best
