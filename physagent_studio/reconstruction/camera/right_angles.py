"""What right-angled things say of the camera: edges of boxes, tables, tiles, rooms.

Each thing stands upright and is turned as it likes, so its edges run upwards or along one of two
level directions at a right angle. Where the camera is tilted and zoomed as it is thought to be, the
edges of every thing agree with such a turn; where it is not, they do not. Edges that agree with
none (grain, shadows, prints) count as what may be anywhere, so that they weigh little.

Follows the world of several level frames with one vertical of Schindler and Dellaert, "Atlanta
World", CVPR 2004, with the turns tried that the edges themselves give.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from physagent_studio.arrays import BoolArray, FloatArray
from physagent_studio.reconstruction.photo.line_segments import Segments


@dataclass(frozen=True, slots=True)
class EdgeSettings:
    """What the edges of right-angled things are like in a picture."""

    end_spread_px: float = 0.6  # 0.2..2: how far the end of an edge is read off the truth
    # 0.001..0.02: lenses bend, and things are not made exactly
    finest_rad: float = math.radians(0.35)
    aligned_share: float = 0.6  # 0.3..0.9: of a right-angled thing's edges that run along it
    max_bend_rad: float = math.radians(12.0)  # 0.05..0.4: more is a round outline or dirt
    full_contrast_levels: float = 20.0  # 5..60: fainter edges count less
    level_spread_rad: float = math.radians(8.0)  # 0.05..0.3: flat ground draws chance edges level
    same_line_px: float = 2.5  # 1..5: how far the pieces of one line lie off it
    stray_share: float = 0.15  # 0.01..0.5: of groups that are no right-angled thing at all
    straightened_share: float = 0.25  # 0..0.5: of level pictures, with uprights made parallel
    straightened_tilt_rad: float = math.radians(10.0)  # 0.05..0.4: by which it falls
    max_edges: int = 36  # count, 10..100: the longest of a thing; time grows with their square
    # -30..90: first, end and step of the tilts that are tried, from a little up to straight down
    pitches_deg: tuple[float, float, float] = (-12.0, 88.0, 1.0)
    max_turns: int = 14  # count, 4..36: of them that say how a thing may be turned


EDGE = EdgeSettings()

PITCHES = np.radians(np.arange(*EDGE.pitches_deg))
"""How far down the camera may look, rad: the tilts that are tried."""


@dataclass(frozen=True, eq=False, slots=True)
class Edges:
    """The N edges of one thing: ends (N, 2, 2) pixels from the middle of the picture,

    sigma (N,) how surely each tells its direction, rad, trust (N,) 0 … 1, and chance (N,) how much
    more often than others such directions are seen anyway.
    """

    ends: FloatArray
    sigma: FloatArray
    trust: FloatArray
    chance: FloatArray


def edges_by_thing(
    found: Segments,
    size: tuple[int, int],
    things: Sequence[BoolArray],
    others: Sequence[BoolArray] = (),
) -> list[Edges]:
    """The edges in and around each thing's mask (H, W), and those of all else together.

    Longest first, MOST of each. others: things that are not upright, whose edges are left out.
    """
    middle = found.ends.mean(1)
    owner = np.full(len(middle), -1)
    for index, mask in enumerate((*others, *things)):
        owner[_near(mask, middle) & (owner < 0)] = index
    straight = found.bend < EDGE.max_bend_rad
    groups = []
    for index in (*range(len(others), len(others) + len(things)), -1):
        mine = _apart(found.only((owner == index) & straight))
        if len(mine.length):
            groups.append(_edges(mine, size))
    return groups


def _apart(found: Segments) -> Segments:
    """The longest of N edges, of pieces of one line only the longest."""
    kept: list[int] = []
    for k, (one, other) in enumerate(found.ends):
        way = (other - one) / found.length[k]
        off = found.ends[kept] - one
        beside = np.abs(off[..., 0] * way[1] - off[..., 1] * way[0])
        if not (beside < EDGE.same_line_px).all(1).any():
            kept.append(k)
        if len(kept) == EDGE.max_edges:
            break
    return found.only(np.array(kept, int))


def _near(mask: BoolArray, points: FloatArray, reach: int = 4) -> NDArray[np.bool_]:
    """Which points (N, 2) lie in a mask or at most `reach` pixels from it."""
    hit = np.zeros(len(points), bool)
    height, width = mask.shape
    for dx in (-reach, 0, reach):
        for dy in (-reach, 0, reach):
            x = np.clip(points[:, 0].astype(int) + dx, 0, width - 1)
            y = np.clip(points[:, 1].astype(int) + dy, 0, height - 1)
            hit |= mask[y, x]
    return hit


def _edges(found: Segments, size: tuple[int, int]) -> Edges:
    sigma = np.hypot(
        math.sqrt(2) * EDGE.end_spread_px / np.maximum(found.length, 1.0), EDGE.finest_rad
    )
    trust = EDGE.aligned_share * np.clip(found.contrast / EDGE.full_contrast_levels, 0.2, 1.0)
    trust = trust * np.exp(-0.5 * (2 * found.bend / EDGE.max_bend_rad) ** 2)
    flat = (
        math.pi
        / (EDGE.level_spread_rad * math.sqrt(2 * math.pi))
        * np.exp(-0.5 * (found.angle / EDGE.level_spread_rad) ** 2)
    )
    return Edges(found.ends - np.array(size) / 2, sigma, trust, 0.5 + 0.5 * flat)


def votes(groups: Sequence[Edges], focals: FloatArray) -> FloatArray:
    """(F, P) log likelihood ratios of focal lengths, pixels, and PITCHES against chance.

    Upright edges may have been made parallel to the sides of the picture: shifted lenses and
    programs do so, and what is cut out of a picture looks alike. Then they say nothing of either.
    """
    seen = np.zeros((len(focals), len(PITCHES)))
    straightened = np.zeros_like(seen)
    for group in groups:
        own = np.array([_evidence(group, focal) for focal in focals])
        own = np.logaddexp(math.log(1 - EDGE.stray_share) + own, math.log(EDGE.stray_share))
        seen += own[:, 0]
        straightened += own[:, 1]
    share = EDGE.straightened_share * np.exp(-0.5 * (PITCHES / EDGE.straightened_tilt_rad) ** 2)
    return np.logaddexp(np.log(1 - share) + seen, np.log(share) + straightened)


def _evidence(edges: Edges, focal: float) -> FloatArray:
    """(2, P) log of how much better right angles explain the edges than chance does: upright

    edges as they are seen, and made parallel.
    """
    normal, along = _planes(edges, focal)
    upward = _density(normal[..., 2], along[..., 2], edges.sigma)
    run = edges.ends[:, 1] - edges.ends[:, 0]
    parallel = np.broadcast_to(_density(run[:, 0], run[:, 1], edges.sigma), upward.shape)
    flat = np.hypot(normal[..., 0], normal[..., 1])
    chosen = slice(0, EDGE.max_turns)
    x = -normal[:, chosen, 1] / np.maximum(flat[:, chosen], 1e-9)
    y = normal[:, chosen, 0] / np.maximum(flat[:, chosen], 1e-9)
    level = np.zeros((len(PITCHES), x.shape[1], edges.sigma.size))
    for u, v in ((x, y), (-y, x)):
        off = normal[:, None, :, 0] * u[..., None] + normal[:, None, :, 1] * v[..., None]
        run = along[:, None, :, 0] * u[..., None] + along[:, None, :, 1] * v[..., None]
        level += _density(off, run, edges.sigma)
    return np.stack([_over_turns(level + up[:, None], edges) for up in (upward, parallel)])


def _over_turns(density: FloatArray, edges: Edges) -> FloatArray:
    """(P,) from (P, turns, N) densities of three directions together, the turns taken alike."""
    share = density / 3 / edges.chance
    ratio = np.log(1 - edges.trust + edges.trust * share)
    total = ratio.sum(2)
    # An edge says as much for any turn as any other edge; that of the turn itself says nothing.
    own = np.arange(ratio.shape[1])
    total -= np.maximum(ratio[:, own, own], 0.0)
    best = total.max(1)
    return best + np.log(np.exp(total - best[:, None]).mean(1))


def _density(off: FloatArray, run: FloatArray, sigma: FloatArray) -> FloatArray:
    """How much likelier an edge's direction is than by chance, for a direction in space.

    off, run: that direction across the plane through the eye and the edge, and along the edge.
    """
    square = off**2 / np.maximum(off**2 + run**2, 1e-12)
    return math.pi / (sigma * math.sqrt(2 * math.pi)) * np.exp(-0.5 * square / sigma**2)


def _planes(edges: Edges, focal: float) -> tuple[FloatArray, FloatArray]:
    """For each pitch the planes through the eye and each edge, in the world, (P, N, 3):

    their normals, and the directions in them across the view of the edge's middle.
    """
    rays = np.concatenate([edges.ends / focal, np.ones((len(edges.sigma), 2, 1))], 2)
    normal = np.cross(rays[:, 0], rays[:, 1])
    normal /= np.linalg.norm(normal, axis=1, keepdims=True)
    view = rays.mean(1)
    view /= np.linalg.norm(view, axis=1, keepdims=True)
    along = np.cross(normal, view)
    down, ahead = np.sin(PITCHES), np.cos(PITCHES)
    zero, one = np.zeros_like(down), np.ones_like(down)
    rows = [[one, zero, zero], [zero, -down, ahead], [zero, -ahead, -down]]
    turn = np.moveaxis(np.array(rows), 2, 0)
    return normal @ np.swapaxes(turn, 1, 2), along @ np.swapaxes(turn, 1, 2)
