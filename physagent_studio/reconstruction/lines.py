"""Straight edges of the picture, the points where they meet, and lines across it."""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from physagent_studio.records.case import Image

FloatArray = NDArray[np.float64]


@dataclass(frozen=True, eq=False, slots=True)
class Segments:
    """N straight edges: ends (N, 2, 2) pixels, length (N,), angle (N,) in −π/2 … π/2,

    image y down, contrast (N,) grey levels across the edge.
    """

    ends: FloatArray
    length: FloatArray
    angle: FloatArray
    contrast: FloatArray

    def only(self, keep: NDArray) -> Segments:
        """The segments that a boolean or index array selects."""
        return Segments(self.ends[keep], self.length[keep], self.angle[keep], self.contrast[keep])


def segments(image: Image, shortest: float = 0.03) -> Segments:
    """Edges longer than `shortest` of the picture's diagonal, longest first."""
    grey = cv2.cvtColor(image, cv2.COLOR_RGB2GRAY)
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
    result = Segments(ends, length, angle, _contrast(image, ends, delta, length))
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


def meeting_points(found: Segments, size: tuple[int, int], most: int = 60) -> FloatArray:
    """Vanishing points (M, 4): x, y, spread of y in pixels, weight 0 … 1; M ≤ 4, best first.

    Found by trying the crossings of all pairs of long, slanted edges and counting the edges
    that point there. Weight is the share of the slanted edges' length that does, less where
    only few edges do, for three lines often meet by chance. The spread
    follows from the edges' own directions being known to about a degree.
    """
    slanted = (np.abs(found.angle) > np.radians(3)) & (np.abs(found.angle) < np.radians(75))
    used = found.only(np.flatnonzero(slanted)[:most])
    count = len(used.length)
    if count < 3:
        return np.zeros((0, 4))
    homogeneous = np.concatenate([used.ends, np.ones((count, 2, 1))], 2)
    lines = np.cross(homogeneous[:, 0], homogeneous[:, 1])
    lines = lines / np.hypot(lines[:, 0], lines[:, 1])[:, None]
    first, second = np.triu_indices(count, 1)
    crossing = np.cross(lines[first], lines[second])
    fine = np.abs(crossing[:, 2]) > 1e-6
    spots = crossing[fine, :2] / crossing[fine, 2:]
    width, height = size
    spots = spots[(np.abs(spots[:, 1] - height / 2) < 2.5 * height)]
    spots = spots[np.abs(spots[:, 0] - width / 2) < 6 * width]
    points: list[tuple[float, float, float, float]] = []
    free = np.ones(count, bool)
    # Grain and dirt are short of contrast; edges of things are not.
    mass = used.length * np.clip(used.contrast / 20, 0.05, 1)
    total, diagonal = mass.sum(), np.hypot(width, height)
    for _ in range(4):
        if not len(spots) or np.count_nonzero(free) < 3:
            break
        votes = _pointing(used, spots) & free
        weight = (votes * mass).sum(1)
        weight[votes.sum(1) < 3] = 0
        best = int(weight.argmax())
        if weight[best] < 0.12 * total:
            break
        mine = votes[best]
        x, y, sigma = _refined(lines[mine], used.ends[mine].mean(1), spots[best])
        several = min(1.0, (np.count_nonzero(mine) - 2) / 4)
        points.append((x, y, sigma, float(several * weight[best] / max(total, 0.8 * diagonal))))
        free &= ~mine
    return np.array(points).reshape(-1, 4)


def _pointing(used: Segments, spots: FloatArray) -> NDArray[np.bool_]:
    """(S, N): whether segment n points at spot s within 1.5°, and does not contain it."""
    middle = used.ends.mean(1)
    toward = spots[:, None] - middle[None]
    distance = np.hypot(toward[..., 0], toward[..., 1])
    direction = np.stack([np.cos(used.angle), np.sin(used.angle)], 1)
    off = np.abs(toward[..., 0] * direction[:, 1] - toward[..., 1] * direction[:, 0])
    near = off < np.sin(np.radians(1.5)) * np.maximum(distance, 1)
    return near & (distance > 0.75 * used.length)


def _refined(
    lines: FloatArray, middles: FloatArray, spot: FloatArray
) -> tuple[float, float, float]:
    """The point nearest to a bundle of unit lines, and the standard deviation of its y."""
    noise = np.radians(0.8) * np.maximum(np.linalg.norm(middles - spot, axis=1), 20.0)
    weighted = lines / noise[:, None]
    information = weighted[:, :2].T @ weighted[:, :2] + 1e-12 * np.eye(2)
    covariance = np.linalg.inv(information)
    x, y = covariance @ (-weighted[:, :2].T @ weighted[:, 2])
    residual = weighted @ np.array([x, y, 1.0])
    misfit = float((residual**2).sum()) / max(len(lines) - 2, 1)
    return float(x), float(y), float(np.sqrt(covariance[1, 1] * max(1.0, misfit)))


def level_transitions(image: Image) -> list[tuple[float, float]]:
    """Rows (y, strength) where most columns change colour together: a wall's foot, a shore.

    strength: share of the columns that step there by more than their usual noise.
    """
    height = 240
    small = cv2.resize(image, (64, height), interpolation=cv2.INTER_AREA)
    lab = cv2.cvtColor(small, cv2.COLOR_RGB2LAB).astype(np.float32)
    step = np.zeros((height, 64), np.float32)
    reach = 4
    for k in range(reach, height - reach):
        before, after = lab[k - reach : k].mean(0), lab[k : k + reach].mean(0)
        step[k] = np.linalg.norm(after - before, axis=1)
    noise = np.maximum(np.median(step, 0) * 3, 6.0)
    share = (step > noise).mean(1)
    share = cv2.GaussianBlur(share.reshape(-1, 1).astype(np.float32), (1, 5), 1.0).ravel()
    found: list[tuple[float, float]] = []
    scale = image.shape[0] / height
    while len(found) < 4:
        k = int(share.argmax())
        if share[k] < 0.55:
            break
        found.append((k * scale, float(share[k])))
        share[max(0, k - 10) : k + 11] = 0
    return found
