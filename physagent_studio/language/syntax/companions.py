"""Turns of phrase about where things are: "with the cup still on top", "that stands there"."""

from __future__ import annotations

from dataclasses import replace

from physagent_studio.language.tokens import vocabulary as v
from physagent_studio.language.tokens.tokens import Token, singular, verb_base
from physagent_studio.language.tokens.vocabulary import words_of

Tokens = tuple[Token, ...]


def _said(first: Token, last: Token, *words: str) -> Tokens:
    """Other words in the place of those from `first` to `last`."""
    return tuple(Token(word, first.start, last.end) for word in words)


def _texts(tokens: Tokens, start: int, count: int) -> tuple[str, ...]:
    return tuple(token.text for token in tokens[start : start + count])


def going_round(tokens: Tokens, nouns: frozenset[str]) -> Tokens:
    """ "Goes round the rock", "spins round": around it; "a round stone" is round."""
    out = list(tokens)
    for index in range(1, len(tokens)):
        base = verb_base(tokens[index - 1].text)
        if (
            tokens[index].text == "round"
            and base is not None
            and tokens[index - 1].text not in nouns
        ):
            out[index] = replace(tokens[index], text="around")
    return tuple(out)


def first_of_all(tokens: Tokens, nouns: frozenset[str]) -> Tokens:
    """ "Hits the cup first and then the box": "first" is no word for a thing there."""
    out = list(tokens)
    for index in range(1, len(tokens) - 1):
        if tokens[index].text != "first" or tokens[index - 1].text not in nouns:
            continue
        told = any(verb_base(token.text) is not None for token in tokens[: index - 1])
        following = [t.text for t in tokens[index + 1 : index + 4] if t.text not in (",", "only")]
        if told and following and following[0] in ("and", "then") and "then" in following[:2]:
            out[index] = replace(tokens[index], text="initially")
    return tuple(out)


def accompanied(tokens: Tokens, nouns: frozenset[str]) -> Tokens:
    """ "Slides away with the cup still on top": while the cup stays on top of it."""
    out: list[Token] = []
    index = 0
    while index < len(tokens):
        told = _companion(tokens, index, nouns) if tokens[index].text == "with" else None
        if told is None:
            out.append(tokens[index])
            index += 1
            continue
        noun, rest, said = told
        out += _said(tokens[index], tokens[index], "while")
        out += tokens[index + 1 : noun + 1]
        out += _said(tokens[noun + 1], tokens[rest - 1], *said)
        index = rest
    return tuple(out)


def _companion(
    tokens: Tokens, start: int, nouns: frozenset[str]
) -> tuple[int, int, tuple[str, ...]] | None:
    """Of "with the cup still on top": the noun, where the sentence goes on, and how that is said
    plainly; None where "with" says something else."""
    noun = start + 1
    while noun < len(tokens) and not _names(tokens, noun, nouns):
        if tokens[noun].text not in v.DETERMINERS and tokens[noun].text not in _QUALITIES:
            return None
        noun += 1
    at = noun + 1
    while at < len(tokens) and tokens[at].text in ("still", "remaining", "staying", "always"):
        at += 1
    words = _texts(tokens, at, 2)
    if noun >= len(tokens) or not words:
        return None
    held = (("on", "top"), ("on", "it"), ("in", "it"), ("on", "them"))
    if words in held or words[0] in ("inside", "atop"):
        inside = words[0] in ("in", "inside")
        taken = 1 if words[0] in ("inside", "atop") else 2
        return noun, at + taken, ("stays", "in" if inside else "on", "it")
    if words[0] in ("standing", "upright"):
        return noun, at + 1, ("stays", "upright")
    if words[0] in ("lying", "sitting", "resting") and words[1:] in (("on",), ("in",)):
        return noun, at + 1, ("stays",)
    return None


_QUALITIES = frozenset(v.COLOURS) | frozenset(v.SIZES) | v.OTHERS | frozenset(v.POSITIONS)


def _names(tokens: Tokens, index: int, nouns: frozenset[str]) -> bool:
    """Whether it is the last word of a thing's name."""
    word, following = tokens[index].text, _texts(tokens, index + 1, 1)
    named = word in nouns or singular(word) in nouns
    return named and not (following and following[0] in nouns)


_STANDING = v.BE | words_of("stands stand stood standing lies lie lay lying sits sit sat sitting")
_WHERE = words_of("on in at near next beside behind under below above atop closest nearest")


def where_it_is(tokens: Tokens, nouns: frozenset[str]) -> Tokens:
    """ "The cup that stands on the left": the cup on the left."""
    out: list[Token] = []
    index = 0
    while index < len(tokens):
        end = index + 1
        while end < len(tokens) and tokens[end].text in _STANDING:
            end += 1
        before = tokens[index - 1].text if index else ""
        named = before in nouns or singular(before) in nouns or before in ("one", "ones")
        where = tokens[end].text if end < len(tokens) else ""
        relates = tokens[index].text in v.RELATIVES and end > index + 1
        if relates and named and where in _WHERE:
            index = end
            continue
        out.append(tokens[index])
        index += 1
    return tuple(out)


_RANKS = words_of("first last")


def ranked(tokens: Tokens, nouns: frozenset[str]) -> Tokens:
    """ "Is the last to fall": falls, and when is what nothing tests; "the second cup from the
    left": counted from there."""
    out = list(tokens)
    texts = [token.text for token in tokens]
    for index in range(len(tokens) - 3):
        words = texts[index : index + 5]
        if words[0] in v.BE and words[1] == "the" and words[2] in _RANKS and words[3] == "to":
            verb = verb_base(words[4]) if len(words) > 4 else None
            if verb is not None:
                out[index] = replace(tokens[index], text="will")
                out[index + 1] = tokens[index + 4]
                out[index + 2] = replace(tokens[index + 2], text=f"{words[2]}_of_all")
                del out[index + 3 : index + 5]
                return tuple(out)
        counted = words[:2] == ["from", "the"] and words[2] in ("left", "right")
        if counted and index > 1 and tokens[index - 2].text in v.ORDINALS:
            out[index : index + 3] = _said(tokens[index], tokens[index + 2], f"counted_{words[2]}")
            return tuple(out)
    return tuple(out)


def nearest(tokens: Tokens, nouns: frozenset[str]) -> Tokens:
    """ "The cup nearest to the ball": by where they are in the picture."""
    out = list(tokens)
    for index in range(1, len(tokens) - 2):
        before = tokens[index - 1].text
        named = before in nouns or singular(before) in nouns or before in ("one", "ones")
        if named and tokens[index].text in ("nearest", "closest"):
            out[index] = replace(tokens[index], text="nearest_to")
            if tokens[index + 1].text == "to":
                del out[index + 1]
            return tuple(out)
    return tuple(out)
