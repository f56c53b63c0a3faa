"""Prepositional phrases of a clause: places, ways, causes, quantities, who did it."""

from __future__ import annotations

from physagent_studio.agent.rules.reading import vocabulary as v
from physagent_studio.agent.rules.reading.clauses import RawClause
from physagent_studio.agent.rules.reading.details import (
    Details,
    is_measure,
    is_path,
    take_force,
    take_measure,
)
from physagent_studio.agent.rules.reading.frames import Place, Way
from physagent_studio.agent.rules.reading.measures import (
    TIMES,
    UNITS,
    amount_of,
    in_units,
)
from physagent_studio.agent.rules.reading.names import GROUPS, is_group, resolve_objects
from physagent_studio.agent.rules.reading.phrases import NounPhrase
from physagent_studio.agent.rules.reading.places import resolve_place
from physagent_studio.agent.rules.reading.stock import Discourse, Inventory

STRIKING = frozenset(("into", "against", "with", "on", "onto", "upon"))
SIDED = ("behind", "in_front", "left_of", "right_of")
"""Relations that say on which side of a thing something is."""
PLURAL = (*SIDED, "between", "over", "past", "through", "under", "before")
"""Relations to several things that are relations to each of them: "past the pins"."""


def take_preposition(
    preposition: str,
    phrase: NounPhrase,
    details: Details,
    stock: Inventory,
    talk: Discourse,
    clause: RawClause,
) -> None:
    """Adds to `details` what one prepositional phrase of the clause says."""
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
    if phrase.head in v.FORCE_NOUNS or is_path(phrase):
        take_force(phrase, details)
        return
    resolved = resolve_objects(phrase, stock, talk)
    if preposition in ("by", "because_of", "from", "with", "under", "in") and resolved is None:
        heads = (phrase.head, phrase.of.head if phrase.of else "")
        cause = next((v.CAUSES[h] for h in heads if h in v.CAUSES), "")
        if cause:
            details.cause = cause
            take_force(phrase, details)
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
        take_measure(phrase, details)
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
