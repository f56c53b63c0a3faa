"""How steeply a thing is looked at, from its outline and from what is known of its form.

Boxes, and what is about as regular (cars), have three edges at right angles, whose lengths are
known from the kind of thing with some spread. What is upright and round is a stack of level
circles, all seen equally flat: those at its foot and at its top show how flat. For each angle of
view the outlines that such forms can have are compared with the outline that is seen: by its
width in all directions, and by how far it reaches each way.
"""

import math
from collections.abc import Iterator
from dataclasses import dataclass

import cv2
import numpy as np

from physagent_studio.arrays import BoolArray, FloatArray
from physagent_studio.knowledge import Usual
from physagent_studio.reconstruction.camera.outline_forms import (
    ALL_WAYS,
    ANGLES,
    WAYS,
    Table,
    boxes_of,
    centred,
    is_boxy,
    is_round,
    rounds_of,
)


@dataclass(frozen=True, slots=True)
class OutlineSettings:
    """How well forms of a kind explain outlines."""

    # 0.02..0.1: of a box's outline in one direction: edges are rounded, cars have bonnets
    width_spread_log: float = 0.05
    reach_spread_ratio: float = 0.035  # 0.02..0.1: of a round outline in one direction
    edge_px: float = 1.0  # 0.5..2: how far the rim of a mask is off
    box_measures: float = 5.0  # count, 2..18: how many directions tell of their own
    round_measures: float = 8.0  # count, 2..30: the same, of round outlines
    stray_sigmas: float = 3.0  # 2..5: what is farther off is of another form
    thin_ratio: float = 0.07  # 0.02..0.2: of its size: what is thinner is no part of a body
    look_px: float = 90.0  # 50..300: size at which round outlines are looked at
    lost_share: float = 0.04  # 0.01..0.1: of a round body, what is not alike on both sides of it
    lean_step_deg: float = 2.5  # 1..10: of the leans at which an axis is sought
    least_px: int = 200  # 50..1000: of a mask, for its form to be seen


OUTLINE = OutlineSettings()


@dataclass(frozen=True, eq=False, slots=True)
class Outline:
    """middle: (x, y) pixels from the middle of the picture. votes: log likelihoods of ANGLES."""

    middle: tuple[float, float]
    votes: FloatArray

    def at(self, pitch: FloatArray, focal: float) -> FloatArray:
        """What it says of cameras that are tilted down so far, rad, and level."""
        x, y = self.middle
        down = (y * np.cos(pitch) + focal * np.sin(pitch)) / math.hypot(x, y, focal)
        return np.interp(np.arcsin(np.clip(down, -1, 1)), ANGLES, self.votes)


def outline_of(mask: BoolArray, usual: Usual, focal: float, roll: float = 0.0) -> Outline | None:
    """What the outline of a mask (H, W) says; None where its form is not known.

    focal: pixels. roll: radians by which the camera is turned clockwise.
    """
    known = is_boxy(usual) or is_round(usual)
    if not known or np.count_nonzero(mask) < OUTLINE.least_px or _is_cut(mask):
        return None
    rows, columns = mask.shape
    found = _Sighted(mask, _hull(mask) - (columns / 2, rows / 2), focal, roll)
    votes = _box_votes(found, usual) if is_boxy(usual) else _round_votes(found, usual)
    x, y = found.middle
    cos, sin = math.cos(roll), math.sin(roll)
    return Outline((x * cos - y * sin, x * sin + y * cos), votes)


def _is_cut(mask: BoolArray) -> bool:
    """Whether a mask goes on beyond the picture."""
    return bool(mask[[0, -1]].any() or mask[:, [0, -1]].any())


def _hull(mask: BoolArray) -> FloatArray:
    """Corners (N, 2) of the convex hull of a mask's pixels."""
    rows, columns = mask.nonzero()
    hull = cv2.convexHull(np.column_stack([columns, rows]).astype(np.float32))[:, 0] + 0.5
    corners = hull[:, None] + np.array([[-0.5, -0.5], [-0.5, 0.5], [0.5, -0.5], [0.5, 0.5]])
    return np.asarray(cv2.convexHull(corners.reshape(-1, 2).astype(np.float32))[:, 0], float)


class _Sighted:
    """A mask, the corners of its hull from the middle of the picture, and views straight at it."""

    def __init__(self, mask: BoolArray, hull: FloatArray, focal: float, roll: float) -> None:
        self.mask, self.hull, self.focal = mask, hull, focal
        x, y = (float(v) for v in (hull.max(0) + hull.min(0)) / 2)
        self.middle = (x, y)
        ahead = np.array([x, y, focal]) / math.hypot(x, y, focal)
        level = x * math.sin(roll) + y * math.cos(roll)
        share = math.hypot(x, y, focal) / math.hypot(level, focal)
        pitch = np.arcsin(np.clip(share * np.sin(ANGLES), -1, 1)) - math.atan2(level, focal)
        up = np.stack(
            [-np.cos(pitch) * math.sin(roll), -np.cos(pitch) * math.cos(roll), -np.sin(pitch)], 1
        )
        up -= (up @ ahead)[:, None] * ahead
        up /= np.maximum(np.linalg.norm(up, axis=1, keepdims=True), 1e-6)
        front = np.broadcast_to(ahead, up.shape)
        self.axes = np.stack([np.cross(front, up), up, front], 1)
        """(A, 3, 3) right, up and ahead of a camera that looks straight at it, for each angle."""

    @property
    def roughness(self) -> float:
        """How far the rim of the mask may be off, over its size."""
        return OUTLINE.edge_px / math.sqrt(np.count_nonzero(self.mask))

    @property
    def leans(self) -> FloatArray:
        """(A,) how far uprights lean to the right in the picture, rad."""
        return np.arctan2(self.axes[:, 1, 0], -self.axes[:, 1, 1])

    def reach(self, points: FloatArray, ways: FloatArray) -> FloatArray:
        """(A, W) how far points (N, 2) of the picture reach in directions, seen straight."""
        rays = np.column_stack([points, np.full(len(points), self.focal)])
        own = rays @ np.swapaxes(self.axes, 1, 2)
        flat = own[..., :2] / own[..., 2:]
        return (flat @ np.stack([np.cos(ways), np.sin(ways)])).max(1)


