"""What the photo's tools look for: candidate masks, and ways along edges; in a process apart, whose
crash or hang fails that alone.

The process keeps a desk of its own for every one here, so that what was found serves again.
"""

import itertools
import threading
import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import lru_cache
from types import MappingProxyType
from typing import Any

from physagent_studio.jobs import Executor, Limits, hearing
from physagent_studio.jobs.executor import never, quiet
from physagent_studio.program import Grounding
from physagent_studio.reconstruction.learned.at_hand import learned_here
from physagent_studio.reconstruction.masks.intelligent_scissors import LiveEdge
from physagent_studio.reconstruction.masks.segmenter import (
    EmbeddedSegmenter,
    Meanwhile,
    apart,
    choose,
)
from physagent_studio.reconstruction.masks.stacks import METHOD, alone, companions
from physagent_studio.reconstruction.photo.regions import BoolArray, iou
from physagent_studio.reconstruction.survey.marked import known_candidates
from physagent_studio.records import Candidate, Image, Scene
from physagent_studio.studio.panels.outline import path_of
from physagent_studio.workbench.boundary import guarded

Groundings = list[tuple[str, Grounding]]
KEPT = 12
"""Things of which the candidates are kept."""
EARLY = 0.35
"""Seconds after which a person is shown what there is, while better masks are sought."""
SAME = 0.75
"""IoU from which a mask that was shown early is one that was found in the end, if refined."""


class PhotoDesk:
    """What the tools keep between two questions: candidates of the last clicks, the last anchor.

    Lives in a process of its own, which one thread asks.
    """

    def __init__(self) -> None:
        self._image: Image | None = None
        self._offers: dict[str, tuple[Grounding, tuple[Candidate, ...]]] = {}
        self._last: tuple[Groundings, Groundings, dict[str, tuple[Candidate, ...]]] = ([], [], {})
        self._edge: LiveEdge | None = None

    def masks(
        self,
        image: Image,
        name: str,
        said: Groundings,
        known: Mapping[str, tuple[Candidate, ...]] = MappingProxyType({}),
        whole: bool = True,
        stop: Callable[[], bool] | None = None,
        early: Callable[[dict[str, Any]], None] | None = None,
    ) -> dict[str, Any]:
        """The masks on offer for a name, best first, its strokes applied.

        whole: whether what all clicks on a stack give together is waited for; without it, `more`
        says that it is still to be found. stop: whether nobody waits any more.
        known: candidates that were found when the picture was reconstructed, and still fit.
        candidate: what the grounding has to say to mean a mask. layer: whether the mask is a layer
        of a stack, which all clicks on the stack give together, and the grounding means of itself.
        early: called with what there is after a moment, where finding takes longer; `now` is then
        the index at which each of these masks is in the end, -1 where it is not any more.
        """
        grounding, asked = dict(said)[name], time.monotonic()
        shown: list[BoolArray] = []

        def meanwhile(key: str, offers: Callable[[], tuple[Candidate, ...]]) -> None:
            late = key == name and not shown and time.monotonic() - asked > EARLY
            if early is None or not late or (stop is not None and stop()):
                return
            found = offers()
            shown.extend(_masks_of(image, name, grounding, found))
            answer = {"name": name, "masks": _told(found, shown), "more": False, "early": True}
            early(answer)

        more = not whole and len(companions(said, name)) > 1
        together = (name, *(companions(said, name) if whole else ()))
        offers = self._offers_of(image, name, said, known, together, stop, meanwhile)
        masks = _masks_of(image, name, grounding, offers)
        answer = {"name": name, "masks": _told(offers, masks), "more": more}
        return answer | ({"now": [_place(mask, masks) for mask in shown]} if shown else {})

    def _offers_of(
        self,
        image: Image,
        name: str,
        said: Groundings,
        known: Mapping[str, tuple[Candidate, ...]],
        together: tuple[str, ...],
        stop: Callable[[], bool] | None,
        meanwhile: Meanwhile,
    ) -> tuple[Candidate, ...]:
        """Candidates from a thing's own clicks, led by its layer where it is one of a stack.

        together: the things that are looked for, that one and what is in its stack.
        """
        if self._image is not image:
            self._image, self._offers, self._last = image, {}, ([], [], {})
        wanted = [(key, own) for key, own in said if key in together]
        own = {key: grounding for key, grounding in apart(said) if key in together}
        if self._last[:2] == (wanted, list(own.items())):
            return self._last[2][name]
        known = {key: alone(found) for key, found in known.items()}
        for key, (grounding, found) in self._offers.items():
            if own.get(key) == grounding:
                known[key] = found
        segmenter = EmbeddedSegmenter(learned=learned_here())
        offers = segmenter.completed(image, wanted, known, stop, said, meanwhile)
        if stop is not None and stop():
            return offers[name]
        for key, grounding in own.items():
            self._offers.pop(key, None)
            self._offers[key] = (grounding, alone(offers[key]))
        for key in list(self._offers)[:-KEPT]:
            del self._offers[key]
        self._last = (wanted, list(own.items()), offers)
        return offers[name]

    def way(self, image: Image, start: tuple[float, float], end: tuple[float, float]) -> Any:
        """The way along edges, as points."""
        if self._edge is None or self._edge.image is not image:
            self._edge = LiveEdge(image)
        return {"points": [[round(x, 1), round(y, 1)] for x, y in self._edge.way(start, end)]}


