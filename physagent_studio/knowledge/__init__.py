"""What anybody knows of things and verbs: tables, and the few questions that are asked of them."""

from physagent_studio.knowledge.catalogue import (
    Heading,
    Kind,
    Pace,
    Range,
    kind_of,
    kinds,
    pace_of,
    paces,
)

__all__ = ["Heading", "Kind", "Pace", "Range", "kind_of", "kinds", "pace_of", "paces"]
