"""What a clause says beside its verb: directions, manners, places, postures, counts, causes."""

from collections.abc import Mapping, Sequence

from physagent_studio.knowledge import is_container
from physagent_studio.language.frames import Place, Relation, Way
from physagent_studio.language.reference.stock import Discourse, Inventory
from physagent_studio.language.semantics.details import Details, is_path, take_force, take_measure
from physagent_studio.language.semantics.prepositions import SIDED, take_preposition
from physagent_studio.language.syntax.clauses import RawClause
from physagent_studio.language.syntax.phrases import NounPhrase
from physagent_studio.language.tokens import vocabulary as v

FIXED_WAYS: dict[str, Way] = {
    "from_left": "right",
    "from_right": "left",
    "from_front": "away",
    "from_above": "down",
    "from_below": "up",
    "from_side": "sideways",
}


def details_of(
    clause: RawClause,
    objects: Sequence[NounPhrase],
    stock: Inventory,
    talk: Discourse,
    unknown: dict[str, None],
    sense: str = "",
) -> Details:
    """Reads the adverbs and prepositional phrases of a clause; reports unknown words.

    sense: of its verb; what is on a shelf and falls, falls from there.
    """
    details = Details(unknown=unknown)
    _adverbs(clause, details, sense, _opening(clause, sense, stock, talk), talk)
    for phrase in (*objects, *clause.subjects):
        _adjectives(phrase, details)
    _places(clause, details, sense, stock, talk)
    if sense == "pull" and any(r == "off" and p.kind == "group" for r, p in details.places):
        # "Out of the row".
        details.manner |= {"out"}
    _join_between(details)
    if (sense, details.direction) in (("accelerate", "up"), ("slow", "down")):
        # "Speeds up": that is the verb, and no way.
        details.direction = None
    return details


def _adverbs(
    clause: RawClause, details: Details, sense: str, inside: Place | None, talk: Discourse
) -> None:
    """The adverbs of a clause; inside: what "goes in" means."""
    comes = any(word.startswith("from_") for word in clause.adverbs)
    for word in clause.adverbs:
        if word == "in" and comes:
            # "Rolls in from the right": into nothing but the picture.
            continue
        if word in ("in", "inside") and inside is not None:
            details.places = (*details.places, ("in", inside))
        elif word in ("in", "inside") and sense in _GOING and not clause.places:
            # "The puck doesn't go in": where that would be is not known.
            details.unknown[word] = None
        else:
            _adverb(word, details, talk)
    if sense in ("kick", "throw") and "up" in clause.adverbs and details.direction != "up":
        # "Is kicked up to the left": through the air, and that way.
        details.posture = details.posture or "airborne"
    if sense in ("pull", "slide") and "out" in clause.adverbs:
        details.manner |= {"out"}
    ways = {v.DIRECTIONS.get(word) for word in clause.adverbs}
    ways |= {preposition for preposition, _ in clause.places}
    for one, other in (("left", "right"), ("up", "down")):
        if {one, other} <= ways and sense == "sway":
            details.manner |= {"rhythmic"}
        elif {one, other} <= ways and ("back" not in clause.adverbs or one == "up"):
            # "The cup slides to the left and the box to the right".
            details.unknown[f"{one} … {other}"] = None


def _places(
    clause: RawClause, details: Details, sense: str, stock: Inventory, talk: Discourse
) -> None:
    """The prepositional phrases of a clause: where things are at first, and what it does there."""
    for preposition, phrase in clause.lead:
        before = dict(details.unknown)
        take_preposition(preposition, phrase, details, stock, talk, clause)
        if any(subject.start < phrase.start for subject in clause.subjects):
            # "The cup next to the kettle", which nobody marked: that tells which cup, no more.
            _only_note(details, before)
    details.begins = tuple(row for row in details.places if row[0] in SIDED)
    details.places = tuple(
        ("from", place)
        if sense == "fall" and _is_above(relation, place, stock)
        else (relation, place)
        for relation, place in details.places
        if relation not in SIDED
    )
    before = dict(details.unknown)
    for preposition, phrase in clause.places:
        take_preposition(preposition, phrase, details, stock, talk, clause)
    if clause.verb is not None and clause.verb.form == "ing" and sense in _BEING_THERE:
        # "The lamp hanging from the ceiling".
        _only_note(details, before)


_BEING_THERE = v.words_of("hang rest lean stay")


def _only_note(details: Details, before: Mapping[str, None]) -> None:
    """What was not understood since then is no doubt, for nothing demanded depends on it."""
    fresh = [word for word in details.unknown if word not in before]
    details.unmarked |= {word: details.unknown.pop(word) for word in fresh}


