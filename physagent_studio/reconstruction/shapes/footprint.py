"""How a thing that stands on the ground is turned, from the lower rim of its mask.

Seen from above its horizon, what stands on level ground and is about rectangular shows the two
sides of its footprint that face the camera as the lower rim of its outline. Laid onto the ground
they are two lines at a right angle. Of all turns that one is taken whose two lines the rim is
nearest to; where the camera or the outline does not fit, no turn is much nearer than another.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from physagent_studio.program.scene.camera import Camera
from physagent_studio.program.scene.shapes import FloatArray

SAMPLES = 60
"""Points of the rim that are laid onto the ground, evenly across the picture."""
FAR = 8.0
"""Pixels beyond which a point counts as no part of a side: what is off the ground lies far back."""
ON = 2.0
"""Pixels within which a point is on a side."""
CLEAR = 0.5
"""Share of the usual distance that the best turn may have, to be told from the others."""
FEWEST = 6
"""Points that a side has at least, to be seen at all."""


@dataclass(frozen=True, slots=True)
class Footprint:
    """angle: degrees, seen from above, 0 … 180, of the longer one of the sides that are seen; 0 is
    to the right. along, across: how much of it and of the other is seen, m; across is 0 where the
    other is not."""

    angle: float
    along: float
    across: float


def footprint_of(mask: np.ndarray, camera: Camera, height: float) -> Footprint | None:
    """How the thing of a mask (H, W) bool stands on ground at that height, m; None if unclear."""
    rim = _rim(mask)
    if rim is None:
        return None
    rows, columns = mask.shape
    pixels = rim * np.array([camera.size[0] / columns, camera.size[1] / rows])
    rays, eye = camera.rays(pixels), np.array(camera.position, float)
    if eye[2] <= height or (rays[:, 2] >= -1e-3).any():
        return None
    places = (eye + rays * ((height - eye[2]) / rays[:, 2])[:, None])[:, :2]
    away = float(np.median(np.linalg.norm(places - eye[:2], axis=1)))
    toward = eye[:2] - np.median(places, axis=0)
    pixel = np.hypot(away, eye[2] - height) / camera.focal
    turns = np.arange(0.0, 90.0, 1.0)
    found = [_sides(places, toward, np.radians(turn)) for turn in turns]
    costs = [float(np.minimum(gaps.min(axis=0), FAR * pixel).mean()) for gaps, _ in found]
    best = int(np.argmin(costs))
    if costs[best] > CLEAR * float(np.median(costs)):
        return None
    return _measured(float(turns[best]), *found[best], ON * pixel)


def _rim(mask: np.ndarray) -> FloatArray | None:
    """(SAMPLES, 2) pixels of the convex rim below a mask, its two ends left out."""
    columns = np.flatnonzero(mask.any(axis=0))
    if len(columns) < SAMPLES // 2:
        return None
    lowest = mask.shape[0] - 1 - np.argmax(mask[::-1], axis=0)
    hull: list[tuple[float, float]] = []
    for column in columns.tolist():
        x, y = float(column), float(lowest[column])
        while len(hull) > 1:
            (a, b), (c, d) = hull[-2:]
            if (c - a) * (y - d) - (d - b) * (x - c) < 0:
                break
            hull.pop()
        hull.append((x, y))
    corners = np.array(hull)
    across = np.linspace(corners[0, 0], corners[-1, 0], SAMPLES + 2)[1:-1]
    return np.stack([across, np.interp(across, corners[:, 0], corners[:, 1])], axis=1)


def _sides(places: FloatArray, toward: FloatArray, turn: float) -> tuple[FloatArray, FloatArray]:
    """(2, n) m: how far behind each of the two sides of a footprint turned by `turn` (rad) points
    (n, 2) lie, and where along it."""
    gaps, along = [], []
    for angle in (turn, turn + np.pi / 2):
        way = np.array([np.cos(angle), np.sin(angle)])
        out = np.array([-way[1], way[0]])
        out = out if float(out @ toward) >= 0 else -out
        reach = places @ out
        gaps.append(reach.max() - reach)
        along.append(places @ way)
    return np.array(gaps), np.array(along)


def _measured(turn: float, gaps: FloatArray, along: FloatArray, near: float) -> Footprint:
    nearer = gaps.argmin(axis=0)
    lengths = []
    for side in (0, 1):
        on = (nearer == side) & (gaps[side] < near)
        lengths.append(float(np.ptp(along[side][on])) if int(on.sum()) >= FEWEST else 0.0)
    longer = int(np.argmax(lengths))
    return Footprint(turn + 90.0 * longer, lengths[longer], lengths[1 - longer])
