"""What the photo's tools look for, in a process apart, whose crash or hang fails that alone.

The process keeps a desk of its own for every one here, so that what was found serves again.
"""

from __future__ import annotations

import itertools
from collections.abc import Callable, Mapping
from functools import lru_cache
from typing import Any

from physagent_studio.jobs import Executor, Limits, hearing
from physagent_studio.jobs.executor import never, quiet
from physagent_studio.reconstruction.survey.marked import known_candidates
from physagent_studio.records import Candidate, Image, Scene
from physagent_studio.studio.photo_desk import Groundings, PhotoDesk

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
