"""The wire: retries, what servers take, bounds, cancelling, and what the key never reaches."""

from __future__ import annotations

import builtins
import json
import logging
import threading
import time
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

from physagent_studio.agent.vlm import wire
from physagent_studio.agent.vlm.config import Limits, Patience
from physagent_studio.agent.vlm.line import Line
from physagent_studio.agent.vlm.messages import (
    BudgetSpent,
    Invalid,
    Picture,
    Question,
    Turn,
    Unreachable,
)
from physagent_studio.agent.vlm.spending import CallLog, CallRecord, Ledger
from physagent_studio.errors import BackendMissing, Cancelled, InputError
from tests.agent.vlm.server import Asked, Model, ModelServer, Reply, failing, says

Serve = Callable[[Model], ModelServer]
Connect = Callable[..., Line]
SCHEMA = {"type": "object", "properties": {}, "required": [], "additionalProperties": False}
KEY = "sk-test-0123456789abcdef"


def question(*parts: str | Picture) -> Question:
    return Question("test.ask", (Turn("user", parts or ("Say {}.",)),), "Empty", SCHEMA)


def test_what_is_sent_is_a_chat_completion(
    serve: Serve, connect: Connect, calls: list[CallRecord]
) -> None:
    server = serve(lambda asked: says("{}", usage=(12, 3)))
    line = connect(server, key=KEY, temperature=0.5, max_output_tokens=77)
    red = np.zeros((20, 30, 3), np.uint8)
    red[..., 0] = 255
    answer = line.ask(question("Look.", Picture(red, "a red field")))
    asked = server.asked[0]
    assert answer.text == "{}"
    assert asked.path == "/v1/chat/completions"
    assert asked.headers["authorization"] == f"Bearer {KEY}"
    assert asked.body["model"] == "scripted"
    assert asked.body["temperature"] == 0.5
    assert asked.body["max_tokens"] == 77
    assert asked.body["response_format"]["json_schema"]["schema"] == SCHEMA
    assert asked.pictures[0].startswith("data:image/jpeg;base64,")
    assert "Picture: a red field" in asked.text("user")
    call = calls[0]
    assert (call.outcome, call.tokens_in, call.tokens_out, call.estimated) == ("ok", 12, 3, False)


@pytest.mark.parametrize("status", [408, 409, 429, 500, 502, 503])
def test_what_may_pass_is_tried_again(
    status: int, serve: Serve, connect: Connect, calls: list[CallRecord]
) -> None:
    server = serve(lambda asked: failing(status) if asked.number < 2 else says("{}"))
    assert connect(server).ask(question()).text == "{}"
    assert [call.outcome for call in calls] == [f"http {status}"] * 2 + ["ok"]
    assert [call.attempt for call in calls] == [1, 2, 3]


def test_retries_end_and_every_attempt_is_recorded(
    serve: Serve, connect: Connect, calls: list[CallRecord]
) -> None:
    server = serve(lambda asked: failing(500, "the fan is broken"))
    with pytest.raises(Unreachable, match="HTTP 500: the fan is broken"):
        connect(server).ask(question())
    assert len(calls) == len(server.asked) == 3


def test_waits_grow_and_a_server_may_ask_for_longer(
    serve: Serve, connect: Connect, monkeypatch: pytest.MonkeyPatch
) -> None:
    waited: list[float] = []
    monkeypatch.setattr(
        "physagent_studio.agent.vlm.line.wait", lambda seconds, cancelled: waited.append(seconds)
    )
    headers: list[dict[str, str]] = [{}, {}, {"Retry_After": "7"}, {"Retry_After": "9999"}]
    server = serve(lambda asked: failing(429, **headers[min(asked.number, 3)]))
    with pytest.raises(Unreachable):
        connect(server, patience=Patience(retries=4, backoff=0.5)).ask(question())
    assert waited == [0.5, 1.0, 7.0, 60.0]


@pytest.mark.parametrize("status", [400, 401, 403, 404])
def test_what_will_not_pass_is_not_tried_again(status: int, serve: Serve, connect: Connect) -> None:
    server = serve(lambda asked: failing(status))
    line = connect(server)
    line.rung = 2
    with pytest.raises(Unreachable):
        line.ask(question())
    assert len(server.asked) == 1


