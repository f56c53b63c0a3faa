"""Looks of the things that a photo shows: led to their masks, the photo on them."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from physagent_studio.program.scene.aloft import AIR
from physagent_studio.program.scene.camera import Camera
from physagent_studio.program.scene.state import Ramp, SceneObject, SceneState, Support
from physagent_studio.reconstruction.masks.hidden_tops import with_hidden_tops
from physagent_studio.reconstruction.photo.regions import BoolArray, grow
from physagent_studio.reconstruction.shapes.silhouettes import in_world
from physagent_studio.reconstruction.texture.carving import carved, with_parts
from physagent_studio.reconstruction.texture.outline_fitting import (
    FloatArray,
    Sight,
    covering,
)
from physagent_studio.reconstruction.texture.projection import textured
from physagent_studio.records.case import Image
from physagent_studio.records.scene import Mesh


def skinned(
    photo: Image,
    masks: Mapping[str, BoolArray],
    state: SceneState,
    bodies: Mapping[str, Mesh],
) -> dict[str, Mesh]:
    """What is drawn of the things that have a mask (H, W), body frame, by name.

    state: completed. bodies: their untextured meshes, body frame.
    """
    camera = state.camera
    assert camera is not None
    shown = [item for item in state.objects if item.name in bodies and item.name in masks]
    sights = sights_of(camera, masks, shown, bodies, state.supports)
    out = {}
    for item in shown:
        body = covering(sights[item.name], item, bodies[item.name])
        look = with_parts(sights[item.name], item, carved(sights[item.name], item, body))
        skin = textured(photo, _own(item.name, masks), camera, item, look)
        solid = None if look is body else (body.vertices, body.faces)
        out[item.name] = replace(skin, solid=solid)
    return out


def _own(name: str, masks: Mapping[str, BoolArray]) -> BoolArray:
    """The mask without what other things' colours have run into, or as it is where little is left.

    What they hide of it is painted from there.
    """
    others = [other for one, other in masks.items() if one != name and other.any()]
    if not others:
        return masks[name]
    fringe_px = 3  # 0..10: beside another thing, where colours are not all a thing's own
    own = masks[name] & ~grow(np.any(others, axis=0), fringe_px)
    return own if np.count_nonzero(own) > np.count_nonzero(masks[name]) / 2 else masks[name]


def sights_of(
    camera: Camera,
    masks: Mapping[str, BoolArray],
    objects: Sequence[SceneObject],
    meshes: Mapping[str, Mesh],
    supports: Sequence[Support],
) -> dict[str, Sight]:
    """What the look of each placed thing is led to, by name."""
    placed = [item for item in objects if item.name in meshes and item.position is not None]
    near = {item.name: _distance(camera, item, meshes[item.name]) for item in placed}
    solid = {support.name: support for support in supports}
    whole = with_hidden_tops(masks, {item.name: item.support or AIR for item in placed})
    out = {}
    for item in placed:
        mask = masks[item.name]
        free = np.ones(mask.shape, bool)
        for other in placed:
            if other.name != item.name and _hides(other, item, near):
                free &= ~masks[other.name] | mask
        out[item.name] = Sight(camera, mask, free, _up(item, solid), whole[item.name] & ~mask)
    return out


def _hides(other: SceneObject, item: SceneObject, near: Mapping[str, float]) -> bool:
    """Whether the one is before the other: what is carried is before what carries it."""
    if other.support == item.name:
        return True
    return item.support != other.name and near[other.name] < near[item.name]


def _distance(camera: Camera, item: SceneObject, mesh: Mesh) -> float:
    """Depth of the middle of a thing along the optical axis, m."""
    return float(camera.project(in_world(item, mesh).mean(0)[None])[1][0])


def _up(item: SceneObject, solid: Mapping[str, Support]) -> FloatArray | None:
    """(3,) unit normal of what a thing stands on, world."""
    if item.support in (None, AIR):
        return None
    support = solid.get(item.support)
    shape = support.shape if support is not None else None
    if isinstance(shape, Ramp) and not shape.steps:
        normal = np.array(
            [-shape.rise * math.cos(shape.yaw), -shape.rise * math.sin(shape.yaw), shape.run]
        )
        return np.asarray(normal / np.linalg.norm(normal))
    return np.array([0.0, 0.0, 1.0])
