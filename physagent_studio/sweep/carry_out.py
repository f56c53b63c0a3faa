"""Carries out the runs of a sweep: each once, again where its worker dies, none that is known."""

from __future__ import annotations

import threading
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass, field

from physagent_studio.errors import Cancelled, StudioError
from physagent_studio.jobs import Executor, JobFailed
from physagent_studio.sweep.plan import Point
from physagent_studio.sweep.run import LIMITS, Ran, ran
from physagent_studio.sweep.store import Store

ATTEMPTS = 5
"""How often a run is begun whose worker breaks down: a node that goes away takes several with it,
and what breaks down every time does so by itself."""

Task = Callable[..., Ran]
Tell = Callable[[Point, Ran], None]


def carry_out(
    points: Iterable[Point],
    executor: Executor,
    done: Callable[[Point, Ran], None],
    *,
    known: Callable[[str], bool] = lambda key: False,
    cancelled: Callable[[], bool] = lambda: False,
    task: Task = ran,
) -> None:
    """Runs every different program of the points; `done` hears of each once, one at a time.

    As many at a time as the executor is wide; points are made as they are needed, so that memory
    does not grow with their number. known: whether the run of a key is there already. Raises
    Cancelled, within a second of being so, and what `done` raises.
    """
    work = _Work(_unknown(points, known), executor, done, cancelled, task)
    if executor.width == 1:
        work.go_on()
    else:
        work.side_by_side(executor.width)
    if work.failed:
        raise work.failed[0]
    if cancelled():
        raise Cancelled("cancelled")


def into(store: Store, tell: Callable[[], None] = lambda: None) -> Callable[[Point, Ran], None]:
    """What `carry_out` tells when runs are kept in a folder."""

    def done(point: Point, found: Ran) -> None:
        store.add(point.key, found)
        tell()

    return done


def _unknown(points: Iterable[Point], known: Callable[[str], bool]) -> Iterator[Point]:
    """Each program once: what two points have in common is begun for the first of them."""
    begun: set[str] = set()
    for point in points:
        key = point.key
        if key not in begun and not known(key):
            begun.add(key)
            yield point


@dataclass
class _Work:
    """What the threads share; each waits for one worker."""

    points: Iterator[Point]
    executor: Executor
    done: Callable[[Point, Ran], None]
    cancelled: Callable[[], bool]
    task: Task
    failed: list[BaseException] = field(default_factory=list)
    _one: threading.Lock = field(default_factory=threading.Lock)
    _ended: threading.Event = field(default_factory=threading.Event)

    def side_by_side(self, width: int) -> None:
        """Until all is done, or this thread is interrupted."""
        threads = [threading.Thread(target=self.go_on, daemon=True) for _ in range(width)]
        for thread in threads:
            thread.start()
        try:
            for thread in threads:
                thread.join()
        finally:
            self._ended.set()
            for thread in threads:
                thread.join()

    def go_on(self) -> None:
        """One run after the other, until none is left or one of the threads has failed."""
        try:
            while (point := self._next()) is not None:
                found = self._attempted(point)
                with self._one:
                    self.done(point, found)
        # Broad on purpose: whatever ends a thread is raised where all of them are waited for.
        except BaseException as error:  # noqa: BLE001
            self.failed.append(error)
            self._ended.set()

    def _next(self) -> Point | None:
        with self._one:
            return None if self._over() else next(self.points, None)

    def _over(self) -> bool:
        return self._ended.is_set() or self.cancelled()

    def _attempted(self, point: Point) -> Ran:
        """The run of a point; why there is none where it cannot be run."""
        target, problem, lost = point.target, point.problem, False
        for _ in range(ATTEMPTS if point.program else 0):
            values = (point.program, target.meshes, target.drawn)
            try:
                return self.executor.submit(self.task, *values, limits=LIMITS, cancelled=self._over)
            except Cancelled:
                raise
            except JobFailed as error:
                problem = f"it was ended: {error}"
                lost = error.reason == "crash"
                if not lost:
                    break
            except StudioError as error:
                problem, lost = str(error), False
                break
        return Ran(problem=problem, lost=lost)
