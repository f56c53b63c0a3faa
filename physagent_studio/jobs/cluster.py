"""Tasks on a Ray cluster: one on this machine, or the one at an address. Needs the extra `ray`."""

import importlib
import time
from collections import OrderedDict
from collections.abc import Callable
from typing import Any, TypeVar

from physagent_studio.errors import BackendMissing, Cancelled, InputError, StudioError
from physagent_studio.jobs import executor
from physagent_studio.jobs.processes import PATIENCE, START_SECONDS

Result = TypeVar("Result")
POLL_SECONDS = 0.05
"""Between two looks at whether a task is done or cancelled."""
SHARED_VALUES = 64
"""Values (meshes of scenes) that the cluster keeps for tasks that are asked with them again."""


class Cluster:
    """Carries out tasks in Ray's workers; every node needs this package and what it needs.

    A task hears of no cancellation and tells of no progress: who cancels has its worker ended.
    Ray is trusted with what comes back, as every machine of the cluster is. Limits: time is that of
    the clock; memory is Ray's own matter.
    """

    def __init__(self, address: str = "", cores: int | None = None) -> None:
        """address: of a cluster, such as `auto` or `ray://head:10001`; "" starts one here.

        cores: of the one that is started here, else all. Raises BackendMissing without Ray.
        """
        try:
            self._ray: Any = importlib.import_module("ray")
        except ImportError as error:
            raise BackendMissing(
                "the executor `ray` needs Ray: pip install 'physagent-studio[ray]'; without it"
                " there are inline and processes"
            ) from error
        here = {"num_cpus": cores, "include_dashboard": False}
        options = {"address": address} if address else here
        try:
            self._ray.init(log_to_driver=False, logging_level="error", **options)
        except (ConnectionError, ValueError, RuntimeError) as error:
            raise InputError(f"there is no Ray cluster at '{address}': {error}") from error
        # What a task breaks is begun again by who asked for it, who counts.
        self._remote = self._ray.remote(_carried_out).options(max_retries=0)
        self._shared: OrderedDict[int, tuple[Any, Any]] = OrderedDict()
        self.width = max(int(self._ray.cluster_resources().get("CPU", 1)), 1)

    def submit(
        self,
        task: Callable[..., Result],
        *values: Any,
        limits: executor.Limits = executor.Limits(),  # noqa: B008
        cancelled: Callable[[], bool] = executor.never,
        tell: executor.Tell = executor.quiet,
    ) -> Result:
        """The task's result; raises as `Processes.submit` does."""
        until = time.monotonic() + START_SECONDS + PATIENCE * limits.seconds
        reference = self._remote.remote(task, *(self._known(value) for value in values))
        try:
            while not self._ray.wait([reference], timeout=POLL_SECONDS)[0]:
                if cancelled():
                    raise Cancelled("cancelled")
                if time.monotonic() > until:
                    raise executor.JobFailed("time", limits)
            kind, found = self._ray.get(reference)
        except self._ray.exceptions.RayError as error:
            raise executor.JobFailed("crash", limits, type(error).__name__) from error
        except StudioError:
            self._ray.cancel(reference, force=True)
            raise
        if (failure := executor.failure_of(kind, found, task, limits)) is not None:
            raise failure
        return found

    def _known(self, value: Any) -> Any:
        """A mapping (meshes by name) goes to the cluster once, for all tasks that are asked it."""
        if not hasattr(value, "keys"):
            return value
        # The value is kept as well: an id is only its own while it is there.
        kept = self._shared.get(id(value)) or (value, self._ray.put(dict(value)))
        self._shared[id(value)] = kept
        while len(self._shared) > SHARED_VALUES:
            self._shared.popitem(last=False)
        return kept[1]

    def close(self) -> None:
        """Leaves the cluster; one that was started here ends."""
        self._ray.shutdown()


def _carried_out(task: Callable[..., Any], *values: Any) -> tuple[str, Any]:
    """On a worker: what a process of ours would answer; values that the cluster keeps are there."""
    return executor.answer_of(task, values)
