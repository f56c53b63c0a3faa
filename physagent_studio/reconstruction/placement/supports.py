"""Supports resolved: floors, slabs, ramps and walls from names, clicks and edges."""

import math
from collections.abc import Mapping, Sequence
from types import MappingProxyType

import numpy as np

from physagent_studio.knowledge import is_rails, is_solid, is_table, support_kind
from physagent_studio.program.scene.camera import Camera
from physagent_studio.program.scene.state import (
    Floor,
    Ramp,
    SceneState,
    Slab,
    Support,
    SupportShape,
    Wall,
)
from physagent_studio.reconstruction.camera.rays import metres_per_pixel, on_plane
from physagent_studio.reconstruction.camera.scale import FLOOR
from physagent_studio.reconstruction.photo.line_segments import Segments
from physagent_studio.reconstruction.photo.regions import BoolArray
from physagent_studio.reconstruction.supports import clicked as clicked_supports
from physagent_studio.reconstruction.supports.boxed_tops import within_box
from physagent_studio.reconstruction.supports.ramps import place_ramp
from physagent_studio.reconstruction.supports.seen_ends import Shown, to_seen_ends
from physagent_studio.reconstruction.supports.slabs import fit_slab
from physagent_studio.reconstruction.supports.snapping import snapped
from physagent_studio.reconstruction.supports.stairs import with_steps
from physagent_studio.reconstruction.supports.stances import Stance
from physagent_studio.reconstruction.supports.tabletops import Top
from physagent_studio.reconstruction.survey.survey import Survey, is_ground
from physagent_studio.reconstruction.switches import at_work


def resolve(
    state: SceneState,
    read: Survey,
    stances: Mapping[str, Stance],
    regions: Mapping[str, BoolArray],
    found: Segments,
    tops: Mapping[str, Top] = MappingProxyType({}),
    shown: Shown | None = None,
) -> tuple[tuple[Support, ...], tuple[str, ...]]:
    """The supports with their shapes, a floor added where there is none, and what stays open.

    tops: whose edges were found. shown: the photo, in which the
    ends of level tops are looked up. The second value are sentences about supports that could not
    be resolved.
    """
    out: list[Support] = []
    flags: list[str] = []
    rail_ratio = 0.06  # 0.02..0.2: over the outer width of the pair
    for support in state.supports:
        if support.shape is not None or support.name in read.basins:
            out.append(support)
            continue
        top = tops.get(support.name)
        shape = (
            _shape(support, read, stances, regions, found)
            if top is None
            else _top_slab(support, read, stances, top)
        )
        if isinstance(shape, Ramp):
            shape = with_steps(support, shape)
        if isinstance(shape, Slab) and shown is not None and _is_fitted(support, read):
            shape = _in_view(shown, support, read, stances, regions, shape)
            shape = _boxed(shown, support, read, stances, shape)
        if isinstance(shape, Slab) and is_rails(support.name):
            shape = shape.model_copy(update={"rail": rail_ratio * min(shape.size[:2])})
        if shape is None:
            flags.append(
                f"support '{support.name}' is not resolved: click the corners of a table, or the"
                " toe, foot and top of a ramp"
            )
        out.append(support.model_copy(update={"shape": shape, "source": "estimated"}))
    if not any(is_ground(support) for support in out):
        out.append(Support(name=FLOOR, shape=Floor(), source="estimated"))
    return tuple(out), tuple(flags)


def _shape(
    support: Support,
    read: Survey,
    stances: Mapping[str, Stance],
    regions: Mapping[str, BoolArray],
    found: Segments,
) -> SupportShape | None:
    exact = snapped(support, found, read.camera.size)
    clicked = clicked_supports.shape_of(exact, read.camera, *_board(support, read))
    if clicked is not None:
        return clicked
    kind = support_kind(support.name)
    clicks = [(c.x, c.y) for c in support.grounding.points if c.label]
    if kind == "floor":
        return Floor()
    if kind == "wall":
        return _wall(read.camera, clicks)
    if kind == "ramp":
        if len(clicks) == 3:
            return clicked_supports.marked_ramp(read.camera, clicks[:1], clicks[1:2], clicks[2])
        if support.name in read.flights:
            return read.flights[support.name].ramp(read.camera.position[2])
        if support.name in read.blocks:
            return read.blocks[support.name].ramp(read.camera.position[2])
        profile = read.profiles.get(support.name)
        return place_ramp(read.camera, profile) if profile else None
    return _slab(support, read, stances, regions, found, clicks)


