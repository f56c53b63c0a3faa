"""Tables, shelves and steps: the visible edges of a top surface make a slab."""

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from physagent_studio.arrays import FloatArray
from physagent_studio.program.scene.camera import Camera
from physagent_studio.program.scene.state import Slab
from physagent_studio.reconstruction.camera.rays import metres_per_pixel, on_plane
from physagent_studio.reconstruction.photo.line_segments import Segments
from physagent_studio.reconstruction.photo.regions import BoolArray, grow


@dataclass(frozen=True, slots=True)
class SlabSettings:
    """How the edges of a top are read."""

    # 0.004..0.04: over the longer side: how far beside an edge is looked
    beside_ratio: float = 0.012
    min_both_share: float = 0.8  # 0.5..1: of both sides on the top, from which a line lies on it
    # count, 2..6: parallel lines on a top that are its planks and do not end it
    min_pattern: int = 3
    # 0..2: over the seen length: how far a top goes on where no edge ends it
    unseen_end_ratio: float = 0.5


SLAB = SlabSettings()


@dataclass(frozen=True, eq=False, slots=True)
class _Edges:
    """Edges on the top's plane: middle (N, 2), direction (N,) radians, weight (N,),

    inward (N, 2): unit vector across the edge to where the top goes on; zero where unclear.
    within (N,): lines on the top itself, such as those between planks: it goes on on both sides.
    """

    middle: FloatArray
    angle: FloatArray
    weight: FloatArray
    inward: FloatArray
    within: BoolArray


def fit_slab(
    camera: Camera,
    top: float,
    region: BoolArray,
    found: Segments,
    standing: Sequence[tuple[float, float]],
    half_widths: Sequence[float],
    clicks: Sequence[tuple[float, float]],
    thickness: float,
    beyond: float = math.inf,
    *,
    boxed: bool = False,
) -> Slab | None:
    """The slab whose top at height `top` shows as `region` in the picture.

    found: edges of the picture. standing: pixels of the feet of what stands on it, with half
    the width of each (pixels): the middle of its base, behind the foot, lies on the top.
    clicks: pixels that a person gave; four or more clicks are the corners of the top. beyond:
    how far it goes on outside the picture at most, m. boxed: a person drew a box around it, so
    that in the picture it ends where the region does.
    None where nothing of the plane is in view.
    """
    if len(clicks) >= 4:
        corners = on_plane(camera, clicks, top)[:, :2]
        if np.isfinite(corners).all():
            return _around(corners, _longest_side(corners), top, thickness)
    seeds = on_plane(camera, list(standing) or list(clicks), top)[:, :2]
    halves = np.zeros(len(seeds))
    for k, half in enumerate(half_widths):
        if np.isfinite(seeds[k]).all():
            halves[k] = half * metres_per_pixel(camera, (*seeds[k], top))
    seeds[:, 1] += halves
    halves, seeds = halves[np.isfinite(seeds).all(1)], seeds[np.isfinite(seeds).all(1)]
    area = _region_on_plane(camera, top, region)
    if not len(seeds):
        seeds = np.median(area, axis=0, keepdims=True) if len(area) else seeds
        halves = np.zeros(len(seeds))
    if not len(seeds):
        return None
    edges = _nearer_counts_more(_edges_on_plane(camera, top, region, found), seeds)
    yaw = _main_direction(edges)
    over = 0.0 if boxed else camera.position[2] - top
    limits, bounded = _limits(over, yaw, (seeds, halves), edges, area)
    limits = _past_unseen_ends(camera, top, region, yaw, limits, bounded, beyond, boxed)
    return _slab(yaw, limits, top, thickness)


