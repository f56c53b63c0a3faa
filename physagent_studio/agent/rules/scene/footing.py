"""What nobody measured is made such that things stand: ramps wide enough, bodies deep enough."""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import product

import numpy as np

from physagent_studio.agent.rules.scene.measures import Layout
from physagent_studio.knowledge import density_of, is_sheet, usual_size
from physagent_studio.program.rotations import matrix_of
from physagent_studio.program.scene.aloft import AIR
from physagent_studio.program.scene.camera import Camera
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
    # ratio, 0.9..0.99: of the boxes around a block as it is seen with its own depth and another
    min_same_share: float = 0.94


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
    """The state with blocks of one kind and one size of front equally deep, as most of what is
    seen of them says.

    A block seen straight from its front shows nothing of its depth; a row of dominoes of several
    depths twists as it falls. The front of each stays where it is, and what is seen to be less or
    more deep keeps its depth.
    """
    if state.camera is None:
        return state
    found = {item.name: item for item in state.objects}
    for item in _blocks(state):
        like = [o for o in _blocks(state) if _alike(item, o)]
        changed = _as_deep(item, _usual_depth(like, state.camera), state.camera)
        if len(like) > 1 and _looks_the_same(item, changed, state.camera):
            found[item.name] = changed
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


def _usual_depth(blocks: Sequence[SceneObject], camera: Camera) -> float:
    """The depth of the one in the middle, where each counts by how much of its depth is seen."""
    depths = np.array([block.shape.size[1] for block in blocks])  # type: ignore[union-attr]
    aways = [np.asarray(block.position) - np.asarray(camera.position) for block in blocks]
    along = [
        float(matrix_of(block.rotation)[:, 1] @ away) / float(np.linalg.norm(away))
        for block, away in zip(blocks, aways, strict=True)
    ]
    order = np.argsort(depths, kind="stable")
    seen = np.sqrt(np.maximum(1 - np.square(along), 0.0))[order].cumsum()
    return float(depths[order][int(np.searchsorted(seen, seen[-1] / 2))])


def _looks_the_same(item: SceneObject, other: SceneObject, camera: Camera) -> bool:
    """Whether the boxes around two blocks in the picture are nearly the same."""
    boxes = [_box_in_the_picture(one, camera) for one in (item, other)]
    low, high = np.maximum(boxes[0][0], boxes[1][0]), np.minimum(boxes[0][1], boxes[1][1])
    common = float(np.prod(np.maximum(high - low, 0.0)))
    areas = sum(float(np.prod(box[1] - box[0])) for box in boxes)
    return common / max(areas - common, 1e-9) > DEPTH.min_same_share


def _box_in_the_picture(item: SceneObject, camera: Camera) -> np.ndarray:
    """(2, 2): lowest and highest pixel of a block."""
    assert isinstance(item.shape, Box)
    signs = np.array(list(product((-0.5, 0.5), repeat=3)))
    corners = signs * np.array(item.shape.size) @ matrix_of(item.rotation).T
    pixels, _ = camera.project(corners + np.asarray(item.position))
    return np.stack([pixels.min(axis=0), pixels.max(axis=0)])


def _as_deep(item: SceneObject, depth: float, camera: Camera) -> SceneObject:
    """The block with another depth, and its front where it was."""
    assert isinstance(item.shape, Box)
    width, before, height = item.shape.size
    back = matrix_of(item.rotation)[:, 1]
    away = np.asarray(item.position) - np.asarray(camera.position)
    back = back if float(back @ away) > 0 else -back
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
