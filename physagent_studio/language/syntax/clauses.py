"""From chunks to clauses: one verb each, with its subjects, objects, places and adverbs."""

import itertools
from collections.abc import Sequence
from dataclasses import dataclass, replace

from physagent_studio.language.syntax.phrases import Chunk, NounPhrase
from physagent_studio.language.tokens import vocabulary as v


@dataclass(frozen=True, slots=True)
class RawClause:
    """One verb with what belongs to it.

    start, end: chunk indices. joint: what introduces it. complement: its subject is the object
    of the clause before ("makes it stop"). lead: places said before the subject. sequel: a
    word says that it comes after the clause before ("then", "finally"). either: which of its
    subjects and objects are alternatives ("the cup or the box").
    """

    verb: Chunk | None
    subjects: tuple[NounPhrase, ...] = ()
    objects: tuple[NounPhrase, ...] = ()
    places: tuple[tuple[str, NounPhrase], ...] = ()
    lead: tuple[tuple[str, NounPhrase], ...] = ()
    adverbs: tuple[str, ...] = ()
    joint: str = ""
    relative: bool = False
    complement: bool = False
    sequel: bool = False
    either: frozenset[str] = frozenset()
    start: int = 0
    end: int = 0


_AFTERWARDS = ("then", "finally", "afterwards", "afterward", "subsequently", "next", "later")
_JOINERS = ("and", "sub", "rel", "stop")


def split(chunks: Sequence[Chunk]) -> tuple[RawClause, ...]:
    """The clauses in order; chunks without any verb make one clause without a verb."""
    verbs = [i for i, chunk in enumerate(chunks) if chunk.kind == "verb"]
    if not verbs:
        return (RawClause(None, end=len(chunks)),) if chunks else ()
    first = _first_sentence(chunks, verbs[0])
    starts = [first]
    starts += [_boundary(chunks, before, verb) for before, verb in itertools.pairwise(verbs)]
    ends = [*starts[1:], len(chunks)]
    found: list[RawClause] = [RawClause(None, end=first)] if first else []
    for start, verb, end in zip(starts, verbs, ends, strict=True):
        # "… while the crowd cheers": what comes after such a word is a clause of its own, even
        # if no verb in it is known.
        cut = next((i for i in range(verb + 1, end) if chunks[i].kind == "sub"), end)
        cut = _apposition(chunks, verb, cut)
        spared = _spared(chunks, verb, cut)
        then = _then(chunks, verb, spared)
        found.append(_clause(chunks, start, verb, then))
        while then < spared:
            onward = _then(chunks, then - 1, spared)
            found.append(_again(found[-1], chunks[then:onward], then, onward))
            then = onward
        if spared < cut:
            found.append(_without(found[-1], chunks[spared:cut], spared, cut))
        if cut < end:
            found.append(RawClause(None, start=cut, end=end))
    return tuple(_resumed(_passive_on(_taken_up(found, chunks))))


def _passive_on(found: Sequence[RawClause]) -> list[RawClause]:
    """ "Is picked up and put into the cup": what is done to it goes on without another "is"."""
    out: list[RawClause] = []
    for clause in found:
        verb, before = clause.verb, out[-1].verb if out else None
        joined = clause.joint in ("", "and", "then") and not clause.objects
        if (
            verb is not None and before is not None and before.passive and verb.form == "pp"
            and joined and not clause.subjects and not clause.relative
        ):  # fmt: skip
            clause = replace(clause, verb=replace(verb, passive=True))
        if verb is not None and before is not None and _goes_on(clause):
            clause = replace(clause, joint="and")
        out.append(clause)
    return out


def _goes_on(clause: RawClause) -> bool:
    """ "Someone lifts the cup, carries it to the left": who lifts it carries it, as after "and"."""
    active = clause.verb is not None and clause.verb.form == "s" and not clause.verb.passive
    told = bool(clause.objects) and all(one.pronoun for one in clause.objects)
    own = clause.subjects or clause.relative or clause.complement or clause.joint
    return active and told and not own


def _first_sentence(chunks: Sequence[Chunk], verb: int) -> int:
    """ "A nudge to the top book; nothing else moves": where the sentence of the verb begins."""
    stops = [i for i in range(verb) if chunks[i].strong_stop]
    told = stops and any(chunk.np is not None for chunk in chunks[: stops[-1]])
    return stops[-1] + 1 if told else 0