def _compared(
    forms: tuple[Table, FloatArray], seen: FloatArray, spread: float, measures: float
) -> FloatArray:
    """(A,) log likelihoods: how well forms of log weights (F,), (F, A, W), explain what is seen.

    seen: (A, W). spread: of it. measures: how many of the W directions tell of their own.
    """
    made, weights = forms
    misfit = ((made - seen.astype(np.float32)) ** 2).mean(2) / spread**2
    weights = weights - np.logaddexp.reduce(weights)
    votes = np.logaddexp.reduce(-0.5 * measures * misfit + weights[:, None], axis=0)
    return np.logaddexp(votes, -0.5 * measures * OUTLINE.stray_sigmas**2)


def _box_votes(found: _Sighted, usual: Usual) -> FloatArray:
    seen = np.log(found.reach(found.hull, WAYS) + found.reach(found.hull, WAYS + math.pi))
    seen -= seen.mean(1, keepdims=True)
    spread = math.hypot(OUTLINE.width_spread_log, math.sqrt(2) * found.roughness)
    return _compared(boxes_of(usual), seen, spread, OUTLINE.box_measures)


def _round_votes(found: _Sighted, usual: Usual) -> FloatArray:
    spread = math.hypot(OUTLINE.reach_spread_ratio, found.roughness)
    reach, shares = _body_reach(found)
    votes = _compared(rounds_of(usual), centred(reach), spread, OUTLINE.round_measures)
    # Where the axis would lean otherwise, less is alike on both of its sides.
    return votes - 0.5 * ((shares.max() - shares) / OUTLINE.lost_share) ** 2


def _body_reach(found: _Sighted) -> tuple[FloatArray, FloatArray]:
    """(A, W) how far the body of a round thing reaches, and which share of it is alike on both

    sides of its axis (A,); a handle is not.
    """
    step = math.radians(OUTLINE.lean_step_deg)
    leans = np.round(found.leans / step)
    out, shares = np.zeros((len(ANGLES), len(ALL_WAYS))), np.zeros(len(ANGLES))
    for lean, share, corners in _bodies(found, sorted(set(leans.tolist())), step):
        reach = found.reach(corners, ALL_WAYS)
        out[leans == lean], shares[leans == lean] = reach[leans == lean], share
    return out, shares


def _bodies(
    found: _Sighted, leans: list[float], step: float
) -> Iterator[tuple[float, float, FloatArray]]:
    """For axes that lean by so many steps, rad each, what is alike on both sides: its share and the

    corners (N, 2) of its hull.
    """
    low, high = found.hull.min(0), found.hull.max(0)
    rows, columns = found.mask.shape
    x, y = np.floor(low + np.array([columns, rows]) / 2).astype(int)
    wide, tall = np.ceil(high - low).astype(int)
    scale = min(1.0, OUTLINE.look_px / max(wide, tall))
    cut = found.mask[y : y + tall, x : x + wide].astype(np.float32)
    small = cv2.resize(cut, None, fx=scale, fy=scale, interpolation=cv2.INTER_AREA) > 0.5
    body = _without_thin(np.asarray(small)).astype(np.float32)
    side = 2 * max(body.shape)
    for lean in leans:
        turn = cv2.getRotationMatrix2D((0, 0), math.degrees(lean * step), 1.0)
        turn[:, 2] = side / 2 - turn[:, :2] @ (np.array(body.shape[::-1]) / 2)
        upright = np.asarray(cv2.warpAffine(body, turn, (side, side)) > 0.5)
        both = _symmetric(upright)
        corners = (_hull(both) - turn[:, 2]) @ turn[:, :2]
        yield lean, np.count_nonzero(both) / np.count_nonzero(upright), corners / scale + low


def _without_thin(mask: BoolArray) -> BoolArray:
    """A mask without handles and hoops, where something is left of it."""
    reach = round(OUTLINE.thin_ratio * math.sqrt(np.count_nonzero(mask)))
    if not reach:
        return mask
    disc = cv2.getStructuringElement(cv2.MORPH_ELLIPSE, (2 * reach + 1, 2 * reach + 1))
    wide = np.pad(mask.astype(np.uint8), reach + 1)
    opened = np.minimum(cv2.dilate(cv2.morphologyEx(wide, cv2.MORPH_OPEN, disc), disc), wide)
    thick = opened[reach + 1 : -reach - 1, reach + 1 : -reach - 1].astype(bool)
    return thick if 2 * np.count_nonzero(thick) > np.count_nonzero(mask) else mask


def _symmetric(mask: BoolArray) -> BoolArray:
    """What of a mask is alike on both sides of the upright axis about which most of it is."""
    columns = np.flatnonzero(mask.any(0))
    low, high = int(columns[0]), int(columns[-1])
    quarter = (high - low) // 4
    best = mask
    most = -1
    for twice in range(low + high - quarter, low + high + quarter + 1):
        mirrored = np.zeros_like(mask)
        own = np.arange(max(0, twice - mask.shape[1] + 1), min(mask.shape[1], twice + 1))
        mirrored[:, own] = mask[:, twice - own]
        mirrored &= mask
        count = np.count_nonzero(mirrored)
        if count > most:
            best, most = mirrored, count
    return best
