"""Turns of phrase that are put into plainer order before a sentence is cut into chunks."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import replace
from itertools import pairwise

from physagent_studio.language.syntax.idioms import in_plain_words
from physagent_studio.language.tokens import vocabulary as v
from physagent_studio.language.tokens.tokens import Token, singular, verb_base

UNREAD = re.compile(
    r"\b(?:by neither|nothing happens|first and|but not both|the only one|on the left and right"
    r"|(?:nearest|closest) (?:to )?(?:the|it)|nor (?:does|do|did|is|are)|too \w+ to"
    r"|(?:one|ones|two|three) (?:below|above))\b|^only (?:after|when|once|then)\b"
)
"""Turns that change what a clause says in a way that is not read, and is said so."""


def rewritten(tokens: Sequence[Token], nouns: frozenset[str]) -> tuple[Token, ...]:
    """The tokens in plainer words, with "but" as an exception where it is one.

    nouns: the words of the case's names, which are no verbs.
    """
    return _excepted(
        in_plain_words(_pliant(_behind(_at_rest(tuple(tokens)), nouns), nouns), nouns), nouns
    )


_ENDS = frozenset(".,;:!?") | v.CONJUNCTIONS | v.SUBORDINATORS


def _at_rest(tokens: tuple[Token, ...]) -> tuple[Token, ...]:
    """ "Nothing happens": nothing moves. "Nothing happens to the cup": the cup does not move."""
    words = [token.text for token in tokens]
    for at, pair in enumerate(pairwise(words)):
        if pair != ("nothing", "happens"):
            continue
        after = at + 2
        if not any(word.isalpha() for word in (*words[:at], *words[after:])):
            return (*tokens[: at + 1], replace(tokens[at + 1], text="moves"), *tokens[after:])
        if words[after : after + 1] == ["to"]:
            end = next((i for i in range(after, len(words)) if words[i] in _ENDS), len(words))
            still = (replace(tokens[at], text=word) for word in ("does", "not", "move"))
            return (*tokens[:at], *tokens[after + 1 : end], *still, *_at_rest(tokens[end:]))
    return tokens


_AFTER = {
    "follows": "goes", "follow": "go", "following": "going", "followed": "went",
    "chases": "goes", "chase": "go", "chasing": "going", "chased": "went",
}  # fmt: skip


def _behind(tokens: tuple[Token, ...], nouns: frozenset[str]) -> tuple[Token, ...]:
    """ "The ball follows the truck", "chases it": goes after it; not "follows a curve"."""
    found: list[Token] = []
    for at, token in enumerate(tokens):
        said = [t.text for t in tokens[at + 1 : at + 5]]
        led = next((w for w in said if w not in v.DETERMINERS | v.PLAIN_ADJECTIVES | v.COLOURS), "")
        thing = led in nouns - v.LANDMARKS.keys() or said[:1] in (["it"], ["them"])
        if token.text in _AFTER and thing:
            found += [replace(token, text=word) for word in (_AFTER[token.text], "after")]
        else:
            found.append(token)
    return tuple(found)


_LIKE = v.words_of("like as if though it they was were is are made of from out a an some")
"""What comes before the stuff that something behaves like."""


def _pliant(tokens: tuple[Token, ...], nouns: frozenset[str]) -> tuple[Token, ...]:
    """ "Wobbles like jelly", "as if it were made of rubber": that it gives way and comes back."""
    for at, token in enumerate(tokens):
        first = at
        while first and tokens[first - 1].text in _LIKE | v.PLAIN_ADJECTIVES:
            first -= 1
        said = [t.text for t in tokens[first:at]]
        likened = [i for i, word in enumerate(said) if word in ("like", "as")]
        if token.text in v.PLIANT - nouns and likened:
            first += likened[0]
            way = Token("pliantly", tokens[first].start, token.end)
            return (*tokens[:first], way, *_pliant(tokens[at + 1 :], nouns))
    return tokens


def _is_verb(word: str, nouns: frozenset[str]) -> bool:
    return verb_base(word) is not None and word not in nouns and singular(word) not in nouns


_ALL = ("all", "every", "each", "everything", "none", "no", "nothing", "both")


def _excepted(tokens: tuple[Token, ...], nouns: frozenset[str]) -> tuple[Token, ...]:
    """ "Every pin but the left one falls", "all fall but the left one": but for it."""
    found = list(tokens)
    words = [token.text for token in tokens]
    for at in (i for i, word in enumerate(words) if word == "but" and i + 1 < len(words)):
        if words[at - 1 : at + 2] == ["all", "but", "one"]:
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
