"""What a person asks to be otherwise: more or less of a quantity, hands off, another photo.

English says such things in few ways: a comparative ("later"), a complaint ("too late", "so late
that"), a denied degree ("not so late", "not late enough"), a verb that is one ("wait", "weaken") or
that turns a quantity ("reduce the force"), and a bare fact ("the floor is slippery"). These are
read from the words of `knowledge/degrees.yaml`; whose quantity it is, is settled elsewhere.
"""

import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cache
from itertools import pairwise
from typing import Literal

from physagent_studio.knowledge import degrees
from physagent_studio.language.tokens.tokens import singular, tokenise, verb_base
from physagent_studio.language.tokens.verbs import VERBS
from physagent_studio.language.tokens.vocabulary import CAMERA_WORDS, DIRECTIONS

Kind = Literal["degree", "side", "way", "keep", "photo", "pace"]
Way = Literal["left", "right", "away", "toward_camera"]
WAYS: dict[str, tuple[Way, ...]] = {
    "forward": ("away", "toward_camera"), "backward": ("toward_camera", "away"),
}  # fmt: skip
"""In a picture each may be either: as who looks at it says, or as the thing does."""
LENSES = CAMERA_WORDS | {"me"}
DEGREES = frozenset(["more", "further", "farther", "bit", "little"])
"""With these a side is no way by itself."""

CLAUSE = re.compile(
    r"[,.;!?]+|(?<!thing )\bbut\b|\band\b|\bbecause\b|\bsince\b|\bso that\b", re.IGNORECASE
)
"""Where one thing that is said ends and another begins; "anything but" goes on."""
BETWEEN = re.compile(r"(\bbetween\b[^,.;!?]*?) and\b", re.IGNORECASE)
EXCEPTED = frozenset(["but", "except", "besides", "save"])
"""After "everything" or "anything" these name what is left as it is."""
AT_ONCE = frozenset(["at", "after", "before", "from", "in", "into", "when", "as", "now", "then",
                     "there", "here", "away", "on", "off"])  # fmt: skip
"""Before these "right" is no side: right at the start, right after it."""
ENDING = frozenset(["end", "finish", "cease"])
"""Verbs with which a time says how long something lasts."""
NEAR = 3
"""How many words a denial, or a "too", may stand before what it speaks of."""
DENIED = frozenset(["not", "never", "no", "without", "neither", "nor"])
OF_THE_WORLD = frozenset({"weight", "friction", "rolling", "bounciness"})
"""Quantities that a plain sentence states as facts; of others it tells how the event went."""


@dataclass(frozen=True, slots=True)
class Wish:
    """One thing that is asked for.

    quantity: a key of `degrees.yaml`, for kind "degree". sign: +1 more, −1 less, 0 not said; for a
    side +1 left, −1 right, for a way +1 where it is asked for. ways: where to go. clause: the words
    around it, to find out whose it is. whole: said of the event or its film as a whole. air: said
    of wind.
    """

    kind: Kind
    quantity: str = ""
    sign: int = 0
    clause: tuple[str, ...] = ()
    whole: bool = False
    air: bool = False
    ways: tuple[Way, ...] = ()


@dataclass(frozen=True, slots=True)
class _Degree:
    at: int
    quantity: str
    sign: int
    form: Literal["plain", "compared", "verb", "noun"]


def wishes(text: str) -> tuple[Wish, ...]:
    """All that a text asks to be otherwise, in its order; empty where nothing is recognised."""
    found = [wish for clause in _clauses(text) for wish in _of(clause)]
    # What is said of the whole once is said of the whole.
    of_all = {wish.quantity for wish in found if wish.whole}
    return tuple(replace(one, whole=one.whole or one.quantity in of_all) for one in found)


def _clauses(text: str) -> Iterator[tuple[str, ...]]:
    for part in CLAUSE.split(BETWEEN.sub(r"\1", text)):
        words = tuple(token.text for token in tokenise(part) if token.text[0].isalnum())
        if words:
            yield words


