"""Chunks of a sentence: noun phrases, prepositional phrases, verb groups and what joins them."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

ChunkKind = Literal["np", "pp", "verb", "adv", "and", "sub", "rel", "stop", "gap"]


@dataclass(frozen=True, slots=True)
class NounPhrase:
    """head: singular noun, or the pronoun. words: its nouns and adjectives as written.

    alternatives: coordinated adjectives ("the top and middle …"). of: what follows "of".
    bound: the limit that the number is ("at least two"), a word of `BOUNDS`. amount: the number
    that it begins with, be it a count or not.
    """

    head: str
    nouns: tuple[str, ...] = ()
    adjectives: tuple[str, ...] = ()
    alternatives: tuple[tuple[str, ...], ...] = ()
    determiner: str = ""
    only: bool = False
    bound: str = ""
    number: int | None = None
    amount: float | None = None
    pronoun: bool = False
    plural: bool = False
    of: NounPhrase | None = None
    start: int = 0
    end: int = 0


@dataclass(frozen=True, slots=True)
class Chunk:
    """A piece of the sentence; start and end are token indices."""

    kind: ChunkKind
    start: int
    end: int
    word: str = ""
    np: NounPhrase | None = None
    verb: str = ""
    form: str = ""
    passive: bool = False
    finite: bool = True
    negated: bool = False
    strong_stop: bool = False
