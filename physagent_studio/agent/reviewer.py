"""Reviewer policies: who decides on a proposal. None means that a person is asked."""

from dataclasses import dataclass
from datetime import UTC, datetime

from physagent_studio.agent.roles import Reviewer
from physagent_studio.records import Decision, Preview, Proposal

LOW_CONFIDENCE = 0.4


def _now() -> str:
    return datetime.now(UTC).isoformat(timespec="milliseconds")


@dataclass(frozen=True, slots=True)
class Auto:
    """Accepts what can run; stops where the planner is stuck."""

    author: str = "policy:auto"

    def decide(self, proposal: Proposal, preview: Preview) -> Decision | None:
        """Accepts; rejects what cannot run or touches a pinned fact; stops where it is stuck."""
        if not proposal.hunks:
            return Decision(kind="stop", author=self.author, at=_now(), reason=proposal.rationale)
        if proposal.touches_pinned:
            pinned = f"{', '.join(proposal.touches_pinned)} is pinned by a person"
            return Decision(kind="reject", author=self.author, at=_now(), reason=pinned)
        if preview.problem:
            return Decision(kind="reject", author=self.author, at=_now(), reason=preview.problem)
        return Decision(
            kind="accept",
            author=self.author,
            at=_now(),
            reason="accepted by policy",
            hunks=tuple(hunk.id for hunk in proposal.hunks),
            edits=proposal.edits,
        )


@dataclass(frozen=True, slots=True)
class Ask:
    """Leaves every decision to a person; nobody answering means no."""

    def decide(self, proposal: Proposal, preview: Preview) -> Decision | None:
        """Always None."""
        return None


@dataclass(frozen=True, slots=True)
class AskWhen:
    """Decides like `Auto`, but asks where a person's judgement is worth most."""

    low_confidence: float = LOW_CONFIDENCE

    def decide(self, proposal: Proposal, preview: Preview) -> Decision | None:
        """None when unsure, stuck, tripped, at odds with the facts, or touching a kept one."""
        physics = (c for c in preview.checks if c.always_on and c.kind != "view")
        tripped = any(not check.ok for check in physics)
        if (
            not proposal.hunks
            or proposal.confidence < self.low_confidence
            or proposal.touches_verified
            or proposal.touches_pinned
            or proposal.contradiction
            or tripped
        ):
            return None
        return Auto("policy:ask_when").decide(proposal, preview)


POLICIES: dict[str, Reviewer] = {"auto": Auto(), "ask": Ask(), "ask_when": AskWhen()}
