"""The checks of stage 1: what was measured in the reconstruction, and whether that is fine."""

import math
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from physagent_studio.program.scene.aloft import AIR
from physagent_studio.program.scene.camera import Camera
from physagent_studio.program.scene.state import (
    Inflated,
    Meshed,
    Ramp,
    SceneObject,
    SceneState,
    Slab,
    Support,
)
from physagent_studio.reconstruction import consistency
from physagent_studio.reconstruction.camera.estimate import Horizon
from physagent_studio.reconstruction.photo.colours import colour_of, pixels_like, said_of
from physagent_studio.reconstruction.photo.regions import BoolArray, border_share, iou
from physagent_studio.reconstruction.placement.seats import bearing
from physagent_studio.reconstruction.placement.static_stability import beyond
from physagent_studio.reconstruction.shapes.contact import vertical_gap
from physagent_studio.reconstruction.shapes.meshes import mesh_of
from physagent_studio.reconstruction.shapes.silhouettes import in_world, look
from physagent_studio.reconstruction.supports.ramps import height_at
from physagent_studio.records.case import Image
from physagent_studio.records.scene import Finding, Mesh


@dataclass(frozen=True, slots=True)
class CheckSettings:
    """What is fine of a reconstruction."""

    min_iou: float = 0.8  # IoU, 0.5..1: of a placed body's silhouette with its mask
    min_named_share: float = 0.12  # 0.02..0.5: of a thing's pixels that its colour word may call
    max_gap_m: float = 2e-3  # 1e-4..0.01: between a thing and what it stands on
    # 0.05..0.4: spread, of the picture's height; more is asked about
    max_horizon_share: float = 0.15


CHECK = CheckSettings()


def measure(
    state: SceneState,
    masks: Mapping[str, BoolArray],
    meshes: Mapping[str, Mesh],
    support_meshes: Mapping[str, Mesh],
    estimate: Horizon | None,
    image: Image | None = None,
) -> tuple[Finding, ...]:
    """All checks of a completed state; meshes in the body frame, those of supports in the world.

    estimate: the horizon that the picture gives by itself, where one is stated.
    """
    assert state.camera is not None
    out = [_camera(state.camera)]
    out += [_points(item, masks.get(item.name)) for item in state.objects if not is_added(item)]
    if image is not None:
        out += _called(state, image, masks)
    out += _silhouettes(state, state.camera, masks, meshes)
    placed = [item for item in state.objects if item.name in meshes]
    for check in (_contact, _over_edge):
        told = (check(item, state, meshes) for item in placed)
        out += [finding for finding in told if finding is not None]
    out += [_support(support) for support in state.supports]
    out += consistency.check(state, masks, meshes, support_meshes, estimate)
    return tuple(out)


def is_added(item: SceneObject) -> bool:
    """Whether a person set the thing down in the scene, so that the photo does not show it."""
    if item.source != "person" or item.shape is None or item.position is None:
        return False
    # What was inflated stood in the photo first.
    return item.shape.kind != "inflated" and not item.grounding.shows_something


def _camera(camera: Camera) -> Finding:
    sigma = camera.horizon_sigma or 0.0
    share = 0.0 if camera.confirmed else sigma / camera.size[1]
    how = "confirmed" if camera.confirmed else f"{camera.source}, ± {sigma:.0f} px"
    text, most = f"the horizon is {_row(camera)} ({how})", CHECK.max_horizon_share
    fine = share <= most
    return Finding("horizon", "camera", share, most, "picture heights", fine, "camera", text)


def _row(camera: Camera) -> str:
    """ "at row 120", "18 px above the picture", "at row 120 and tilted by 3.2°"."""
    over, under = -camera.horizon, camera.horizon - camera.size[1]
    tilt = abs(math.degrees(camera.roll))
    tilted = f" and tilted by {tilt:.1f}°" if tilt > 0.05 else ""
    if over > 0:
        return f"{over:.0f} px above the picture{tilted}"
    if under > 0:
        return f"{under:.0f} px below the picture{tilted}"
    return f"at row {camera.horizon:.0f}{tilted}"


def _points(item: SceneObject, mask: BoolArray | None) -> Finding:
    area = 0 if mask is None else int(np.count_nonzero(mask))
    text = f"{item.name} is cut out of the photo, {area} pixels of it"
    return Finding("mask", item.name, float(area), 12.0, "px", area >= 12, "points", text)


def _called(state: SceneState, image: Image, masks: Mapping[str, BoolArray]) -> list[Finding]:
    """Whether what was clicked has the colour that its name says; a drawn box says enough."""
    out: list[Finding] = []
    for item in state.objects:
        mask, word = masks.get(item.name), colour_of(item.name)
        boxed = item.grounding.box is not None
        if mask is None or word is None or boxed or not mask.any():
            continue
        share, least = float(pixels_like(image, word)[mask].mean()), CHECK.min_named_share
        fine = share >= least
        text = f"{item.name}: {share:.0%} of what was clicked may be called {word}"
        if not fine:
            text += f", most of it is {said_of(image, mask)}"
        out.append(Finding("colour", item.name, share, least, "", fine, "points", text))
    return out