def _of(words: Sequence[str]) -> list[Wish]:
    known = degrees()
    told = tuple(words)
    if _is_kept(words):
        return [Wish("keep", clause=told)]
    ways = _ways(words)
    if (not ways and any(singular(word) in known.photo for word in words)) or _is_cut_out(words):
        return [Wish("photo", clause=told)]
    side = _side(words)
    if side is not None:
        # "More to the left" is by degrees.
        sides: tuple[Way, ...] = () if DEGREES & set(words) else ("left", "right")
        return [Wish("side", sign=side, clause=told, ways=sides[side < 0 : 1 + (side <= 0)])]
    whole = any(word in known.whole for word in words)
    if _phrase(words, "slow", "motion") or _phrase(words, "time", "lapse"):
        return [Wish("pace", sign=-1 if "slow" in words else 1, clause=told)]
    air = any(singular(word) in known.air for word in words)
    found = _told_once(words, _degrees(words))
    where = [Wish("way", sign=int(_is_asked(words)), clause=told, ways=ways)] if ways else []
    return where + [Wish("degree", d.quantity, _sign(words, d), told, whole, air) for d in found]


def _phrase(words: Sequence[str], *phrase: str) -> bool:
    return any(tuple(words[at : at + len(phrase)]) == phrase for at in range(len(words)))


# --- hands off, the photo, sides ----------------------------------------------------------------


def _is_kept(words: Sequence[str]) -> bool:
    """ "leave it alone", "keep it as it is", "don't touch it", "it was fine"."""
    known = degrees()
    denied = [at for at, word in enumerate(words) if word in DENIED]
    bases = [_base(word) for word in words]
    # "must not touch it" is said of a thing in the event, "do not touch it" to whoever changes it.
    told = [at for at in denied if at == 0 or words[at - 1] in ("do", "please")]
    if any(b in known.touching for at in told for b in bases[at + 1 : at + 1 + NEAR]):
        return True
    if any(a.endswith("thing") and b in EXCEPTED for a, b in pairwise(words)):
        return True
    if bases[0] == "leave" and {"alone", "as"} & set(words):
        return True
    if bases[0] == "keep" and {"as", "like", "unchanged", "this", "that"} & set(words):
        return True
    praised = any(word in known.praise for word in words[-1:])
    return praised and not denied and any(word in ("is", "was", "were", "are") for word in words)


def _is_cut_out(words: Sequence[str]) -> bool:
    """ "the cut-out", and "that is not the pear": what was taken for a thing is another."""
    if _phrase(words, "cut", "out"):
        return True
    return any(
        words[at] in ("is", "are", "was", "that", "this", "it")
        and tuple(words[at + 1 : at + 3]) in (("not", "the"), ("not", "a"))
        for at in range(len(words) - 3)
    )


def _tells(words: Sequence[str], at: int) -> bool:
    """Whether a side tells things apart ("hits the left pin") or is none ("right at the start")
    instead of saying where to go."""
    if words[at] == "right" and AT_ONCE & set(words[at + 1 : at + 2]):
        return True
    which = at + 1 < len(words) and at > 0 and words[at - 1] in ("the", "a", "its", "that")
    return which and words[max(at - 2, 0)] not in ("to", "toward", "towards")


def _side(words: Sequence[str]) -> int | None:
    """+1 left, −1 right, 0 some other way than now; None where no side is asked for."""
    known, said = degrees(), {"left": 1, "right": -1, "leftward": 1, "rightward": -1}
    # "It curves to the left" may be a complaint, "too far left" is one.
    turned = -1 if "too" in words else int(_is_asked(words) or not _is_told(words))
    sides = [
        turned * said[word]
        for at, word in enumerate(words)
        if word in said and not _tells(words, at)
    ]
    steered = any(_base(word) in known.steering or word in known.steering for word in words)
    driven = any(_sense_is_driving(word) for word in words)
    driven = driven or any(_phrase(words, "to", "the", side) for side in ("left", "right"))
    if sides and len(set(sides)) == 1 and (steered or driven) and not _is_place(words):
        return sides[0]
    if sides and steered:
        return 0
    wrong = {"wrong", "other", "another", "different", "opposite"} & set(words)
    order = any(_phrase(words, "way", around) for around in ("round", "around"))
    return 0 if wrong and not order and any(word in known.sides for word in words) else None


