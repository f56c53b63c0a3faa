"""Open vessels that do not move: a bowl, a tray or a box without a lid that is a support.

They are fitted as an object of that name would be, to the pixels that their clicks select, and are
given walls; what stands in them stands on their floor.
"""

import math
from collections.abc import Mapping

import numpy as np

from physagent_studio.language import SceneHints
from physagent_studio.program.rotations import about_up
from physagent_studio.program.scene.boards import is_hollow
from physagent_studio.program.scene.state import (
    Box,
    Frustum,
    Revolved,
    SceneObject,
    SceneState,
    Support,
    Vessel,
)
from physagent_studio.reconstruction.photo.regions import BoolArray
from physagent_studio.reconstruction.placement.bases import base_of
from physagent_studio.reconstruction.shapes.forms import forms
from physagent_studio.reconstruction.shapes.meshes import mesh_of
from physagent_studio.reconstruction.shapes.vessels import (
    hollow_first,
    hollow_kinds,
    opened,
)
from physagent_studio.reconstruction.supports.stances import Stance
from physagent_studio.reconstruction.survey.survey import Survey
from physagent_studio.records.scene import Mesh


def basin_names(state: SceneState, told: SceneHints) -> frozenset[str]:
    """Supports that are open vessels, as the sentence uses them, and whose shape is open or such.

    Only those that were clicked: nothing else says where they are.
    """
    return frozenset(
        item.name
        for item in state.supports
        if isinstance(item.shape, Vessel)
        or (item.shape is None and item.grounding.points and item.name in told.hollow)
    )


def with_basins(
    solid: tuple[Support, ...],
    masks: Mapping[str, BoolArray],
    things: Mapping[str, BoolArray],
    stances: Mapping[str, Stance],
    read: Survey,
) -> tuple[Support, ...]:
    """The supports with every open vessel among them fitted.

    masks: (H, W) of the vessels. things: (H, W) of the objects, which may hide parts of them.
    """
    out = list(solid)
    for index, support in enumerate(solid):
        stance = stances.get(support.name)
        if support.shape is not None or support.name not in read.basins or stance is None:
            continue
        others = [mask for name, mask in {**masks, **things}.items() if name != support.name]
        hidden = np.any(others, axis=0) if others else None
        shape = _fitted(masks[support.name], hidden, stance, read, solid)
        out[index] = support.model_copy(update={"shape": shape, "source": "estimated"})
    return tuple(out)


def _fitted(
    mask: BoolArray,
    hidden: BoolArray | None,
    stance: Stance,
    read: Survey,
    solid: tuple[Support, ...],
) -> Vessel | None:
    base = base_of(stance, read, solid, {})
    usual = read.usual[stance.name]
    found = hollow_first(forms(read.camera, mask, base, hollow_kinds(usual), None, hidden))
    body = opened(found).shape
    if not isinstance(body, Box | Frustum | Revolved) or body.wall is None:
        return None
    w, _, _, z = found.rotation
    return Vessel(position=found.position, yaw=2 * math.atan2(z, w), body=body)


def standing_for(supports: tuple[Support, ...]) -> dict[str, tuple[SceneObject, Mesh]]:
    """The vessels among supports as things in place, with their meshes in the body frame."""
    out: dict[str, tuple[SceneObject, Mesh]] = {}
    for support in supports:
        shape = support.shape
        if isinstance(shape, Vessel) and is_hollow(shape):
            item = SceneObject(
                name=support.name,
                shape=shape.body,
                position=shape.position,
                rotation=about_up(shape.yaw),
            )
            out[support.name] = (item, mesh_of(shape.body))
    return out
