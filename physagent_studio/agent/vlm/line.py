"""`Line`: a role's connection to its model, with retries, budget, records and the tape."""

import json
import time
from collections.abc import Callable
from dataclasses import dataclass
from datetime import UTC, datetime
from typing import Any

from physagent_studio.agent.vlm import wire
from physagent_studio.agent.vlm.config import Endpoint
from physagent_studio.agent.vlm.messages import (
    Answer,
    Invalid,
    Part,
    Question,
    Unreachable,
    Usage,
    prompt,
)
from physagent_studio.agent.vlm.pictures import data_url
from physagent_studio.agent.vlm.spending import CallRecord, Ledger, price
from physagent_studio.agent.vlm.tape import Tape
from physagent_studio.agent.vlm.wire import wait
from physagent_studio.errors import Cancelled
from physagent_studio.records.loop_state import RoleName
from physagent_studio.rendering.sheets import fitted

FORMATS = ("json_schema", "json_object", "text")
LONGEST_WAIT = 60.0
MOST_WORDS = 400
MOST_BILLED = 1
"""Further attempts where the server has worked for nothing: one that drips or lies goes on so."""


@dataclass(frozen=True, slots=True)
class Answers:
    """Answers that have arrived, by question: found again where a phase was cut short."""

    find: Callable[[str], dict[str, Any] | None]
    keep: Callable[[str, dict[str, Any]], None]

    def found(self, key: str) -> Answer | None:
        """The answer to that question."""
        data = self.find(key)
        if data is None:
            return None
        return Answer(data["text"], data["finish"], data["refusal"], Usage(*data["usage"]))

    def arrived(self, key: str, answer: Answer, hide: str) -> None:
        """Keeps an answer, on the disk when this returns; `hide` is a secret to be left out."""
        said = {name: getattr(answer, name) for name in ("text", "finish", "refusal")}
        said = {name: text.replace(hide, "***") if hide else text for name, text in said.items()}
        usage = answer.usage
        self.keep(key, {**said, "usage": [usage.input, usage.output, usage.estimated]})


