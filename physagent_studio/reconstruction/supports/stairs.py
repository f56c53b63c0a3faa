"""Stairs: a ramp with steps, how many, and what stands on one of them."""

import math

import numpy as np

from physagent_studio.knowledge import RISER, is_stairs
from physagent_studio.language.hints import told_steps
from physagent_studio.program.scene.camera import Camera
from physagent_studio.program.scene.stairs import treads_of
from physagent_studio.program.scene.state import Ramp, SceneObject, Support
from physagent_studio.reconstruction.camera.rays import RAY, on_plane
from physagent_studio.reconstruction.shapes.primitives import Base
from physagent_studio.reconstruction.shapes.silhouettes import in_world
from physagent_studio.reconstruction.supports.stances import Stance
from physagent_studio.records.scene import Mesh


def with_steps(support: Support, ramp: Ramp) -> Ramp:
    """The ramp as stairs, where its name says so: a step for each edge that was clicked.

    With the uppermost edge alone their number follows from the name ("three_steps"), or from the
    usual height of a step.
    """
    if not is_stairs(support.name) or ramp.steps:
        return ramp
    edges = len(support.grounding.marked("top"))
    count = edges if edges > 1 else told_steps(support.name) or round(ramp.rise / RISER)
    max_guessed_steps = 40  # count, 10..100: from a height: more are a mistake of the height
    return ramp.model_copy(update={"steps": min(max(count, 2), max_guessed_steps)})


def base_on(stance: Stance, camera: Camera, stairs: Ramp) -> Base:
    """The tread on which the foot's ray ends: the nearest of those that it meets."""
    treads = treads_of(stairs)
    best: tuple[float, Base] | None = None
    for tread in treads:
        height = stairs.toe[2] + tread.top
        spot = on_plane(camera, [stance.foot], height)[0]
        if not np.isfinite(spot).all():
            continue
        ahead, across = _along(stairs, float(spot[0]), float(spot[1]))
        off = max(tread.start - ahead, ahead - tread.end, 0.0)
        off += max(abs(across) - stairs.width / 2, 0.0)
        away = float(np.linalg.norm(spot - np.asarray(camera.position)))
        # On no tread at all, the one that it misses least.
        rank = away if off <= 0 else 1e3 + off
        if best is None or rank < best[0]:
            best = (rank, Base(float(spot[0]), float(spot[1]), height))
    if best is not None:
        return best[1]
    x, y, z = stairs.toe
    return Base(x, y, z, 0.5)


def standing(item: SceneObject, mesh: Mesh, stairs: Ramp) -> tuple[float, float, float]:
    """The position of an object on the tread below its middle, clear of the riser behind it."""
    assert item.position is not None
    x, y, z = item.position
    ahead, _ = _along(stairs, x, y)
    treads = treads_of(stairs)
    tread = next((one for one in reversed(treads) if one.start <= ahead), treads[0])
    world = in_world(item, mesh)
    z += stairs.toe[2] + tread.top - float(world[:, 2].min()) + RAY.clearance_m
    uphill = np.array([math.cos(stairs.yaw), math.sin(stairs.yaw)])
    reach = float(((world[:, :2] - np.asarray(stairs.toe[:2])) @ uphill).max())
    if tread is not treads_of(stairs)[-1] and reach > tread.end - RAY.clearance_m:
        back = reach - tread.end + RAY.clearance_m
        x, y = x - back * float(uphill[0]), y - back * float(uphill[1])
    return x, y, z


def _along(stairs: Ramp, x: float, y: float) -> tuple[float, float]:
    """How far uphill of the toe, and how far to the side, a place is, m."""
    cos, sin = math.cos(stairs.yaw), math.sin(stairs.yaw)
    dx, dy = x - stairs.toe[0], y - stairs.toe[1]
    return dx * cos + dy * sin, dy * cos - dx * sin
