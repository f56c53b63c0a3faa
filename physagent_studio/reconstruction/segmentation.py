"""Masks from clicks and boxes: several methods offer candidates, the objects compete.

Every object gets up to four candidate masks, best first, so that a person can take another
one. Everything is seeded: the same picture and clicks give the same bits.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from concurrent.futures import Executor, ThreadPoolExecutor
from dataclasses import dataclass
from typing import Protocol

import numpy as np

from physagent_studio.program.scene import Click, Grounding, Stroke
from physagent_studio.reconstruction.masks import BoolArray
from physagent_studio.reconstruction.maskscore import Draft, Scorer
from physagent_studio.reconstruction.names import usual_size
from physagent_studio.reconstruction.segmentation_attached import led_by, with_attached
from physagent_studio.reconstruction.segmentation_box import box_drafts
from physagent_studio.reconstruction.segmentation_choice import agreed
from physagent_studio.reconstruction.segmentation_clicks import Cutting, begun, click_drafts
from physagent_studio.reconstruction.segmentation_closeup import (
    EARLY,
    Look,
    is_doubtful,
    merged,
    piece_around,
)
from physagent_studio.reconstruction.segmentation_ranking import ranked
from physagent_studio.reconstruction.segmentation_stack import stacked, stacks_of
from physagent_studio.reconstruction.segmentation_task import (
    Task,
    View,
    full_size,
    looks_for_poles,
    part_around,
    task_of,
    view_of,
)
from physagent_studio.reconstruction.strokes import corrected, covered, drawn, seeds_of
from physagent_studio.records.case import Image
from physagent_studio.records.scene import Candidate

SIDE = 240
"""Longest side in pixels of the picture on which candidates are found."""


LEAST, LOST = 12, 0.03
"""Pixels, and share of what it had before others took theirs, below which a mask is none."""
SPOT = 0.012
"""Radius of the spot in its place, as a share of the picture's longer side."""


class Segmenter(Protocol):
    """Turns clicks and boxes into candidate masks, best first, for each named thing."""

    def segment(
        self,
        image: Image,
        groundings: Sequence[tuple[str, Grounding]],
        cancelled: Callable[[], bool] | None = None,
    ) -> dict[str, tuple[Candidate, ...]]: ...


@dataclass(frozen=True, slots=True)
class EmbeddedSegmenter:
    """GrabCut at several scales, the contour of greatest contrast, and their agreement.

    Each thing is segmented by itself, from what `apart` says of it.
    """

    side: int = SIDE

    def segment(
        self,
        image: Image,
        groundings: Sequence[tuple[str, Grounding]],
        cancelled: Callable[[], bool] | None = None,
    ) -> dict[str, tuple[Candidate, ...]]:
        """Candidates (H, W) at the size of `image`; empty where nothing was clicked."""
        return self.completed(image, groundings, {}, cancelled)

    def completed(
        self,
        image: Image,
        groundings: Sequence[tuple[str, Grounding]],
        known: Mapping[str, tuple[Candidate, ...]],
        cancelled: Callable[[], bool] | None = None,
        among: Sequence[tuple[str, Grounding]] = (),
    ) -> dict[str, tuple[Candidate, ...]]:
        """The candidates of all that is grounded, with those that only all clicks together give.

        known: candidates from a thing's own clicks that need not be sought again. among: all that
        is marked in the picture, where `groundings` are but some of it. Things are sought two at a
        time, and what all clicks on a stack mean beside them. Some are missing once cancelled.
        """
        asked = [one for one in apart(among or groundings) if one[0] not in known]
        wanted = {name for name, _ in groundings}

        def found(name: str, own: Grounding) -> tuple[Candidate, ...]:
            return () if stopped() else self.candidates(image, name, own)

        def whole(stack: Grounding) -> BoolArray | None:
            return None if stopped() else self._whole(image, stack)

        def stopped() -> bool:
            return cancelled is not None and cancelled()

        with ThreadPoolExecutor(2) as pool:
            fresh = {n: pool.submit(found, n, own) for n, own in asked if n in wanted}
            wholes = {stack: pool.submit(whole, stack) for stack in stacks_of(groundings)}
            offers = {n: fresh[n].result() if n in fresh else known[n] for n, _ in groundings}
            return stacked(image, groundings, offers, lambda stack: wholes[stack].result())

    def candidates(self, image: Image, name: str, grounding: Grounding) -> tuple[Candidate, ...]:
        """Candidates (H, W) of one thing whose grounding says all; its name helps to rank them."""
        best = self._best(image, name, grounding)
        if not best:
            return ()
        with ThreadPoolExecutor(2) as pool:
            sized = [pool.submit(full_size, image, *one) for one in best]
            # Parts of the first are sought while the others are still being brought to size.
            first = sized[0].result().mask
            found = with_attached(image, first, grounding, looks_for_poles(name))
            alike = [one.result() for one in sized]
        return led_by(found, alike, usual_size(name).aspect)

    def _whole(self, image: Image, grounding: Grounding) -> BoolArray | None:
        """(H, W) what most looks like all that was clicked; None where nothing does."""
        best = self._best(image, "", grounding)
        return full_size(image, *best[0]).mask if best else None

    def _best(
        self, image: Image, name: str, grounding: Grounding
    ) -> list[tuple[tuple[Draft, float], View]]:
        """What looks like the places that were clicked, each as it is on a view of the picture."""
        if grounding.box is not None:
            view = view_of(image, part_around(grounding.box, image.shape), self.side)
            look = _boxed(view, task_of(name, grounding, view))
            return [(item, view) for item in look.found]
        pool = ThreadPoolExecutor(2)
        piece = piece_around(grounding, image.shape)
        closer: list[_Sight] = []

        def closely() -> None:
            if piece is not None and not closer:
                closer.append(_Sight.of(image, name, grounding, (piece, self.side), pool))

        height, width = image.shape[:2]
        try:
            sight = _Sight.of(image, name, grounding, ((0, 0, width, height), self.side), pool)
            # Cuts of a closer look run while the contours of the first one are still sought.
            look = sight.look(lambda score: closely() if score < EARLY else None)
            if piece is None or not is_doubtful(look):
                return [(item, look.view) for item in look.found]
            closely()
            return merged(look, closer[0].look())
        finally:
            # A closer look that turned out to be of no use is not waited for.
            pool.shutdown(wait=False, cancel_futures=True)


