"""What a session costs: counted once, kept over a restart, and stopped by nothing here."""

from __future__ import annotations

from pathlib import Path

from physagent_studio.agent.vlm import CallRecord, Limits
from physagent_studio.records import Case, LoopState
from physagent_studio.session import Store
from physagent_studio.workbench.snapshot import Meter

CASE = Case(
    name="x", image=None, image_hash="", objects=(), supports=(), landmarks=(), prompt="It falls."
)


def _call(**more: object) -> dict[str, object]:
    call = CallRecord(
        at="2026-01-01T00:00:00Z", role="verifier", purpose="rollout", model="m", host="h",
        key="k", attempt=1, outcome="ok", seconds=2.0, tokens_in=900, tokens_out=100, money=0.02,
    )  # fmt: skip
    return call.model_copy(update=more).model_dump(mode="json")


def test_calls_and_work_add_up_and_survive(tmp_path: Path) -> None:
    session = Store(tmp_path).create(CASE, LoopState())
    meter = Meter(session, Limits(calls=10, tokens=5000))
    session.record("model call", "m", _call())
    session.record("decision", "person", {"kind": "accept"})
    meter.add_work(1.5)
    first = meter.read()
    assert (first.calls, first.tokens, first.money, first.seconds) == (1, 1000, 0.02, 1.5)
    assert (first.most_calls, first.most_tokens, first.most_money) == (10, 5000, None)
    session.record("model call", "m", _call(outcome="replayed"))
    session.record("model call", "m", _call(outcome="timeout", tokens_in=0, tokens_out=0))
    meter.add_work(0.5)
    second = meter.read()
    assert (second.calls, second.tokens, second.waited, second.seconds) == (2, 1000, 4.0, 2.0)
    session.close()
    again = Meter(Store(tmp_path).open(session.id))
    assert again.read().calls == 2
    assert again.read().seconds == 2.0
    assert again.read().most_calls is None