def test_a_server_without_structured_output_is_asked_for_less(
    serve: Serve, connect: Connect
) -> None:
    def model(asked: Asked) -> Reply:
        plain = asked.format == "text"
        return says("Here: ```json\n{}\n```") if plain else failing(400, "unknown response_format")

    server = serve(model)
    line = connect(server)
    line.ask(question())
    line.ask(question())
    # It learns once and does not ask for more again.
    # And where no schema is enforced, the model reads it.
    assert json.dumps(SCHEMA) in server.asked[-1].text("system")
    assert json.dumps(SCHEMA) not in server.asked[0].text("system")
    formats = [asked.format for asked in server.asked]
    assert formats == ["json_schema", "json_object", "text", "text"]


def test_a_model_that_wants_another_name_for_the_limit_gets_it(
    serve: Serve, connect: Connect
) -> None:
    def model(asked: Asked) -> Reply:
        if "max_tokens" in asked.body:
            return failing(400, "use 'max_completion_tokens' instead")
        return says("{}")

    server = serve(model)
    connect(server).ask(question())
    assert server.asked[1].body["max_completion_tokens"] == 8000
    assert server.asked[1].format == "json_schema"


def test_a_reply_in_parts_is_one_text(serve: Serve, connect: Connect) -> None:
    parts = [{"type": "text", "text": "{"}, {"type": "text", "text": "}"}]
    message = {"role": "assistant", "content": parts}
    body = json.dumps({"choices": [{"message": message}]}).encode()
    answer = connect(serve(lambda asked: Reply(body=body))).ask(question())
    assert (answer.text, answer.usage.estimated) == ("{}", True)


def test_a_redirect_is_not_followed(serve: Serve, connect: Connect) -> None:
    other = serve(lambda asked: says("{}"))
    location = {"Location": f"{other.url}/chat/completions"}
    server = serve(lambda asked: Reply(307, b"", location))
    with pytest.raises(Unreachable, match="redirects to"):
        connect(server, key=KEY).ask(question())
    assert other.asked == []


def test_a_body_without_end_is_cut_off(
    serve: Serve, connect: Connect, calls: list[CallRecord]
) -> None:
    server = serve(lambda asked: says("z" * 5_000_000))
    with pytest.raises(Invalid, match="larger than 2000000 bytes"):
        connect(server).ask(question())
    assert calls[0].outcome == "too large"
    assert calls[0].estimated
    assert calls[0].tokens_in > 0


def test_a_reply_that_drips_meets_the_whole_timeout(serve: Serve, connect: Connect) -> None:
    server = serve(lambda asked: Reply(body=b"{" * 10_000, drip=0.02))
    with pytest.raises(Unreachable, match=r"did not answer within 0\.3 s"):
        connect(server, patience=Patience(timeout=0.3, retries=0)).ask(question())


@pytest.mark.parametrize(("total", "tries"), [(600.0, 2), (0.5, 1)])
def test_a_server_that_drips_is_tried_once_more_and_not_when_all_the_time_is_over(
    total: float, tries: int, serve: Serve, connect: Connect, calls: list[CallRecord]
) -> None:
    server = serve(lambda asked: Reply(body=b"{" * 10_000, drip=0.02))
    patience = Patience(timeout=0.5, total=total, retries=10, backoff=0.1)
    with pytest.raises(Unreachable, match=r"did not answer within 0\.5 s"):
        connect(server, patience=patience).ask(question())
    # The server may have worked for each, so that each counts.
    assert [(call.outcome, call.estimated) for call in calls] == [("timeout", True)] * tries
    assert len(server.asked) == tries


@pytest.mark.parametrize("reply", [Reply(wait=60.0), Reply(body=b"{" * 10_000, drip=0.05)])
def test_cancelling_frees_the_caller_at_once(
    reply: Reply, serve: Serve, connect: Connect, calls: list[CallRecord]
) -> None:
    cancel = threading.Event()
    server = serve(lambda asked: reply)
    line = connect(server, cancelled=cancel.is_set, patience=Patience(timeout=600, retries=0))
    began: list[float] = []

    def stop() -> None:
        server.wait_for(1)
        began.append(time.monotonic())
        cancel.set()

    threading.Thread(target=stop, daemon=True).start()
    with pytest.raises(Cancelled):
        line.ask(question())
    # Hundreds of seconds were left; the bound of half a second has room for a busy machine.
    assert time.monotonic() - began[0] < 60
    assert [call.outcome for call in calls] == ["cancelled"]
    # Nobody knows whether it was billed, so it counts.
    assert line.ledger.calls == 1


