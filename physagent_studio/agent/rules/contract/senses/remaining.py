"""Whether a thing stays where a clause brings it, and what can have something in it."""

from __future__ import annotations

from physagent_studio.agent.rules.contract.specs import Context
from physagent_studio.knowledge import is_container as is_container
from physagent_studio.language.tokens.vocabulary import words_of

_GOING_ON = words_of(
    "roll slide move slip bounce leave fall fly jump drift push knock topple rise strike"
)


def is_last(c: Context) -> bool:
    """Whether it stays where this clause brings it: no later clause takes it away."""
    return not any(f.sense in _GOING_ON and not f.negated for f in c.later)