def _resumed(found: Sequence[RawClause]) -> list[RawClause]:
    """ "One rolls off the table; the other does not": an auxiliary alone repeats the verb."""
    out: list[RawClause] = []
    for clause in found:
        verb = clause.verb
        told = next((c for c in reversed(out) if c.verb is not None and c.verb.verb != "?"), None)
        alone = verb is not None and verb.verb == "?" and set(verb.word.split()) <= _ALONE
        if verb is not None and verb.verb == "be" and told is not None and told.verb is not None:
            # "Two are knocked over; the other is not".
            bare = not (clause.objects or clause.places or set(clause.adverbs) - {"not"})
            alone = bare and told.verb.passive and clause.joint in ("", "and", "but", "while")
        # "The hammer falls and the can follows": it does so too, after it.
        follows = verb is not None and verb.verb == "follow" and not clause.objects
        alone = alone or (follows and bool(clause.subjects))
        clause = replace(clause, sequel=clause.sequel or follows)
        if verb is not None and alone and told is not None and told.verb is not None:
            # "Someone tips the first one and the rest follow": it is done to them too.
            passive = told.verb.passive or (follows and bool(told.objects))
            again = replace(
                told.verb, start=verb.start, end=verb.end, negated=verb.negated, passive=passive
            )
            clause = replace(
                clause, verb=again, objects=clause.objects or (() if follows else told.objects),
                places=clause.places or told.places,
                adverbs=(*(a for a in told.adverbs if a != "not"), *clause.adverbs),
            )  # fmt: skip
        out.append(clause)
    return out


_ALONE = {"does", "do", "did", "not", "is", "are", "was", "were", "will", "has", "have"}


def _boundary(chunks: Sequence[Chunk], before: int, verb: int) -> int:
    """Index of the chunk with which the clause of `verb` begins."""
    strong = [i for i in range(before + 1, verb) if chunks[i].strong_stop]
    if strong:
        return strong[-1] + 1
    hard = [i for i in range(before + 1, verb) if chunks[i].kind in ("sub", "rel")]
    joiners = [i for i in range(before + 1, verb) if chunks[i].kind in _JOINERS]
    if not joiners:
        return verb
    if hard:
        about = _antecedent(chunks, hard[-1])
        if (
            about is not None
            and before < about - 1
            and _resumes(chunks, hard[-1], verb) is not None
        ):
            # "The lamp falls, but the vase, which stood there, is not hit".
            return _run_start(chunks, about - 1, before)
        return _run_start(chunks, hard[-1], before)
    last = joiners[-1]
    return _run_start(chunks, last, before)


def _antecedent(chunks: Sequence[Chunk], relative: int) -> int | None:
    """Index of what a relative clause hangs on, where that is a subject: it opens a clause."""
    if chunks[relative].kind != "rel":
        return None
    index = relative - 1
    index -= index > 0 and chunks[index].kind == "stop"
    while index > 0 and chunks[index].kind == "pp":
        index -= 1
    opens = index == 0 or chunks[index - 1].kind in ("and", "sub", "stop")
    return index if index >= 0 and chunks[index].kind == "np" and opens else None


_CAUSING = ("make", "let", "cause", "see", "send", "set", "get")


def _resumes(chunks: Sequence[Chunk], relative: int, verb: int) -> int | None:
    """Index of the verb with which the sentence goes on behind a relative clause; None where the
    clause is its end."""
    following = next((i for i in range(verb + 1, len(chunks)) if chunks[i].kind == "verb"), None)
    if following is None or not chunks[following].finite or chunks[verb].verb in _CAUSING:
        return None
    between = chunks[verb + 1 : following]
    if any(chunk.kind in ("and", "sub", "rel") or chunk.strong_stop for chunk in between):
        return None
    set_off = relative > 0 and chunks[relative - 1].kind == "stop"
    stops = [i for i, chunk in enumerate(between) if chunk.kind == "stop"]
    if set_off:
        # "…, which is heavy, does not move": the second comma ends it.
        plain = stops and all(chunk.kind == "adv" for chunk in between[stops[-1] + 1 :])
        return following if plain else None
    return following if not stops else None


