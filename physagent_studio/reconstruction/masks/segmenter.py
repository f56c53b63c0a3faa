"""Masks from clicks and boxes: several methods offer candidates, the objects compete.

Every object gets up to four candidate masks, best first, so that a person can take another
one. Everything is seeded: the same picture and clicks give the same bits.
"""

from collections.abc import Callable, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, replace
from typing import Protocol

import numpy as np

from physagent_studio.knowledge.things import usual_size
from physagent_studio.program.scene.state import Click, Grounding, Stroke
from physagent_studio.reconstruction.learned.at_hand import NOTHING, Learned
from physagent_studio.reconstruction.masks.box_drafts import found_in
from physagent_studio.reconstruction.masks.competition import compete
from physagent_studio.reconstruction.masks.draft_score import Draft
from physagent_studio.reconstruction.masks.learned_offers import ranked_together
from physagent_studio.reconstruction.masks.round_outlines import rounder_first
from physagent_studio.reconstruction.masks.stacks import stacked, stacks_of
from physagent_studio.reconstruction.masks.strokes import corrected, covered, drawn, seeds_of
from physagent_studio.reconstruction.masks.task import (
    View,
    full_size,
    part_around,
    task_of,
    view_of,
)
from physagent_studio.reconstruction.masks.thing_map import (
    FloatArray,
    ThingMap,
    expected_iou,
    extent_of,
    seen_in,
    thing_map,
)
from physagent_studio.reconstruction.photo.regions import BoolArray
from physagent_studio.reconstruction.switches import at_work
from physagent_studio.records.case import Image
from physagent_studio.records.scene import Candidate


@dataclass(frozen=True, slots=True)
class SegmenterSettings:
    """On what masks are sought, and what is none."""

    view_side_px: int = 240  # 120..640: the longer side of the part that drafts are found on
    min_mask_px: int = 12  # 4..100: what is left below it when others took theirs is no mask
    min_left_share: float = 0.03  # 0..0.2: of what it had, likewise
    # 0..0.4: of its longer side: around what its clicks show a stack may go on
    stack_margin_ratio: float = 0.1
    # 0.004..0.05: radius of the spot that stands for a lost mask, of the picture's longer side
    spot_ratio: float = 0.012


SEGMENTER = SegmenterSettings()

Offers = tuple[Candidate, ...]
Cancelled = Callable[[], bool] | None
Meanwhile = Callable[[str, Callable[[], Offers]], None]
"""Told of which thing there are candidates to look at while better ones are sought; they are only
brought to size, with their outlines as they are, when they are called for. Called from the threads
that seek."""


class Segmenter(Protocol):
    """Turns clicks and boxes into candidate masks, best first, for each named thing."""

    def segment(
        self, image: Image, groundings: Sequence[tuple[str, Grounding]], cancelled: Cancelled = None
    ) -> dict[str, Offers]: ...


