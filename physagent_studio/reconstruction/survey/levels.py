"""Sizes and levels of a picture: what things of known size say of the camera and the planes."""

from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from physagent_studio.knowledge import Usual, support_height, support_kind
from physagent_studio.program.scene.aloft import AIR
from physagent_studio.program.scene.camera import Camera
from physagent_studio.program.scene.state import SceneState
from physagent_studio.reconstruction.camera.rays import depth_of, on_plane
from physagent_studio.reconstruction.camera.scale import FLOOR, Heights, Measured, solve
from physagent_studio.reconstruction.photo.regions import BoolArray
from physagent_studio.reconstruction.supports import clicked as clicked_supports
from physagent_studio.reconstruction.supports.block import Block
from physagent_studio.reconstruction.supports.ramps import Profile
from physagent_studio.reconstruction.supports.stances import Stance
from physagent_studio.reconstruction.supports.standing import ground_pixel


def heights_of(
    state: SceneState,
    unit: Camera,
    measured: list[Measured],
    blocks: Mapping[str, Block],
    steps: Mapping[str, int],
    shelved: Mapping[str, float],
) -> Heights:
    """Metres: the heights of the camera and of all level planes.

    steps: see `on_one_floor`. shelved: boards of a shelf, as shares of the camera's height.
    """
    rises = {name: block.size[2] for name, block in blocks.items() if block.kind == "box"}
    rises |= {**clicked_supports.rises_of(state, unit), **shelved}
    measured = clicked_supports.on_one_floor(
        measured, rises, {**steps, **dict.fromkeys(shelved, 0)}
    )
    slabs = {name: top for name, top in _usual_tops(state).items() if name not in rises}
    known = state.camera.position[2] if state.camera is not None else None
    found = clicked_supports.with_rises(solve(measured, slabs, state.scale, known), rises)
    # Over a known camera what is given stays where it is, whatever sizes say.
    return found if known is None else replace(found, tops={**found.tops, **_given_tops(state)})


def _given_tops(state: SceneState) -> dict[str, float]:
    """Heights of the tops of slabs that have a shape, m."""
    return {
        support.name: support.shape.position[2] + support.shape.size[2] / 2
        for support in state.supports
        if support.shape is not None and support.shape.kind == "box"
    }


def _usual_tops(state: SceneState) -> dict[str, float]:
    """Level planes above the floor: the tops of slabs, given or usual."""
    tops = _given_tops(state)
    usual_top_m = 0.6  # 0.2..1.2: of a slab whose name says nothing, between bench and counter
    for support in state.supports:
        if support.shape is None and support_kind(support.name) == "slab":
            tops[support.name] = support_height(support.name) or usual_top_m
    return tops


def measured_of(
    unit: Camera,
    stances: Mapping[str, Stance],
    on: Mapping[str, str],
    under: Mapping[str, str | None],
    root: Mapping[str, str],
    usual: Mapping[str, Usual],
    profiles: Mapping[str, Profile],
    tops: Mapping[str, BoolArray],
) -> list[Measured]:
    """Sizes in units of the camera's height above each object's plane.

    `unit` may have any height above z = 0; sizes are divided by it. tops: (H, W) where the tops of
    tables are seen; what is in the air above one of them is taken to be over its middle.
    """
    above = unit.position[2]
    out: list[Measured] = []
    aloft_spread_log = 0.4  # 0..1: less sure where it is only known what a thing is over
    for name, stance in stances.items():
        foot = ground_pixel(name, stances, on, under, profiles)
        plane = FLOOR if root[name] in (AIR, *profiles) else root[name]
        seen = usual[name]
        if foot is None and on[name] == AIR:
            foot, plane = _over(stance, tops)
            seen = replace(seen, spread=seen.spread + aloft_spread_log)
        if foot is None:
            continue
        place = on_plane(unit, [foot], 0.0)[0]
        if not np.isfinite(place).all():
            continue
        units = stance.extent * depth_of(unit, place) / unit.focal / above
        if on[name] == AIR or on[name] in stances:
            seen = replace(seen, spread=seen.spread + 0.1)
        out.append(Measured(name, plane, units, seen))
    return out


def _over(stance: Stance, tops: Mapping[str, BoolArray]) -> tuple[tuple[float, float] | None, str]:
    """The pixel of a top that something in the air is over, half way down it, and whose it is."""
    column, foot = round(stance.foot[0]), round(stance.foot[1])
    for name, top in tops.items():
        rows = np.flatnonzero(top[:, min(max(column, 0), top.shape[1] - 1)])
        if len(rows) and rows[0] >= foot:
            return (float(column), float(rows[0] + rows[-1]) / 2), name
    return None, FLOOR