def _taken_up(found: Sequence[RawClause], chunks: Sequence[Chunk]) -> list[RawClause]:
    """Gives what a relative clause hangs on to the verb with which the sentence goes on."""
    out = list(found)
    for index, (clause, after) in enumerate(itertools.pairwise(found)):
        verb = next((i for i in range(clause.start, clause.end) if chunks[i].kind == "verb"), None)
        if not clause.relative or verb is None or after.subjects or after.verb is None:
            continue
        relative = max(i for i in range(clause.start, verb) if chunks[i].kind == "rel")
        about = _antecedent(chunks, relative)
        goes_on = _resumes(chunks, relative, verb)
        phrase = chunks[about].np if about is not None else None
        if goes_on is None or phrase is None or chunks[goes_on] is not after.verb:
            continue
        joint = next((chunks[i].word for i in range(clause.start, relative) if
                      chunks[i].kind in ("and", "sub")), "")  # fmt: skip
        out[index + 1] = replace(after, subjects=(phrase,), complement=False, joint=joint)
    return out


def _run_start(chunks: Sequence[Chunk], index: int, before: int) -> int:
    while index - 1 > before and (
        chunks[index - 1].kind in ("and", "stop") or chunks[index - 1].word in ("just", "only")
    ):
        index -= 1
    return index


def _clause(chunks: Sequence[Chunk], start: int, verb: int, end: int) -> RawClause:
    head, tail = chunks[start:verb], chunks[verb + 1 : end]
    joint = next((c.word for c in head if c.kind in ("sub", "rel")), "")
    if not joint:
        joint = next((c.word for c in head if c.kind == "and"), "")
    subjects, lead = _subject(head)
    complement = start == verb and start > 0 and not chunks[start - 1].strong_stop
    objects, places = _after_verb(tail)
    return RawClause(
        chunks[verb],
        subjects,
        objects,
        places,
        lead,
        tuple(c.word for c in (*head, *tail) if c.kind in ("adv", "gap")),
        joint,
        any(c.kind == "rel" for c in head),
        complement,
        any(c.word in _AFTERWARDS for c in (*head, *chunks[verb : verb + 2])),
        _either(head, tail),
        start,
        end,
    )


def _apposition(chunks: Sequence[Chunk], verb: int, end: int) -> int:
    """ "Both fall, the cup first", "off the left edge, not the right one": what is set behind a
    comma and is no object of the verb begins a clause of its own; else the end."""
    for index in range(verb + 1, end - 1):
        if chunks[index].kind != "stop":
            continue
        told = any(chunk.np is not None for chunk in chunks[verb + 1 : index])
        after = chunks[index + 1]
        if _is_ranked(chunks[index + 1 : end]):
            # "Both roll to the box, the red one first": no object, wherever they roll.
            return index + 1
        denied = after.kind == "adv" and after.word == "not" and index + 2 < end
        if (denied and chunks[index + 2].kind == "np") or (after.kind == "np" and not told):
            return index + 1
    return end


_RANKS = ("first", "last")


def _is_ranked(chunks: Sequence[Chunk]) -> bool:
    """Whether they begin with "the cup first", "the red one last" or "first the cup"."""
    phrase = next((chunk.np for chunk in chunks[:2] if chunk.np is not None), None)
    alone = phrase is not None and phrase.head in _RANKS and "one" in phrase.adjectives
    return alone or (phrase is not None and any(c.word in _RANKS for c in chunks[:2]))


def _spared(chunks: Sequence[Chunk], verb: int, end: int) -> int:
    """ "Hits the cup but not the box": where what it does not do begins; else the end."""
    for index in range(verb + 1, end - 2):
        plain = chunks[index].kind == "stop" and chunks[index + 2].kind == "pp"
        if (chunks[index].kind, chunks[index].word) != ("and", "but") and not plain:
            continue
        following = chunks[index + 1]
        if following.kind == "adv" and following.word == "not" and chunks[index + 2].np is not None:
            return index
    return end


def _then(chunks: Sequence[Chunk], verb: int, end: int) -> int:
    """ "Hits the cup, then the box": where the verb goes on to another thing; else the end."""
    for index in range(verb + 2, end - 1):
        told = any(c.np is not None for c in chunks[verb + 1 : index]) or chunks[verb].passive
        gone = any(_is_way(c) for c in chunks[verb + 1 : index])
        then = (chunks[index].kind, chunks[index].word) == ("and", "then")
        if then and gone and _is_way(chunks[index + 1]):
            # "Slides to the left, then to the right"; "and then back" is of turning back.
            return index
        # "The cherry falls off, then the candle".
        told |= any(c.np is not None for c in chunks[max(verb - 3, 0) : verb])
        if not then or not told:
            continue
        if chunks[index + 1].kind == "np" and all(c.kind != "gap" for c in chunks[index:end]):
            return index
    return end


_LEVEL = ("left", "right")


