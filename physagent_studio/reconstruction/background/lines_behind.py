"""Lines that run behind what is taken out of a picture: seen on both sides of it."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import cv2
import numpy as np
from numpy.typing import NDArray

from physagent_studio.arrays import FloatArray
from physagent_studio.program.scene.camera import Camera
from physagent_studio.program.scene.state import Ramp, Slab, Support
from physagent_studio.reconstruction.background.edges_onward import onward, to_border
from physagent_studio.reconstruction.photo.line_segments import Segments
from physagent_studio.reconstruction.photo.regions import BoolArray, grow
from physagent_studio.reconstruction.shapes.meshes import ramp_corners
from physagent_studio.reconstruction.switches import at_work
from physagent_studio.records.case import Image


@dataclass(frozen=True, slots=True)
class LineSettings:
    """Which edges are one line."""

    max_bend_rad: float = math.radians(5.0)  # 0.02..0.3: between two pieces of one line
    beside_px: float = 3.0  # 1..10: by which two ends may miss one another's line
    twin_px: float = 1.5  # 0.5..5: between two lines that are one
    max_arc_rad: float = math.radians(60.0)  # 0.2..2: between the two ends of a bent line
    uneven_arc_rad: float = math.radians(8.0)  # 0.03..0.3: by which its ends differ from an arc's
    arc_piece_rad: float = math.radians(8.0)  # 0.02..0.3: of a straight piece of a bent line
    alike_levels: float = 45.0  # 15..90: on either side of two pieces of one line
    clear_levels: float = 30.0  # 10..90: between the two sides of a bent line: grass has edges too


LINE = LineSettings()


def lines_through(
    photo: Image,
    hole: BoolArray,
    found: Segments,
    whole: BoolArray | None = None,
) -> FloatArray:
    """Lines (N, 2, 2), pixels, that join two edges of the picture across the hole (H, W).

    Edges that go on straight are joined first, then those found again where they come out. whole:
    (H, W) all that is filled in, of which the hole is a part: the lines begin beside it where their
    edges are seen there.
    """
    ends, ways = _heading_in(hole, found)
    if not len(ends):
        return np.zeros((0, 2, 2))
    colours = _sides(photo, ends, ways)
    pairs = []
    for i in range(len(ends)):
        for j in range(i + 1, len(ends)):
            missed = _missed(ends[i], ways[i], ends[j], ways[j])
            if missed is None or not _within(hole, ends[i], ends[j]):
                continue
            # Facing one another, the left of one is the right of the other.
            apart = np.abs(colours[i] - colours[j, ::-1]).mean(-1).max()
            if apart < LINE.alike_levels and at_work("straight lines"):
                pairs.append((missed + apart / 8, i, j))
    taken: set[int] = set()
    out = []
    for _, i, j in sorted(pairs):
        if i not in taken and j not in taken:
            taken |= {i, j}
            out.append((ends[i], ends[j]))
    bent = _bent(hole, ends, ways, colours, taken) if at_work("bent lines") else []
    lengths = _lengths(ends, found)
    rest = np.array([k for k in range(len(ends)) if k not in taken], int)
    straight = np.zeros((0, 2, 2))
    if at_work("edges onward"):
        straight = onward(photo, ends[rest], ways[rest], lengths[rest], hole)
        cut = to_border(photo, ends[rest], ways[rest], lengths[rest], hole)
        straight = np.concatenate([straight, cut])
    lines = np.concatenate([np.array(out).reshape(-1, 2, 2), straight])
    if whole is not None and at_work("lines from beside"):
        lines = _from_beside(lines, whole, ends, ways, lengths)
    return np.concatenate([lines, *bent])


def _bent(
    hole: BoolArray, ends: FloatArray, ways: FloatArray, colours: FloatArray, taken: set[int]
) -> list[FloatArray]:
    """Lines (n, 2, 2) each, pixels, along arcs that join two edges across the hole (H, W).

    ends, ways: (E, 2) as `_heading_in` gives them. colours: (E, 2, 3) left and right of them.
    taken: the edges that are joined already; those joined here are added.
    """
    pairs = []
    clear = np.abs(colours[:, 0] - colours[:, 1]).mean(-1) > LINE.clear_levels
    for i in np.flatnonzero(clear):
        for j in np.flatnonzero(clear[:i]):
            turns = _arc(ends[i], ways[i], ends[j], ways[j])
            apart = np.abs(colours[i] - colours[j, ::-1]).mean(-1).max()
            if i in taken or j in taken or turns is None or apart > LINE.alike_levels:
                continue
            spots = _on_arc(ends[i], ends[j], (turns[0] + turns[1]) / 2)
            if all(_within(hole, *piece) for piece in pairwise(spots)):
                uneven = math.degrees(abs(turns[0] - turns[1]))
                pairs.append((uneven + apart / 8, i, j, spots))
    out = []
    for _, i, j, spots in sorted(pairs, key=lambda pair: pair[:3]):
        if i not in taken and j not in taken:
            taken |= {i, j}
            out.append(np.stack([spots[:-1], spots[1:]], 1))
    return out


def _arc(p: FloatArray, u: FloatArray, q: FloatArray, v: FloatArray) -> tuple[float, float] | None:
    """By how much a line that leaves p along u and comes to q against v turns before and after it
    goes straight from p to q, rad; None where that is no arc."""
    gap = q - p
    if float(np.linalg.norm(gap)) < 4 or gap @ u <= 0 or gap @ v >= 0:
        return None
    before = math.atan2(u[0] * gap[1] - u[1] * gap[0], float(u @ gap))
    after = math.atan2(gap[1] * v[0] - gap[0] * v[1], float(-(gap @ v)))
    if abs(before + after) > LINE.max_arc_rad or abs(before - after) > LINE.uneven_arc_rad:
        return None
    return before, after


def _on_arc(p: FloatArray, q: FloatArray, half: float) -> FloatArray:
    """Spots (n, 2) along an arc from p to q that turns by `half` until it runs along the chord."""
    if abs(half) < 1e-3:
        return np.stack([p, q])
    count = math.ceil(abs(2 * half) / LINE.arc_piece_rad)
    gap = q - p
    # The centre lies beside the middle of the chord; from there the arc is a turn.
    centre = (p + q) / 2 + np.array([-gap[1], gap[0]]) / (2 * math.tan(half))
    turns = np.linspace(0, 2 * half, count + 1)
    x, y = p - centre
    return centre + np.stack(
        [np.cos(turns) * x - np.sin(turns) * y, np.sin(turns) * x + np.cos(turns) * y], 1
    )


def _from_beside(
    lines: FloatArray, whole: BoolArray, ends: FloatArray, ways: FloatArray, lengths: FloatArray
) -> FloatArray:
    """The lines (N, 2, 2) from where their edges (E, 2) run into the whole of the hole (H, W)."""
    out = lines.copy()
    closed = grow(whole, 2)
    for end, way, length in zip(ends, ways, lengths, strict=True):
        back = end - np.arange(0.0, length)[:, None] * way
        free = np.flatnonzero(_at(closed, back) == 0)
        out[(lines == end).all(-1)] = back[free[0] if len(free) else -1]
    return out


def each_once(lines: FloatArray) -> FloatArray:
    """Lines (N, 2, 2), pixels, without those that run along an earlier one."""
    out: list[FloatArray] = []
    for line in lines:
        middle = line.mean(0)
        if not any(_along(other, line) and _along(other, middle[None]) for other in out):
            out.append(line)
    return np.array(out).reshape(-1, 2, 2)


def _along(line: FloatArray, spots: FloatArray, near: float = LINE.twin_px) -> bool:
    """Whether spots (N, 2) lie on a line (2, 2), as near as that, pixels."""
    way = (line[1] - line[0]) / max(float(np.linalg.norm(line[1] - line[0])), 1e-9)
    off = spots - line[0]
    along = off @ way
    aside = np.abs(off[:, 0] * way[1] - off[:, 1] * way[0])
    inside = (along > -near) & (along < np.linalg.norm(line[1] - line[0]) + near)
    return bool((inside & (aside < near)).all())


def _lengths(tips: FloatArray, found: Segments) -> FloatArray:
    """(N,) how long the edges with these tips (N, 2) are, pixels."""
    long = np.linalg.norm(found.ends[:, 1] - found.ends[:, 0], axis=1)
    return np.array([long[(found.ends == tip).all(2).any(1)].max() for tip in tips])


def edges_of(
    photo: Image, hole: BoolArray, camera: Camera, supports: Sequence[Support]
) -> FloatArray:
    """Edges (N, 2, 2), pixels, of level tops and of ramps that run behind the hole (H, W).

    An edge that was read off the picture has to be seen there where it is not hidden; where a
    person marked the corners of a top it is taken as it is.
    """
    grey = cv2.GaussianBlur(photo, (0, 0), 1.5).astype(float)
    out: dict[tuple[float, ...], FloatArray] = {}
    mostly_share = 0.6  # 0.3..0.9: of its visible part over which an edge has to be seen
    for support in supports:
        marked = isinstance(support.shape, Slab) and bool(support.grounding.marked("top"))
        for face in faces_of(support, camera):
            for edge in np.stack([face, np.roll(face, -1, 0)], 1):
                hidden, seen = along_edge(grey, hole, edge)
                if hidden and (marked or seen > mostly_share):
                    ends = sorted((round(x, 3), round(y, 3)) for x, y in edge.tolist())
                    out.setdefault((*ends[0], *ends[1]), edge)
    return np.array(list(out.values())).reshape(-1, 2, 2)


def along_edge(grey: FloatArray, hole: BoolArray, edge: FloatArray) -> tuple[bool, float]:
    """Whether an edge (2, 2), pixels, is hidden somewhere, and over what share of the rest it is
    seen; 0 where too little of it is in view."""
    along = edge[0] + np.linspace(0, 1, 200)[:, None] * (edge[1] - edge[0])
    inside = (along >= 0).all(1) & (along < (hole.shape[1], hole.shape[0])).all(1)
    hidden = inside & (_at(hole, along) > 0)
    return bool(hidden.any()), _seen_share(grey, along[inside & ~hidden], edge[1] - edge[0])


def faces_of(support: Support, camera: Camera) -> list[FloatArray]:
    """Pixels (K, 2) of the corners of a level top, or of the sides of a ramp that are seen."""
    out = []
    for face in _faces(support, camera):
        pixels, depth = camera.project(face)
        if depth.min() > 0.05 * abs(depth).max():
            out.append(pixels)
    return out


def _faces(support: Support, camera: Camera) -> list[FloatArray]:
    """The same, in the world (K, 3); whatever of them lies behind the camera."""
    if isinstance(support.shape, Slab):
        return [_top_corners(support.shape)]
    if not isinstance(support.shape, Ramp) or support.shape.steps:
        return []
    left, right = ramp_corners(support.shape)
    following = np.stack([left, right, np.roll(right, -1, 0), np.roll(left, -1, 0)], 1)
    middle = np.concatenate([left, right]).mean(0)
    out = []
    for face in (left, right, *following):
        normal = np.cross(face[1] - face[0], face[2] - face[0])
        # Whichever way round its corners go: outward is away from the middle of the ramp.
        normal *= np.sign(normal @ (face.mean(0) - middle))
        if normal @ (np.array(camera.position) - face[0]) > 0:
            out.append(face)
    return out


def _top_corners(slab: Slab) -> FloatArray:
    cos, sin = math.cos(slab.yaw), math.sin(slab.yaw)
    flat = np.array([[-1, -1], [1, -1], [1, 1], [-1, 1]]) * np.array(slab.size[:2]) / 2
    turned = flat @ np.array([[cos, sin], [-sin, cos]]) + slab.position[:2]
    return np.column_stack([turned, np.full(4, slab.position[2] + slab.size[2] / 2)])


def _seen_share(grey: FloatArray, along: FloatArray, way: FloatArray) -> float:
    """Over what share of a line's visible part (N, 2) colours differ on its two sides."""
    if len(along) < 10:
        return 0.0
    normal = np.array([-way[1], way[0]]) / max(float(np.linalg.norm(way)), 1e-9)
    step = np.abs(_at(grey, along + 4 * normal) - _at(grey, along - 4 * normal)).mean(-1)
    seen_levels = 12.0  # 4..40: across an edge that counts as seen
    return float((step > seen_levels).mean())


