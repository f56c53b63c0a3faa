"""Straight edges of the picture, and lines across it."""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from physagent_studio.arrays import FloatArray
from physagent_studio.reconstruction.switches import at_work
from physagent_studio.records.case import Image


@dataclass(frozen=True, eq=False, slots=True)
class Segments:
    """N straight edges: ends (N, 2, 2) pixels, length (N,), angle (N,) in −π/2 … π/2,

    image y down, contrast (N,) grey levels across the edge, bend (N,) how much its direction
    changes from end to end, rad: pieces of round outlines are bent.
    """

    ends: FloatArray
    length: FloatArray
    angle: FloatArray
    contrast: FloatArray
    bend: FloatArray

    def only(self, keep: NDArray) -> Segments:
        """The segments that a boolean or index array selects."""
        values = (self.ends, self.length, self.angle, self.contrast, self.bend)
        return Segments(*(value[keep] for value in values))


def segments(image: Image, shortest: float = 0.03) -> Segments:
    """Edges longer than `shortest` of the picture's diagonal, longest first."""
    return _in_plane(image, cv2.cvtColor(image, cv2.COLOR_RGB2GRAY), shortest)


def with_hues(image: Image, found: Segments, shortest: float = 0.03) -> Segments:
    """The same and the edges at which colour changes and lightness does not: wood before brick."""
    lab = cv2.cvtColor(image, cv2.COLOR_RGB2LAB)
    colour_gain = 3.0  # factor, 1..6: a* and b* vary less than lightness does
    for hue in (lab[..., 1], lab[..., 2]):
        plane = cv2.GaussianBlur((hue.astype(np.float32) - 128) * colour_gain + 128, (0, 0), 1.0)
        new = _in_plane(image, np.clip(np.round(plane), 0, 255).astype(np.uint8), shortest)
        found = _with_fresh(found, new)
    return found


def with_grain(image: Image, found: Segments, shortest: float = 0.03) -> Segments:
    """The same and the edges of the softened picture: grain breaks edges to pieces."""
    if not at_work("edges in grain"):
        return found
    grain_px = 2.0  # 1..4: spread of the blur in which grain is lost
    soft = np.asarray(cv2.GaussianBlur(image, (0, 0), grain_px), np.uint8)
    return _with_fresh(found, segments(soft, shortest))


def _with_fresh(found: Segments, new: Segments) -> Segments:
    """The edges that are known and those new ones that do not run along them."""
    fresh = np.array([not _runs_along(edge, found.ends) for edge in new.ends], bool)
    both = found, new.only(fresh)
    return Segments(*(np.concatenate([getattr(one, name) for one in both]) for name in _FIELDS))


_FIELDS = ("ends", "length", "angle", "contrast", "bend")


def _runs_along(edge: FloatArray, known: FloatArray) -> bool:
    """Whether one of the known edges (N, 2, 2) runs along most of an edge (2, 2)."""
    if not len(known):
        return False
    way = known[:, 1] - known[:, 0]
    length = np.maximum(np.linalg.norm(way, axis=1), 1e-9)
    spots = edge[0] + np.array([0.2, 0.5, 0.8])[:, None] * (edge[1] - edge[0])
    off = spots[:, None] - known[:, 0]
    along = (off * way).sum(-1) / length
    aside = np.abs(off[..., 0] * way[:, 1] - off[..., 1] * way[:, 0]) / length
    return bool(((along > -3) & (along < length + 3) & (aside < 3)).all(0).any())


def _in_plane(image: Image, grey: NDArray, shortest: float) -> Segments:
    """Edges of one plane (H, W) uint8 of a picture."""
    found = cv2.createLineSegmentDetector().detect(grey)[0]
    ends = np.zeros((0, 2, 2)) if found is None else found.reshape(-1, 2, 2).astype(float)
    delta = ends[:, 1] - ends[:, 0]
    length = np.hypot(delta[:, 0], delta[:, 1])
    keep = length > shortest * np.hypot(*image.shape[:2])
    ends, delta, length = ends[keep], delta[keep], length[keep]
    flip = delta[:, 0] < 0
    ends[flip] = ends[flip][:, ::-1]
    delta[flip] *= -1
    angle = np.arctan2(delta[:, 1], delta[:, 0])
    contrast = _contrast(image, ends, delta, length)
    result = Segments(ends, length, angle, contrast, _bend(grey, ends, delta))
    return result.only(np.argsort(-length, kind="stable"))