def _ways(words: Sequence[str]) -> tuple[Way, ...]:
    """Where words want a thing to go, other than to a side; both where either could be meant."""
    for at, word in enumerate(words):
        if word in ("away", "toward", "towards") and LENSES & set(words[at + 1 : at + 4]):
            return ("away",) if word == "away" else ("toward_camera",)
        # "Back" is said of versions and of time as well.
        if word != "back" and (way := DIRECTIONS.get(word)) in WAYS:
            return WAYS[way]
    return ()


def _is_asked(words: Sequence[str]) -> bool:
    known = degrees().steering
    named = _is_wished(words) and not (words[0].endswith("s") and _is_told(words[:1]))
    return named or any(_base(word) in known or word in known for word in words)


def _is_told(words: Sequence[str]) -> bool:
    """Whether a verb of motion says what happens, "it curves"."""
    return any(
        _sense_is_driving(word) and word.endswith("s") and word != _base(word) for word in words
    )


def _is_place(words: Sequence[str]) -> bool:
    """ "on the right side", "to the left of": where something is, not where it should go."""
    return any(
        tuple(words[max(at - 2, 0) : at]) == ("on", "the") or "of" in words[at + 1 : at + 2]
        for at, word in enumerate(words)
        if word in ("left", "right")
    )


def _sense_is_driving(word: str) -> bool:
    base = verb_base(word)
    return base is not None and VERBS[base].kind in ("act", "move")


# --- degrees ------------------------------------------------------------------------------------


def _degrees(words: Sequence[str]) -> Iterator[_Degree]:
    for at, word in enumerate(words):
        if tuple(words[at : at + 2]) == ("short", "of"):
            yield _Degree(at, "reach", 1, "compared")
            continue
        if _is_intensifier(words, at):
            continue
        for quantity, row in degrees().quantities.items():
            base = _base(word)
            if sign := (word in row.up or base in row.up) - (word in row.down or base in row.down):
                yield _Degree(at, quantity, sign, "verb")
            elif (form := _form(word, quantity)) is not None:
                yield _Degree(at, quantity, form[0], "compared" if form[1] else "plain")
            elif singular(word) in row.of or base in row.of:
                yield _Degree(at, quantity, 1, "noun")
        if _is_amount(words, at):
            yield _Degree(at, "strength", 1, "noun")
        if word in degrees().deep:
            yield _Degree(at, "rolling", 1, "plain")
        if _base(word) == "weigh":
            yield _Degree(at, "weight", 1, "noun")
        if word in degrees().beyond and {"the", "a", "it"} & set(words[at + 1 : at + 2]):
            yield _Degree(at, "reach", -1, "verb")


def _is_amount(words: Sequence[str], at: int) -> bool:
    """ "less wind", "too much push": so much of what is done, by its verb or by air."""
    before = words[at - 1] if at else ""
    done = _sense_is_driving(words[at]) or singular(words[at]) in degrees().air
    return before in ("less", "more", "much", "enough", "little") and done


def _is_intensifier(words: Sequence[str], at: int) -> bool:
    """ "far too slow", "way faster", "light years": "far" says how much, not how far."""
    follows = tuple(words[at + 1 : at + 2])
    return words[at] in ("far", "way") and bool(follows) and (
        follows[0] in ("too", "more", "less") or follows[0].endswith("er")
    )  # fmt: skip


def _form(word: str, quantity: str) -> tuple[int, bool] | None:
    """(sign, whether it is a comparative) of an adjective or adverb of a quantity."""
    row = degrees().quantities[quantity]
    for base, compared in _plain_forms(word):
        if base in row.more:
            return 1, compared
        if base in row.less:
            return -1, compared
    return None


@cache
def _plain_forms(word: str) -> tuple[tuple[str, bool], ...]:
    """What a word may be a form of, and whether it compares: strongly, stronger, later."""
    irregular = {"further": "far", "farther": "far"}
    found = [(word, False), (irregular.get(word, word), word in irregular)]
    if word.endswith("ed"):  # oiled, iced
        found.append((word[:-2] + "y", False))
    if word.endswith("ily"):
        found.append((word[:-3] + "y", False))
    if word.endswith("ly"):
        found += [(word[:-2], False), (word[:-2] + "le", False), (word[:-1] + "e", False)]
    for ending in ("er", "est"):
        if word.endswith(ending) and len(word) > len(ending) + 2:
            stem = word[: -len(ending)]
            bases = [stem, stem + "e"] + ([stem[:-1]] if stem[-1] == stem[-2] else [])
            bases += [stem[:-1] + "y"] if stem.endswith("i") else []
            found += [(base, True) for base in bases]
    return tuple(found)


