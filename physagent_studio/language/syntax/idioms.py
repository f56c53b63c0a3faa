"""Everyday turns of phrase in plainer words: amounts, "does a flip", "too heavy to"."""

from collections.abc import Sequence

from physagent_studio.language.syntax.measures import LENGTHS, ROUGHLY, UNITS
from physagent_studio.language.tokens import vocabulary as v
from physagent_studio.language.tokens.tokens import Token, is_number, singular, verb_base
from physagent_studio.language.tokens.vocabulary import words_of

Tokens = tuple[Token, ...]


def in_plain_words(tokens: Sequence[Token], nouns: frozenset[str]) -> Tokens:
    """The tokens with each such turn put plainly; what replaces words keeps their span.

    nouns: the words of the case's names.
    """
    found = tuple(tokens)
    for rule in (
        _out_of_sight,
        _laden,
        _taken_along,
        where_it_is,
        _performed,
        _taken_out,
        _amounts,
        _unable,
        counted_from,
        _after_that,
        _back_to_a_side,
        _growing_on,
    ):
        found = rule(found, nouns)
    return found


def _said(first: Token, last: Token, *words: str) -> Tokens:
    """Other words in the place of those from `first` to `last`."""
    return tuple(Token(word, first.start, last.end) for word in words)


def _texts(tokens: Tokens, start: int, count: int) -> tuple[str, ...]:
    return tuple(token.text for token in tokens[start : start + count])


_CARRIED = (
    ("on", "top", "of", "it"), ("on", "top", "of", "them"), ("inside", "of", "it"), ("on", "top"),
    ("on", "it"), ("on", "them"), ("in", "it"), ("in", "them"), ("inside", "it"), ("inside",),
)  # fmt: skip


def _laden(tokens: Tokens, nouns: frozenset[str]) -> Tokens:
    """ "The tray with a cup on it": the tray. What lies on it goes along by itself."""
    longest = 5  # words, 2..8: that say what is carried
    for start, token in enumerate(tokens):
        if token.text != "with" or not start:
            continue
        comma = tokens[start - 1].text == ","
        if start == comma or not _named(tokens[start - 1 - comma], nouns):
            continue
        for end in range(start + 2, min(start + 2 + longest, len(tokens))):
            turn = next((t for t in _CARRIED if _texts(tokens, end, len(t)) == t), None)
            if turn is None or not _named(tokens[end - 1], nouns):
                continue
            rest = _past_a_place(tokens, end + len(turn), nouns)
            rest += comma and _texts(tokens, rest, 1) == (",",)
            return tokens[: start - comma] + _laden(tokens[rest:], nouns)
    return tokens


_GOES_OVER = words_of("tip topple fall flip tumble overturn drop")


def _taken_along(tokens: Tokens, nouns: frozenset[str]) -> Tokens:
    """ "Slides to the left with the cup on it": while the cup stays on it. Where it tips over or
    falls, what lies on it goes along in its own way."""
    for start, token in enumerate(tokens):
        article, *rest = (*_texts(tokens, start + 1, 6), "")
        if token.text != "with" or not start or article not in v.DETERMINERS:
            continue
        end = next((i for i, word in enumerate(rest) if word in nouns), len(rest)) + start + 2
        while end < len(tokens) and tokens[end].text in nouns:
            end += 1
        turn = next((t for t in _CARRIED if _texts(tokens, end, len(t)) == t), None)
        if turn is None:
            continue
        over = any(verb_base(t.text) in _GOES_OVER for t in tokens[:start])
        what, last = tokens[start + 1 : end], tokens[end + len(turn) - 1]
        stays = (
            *_said(token, token, "while"),
            *what,
            *_said(tokens[end], last, "stays", "on", "it"),
        )
        return (*tokens[:start], *(() if over else stays), *tokens[end + len(turn) :])
    return tokens


def _past_a_place(tokens: Tokens, start: int, nouns: frozenset[str]) -> int:
    """Behind "of the saucer", "the box", where such words follow "on top" and "inside"."""
    at = start + (_texts(tokens, start, 1) == ("of",))
    if not set(_texts(tokens, at, 1)) & v.DETERMINERS:
        return start
    longest = 4  # words, 1..6: "the", "small", "red", "box"
    last = (i for i in range(at + 1, min(at + longest, len(tokens))) if _named(tokens[i], nouns))
    return next(last, start - 1) + 1