def _contrast(image: Image, ends: FloatArray, delta: FloatArray, length: FloatArray) -> FloatArray:
    """Median colour step between the two sides of each edge, 2.5 pixels off."""
    if not len(ends):
        return np.zeros(0)
    soft = cv2.cvtColor(cv2.GaussianBlur(image, (0, 0), 1.0), cv2.COLOR_RGB2LAB).astype(np.float32)
    normal = np.stack([-delta[:, 1], delta[:, 0]], 1) / length[:, None]
    along = np.linspace(0.05, 0.95, 24)[None, :, None]
    middle = ends[:, :1] + along * delta[:, None]

    def sample(points: FloatArray) -> NDArray:
        x, y = points[..., 0].astype(np.float32), points[..., 1].astype(np.float32)
        return cv2.remap(soft, x, y, cv2.INTER_LINEAR, borderMode=cv2.BORDER_REPLICATE)

    step = sample(middle + 2.5 * normal[:, None]) - sample(middle - 2.5 * normal[:, None])
    return np.median(np.linalg.norm(step, axis=2), axis=1).astype(float)


def _bend(grey: NDArray, ends: FloatArray, delta: FloatArray) -> FloatArray:
    """How much the brightness gradient turns along each edge, rad.

    A straight line through its direction at points along the edge, each counted by how clear the
    edge is there; directions that differ by half a turn are the same.
    """
    if not len(ends):
        return np.zeros(0)
    soft = cv2.GaussianBlur(grey, (0, 0), 1.2).astype(np.float32)
    steps = [cv2.Sobel(soft, cv2.CV_32F, dx, 1 - dx, ksize=3) for dx in (1, 0)]
    share = np.linspace(0.1, 0.9, 16)
    spots = (ends[:, :1] + share[None, :, None] * delta[:, None]).astype(np.float32)
    x, y = (cv2.remap(step, spots[..., 0], spots[..., 1], cv2.INTER_LINEAR) for step in steps)
    across = np.stack([-delta[:, 1], delta[:, 0]], 1) / np.linalg.norm(delta, axis=1)[:, None]
    along = x * across[:, 1:] - y * across[:, :1]
    over = x * across[:, :1] + y * across[:, 1:]
    turn = np.arctan2(along * np.sign(over), np.abs(over) + 1e-9)
    weight = over**2 + 1e-6
    where = share[None] - (weight * share).sum(1, keepdims=True) / weight.sum(1, keepdims=True)
    slope = (weight * where * turn).sum(1) / (weight * where**2).sum(1)
    return np.abs(slope).astype(float)


def _grown(along: FloatArray, half: float) -> tuple[float, float]:
    """The span around 0 that pieces (N, 2) of one line fill with small gaps."""
    low, high = -half, half
    for _ in range(len(along)):
        gap = max(12.0, 0.3 * (high - low))
        near = (along[:, 0] < high + gap) & (along[:, 1] > low - gap)
        grown = (min(low, along[near, 0].min()), max(high, along[near, 1].max()))
        if grown == (low, high):
            break
        low, high = grown
    return float(low), float(high)


def joined(used: Segments, most: int = 40) -> tuple[FloatArray, FloatArray]:
    """Collinear pieces merged into one edge each: ends (N, 2, 2) and covered length (N,)."""
    ends, lengths = [], []
    for k in range(min(len(used.length), most)):
        direction = np.array([np.cos(used.angle[k]), np.sin(used.angle[k])])
        off = used.ends - used.ends[k].mean(0)
        across = np.abs(off[..., 0] * direction[1] - off[..., 1] * direction[0]).max(1)
        turn = np.abs(used.angle - used.angle[k])
        mine = (across < 4) & (np.minimum(turn, np.pi - turn) < np.radians(4))
        along = np.sort((used.ends[mine] - used.ends[k].mean(0)) @ direction, axis=1)
        reach = _grown(along, used.length[k] / 2)
        inside = (along[:, 0] >= reach[0] - 1e-6) & (along[:, 1] <= reach[1] + 1e-6)
        middle = used.ends[k].mean(0)
        ends.append([middle + reach[0] * direction, middle + reach[1] * direction])
        lengths.append(float((along[inside, 1] - along[inside, 0]).sum()))
    return np.array(ends).reshape(-1, 2, 2), np.array(lengths)