@dataclass(frozen=True, slots=True)
class EmbeddedSegmenter:
    """A network's map of the thing, and drafts by colour and contour that agree with it.

    Each thing is segmented by itself, from what `apart` says of it. learned: models whose masks
    are ranked among these.
    """

    side: int = SEGMENTER.view_side_px
    learned: Learned = NOTHING

    def segment(
        self, image: Image, groundings: Sequence[tuple[str, Grounding]], cancelled: Cancelled = None
    ) -> dict[str, Offers]:
        """Candidates (H, W) at the size of `image`; empty where nothing was clicked."""
        return self.completed(image, groundings, {}, cancelled)

    def completed(
        self,
        image: Image,
        groundings: Sequence[tuple[str, Grounding]],
        known: Mapping[str, Offers],
        cancelled: Cancelled = None,
        among: Sequence[tuple[str, Grounding]] = (),
        meanwhile: Meanwhile | None = None,
    ) -> dict[str, Offers]:
        """The candidates of all that is grounded, with those that only all clicks together give.

        known: candidates from a thing's own clicks that need not be sought again. among: all that
        is marked in the picture, where `groundings` are but some of it. Things are sought two at a
        time, and what all clicks on a stack mean beside them. Some are missing once cancelled.
        meanwhile: told what is found before the end.
        """
        asked = [one for one in apart(among or groundings) if one[0] not in known]
        wanted = {name for name, _ in groundings}

        def found(name: str, own: Grounding) -> Offers:
            offers = () if stopped() else self.candidates(image, name, own, meanwhile)
            if meanwhile is not None and offers and self.learned.there:
                meanwhile(name, lambda: offers)
            return offers if stopped() else ranked_together(offers, self.learned.masks(image, own))

        def whole(stack: Grounding) -> BoolArray | None:
            return None if stopped() else self._whole(image, stack)

        def stopped() -> bool:
            return cancelled is not None and cancelled()

        with ThreadPoolExecutor(2) as pool:
            fresh = {n: pool.submit(found, n, own) for n, own in asked if n in wanted}
            wholes = {stack: pool.submit(whole, stack) for stack in stacks_of(groundings)}
            offers = {n: fresh[n].result() if n in fresh else known[n] for n, _ in groundings}
            return stacked(image, groundings, offers, lambda stack: wholes[stack].result())

    def candidates(
        self, image: Image, name: str, grounding: Grounding, meanwhile: Meanwhile | None = None
    ) -> Offers:
        """Candidates (H, W) of one thing whose grounding says all.

        meanwhile: told of them before their outlines are settled at the size of the picture.
        """
        best = self._best(image, grounding)
        if not best:
            return ()
        if meanwhile is not None:
            meanwhile(name, lambda: tuple(full_size(image, *one, settled=False) for one in best))
        with ThreadPoolExecutor(2) as pool:
            offers = tuple(pool.map(lambda one: full_size(image, *one), best))
        is_ball = usual_size(name).shapes == ("sphere",) and at_work("round masks")
        return rounder_first(offers) if is_ball else offers

    def _whole(self, image: Image, grounding: Grounding) -> BoolArray | None:
        """(H, W) all layers of a stack that are marked together; None where nothing is found.

        The map of each click by itself, since the network knows of one thing at a time. Such a map
        ends above the layers that were not clicked, and agrees best with itself: cuts lead.
        """
        if grounding.box is not None:
            best = self._best(image, grounding)
        else:
            maps = [thing_map(image, Grounding(points=(click,))) for click in grounding.points]
            every = np.maximum.reduce([one.chance for one in maps if one is not None])
            best = self._around(image, grounding, every) if (every > 0.5).any() else []
            best.sort(key=lambda one: one[0][0].family == "map")
        return full_size(image, *best[0]).mask if best else None

    def _around(
        self, image: Image, grounding: Grounding, chance: FloatArray
    ) -> list[tuple[tuple[Draft, float], View]]:
        """What is found in a box a little wider than a map, which may end above the last layer."""
        x0, y0, x1, y1 = extent_of(chance, grounding, image.shape)
        wide = SEGMENTER.stack_margin_ratio * max(x1 - x0, y1 - y0)
        box = (x0 - wide, y0 - wide, x1 + wide, y1 + wide)
        seen = thing_map(image, Grounding(box=box))
        every = chance if seen is None else np.maximum(chance, seen.chance)
        return self._found(image, grounding.model_copy(update={"box": box}), ThingMap(every, 1.0))

    def _best(self, image: Image, grounding: Grounding) -> list[tuple[tuple[Draft, float], View]]:
        """What looks like the places that were marked, best first, as it is on a view of them."""
        seen = thing_map(image, grounding)
        if seen is None:
            return []
        return self._found(image, grounding, seen, tight=_is_tight(grounding))

    def _found(
        self, image: Image, grounding: Grounding, seen: ThingMap, *, tight: bool = False
    ) -> list[tuple[tuple[Draft, float], View]]:
        """The same by a map of the thing. Clicks become a box around what it shows."""
        box = extent_of(seen.chance, grounding, image.shape)
        view = view_of(image, part_around(box, image.shape), self.side)
        task = replace(task_of(grounding.model_copy(update={"box": box}), view), tight=tight)
        maps = [seen_in(one, view, image.shape) for one in (seen.chance, *seen.looks)]
        found = found_in(view, task, maps, seen.agreement * expected_iou(seen.chance))
        return [(one, view) for one in found]