def _heading_in(hole: BoolArray, found: Segments) -> tuple[FloatArray, FloatArray]:
    """Ends (N, 2) of edges at the hole and unit directions (N, 2) into it."""
    away = cv2.distanceTransform((~hole).astype(np.uint8), cv2.DIST_L2, 5)
    near_ratio = 0.03  # 0.005..0.1: over the longer side, from the hole to where an edge ends
    near = near_ratio * max(hole.shape)
    tips = found.ends.reshape(-1, 2)
    tails = found.ends[:, ::-1].reshape(-1, 2)
    ways = (tips - tails) / np.maximum(np.linalg.norm(tips - tails, axis=1), 1e-9)[:, None]
    ahead = tips[:, None] + np.linspace(0.0, 1.4 * near, 9)[:, None] * ways[:, None]
    gaps = _at(away, ahead.reshape(-1, 2)).reshape(-1, 9)
    into = (gaps[:, 0] < near) & (gaps.min(1, initial=np.inf) == 0) & (_at(away, tails) > 0)
    return tips[into], ways[into]


def _at(image: NDArray, points: FloatArray) -> FloatArray:
    x = np.clip(points[:, 0].astype(int), 0, image.shape[1] - 1)
    y = np.clip(points[:, 1].astype(int), 0, image.shape[0] - 1)
    return np.asarray(image[y, x], float)


