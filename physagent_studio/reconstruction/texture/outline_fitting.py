"""What is drawn is drawn to its mask: the visual mesh led to the outline that the photo shows.

Bodies collide as their shapes are; their looks are moved in the picture, every vertex at its own
depth, by a smooth map: first as a whole, then, bounded, along the outline. What is hidden by other
things, cut off by the frame or too far away says nothing. What touches the support stays on it.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import cv2
import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import RBFInterpolator

from physagent_studio.arrays import FloatArray
from physagent_studio.program.rotations import matrix_of
from physagent_studio.program.scene.camera import Camera
from physagent_studio.program.scene.state import SceneObject
from physagent_studio.reconstruction.photo.regions import BoolArray, bounds, grow, iou
from physagent_studio.reconstruction.shapes.silhouettes import in_world, silhouette
from physagent_studio.reconstruction.switches import at_work
from physagent_studio.records.scene import Mesh


@dataclass(frozen=True, slots=True)
class FittingSettings:
    """How far what is drawn is led to its mask."""

    reach_ratio: float = 0.12  # 0.03..0.3: over √area: how far outlines may be led
    # IoU, 0.3..0.9: what covers its mask less stands elsewhere, or is another thing
    min_iou: float = 0.6
    enough_iou: float = 0.98  # IoU, 0.9..1: what covers its mask so well is left as it is
    min_gain: float = 0.002  # IoU, 0..0.02: for which a map with more freedom is taken
    points_count: int = 160  # 40..600: of an outline that are compared
    # count, 1..20: maps found one upon the other, each from where the last has led
    max_rounds: int = 5
    # weight, 0.1..10: against bending, of kinds that `STIFF` does not name
    stiffness_weight: float = 1.0
    slide_share: float = 0.08  # 0..0.3: of the body's extent, that a foot may slide on its support
    # 0..0.1: of the seen area, that may turn over; more tears the look
    max_flipped_share: float = 0.01
    # 0.2..3: over its lowest point up to which a body touches its support
    touching_px: float = 0.75


FITTING = FittingSettings()

STIFF = {"revolved": 20.0, "cylinder": 10.0, "frustum": 10.0, "capsule": 10.0}
FLAT = ("box",)
"""Kinds whose straight edges stay straight."""
WHOLE = ("sphere", "ellipsoid")
"""What rolls stays round: it is moved and scaled as a whole alone."""
AS_DRAWN = ("inflated",)
"""Kinds that collide as their mesh."""
LEFT = ("meshed",)
"""Bodies whose looks are given."""


@dataclass(frozen=True, eq=False, slots=True)
class Sight:
    """The mask (H, W) that a look is led to. free: (H, W) where the thing would be seen.

    up: (3,) unit normal of what it stands on, world; None for what hangs in the air. behind:
    (H, W) what is known of it behind other things; None for nothing.
    """

    camera: Camera
    mask: BoolArray
    free: BoolArray
    up: FloatArray | None
    behind: BoolArray | None = None

    def drawn(self, world: FloatArray, faces: NDArray[np.int32]) -> BoolArray:
        """(H, W) the silhouette of a mesh in world places where nothing hides it."""
        return silhouette(self.camera, world, faces) & self.free


def covering(sight: Sight, item: SceneObject, mesh: Mesh) -> Mesh:
    """The mesh (body frame) led to the mask, or as it is where that covers it no better.

    sight: the mask, and what says nothing about it.
    """
    if not at_work("outline fitting"):
        return mesh
    if item.shape is None or item.shape.kind in LEFT or not (sight.mask & sight.free).any():
        return mesh
    first = in_world(item, mesh)
    depth = sight.camera.project(first)[1]
    mask = sight.mask & sight.free
    best, value = first, iou(sight.drawn(first, mesh.faces), mask)
    if not FITTING.min_iou <= value < FITTING.enough_iou or depth.min() <= 0:
        return mesh
    stiff = STIFF.get(item.shape.kind, FITTING.stiffness_weight)
    for stiffness in (math.inf, stiff) if at_work("outline bending") else (math.inf,):
        world = best
        for _ in range(FITTING.max_rounds):
            moved = _led(sight, world, first, mesh.faces, item.shape.kind, stiffness)
            if moved is None:
                break
            world = moved
            found = iou(sight.drawn(world, mesh.faces), mask)
            if found > value + FITTING.min_gain and _whole(sight.camera, first, world, mesh.faces):
                best, value = world, found
        if item.shape.kind in WHOLE:
            break
    if best is first:
        return mesh
    body = (best - np.asarray(item.position)) @ matrix_of(item.rotation)
    return replace(mesh, vertices=body)


def _led(
    sight: Sight,
    world: FloatArray,
    first: FloatArray,
    faces: NDArray[np.int32],
    kind: str,
    stiffness: float,
) -> FloatArray | None:
    """World vertices (V, 3) one map nearer to the mask; None where too little is seen.

    first: where they were before any map. stiffness: inf for a map of the whole alone.
    """
    pairs = _pairs(sight, sight.drawn(world, faces))
    if pairs is None:
        return None
    at, to = pairs
    pixels, depth = sight.camera.project(world)
    if kind in WHOLE:
        led, scale = _similar(at, to, pixels)
    elif math.isinf(stiffness):
        led, scale = _affine(at, to, pixels), 1.0
    elif kind in FLAT:
        led, scale = _projected(at, to, pixels), 1.0
    else:
        led, scale = _bent(at, to, pixels, stiffness), 1.0
    start = sight.camera.project(first)[0]
    most = FITTING.reach_ratio * math.sqrt(np.count_nonzero(sight.mask))
    off = led - start
    far = np.linalg.norm(off, axis=1, keepdims=True)
    led = start + off * np.minimum(1.0, most / np.maximum(far, 1e-9))
    middle = float(depth.mean())
    depth = middle + (depth - middle) * scale
    moved = np.asarray(sight.camera.position) + sight.camera.rays(led) * depth[:, None]
    return _standing(sight, first, moved, kind in AS_DRAWN)


def _standing(sight: Sight, first: FloatArray, moved: FloatArray, as_drawn: bool) -> FloatArray:
    """The same with what touched the support still on it, and nothing within it.

    as_drawn: the body collides as it is drawn, so that its foot stays where it carries it.
    """
    if sight.up is None:
        return moved
    height = first @ sight.up
    low = float(height.min())
    pixel = float(sight.camera.project(first)[1].mean()) / sight.camera.focal
    foot = height <= low + FITTING.touching_px * pixel
    rise = moved @ sight.up - height
    out = moved.copy()
    # On the support a vertex goes where its pixel lies on it, but not far.
    eye = np.asarray(sight.camera.position)
    ray = moved[foot] - eye
    down = ray @ sight.up
    share = np.divide(-rise[foot], down, out=np.zeros_like(down), where=np.abs(down) > 1e-9)
    slide = moved[foot] + share[:, None] * ray - first[foot]
    # From where it stood at first: seen nearly edge-on, a pixel is a long way, map by map.
    most = FITTING.slide_share * float(np.ptp(first, axis=0).max())
    slide *= np.minimum(1, most / np.maximum(np.linalg.norm(slide, axis=1), 1e-9))[:, None]
    out[foot] = first[foot] + slide
    if as_drawn:
        out[foot] = first[foot]
    out[foot] -= np.outer(out[foot] @ sight.up - height[foot], sight.up)
    under = np.minimum(out @ sight.up - low, 0.0)
    return np.asarray(out - under[:, None] * sight.up)


def _pairs(sight: Sight, drawn: BoolArray) -> tuple[FloatArray, FloatArray] | None:
    """Points (N, 2) of the drawn outline and where the mask's outline is for them, pixels."""
    mask = sight.mask & sight.free
    if not drawn.any():
        return None
    told = ~grow(~sight.free, 2)
    told[:2], told[-2:], told[:, :2], told[:, -2:] = False, False, False, False
    own, other = _outline(drawn), _outline(mask)
    away = np.linalg.norm(own[:, None] - other[None], axis=2)
    limit = FITTING.reach_ratio * math.sqrt(np.count_nonzero(mask))
    there, back = away.argmin(1), away.argmin(0)
    at = np.vstack([own, own[back]])
    to = np.vstack([other[there], other])
    near = np.linalg.norm(to - at, axis=1) < limit
    near &= looked_up(told, at) & looked_up(told, to)
    if np.count_nonzero(near) < 24:
        return None
    return at[near], to[near]


