"""What nobody measured is made such that things stand: ramps wide enough, bodies deep enough."""

from __future__ import annotations

import math

import numpy as np

from physagent_studio.agent.rules.layout import Layout
from physagent_studio.agent.rules.look import is_sheet
from physagent_studio.program.scene import Inflated, Ramp, SceneObject, SceneState, Support


def with_room(state: SceneState) -> SceneState:
    """The state with estimated ramps as wide as what stands on them needs."""
    layout = Layout(state)
    supports = tuple(_wide_enough(support, layout) for support in state.supports)
    return state.model_copy(update={"supports": supports}) if supports != state.supports else state


def with_depth(state: SceneState) -> SceneState:
    """The state with inflated bodies about as deep as they are narrow.

    The depth of an inflated outline is a guess that no picture can settle; what stands by itself
    is not a thin slice, or the first push along it would lay it on its side.
    """
    objects = tuple(_deep_enough(item) for item in state.objects)
    return state.model_copy(update={"objects": objects}) if objects != state.objects else state


def _deep_enough(item: SceneObject) -> SceneObject:
    shape = item.shape
    stands = item.support not in (None, "air") and not is_sheet(item.name)
    if not isinstance(shape, Inflated) or not stands or item.source in ("given", "person"):
        return item
    width, depth, height = shape.size
    wanted = 0.9 * min(width, height)
    if depth >= wanted:
        return item
    size = (width, round(wanted, 6), height)
    return item.model_copy(update={"shape": shape.model_copy(update={"size": size})})


def _wide_enough(support: Support, layout: Layout) -> Support:
    shape = support.shape
    if not isinstance(shape, Ramp) or support.source in ("given", "person"):
        return support
    across = np.array([-math.sin(shape.yaw), math.cos(shape.yaw), 0.0])
    carried = [o.name for o in layout.state.objects if layout.carrier(o.name) == support.name]
    reach = [_reach(layout, name, across, np.array(shape.toe)) for name in carried]
    width = max([shape.width, *(2.2 * one for one in reach)])
    if width <= shape.width * 1.001:
        return support
    return support.model_copy(update={"shape": shape.model_copy(update={"width": width})})


def _reach(layout: Layout, name: str, across: np.ndarray, toe: np.ndarray) -> float:
    """How far an object reaches to the side from the middle line of the ramp, m."""
    offset = abs(float((layout.position(name) - toe) @ across))
    return offset + max(layout.extent(name, across), layout.extent(name, -across))
