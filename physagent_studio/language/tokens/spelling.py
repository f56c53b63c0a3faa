"""Slips of the keyboard: an unknown word that is a known one misspelt is read as that one.

Only slips that leave little doubt: swapped neighbours, a letter doubled or not doubled, and in
long words, or in the case's own names, one letter. What has another meaning ("sings", which is
one letter from "swings") stays unknown.
"""

import difflib
import itertools
import re
from collections.abc import Iterable, Sequence
from dataclasses import replace
from functools import cache, lru_cache

from physagent_studio.knowledge.things import kind_of
from physagent_studio.language.tokens import vocabulary as v
from physagent_studio.language.tokens.expressions import FIXED
from physagent_studio.language.tokens.tokens import Token, singular, verb_base

SHORT, LONG = 4, 6
"""Least letters of a word in which neighbours may be swapped, and in which one may be wrong."""
LIKE = 0.85
"""How like, 0 … 1, a known verb has to be written to be offered in place of an unknown word."""


def corrected(tokens: Sequence[Token], nouns: frozenset[str]) -> tuple[Token, ...]:
    """The tokens with misspelt words replaced; `nouns` are the words of the case's names."""
    return tuple(replace(token, text=_meant(token.text, nouns)) for token in tokens)


@lru_cache(maxsize=1024)
def _meant(word: str, nouns: frozenset[str]) -> str:
    """The one known word that it is a slip of; else the word itself."""
    if len(word) < 3 or not word.isalpha() or is_known(word, nouns):
        return word
    names = {form for noun in nouns for form in (noun, f"{noun}s")}
    found = [w for w in _everything() | names if _is_slip(word, w)]
    if not found:
        found = [w for w in _long_words() | names if len(w) >= LONG - 1 and _one_off(word, w)]
    # Two readings that mean different things are none.
    meant = {verb_base(w) or singular(w) for w in found}
    return min(found, key=len) if len(meant) == 1 else word


def mostly_strange(prompt: str, nouns: frozenset[str]) -> tuple[str, ...]:
    """The words that are not known, where they are half of all; none where they are fewer."""
    words = dict.fromkeys(re.findall(r"[^\W\d_]+", prompt.lower()))
    read_as = corrected([Token(word, 0, 0) for word in words], nouns)
    strange = sum(not is_known(token.text, nouns) for token in read_as)
    if 2 * strange < len(words) + (strange < 2):
        return ()
    return tuple(word for word in words if not is_known(word, nouns))


def once_each(unknown: Iterable[str]) -> tuple[str, ...]:
    """Each word once: not again in the singular, or where it is part of a turn that is said."""
    said = tuple(unknown)
    return tuple(
        word
        for word in said
        if not any(word != one and (word == singular(one) or word in one.split()) for one in said)
    )


def instead_of(said: str) -> str:
    """What to do about words that were not understood, as a request: a verb that is written much
    like one is offered, a thing is to be marked."""
    word = said.lower()
    if verb_base(word) is None and word.isalpha():
        verbs = [form for verb in v.VERBS if verb.isalpha() for form in _forms(verb)[:2]]
        bent = [form for form, verb in v.IRREGULAR.items() if verb in v.VERBS]
        near = difflib.get_close_matches(word, [*verbs, *bent], 1, LIKE)
        if near:
            return f"did you mean “{near[0]}”?"
        if kind_of(word) is not None:
            return "mark it too, if it takes part"
    return "say it in other words"


def is_known(word: str, nouns: frozenset[str]) -> bool:
    """Whether the reader knows the word, or it is one of the case's names."""
    return (
        word in _everything()
        or verb_base(word) is not None
        or word in nouns
        or singular(word) in nouns
        or singular(word) in _everything()
    )


@cache
def _everything() -> frozenset[str]:
    """Every word that the reader knows, verbs in all their forms."""
    tables = (
        v.IRREGULAR, v.FORCE_NOUNS, v.CAUSES, v.CAMERA_WORDS, v.PARTS, v.LANDMARKS, v.MASS_HEADS,
        v.IGNORED_NOUNS, v.GENERIC, v.GROUND_WORDS, v.TABLE_WORDS, v.SIZES, v.PRONOUNS,
        v.AUXILIARIES, v.COUNTS, v.NEARLY, v.SHARES, v.TIMINGS, v.BOUNDS,
        *v.SUPPORT_CLASSES.values(), *v.SYNONYMS,
    )  # fmt: skip
    words = {word for table in tables for word in table}
    words |= {word for said, _ in FIXED for word in said}
    return frozenset(words | {form for verb in v.VERBS for form in _forms(verb)} | _long_words())


@cache
def _long_words() -> frozenset[str]:
    """Words that say how and where; a long one is still recognised with one letter wrong."""
    tables = (
        v.DIRECTIONS, v.MANNERS, v.FILLERS, v.PREPOSITIONS, v.SUBORDINATORS, v.POSTURES,
        v.COLOURS, v.POSITIONS, v.ORDINALS, v.NUMBERS, v.OTHERS, v.MATERIAL_WORDS,
        v.PLAIN_ADJECTIVES, v.DETERMINERS, v.CONJUNCTIONS, v.RELATIVES, v.NEGATIONS,
    )  # fmt: skip
    return frozenset(word for table in tables for word in table)


def _forms(verb: str) -> tuple[str, ...]:
    stem = verb.removesuffix("e")
    doubled = verb + verb[-1]
    third = f"{verb}es" if verb.endswith(("s", "sh", "ch", "x")) else f"{verb}s"
    return (
        verb, third, f"{stem}ing", f"{stem}ed", f"{doubled}ing", f"{doubled}ed",
    )  # fmt: skip


def _is_slip(word: str, other: str) -> bool:
    if word == other or abs(len(word) - len(other)) > 1:
        return False
    if len(word) != len(other):
        return len(other) > 3 and _undoubled(word) == _undoubled(other)
    if len(word) < SHORT:
        return False
    wrong = [i for i, (a, b) in enumerate(zip(word, other, strict=True)) if a != b]
    return (
        len(wrong) == 2
        and wrong[1] == wrong[0] + 1
        and word[wrong[0]] == other[wrong[1]]
        and word[wrong[1]] == other[wrong[0]]
    )


def _undoubled(word: str) -> str:
    return "".join(letter for letter, _ in itertools.groupby(word))


def _one_off(word: str, other: str) -> bool:
    """Whether one letter was put in, left out or mistaken, but not the first one."""
    if word[0] != other[0] or max(len(word), len(other)) < LONG:
        return False
    if len(word) == len(other):
        return sum(a != b for a, b in zip(word, other, strict=True)) == 1
    short, long = sorted((word, other), key=len)
    return len(long) - len(short) == 1 and any(
        long[:i] + long[i + 1 :] == short for i in range(len(long))
    )
