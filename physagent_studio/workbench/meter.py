"""What a session has cost so far: time of work, calls to a model, their tokens and money."""

from __future__ import annotations

from dataclasses import dataclass

from physagent_studio.agent.vlm import CallRecord, Ledger, Limits
from physagent_studio.session import Session

WORKED = "worked_seconds"


@dataclass(frozen=True, slots=True)
class Spending:
    """seconds: of work, waiting for the model included. waited: s of these for the model.

    calls, tokens, money: of the model, with the limits that stop it; None without a limit.
    money is in the currency of the configured prices; 0 without prices.
    """

    seconds: float = 0.0
    waited: float = 0.0
    calls: int = 0
    tokens: int = 0
    money: float = 0.0
    most_calls: int | None = None
    most_tokens: int | None = None
    most_money: float | None = None


class Meter:
    """Adds up one session; reads only what has come to its log since the last reading."""

    def __init__(self, session: Session, limits: Limits | None = None) -> None:
        self._session = session
        self._ledger = Ledger(limits or Limits())
        self._limited = limits is not None
        self._seen = 0
        self._waited = 0.0

    def add_work(self, seconds: float) -> None:
        """Counts time of work, for good."""
        self._session.note(WORKED, f"{self._worked() + seconds:.3f}")

    def read(self) -> Spending:
        """Everything up to now."""
        for number, payload in self._session.log_after(self._seen, "model call"):
            call = CallRecord.model_validate(payload)
            self._ledger.add(call)
            self._waited += 0.0 if call.outcome == "replayed" else call.seconds
            self._seen = number
        ledger, limits = self._ledger, self._ledger.limits
        return Spending(
            seconds=self._worked(),
            waited=self._waited,
            calls=ledger.calls,
            tokens=ledger.tokens,
            money=ledger.money,
            most_calls=limits.calls if self._limited else None,
            most_tokens=limits.tokens if self._limited else None,
            most_money=limits.money if self._limited else None,
        )

    def _worked(self) -> float:
        return float(self._session.meta(WORKED) or 0.0)
