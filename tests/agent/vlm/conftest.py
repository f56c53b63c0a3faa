"""Settings and lines for the VLM tests; no test sees the environment of the person who runs it."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterator
from contextlib import ExitStack
from pathlib import Path

import pytest

from physagent_studio.agent.vlm.config import Endpoint, Limits, Patience
from physagent_studio.agent.vlm.line import Line
from physagent_studio.agent.vlm.spending import CallRecord, Ledger
from physagent_studio.records.loop_state import RoleName
from tests.agent.vlm.server import Model, ModelServer

QUICK = Patience(timeout=30.0, retries=2, backoff=0.0)


@pytest.fixture(autouse=True)
def _clean_environment(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    for name in list(os.environ):
        if name.startswith(("PHYSAGENT_VLM", "OPENAI_")) or name.lower().endswith("_proxy"):
            monkeypatch.delenv(name)
    monkeypatch.setenv("PHYSAGENT_VLM_CONFIG", str(tmp_path / "none.yaml"))


@pytest.fixture
def serve() -> Iterator[Callable[[Model], ModelServer]]:
    """Starts servers that live as long as the test."""
    with ExitStack() as stack:
        yield lambda model: stack.enter_context(ModelServer(model))


@pytest.fixture
def calls() -> list[CallRecord]:
    """What the lines of `connect` have recorded."""
    return []


@pytest.fixture
def connect(calls: list[CallRecord]) -> Callable[..., Line]:
    """A line to a server. Keywords go to the endpoint, but `limits`, `cancelled` and `role`."""

    def make(
        server: ModelServer,
        *,
        role: RoleName = "planner",
        limits: Limits | None = None,
        ledger: Ledger | None = None,
        cancelled: Callable[[], bool] = lambda: False,
        patience: Patience = QUICK,
        **fields: object,
    ) -> Line:
        endpoint = Endpoint.model_validate(
            {"base_url": server.url, "model": "scripted", "patience": patience, **fields}
        )
        return Line(role, endpoint, ledger or Ledger(limits or Limits()), cancelled, calls.append)

    return make
