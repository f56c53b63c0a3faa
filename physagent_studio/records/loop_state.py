"""`LoopState`: the reflection loop as it is stored, with its rounds and who decides."""

from collections.abc import Iterable
from typing import Literal, get_args

from physagent_studio.program.base import Frozen
from physagent_studio.program.program import PhysicalProgram
from physagent_studio.records.judgement import Lesson, Round

Phase = Literal[
    "generate", "reconstruct", "simulate", "judge", "propose", "ease", "decide", "revise", "done"
]
Outcome = Literal["realised", "budget", "stopped", "stuck", "running"]
PolicyName = Literal["auto", "ask", "ask_when"]
RoleName = Literal["generator", "verifier", "planner"]
ROLES: tuple[RoleName, ...] = get_args(RoleName)


class LoopState(Frozen):
    """The whole state of the reflection loop, stored after every phase.

    rounds: all rounds of the tree, in order of creation. head: the round being worked on.
    draft: a person's program that has not become a round yet; the next round runs it.
    budget: how many rounds the path may have before the loop ends by itself.
    by_hand: roles that a person plays; the loop waits where one of them is to act.
    lessons: of earlier sessions, given when this one began.
    """

    rounds: tuple[Round, ...] = ()
    head: str | None = None
    phase: Phase = "generate"
    outcome: Outcome = "running"
    draft: PhysicalProgram | None = None
    budget: int = 10
    policy: PolicyName = "ask"
    by_hand: tuple[RoleName, ...] = ()
    pinned: tuple[str, ...] = ()
    hints: tuple[str, ...] = ()
    lessons: tuple[Lesson, ...] = ()

    @property
    def current(self) -> Round | None:
        """The round at the head."""
        return next((item for item in self.rounds if item.id == self.head), None)

    def path(self) -> tuple[Round, ...]:
        """Rounds from the first to the head, along parents."""
        by_id = {item.id: item for item in self.rounds}
        chain: list[Round] = []
        node = self.current
        while node is not None:
            chain.append(node)
            node = by_id.get(node.parent) if node.parent else None
        return tuple(reversed(chain))

    @property
    def best(self) -> Round | None:
        """The round on the path whose rollout holds best; the result when the budget ends."""
        return best_of(self.path())


def best_of(rounds: Iterable[Round]) -> Round | None:
    """The round whose rollout holds best; None where none has run.

    Of those that fail, one in which something is seen to happen goes before one at rest.
    """
    judged = [one for one in rounds if one.rollout and one.assessment]
    return max(judged, key=_merit, default=None)


def _merit(item: Round) -> tuple[bool, bool, float, int]:
    told = item.assessment
    assert told is not None
    return (item.passed, told.seen_to_move, told.score, item.number)