def _masks_of(
    image: Image, name: str, grounding: Grounding, offers: Sequence[Candidate]
) -> list[BoolArray]:
    """(H, W) each candidate as it is if it is chosen, with the strokes of the grounding."""
    out = []
    for index in range(len(offers)):
        chosen = grounding.model_copy(update={"candidate": index})
        shape = (image.shape[0], image.shape[1])
        out.append(choose({name: tuple(offers)}, [(name, chosen)], shape, image)[name])
    return out


def _told(offers: Sequence[Candidate], masks: Sequence[BoolArray]) -> list[dict[str, Any]]:
    """Candidates and their masks as the page hears of them."""
    out = []
    for index, (offer, mask) in enumerate(zip(offers, masks, strict=True)):
        own = index - (offers[0].method == METHOD)
        out.append(
            {
                "path": path_of(mask),
                "score": round(offer.score, 3),
                "candidate": max(own, 0),
                "layer": offer.method == METHOD,
            }
        )
    return out


def _place(mask: BoolArray, masks: Sequence[BoolArray]) -> int:
    """The index of the mask that is most like this one; -1 where none is the same."""
    alike = [iou(mask, other) for other in masks]
    best = max(range(len(alike)), key=alike.__getitem__, default=-1)
    return best if best >= 0 and alike[best] >= SAME else -1


LOOKING = Limits(120.0, 3 * 2**30)
"""The slowest click takes 4 s and half a gigabyte; what takes thirty times that hangs."""
MODULES = (__name__, "physagent_studio.rendering")
"""What a process for these tasks, and for small pictures, imports before the first one comes."""
DESKS = 6
"""Of the open session, of four browsers with a photo that is no session yet, and one to spare."""
_numbers = itertools.count()


class DeskApart:
    """A photo desk, wherever its executor has it."""

    def __init__(self, executor: Executor) -> None:
        self._executor, self._number = executor, next(_numbers)

    def masks(
        self,
        image: Image,
        name: str,
        said: Groundings,
        scene: Scene | None = None,
        whole: bool = True,
        stop: Callable[[], bool] | None = None,
        early: Callable[[dict[str, Any]], None] | None = None,
    ) -> dict[str, Any]:
        """As `PhotoDesk.masks`; scene: what was reconstructed of the picture."""
        known = known_candidates(scene, said)
        return self._executor.submit(
            _masks,
            *(self._number, image, name, said, known, whole, early is not None),
            limits=LOOKING,
            cancelled=stop or never,
            tell=early or quiet,
        )

    def way(self, image: Image, start: tuple[float, float], end: tuple[float, float]) -> Any:
        """The way along edges, as points."""
        return self._executor.submit(_way, self._number, image, start, end, limits=LOOKING)


@lru_cache(maxsize=DESKS)
def _desk(_number: int) -> PhotoDesk:
    return PhotoDesk()


def _masks(
    number: int,
    image: Image,
    name: str,
    said: Groundings,
    known: Mapping[str, tuple[Candidate, ...]],
    whole: bool,
    early: bool,
) -> dict[str, Any]:
    cancelled, tell = hearing()
    return _desk(number).masks(image, name, said, known, whole, cancelled, tell if early else None)


def _way(
    number: int, image: Image, start: tuple[float, float], end: tuple[float, float]
) -> dict[str, Any]:
    return _desk(number).way(image, start, end)


Tell = Callable[[int, str, dict[str, Any]], None]
"""Browser, channel, what was found; called on the finder's thread."""


@dataclass(frozen=True, eq=False, slots=True)
class _Question:
    ticket: int
    finds: tuple[Callable[[], dict[str, Any]], ...]


class Finder:
    """One thread that answers browsers; every answer carries the ticket of its question."""

    def __init__(self, tell: Tell) -> None:
        self._tell = tell
        self._news = threading.Condition()
        self._asked: dict[tuple[int, str], _Question] = {}
        self._open = True
        self._thread = threading.Thread(target=self._work, name="finder", daemon=True)
        self._thread.start()

    def ask(self, browser: int, channel: str, ticket: int, *finds: Callable[[], Any]) -> None:
        """Has `finds` called soon, one after the other, unless something newer is asked before.

        Each one's answer is sent at once; the next is only called where it says that there is
        `more`.
        """
        with self._news:
            self._asked.pop((browser, channel), None)
            self._asked[browser, channel] = _Question(ticket, finds)
            self._news.notify()

    def tell_early(self, browser: int, channel: str, ticket: int, found: dict[str, Any]) -> None:
        """Sends what there is of an answer while its question is looked into; from any thread."""
        if not self.overtaken(browser, channel):
            self._tell(browser, channel, {"ticket": ticket, **found})

    def stop(self) -> None:
        """Ends the thread once the question at hand is answered."""
        with self._news:
            self._open = False
            self._news.notify()
        self._thread.join(timeout=10)

    def _work(self) -> None:
        while True:
            with self._news:
                self._news.wait_for(lambda: self._asked or not self._open)
                if not self._open:
                    return
                browser, channel = next(iter(self._asked))
                question = self._asked.pop((browser, channel))
            for find in question.finds:
                found = guarded(find, lambda text: {"problem": text}, "a search")
                self._tell(browser, channel, {"ticket": question.ticket, **found})
                if not found.get("more") or self.overtaken(browser, channel):
                    break

    def overtaken(self, browser: int, channel: str) -> bool:
        """Whether nobody waits for what is being looked for any more."""
        with self._news:
            return not self._open or (browser, channel) in self._asked
