"""Masks of what is marked in the picture: candidates of every thing, regions of supports."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace

import numpy as np

from physagent_studio.arrays import BoolArray
from physagent_studio.errors import InputError
from physagent_studio.knowledge import is_solid, support_kind
from physagent_studio.program.scene.state import Grounding, SceneState, Support
from physagent_studio.reconstruction.masks.segmenter import EmbeddedSegmenter, Segmenter, apart
from physagent_studio.reconstruction.masks.stacks import alone
from physagent_studio.reconstruction.masks.strokes import corrected
from physagent_studio.reconstruction.masks.surface_region import with_surface
from physagent_studio.reconstruction.supports import clicked as clicked_supports
from physagent_studio.records.case import Case, Image
from physagent_studio.records.scene import Candidate, Scene


def candidates_of(
    case: Case,
    state: SceneState,
    previous: Scene | None,
    segmenter: Segmenter,
    tick: Callable[[], None],
    cancelled: Callable[[], bool] | None,
) -> dict[str, tuple[Candidate, ...]]:
    """Candidates of objects and of clicked supports; reused where no click changed."""
    assert case.image is not None
    tasks = _clicked(state)
    for name, grounding in tasks:
        height, width = case.image.shape[:2]
        for click in grounding.points:
            if not (0 <= click.x < width and 0 <= click.y < height):
                raise InputError(
                    f"the click ({click.x:g}, {click.y:g}) on '{name}' lies outside the picture"
                    f" of {width} × {height} pixels"
                )
    for item in state.objects:
        wanted = item.shape is None or item.position is None
        if wanted and not item.grounding.shows_something:
            raise InputError(f"'{item.name}' is not marked in the photo: click it, or draw a box")
    kept = known_candidates(previous, tasks)
    known = kept
    if len(known) < len(tasks) and isinstance(segmenter, EmbeddedSegmenter):
        known = segmenter.completed(case.image, tasks, known, cancelled)
    elif len(known) < len(tasks):
        fresh = segmenter.segment(case.image, tasks, cancelled)
        known = {name: fresh.get(name, known.get(name, ())) for name, _ in tasks}
    tick()
    tops = {
        item.name
        for item in state.supports
        if support_kind(item.name) == "slab" and not is_solid(item.name)
    }
    boxes = {item.name: item.grounding.box for item in state.supports if item.name in tops}
    return {
        name: _within(with_surface(case.image, own, known[name]), boxes[name])
        if name in tops and name not in kept
        else known[name]
        for name, own in apart(tasks)
    }


def _within(
    offers: tuple[Candidate, ...], box: tuple[float, float, float, float] | None
) -> tuple[Candidate, ...]:
    """Candidates of a surface (H, W), none of them larger than the box that a person drew."""
    if box is None:
        return offers
    left, top, right, bottom = (round(value) for value in box)
    inside = np.zeros_like(offers[0].mask)
    inside[max(top, 0) : bottom, max(left, 0) : right] = True
    cut = tuple(replace(one, mask=one.mask & inside) for one in offers)
    return tuple(one for one in cut if one.mask.any()) or offers


def _clicked(state: SceneState) -> list[tuple[str, Grounding]]:
    tasks = [(item.name, item.grounding) for item in state.objects]
    tasks += [
        (item.name, _as_clicked(item))
        for item in state.supports
        if item.grounding.shows_something and support_kind(item.name) in ("slab", "ramp")
    ]
    return tasks


def _as_clicked(item: Support) -> Grounding:
    """How a support is looked for: a box around a table has its legs in it too, so that its clicks
    say more."""
    if support_kind(item.name) == "slab" and item.grounding.points:
        return item.grounding.model_copy(update={"box": None})
    return item.grounding


def known_candidates(
    previous: Scene | None, tasks: Sequence[tuple[str, Grounding]]
) -> dict[str, tuple[Candidate, ...]]:
    """Candidates of an earlier scene, of the things for whose masks nothing has changed."""
    if previous is None:
        return {}
    before = dict(apart(_clicked(previous.state)))
    said = dict(tasks)
    return {
        name: alone(previous.candidates[name]) if said[name].settled else previous.candidates[name]
        for name, own in apart(tasks)
        if before.get(name) == own and name in previous.candidates
    }


def regions_of(
    state: SceneState,
    image: Image,
    candidates: Mapping[str, tuple[Candidate, ...]],
    masks: Mapping[str, BoolArray],
) -> dict[str, BoolArray]:
    """Masks of the clicked supports, without the objects in front of them."""
    out: dict[str, BoolArray] = {}
    size = next((mask.shape for mask in masks.values()), (0, 0))
    for item in state.supports:
        offers = candidates.get(item.name, ())
        marked = clicked_supports.region_of(item, (size[0], size[1]))
        if marked is not None:
            out[item.name] = marked & ~np.any(list(masks.values()), axis=0)
        if marked is not None or not offers or support_kind(item.name) != "slab":
            continue
        chosen = offers[min(item.grounding.candidate, len(offers) - 1)].mask
        region = corrected(image, chosen, item.grounding.strokes).copy()
        for mask in masks.values():
            region &= ~mask
        out[item.name] = region
    return out
