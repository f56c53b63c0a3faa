"""Where each object stands before it has a shape: foot, height, and how sure its depth is."""

import math
from collections.abc import Mapping
from dataclasses import dataclass

import cv2
import numpy as np

from physagent_studio.program.scene.aloft import AIR
from physagent_studio.program.scene.camera import Camera
from physagent_studio.program.scene.state import Box, Ramp, SceneObject, Support, SupportShape
from physagent_studio.reconstruction.camera.rays import (
    metres_per_pixel,
    on_plane,
    on_upright,
    on_upright_through,
)
from physagent_studio.reconstruction.placement.seats import base_on_seat, has_seat
from physagent_studio.reconstruction.shapes.forms import highest
from physagent_studio.reconstruction.shapes.primitives import Base, Lying
from physagent_studio.reconstruction.shapes.silhouettes import in_world
from physagent_studio.reconstruction.supports import stairs
from physagent_studio.reconstruction.supports.ramps import height_at
from physagent_studio.reconstruction.supports.stances import Stance
from physagent_studio.reconstruction.survey.survey import Survey
from physagent_studio.records.scene import Mesh

FLAT_TOPPED = ("box", "cylinder", "frustum")
"""Forms with a level top."""


@dataclass(frozen=True, slots=True)
class BaseSettings:
    """Where things stand on others."""

    # 0.1..0.5: of the ramp's width: a foot read beyond that would fall off
    max_aside_share: float = 0.3
    # 1..4: over a thing's width: on tops so wide it may stand anywhere
    min_wide_ratio: float = 1.6
    hold_weight: float = 0.6  # weight, 0..1: that what is on an object is right above its middle


BASE = BaseSettings()


def base_of(
    stance: Stance,
    read: Survey,
    supports: tuple[Support, ...],
    done: Mapping[str, tuple[SceneObject, Mesh]],
) -> Base:
    """The base of an object on what is under it; `done` are objects in place with meshes."""
    on = read.on[stance.name]
    if on == AIR:
        return _in_the_air(stance, read, supports, done)
    if on in done:
        below, mesh = done[on]
        assert below.position is not None
        assert below.shape is not None
        inside = _in_the_vessel(stance, read.camera, below, mesh)
        if inside is not None:
            return inside
        if has_seat(below):
            return base_on_seat(stance, read.camera, below, mesh)
        z = below.position[2] + highest(mesh, below.rotation)
        wide = _on_a_wide_top(stance, read.camera, below, mesh, z)
        if wide is not None:
            return wide
        x = float(on_upright(read.camera, [stance.foot], below.position[1])[0, 0])
        # Round things balance only right above each other; flat ones may be shifted.
        round_both = is_round(read, stance.name) and below.shape.kind != "box"
        hold = 1.0 if round_both else BASE.hold_weight
        return Base(x, below.position[1], z, hold, below=_lying(below))
    shape = shape_of(on, supports)
    if isinstance(shape, Ramp) and shape.steps:
        return stairs.base_on(stance, read.camera, shape)
    if isinstance(shape, Ramp):
        return _on_the_ramp(stance, read.camera, shape)
    top = read.tops.get(on, 0.0)
    spot = on_plane(read.camera, [stance.foot], top)[0]
    if not np.isfinite(spot).all():
        return _in_the_air(stance, read, supports, done)
    return Base(float(spot[0]), float(spot[1]), top)


def _on_a_wide_top(
    stance: Stance, camera: Camera, below: SceneObject, mesh: Mesh, top: float
) -> Base | None:
    """Where the foot is seen on a flat top that is decidedly wider than the thing (a plate)."""
    if below.shape is None or below.shape.kind not in FLAT_TOPPED:
        return None
    spot = on_plane(camera, [stance.foot], top)[0]
    if not np.isfinite(spot).all():
        return None
    world = in_world(below, mesh)
    rim = world[world[:, 2] > top - 0.03 * float(np.ptp(world[:, 2])), :2].astype(np.float32)
    width = stance.width * metres_per_pixel(camera, spot)
    narrow = float(min(cv2.minAreaRect(rim)[1]))
    inside = cv2.pointPolygonTest(cv2.convexHull(rim), (float(spot[0]), float(spot[1])), False)
    if narrow < BASE.min_wide_ratio * width or inside < 0:
        return None
    return Base(float(spot[0]), float(spot[1]), top)