def _is_tight(own: Grounding) -> bool:
    """Whether a person drew a box around the thing and left all of it in: what a click inside the
    box holds out may have reached its sides."""
    if own.box is None:
        return False
    return not any(_within(own.box, click) for click in own.points if not click.label)


def _within(box: tuple[float, float, float, float], click: Click) -> bool:
    (left, right), (top, low) = sorted((box[0], box[2])), sorted((box[1], box[3]))
    return left < click.x < right and top < click.y < low


def apart(groundings: Sequence[tuple[str, Grounding]]) -> list[tuple[str, Grounding]]:
    """Groundings that each say all that matters for their mask.

    Clicks inside the other things lie outside of this one, unless its mask is settled; what lies
    outside of a box that was drawn around it needs no click to say so. What only
    matters after the candidates are there (the choice, strokes beside clicks) is left out.
    """
    out: list[tuple[str, Grounding]] = []
    for name, own in groundings:
        points = list(own.points)
        if own.box is None and not any(click.label for click in points):
            points += [Click(x=x, y=y, label=1 if i else 0) for x, y, i in seeds_of(own.strokes)]
        if not own.settled and at_work("clicks of others"):
            points += [
                Click(x=click.x, y=click.y, label=0)
                for other, grounding in groundings
                if other != name
                for click in grounding.points
                if click.label and (own.box is None or _within(own.box, click))
            ]
        # The order of clicks outside says nothing.
        inside = [click for click in points if click.label]
        outside = sorted({(click.x, click.y) for click in points if not click.label})
        kept = (*inside, *(Click(x=x, y=y, label=0) for x, y in outside))
        out.append((name, Grounding(points=kept[:500], box=own.box, settled=True)))
    return out


def settled(name: str, groundings: Sequence[tuple[str, Grounding]]) -> Grounding:
    """The grounding of that name with everything in it that its mask depends on.

    Clicks on other things that come later do not change it any more.
    """
    own = dict(groundings)[name]
    points = own.points
    if own.shows_something and not own.settled:
        said = {(click.x, click.y) for click in points}
        others = dict(apart(groundings))[name].points
        points += tuple(c for c in others if not c.label and (c.x, c.y) not in said)
    return own.model_copy(update={"points": points[:500], "settled": True, "proposed": False})


def choose(
    candidates: Mapping[str, Offers],
    groundings: Sequence[tuple[str, Grounding]],
    shape: tuple[int, int],
    image: Image | None = None,
) -> dict[str, BoolArray]:
    """The chosen candidate of each object with its strokes, after competition.

    shape: (H, W) of the masks. image: the picture, whose edges the strokes' surroundings snap to.
    """
    picked: dict[str, BoolArray] = {}
    owned: dict[str, BoolArray] = {}
    for name, grounding in groundings:
        offers = candidates.get(name, ())
        index = min(grounding.candidate, len(offers) - 1)
        mask = offers[index].mask if offers else np.zeros(shape, bool)
        picked[name] = corrected(image, mask, grounding.strokes)
        if grounding.strokes:
            owned[name] = drawn(grounding.strokes, shape).inside
    boxes = {name: own.box for name, own in groundings if own.box is not None}
    masks = compete(picked, owned, boxes)
    for name, grounding in groundings:
        left, had = np.count_nonzero(masks[name]), np.count_nonzero(picked[name])
        if left < max(SEGMENTER.min_mask_px, SEGMENTER.min_left_share * had) and any(
            click.label for click in grounding.points
        ):
            masks = _with_spot(masks, name, grounding, shape)
    return masks


def _with_spot(
    masks: Mapping[str, BoolArray], name: str, grounding: Grounding, shape: tuple[int, int]
) -> dict[str, BoolArray]:
    """Masks in which a thing that has lost all its pixels keeps a spot at its click.

    It shows where it was clicked, and that it has no mask of its own is told as a finding.
    """
    click = next(c for c in grounding.points if c.label)
    radius = max(4.0, SEGMENTER.spot_ratio * max(shape))
    spot = covered(Stroke(radius=radius, points=((click.x, click.y),)), shape)
    return {other: spot if other == name else mask & ~spot for other, mask in masks.items()}