def _silhouettes(
    state: SceneState,
    camera: Camera,
    masks: Mapping[str, BoolArray],
    meshes: Mapping[str, Mesh],
) -> list[Finding]:
    placed = [
        o for o in state.objects if o.name in meshes and o.position is not None and not is_added(o)
    ]
    bodies = {o.name: (in_world(o, meshes[o.name]), meshes[o.name].faces) for o in placed}
    seen = look(camera, bodies)
    out: list[Finding] = []
    for index, item in enumerate(placed):
        mask = masks.get(item.name)
        if mask is None:
            continue
        value, least = iou(seen.owner == index, mask), CHECK.min_iou
        text = f"the shape of {item.name} covers what was cut out with IoU {value:.2f}"
        fine = value >= least
        out.append(Finding("reprojection", item.name, value, least, "", fine, "mask", text))
        cut = border_share(mask)
        text = f"the border of the picture cuts off {cut:.0%} of the outline of {item.name}"
        text = f"the whole of {item.name} is in the picture" if cut < 0.005 else text
        out.append(Finding("inside", item.name, cut, 0.5, "", cut <= 0.5, "mask", text))
    return out


def _contact(item: SceneObject, state: SceneState, meshes: Mapping[str, Mesh]) -> Finding | None:
    """Gap (positive) or penetration (negative) between an object and its support, m."""
    if item.support in (None, AIR) or item.position is None:
        return None
    gap = gap_below(item, state, meshes)
    if gap is None:
        text = f"{item.name} is not over its support {item.support}"
        return Finding("contact", item.name, 1.0, CHECK.max_gap_m, "m", False, "placement", text)
    fine = abs(gap) <= CHECK.max_gap_m
    text = f"{item.name} is {abs(gap) * 1000:.2f} mm {'above' if gap >= 0 else 'inside'}"
    text = f"{item.name} stands on {item.support}" if fine else f"{text} {item.support}"
    return Finding("contact", item.name, gap, CHECK.max_gap_m, "m", fine, "placement", text)


def _over_edge(item: SceneObject, state: SceneState, meshes: Mapping[str, Mesh]) -> Finding | None:
    """A thing that is seen beyond the edge of the table it stands on: it would not stay there."""
    support = state.support(item.support or "")
    if support is None or item.position is None or not isinstance(support.shape, Slab):
        return None
    if support.shape.rail is not None:
        return None
    off = float(np.hypot(*beyond(item, meshes[item.name], support.shape)))
    if off <= CHECK.max_gap_m:
        return None
    text = f"the middle of {item.name} is seen {off:.2f} m beyond the edge of {support.name}"
    return Finding("edge", item.name, off, CHECK.max_gap_m, "m", False, "support", text)


def gap_below(item: SceneObject, state: SceneState, meshes: Mapping[str, Mesh]) -> float | None:
    """Height of an object over its support, m; None where it is not over it.

    Of the bodies that touch, without what only shows: a leaf of the lower one may reach past.
    """
    body = _solid(item, meshes)
    world = in_world(item, body)
    below = state.object(item.support or "")
    if below is not None and below.name in meshes and below.position is not None:
        other = bearing(below, _solid(below, meshes))
        return vertical_gap(world, body.faces, in_world(below, other), other.faces)
    support = state.support(item.support or "")
    if support is None or support.shape is None:
        return None
    return _over_support(world, support)


def _solid(item: SceneObject, meshes: Mapping[str, Mesh]) -> Mesh:
    """The body of an object as its shape says, where its numbers say it."""
    if item.shape is None or isinstance(item.shape, Inflated | Meshed):
        return meshes[item.name]
    return mesh_of(item.shape)


def _over_support(world: np.ndarray, support: Support) -> float | None:
    shape = support.shape
    if shape is None:
        return None
    if shape.kind == "floor":
        return float(world[:, 2].min()) - shape.height
    if shape.kind == "box" and shape.rail is not None:
        return 0.0
    if shape.kind == "box":
        top = shape.position[2] + shape.size[2] / 2
        cos, sin = np.cos(shape.yaw), np.sin(shape.yaw)
        local = (world[:, :2] - np.array(shape.position[:2])) @ np.array([[cos, -sin], [sin, cos]])
        over = (np.abs(local) <= np.array(shape.size[:2]) / 2 + 1e-9).all(1)
        return float(world[over, 2].min()) - top if over.any() else None
    if isinstance(shape, Ramp):
        gaps = [
            float(p[2]) - height
            for p in world[:: max(1, len(world) // 1500)]
            for height in [height_at(shape, float(p[0]), float(p[1]))]
            if height is not None
        ]
        return min(gaps) if gaps else None
    return 0.0


def _support(support: Support) -> Finding:
    fine = support.shape is not None
    text = f"where {support.name} lies is {'known' if fine else 'not known yet'}"
    return Finding("support", support.name, float(fine), 1.0, "", fine, "support", text)