def _named(token: Token, nouns: frozenset[str]) -> bool:
    return token.text in nouns or singular(token.text) in nouns


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
            (("leaving",), ("moving", "offscreen")),
            (("exiting",), ("moving", "offscreen")),
        ):
            start = index + len(turn)
            start += _texts(tokens, start, 1) in (("the",), ("our",))
            named = _texts(tokens, start, 1)
            if _texts(tokens, index, len(turn)) == turn and named and named[0] in _FRAMES - nouns:
                side, taken = _rim(_texts(tokens, start + 1, 4))
                found += _said(tokens[index], tokens[start + taken], *words, *side)
                index = start + taken + 1
                break
        else:
            found.append(tokens[index])
            index += 1
    return tuple(found)


_RIMS = {"top": "up", "bottom": "down", "left": "leftwards", "right": "rightwards"}


def _rim(after: tuple[str, ...]) -> tuple[tuple[str, ...], int]:
    """The way that "at the top", "on the left side" says, and how many words it takes."""
    at, article, rim, part = (*after, *[""] * 4)[:4]
    if at not in ("at", "on", "over", "through", "from") or article != "the" or rim not in _RIMS:
        return (), 0
    return (_RIMS[rim],), 3 + (part in ("side", "edge"))


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


def is_plain(number: str) -> bool:
    """Whether a number is written in figures."""
    return number.replace(".", "", 1).isdigit()


_TURNS = words_of("turn rotation revolution spin")
_PART_TURNS = {"half": "180", "quarter": "90", "full": "360", "complete": "360", "whole": "360"}


def _amount(words: tuple[str, ...], nouns: frozenset[str]) -> tuple[int, tuple[str, ...]]:
    """How many of the words an amount takes, and what it is in plainer ones; (0, ()) for none."""
    first, second, third, fourth = (*words, *[""] * 4)[:4]
    about = 1 if first in ROUGHLY else 0
    number, unit, each, second_of = (*words[about:], *[""] * 4)[:4]
    if is_number(number) and singular(unit) in LENGTHS and each in ("per", "a", "each"):
        speed = f"{float(number) * LENGTHS[singular(unit)]:.4g}" if is_plain(number) else ""
        if speed and second_of == "second":
            return 4 + about, (speed, "m/s")
    if first in ROUGHLY and is_number(second) and singular(third) in UNITS:
        return 3, (second, third)
    if (first, second) in (("half", "a"), ("half", "an")) and singular(third) in UNITS:
        return 3, ("0.5", third)
    if degrees := _part_of_a_turn(words[:3]):
        return 3, (degrees, "degrees")
    if (first, second) == ("a", "few"):
        unit, taken = (fourth, 4) if third == "of" else (third, 3)
        return (taken, ("3", unit)) if singular(unit) in UNITS else (0, ())
    return 0, ()


def _part_of_a_turn(words: tuple[str, ...]) -> str:
    """The degrees of "half a turn", "a quarter turn"; "" for anything else."""
    first, second, third = (*words, "", "", "")[:3]
    if third not in _TURNS:
        return ""
    share = first if second == "a" else second if first in ("a", "one") else ""
    return _PART_TURNS.get(share, "")


_DOING = {
    **dict.fromkeys(("do", "perform", "execute", "take"), ""),
    **dict.fromkeys(("does", "performs", "executes", "takes"), "s"),
    **dict.fromkeys(("doing", "performing", "executing", "taking"), "ing"),
    **dict.fromkeys(("did", "performed", "executed", "took", "given"), "ed"),
}
_MAKING = {"make": "", "makes": "s", "making": "ing", "made": "ed"}
"""What is done of part of a turn only: else it makes another thing do so."""
_DONE = {
    "flip": "flip", "somersault": "somersault", "backflip": "flip", "frontflip": "flip",
    "cartwheel": "somersault", "spin": "spin", "roll": "roll", "pirouette": "spin", "jump": "jump",
    "hop": "hop", "leap": "leap", "bounce": "bounce", "tumble": "tumble", "loop": "circle",
    "lap": "circle", "wobble": "wobble", "fall": "fall", "dive": "fall", "spill": "fall",
    "twirl": "twirl", "turn": "spin", "rotation": "spin", "revolution": "spin", "push": "push",
    "shove": "shove", "nudge": "nudge", "kick": "kick", "tap": "tap", "poke": "poke",
    "toss": "toss", "knock": "push", "shake": "shake", "squeeze": "squeeze",
    "tug": "tug", "pull": "pull",
}  # fmt: skip
"""What one does or takes, as the verb that says it."""