def test_cancelling_ends_the_thread_too(serve: Serve, connect: Connect) -> None:
    cancel = threading.Event()
    server = serve(lambda asked: Reply(wait=60.0))
    line = connect(server, cancelled=cancel.is_set, patience=Patience(timeout=600, retries=0))
    threading.Thread(target=lambda: (server.wait_for(1), cancel.set()), daemon=True).start()
    with pytest.raises(Cancelled):
        line.ask(question())
    for thread in threading.enumerate():
        if thread.name == "vlm-call":
            thread.join(timeout=20)
            assert not thread.is_alive()


def test_cancelling_between_retries(serve: Serve, connect: Connect) -> None:
    cancelled = iter([False] * 8 + [True] * 1000)
    server = serve(lambda asked: failing(500))
    line = connect(
        server, cancelled=lambda: next(cancelled), patience=Patience(retries=5, backoff=60)
    )
    with pytest.raises(Cancelled):
        line.ask(question())
    assert len(server.asked) == 1


def test_a_limit_stops_before_anything_is_sent(serve: Serve, connect: Connect) -> None:
    server = serve(lambda asked: says("{}"))
    line = connect(server, limits=Limits(calls=2))
    line.ask(question())
    line.ask(question())
    with pytest.raises(BudgetSpent, match="2 calls"):
        line.ask(question())
    assert len(server.asked) == 2


def test_a_ledger_counts_what_an_earlier_one_spent(calls: list[CallRecord]) -> None:
    record = CallRecord(
        at="now", role="planner", purpose="p", model="m", host="h", key="k", attempt=1,
        outcome="ok", seconds=1, tokens_in=900, tokens_out=100, money=0.5,
    )  # fmt: skip
    ledger = Ledger.of(Limits(tokens=1000), [record])
    assert (ledger.calls, ledger.tokens, ledger.money) == (1, 1000, 0.5)
    with pytest.raises(BudgetSpent, match="1000 tokens"):
        ledger.check()


def test_the_log_is_one_line_a_call(
    serve: Serve, connect: Connect, tmp_path: Any, calls: list[CallRecord]
) -> None:
    log = CallLog(tmp_path / "deep" / "calls.jsonl")
    line = connect(serve(lambda asked: says("{}")), prices={"input": 2, "output": 10})
    line.record = log
    line.ask(question())
    line.ask(question())
    assert [call.money for call in log.read()] == [0.0004] * 2
    assert log.path.stat().st_mode & 0o077 == 0
    with log.path.open("ab") as stream:
        stream.write(b'{"at": "cut sho')
    assert len(log.read()) == 2


def test_a_log_that_cannot_be_written_is_said(
    serve: Serve, connect: Connect, tmp_path: Any
) -> None:
    line = connect(serve(lambda asked: says("{}")))
    line.record = CallLog(tmp_path)
    with pytest.raises(InputError, match="the log of calls"):
        line.ask(question())


def test_the_key_is_nowhere_but_in_the_request(
    serve: Serve,
    connect: Connect,
    calls: list[CallRecord],
    caplog: pytest.LogCaptureFixture,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """Even where the server repeats it in every answer, and all logging is on."""
    monkeypatch.setenv("OPENAI_LOG", "debug")
    caplog.set_level(logging.DEBUG)
    echo = f"Incorrect API key provided: {KEY}"
    replies = [failing(500, echo), Reply(302, b"", {"Location": f"/{KEY}"}), failing(401, echo)]
    server = serve(lambda asked: replies[min(asked.number, 2)])
    line = connect(server, key=KEY)
    texts = [repr(line), str(line.endpoint), line.endpoint.model_dump_json()]
    for _ in range(2):
        with pytest.raises(Unreachable) as caught:
            line.ask(question())
        texts += [str(caught.value), repr(caught.value)]
        assert caught.value.__cause__ is None
        assert caught.value.__suppress_context__
    texts += [call.model_dump_json() for call in calls] + [caplog.text]
    assert server.asked[0].headers["authorization"] == f"Bearer {KEY}"
    for text in texts:
        assert KEY not in text


def test_without_the_sdk_one_sentence_says_what_to_install(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    real = builtins.__import__

    def without(name: str, *args: Any, **options: Any) -> Any:
        if name == "openai":
            raise ModuleNotFoundError("No module named 'openai'")
        return real(name, *args, **options)

    monkeypatch.setattr(builtins, "__import__", without)
    with pytest.raises(BackendMissing, match=r'pip install "physagent-studio\[vlm\]"'):
        wire.check_installed()