def _is_way(chunk: Chunk) -> bool:
    return chunk.kind == "adv" and v.DIRECTIONS.get(chunk.word) in _LEVEL


def _again(told: RawClause, tail: Sequence[Chunk], start: int, end: int) -> RawClause:
    """The same verb of the next thing, afterwards."""
    things, places = _after_verb(tail)
    if not things:
        way = tuple(c.word for c in tail if c.kind == "adv")
        kept = tuple(a for a in told.adverbs if v.DIRECTIONS.get(a) not in _LEVEL)
        fresh = replace(told, lead=(), adverbs=(*kept, *way), joint="then", sequel=True)
        return replace(fresh, start=start, end=end)
    passive = told.verb is not None and (told.verb.passive or not told.objects)
    about = {"subjects": things} if passive else {"objects": things}
    fresh = replace(told, places=places or told.places, lead=(), joint="then", sequel=True, **about)  # type: ignore[arg-type]
    return replace(fresh, start=start, end=end)


def _without(told: RawClause, tail: Sequence[Chunk], start: int, end: int) -> RawClause:
    """The same verb denied of something else."""
    assert told.verb is not None
    objects, places = _after_verb(tail)
    particles: tuple[str, ...] = ()
    if objects and not told.objects:
        # "Knocks down two pins but not the third": the particle goes with both.
        particles = tuple(word for word, _ in told.places[:1])
    subjects = told.subjects
    entry = v.VERBS.get(told.verb.verb)
    if not told.objects and not told.places and entry is not None and entry.kind != "act":
        # "The dominoes fall, but not the last two": those do not.
        subjects, objects = objects, ()
    return replace(
        told, verb=replace(told.verb, negated=not told.verb.negated), objects=objects,
        subjects=subjects, places=places, lead=(), adverbs=(*told.adverbs, *particles), joint="and",
        start=start, end=end,
    )  # fmt: skip


def _either(head: Sequence[Chunk], tail: Sequence[Chunk]) -> frozenset[str]:
    """Which of subjects and objects an "or" joins."""

    def has_or(part: Sequence[Chunk]) -> bool:
        return any(
            chunk.kind == "and" and chunk.word == "or" and part[i - 1].np is not None
            and part[i + 1].np is not None
            for i, chunk in enumerate(part[:-1]) if i
        )  # fmt: skip

    return frozenset(name for name, part in (("subjects", head), ("objects", tail)) if has_or(part))


def _after_verb(
    tail: Sequence[Chunk],
) -> tuple[tuple[NounPhrase, ...], tuple[tuple[str, NounPhrase], ...]]:
    """Objects and places; in "between the cup and the box" both belong to the preposition."""
    objects: list[NounPhrase] = []
    places: list[tuple[str, NounPhrase]] = []
    for index, chunk in enumerate(tail):
        if chunk.np is None:
            continue
        joined = index > 1 and tail[index - 1].kind == "and" and tail[index - 2].kind == "pp"
        if chunk.kind == "pp":
            places.append((chunk.word, chunk.np))
        elif chunk.kind == "np" and joined:
            places.append((tail[index - 2].word, chunk.np))
        elif chunk.kind == "np":
            objects.append(chunk.np)
    return tuple(objects), tuple(places)


def _is_floating(head: Sequence[Chunk], index: int) -> bool:
    """ "The cube and the cup both …": a word that only says how many of those before it."""
    phrase = head[index].np
    quantity = phrase is not None and phrase.pronoun and phrase.head in ("both", "all", "each")
    return quantity and index > 0 and head[index - 1].kind == "np"


def _subject(
    head: Sequence[Chunk],
) -> tuple[tuple[NounPhrase, ...], tuple[tuple[str, NounPhrase], ...]]:
    """The run of noun phrases nearest before the verb, and the places around it."""
    kept: list[NounPhrase] = []
    joined = True
    for index, chunk in reversed(list(enumerate(head))):
        if _is_floating(head, index):
            continue
        if chunk.kind == "np" and chunk.np is not None and joined:
            kept.append(chunk.np)
            joined = False
        elif chunk.kind in ("and", "stop") and kept:
            joined = True
        elif (
            chunk.kind in ("sub", "rel")
            or (chunk.kind == "np" and not joined)
            or (chunk.kind == "pp" and kept and joined)
        ):
            break
    lead = tuple((c.word, c.np) for c in head if c.kind == "pp" and c.np is not None)
    return tuple(reversed(kept)), lead