def _performed(tokens: Tokens, nouns: frozenset[str]) -> Tokens:
    """ "Does a somersault", "took a tumble", "is given a push": the verb itself."""
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
    ending = (_DOING | _MAKING).get(tokens[index].text)
    if ending is None:
        return None
    at = index + 1
    if degrees := _part_of_a_turn(_texts(tokens, at, 3)):
        return (_inflected("spin", ending), degrees, "degrees"), 4
    if tokens[index].text in _MAKING:
        return None
    count = _texts(tokens, at, 1)[0] if at < len(tokens) else ""
    if count not in ("a", "an", "one", "another") and count not in v.NUMBERS:
        return None
    at += 1
    extra = []
    while at < len(tokens) and (
        tokens[at].text in v.PLAIN_ADJECTIVES or tokens[at].text in v.MANNERS
    ):
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


_REMOVED = {"take": "remove", "takes": "removes", "took": "removes", "taken": "removed"}


def _taken_out(tokens: Tokens, nouns: frozenset[str]) -> Tokens:
    """ "Takes the blue book out", "is taken away": removes it."""
    found = list(tokens)
    for at, token in enumerate(tokens):
        rest = [t.text for t in tokens[at + 1 : at + 7]]
        end = next((i for i, word in enumerate(rest) if word in ("out", "away")), None)
        named = end is not None and all(word in nouns or not verb_base(word) for word in rest[:end])
        if token.text in _REMOVED and named and not set(rest[:end]) & set(".,;:!?"):
            found[at] = Token(_REMOVED[token.text], token.start, token.end)
    return tuple(found)


def _inflected(base: str, ending: str) -> str:
    if ending in ("", "s"):
        return base + ending
    doubled = base + base[-1] if base in ("flip", "spin", "hop") else base.removesuffix("e")
    return doubled + ending


def _unable(tokens: Tokens, nouns: frozenset[str]) -> Tokens:
    """ "Is too heavy to move": it does not."""
    out: list[Token] = []
    index = 0
    while index < len(tokens):
        words = _texts(tokens, index, 5)
        told = len(words) == 5 and words[0] in v.BE and (words[1], words[3]) == ("too", "to")
        if told and verb_base(words[4]) is not None:
            out += _said(tokens[index], tokens[index + 3], "does", "not")
            index += 4
            continue
        out.append(tokens[index])
        index += 1
    return tuple(out)


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


def counted_from(tokens: Tokens, nouns: frozenset[str]) -> Tokens:
    """ "The second cup from the left": counted from there."""
    texts = [token.text for token in tokens]
    for at in range(2, len(tokens) - 2):
        counted = texts[at : at + 2] == ["from", "the"] and texts[at - 2] in v.ORDINALS
        if counted and texts[at + 2] in ("left", "right"):
            said = _said(tokens[at], tokens[at + 2], f"counted_{texts[at + 2]}")
            return (*tokens[:at], *said, *tokens[at + 3 :])
    return tokens


def _after_that(tokens: Tokens, nouns: frozenset[str]) -> Tokens:
    """ "And after that the box tips": what was told before comes first; not "after that ball"."""
    found: list[Token] = []
    index = 0
    while index < len(tokens):
        word, what, following, *_ = (*_texts(tokens, index, 3), "", "")
        ends = following in (",", "") or following in v.DETERMINERS | v.PRONOUNS
        if word == "after" and (what == "which" or (what in ("that", "this") and ends)):
            found += _said(tokens[index], tokens[index + 1], "afterwards")
            index += 2
        else:
            found.append(tokens[index])
            index += 1
    return tuple(found)


_HAULED = words_of("drag pull push shove tug tow haul nudge draw")


def _back_to_a_side(tokens: Tokens, nouns: frozenset[str]) -> Tokens:
    """ "Is pulled back to the right": to the right, which says which way that is.

    What goes or bounces back by itself turns round, and keeps its word.
    """
    found: list[Token] = []
    for at, token in enumerate(tokens):
        aim = _texts(tokens, at + 1, 3)
        sided = aim[:2] == ("to", "the") and aim[2:] in (("left",), ("right",))
        hauled = at > 0 and verb_base(tokens[at - 1].text) in _HAULED
        if not (token.text == "back" and sided and hauled):
            found.append(token)
    return tuple(found)


def _growing_on(tokens: Tokens, nouns: frozenset[str]) -> Tokens:
    """ "The leaves of the plant rustle", "the tree's branches sway": the plant and the tree do."""
    found: list[Token] = []
    index = 0
    while index < len(tokens):
        of, article, *whole = (*_texts(tokens, index + 1, 5), "", "")
        grows = tokens[index].text in v.GROWTH - nouns
        owned = index > 0 and tokens[index - 1].text in nouns
        if grows and of == "of" and article in v.DETERMINERS and nouns & {*whole}:
            # The article of the parts is that of the whole.
            index += 3
        elif grows and owned and verb_base(of) is not None:
            index += 1
        else:
            found.append(tokens[index])
            index += 1
    return tuple(found)
