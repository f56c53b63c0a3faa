"""Whether a thing stays where a clause brings it, and what can have something in it."""

from __future__ import annotations

from physagent_studio.agent.rules.reading.vocabulary import words_of
from physagent_studio.agent.rules.specs import Context

_GOING_ON = words_of(
    "roll slide move slip bounce leave fall fly jump drift push knock topple rise strike"
)


def is_last(c: Context) -> bool:
    """Whether it stays where this clause brings it: no later clause takes it away."""
    return not any(f.sense in _GOING_ON and not f.negated for f in c.later)


_CONTAINERS = words_of(
    "box crate carton basket bin bucket bowl cup mug glass pot pan can trash_can bag drawer sink "
    "tray hole pit tub bathtub barrel jar vase trashcan dustbin hat nest cart wagon"
)


def is_container(name: str) -> bool:
    """Whether a thing of that name can have something in it."""
    words = name.lower().split("_")
    return words[-1] in _CONTAINERS or "_".join(words[-2:]) in _CONTAINERS
