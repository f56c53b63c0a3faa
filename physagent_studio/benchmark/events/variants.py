"""Who plays the roles in a variant of the agent, and how many rounds it has."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from physagent_studio.agent.crew import Crew
from physagent_studio.agent.rules import RuleVerifier
from physagent_studio.benchmark.events.plain_vectors import PlainGenerator, PlainPlanner
from physagent_studio.errors import InputError
from physagent_studio.workbench.engine import AgentName


@dataclass(frozen=True, slots=True)
class Variant:
    """rounds: most rounds. crew: who plays the roles; None is the agent of that name as it is."""

    words: str
    rounds: int = 10
    crew: Callable[[], Crew] | None = None
    agent: AgentName = "rules"


def _without_semantics() -> Crew:
    return Crew(PlainGenerator(), RuleVerifier(), PlainPlanner())


VARIANTS = {
    "full": Variant("full"),
    "no_reflection": Variant("without reflection", rounds=1),
    "no_semantics": Variant("without the semantic actions", crew=_without_semantics),
}
EVERY_VARIANT = VARIANTS | {"model": Variant("a model", agent="vlm")}
"""Those, and the full loop with a model behind an endpoint in all roles."""


def variant_of(name: str) -> Variant:
    """The variant of that name; raises InputError for an unknown one."""
    if name not in EVERY_VARIANT:
        raise InputError(f"there is no variant '{name}' (known: {', '.join(EVERY_VARIANT)})")
    return EVERY_VARIANT[name]
