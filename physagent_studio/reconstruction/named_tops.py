"""Tables that the sentence names and nobody clicked: the level top under the things."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from physagent_studio.program.camera import Camera
from physagent_studio.program.scene import SceneState, Support
from physagent_studio.reconstruction.geometry import metres_per_pixel, on_plane
from physagent_studio.reconstruction.layout import Stance
from physagent_studio.reconstruction.lines import with_hues
from physagent_studio.reconstruction.names import support_height, support_kind
from physagent_studio.reconstruction.scale import FLOOR
from physagent_studio.reconstruction.sighting import Look, unit_camera
from physagent_studio.reconstruction.survey import first_sight
from physagent_studio.reconstruction.tabletops import Top, top_around
from physagent_studio.records.case import Case

FloatArray = NDArray[np.float64]


def unclicked(state: SceneState) -> tuple[Support, ...]:
    """Supports with a level top that are known by name alone, the first one only.

    Where several are, nothing tells which of them it is that things stand on.
    """
    found = [
        item
        for item in state.supports
        if item.shape is None
        and support_kind(item.name) == "slab"
        and support_height(item.name) is not None
        and not item.grounding.shows_something
        and not item.grounding.marks
    ]
    return tuple(found[:1])


def with_named_tops(case: Case, state: SceneState, look: Look) -> tuple[Look, dict[str, Top]]:
    """The look with the regions of tables that are known by name alone; and those tops.

    What stands on the floor, as far as anyone said, stands on it.
    """
    named = unclicked(state)
    if not named:
        return look, {}
    first = first_sight(case, state, look)
    unit = unit_camera(case, state, look.size, first.horizon(case, state))
    standing = [
        stance
        for name, stance in look.stances.items()
        if first.on[name] == FLOOR and not stance.aloft and name not in first.groundless
    ]
    bases = _bases(unit, standing)
    seen = np.flatnonzero(np.isfinite(bases).all(1))
    standing = [standing[k] for k in seen]
    if not standing:
        return look, {}
    edges = with_hues(look.image, look.found)
    top = top_around(look.image, edges, standing, bases[seen], look.covered)
    if top is None:
        return look, {}
    own = {named[0].name: top}
    regions = {**look.regions, **{name: one.region for name, one in own.items()}}
    return replace(look, regions=regions), own


def said(names: Iterable[str]) -> list[str]:
    """Sentences about tables that are known by name alone."""
    return [
        f"{name} is known by the sentence alone: its height is a usual one, and where none of its"
        " edges is seen, so is its size"
        for name in names
    ]


def _bases(unit: Camera, stances: Sequence[Stance]) -> FloatArray:
    """(N, 2) pixels of the middles of what things stand with; nan above the horizon."""
    out = np.full((len(stances), 2), np.nan)
    for k, stance in enumerate(stances):
        ground = on_plane(unit, [stance.foot], 0.0)
        if np.isfinite(ground).all():
            ground[0, 1] += stance.width / 2 * metres_per_pixel(unit, tuple(ground[0]))
            out[k] = unit.project(ground)[0][0]
    return out
