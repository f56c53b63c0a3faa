"""From noun phrases to the case's objects, supports and landmarks."""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from types import MappingProxyType
from typing import Any

from physagent_studio.knowledge import kind_of, word_lists
from physagent_studio.language.reference.selecting import filtered
from physagent_studio.language.reference.stock import (
    FUNCTION_WORDS,
    Discourse,
    Inventory,
    Thing,
    thing,
)
from physagent_studio.language.syntax.phrases import NounPhrase
from physagent_studio.language.tokens import vocabulary as v
from physagent_studio.language.tokens.tokens import singular
from physagent_studio.language.tokens.vocabulary import words_of
from physagent_studio.program.scene.state import Grounding


def inventory(
    objects: Sequence[tuple[str, Grounding]],
    supports: Sequence[tuple[str, Grounding]] = (),
    landmarks: Sequence[str] = (),
    extents: Mapping[str, tuple[float, float]] = MappingProxyType({}),
    stacks: tuple[tuple[str, ...], ...] = (),
    on: tuple[tuple[str, str], ...] = (),
) -> Inventory:
    """The inventory of a case; how large its objects are and what stands on what, if known."""
    own = tuple(
        replace(thing(name, grounding), extents=extents.get(name)) for name, grounding in objects
    )
    carried = tuple(thing(name, grounding) for name, grounding in supports)
    places = tuple(thing(name) for name in landmarks)
    ground = next((s.name for s in carried if s.words[-1] in v.GROUND_WORDS), "floor")
    words = {w for t in (*own, *carried, *places) for w in t.words if w not in v.POSITIONS}
    words -= FUNCTION_WORDS
    words |= {near for w in words for near in _alike(w)} | set(v.LANDMARKS) | set(v.GROUND_WORDS)
    words |= {w for row in v.SUPPORT_CLASSES.values() for w in row if w not in v.VERBS}
    words |= {t.name.lower() for t in (*own, *carried, *places)}
    words -= (v.ORDINALS.keys() | v.COLOURS | v.SIZES.keys() | v.MATERIAL_WORDS) - _heads(own)
    return Inventory(own, carried, places, ground, frozenset(words), stacks, on)


def _heads(things: Iterable[Thing]) -> frozenset[str]:
    return frozenset(t.head for t in things)


def _alike(word: str) -> frozenset[str]:
    found = [row for row in v.SYNONYMS if word in row]
    return frozenset().union(*found) if found else frozenset()


@dataclass(frozen=True, slots=True)
class Resolved:
    """Objects that a phrase stands for; any_one: one of them is meant; as_one: several that are
    named together.

    least, most: how many of them, where the phrase sets a limit.
    """

    names: tuple[str, ...]
    any_one: bool = False
    least: int = 0
    most: int | None = None
    as_one: bool = False

    @property
    def counts(self) -> dict[str, Any]:
        """How many of the names are meant, as the fields of an event frame."""
        counts = {"any_one": self.any_one, "least": self.least, "most": self.most}
        return {**counts, "as_one": self.as_one and len(self.names) > 1}


def resolve_objects(
    phrase: NounPhrase, stock: Inventory, talk: Discourse, *, subject_of_clause: bool = False
) -> Resolved | None:
    """The objects meant by a noun phrase, or None where it names no object of the case."""
    if phrase.pronoun:
        return of_pronoun(phrase.head, stock, talk, subject_of_clause)
    if phrase.head == "rest" and not phrase.determiner:
        # "Comes to rest".
        return None
    of = phrase.of if phrase.head in v.MASS_HEADS else None
    if of is not None and (inner := _candidates(of, stock)):
        return _choose(phrase, inner, stock, talk, of)
    if is_group(phrase, stock):
        group = next((m for m in reversed(talk.mentions) if len(m) > 1), ())
        everything = tuple(t.name for t in stock.objects)
        telling = v.OTHERS | v.POSITIONS.keys() | v.ORDINALS.keys()
        others = any(a in telling for a in phrase.adjectives)
        if others or phrase.head in ("one", "other", "rest", "each", "both", "all"):
            kind = _class_of_last(stock, talk)
            fresh = tuple(t for t in kind if t.name not in talk.known)
            plain = phrase.head == "one" and phrase.adjectives == ("one",)
            # "Two of the pins fall, one stays up": one of those not spoken of yet.
            kind = fresh if plain and not phrase.determiner and fresh and talk.known else kind
            return _choose(phrase, kind, stock, talk, phrase)
        whole = _whole(phrase.head, stock)
        if whole or group:
            return Resolved(whole or group, as_one=phrase.head in GROUPS)
        rest = tuple(n for n in everything if subject_of_clause or n not in talk.subject)
        return Resolved(rest) if len(rest) > 1 else None
    if phrase.of is not None and phrase.head in v.SIDES:
        # "The back of the plate" is the plate.
        return resolve_objects(phrase.of, stock, talk)
    if phrase.head in v.OTHERS or (not phrase.nouns and phrase.adjectives):
        return _choose(phrase, _class_of_last(stock, talk), stock, talk, phrase)
    found = _besides(talk.acting, _candidates(phrase, stock))
    return _choose(phrase, found, stock, talk, phrase) if found else None


