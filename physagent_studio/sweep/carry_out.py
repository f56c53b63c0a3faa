"""Carries out the runs of a sweep: each once, again where its worker dies, none that is known."""

from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import FIRST_EXCEPTION, ThreadPoolExecutor, wait
from threading import Event, Lock

from physagent_studio.errors import Cancelled, StudioError
from physagent_studio.jobs import Executor, JobFailed
from physagent_studio.jobs.executor import never, quiet
from physagent_studio.sweep.plan import Point
from physagent_studio.sweep.run import LIMITS, Ran, ran

ATTEMPTS = 5
"""How often a run is begun whose worker breaks down: a node that goes away takes several with it,
and what breaks down every time does so by itself."""


def carry_out(
    points: Iterable[Point],
    executor: Executor,
    done: Callable[[Point, Ran], None],
    *,
    known: Callable[[str], bool] = lambda key: False,
    cancelled: Callable[[], bool] = never,
    task: Callable[..., Ran] = ran,
) -> None:
    """Runs every different program of the points; `done` hears of each once, one at a time.

    As many at a time as the executor is wide; points are made as they are needed, so that memory
    does not grow with their number. known: whether the run of a key is there already. Raises
    Cancelled, within a second of being so, and what `done` raises.
    """
    one, ended, fresh = Lock(), Event(), _fresh(points, known)

    def over() -> bool:
        return ended.is_set() or cancelled()

    def go_on() -> None:
        while not over():
            with one:
                point = next(fresh, None)
            if point is None:
                return
            found = _attempted(point, executor, task, over)
            with one:
                done(point, found)

    if executor.width == 1:
        go_on()
    else:
        _side_by_side(go_on, executor.width, ended)
    if cancelled():
        raise Cancelled("cancelled")


def results(
    points: Iterable[Point],
    executor: Executor,
    cancelled: Callable[[], bool] = never,
    tell: Callable[[int], None] = quiet,
) -> dict[str, Ran]:
    """The runs of points by key, in memory; `tell` hears how many there are."""
    found: dict[str, Ran] = {}

    def done(point: Point, ran: Ran) -> None:
        found[point.key] = ran
        tell(len(found))

    carry_out(points, executor, done, cancelled=cancelled)
    return found


def _side_by_side(work: Callable[[], None], width: int, ended: Event) -> None:
    """On threads, each of which waits for one worker; where one fails the others end."""
    with ThreadPoolExecutor(width) as threads:
        running = [threads.submit(work) for _ in range(width)]
        try:
            wait(running, return_when=FIRST_EXCEPTION)
        finally:
            ended.set()
    errors = [error for one in running if (error := one.exception()) is not None]
    # That the others were ended is no reason of its own.
    for error in sorted(errors, key=lambda error: isinstance(error, Cancelled)):
        raise error


def _fresh(points: Iterable[Point], known: Callable[[str], bool]) -> Iterator[Point]:
    """Each program once: what two points have in common is begun for the first of them."""
    begun: set[str] = set()
    for point in points:
        if point.key not in begun and not known(point.key):
            begun.add(point.key)
            yield point


def _attempted(
    point: Point, executor: Executor, task: Callable[..., Ran], over: Callable[[], bool]
) -> Ran:
    """The run of a point; why there is none where it cannot be run."""
    target, problem, lost = point.target, point.problem, False
    for _ in range(ATTEMPTS if point.program else 0):
        values = (point.program, target.scene.meshes, target.drawn)
        try:
            return executor.submit(task, *values, limits=LIMITS, cancelled=over)
        except Cancelled:
            raise
        except StudioError as error:
            problem, lost = str(error), isinstance(error, JobFailed) and error.reason == "crash"
            if not lost:
                break
    return Ran(problem=problem, lost=lost)
