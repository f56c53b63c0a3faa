"""Everyday turns of phrase in plainer words: questions, amounts, "does a flip", "too heavy to"."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from physagent_studio.language.syntax.companions import (
    accompanied,
    first_of_all,
    going_round,
    nearest,
    ranked,
    where_it_is,
)
from physagent_studio.language.syntax.measures import ROUGHLY, UNITS
from physagent_studio.language.tokens import vocabulary as v
from physagent_studio.language.tokens.tokens import Token, is_number, singular, verb_base
from physagent_studio.language.tokens.vocabulary import words_of

Tokens = tuple[Token, ...]


def in_plain_words(tokens: Sequence[Token], nouns: frozenset[str]) -> Tokens:
    """The tokens with each such turn put plainly; what replaces words keeps their span.

    nouns: the words of the case's names.
    """
    found = _not_asked(tuple(tokens), nouns)
    for rule in (
        _out_of_sight,
        where_it_is,
        _sided,
        _performed,
        _amounts,
        _compared,
        _unable,
        _slipped,
        _untouched,
    ):
        found = rule(found, nouns)
    for rule in (
        _instead,
        going_round,
        first_of_all,
        accompanied,
        _there_and_back,
        _late_subject,
        ranked,
        nearest,
    ):
        found = rule(found, nouns)
    return found


def _said(first: Token, last: Token, *words: str) -> Tokens:
    """Other words in the place of those from `first` to `last`."""
    return tuple(Token(word, first.start, last.end) for word in words)


def _texts(tokens: Tokens, start: int, count: int) -> tuple[str, ...]:
    return tuple(token.text for token in tokens[start : start + count])


_OPENINGS = tuple(
    tuple(row.split())
    for row in (
        "what happens if", "what would happen if", "what happens when", "what if", "how about",
        "imagine that", "imagine", "suppose that", "suppose", "show me how", "show how", "show me",
        "show", "i want to see", "i would like to see", "i want", "i would like", "i wish that",
        "i wish", "can you make", "could you make", "can you let", "could you let", "please make",
        "please let", "please", "can you", "could you", "would you", "now make",
    )
)  # fmt: skip
_FRAMES = v.VIEW_WORDS | words_of("camera photo photograph")


def _out_of_sight(tokens: Tokens, nouns: frozenset[str]) -> Tokens:
    """ "Rolls out of the picture", "leaves the frame": it goes offscreen."""
    found: list[Token] = []
    index = 0
    while index < len(tokens):
        for turn, words in (
            (("out", "of"), ("offscreen",)),
            (("off",), ("offscreen",)),
            (("leaves",), ("moves", "offscreen")),
            (("leave",), ("move", "offscreen")),
            (("exits",), ("moves", "offscreen")),
        ):
            start = index + len(turn)
            start += _texts(tokens, start, 1) in (("the",), ("our",))
            named = _texts(tokens, start, 1)
            if _texts(tokens, index, len(turn)) == turn and named and named[0] in _FRAMES - nouns:
                found += _said(tokens[index], tokens[start], *words)
                index = start + 1
                break
        else:
            found.append(tokens[index])
            index += 1
    return tuple(found)


_ASKING = words_of("would could can will does did do should might may")


def _not_asked(tokens: Tokens, nouns: frozenset[str]) -> Tokens:
    """ "What if the mug tips over?", "could the ball roll …?": what is asked for is told."""
    for opening in sorted(_OPENINGS, key=len, reverse=True):
        if _texts(tokens, 0, len(opening)) != opening or len(tokens) <= len(opening):
            continue
        rest = tokens[len(opening) :]
        made = opening[-1] in ("make", "let") and verb_base(rest[0].text) is None
        return (*_said(tokens[0], tokens[len(opening) - 1], "make"), *rest) if made else rest
    opens = len(tokens) > 2 and tokens[0].text in _ASKING
    subject = tokens[1].text if len(tokens) > 1 else ""
    told = subject in v.DETERMINERS or subject in v.PRONOUNS or subject in nouns
    return tokens[1:] if opens and told else tokens


def _amounts(tokens: Tokens, nouns: frozenset[str]) -> Tokens:
    """ "About 20 cm", "half a metre", "a few centimetres", "half a turn", "two full turns"."""
    out: list[Token] = []
    index = 0
    while index < len(tokens):
        words = _texts(tokens, index, 5)
        taken, plain = _amount(words, nouns)
        if taken:
            out += _said(tokens[index], tokens[index + taken - 1], *plain)
        else:
            out.append(tokens[index])
        index += taken or 1
    return tuple(out)


_TURNS = words_of("turn rotation revolution spin")


def _amount(words: tuple[str, ...], nouns: frozenset[str]) -> tuple[int, tuple[str, ...]]:
    """How many of the words an amount takes, and what it is in plainer ones; (0, ()) for none."""
    first, second, third, fourth, fifth = (*words, *[""] * 5)[:5]
    if first in ROUGHLY and is_number(second) and singular(third) in UNITS:
        return 3, (second, third)
    if first in ROUGHLY and second in ("a", "an") and singular(third) in UNITS:
        return 3, ("1", third)
    shares = {"half": "180", "quarter": "90"}
    if (first, second) in (("half", "a"), ("half", "an")) and singular(third) in UNITS:
        return 3, ("0.5", third)
    if first == "half" and second == "a" and third in _TURNS:
        return 3, ("180", "degrees")
    if first in ("a", "one") and second in shares and third in _TURNS:
        return 3, (shares[second], "degrees")
    if (first, second, third, fourth) == ("a", "quarter", "of", "a"):
        return 0, ()
    if first in ("a", "one") and singular(second) in UNITS and (third, fourth) == ("and", "a"):
        # "A metre and a half".
        return (5, ("1.5", second)) if fifth == "half" else (0, ())
    if first in ("a", "one") and second in ("full", "whole", "complete") and third in _TURNS:
        return 3, ("once",)
    number = v.NUMBERS.get(first) or (int(first) if first.isdecimal() else 0)
    plural = singular(third if second in ("full", "whole", "complete") else second)
    if number > 1 and plural in _TURNS and plural not in nouns:
        taken = 3 if second in ("full", "whole", "complete") else 2
        return taken, (str(number), "times")
    if (first, second) in (("a", "few"), ("a", "couple")):
        unit, taken = (fourth, 4) if third == "of" else (third, 3)
        return (taken, ("3", unit)) if singular(unit) in UNITS else (0, ())
    if first in ("some", "several") and singular(second) in UNITS:
        return 2, ("3", second)
    return 0, ()


_KNOWN_AS = ("soon", "long", "well", "far")


def _compared(tokens: Tokens, nouns: frozenset[str]) -> Tokens:
    """ "As far as the box" is to it; "as high as the box" is a comparison, and said as one."""
    out: list[Token] = []
    index = 0
    while index < len(tokens):
        words = _texts(tokens, index, 3)
        pair = len(words) == 3 and words[0] == words[2] == "as"
        if pair and words[1] in ("far", "well"):
            plain = "to" if words[1] == "far" else "and"
            out += _said(tokens[index], tokens[index + 2], plain)
        elif pair and words[1] not in _KNOWN_AS:
            out += _said(tokens[index], tokens[index + 2], "as_much_as")
        else:
            out.append(tokens[index])
            index += 1
            continue
        index += 3
    return tuple(out)


_DOING = {
    **dict.fromkeys(("do", "perform", "execute", "take"), ""),
    **dict.fromkeys(("does", "performs", "executes", "takes"), "s"),
    **dict.fromkeys(("doing", "performing", "executing", "taking"), "ing"),
    **dict.fromkeys(("did", "performed", "executed", "took"), "ed"),
}
_DONE = {
    "flip": "flip", "somersault": "somersault", "backflip": "flip", "frontflip": "flip",
    "cartwheel": "somersault", "spin": "spin", "roll": "roll", "pirouette": "spin", "jump": "jump",
    "hop": "hop", "leap": "leap", "bounce": "bounce", "tumble": "tumble", "loop": "circle",
    "lap": "circle", "wobble": "wobble", "fall": "fall", "dive": "fall", "spill": "fall",
    "twirl": "twirl", "turn": "spin", "rotation": "spin", "revolution": "spin",
}  # fmt: skip
"""What one does or takes, as the verb that says it."""


def _performed(tokens: Tokens, nouns: frozenset[str]) -> Tokens:
    """ "Does a somersault", "took a tumble", "does two flips": the verb itself."""
    out: list[Token] = []
    index = 0
    while index < len(tokens):
        told = _doing(tokens, index, nouns)
        if told is None:
            out.append(tokens[index])
            index += 1
            continue
        words, taken = told
        out += _said(tokens[index], tokens[index + taken - 1], *words)
        index += taken
    return tuple(out)


def _doing(tokens: Tokens, index: int, nouns: frozenset[str]) -> tuple[tuple[str, ...], int] | None:
    """The words that stand for "does a flip" at an index, and how many tokens it has."""
    ending = _DOING.get(tokens[index].text)
    if ending is None:
        return None
    at = index + 1
    count = _texts(tokens, at, 1)[0] if at < len(tokens) else ""
    if count not in ("a", "an", "one", "another") and count not in v.NUMBERS:
        return None
    at += 1
    extra = []
    while at < len(tokens) and (tokens[at].text in v.PLAIN_ADJECTIVES or _manner(tokens[at].text)):
        extra.append(tokens[at].text)
        at += 1
    noun = tokens[at].text if at < len(tokens) else ""
    base = _DONE.get(singular(noun))
    if base is None or noun in nouns:
        return None
    number = v.NUMBERS.get(count, 1)
    times = (str(number), "times") if number > 1 else ()
    said = tuple(word for word in extra if word in v.MANNERS)
    return (_inflected(base, ending), *times, *said), at + 1 - index


def _manner(word: str) -> bool:
    return word in v.MANNERS


def _inflected(base: str, ending: str) -> str:
    if not ending or ending == "s":
        return base + ending
    past = {"fall": "fell", "spin": "spun"}
    if ending == "ed" and base in past:
        return past[base]
    doubled = base + base[-1] if base in ("flip", "spin", "hop") else base.removesuffix("e")
    return doubled + ending


def _unable(tokens: Tokens, nouns: frozenset[str]) -> Tokens:
    """ "Is too heavy to move", "fails to reach it": it does not."""
    out: list[Token] = []
    index = 0
    while index < len(tokens):
        words = _texts(tokens, index, 5)
        told = len(words) == 5 and words[0] in v.BE and (words[1], words[3]) == ("too", "to")
        slowly = len(words) > 3 and (words[0], words[2]) == ("too", "to") and words[1] in v.MANNERS
        if slowly and verb_base(tokens[index + 3].text) is not None:
            # "Rolls too slowly to knock it over".
            out.append(tokens[index + 1])
            out += _said(tokens[index], tokens[index + 2], "and", "does", "not")
            index += 3
            continue
        if told and verb_base(tokens[index + 4].text) is not None:
            out += _said(tokens[index], tokens[index + 3], "does", "not")
            index += 4
            continue
        out.append(tokens[index])
        index += 1
    return tuple(out)


_LEAVING = words_of(
    "fall drop slide roll slip tumble topple come knock push kick blow fly jump hop bounce move go"
)


def _slipped(tokens: Tokens, nouns: frozenset[str]) -> Tokens:
    """ "Falls of the table": an f forgotten."""
    out = list(tokens)
    for index in range(1, len(tokens) - 1):
        if tokens[index].text != "of" or tokens[index + 1].text not in v.DETERMINERS:
            continue
        if verb_base(tokens[index - 1].text) in _LEAVING and tokens[index - 1].text not in nouns:
            out[index] = replace(tokens[index], text="off")
    return tuple(out)


def _sided(tokens: Tokens, nouns: frozenset[str]) -> Tokens:
    """ "The table's right edge": the right table edge."""
    out = list(tokens)
    for i in range(len(tokens) - 2):
        side = tokens[i + 1].text in v.POSITIONS and tokens[i + 2].text in ("edge", "side", "end")
        if (
            side
            and tokens[i].text in nouns
            and tokens[i].end - tokens[i].start > len(tokens[i].text)
        ):
            out[i], out[i + 1] = tokens[i + 1], tokens[i]
    return tuple(out)


def _untouched(tokens: Tokens, nouns: frozenset[str]) -> Tokens:
    """ "Nothing happens to the box": it does not move; "nothing happens": nothing moves."""
    words = [token.text for token in tokens]
    for at in range(len(words) - 1):
        if words[at] != "nothing" or words[at + 1] not in ("happens", "happened", "happen"):
            continue
        if words[at + 2 : at + 3] != ["to"]:
            moved = replace(tokens[at + 1], text="moves")
            return (*tokens[: at + 1], moved, *_untouched(tokens[at + 2 :], nouns))
        end = at + 3
        while end < len(words) and not _ends_phrase(words[end]):
            end += 1
        denied = _said(tokens[at], tokens[at + 2], "does", "not", "move")
        return (*tokens[:at], *tokens[at + 3 : end], *denied, *_untouched(tokens[end:], nouns))
    return tokens


def _ends_phrase(word: str) -> bool:
    closed = v.SUBORDINATORS | v.CONJUNCTIONS | v.RELATIVES | v.AUXILIARIES
    return word in ".,;:!?" or word in closed


def _instead(tokens: Tokens, nouns: frozenset[str]) -> Tokens:
    """ "Instead of falling": without falling; "the cup instead of the box": but not the box."""
    out: list[Token] = []
    index = 0
    while index < len(tokens):
        pair = _texts(tokens, index, 2)
        if pair not in (("instead", "of"), ("rather", "than")):
            out.append(tokens[index])
            index += 1
            continue
        following = tokens[index + 2].text if index + 2 < len(tokens) else ""
        acts = following.endswith("ing") and verb_base(following) is not None
        plain = ("without",) if acts else ("but", "not")
        out += _said(tokens[index], tokens[index + 1], *plain)
        index += 2
    return tuple(out)


_OPPOSITE = {"left": "right", "right": "left"}


def _there_and_back(tokens: Tokens, nouns: frozenset[str]) -> Tokens:
    """ "Slides left, then right": then back to the right."""
    out = list(tokens)
    for index, token in enumerate(tokens):
        before = [t.text for t in tokens[max(index - 4, 0) : index] if t.text in _OPPOSITE]
        if token.text != "then" or not before:
            continue
        at = index + (3 if _texts(tokens, index + 1, 2) == ("to", "the") else 1)
        if _texts(tokens, at, 1) == (_OPPOSITE[before[-1]],):
            out[index] = replace(token, text="then back")
            out[at] = replace(tokens[at], text=f"{tokens[at].text}wards")
            out[index + 1 : at] = []
            parted = out[index].text.split()
            out[index : index + 1] = [replace(token, text=word) for word in parted]
            return tuple(out)
    return tuple(out)


def _late_subject(tokens: Tokens, nouns: frozenset[str]) -> Tokens:
    """ "Only after the glass fell does the bottle tip over": then the bottle tips over."""
    words = [token.text for token in tokens]
    if words[:1] != ["only"] or words[1:2] not in (["after"], ["when"], ["once"], ["then"]):
        return tokens
    told = next((i for i, w in enumerate(words) if verb_base(w) and w not in nouns), len(words))
    for index in range(told + 1 if words[1] != "then" else 2, len(words) - 1):
        if words[index] in ("does", "do", "did", "will") and words[index + 1] in v.DETERMINERS:
            comma = replace(tokens[index], text=",")
            return (*tokens[1:index], comma, *tokens[index + 1 :])
    return tokens