def _sides(photo: Image, ends: FloatArray, ways: FloatArray) -> FloatArray:
    """(N, 2, 3) colours to the left and the right of each edge, a little before its end."""
    soft = cv2.GaussianBlur(photo, (0, 0), 1.5).astype(float)
    normal = np.stack([-ways[:, 1], ways[:, 0]], 1)
    spots = [(ends - back * ways) for back in (5, 9, 13)]
    sides = [[_at(soft, spot + 5 * sign * normal) for spot in spots] for sign in (1, -1)]
    return np.median(np.array(sides), axis=1).transpose(1, 0, 2)


def _missed(p: FloatArray, u: FloatArray, q: FloatArray, v: FloatArray) -> float | None:
    """How far two ends miss one another's line, pixels; None where they are not one line."""
    gap = q - p
    length = float(np.linalg.norm(gap))
    if length < 4 or gap @ u <= 0 or -(u @ v) < math.cos(LINE.max_bend_rad):
        return None
    missed = max(
        abs(float(gap[0] * u[1] - gap[1] * u[0])), abs(float(gap[0] * v[1] - gap[1] * v[0]))
    )
    return missed if missed < LINE.beside_px + 0.03 * length else None


def _within(hole: BoolArray, p: FloatArray, q: FloatArray) -> bool:
    share = np.linspace(0, 1, 40)[:, None]
    return bool(_at(hole, p + share * (q - p)).mean() > 0.6)