def _outline(mask: BoolArray) -> FloatArray:
    """Points (N, 2), evenly along the outlines of a region and of its holes and not too many, pixel
    edges."""
    x0, y0, x1, y1 = bounds(mask)
    own = np.pad(mask[y0:y1, x0:x1], 1).astype(np.uint8)
    own = cv2.resize(own, None, fx=2, fy=2, interpolation=cv2.INTER_NEAREST)
    found, _ = cv2.findContours(own, cv2.RETR_LIST, cv2.CHAIN_APPROX_NONE)
    points = np.vstack([part[:, 0] for part in found]).astype(float)
    x0, y0, _, _ = bounds(mask)
    points = (points + 0.5) / 2 - 1 + np.array([x0, y0])
    every = np.linspace(
        0, len(points), min(FITTING.points_count, len(points)), endpoint=False
    ).astype(int)
    return points[every]


def looked_up(area: BoolArray, points: FloatArray) -> BoolArray:
    """(N,) what a region (H, W) says at pixels (N, 2); beyond the picture, what its border says."""
    x = np.clip(points[:, 0].astype(int), 0, area.shape[1] - 1)
    y = np.clip(points[:, 1].astype(int), 0, area.shape[0] - 1)
    return np.asarray(area[y, x])


def _affine(at: FloatArray, to: FloatArray, pixels: FloatArray) -> FloatArray:
    """Pixels (V, 2) under the affine map that most pairs agree on."""
    middle = at.mean(0)
    size = float(np.abs(at - middle).mean())
    terms = np.column_stack([(at - middle) / size, np.ones(len(at))])
    pull = 0.02 * len(at) * np.diag([1.0, 1.0, 0.0])
    fit, weight = np.zeros((3, 2)), np.ones(len(at))
    for _ in range(8):
        left = (terms.T * weight) @ terms + pull
        fit = np.linalg.solve(left, (terms.T * weight) @ (to - at))
        weight = _trust(to - at - terms @ fit)
    return pixels + np.column_stack([(pixels - middle) / size, np.ones(len(pixels))]) @ fit


