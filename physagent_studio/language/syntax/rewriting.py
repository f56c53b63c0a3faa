"""Turns of phrase that are put into plainer order before a sentence is cut into chunks."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from physagent_studio.language.syntax.idioms import in_plain_words
from physagent_studio.language.tokens import vocabulary as v
from physagent_studio.language.tokens.tokens import Token, singular, verb_base

LABEL = 6
"""Words that a label before a colon may have."""


def rewritten(tokens: Sequence[Token], nouns: frozenset[str]) -> tuple[Token, ...]:
    """The tokens without a label in front, and with "neither … nor" as plain denials.

    nouns: the words of the case's names, which are no verbs.
    """
    plain = in_plain_words(_unlabelled(tuple(tokens), nouns), nouns)
    return _denials(_excepted(plain, nouns), nouns)


def _is_verb(word: str, nouns: frozenset[str]) -> bool:
    return verb_base(word) is not None and word not in nouns and singular(word) not in nouns


def _unlabelled(tokens: tuple[Token, ...], nouns: frozenset[str]) -> tuple[Token, ...]:
    """ "A strike: the ball …", "Strike! The ball …": what stands in front names the sentence that
    follows."""
    words = [token.text for token in tokens[: LABEL + 1]]
    end = next((i for i, word in enumerate(words) if word in (":", "!")), len(words))
    if end == len(words):
        return tokens
    named = [i for i in range(end) if words[i] in nouns or singular(words[i]) in nouns]
    told = any(
        words[i] in v.BE or (_is_verb(words[i], nouns) and not words[i].endswith("ing"))
        for i in range((named[0] if named else end) + 1, end)
    )
    return tokens if told or end + 1 >= len(tokens) else tokens[end + 1 :]


_ALL = ("all", "every", "each", "everything", "none", "no", "nothing", "both")


def _excepted(tokens: tuple[Token, ...], nouns: frozenset[str]) -> tuple[Token, ...]:
    """ "Every pin but the left one falls", "all fall but the left one": but for it."""
    found = list(tokens)
    words = [token.text for token in tokens]
    for at in (i for i, word in enumerate(words) if word == "but" and i + 1 < len(words)):
        if words[at - 1 : at + 2] == ["all", "but", "one"] and words[at + 2 : at + 3] != ["that"]:
            # "All but one of the cups": however many that are.
            continue
        said = ("does", "do", "did", "will", "has", "have")
        verbs = [
            i
            for i, word in enumerate(words)
            if _is_verb(word, nouns) or word in v.BE or word in said
        ]
        end = next((i for i in range(at, len(words)) if words[i] in ".,;:!?"), len(words))
        whole = any(word in _ALL for word in words[max(at - 6, 0) : at])
        subject = not any(i < at for i in verbs)
        trailing = not any(at < i < end for i in verbs) and words[at + 1] in v.DETERMINERS
        if whole and (subject or trailing):
            found[at] = replace(tokens[at], text="except")
    return tuple(found)


def _denials(tokens: tuple[Token, ...], nouns: frozenset[str]) -> tuple[Token, ...]:
    found: list[Token] = []
    index = 0
    while index < len(tokens):
        token = tokens[index]
        following = tokens[index + 1].text if index + 1 < len(tokens) else ""
        if token.text == "neither" and _is_verb(following, nouns):
            found.append(replace(token, text="not"))
        elif token.text == "neither" and found and found[-1].text in ("by", "with", "into"):
            # "Is hit by neither of the balls": it is not hit by them.
            found[-1:] = [replace(found[-1], text="not"), found[-1]]
            index += following == "of"
        elif token.text == "nor" and following in v.AUXILIARIES:
            verb = _next_verb(tokens, index + 2, nouns)
            if verb is None:
                found.append(token)
            else:
                # "Nor does it touch the box": and it does not touch the box.
                found += [replace(token, text="and"), *tokens[index + 2 : verb]]
                found += [tokens[index + 1], replace(tokens[index + 1], text="not")]
                index = verb - 1
        else:
            found.append(token)
        index += 1
    return tuple(found)


def _next_verb(tokens: Sequence[Token], start: int, nouns: frozenset[str]) -> int | None:
    for index in range(start, len(tokens)):
        if tokens[index].text in ".,;:!?":
            return None
        if index > start and _is_verb(tokens[index].text, nouns):
            return index
    return None
