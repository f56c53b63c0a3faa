"""What nobody measured is made such that things stand: ramps wide enough, bodies deep enough."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from physagent_studio.agent.rules.scene.measures import Layout
from physagent_studio.knowledge import density_of, is_sheet, usual_size
from physagent_studio.program.rotations import matrix_of
from physagent_studio.program.scene.aloft import AIR
from physagent_studio.program.scene.state import (
    Box,
    Inflated,
    Landmark,
    Ramp,
    SceneObject,
    SceneState,
    Slab,
    Support,
)
from physagent_studio.reconstruction.grounding.same_kind import kind_name


@dataclass(frozen=True, slots=True)
class DepthSettings:
    """Which blocks are taken for copies of one another."""

    # ratio, 1.05..1.5: of widths and heights as they are seen, up to which blocks are alike
    alike_ratio: float = 1.25


DEPTH = DepthSettings()


def with_room(state: SceneState) -> SceneState:
    """The state with estimated ramps as wide as what stands on them needs."""
    layout = Layout(state)
    supports = tuple(_wide_enough(support, layout) for support in state.supports)
    return state.model_copy(update={"supports": supports}) if supports != state.supports else state


def with_depth(state: SceneState) -> SceneState:
    """The state with inflated bodies about as deep as they are narrow.

    The depth of an inflated outline is a guess that no picture can settle, unless its name does;
    what stands by itself is not a thin slice, or the first push along it would lay it on its side.
    What has a seat keeps it where things stand on it.
    """
    objects = tuple(_deep_enough(item) for item in state.objects)
    return state.model_copy(update={"objects": objects}) if objects != state.objects else state


def with_depth_of_like(state: SceneState) -> SceneState:
    """The state with blocks of one kind and one size of front as deep as the one of them whose
    side is seen best.

    A block seen straight from its front shows nothing of its depth; a row of dominoes of several
    depths twists as it falls. What is seen of each, its front, stays where it is.
    """
    eye = np.asarray(state.camera.position if state.camera is not None else (0.0, 0.0, 0.0))
    found = {item.name: item for item in state.objects}
    for item in _blocks(state):
        like = [o for o in _blocks(state) if _alike(item, o)]
        best = max(like, key=lambda one: _seen_from_the_side(one, eye))
        if best is not item:
            found[item.name] = _as_deep(item, best.shape.size[1], eye)  # type: ignore[union-attr]
    objects = tuple(found.values())
    return state.model_copy(update={"objects": objects}) if objects != state.objects else state


def _blocks(state: SceneState) -> Sequence[SceneObject]:
    """Blocks whose depth nobody has stated."""
    return [
        item
        for item in state.objects
        if isinstance(item.shape, Box)
        and item.position is not None
        and item.source not in ("given", "person")
        and usual_size(item.name).depth is None
    ]


def _alike(one: SceneObject, other: SceneObject) -> bool:
    """Whether two blocks are called alike, stand on the same and look alike from their fronts."""
    assert isinstance(one.shape, Box)
    assert isinstance(other.shape, Box)
    same = kind_name(one.name) == kind_name(other.name) and one.support == other.support
    ratios = np.log(np.array(one.shape.size) / np.array(other.shape.size))[[0, 2]]
    return same and bool((np.abs(ratios) < math.log(DEPTH.alike_ratio)).all())


def _seen_from_the_side(item: SceneObject, eye: np.ndarray) -> float:
    """Sine, 0 … 1, between the way in which a block is deep and the line of sight."""
    away = np.asarray(item.position) - eye
    return abs(float(matrix_of(item.rotation)[:, 0] @ away)) / float(np.linalg.norm(away))


def _as_deep(item: SceneObject, depth: float, eye: np.ndarray) -> SceneObject:
    """The block with another depth, and its front where it was."""
    assert isinstance(item.shape, Box)
    width, before, height = item.shape.size
    back = matrix_of(item.rotation)[:, 1]
    back = back if float(back @ (np.asarray(item.position) - eye)) > 0 else -back
    spot = np.asarray(item.position) + back * (depth - before) / 2
    x, y, z = (round(float(part), 6) for part in spot)
    shape = item.shape.model_copy(update={"size": (width, depth, height)})
    return item.model_copy(update={"shape": shape, "position": (x, y, z)})


def with_walls_weighed(state: SceneState) -> SceneState:
    """The state with open vessels as heavy as their walls.

    The mean density of what is mostly air counts for a solid outline, not for walls.
    """
    objects = tuple(_weighed(item) for item in state.objects)
    return state.model_copy(update={"objects": objects}) if objects != state.objects else state


def _weighed(item: SceneObject) -> SceneObject:
    walled = getattr(item.shape, "wall", None) is not None
    guessed = item.density is not None and item.density == density_of(item.name)
    if not walled or not guessed or item.source in ("given", "person"):
        return item
    return item.model_copy(update={"density": None})


def _deep_enough(item: SceneObject) -> SceneObject:
    shape = item.shape
    stands = item.support not in (None, AIR) and not is_sheet(item.name)
    if (
        not isinstance(shape, Inflated)
        or shape.flat
        or shape.seat is not None
        or not stands
        or item.source in ("given", "person")
        or usual_size(item.name).depth is not None
    ):
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
    width = max([shape.width, *reach])
    if width <= shape.width * 1.001:
        return support
    return support.model_copy(update={"shape": shape.model_copy(update={"width": width})})


def _reach(layout: Layout, name: str, across: np.ndarray, toe: np.ndarray) -> float:
    """Width of a ramp on which an object has half of its own size to spare on either side, m.

    What runs down a slope turns a little on its way; without that room it falls off the side.
    """
    offset = abs(float((layout.position(name) - toe) @ across))
    aside = offset + max(layout.extent(name, across), layout.extent(name, -across))
    return 2 * aside + layout.size(name)


def with_hold(state: SceneState) -> SceneState:
    """The state with what rests near an edge standing on its support by a little.

    Reconstruction is uncertain by some centimetres, and an object whose middle comes out beyond
    the edge would fall by itself. It is moved inwards, level, by what is missing.
    """
    layout = Layout(state)
    objects = tuple(_held_in(item, layout) for item in state.objects)
    return state.model_copy(update={"objects": objects}) if objects != state.objects else state


def _held_in(item: SceneObject, layout: Layout) -> SceneObject:
    if item.source in ("given", "person") or item.position is None or item.shape is None:
        return item
    carrier = layout.carrier(item.name)
    shape = getattr(layout.state.support(carrier or ""), "shape", None)
    if not isinstance(shape, Slab):
        return item
    spot = np.array(item.position, float)
    inside_share = 0.05  # 0..0.3: of a thing's size: how far in from the edge its middle is
    for _ in range(2):
        for out, middle in _edges(shape, layout.state.landmark(f"{carrier}_edge")):
            beyond = float((spot - middle) @ out) + inside_share * layout.size(item.name)
            if 0 < beyond < layout.size(item.name):
                spot = spot - out * beyond
    if np.allclose(spot, item.position, atol=1e-6):
        return item
    x, y, z = (round(float(part), 6) for part in spot)
    return item.model_copy(update={"position": (x, y, z)})


def _edges(slab: Slab, mark: Landmark | None) -> list[tuple[np.ndarray, np.ndarray]]:
    """(outward unit vector, a point) of each edge of a slab, and of the edge that was marked."""
    ahead = np.array([math.cos(slab.yaw), math.sin(slab.yaw), 0.0])
    aside = np.array([-ahead[1], ahead[0], 0.0])
    centre = np.array(slab.position, float)
    found = [
        (out, centre + out * half)
        for axis, half in ((ahead, slab.size[0] / 2), (aside, slab.size[1] / 2))
        for out in (axis, -axis)
    ]
    if mark is not None and mark.points is not None and len(mark.points) > 1:
        start, end = (np.array(point, float) for point in (mark.points[0], mark.points[-1]))
        along = end - start
        out = np.array([along[1], -along[0], 0.0]) / max(float(np.hypot(along[0], along[1])), 1e-9)
        out = out if float(out @ (start - centre)) > 0 else -out
        found.append((out, start))
    return found
