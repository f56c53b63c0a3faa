"""An object set down on what it stands on: a plane, a slope, a tread, rails, another object."""

import math
from collections.abc import Mapping

import numpy as np

from physagent_studio.program.base import Position
from physagent_studio.program.scene.aloft import AIR
from physagent_studio.program.scene.camera import Camera
from physagent_studio.program.scene.state import (
    Ramp,
    SceneObject,
    Slab,
    Sphere,
    Support,
    SupportShape,
)
from physagent_studio.reconstruction.camera.rays import RAY, on_upright_through
from physagent_studio.reconstruction.placement import rails
from physagent_studio.reconstruction.placement.bases import shape_of
from physagent_studio.reconstruction.placement.static_stability import moved_in, nudged
from physagent_studio.reconstruction.shapes.contact import vertical_gap
from physagent_studio.reconstruction.shapes.forms import Form, lowest
from physagent_studio.reconstruction.shapes.silhouettes import in_world
from physagent_studio.reconstruction.supports import stairs
from physagent_studio.reconstruction.supports.ramps import height_at
from physagent_studio.reconstruction.survey.survey import Survey
from physagent_studio.records.scene import Mesh


def settled(
    item: SceneObject,
    form: Form,
    read: Survey,
    supports: tuple[Support, ...],
    done: Mapping[str, tuple[SceneObject, Mesh]],
    fresh: bool,
) -> SceneObject:
    """The object with its fields filled, lowered or raised onto what it stands on."""
    on = read.on[item.name]
    update: dict[str, object] = {"shape": form.shape, "support": on}
    if item.shape is None:
        update["rotation"] = form.rotation
    if on == AIR and item.support is None:
        update["aloft"] = "hangs"
    elif on != AIR and item.aloft is not None:
        update["aloft"] = None
    position = form.position
    if (item.position is None or fresh) and on != AIR:
        trial = item.model_copy(update={**update, "position": position})
        if on in done and not fresh:
            beside = _as_high(on, done, trial, form.mesh)
            trial = trial.model_copy(update={"position": nudged(trial, *done[on], beside)})
            position = trial.position or position
            # Of several it stands on, the highest is what it touches.
            tops = {on: done[on], **{other.name: (other, body) for other, body in beside}}
            if item.support is None:
                on = max(tops, key=lambda name: _top_of(*tops[name]))
            update["support"] = on
            trial = trial.model_copy(update={"support": on})
        under = shape_of(on, supports)
        if isinstance(under, Ramp) and under.steps:
            position = stairs.standing(trial, form.mesh, under)
        elif isinstance(under, Slab) and under.rail is not None:
            position = rails.standing(trial, form.mesh, under)
        else:
            ball = _ball_on_slope(trial, form, read.camera, under)
            position = ball or position
            if isinstance(under, Slab) and _is_stated(on, supports):
                position = moved_in(trial, form.mesh, under)
            trial = trial.model_copy(update={"position": position})
            z = _resting_z(trial, form.mesh, read, supports, done)
            position = (position[0], position[1], z)
    elif item.position is None and (below := read.under.get(item.name)) is not None:
        # In the air, but never inside what it hangs above.
        trial = item.model_copy(update={**update, "position": position, "support": below})
        rest = _resting_z(trial, form.mesh, read, supports, done)
        position = (position[0], position[1], max(position[2], rest))
    update["position"] = position
    return item.model_copy(update=update)


def _is_stated(name: str, supports: tuple[Support, ...]) -> bool:
    """Whether a case or a person gave the support: the picture does not move its edges."""
    return any(one.name == name and one.source in ("given", "person") for one in supports)


def _as_high(
    on: str, done: Mapping[str, tuple[SceneObject, Mesh]], item: SceneObject, mesh: Mesh
) -> list[tuple[SceneObject, Mesh]]:
    """What else a thing may stand on: others as high as what it stands on, that it reaches over."""
    top, own = _top_of(*done[on]), in_world(item, mesh)
    found = []
    # 0.01..0.3: of their height: two things so alike carry a third together
    same_height_share = 0.08
    for name, (other, body) in done.items():
        world = in_world(other, body)
        tall = float(np.ptp(world[:, 2]))
        shared = np.minimum(own.max(0), world.max(0)) - np.maximum(own.min(0), world.min(0))
        if (
            name != on
            and abs(_top_of(other, body) - top) < same_height_share * tall
            and (shared[:2] > 0).all()
        ):
            found.append((other, body))
    return found


def _top_of(item: SceneObject, mesh: Mesh) -> float:
    return float(in_world(item, mesh)[:, 2].max())


def _ball_on_slope(
    item: SceneObject, form: Form, camera: Camera, under: SupportShape | None
) -> Position | None:
    """Where a ball on a slope shows in the same place; None where the slope is seen edge-on.

    Its lowest point is not where it touches the slope: its middle lies a radius off the slope.
    """
    ball = form.shape
    if not isinstance(ball, Sphere) or not isinstance(under, Ramp) or item.position is None:
        return None
    ahead = np.array([math.cos(under.yaw), math.sin(under.yaw), 0.0])
    normal = np.array([*(-under.rise * ahead[:2]), under.run])
    normal /= np.linalg.norm(normal)
    pixel, _ = camera.project(np.array([item.position]))
    ray = camera.rays(pixel)[0]
    # sine, 0.02..0.5: of the view of a slope, to tell where on it a ball lies
    min_slant_sine = 0.15
    if -float(ray @ normal) < min_slant_sine * float(np.linalg.norm(ray)):
        return None
    middle = np.asarray(under.toe) + ball.radius * normal
    spot = on_upright_through(camera, pixel, middle, normal)[0]
    off = spot - np.asarray(under.toe)
    across = abs(float(off @ (-ahead[1], ahead[0], 0.0)))
    if not 0 <= float(off @ ahead) <= under.run or across > under.width / 2:
        return None
    x, y, z = (float(v) for v in spot)
    return x, y, z


def _resting_z(
    item: SceneObject,
    mesh: Mesh,
    read: Survey,
    supports: tuple[Support, ...],
    done: Mapping[str, tuple[SceneObject, Mesh]],
) -> float:
    """z of the centre of mass with the body touching what it stands on."""
    assert item.position is not None
    on = item.support
    if on is not None and on in done:
        world = in_world(item, mesh)
        gaps = [
            vertical_gap(world, mesh.faces, in_world(below, body), body.faces)
            for below, body in (done[on], *_as_high(on, done, item, mesh))
        ]
        return (
            item.position[2]
            - min((g for g in gaps if g is not None), default=0.0)
            + RAY.clearance_m
        )
    shape = shape_of(on, supports)
    if isinstance(shape, Ramp):
        return _on_ramp(item, mesh, shape) + RAY.clearance_m
    return read.tops.get(on or "", 0.0) - lowest(mesh, item.rotation) + RAY.clearance_m


def _on_ramp(item: SceneObject, mesh: Mesh, ramp: Ramp) -> float:
    """z at which the lowest-lying vertex touches the ramp's surface."""
    assert item.position is not None
    world = in_world(item, mesh)
    need = [
        height - float(point[2])
        for point in world[:: max(1, len(world) // 1500)]
        for height in [height_at(ramp, float(point[0]), float(point[1]))]
        if height is not None
    ]
    return item.position[2] + max(need, default=0.0)