def of_its_owner(phrase: NounPhrase, stock: Inventory) -> NounPhrase:
    """ "Bumps against its leg", "the leg of the chair": against the thing whose part that is."""
    if phrase.head not in v.LIMBS or any(phrase.head in t.words for t in stock.objects):
        return phrase
    own = replace(phrase, head="it", nouns=(), pronoun=True)
    return own if phrase.determiner == "its" else phrase.of or phrase


def _besides(acting: tuple[str, ...], found: tuple[Thing, ...]) -> tuple[Thing, ...]:
    """ "The red can hits the can": a noun beside the subject means another thing, or nothing here.

    Where several act, it may be one of them.
    """
    others = tuple(t for t in found if t.name not in acting)
    return others or (found if len(acting) > 1 else ())


def _whole(head: str, stock: Inventory) -> tuple[str, ...]:
    """ "The tower" is what stands on one another, "the row" the things of one kind."""
    if head in _PILES:
        return max(stock.stacks, key=len, default=())
    if head not in ("row", "line", "set", "bunch"):
        return ()
    kinds: dict[str, list[str]] = {}
    for t in stock.objects:
        kinds.setdefault(t.head, []).append(t.name)
    largest = max(kinds.values(), key=len, default=[])
    return tuple(largest) if len(largest) > 2 else ()


def is_group(phrase: NounPhrase, stock: Inventory) -> bool:
    """Whether the phrase names a group ("the stack") and no object of the case."""
    named = any(phrase.head in t.words for t in stock.objects)
    return phrase.head in GROUPS | COUNTERS and not named


def of_pronoun(word: str, stock: Inventory, talk: Discourse, subject: bool) -> Resolved | None:
    """The objects that a pronoun stands for; `subject`: it is the subject of its clause."""
    everything = tuple(t.name for t in stock.objects)
    if word == "all" and (group := _all_of_them(stock, talk)):
        return Resolved(group)
    if word in ("everything", "all"):
        return Resolved(everything)
    if word in ("itself", "themselves"):
        return Resolved(talk.subject) if talk.subject else None
    if word in ("any", "anything"):
        groups = (m for m in reversed(talk.mentions) if len(m) > 1 and m != talk.subject)
        group = next(groups, ()) if word == "any" else ()
        rest = tuple(name for name in everything if name not in talk.subject)
        return Resolved(group or rest) if group or rest else None
    if word == "others":
        rest = tuple(name for name in everything if name not in talk.known)
        return Resolved(rest) if rest else None
    if word in ("they", "them", "both", "these", "those", "each"):
        group = next((m for m in reversed(talk.mentions) if len(m) > 1), ())
        pair = _last_two(talk, word == "they") if word == "both" or not group else ()
        # "The first domino is pushed and they fall one by one".
        found = pair or group or _all_of_them(stock, talk)
        return Resolved(found) if found else None
    if word not in ("it", "one", "that", "this", "he", "she", "him"):
        return None
    if subject and talk.subject:
        # "Neither cup is touched by the ball as it rolls by": of one thing, where one was named.
        single = next((m for m in reversed(talk.mentions) if len(m) == 1), ())
        apart = single and len(talk.subject) > 1 and not set(single) & set(talk.subject)
        return Resolved(single if apart else talk.subject)
    # "Hits the crate and tips it over" is not about itself, where nothing else is known by a name.
    own = talk.subject if talk.subject != talk.acting else ()
    other = next((m for m in reversed(talk.mentions) if m != talk.subject), own)
    return Resolved(other) if other else None


