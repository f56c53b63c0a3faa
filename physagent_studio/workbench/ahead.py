"""Trials that a search is likely to ask for, made on cores that have nothing else to do.

What a trial comes to does not depend on where it is made, or on whether it was begun ahead: cores
make a search faster and change nothing else.
"""

import threading
import time
from collections.abc import Callable, Sequence
from concurrent.futures import Future, ThreadPoolExecutor
from dataclasses import dataclass, field

from physagent_studio.agent.roles import Trial
from physagent_studio.program import PhysicalProgram
from physagent_studio.records import Scene

Run = Callable[[PhysicalProgram, Scene, Callable[[], bool]], Trial]
"""Tries a program on a scene, until it is told that nobody wants that any more."""
Then = Callable[[], Sequence[PhysicalProgram]]
WORTH_SECONDS = 1.0
"""Of waiting for trials, after which another process is started: that takes two and a half."""
POLL_SECONDS = 0.05
"""Between two looks at whether a person has cancelled."""


@dataclass(eq=False)
class _Job:
    """dropped: whether nobody wants it any more."""

    program: PhysicalProgram
    scene: Scene
    future: Future[Trial] | None = None
    dropped: threading.Event = field(default_factory=threading.Event)


@dataclass(eq=False)
class Lane:
    """What runs one trial at a time. open: waits until it can begin at once."""

    run: Run
    open: Callable[[], None]
    threads: ThreadPoolExecutor = field(default_factory=lambda: ThreadPoolExecutor(1, "trial"))


class Lanes:
    """Hands out trials, the one that is waited for first. The first lane is open from the start,
    the others when a search turns out to be long. What was begun ahead and is no longer likely is
    told to end."""

    def __init__(self, lanes: Sequence[Lane], check: Callable[[], None]) -> None:
        """check: raises `Cancelled` where a person has cancelled."""
        self._free, self._closed = [lanes[0]], list(lanes[1:])
        self._check = check
        self._waited = 0.0
        self._jobs: list[_Job] = []
        self._awaited: _Job | None = None
        self._news = threading.Condition()

    def take(self, scene: Scene, program: PhysicalProgram, then: Then) -> Trial:
        """What a program does; raises what its trial raises.

        then: asked while that goes on for what may be wanted next, likeliest first.
        """
        began = time.monotonic()
        job = self._asked(scene, program)
        if not _is_done(job):
            self._want(scene, then())
        with self._news:
            while (future := job.future) is None or not future.done():
                self._news.wait(POLL_SECONDS)
                self._check()
            self._awaited = None
        self._open_where_worth(time.monotonic() - began)
        return future.result()

    def _asked(self, scene: Scene, program: PhysicalProgram) -> _Job:
        """The job that is waited for from now on, which goes before all others."""
        with self._news:
            job = next((one for one in self._jobs if one.program is program), None)
            # Where another one was foreseen, what was to follow will hardly do so either.
            others = self._jobs if job else [one for one in self._jobs if one.future is not None]
            job = self._awaited = job or _Job(program, scene)
            self._jobs = [job]
            self._hand_out()
            self._jobs += [one for one in others if one is not job]
        return job

    def give_up(self) -> None:
        """Nothing is wanted any more."""
        with self._news:
            for job in self._jobs:
                job.dropped.set()
            self._jobs, self._awaited = [], None

    def _want(self, scene: Scene, programs: Sequence[PhysicalProgram]) -> None:
        """What is likely from now on; what was begun and is not makes room for it."""
        with self._news:
            likely = {id(one) for one in programs}
            for job in self._jobs:
                # What has ended already takes no room.
                if not (job is self._awaited or _is_done(job) or id(job.program) in likely):
                    job.dropped.set()
            kept = [
                job
                for job in self._jobs
                if job is self._awaited or (job.future and not job.dropped.is_set())
            ]
            new = [one for one in programs if all(one is not job.program for job in kept)]
            self._jobs = [*kept, *(_Job(one, scene) for one in new)]
            self._hand_out()

    def _hand_out(self) -> None:
        """Begins what is wanted and not begun, as long as there is a lane for it."""
        for job in self._jobs:
            if job.future is None and self._free:
                lane = self._free.pop()
                job.future = lane.threads.submit(
                    lane.run, job.program, job.scene, job.dropped.is_set
                )
                job.future.add_done_callback(lambda _, lane=lane: self._freed(lane))

    def _freed(self, lane: Lane) -> None:
        with self._news:
            self._free.append(lane)
            if self._awaited is not None and not _is_done(self._awaited):
                # Else the search will say what it wants now that it has its answer.
                self._hand_out()
            self._news.notify_all()

    def _open_where_worth(self, seconds: float) -> None:
        """Opens the other lanes once so much has been waited for that it will pay."""
        self._waited += seconds
        if self._waited < WORTH_SECONDS:
            return
        for lane in self._closed:
            opened = lane.threads.submit(lane.open)
            opened.add_done_callback(lambda _, lane=lane: self._freed(lane))
        self._closed = []


def _is_done(job: _Job) -> bool:
    return job.future is not None and job.future.done()


@dataclass(frozen=True, eq=False, slots=True)
class Ahead:
    """The trials of one scene."""

    lanes: Lanes
    scene: Scene

    def take(self, program: PhysicalProgram, then: Then = tuple) -> Trial:
        """See `Lanes.take`."""
        return self.lanes.take(self.scene, program, then)

    def give_up(self) -> None:
        """See `Lanes.give_up`."""
        self.lanes.give_up()