def _told_once(words: Sequence[str], found: Iterator[_Degree]) -> list[_Degree]:
    """One degree of each quantity: a comparative or verb before a plain one, that before a noun."""
    order = ("compared", "verb", "plain", "noun")
    best: dict[str, _Degree] = {}
    for one in found:
        now = best.get(one.quantity)
        if now is None or order.index(one.form) < order.index(now.form):
            best[one.quantity] = one
    # "Wait longer": how long one waits is when it begins; "ends later": when it ends, how long.
    timed = best.get("time")
    if timed is not None and any(_base(word) in ENDING for word in words):
        best["length"] = replace(best.pop("time"), quantity="length")
        timed = None
    if timed is not None and (timed.form == "verb" or "length" in best):
        best.pop("length", None)
    return sorted(best.values(), key=lambda one: one.at)


def _sign(words: Sequence[str], one: _Degree) -> int:
    """+1 more, −1 less, 0 where it is not said which is wanted."""
    before = tuple(words[max(one.at - NEAR, 0) : one.at])
    denied = any(word in DENIED for word in before)
    if one.form == "noun":
        return 0 if one.quantity == "time" else _turned(words, one)
    if one.form == "verb":
        hardly = _hardly(before)
        told = one.quantity in OF_THE_WORLD or words[one.at] == _base(words[one.at]) + "s"
        stated = told and not _is_wished(words)
        return -one.sign if denied or hardly else 0 if stated else one.sign
    enough = "enough" in words[one.at + 1 : one.at + 2]
    if enough and one.quantity not in OF_THE_WORLD:
        return one.sign if denied else 0
    if denied:
        # "not stronger" may ask for as much as now; "not so strong" asks for less.
        return 0 if one.form == "compared" else -one.sign
    if _hardly(before):
        return -one.sign
    if one.form == "compared":
        return one.sign
    if "too" in before or ("so" in before and "that" in words[one.at :]):
        return -one.sign
    if "so" in before or "that" in before[-1:]:
        return -one.sign
    if "more" in before or one.quantity in OF_THE_WORLD or _is_wished(words):
        return one.sign
    return 0


def _hardly(before: Sequence[str]) -> bool:
    """ "barely", "less", "little", but not "a little", which says how much."""
    return any(
        word in degrees().hardly and (word != "little" or "a" not in before) for word in before
    )


def _turned(words: Sequence[str], one: _Degree) -> int:
    """Which way a quantity that is named is turned: "more force", "take some power out"."""
    known = degrees()
    around = [*words[: one.at], *words[one.at + 1 :]]
    if any(word in known.hardly for word in around) or any(word in DENIED for word in around):
        return -1
    if any(_base(word) in known.lowering for word in around):
        return -1
    up = {"more", "extra", "additional", "much", "lot"} & set(around)
    if up and "too" in around:
        return -1
    return 1 if up or any(_base(word) in known.raising for word in around) else 0


def _is_wished(words: Sequence[str]) -> bool:
    """Whether it is asked for: an imperative, "let", "make", "should", "must"."""
    if any(word in degrees().must for word in words):
        return True
    return _base(words[0]) in ("let", "make", "have") or _sense_is_driving(words[0])


@cache
def _base(word: str) -> str:
    """The plain form of a verb, also of one that the reader of events does not know."""
    known = verb_base(word)
    if known is not None:
        return known
    listed = _every_verb()
    stems = [word]
    for ending in ("ing", "ed", "es", "s"):
        if word.endswith(ending) and len(word) > len(ending) + 1:
            stem = word[: -len(ending)]
            stems += [stem, stem + "e", stem[:-1] if stem[-1:] == stem[-2:-1] else stem]
    return next((stem for stem in stems if stem in listed), word)


@cache
def _every_verb() -> frozenset[str]:
    known = degrees()
    rows = known.quantities.values()
    told = (known.raising, known.lowering, known.touching, known.steering)
    return frozenset().union(
        {"leave", "keep", "weigh"}, ENDING, *told, *(row.up | row.down for row in rows)
    )