def _all_of_them(stock: Inventory, talk: Discourse) -> tuple[str, ...]:
    """ "The marble hits the first domino and all fall": those spoken of, or all of that kind."""
    group = next((m for m in reversed(talk.mentions) if len(m) > 1), ())
    heads = {t.head for t in stock.objects if talk.mentions and t.name in talk.mentions[-1]}
    kind = tuple(t.name for t in stock.objects if t.head in heads)
    return group or (kind if len(kind) > 2 else ())


def _last_two(talk: Discourse, acting: bool) -> tuple[str, ...]:
    """The two last spoken of; acting: the subject and what was named beside it, as in "rolls to
    the ball until they touch"."""
    seen = list(talk.subject) if acting and len(talk.subject) == 1 else []
    for names in reversed(talk.mentions):
        seen += [name for name in names if name not in seen]
    return tuple(reversed(seen[:2])) if len(seen) >= 2 else ()


def _class_of_last(stock: Inventory, talk: Discourse) -> tuple[Thing, ...]:
    """Objects of the same kind as the last one spoken of, else all."""
    by_name = {t.name: t for t in stock.objects}
    for names in reversed(talk.mentions):
        heads = {by_name[name].head for name in names if name in by_name}
        found = tuple(t for t in stock.objects if t.head in heads)
        if len(found) > 1:
            return found
    return stock.objects


def _candidates(phrase: NounPhrase, stock: Inventory) -> tuple[Thing, ...]:
    """Objects whose name fits the phrase's nouns; adjectives are looked at afterwards."""
    if phrase.head in v.GENERIC:
        return stock.objects
    for test in (_same_name, _head_fits, _word_fits, _synonym_fits):
        found = tuple(t for t in stock.objects if test(phrase, t))
        if test is _same_name and phrase.plural and all(t.name == phrase.head for t in found):
            # "The pins" are all of them, also where one is called "pin" alone.
            continue
        if found:
            if test is _same_name:
                found = _called_so(phrase, stock) or found
            # The cue ball is the white one.
            kind = kind_of("_".join(phrase.nouns))
            usual = set(() if kind is None else kind.colours)
            found = tuple(t for t in found if usual & set(t.words)) or found
            exact = tuple(t for t in found if {singular(n) for n in phrase.nouns} <= set(t.words))
            return exact or found
    return ()


def _same_name(phrase: NounPhrase, t: Thing) -> bool:
    return t.name.lower() in phrase.nouns or phrase.head == t.name.lower()


def _called_so(phrase: NounPhrase, stock: Inventory) -> tuple[Thing, ...]:
    """ "The big coin" is the one of that name, beside one that is called "coin"."""
    said = set(phrase.adjectives)
    return tuple(t for t in stock.objects if _head_fits(phrase, t) and said & set(t.words))


def _head_fits(phrase: NounPhrase, t: Thing) -> bool:
    return phrase.head == t.head


def _word_fits(phrase: NounPhrase, t: Thing) -> bool:
    place = phrase.head in v.POSITIONS or phrase.head in v.GROUND_WORDS | v.TABLE_WORDS
    compound = len(phrase.head) > 2 and any(word.endswith(phrase.head) for word in t.words)
    compound = compound or (len(t.head) > 3 and phrase.head.endswith(t.head))
    return (phrase.head in t.words or compound) and not place


def _synonym_fits(phrase: NounPhrase, t: Thing) -> bool:
    return any(phrase.head in _alike(word) for word in t.words)


