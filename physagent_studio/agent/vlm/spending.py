"""What calls cost: one record per call, a ledger that stops at the limits, a log on the disk."""

from __future__ import annotations

import os
from collections.abc import Iterable
from dataclasses import dataclass, field
from pathlib import Path

from physagent_studio.agent.vlm.config import Limits, Prices
from physagent_studio.agent.vlm.messages import BudgetSpent, Usage
from physagent_studio.errors import InputError
from physagent_studio.program.base import Frozen


class CallRecord(Frozen):
    """One attempt at one call. at: ISO 8601, UTC. key: content hash of what was asked.

    outcome: `ok`, `replayed`, `cancelled`, `timeout`, `too large`, `no connection`, `malformed`
    or `http 429` and the like. estimated: the server named no tokens. money: by the configured
    prices. detail: the server's words, shortened, without the key.
    """

    at: str
    role: str
    purpose: str
    model: str
    host: str
    key: str
    attempt: int
    outcome: str
    seconds: float
    tokens_in: int = 0
    tokens_out: int = 0
    estimated: bool = False
    money: float = 0.0
    detail: str = ""


def price(usage: Usage, prices: Prices | None) -> float:
    """Money for a call; 0 without prices."""
    if prices is None:
        return 0.0
    return (usage.input * prices.input + usage.output * prices.output) / 1e6


@dataclass
class Ledger:
    """Adds up what was spent, over all roles. A limit stops the call after the one that met it."""

    limits: Limits = field(default_factory=Limits)
    calls: int = 0
    tokens: int = 0
    money: float = 0.0

    @classmethod
    def of(cls, limits: Limits, earlier: Iterable[CallRecord] = ()) -> Ledger:
        """A ledger that already counts earlier calls, such as those of a reopened session."""
        ledger = cls(limits)
        for record in earlier:
            ledger.add(record)
        return ledger

    def check(self) -> None:
        """Raises `BudgetSpent` where a limit is reached."""
        limits = self.limits
        if self.calls >= limits.calls:
            raise BudgetSpent(f"the budget of {limits.calls} calls to the model is used up")
        if self.tokens >= limits.tokens:
            raise BudgetSpent(f"the budget of {limits.tokens} tokens is used up ({self.tokens})")
        if limits.money is not None and self.money >= limits.money:
            raise BudgetSpent(f"the budget of {limits.money:g} is used up ({self.money:.4g})")

    def add(self, record: CallRecord) -> None:
        """Counts a call; a replayed one costs nothing."""
        if record.outcome == "replayed":
            return
        self.calls += 1
        self.tokens += record.tokens_in + record.tokens_out
        self.money += record.money


@dataclass(frozen=True, slots=True)
class CallLog:
    """Appends records to a file of JSON lines; readable by the user alone."""

    path: Path

    def __call__(self, record: CallRecord) -> None:
        """Writes one line."""
        try:
            self.path.parent.mkdir(parents=True, exist_ok=True)
            handle = os.open(self.path, os.O_APPEND | os.O_CREAT | os.O_WRONLY, 0o600)
            try:
                os.write(handle, record.model_dump_json().encode() + b"\n")
            finally:
                os.close(handle)
        except OSError as error:
            text = f"the log of calls {self.path} cannot be written: {error.strerror}"
            raise InputError(text) from error

    def read(self) -> tuple[CallRecord, ...]:
        """All whole lines; a last one that a crash cut short is left out."""
        if not self.path.is_file():
            return ()
        lines = self.path.read_bytes().split(b"\n")[:-1]
        return tuple(CallRecord.model_validate_json(line) for line in lines if line.strip())