def _board(support: Support, read: Survey) -> tuple[float, float]:
    """Height of a level support's top and thickness of what lies under it, m."""
    top = read.tops.get(support.name, 0.0)
    solid = is_solid(support.name) or support.name in read.blocks
    board_m = 0.05  # 0.01..0.1: as thick as table tops are
    return top, top if solid else min(board_m, top)


def _slab(
    support: Support,
    read: Survey,
    stances: Mapping[str, Stance],
    regions: Mapping[str, BoolArray],
    found: Segments,
    clicks: Sequence[tuple[float, float]],
    beyond: float = math.inf,
    *,
    ends_seen: bool = False,
) -> Slab | None:
    """ends_seen: in the picture the top ends where its region does, edge or no edge."""
    if support.name in read.blocks:
        return read.blocks[support.name].slab(read.camera.position[2])
    top, thickness = _board(support, read)
    standing = [stances[name] for name in stances if read.on[name] == support.name]
    feet = [stance.foot for stance in standing]
    halves = [stance.width / 2 for stance in standing]
    region = regions.get(support.name)
    if region is None:
        width, height = read.camera.size
        region = np.zeros((height, width), bool)
    boxed = ends_seen or support.grounding.box is not None
    sides = (clicks, thickness, beyond)
    return fit_slab(read.camera, top, region, found, feet, halves, *sides, boxed=boxed)


def _top_slab(
    support: Support, read: Survey, stances: Mapping[str, Stance], top: Top
) -> Slab | None:
    """The slab of a top whose edges were found; what nobody marked may go on where none is seen."""
    unseen_m = 0.25  # 0..1: how far such a top goes on outside the picture
    region = {support.name: top.region}
    marked = support.grounding.shows_something
    return _slab(support, read, stances, region, top.edges, (), unseen_m, ends_seen=marked)


def _is_fitted(support: Support, read: Survey) -> bool:
    """Whether the sides of a level top come from the picture's edges, not from clicked corners."""
    clicks = sum(click.label for click in support.grounding.points)
    return not support.grounding.marks and clicks < 4 and support.name not in read.blocks


def _in_view(
    shown: Shown,
    support: Support,
    read: Survey,
    stances: Mapping[str, Stance],
    regions: Mapping[str, BoolArray],
    slab: Slab,
) -> Slab:
    feet = [stances[name].foot for name in stances if read.on[name] == support.name]
    spots = np.array(feet, float).reshape(-1, 2)
    places = on_plane(read.camera, spots, slab.position[2] + slab.size[2] / 2)[:, :2]
    standing = places[np.isfinite(places).all(1)]
    region = regions.get(support.name, np.zeros(shown.covered.shape, bool))
    return to_seen_ends(shown, read.camera, slab, region, standing)


def _boxed(
    shown: Shown, support: Support, read: Survey, stances: Mapping[str, Stance], slab: Slab
) -> Slab:
    """The slab of a table that a person drew a box around, as that says where it ends, unless they
    chose or drew its mask."""
    mark = support.grounding
    chosen = mark.settled or mark.candidate > 0 or bool(mark.strokes)
    if mark.box is None or chosen or not is_table(support.name) or not at_work("boxed tops"):
        return slab
    top = slab.position[2] + slab.size[2] / 2
    bases = []
    for name, stance in stances.items():
        if read.on[name] == support.name:
            place = on_plane(read.camera, [stance.foot], top)
            if np.isfinite(place).all():
                place[0, 1] += stance.width / 2 * metres_per_pixel(read.camera, tuple(place[0]))
                bases.append(read.camera.project(place)[0][0])
    return within_box(shown, read.camera, slab, mark.box, np.array(bases).reshape(-1, 2))


def _wall(camera: Camera, clicks: Sequence[tuple[float, float]]) -> Wall | None:
    """A wall through two clicks on its foot; with one click, facing the camera."""
    ground = on_plane(camera, clicks, 0.0) if clicks else np.zeros((0, 3))
    ground = ground[np.isfinite(ground).all(1)]
    if not len(ground):
        return None
    yaw = -math.pi / 2
    if len(ground) > 1:
        along = ground[1] - ground[0]
        yaw = math.atan2(-along[0], along[1])
        facing = np.array([math.cos(yaw), math.sin(yaw)])
        if facing @ (np.array(camera.position[:2]) - ground[0, :2]) < 0:
            yaw = yaw - math.pi if yaw > 0 else yaw + math.pi
    x, y, _ = (float(value) for value in ground[0])
    return Wall(point=(x, y, 0.0), yaw=yaw)