def _choose(
    phrase: NounPhrase,
    found: tuple[Thing, ...],
    stock: Inventory,
    talk: Discourse,
    inner: NounPhrase,
) -> Resolved | None:
    adjectives = (*phrase.adjectives, *(inner.adjectives if inner is not phrase else ()))
    if any(a in v.OTHERS for a in (*adjectives, phrase.head)) or phrase.determiner == "another":
        fresh = tuple(t for t in found if t.name not in talk.known)
        names = {t.name for t in found}
        group = next((m for m in reversed(talk.mentions) if len(m) > 1 and set(m) <= names), ())
        if not fresh and group:
            # "One of the two falls, the other one stays": which of them is left open.
            several = phrase.plural or phrase.head in ("others", "rest")
            return Resolved(group, any_one=not several)
        found = fresh
    if phrase.alternatives:
        parts = [filtered(found, group, None, talk) for group in phrase.alternatives]
        names = {t.name: None for part in parts for t in part}
        return Resolved(tuple(names)) if names else None
    number = phrase.number if phrase.number is not None else inner.number
    kept = filtered(found, adjectives, number, talk, stock)
    if not kept:
        return None
    return _quantify(phrase, inner, kept, number, talk)


def _quantify(
    phrase: NounPhrase,
    inner: NounPhrase,
    kept: tuple[Thing, ...],
    number: int | None,
    talk: Discourse,
) -> Resolved:
    names = tuple(t.name for t in kept)
    bound = phrase.bound or inner.bound
    if bound and number is not None and len(names) > 1:
        return _limited(names, bound, number)
    if len(names) > 1 and (share := _share_of(phrase, inner, len(names))) is not None:
        return Resolved(names, least=share[0], most=share[1])
    one_of = phrase.head == "one" or number == 1
    if phrase.head == "one" and phrase.adjectives == ("one",) and not phrase.determiner:
        # "…, but only one falls": whichever of them.
        return Resolved(names, any_one=len(names) > 1)
    if len(names) == 1:
        return Resolved(names)
    if one_of and (inner is not phrase or not (phrase.determiner or phrase.plural)):
        return Resolved(names, any_one=True)
    if phrase.determiner == "either":
        return Resolved(names, any_one=True)
    if number is not None and inner is not phrase and number < len(names):
        # "Two of the three cups": whichever two, and no third.
        return Resolved(names, least=number, most=number)
    if number is not None:
        return Resolved(names[:number])
    if inner.head in v.COLLECTIVES and inner.determiner not in ("a", "an", "another"):
        return Resolved(names)
    every = {phrase.determiner, inner.determiner, phrase.head} & {"all", "both", "each", "every"}
    if phrase.plural or inner.plural or every:
        return Resolved(names, as_one=not every)
    if phrase.head in v.OTHERS:
        return Resolved(names)
    last = next((m for m in reversed(talk.mentions) if len(m) == 1 and m[0] in names), None)
    if last is not None and phrase.determiner in ("the", "that", "this", "its"):
        return Resolved(last)
    return Resolved(names, any_one=True)


def _limited(names: tuple[str, ...], bound: str, number: int) -> Resolved:
    """ "At least two of the pins", "no more than one"."""
    low, high = {
        "atleast": (number, None), "morethan": (number + 1, None), "atmost": (0, number),
        "fewerthan": (0, max(number - 1, 0)), "exactly": (number, number),
    }[bound]  # fmt: skip
    return Resolved(names, least=min(low, len(names)), most=high)


def of_them(phrases: Sequence[NounPhrase], count: int) -> Resolved | None:
    """ "One of the cup, the box and the ball": how many of what is listed; None where the first
    phrase counts nothing."""
    first = phrases[0] if phrases else None
    if first is None or first.of is None or len(phrases) < 2 or not 0 < (first.number or 0) < count:
        return None
    number = first.number or 0
    if first.bound:
        return _limited(("",) * count, first.bound, number)
    return Resolved((), any_one=number == 1) if number == 1 else Resolved((), False, number, number)


def _share_of(phrase: NounPhrase, inner: NounPhrase, count: int) -> tuple[int, int | None] | None:
    """ "Most pins", "some of the pins", "half of them": from how many to how many."""
    words = {phrase.determiner, phrase.head if inner is not phrase else "", *phrase.adjectives}
    if "most" in words:
        return count // 2 + 1, None
    if "allbutone" in words:
        return count - 1, count - 1
    if "some" in words and (phrase.plural or inner.plural):
        return 1, None
    if "half" in words and inner is not phrase:
        return count // 2, count // 2
    return None


COUNTERS = words_of("one two three both all each some other rest half number")
_PILES, GROUPS = word_lists().stacked, word_lists().grouped
