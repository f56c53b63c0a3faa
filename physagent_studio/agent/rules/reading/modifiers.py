"""What a clause says beside its verb: directions, manners, places, postures, counts, causes."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Literal

from physagent_studio.agent.rules.reading import vocabulary as v
from physagent_studio.agent.rules.reading.clauses import RawClause
from physagent_studio.agent.rules.reading.frames import Place, Relation, Way
from physagent_studio.agent.rules.reading.measures import (
    ANGLES,
    LENGTHS,
    SPEEDS,
    TIMES,
    UNITS,
    amount_of,
    in_units,
)
from physagent_studio.agent.rules.reading.names import GROUPS, is_group, resolve_objects
from physagent_studio.agent.rules.reading.phrases import NounPhrase
from physagent_studio.agent.rules.reading.places import resolve_place
from physagent_studio.agent.rules.reading.stock import Discourse, Inventory

FIXED_WAYS: dict[str, Way] = {
    "toward_camera": "toward_camera",
    "from_camera": "away",
    "from_left": "right",
    "from_right": "left",
    "from_front": "away",
    "from_above": "down",
    "from_below": "up",
    "from_side": "sideways",
}
STRIKING = frozenset(("into", "against", "with", "on", "onto", "upon"))
PATHS: dict[str, Literal["curve", "straight", "circle"]] = {
    "arc": "curve", "curve": "curve", "bend": "curve", "hook": "curve", "c": "curve",
    "line": "straight", "circle": "circle", "loop": "circle", "spiral": "circle",
}  # fmt: skip
PATH_ADJECTIVES: dict[str, Literal["curve", "straight", "circle"]] = {
    "curved": "curve", "curving": "curve", "straight": "straight", "circular": "circle",
    "bending": "curve",
}  # fmt: skip


@dataclass
class Details:
    """The modifiers of one clause. struck: objects that a "into …" or "with …" names."""

    direction: Way | None = None
    origin: Way | None = None
    places: tuple[tuple[Relation, Place], ...] = ()
    manner: frozenset[str] = frozenset()
    posture: str = ""
    path: Literal["", "curve", "straight", "circle"] = ""
    count: int | None = None
    distance: float | None = None
    cause: str = ""
    only: bool = False
    begins: tuple[tuple[Relation, Place], ...] = ()
    speed: float | None = None
    delay: float | None = None
    angle: float | None = None
    gap: float | None = None
    share: tuple[float, float] | None = None
    timing: Literal["", "in_turn", "together"] = ""
    by: tuple[str, ...] = ()
    struck: tuple[str, ...] = ()
    unknown: dict[str, None] = field(default_factory=dict)

    def object_places(
        self, objects: Sequence[NounPhrase], stock: Inventory, talk: Discourse
    ) -> tuple[tuple[Relation, Place], ...]:
        """Direct objects as places ("crosses the goal line", "reaches the table")."""
        found: list[tuple[Relation, Place]] = []
        for phrase in objects:
            named = resolve_objects(phrase, stock, talk)
            several = named is not None and len(named.names) > 1
            if named is not None and several and (phrase.pronoun or not is_group(phrase, stock)):
                found.extend(("object", Place(name, "object")) for name in named.names)
            elif (place := resolve_place(phrase, stock, talk)) is not None:
                found.append(("object", place))
            elif not is_measure(phrase):
                self.unknown[phrase.head] = None
        return tuple(found)


def details_of(
    clause: RawClause,
    objects: Sequence[NounPhrase],
    stock: Inventory,
    talk: Discourse,
    unknown: dict[str, None],
) -> Details:
    """Reads the adverbs and prepositional phrases of a clause; reports unknown words."""
    details = Details(unknown=unknown)
    for phrase in objects if any(np.head in v.OTHERS for _, np in clause.places) else ():
        # "Pulls the red one from under the others".
        if (direct := resolve_objects(phrase, stock, talk)) is not None:
            talk.mention(direct.names)
    for word in clause.adverbs:
        _adverb(word, details, talk)
    for phrase in (*objects, *clause.subjects):
        _adjectives(phrase, details)
    for preposition, phrase in clause.lead:
        _preposition(preposition, phrase, details, stock, talk, clause)
    details.begins = tuple(row for row in details.places if row[0] in SIDED)
    details.places = tuple(row for row in details.places if row[0] not in SIDED)
    for preposition, phrase in clause.places:
        _preposition(preposition, phrase, details, stock, talk, clause)
    _join_between(details)
    return details


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
        if word.startswith("from_") and word != "from_camera":
            details.origin = FIXED_WAYS[word]
        else:
            details.direction = FIXED_WAYS[word]
    elif word in ("inside", "in", "there") and talk.landmark is not None:
        details.places = (*details.places, ("in", talk.landmark))
    elif word in v.MANNERS:
        details.manner |= {v.MANNERS[word]}
    elif word in v.DIRECTIONS:
        way = v.DIRECTIONS[word]
        if word == "off":
            details.places = (*details.places, ("off", Place("stack", "group")))
        if details.direction in (None, "off", "down", "up"):
            details.direction = way  # type: ignore[assignment]
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
    elif word in ("where_it_started", "stepwise"):
        details.unknown[_WRITTEN[word]] = None
    elif word in _ENDS:
        details.posture = _ENDS[word]
    elif not _is_known(word):
        details.unknown[word] = None


_WRITTEN = {"where_it_started": "where it started", "stepwise": "step by step"}
"""How words that were joined, and that nothing tests, were written."""
_ENDS = {"motionless": "still", "sidelong": "side", "inverted": "inverted", "airborne": "airborne"}


def _is_known(word: str) -> bool:
    tables: tuple[Mapping[str, object] | frozenset[str], ...] = (
        v.FILLERS, v.PREPOSITIONS, v.POSITIONS, v.PLAIN_ADJECTIVES, v.COLOURS, v.SIZES,
        v.NEGATIONS, v.DETERMINERS, v.AUXILIARIES, v.SUBORDINATORS, v.RELATIVES, v.CONJUNCTIONS,
        v.MATERIAL_WORDS,
    )  # fmt: skip
    return any(word in table for table in tables) or word in ("times", "horizontally")


SIDED = ("behind", "in_front", "left_of", "right_of")
"""Relations that say on which side of a thing something is."""
PLURAL = (*SIDED, "between", "over", "past", "through", "under", "before")
"""Relations to several things that are relations to each of them: "past the pins"."""


def _measure(phrase: NounPhrase, details: Details) -> None:
    """ "Slides 20 cm to the left", "at 2 m/s", "by 90 degrees": a number with its unit."""
    if phrase.head == "time" and phrase.number:
        details.count = phrase.number
    if phrase.head not in UNITS:
        return
    details.distance = in_units(phrase, LENGTHS) or details.distance
    details.speed = in_units(phrase, SPEEDS) or details.speed
    details.angle = in_units(phrase, ANGLES) or details.angle
    for adjective in phrase.adjectives:
        if adjective in v.DIRECTIONS and details.direction is None:
            details.direction = v.DIRECTIONS[adjective]  # type: ignore[assignment]


def _adjectives(phrase: NounPhrase, details: Details) -> None:
    """ "A strong sideways push": the adjectives of a force belong to the clause."""
    _measure(phrase, details)
    if phrase.head not in v.FORCE_NOUNS and phrase.head not in v.CAUSES and not _is_path(phrase):
        return
    _force_adjectives(phrase, details)
    if phrase.of is not None:
        _force_adjectives(phrase.of, details)


def _force_adjectives(phrase: NounPhrase, details: Details) -> None:
    for adjective in (*phrase.adjectives, *phrase.nouns[:-1]):
        if adjective in v.MANNERS:
            details.manner |= {v.MANNERS[adjective]}
        elif adjective in v.DIRECTIONS and details.direction is None:
            details.direction = v.DIRECTIONS[adjective]  # type: ignore[assignment]
        if adjective in PATH_ADJECTIVES:
            details.path = PATH_ADJECTIVES[adjective]
    if _is_path(phrase):
        known = PATHS.get(phrase.head)
        details.path = known or details.path


def _is_path(phrase: NounPhrase) -> bool:
    shaped = any(a in PATH_ADJECTIVES for a in (*phrase.adjectives, *phrase.nouns[:-1]))
    return phrase.head in ("arc", "curve", "hook", "circle", "loop", "spiral", "c") or (
        phrase.head in ("line", "path", "trajectory", "course", "motion", "arc") and shaped
    )


def is_measure(phrase: NounPhrase) -> bool:
    """Whether the phrase is a quantity, a force, a cause or a path, and no thing."""
    return (
        phrase.head in v.IGNORED_NOUNS
        or phrase.head in v.FORCE_NOUNS
        or phrase.head in v.CAUSES
        or phrase.head in UNITS
        or phrase.head in ("second", "degree", "time", "masscenter")
        or _is_path(phrase)
    )


def _preposition(
    preposition: str,
    phrase: NounPhrase,
    details: Details,
    stock: Inventory,
    talk: Discourse,
    clause: RawClause,
) -> None:
    if phrase.head in ("time", "times") and phrase.number:
        details.count = phrase.number
        return
    if _quantity(preposition, phrase, details):
        return
    if preposition == "like":
        # A comparison says nothing that could be measured.
        return
    if preposition == "as_much_as":
        whose = resolve_objects(phrase, stock, talk)
        details.unknown["as … as " + " ".join(whose.names if whose else phrase.nouns)] = None
        return
    if preposition == "except":
        return
    if preposition == "starting_with":
        details.unknown["starting with"] = None
        return
    if preposition == "infront" and phrase.head in v.CAMERA_WORDS:
        details.direction = details.direction or "toward_camera"
        return
    if phrase.head in v.FORCE_NOUNS or _is_path(phrase):
        _force_adjectives(phrase, details)
        return
    resolved = resolve_objects(phrase, stock, talk)
    if preposition in ("by", "because_of", "from", "with", "under", "in") and resolved is None:
        heads = (phrase.head, phrase.of.head if phrase.of else "")
        cause = next((v.CAUSES[h] for h in heads if h in v.CAUSES), "")
        if cause:
            details.cause = cause
            _force_adjectives(phrase, details)
            return
    if _by_or_way(preposition, phrase, details):
        return
    if resolved is not None:
        if preposition == "by" and _goes_by(clause):
            _place("past", phrase, details, stock, talk)
            return
        if preposition == "by" and len(clause.objects) == 0:
            details.by = resolved.names
            talk.mention(resolved.names)
            return
        if preposition in STRIKING and not is_group(phrase, stock):
            details.struck = resolved.names
        if phrase.head not in GROUPS:
            talk.mention(resolved.names)
    if preposition == "by" and _goes_by(clause):
        preposition = "past"
    _place(preposition, phrase, details, stock, talk)


def _goes_by(clause: RawClause) -> bool:
    """ "Rolls by the hole": past it, and not done by it."""
    verb = clause.verb
    entry = v.VERBS.get(verb.verb) if verb is not None else None
    plain = verb is not None and not verb.passive and verb.form != "pp"
    return plain and entry is not None and entry.kind == "move"


def _quantity(preposition: str, phrase: NounPhrase, details: Details) -> bool:
    """ "At 2 m/s", "by 20 cm", "after 1 second", "for 2 seconds": whether that is one."""
    if phrase.head not in UNITS or amount_of(phrase) is None:
        return False
    seconds = in_units(phrase, TIMES)
    if seconds is None:
        _measure(phrase, details)
    elif preposition in ("after", "in"):
        details.delay = seconds
    else:
        details.unknown[f"{preposition} {seconds:g} s"] = None
    return True


def _by_or_way(preposition: str, phrase: NounPhrase, details: Details) -> bool:
    """Directions said with a preposition: "to the left", "toward the camera"."""
    word = phrase.head
    way = v.DIRECTIONS.get(word) if not phrase.nouns else None
    side = word == "side" and next((a for a in phrase.adjectives if a in ("left", "right")), None)
    if preposition in ("to", "toward", "towards") and (word in v.CAMERA_WORDS):
        details.direction = "toward_camera"
    elif preposition == "away_from" and word in v.CAMERA_WORDS:
        details.direction = "away"
    elif preposition in ("to", "toward", "towards", "on") and (way or side):
        details.direction = side or way  # type: ignore[assignment]
    elif word in ("side", "sides") and preposition in ("to", "from", "on", "onto"):
        if preposition in ("on", "onto"):
            details.posture = "side"
        elif preposition == "from":
            details.origin = "sideways"
        else:
            details.direction = "sideways"
    else:
        return False
    return True


SIDES: dict[str, Way] = {
    "left": "left", "lefthand": "left", "right": "right", "righthand": "right", "far": "away",
    "back": "away", "rear": "away", "near": "toward_camera", "front": "toward_camera",
}  # fmt: skip


def _without_side(phrase: NounPhrase, details: Details) -> NounPhrase:
    """ "Off the right side of the table" is off the table, to the right."""
    if phrase.head != "side" or phrase.of is None:
        if v.PARTS.get(phrase.head) == "edge":
            # "Off the far edge": which of the edges.
            for adjective in phrase.adjectives:
                if adjective in SIDES and details.direction is None:
                    details.direction = SIDES[adjective]
        return phrase
    for adjective in phrase.adjectives:
        if adjective in SIDES:
            details.direction = SIDES[adjective]
            break
    return phrase.of


def _place(
    preposition: str, phrase: NounPhrase, details: Details, stock: Inventory, talk: Discourse
) -> None:
    relation = v.RELATIONS.get(preposition)
    side: Way | None = next((SIDES[a] for a in phrase.adjectives if a in SIDES), None)
    if phrase.head == "side" and phrase.of is None and relation in ("off", "over") and side:
        # "Off the right side", of whatever it stands on.
        details.direction = side
        details.places = (*details.places, ("off", Place("stack", "group")))
        return
    phrase = _without_side(phrase, details)
    several = resolve_objects(phrase, stock, talk) if preposition not in ("to", "at") else None
    plain = several is not None and not several.any_one and not is_group(phrase, stock)
    if several is not None and plain and len(several.names) > 1 and relation in PLURAL:
        rows = tuple((relation, Place(name, "object")) for name in several.names)
        details.places = (*details.places, *rows)  # type: ignore[assignment]
        return
    place = resolve_place(phrase, stock, talk)
    if place is None or relation is None:
        if preposition == "away_from" and place is not None and place.kind != "group":
            details.places = (*details.places, ("away_from", place))
            return
        if preposition == "away_from" or is_measure(phrase) or phrase.pronoun:
            details.direction = details.direction or ("off" if preposition == "away_from" else None)
            return
        if phrase.head not in ("air", "second", "place"):
            details.unknown[phrase.head] = None
        return
    if relation not in ("with", "by", "during"):
        details.places = (*details.places, (relation, place))  # type: ignore[assignment]