def _in_the_vessel(stance: Stance, camera: Camera, below: SceneObject, mesh: Mesh) -> Base | None:
    """On the floor of an open vessel; None for what is wider than that, and for other things."""
    wall = getattr(below.shape, "wall", None)
    if wall is None or below.position is None:
        return None
    world = in_world(below, mesh)
    low, high = world.min(0), world.max(0)
    middle = (low + high) / 2
    room = float((high - low)[:2].min()) - 2 * wall
    rim, floor = float(high[2]), float(low[2]) + wall
    if stance.width * metres_per_pixel(camera, (middle[0], middle[1], rim)) > room:
        return None
    enters, lands = (on_plane(camera, [stance.foot], z)[0] for z in (rim, floor))
    if all(_is_within(spot, middle, room) for spot in (enters, lands)):
        return Base(float(lands[0]), float(lands[1]), floor)
    # Its foot is hidden by the near side.
    x = float(on_upright(camera, [stance.foot], float(middle[1]))[0, 0])
    return Base(x, float(middle[1]), floor, BASE.hold_weight)


def _is_within(spot: np.ndarray, middle: np.ndarray, room: float) -> bool:
    return bool(np.isfinite(spot).all()) and float(np.hypot(*(spot - middle)[:2])) < room / 2


def _lying(below: SceneObject) -> Lying | None:
    """How a box lies that something stands on; None for other shapes and tilted ones."""
    if not isinstance(below.shape, Box) or below.position is None:
        return None
    w, x, y, z = below.rotation
    if max(abs(x), abs(y)) > 1e-3:
        return None
    width, depth, _ = below.shape.size
    return Lying(below.position[0], below.position[1], width, depth, 2 * math.atan2(z, w))


def _on_the_ramp(stance: Stance, camera: Camera, ramp: Ramp) -> Base:
    """Where the foot's ray meets the slope or the level part behind it, kept away from the sides.

    What is seen a little beyond the sides or ends of a ramp stands near them. On a ramp that is
    seen from its side the depth is not told by the foot: there it is taken from the ramp.
    """
    ahead = np.array([math.cos(ramp.yaw), math.sin(ramp.yaw), 0.0])
    side = np.array([-ahead[1], ahead[0], 0.0])
    toe = np.asarray(ramp.toe, float)
    slope = np.array([-ramp.rise * ahead[0], -ramp.rise * ahead[1], ramp.run])
    spot = on_upright_through(camera, [stance.foot], toe, slope)[0]
    if ramp.plateau > 0 and (not np.isfinite(spot).all() or (spot - toe) @ ahead > ramp.run):
        spot = on_plane(camera, [stance.foot], ramp.toe[2] + ramp.rise)[0]
    across = float((spot - toe) @ side) if np.isfinite(spot).all() else math.inf
    if abs(across) > BASE.max_aside_share * ramp.width:
        # The plane along the ramp, as near to where the ray meets it as the ramp goes.
        across = math.copysign(
            BASE.max_aside_share * ramp.width, across if math.isfinite(across) else side[1]
        )
        spot = on_upright_through(camera, [stance.foot], toe + across * side, side)[0]
    if not np.isfinite(spot).all():
        spot = toe + ahead * ramp.run / 2
    along = float(np.clip((spot - toe) @ ahead, 0.0, ramp.run + ramp.plateau))
    x, y, _ = (float(v) for v in toe + along * ahead + across * side)
    return Base(x, y, height_at(ramp, x, y) or ramp.toe[2], 0.5)


def _in_the_air(
    stance: Stance,
    read: Survey,
    supports: tuple[Support, ...],
    done: Mapping[str, tuple[SceneObject, Mesh]],
) -> Base:
    """On the plumb line above what is beneath it, else as far as its usual size says."""
    beneath = read.under.get(stance.name)
    if beneath is not None and beneath in done:
        position = done[beneath][0].position
        assert position is not None
        y = position[1]
    elif isinstance(ramp := shape_of(beneath, supports), Ramp):
        y = ramp.toe[1]
    else:
        depth = read.usual[stance.name].metres * read.camera.focal / max(stance.extent, 1)
        ray = read.camera.rays(np.array([stance.foot]))[0]
        y = read.camera.position[1] + depth * float(ray[1])
        ground = float(on_plane(read.camera, [stance.foot], 0.0)[0, 1])
        # Where its foot is seen before the ground it is above it: no farther than that ground.
        y = min(y, ground) if math.isfinite(ground) else y
    spot = on_upright(read.camera, [stance.foot], y)[0]
    return Base(float(spot[0]), y, float(spot[2]), 1.0, free_z=True)


def shape_of(name: str | None, supports: tuple[Support, ...]) -> SupportShape | None:
    """The shape of the support of that name."""
    return next((support.shape for support in supports if support.name == name), None)


def is_round(read: Survey, name: str) -> bool:
    """Whether a name says round: such a thing ends where another is seen to stand on it."""
    return bool({"sphere", "ellipsoid"} & set(read.usual[name].shapes))


def is_in_round_stack(read: Survey, name: str) -> bool:
    """Whether a round thing carries another or is carried by one: it shows that it balances."""
    beside = [other for other, on in read.on.items() if on == name]
    if read.on[name] in read.on:
        beside.append(read.on[name])
    return is_round(read, name) and any(is_round(read, other) for other in beside)