def _projected(at: FloatArray, to: FloatArray, pixels: FloatArray) -> FloatArray:
    """Pixels (V, 2) under the map of lines to lines that most pairs agree on."""
    middle = at.mean(0)
    size = float(np.abs(at - middle).mean())
    own, goal = (at - middle) / size, (to - middle) / size
    one, none = np.ones(len(own)), np.zeros(len(own))
    x, y = own.T
    terms = np.stack(
        [
            np.stack([x, y, one, none, none, none, -goal[:, 0] * x, -goal[:, 0] * y], 1),
            np.stack([none, none, none, x, y, one, -goal[:, 1] * x, -goal[:, 1] * y], 1),
        ],
        1,
    )
    same = np.array([1.0, 0, 0, 0, 1, 0, 0, 0])
    pull = 0.02 * len(own) * np.diag([1.0, 1, 0, 1, 1, 0, 1, 1])
    fit, weight = same, np.ones(len(own))
    for _ in range(8):
        left = np.einsum("n,nki,nkj->ij", weight, terms, terms) + pull
        rest = goal - terms @ same
        fit = same + np.linalg.solve(left, np.einsum("n,nki,nk->i", weight, terms, rest))
        weight = _trust((goal - terms @ fit) * size)
    u, v = ((pixels - middle) / size).T
    below = np.maximum(1 + fit[6] * u + fit[7] * v, 0.2)
    led = np.stack([fit[0] * u + fit[1] * v + fit[2], fit[3] * u + fit[4] * v + fit[5]], 1)
    return middle + size * led / below[:, None]


def _similar(at: FloatArray, to: FloatArray, pixels: FloatArray) -> tuple[FloatArray, float]:
    """Pixels (V, 2) moved and scaled as most pairs agree on, and the scale."""
    middle = at.mean(0)
    weight, scale, move = np.ones(len(at)), 0.0, np.zeros(2)
    own, off = at - middle, to - at
    for _ in range(8):
        move = (weight[:, None] * (off - scale * own)).sum(0) / weight.sum()
        scale = float(
            (weight[:, None] * own * (off - move)).sum() / (weight[:, None] * own**2).sum()
        )
        weight = _trust(off - move - scale * own)
    return pixels + move + scale * (pixels - middle), 1 + scale


def _trust(rest: FloatArray) -> FloatArray:
    """(N,) how much pairs count that are so far (N, 2) from where the rest leads them."""
    away = np.linalg.norm(rest, axis=1)
    return 1 / (1 + (away / max(1.5 * float(np.median(away)), 0.7)) ** 2)


def _bent(at: FloatArray, to: FloatArray, pixels: FloatArray, stiffness: float) -> FloatArray:
    """Pixels (V, 2) under a thin plate that passes near the pairs."""
    spots, which = np.unique(np.round(at), axis=0, return_inverse=True)
    count = np.bincount(which.ravel())
    off = np.column_stack([np.bincount(which.ravel(), (to - at)[:, k]) / count for k in (0, 1)])
    size = float(np.ptp(spots, axis=0).max())
    plate = RBFInterpolator(
        spots / size, off, kernel="thin_plate_spline", smoothing=stiffness * 0.02, degree=1
    )
    return pixels + plate(pixels / size)


def _whole(camera: Camera, first: FloatArray, world: FloatArray, faces: NDArray[np.int32]) -> bool:
    """Whether hardly any face has turned over in the picture."""
    areas = []
    for places in (first, world):
        a, b, c = (camera.project(places)[0][faces[:, k]] for k in range(3))
        (ux, uy), (vx, vy) = (b - a).T, (c - a).T
        areas.append(ux * vy - uy * vx)
    turned = (areas[0] * areas[1] < 0) & (np.abs(areas[0]) > 0.05)
    return bool(
        np.abs(areas[0])[turned].sum() <= FITTING.max_flipped_share * np.abs(areas[0]).sum()
    )
