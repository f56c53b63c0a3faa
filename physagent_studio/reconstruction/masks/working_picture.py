"""One look at a picture: a part of it brought to working size, and what is found there."""

from __future__ import annotations

from collections.abc import Callable
from concurrent.futures import Executor
from dataclasses import dataclass

from physagent_studio.program.scene.state import Grounding
from physagent_studio.reconstruction.masks.box_drafts import box_drafts
from physagent_studio.reconstruction.masks.choice import agreed
from physagent_studio.reconstruction.masks.click_drafts import Cutting, begun, click_drafts
from physagent_studio.reconstruction.masks.closeup import Look
from physagent_studio.reconstruction.masks.draft_score import Scorer
from physagent_studio.reconstruction.masks.ranking import ranked
from physagent_studio.reconstruction.masks.task import Task, View, task_of, view_of
from physagent_studio.reconstruction.masks.thing_map import weighed
from physagent_studio.records.case import Image


@dataclass(frozen=True, eq=False, slots=True)
class Sight:
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
    ) -> Sight:
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


def boxed(view: View, task: Task) -> Look:
    """What is found in a person's box."""
    scorer = Scorer(view.lab, task.inside)
    drafts = [] if task.box is None else box_drafts(view.small, view.lab, task, task.box, scorer)
    found = weighed(view, task, ranked(scorer, drafts, task))
    return Look(view, agreed(found, view.lab, scorer.likeness))
