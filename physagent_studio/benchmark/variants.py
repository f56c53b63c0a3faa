"""Who plays the roles in a variant of the agent."""

from __future__ import annotations

from collections.abc import Callable

from physagent_studio.agent.loop import Crew
from physagent_studio.errors import InputError

VARIANTS: dict[str, Callable[[], Crew | None]] = {"full": lambda: None}
"""Variants by name; None is the embedded agent as it is."""


def crew_of(variant: str) -> Crew | None:
    """The crew of a variant; None for the embedded agent as it is."""
    if variant not in VARIANTS:
        raise InputError(f"there is no variant '{variant}' (known: {', '.join(VARIANTS)})")
    return VARIANTS[variant]()