_GOING = v.words_of("move roll slide drift fly fall jump bounce slip kick throw push drop hit")
"""Senses of what can get into something."""


def _opening(clause: RawClause, sense: str, stock: Inventory, talk: Discourse) -> Place | None:
    """What "goes in" means without a name: what was spoken of, else the only thing there is that
    something can be in."""
    if sense not in _GOING or clause.places:
        return None
    if talk.landmark is not None:
        return talk.landmark
    marks = [t.name for t in stock.landmarks if v.LANDMARKS.get(t.head) in ("opening", "area")]
    things = [t.name for t in stock.objects if is_container(t.name)]
    about = (*talk.acting, *talk.subject)
    things = [name for name in things if name not in about]
    if len(marks) + len(things) != 1:
        return None
    return Place(marks[0], "landmark") if marks else Place(things[0], "object")


def _is_above(relation: Relation, place: Place, stock: Inventory) -> bool:
    """Whether what is there stands on a support other than the ground."""
    return relation == "on" and place.kind == "support" and place.name != stock.ground


def _join_between(details: Details) -> None:
    """ "Between the cup and the box" is one place: the line from the one to the other."""
    ends = [p for r, p in details.places if r == "between" and p.kind == "object"]
    if len(ends) != 2:
        return
    names = (ends[0].name, ends[1].name)
    gate = Place("_".join(("between", *names))[:64], "landmark", "", "line", names)
    # "Through the gap between …" is between them.
    kept = tuple(
        row
        for row in details.places
        if row[1] not in ends and row[1].name not in ("gap", "space", "opening")
    )
    details.places = (*kept, ("between", gate))


def _adverb(word: str, details: Details, talk: Discourse) -> None:
    if word == "from_behind":
        return
    if word in FIXED_WAYS:
        details.origin = FIXED_WAYS[word]
    elif word in ("inside", "in", "there") and talk.landmark is not None:
        details.places = (*details.places, ("in", talk.landmark))
    elif word in v.MANNERS:
        details.manner |= {v.MANNERS[word]}
    elif word in v.DIRECTIONS:
        way = v.DIRECTIONS[word]
        if word == "off":
            details.places = (*details.places, ("off", Place("stack", "group")))
        if word == "away":
            details.manner |= {"away"}
        # "Drives forward to the right": the picture's side says more than the thing's own.
        own = details.direction in ("forward", "backward") or "backwards" in details.manner
        if details.direction == "backward" and "backwards" not in details.manner:
            details.manner |= {"back"}
        if details.direction in (None, "off", "down", "up") or own:
            details.direction = way  # type: ignore[assignment]
        if word in ("backward", "backwards"):
            details.manner |= {"backwards"}
    elif word in v.SHARES:
        details.share = v.SHARES[word]
    elif word in v.NEARLY:
        details.manner |= {"nearly"}
    elif word == "alone":
        details.only = True
    elif word in v.TIMINGS:
        details.timing = v.TIMINGS[word]  # type: ignore[assignment]
    elif word in v.COUNTS:
        details.count = v.COUNTS[word]
    elif word in v.POSTURES:
        details.posture = v.POSTURES[word]
    elif word == "where_it_started":
        details.unknown["where it started"] = None
    elif word in _ENDS:
        details.posture = _ENDS[word]
    elif word == "outside" or not _is_known(word):
        details.unknown[word] = None


_ENDS = {"motionless": "still", "sidelong": "side", "inverted": "inverted", "airborne": "airborne"}


def _is_known(word: str) -> bool:
    tables: tuple[Mapping[str, object] | frozenset[str], ...] = (
        v.FILLERS, v.PREPOSITIONS, v.POSITIONS, v.PLAIN_ADJECTIVES, v.COLOURS, v.SIZES,
        v.NEGATIONS, v.DETERMINERS, v.AUXILIARIES, v.SUBORDINATORS, v.RELATIVES, v.CONJUNCTIONS,
        v.MATERIAL_WORDS,
    )  # fmt: skip
    return any(word in table for table in tables) or word in ("times", "horizontally")


def _adjectives(phrase: NounPhrase, details: Details) -> None:
    """ "A strong sideways push": the adjectives of a force belong to the clause."""
    take_measure(phrase, details)
    if phrase.head not in v.FORCE_NOUNS and phrase.head not in v.CAUSES and not is_path(phrase):
        return
    take_force(phrase, details)
    if phrase.of is not None:
        take_force(phrase.of, details)