@dataclass(frozen=True, eq=False, slots=True)
class _Sight:
    """A part of the picture with what was clicked there, and the cuts, which have begun."""

    view: View
    task: Task
    cutting: Cutting | None

    @classmethod
    def of(
        cls,
        image: Image,
        name: str,
        grounding: Grounding,
        sized: tuple[tuple[int, int, int, int], int],
        pool: Executor,
    ) -> _Sight:
        """What is seen of a part (x0, y0, x1, y1) brought to so many pixels."""
        part, side = sized
        view = view_of(image, part, side)
        task = task_of(name, grounding, view)
        # What was small on the whole picture does not fill a piece of it.
        whole = (part[2] - part[0], part[3] - part[1]) == (image.shape[1], image.shape[0])
        inside = bool(task.inside)
        cutting = begun(pool, view.small, view.lab, task, filling=whole) if inside else None
        return cls(view, task, cutting)

    def look(self, glimpsed: Callable[[float], None] = lambda score: None) -> Look:
        """What is found, best first. glimpsed: told how good the best of the first drafts is."""
        view, task = self.view, self.task
        if self.cutting is None:
            return Look(view, [])
        scorer = Scorer(view.lab, task.inside)
        drafts = click_drafts(view.small, view.lab, task, scorer, self.cutting, glimpsed)
        return Look(view, agreed(ranked(scorer, drafts, task), view.lab, scorer.likeness))


def _boxed(view: View, task: Task) -> Look:
    """What is found in a person's box."""
    scorer = Scorer(view.lab, task.inside)
    drafts = [] if task.box is None else box_drafts(view.small, view.lab, task, task.box, scorer)
    return Look(view, agreed(ranked(scorer, drafts, task), view.lab, scorer.likeness))


def apart(groundings: Sequence[tuple[str, Grounding]]) -> list[tuple[str, Grounding]]:
    """Groundings that each say all that matters for their mask.

    Clicks inside the other things lie outside of this one, unless its mask is settled. What only
    matters after the candidates are there (the choice, strokes beside clicks) is left out.
    """
    out: list[tuple[str, Grounding]] = []
    for name, own in groundings:
        points = list(own.points)
        if own.box is None and not any(click.label for click in points):
            points += [Click(x=x, y=y, label=1 if i else 0) for x, y, i in seeds_of(own.strokes)]
        if not own.settled:
            points += [
                Click(x=click.x, y=click.y, label=0)
                for other, grounding in groundings
                if other != name
                for click in grounding.points
                if click.label
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


def compete(
    masks: Mapping[str, BoolArray], owned: Mapping[str, BoolArray] | None = None
) -> dict[str, BoolArray]:
    """Every pixel belongs to one object: where masks overlap, the smaller one keeps it.

    owned: pixels that a person gave to an object; no other takes them.
    """
    order = sorted(masks, key=lambda name: int(np.count_nonzero(masks[name])))
    taken: BoolArray | None = None
    out: dict[str, BoolArray] = {}
    given = owned or {}
    for name in order:
        mask = masks[name]
        for other, own in given.items():
            if other != name:
                mask = mask & ~(own & ~given.get(name, np.zeros_like(own)))
        free = mask if taken is None else mask & ~taken
        out[name] = free
        taken = free.copy() if taken is None else taken | free
    return {name: out[name] for name in masks}


def choose(
    candidates: Mapping[str, tuple[Candidate, ...]],
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
    masks = compete(picked, owned)
    for name, grounding in groundings:
        left, had = np.count_nonzero(masks[name]), np.count_nonzero(picked[name])
        if left < max(LEAST, LOST * had) and any(click.label for click in grounding.points):
            masks = _with_spot(masks, name, grounding, shape)
    return masks


def _with_spot(
    masks: Mapping[str, BoolArray], name: str, grounding: Grounding, shape: tuple[int, int]
) -> dict[str, BoolArray]:
    """Masks in which a thing that has lost all its pixels keeps a spot at its click.

    It shows where it was clicked, and that it has no mask of its own is told as a finding.
    """
    click = next(c for c in grounding.points if c.label)
    radius = max(4.0, SPOT * max(shape))
    spot = covered(Stroke(radius=radius, points=((click.x, click.y),)), shape)
    return {other: spot if other == name else mask & ~spot for other, mask in masks.items()}
