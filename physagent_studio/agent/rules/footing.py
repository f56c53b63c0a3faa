"""Supports that nobody measured are made to carry what stands on them."""

from __future__ import annotations

import math

import numpy as np

from physagent_studio.agent.rules.layout import Layout
from physagent_studio.program.scene import Ramp, SceneState, Support


def with_room(state: SceneState) -> SceneState:
    """The state with estimated ramps as wide as what stands on them needs."""
    layout = Layout(state)
    supports = tuple(_wide_enough(support, layout) for support in state.supports)
    return state.model_copy(update={"supports": supports}) if supports != state.supports else state


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
