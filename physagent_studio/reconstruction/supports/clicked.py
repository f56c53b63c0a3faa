"""Supports from marks: a person clicked a ramp's ends, a table's corners or the foot of a wall."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from types import MappingProxyType

import cv2
import numpy as np

from physagent_studio.arrays import BoolArray, FloatArray
from physagent_studio.knowledge import (
    RISER,
    Usual,
    support_height,
    support_kind,
)
from physagent_studio.program.base import Pixel
from physagent_studio.program.scene.camera import Camera
from physagent_studio.program.scene.state import Ramp, SceneState, Slab, Support, Wall
from physagent_studio.reconstruction.camera.estimate import usual_focal
from physagent_studio.reconstruction.camera.rays import on_plane, on_upright_through
from physagent_studio.reconstruction.camera.scale import FLOOR, Heights, Measured
from physagent_studio.reconstruction.supports.ramps import Profile


@dataclass(frozen=True, slots=True)
class ClickedSettings:
    """How marks of a support are read."""

    border_px: float = 4.0  # 1..10: a click so near shows where an edge leaves the picture
    max_mean_cosine: float = 0.1  # cosine, 0.02..0.3: of corners that pass for right angles
    # 0.2..1.2: models of stairs are about as common in pictures as stairs
    stair_spread_log: float = 0.7


CLICKED = ClickedSettings()

UP = np.array([0.0, 0.0, 1.0])


def profile_of(support: Support) -> Profile | None:
    """The outline of a ramp whose ends are marked; None for others."""
    toe, top = support.grounding.marked("toe"), support.grounding.marked("top")
    if not toe or not top:
        return None
    end = support.grounding.marked("end")
    # Of stairs the edge of every step may be marked, the uppermost last.
    return Profile(toe[0], top[-1], end[0] if end else top[-1])


def region_of(support: Support, size: tuple[int, int]) -> BoolArray | None:
    """The pixels of a level top whose corners are marked; size: (height, width)."""
    corners = support.grounding.marked("top")
    if support_kind(support.name) != "slab" or len(corners) < 3:
        return None
    mask = np.zeros(size, np.uint8)
    cv2.fillPoly(mask, [np.round(np.array(corners)).astype(np.int32)], 1)
    return mask.astype(bool)


def focal_of(state: SceneState, size: tuple[int, int], horizon: float) -> float | None:
    """The focal length (pixels) at which the marked corners of level tops are right angles.

    size: (width, height) of the picture. horizon: row of a horizon that a person gave. None
    without two marked edges that meet, or where no usual lens makes them square.
    """
    if state.horizon is None:
        return None
    tops = [
        s.grounding.marked("top")
        for s in state.supports
        if support_kind(s.name) == "slab" and len(s.grounding.marked("top")) >= 4
    ]
    usual = usual_focal(size)
    best: tuple[float, float] | None = None
    for focal in usual * np.geomspace(0.35, 2.1, 60):
        roll = math.radians(state.roll)
        camera = Camera.from_horizon(size, horizon, 1.0, focal=float(focal), roll=roll)
        slants = [slant for top in tops for slant in _slants(camera, top)]
        if slants and (best is None or float(np.mean(slants)) < best[0]):
            best = (float(np.mean(slants)), float(focal))
    return best[1] if best is not None and best[0] < CLICKED.max_mean_cosine else None


def _slants(camera: Camera, corners: Sequence[Pixel]) -> list[float]:
    """How far each corner that is in the picture is from a right angle: |cos|, 0 … 1."""
    places = on_plane(camera, corners, 0.0)[:, :2]
    if not np.isfinite(places).all():
        return []
    found = []
    for k, corner in enumerate(corners):
        if not _cut_sides(corner, camera.size):
            one, other = places[k - 1] - places[k], places[(k + 1) % len(corners)] - places[k]
            length = float(np.linalg.norm(one) * np.linalg.norm(other))
            found.append(abs(float(one @ other)) / max(length, 1e-12))
    return found


def rises_of(state: SceneState, unit: Camera) -> dict[str, float]:
    """Height of each level top over the ground, as a share of the camera's height above it.

    From the mark on the ground below the first corner. unit: the camera, at any height.
    """
    rises: dict[str, float] = {}
    for support in state.supports:
        corners, feet = support.grounding.marked("top"), support.grounding.marked("foot")
        if support.shape is not None or support_kind(support.name) != "slab":
            continue
        if not corners or not feet:
            continue
        ground = on_plane(unit, feet[:1], 0.0)[0]
        if not np.isfinite(ground).all():
            continue
        toward = np.asarray(unit.position) - ground
        normal = toward * (1, 1, 0) / max(math.hypot(toward[0], toward[1]), 1e-9)
        height = on_upright_through(unit, corners[:1], ground, normal)[0, 2]
        share = float(height) / unit.position[2]
        if 0.01 < share < 0.98:
            rises[support.name] = share
    return rises


def on_one_floor(
    measured: Sequence[Measured],
    rises: Mapping[str, float],
    steps: Mapping[str, int] = MappingProxyType({}),
) -> list[Measured]:
    """Sizes on tops of known rise told for the floor, and the usual heights of those tops.

    steps: which of them are the how many-th step of a flight; 0 for boards of a shelf, whose
    height tells nothing.
    """
    out = [
        replace(item, plane=FLOOR, units=item.units * (1 - rises[item.plane]))
        if item.plane in rises
        else item
        for item in measured
    ]
    for name, share in rises.items():
        usual = support_height(name)
        if steps.get(name) == 0:
            continue
        if name in steps:
            # Models of stairs are about as common in pictures as stairs.
            out.append(
                Measured(name, FLOOR, share, Usual(RISER * steps[name], CLICKED.stair_spread_log))
            )
        elif usual is not None:
            out.append(Measured(name, FLOOR, share, Usual(usual, 0.2)))
    return out


def with_rises(heights: Heights, rises: Mapping[str, float]) -> Heights:
    """The heights with the tops of known rise put in."""
    tops = {name: share * heights.camera for name, share in rises.items()}
    return replace(heights, tops={**heights.tops, **tops})


def shape_of(
    support: Support, camera: Camera, top: float, thickness: float
) -> Ramp | Slab | Wall | None:
    """The shape that the marks give; None where there are none, or they do not meet the ground.

    top: height of a level top, m. thickness: of its board, m.
    """
    marked = support.grounding.marked
    kind = support_kind(support.name)
    if kind == "ramp" and marked("toe") and marked("top"):
        return marked_ramp(camera, marked("toe"), marked("foot"), marked("top")[-1], marked("end"))
    if kind == "slab" and len(marked("top")) >= 3:
        return _slab(camera, marked("top"), top, thickness)
    if kind == "wall" and len(marked("foot")) == 2:
        return _wall(camera, marked("foot"))
    return None


def marked_ramp(
    camera: Camera,
    toes: Sequence[Pixel],
    feet: Sequence[Pixel],
    top: Pixel,
    ends: Sequence[Pixel] = (),
) -> Ramp | None:
    """A ramp by its toe, the foot below its top, its top, and the end of the flat part behind.

    The slope in the upright plane through toe and foot, else in one that faces the camera."""
    ground = on_plane(camera, [*toes, *feet], 0.0)
    if not np.isfinite(ground).all():
        return None
    toe = ground[0]
    ahead = np.array([1.0, 0.0, 0.0])
    if feet:
        ahead = (ground[-1] - toe) / max(float(np.linalg.norm(ground[-1] - toe)), 1e-9)
    side = np.cross(UP, ahead)
    spots = on_upright_through(camera, [top, *ends], toe, side) - toe
    if not np.isfinite(spots).all():
        return None
    ahead = ahead * math.copysign(1.0, float(spots[0] @ ahead))
    run, rise = float(spots[0] @ ahead), float(spots[0, 2])
    if run < 1e-3 or rise < 1e-3:
        return None
    plateau = max(float(spots[1] @ ahead) - run, 0.0) if ends else 0.0
    across = float((ground[1] - toe) @ side) if len(toes) > 1 else 0.0
    if abs(across) < 1e-3:
        # One side of the ramp was clicked, and one sees its near side.
        across = math.copysign(0.4 * (run + plateau), side[1] or 1.0)
    place = toe + side * across / 2
    return Ramp(
        toe=(float(place[0]), float(place[1]), 0.0),
        yaw=math.atan2(ahead[1], ahead[0]),
        run=run,
        rise=rise,
        width=abs(across),
        plateau=plateau,
    )


def _slab(camera: Camera, corners: Sequence[Pixel], top: float, thickness: float) -> Slab | None:
    """The rectangle along the longest clicked edge that holds all corners."""
    places = on_plane(camera, corners, top)[:, :2]
    if not np.isfinite(places).all():
        return None
    yaw = _main_turn(places, corners, camera.size)
    axes = np.array([[math.cos(yaw), math.sin(yaw)], [-math.sin(yaw), math.cos(yaw)]])
    own = places @ axes.T
    low, high = own.min(0), own.max(0)
    x, y = (low + high) / 2 @ axes
    size = np.maximum(high - low, 0.02)
    return Slab(
        position=(float(x), float(y), top - thickness / 2),
        size=(float(size[0]), float(size[1]), thickness),
        yaw=yaw,
    )


def _main_turn(places: FloatArray, corners: Sequence[Pixel], size: tuple[int, int]) -> float:
    """Turn of the longest edge, −45° … 45°; a cut by the picture's border is no edge."""
    sides = np.roll(places, -1, axis=0) - places
    lengths = np.hypot(sides[:, 0], sides[:, 1])
    for k, (one, other) in enumerate(zip(corners, [*corners[1:], corners[0]], strict=True)):
        if _cut_sides(one, size) & _cut_sides(other, size):
            lengths[k] *= 1e-3
    longest = sides[int(lengths.argmax())]
    angle = math.atan2(longest[1], longest[0])
    return (angle + math.pi / 4) % (math.pi / 2) - math.pi / 4


def _cut_sides(click: Pixel, size: tuple[int, int]) -> set[str]:
    x, y = click
    near = {"left": x, "right": size[0] - 1 - x, "upper": y, "lower": size[1] - 1 - y}
    return {side for side, distance in near.items() if distance <= CLICKED.border_px}


def _wall(camera: Camera, feet: Sequence[Pixel]) -> Wall | None:
    """The wall on the ground line through two clicks, facing the camera."""
    ground = on_plane(camera, feet, 0.0)
    if not np.isfinite(ground).all() or np.allclose(ground[0], ground[1], atol=1e-6):
        return None
    along = ground[1] - ground[0]
    normal = np.array([-along[1], along[0]])
    if normal @ (np.array(camera.position[:2]) - ground[0, :2]) < 0:
        normal = -normal
    x, y = (float(value) for value in ground[0, :2])
    return Wall(point=(x, y, 0.0), yaw=math.atan2(normal[1], normal[0]))
