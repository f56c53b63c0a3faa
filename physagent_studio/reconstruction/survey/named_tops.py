"""Tables as what ends them shows them: those that nobody clicked, and those whose clicks agree."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from physagent_studio.arrays import BoolArray, FloatArray
from physagent_studio.knowledge import (
    is_rails,
    is_solid,
    support_height,
    support_kind,
)
from physagent_studio.program.scene.camera import Camera
from physagent_studio.program.scene.state import Grounding, SceneState, Support
from physagent_studio.reconstruction.camera.rays import metres_per_pixel, on_plane
from physagent_studio.reconstruction.camera.scale import FLOOR
from physagent_studio.reconstruction.photo.line_segments import Segments, with_hues
from physagent_studio.reconstruction.photo.regions import grow, iou
from physagent_studio.reconstruction.supports.stances import Stance
from physagent_studio.reconstruction.supports.tabletops import Top, top_around
from physagent_studio.reconstruction.survey.sighting import Look, unit_camera
from physagent_studio.reconstruction.survey.survey import first_sight
from physagent_studio.records.case import Case


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


def with_tops(case: Case, state: SceneState, look: Look) -> tuple[Look, dict[str, Top]]:
    """The look with the regions of level tops that are bounded by their edges; and those tops.

    On a table that is known by name alone stands what nobody said stands elsewhere. The top of one
    that is clicked or boxed counts for more than what grew from there, unless a person chose that,
    or the top is only a part of what grew from a click on it; a click on its front tells it too.
    """
    named, clicked = unclicked(state), _clicked(state, look)
    if not named and not clicked:
        return look, {}
    first = first_sight(state, look)
    unit = unit_camera(case, state, look.size, first.horizon(case, state))
    edges = with_hues(look.image, look.found)
    floored = {
        name: stance
        for name, stance in look.stances.items()
        if first.on[name] == FLOOR and not stance.aloft
    }
    loose = list(floored.values())
    stated = {item.name for item in state.objects if item.support is not None}
    unsaid = [stance for name, stance in floored.items() if name not in stated]
    found: dict[str, Top] = {}
    for support in named:
        top = _top(look, unit, edges, loose)
        if top is not None:
            found[support.name] = top
    for support in clicked:
        own = [stance for name, stance in look.stances.items() if first.on[name] == support.name]
        # Where it grew into a speck, that does not tell what stands on the whole.
        top = _marked(support.grounding, look, unit, edges, own or unsaid, support.name)
        if top is not None:
            found[support.name] = top
    tops = {name: top.region for name, top in found.items()}
    return replace(look, regions={**look.regions, **tops}), found


def _marked(
    mark: Grounding,
    look: Look,
    unit: Camera,
    edges: Segments,
    standing: Sequence[Stance],
    name: str,
) -> Top | None:
    """The top that is clicked or boxed, where it counts for more than what has grown from there."""
    points = mark.points if mark.box is None else ()
    clicks = np.array([(c.x, c.y) for c in points if c.label]).reshape(-1, 2)
    masks = [mask & ~look.covered for mask in look.offers[name]]
    chosen = mark.settled or mark.candidate > 0
    top = _top(look, unit, edges, standing, clicks, mark.box)
    if top is None and mark.box is None and not chosen:
        # The clicks lie on its front, with which the top has grown.
        top = _top(look, unit, edges, _resting(masks[0], standing))
        return top if top is not None and _has_front(top.region, masks[0], clicks) else None
    if top is None:
        return None
    min_overlap = 0.5  # IoU, 0.3..0.9: from which a clicked mask and a bounded top are one
    alike = max(iou(mask, top.region) for mask in masks) > min_overlap
    part = mark.box is None and _is_part(top.region, masks[0])
    return top if alike or not (chosen or part) else None


def _resting(mask: BoolArray, standing: Sequence[Stance]) -> list[Stance]:
    """Those of the things whose feet are next to a mask (H, W)."""
    near_ratio = 0.01  # 0.002..0.03: over the longer side, between a foot and the mask
    near = grow(mask, max(3, round(near_ratio * max(mask.shape))))
    rows, columns = mask.shape
    feet = [np.round(stance.foot).astype(int) for stance in standing]
    return [
        stance
        for stance, (x, y) in zip(standing, feet, strict=True)
        if near[np.clip(y, 0, rows - 1), np.clip(x, 0, columns - 1)]
    ]


def _is_part(top: BoolArray, mask: BoolArray) -> bool:
    """Whether a top is only a part of the mask that has grown from a click: of one colour of it."""
    min_share = 0.7  # share, 0.5..0.95: of the top that lies on the mask
    return float((mask & top).sum()) > min_share * float(top.sum())


def _has_front(top: BoolArray, mask: BoolArray, clicks: FloatArray) -> bool:
    """Whether clicks (N, 2) lie below a top, on what has grown from them with most of the top."""
    rows, columns = top.shape
    x, y = np.clip(np.round(clicks).astype(int), 0, (columns - 1, rows - 1)).T
    lowest = np.where(top.any(0), rows - 1 - np.argmax(top[::-1], axis=0), rows)
    below = len(clicks) > 0 and bool((y > lowest[x]).all())
    return below and _is_part(top, mask) and int(top.sum()) < int(mask.sum())


def _clicked(state: SceneState, look: Look) -> list[Support]:
    """Level tops that were clicked, without corners, and on which things may stand."""
    corner_clicks = 4  # count, 3..4: so many clicks on a top are its corners
    return [
        item
        for item in state.supports
        if item.shape is None
        and support_kind(item.name) == "slab"
        and not is_solid(item.name)
        and not is_rails(item.name)
        and not item.grounding.marks
        and sum(click.label for click in item.grounding.points) < corner_clicks
        and look.offers.get(item.name)
    ]


def _top(
    look: Look,
    unit: Camera,
    edges: Segments,
    standing: Sequence[Stance],
    clicks: FloatArray | None = None,
    box: tuple[float, float, float, float] | None = None,
) -> Top | None:
    """The level top on which things are seen to stand, those of them that stand in a box."""
    bases = _bases(unit, standing)
    if box is not None:
        feet = np.array([stance.foot for stance in standing]).reshape(-1, 2)
        bases = np.where(_within(bases, box)[:, None], bases, feet)
        bases[~_within(feet, box)] = np.nan
    seen = [k for k, base in enumerate(bases) if np.isfinite(base).all()]
    if not seen:
        return None
    return top_around(
        look.image, edges, [standing[k] for k in seen], bases[seen], look.covered, clicks, box
    )


def _within(places: FloatArray, box: tuple[float, float, float, float]) -> BoolArray:
    """(N,) whether places (N, 2) lie in a box (left, top, right, bottom), pixels."""
    return np.asarray(((places > box[:2]) & (places < box[2:])).all(1))


def said(state: SceneState) -> list[str]:
    """Sentences about tables that are known by name alone."""
    return [
        f"{item.name} is known by the sentence alone: its height is a usual one, and where none of"
        " its edges is seen, so is its size"
        for item in unclicked(state)
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