@dataclass
class Line:
    """Sends questions and brings answers. One per role; the ledger is shared.

    record: is told of every call. rung: which of `FORMATS` the server has proved to take.
    cap: the name under which it takes a limit on the reply; newer models want another one.
    """

    role: RoleName
    endpoint: Endpoint
    ledger: Ledger
    cancelled: Callable[[], bool] = lambda: False
    record: Callable[[CallRecord], None] = lambda record: None
    tape: Tape | None = None
    rung: int = 0
    cap: str = "max_tokens"
    kept: Answers | None = None

    def ask(self, question: Question) -> Answer:
        """The model's answer.

        Raises:
            Invalid: the server worked, but what came is no answer that could be read.
            BudgetSpent, Unreachable, TapeMiss: there will be none.
            Cancelled: the person cancelled.
        """
        recorded = self.tape.find(question, self.endpoint.model) if self.tape else None
        if recorded is not None:
            self._note(question, 0, "replayed", Usage())
            return recorded
        key = question.key(self.endpoint.model)
        if self.kept is not None and (known := self.kept.found(key)) is not None:
            self._note(question, 0, "replayed", Usage())
            return known
        answer = self._send(question)
        if self.kept is not None:
            self.kept.arrived(key, answer, self.endpoint.secret)
        if self.tape is not None:
            self.tape.keep(question, self.endpoint.model, answer, self.endpoint.secret)
        return answer

    def _send(self, question: Question) -> Answer:
        """One answer, trying again what may pass and stepping down in what is asked for."""
        tries, began, patience = 0, time.monotonic(), self.endpoint.patience
        while True:
            try:
                return self._once(question, tries)
            except wire.WireFailure as failure:
                if self._asks_for_less(failure):
                    continue
                text = self.redacted(failure.detail)
                if failure.outcome == "too large":
                    raise Invalid(text) from None
                tries += 1
                own = patience.backoff * 2 ** (tries - 1)
                pause = min(LONGEST_WAIT, max(own, failure.wait or 0.0))
                spent = time.monotonic() - began + pause
                most = min(patience.retries, MOST_BILLED) if failure.billed else patience.retries
                if not failure.passing or tries > most or spent > patience.total:
                    raise Unreachable(text) from None
                wait(pause, self.cancelled)

    def _asks_for_less(self, failure: wire.WireFailure) -> bool:
        """Whether the request is worth repeating in a form that older or newer servers take."""
        if failure.status not in (400, 415, 422, 501):
            return False
        if self.cap == "max_tokens" and "max_completion_tokens" in failure.detail:
            self.cap = "max_completion_tokens"
            return True
        if self.rung < len(FORMATS) - 1:
            # A server without structured output says no to the whole request.
            self.rung += 1
            return True
        return False

    def _once(self, question: Question, tries: int) -> Answer:
        self.ledger.check()
        if self.cancelled():
            raise Cancelled("cancelled")
        payload = self._payload(question)
        guess = _guess(question)
        began = time.monotonic()
        try:
            answer = wire.send(self.endpoint, payload, self.cancelled)
        except wire.WireFailure as failure:
            used = Usage(guess, 0, True) if failure.billed else Usage()
            self._note(question, tries, failure.outcome, used, began, failure.detail)
            raise
        except Cancelled:
            self._note(question, tries, "cancelled", Usage(guess, 0, True), began)
            raise
        if answer.usage.estimated:
            spoken = len(answer.text) // 3
            answer = Answer(answer.text, answer.finish, answer.refusal, Usage(guess, spoken, True))
        self._note(question, tries, "ok", answer.usage, began)
        return answer

    def _payload(self, question: Question) -> dict[str, Any]:
        endpoint = self.endpoint
        messages: list[dict[str, Any]] = [
            {"role": turn.role, "content": self._content(turn.parts)} for turn in question.turns
        ]
        payload: dict[str, Any] = {"model": endpoint.model, "messages": messages}
        if endpoint.temperature is not None:
            payload["temperature"] = endpoint.temperature
        if endpoint.max_output_tokens is not None:
            payload[self.cap] = endpoint.max_output_tokens
        kind = FORMATS[self.rung]
        if kind == "json_schema":
            form = {"name": question.form, "schema": question.schema, "strict": True}
            payload["response_format"] = {"type": kind, "json_schema": form}
            return payload
        if kind == "json_object":
            payload["response_format"] = {"type": kind}
        # Nothing else tells the model what is wanted.
        form = prompt("form", schema=json.dumps(question.schema))
        messages.insert(1, {"role": "system", "content": form})
        return payload

    def _content(self, parts: tuple[Part, ...]) -> str | list[dict[str, Any]]:
        if all(isinstance(part, str) for part in parts):
            return "\n\n".join(str(part) for part in parts)
        content: list[dict[str, Any]] = []
        for part in parts:
            if isinstance(part, str):
                content.append({"type": "text", "text": part})
            else:
                url = data_url(fitted(part.pixels, self.endpoint.picture_side))
                content.append({"type": "text", "text": f"Picture: {part.label}"})
                content.append({"type": "image_url", "image_url": {"url": url, "detail": "high"}})
        return content

    def redacted(self, text: str) -> str:
        """The text without the key, should a server or a library repeat it."""
        secret = self.endpoint.secret
        return text.replace(secret, "***") if secret else text

    def _note(
        self,
        question: Question,
        tries: int,
        outcome: str,
        usage: Usage,
        began: float | None = None,
        detail: str = "",
    ) -> None:
        entry = CallRecord(
            at=datetime.now(UTC).isoformat(timespec="milliseconds"),
            role=self.role,
            purpose=question.purpose,
            model=self.endpoint.model,
            host=self.endpoint.host,
            key=question.key(self.endpoint.model),
            attempt=tries + 1,
            outcome=outcome,
            seconds=0.0 if began is None else round(time.monotonic() - began, 3),
            tokens_in=usage.input,
            tokens_out=usage.output,
            estimated=usage.estimated,
            money=price(usage, self.endpoint.prices),
            detail=self.redacted(detail)[:MOST_WORDS],
        )
        self.ledger.add(entry)
        self.record(entry)


def _guess(question: Question) -> int:
    """Tokens of a question, roughly: three characters each, and a picture by its tiles."""
    total = 0
    for turn in question.turns:
        for part in turn.parts:
            total += len(part) // 3 if isinstance(part, str) else 1500
    return total + len(str(question.schema)) // 3