def _region_on_plane(camera: Camera, top: float, region: BoolArray) -> FloatArray:
    """Places (N, 2) of a sample of the region's pixels on the plane."""
    rows, columns = np.nonzero(region)
    if not len(rows):
        return np.zeros((0, 2))
    step = max(1, len(rows) // 3000)
    pixels = np.column_stack([columns[::step] + 0.5, rows[::step] + 0.5])
    places = on_plane(camera, pixels, top)[:, :2]
    places = places[np.isfinite(places).all(1)]
    far = 25 * max(camera.position[2] - top, 0.01)
    return places[np.hypot(places[:, 0], places[:, 1] - camera.position[1]) < far]


def _edges_on_plane(camera: Camera, top: float, region: BoolArray, found: Segments) -> _Edges:
    """Edges at the rim of the region, as lines on the plane of the top."""
    near = grow(region, max(4, round(0.012 * max(region.shape)))) if region.any() else ~region
    if not len(found.length):
        nothing = np.zeros(0)
        return _Edges(np.zeros((0, 2)), nothing, nothing, np.zeros((0, 2)), nothing.astype(bool))
    share = np.linspace(0.02, 0.98, 16)[None, :, None]
    along = found.ends[:, :1] * (1 - share) + found.ends[:, 1:] * share
    columns = np.clip(along[..., 0].astype(int), 0, region.shape[1] - 1)
    rows = np.clip(along[..., 1].astype(int), 0, region.shape[0] - 1)
    touching = near[rows, columns].mean(1) > 0.6
    touching |= _continues(found, touching)
    touching &= found.ends[:, :, 1].min(1) > camera.horizon + 0.01 * region.shape[0]
    used = found.only(touching)
    first = on_plane(camera, used.ends[:, 0], top)[:, :2]
    second = on_plane(camera, used.ends[:, 1], top)[:, :2]
    fine = np.isfinite(first).all(1) & np.isfinite(second).all(1)
    delta = (second - first)[fine]
    weight = used.length[fine] * np.minimum(used.contrast[fine], 25) / 25
    middle, angle = (first + second)[fine] / 2, np.arctan2(delta[:, 1], delta[:, 0])
    beside = _covered_beside(used.only(np.asarray(fine)), region)
    inward = _inward(camera, top, used.only(np.asarray(fine)), beside, middle, angle)
    return _Edges(middle, angle, weight, inward, np.asarray(beside.min(1) > SLAB.min_both_share))


def _covered_beside(used: Segments, region: BoolArray) -> FloatArray:
    """(N, 2) how much of the region lies on both sides of each edge, along its normal first."""
    share = np.linspace(0.1, 0.9, 12)[None, :, None]
    along = used.ends[:, :1] * (1 - share) + used.ends[:, 1:] * share
    off = max(5.0, SLAB.beside_ratio * max(region.shape)) * _normals(used)[:, None]

    def covered(points: FloatArray) -> FloatArray:
        x = np.clip(points[..., 0].astype(int), 0, region.shape[1] - 1)
        y = np.clip(points[..., 1].astype(int), 0, region.shape[0] - 1)
        return region[y, x].mean(1)

    return np.stack([covered(along + off), covered(along - off)], 1)


def _normals(used: Segments) -> FloatArray:
    """(N, 2) unit vectors across edges, in the picture."""
    return np.stack([-np.sin(used.angle), np.cos(used.angle)], 1)


def _inward(
    camera: Camera,
    top: float,
    used: Segments,
    beside: FloatArray,
    middle: FloatArray,
    angle: FloatArray,
) -> FloatArray:
    """Across each edge, the side on which the region lies, as a direction on the plane."""
    lead = beside[:, 0] - beside[:, 1]
    step = max(5.0, SLAB.beside_ratio * max(camera.size))
    target = used.ends.mean(1) + np.sign(lead)[:, None] * step * _normals(used)
    toward = on_plane(camera, target, top)[:, :2] - middle
    across = np.stack([-np.sin(angle), np.cos(angle)], 1)
    sign = np.sign((np.nan_to_num(toward) * across).sum(1))
    return np.where(np.abs(lead)[:, None] > 0.25, sign[:, None] * across, 0.0)


def _nearer_counts_more(edges: _Edges, seeds: FloatArray) -> _Edges:
    """Edges weighted by nearness to what stands there, for these are where things fall off."""
    if not len(edges.weight):
        return edges
    middle = seeds.mean(0)
    along = np.stack([np.cos(edges.angle), np.sin(edges.angle)], 1)
    off = middle - edges.middle
    across = np.abs(off[:, 0] * along[:, 1] - off[:, 1] * along[:, 0])
    reach = max(float(np.median(across)), 1e-6)
    weight = edges.weight / (0.5 + across / reach)
    return replace(edges, weight=weight)


def _continues(found: Segments, chosen: BoolArray) -> BoolArray:
    """Segments that lie on the line of a chosen one: an edge goes on behind what stands there."""
    out = np.zeros(len(found.length), bool)
    for k in np.flatnonzero(chosen):
        direction = np.array([math.cos(found.angle[k]), math.sin(found.angle[k])])
        off = found.ends - found.ends[k].mean(0)
        across = np.abs(off[..., 0] * direction[1] - off[..., 1] * direction[0]).max(1)
        out |= (across < 5) & (np.abs(found.angle - found.angle[k]) < math.radians(4))
    return out


def _main_direction(edges: _Edges) -> float:
    """The turn of a rectangle that most edges run along, −45° … 45°."""
    if not len(edges.weight):
        return 0.0
    grid = np.radians(np.arange(-45, 45, 0.5))
    off = (edges.angle[None] - grid[:, None] + math.pi / 4) % (math.pi / 2) - math.pi / 4
    votes = (np.exp(-0.5 * (off / math.radians(4)) ** 2) * edges.weight).sum(1)
    # Where nothing speaks against it, a table stands square to the picture.
    votes = votes + 0.04 * edges.weight.sum() * np.exp(-0.5 * (grid / math.radians(6)) ** 2)
    best = grid[int(votes.argmax())]
    off = (edges.angle - best + math.pi / 4) % (math.pi / 2) - math.pi / 4
    near = np.abs(off) < math.radians(5)
    if not near.any():
        return float(best)
    return float(best + np.average(off[near], weights=edges.weight[near]))


def _limits(
    above: float,
    yaw: float,
    standing: tuple[FloatArray, FloatArray],
    edges: _Edges,
    area: FloatArray,
) -> tuple[FloatArray, BoolArray]:
    """(4,) how far the top reaches along +x', +y', −x', −y' of the turned frame; and (4,)

    whether an edge says so.

    above: height of the camera over the top, m. standing: middles of the bases of what stands
    on it (N, 2) and half their widths (N,). An edge may run under a thing, never past the middle
    of its base, for then it would not stay.
    """
    seeds, halves = standing
    half = float(halves.max(initial=0.0))
    axes = [(math.cos(yaw), math.sin(yaw)), (-math.sin(yaw), math.cos(yaw))]
    directions = np.array(
        [axes[0], axes[1], (-axes[0][0], -axes[0][1]), (-axes[1][0], -axes[1][1])]
    )
    limits, bounded = np.zeros(4), np.zeros(4, bool)
    over = max(above, 0.02)
    for k, direction in enumerate(directions):
        inner = float((seeds @ direction).max())
        runs = edges.angle - math.atan2(direction[1], direction[0])
        across = np.abs(np.cos(runs)) < math.sin(math.radians(18))
        offset = edges.middle[across] @ direction
        weight = edges.weight[across]
        facing = edges.inward[across] @ direction
        outward = (facing < -0.3) & (offset > inner - 0.7 * half)
        unclear = (facing == 0) & (offset > inner + 0.5 * half)
        drawn = unclear & edges.within[across]
        # One line on it may be where its front begins; several are planks, or a pattern.
        outward |= unclear & ~drawn if _distinct(offset[drawn]) >= SLAB.min_pattern else unclear
        limits[k] = _nearest_strong(offset[outward], weight[outward], inner + 0.15 * half)
        bounded[k] = math.isfinite(limits[k])
        if not bounded[k]:
            reach = float(np.percentile(area @ direction, 99)) if len(area) else inner
            limits[k] = max(reach, inner + 0.05 * over) + 0.25 * over
    return limits, bounded


def _distinct(offset: FloatArray) -> int:
    """How many lines lie clearly apart."""
    apart = np.diff(np.sort(offset)) > 0.04 * max(float(np.ptp(offset)), 0.1) if len(offset) else []
    return len(offset[:1]) + int(np.count_nonzero(apart))


def _past_unseen_ends(
    camera: Camera,
    top: float,
    region: BoolArray,
    yaw: float,
    limits: FloatArray,
    bounded: BoolArray,
    beyond: float,
    boxed: bool,
) -> FloatArray:
    """Limits pushed out where no edge ends the top, from the picture's rim where it gets there.

    bounded: (4,) sides where an edge is seen. beyond: how far at most, m. boxed: not at all but
    from the rim.
    """
    rim = np.zeros_like(region)
    rim[:, :3] = rim[:, -3:] = True
    rim[-3:] = True
    places = _region_on_plane(camera, top, region & rim)
    out = limits.copy()
    cos, sin = math.cos(yaw), math.sin(yaw)
    directions = np.array([(cos, sin), (-sin, cos), (-cos, -sin), (sin, -cos)])
    for k in np.flatnonzero(~bounded):
        length = limits[k] + limits[(k + 2) % 4]
        farthest = float((places @ directions[k]).max(initial=-math.inf))
        leaves = farthest > limits[k] - 0.3 * length
        seen = max(limits[k], farthest) if leaves else limits[k]
        if leaves or not boxed:
            seen += min(SLAB.unseen_end_ratio * length, beyond)
        out[k] = seen
    return out


def _nearest_strong(offset: FloatArray, weight: FloatArray, inner: float) -> float:
    """Offset of the first edge outward that is not much weaker than the strongest; inf: none."""
    if not len(offset) or weight.max() < 10:
        return math.inf
    spread = 0.02 * max(float(np.ptp(offset)), 0.2)
    pooled = np.array([(weight * (np.abs(offset - o) < spread)).sum() for o in offset])
    strong = np.flatnonzero(pooled > 0.35 * pooled.max())
    first = strong[int(offset[strong].argmin())]
    near = np.abs(offset - offset[first]) < spread
    return max(float(np.average(offset[near], weights=weight[near])), inner)


def _longest_side(corners: FloatArray) -> float:
    sides = np.roll(corners, -1, axis=0) - corners
    longest = sides[int(np.hypot(sides[:, 0], sides[:, 1]).argmax())]
    angle = math.atan2(longest[1], longest[0])
    return (angle + math.pi / 4) % (math.pi / 2) - math.pi / 4


def _around(corners: FloatArray, yaw: float, top: float, thickness: float) -> Slab:
    ahead = np.array([math.cos(yaw), math.sin(yaw)])
    side = np.array([-math.sin(yaw), math.cos(yaw)])
    limits = [(corners @ ahead).max(), (corners @ side).max()]
    limits += [-(corners @ ahead).min(), -(corners @ side).min()]
    return _slab(yaw, np.array(limits), top, thickness)


def _slab(yaw: float, limits: FloatArray, top: float, thickness: float) -> Slab:
    """limits: reach along +x', +y', −x', −y'."""
    size_x = max(float(limits[0] + limits[2]), 0.02)
    size_y = max(float(limits[1] + limits[3]), 0.02)
    along, across = float(limits[0] - limits[2]) / 2, float(limits[1] - limits[3]) / 2
    cos, sin = math.cos(yaw), math.sin(yaw)
    x, y = along * cos - across * sin, along * sin + across * cos
    return Slab(position=(x, y, top - thickness / 2), size=(size_x, size_y, thickness), yaw=yaw)
