"""Prepositional phrases of a clause: places, ways, causes, quantities, who did it."""

from dataclasses import replace

from physagent_studio.knowledge import is_step, kind_of
from physagent_studio.language.frames import Place, Way
from physagent_studio.language.reference.names import (
    GROUPS,
    is_group,
    of_its_owner,
    resolve_objects,
)
from physagent_studio.language.reference.stock import Discourse, Inventory
from physagent_studio.language.semantics.details import (
    Details,
    is_measure,
    is_path,
    take_force,
    take_measure,
)
from physagent_studio.language.semantics.places import resolve_place
from physagent_studio.language.syntax.clauses import RawClause
from physagent_studio.language.syntax.measures import (
    TIMES,
    UNITS,
    amount_of,
    in_units,
)
from physagent_studio.language.syntax.phrases import NounPhrase
from physagent_studio.language.tokens import vocabulary as v

STRIKING = frozenset(("into", "against", "with", "on", "onto", "upon"))
RUNNING = ("into", "against")
"""Of these, those that mean a blow where they stand before a stack or a row too."""
TO = ("to", "toward", "towards")
OUT = {"off": "out of", "from": "from", "into": "into"}
"""How something gets out of, or into, what the picture shows, and how that is said."""
SIDED = ("behind", "in_front", "left_of", "right_of")
"""Relations that say on which side of a thing something is."""
PLURAL = (*SIDED, "between", "over", "past", "through", "under", "before", "around")
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
    if _quantity(preposition, phrase, details):
        return
    if _only_said(preposition, phrase, details, stock, talk):
        return
    if preposition in TO and phrase.of is not None and phrase.head in v.SIDES:
        # "To the back of the plate".
        details.direction = v.SIDES[phrase.head]
        return
    if _half(preposition, phrase, details, stock, talk):
        return
    phrase = _without_side(preposition, phrase, details)
    if preposition == "infront" and phrase.head in v.CAMERA_WORDS:
        details.direction = details.direction or "toward_camera"
        return
    if phrase.head in v.FORCE_NOUNS or is_path(phrase):
        take_force(phrase, details)
        return
    if preposition in (*RUNNING, *TO, "at", "with"):
        phrase = of_its_owner(phrase, stock)
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
    if (steps := _steps(phrase)) and {"down", "lower"} & {
        preposition, *clause.adverbs, *phrase.adjectives
    }:  # fmt: skip
        preposition, details.steps = "down", steps
    if preposition == "alongwith" and resolved is not None:
        details.company = (*details.company, *resolved.names)
        return
    if resolved is not None:
        if preposition == "by" and not clause.objects and not _goes_by(clause):
            details.by = resolved.names
            talk.mention(resolved.names)
            return
        entry = v.VERBS.get(clause.verb.verb) if clause.verb is not None else None
        beside = preposition == "with" and entry is not None and entry.kind == "move"
        whole = preposition in RUNNING and resolved.as_one
        if preposition in STRIKING and not beside and (whole or not is_group(phrase, stock)):
            details.struck, details.struck_as_one = resolved.names, resolved.as_one
    if preposition == "by" and _goes_by(clause):
        preposition = "past"
    _place(preposition, phrase, details, stock, talk)
    if resolved is not None and (phrase.head not in GROUPS or preposition in ("into", "against")):
        # Only now: the second bottle is still the second while its place is looked up.
        talk.mention(resolved.names, behind=preposition in ("off", "from"))


def _steps(phrase: NounPhrase) -> int:
    """How many steps of a flight "one step", "two stairs" or "the next step" is; 0 for what is
    none, or all of them."""
    which = {*phrase.adjectives} & v.POSITIONS.keys() - {"lower"}
    return phrase.number or int(not phrase.plural) if is_step(phrase.head) and not which else 0


def _only_said(
    preposition: str, phrase: NounPhrase, details: Details, stock: Inventory, talk: Discourse
) -> bool:
    """Whether it says nothing that could be measured, or what nothing measures."""
    if preposition in OUT and phrase.head in v.VIEW_WORDS and not _is_there(phrase, stock):
        details.unknown[f"{OUT[preposition]} the {phrase.head}"] = None
        details.direction = details.direction or _side_said(phrase)
        return True
    if preposition == "with" and phrase.head in v.SOUNDS:
        return True
    own = preposition == "with" and phrase.determiner in ("its", "his", "her", "their")
    if own and phrase.head in v.LIMBS | v.PARTS.keys() and not _is_there(phrase, stock):
        # "Nudges it with its nose": so it does, being one thing.
        return True
    if preposition == "by" and phrase.head in v.LIMBS and not _is_there(phrase, stock):
        # "Is lifted by its handle": where it is held, and no one who does it.
        return True
    if (
        preposition in _BY
        and phrase.head in v.HOLDERS
        and resolve_place(phrase, stock, talk) is None
    ):
        # "Slips off its hook".
        return True
    # A comparison tells nothing; who is spared is read with the subject.
    return preposition in ("like", "except")


_BY = ("on", "off", "from", "by")
"""Prepositions before what something hangs by."""


def _side_said(phrase: NounPhrase) -> Way | None:
    return next((v.SIDES[a] for a in phrase.adjectives if a in v.SIDES), None)


def _tells_apart(side: Way, phrase: NounPhrase, stock: Inventory) -> bool:
    """Whether a side picks one of several things rather than a way: "off the left table", "over
    the left one"."""
    if phrase.head in ("one", "ones") or phrase.head in v.OTHERS:
        return True
    alike = [t for t in (*stock.objects, *stock.supports) if phrase.head in t.words]
    return len(alike) > 1 or any(v.SIDES.get(word) == side for t in alike for word in t.words)


def _is_there(phrase: NounPhrase, stock: Inventory) -> bool:
    things = (*stock.objects, *stock.supports, *stock.landmarks)
    return any(phrase.head in t.words for t in things)


def _goes_by(clause: RawClause) -> bool:
    """ "Rolls by the hole": past it, and not done by it."""
    verb = clause.verb
    entry = v.VERBS.get(verb.verb) if verb is not None else None
    plain = verb is not None and not verb.passive and verb.form != "pp"
    return plain and entry is not None and entry.kind == "move"


def _quantity(preposition: str, phrase: NounPhrase, details: Details) -> bool:
    """ "At 2 m/s", "by 20 cm", "after 1 second", "for 2 seconds": whether that is one."""
    if phrase.head == "time" and phrase.number:
        # "Jumps up three times".
        details.count = phrase.number
        details.direction = details.direction or v.DIRECTIONS.get(preposition)  # type: ignore[assignment]
        return True
    if phrase.head not in UNITS or amount_of(phrase) is None:
        return False
    seconds = in_units(phrase, TIMES)
    if preposition == "within":
        details.unknown[f"within {amount_of(phrase):g} {phrase.head}"] = None
    elif seconds is None:
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
    if preposition in TO and word in v.CAMERA_WORDS:
        details.direction = "toward_camera"
    elif preposition == "away_from" and word in v.CAMERA_WORDS:
        details.direction = "away"
    elif preposition in TO and word in ("front", "back", "rear") and phrase.of is None:
        details.direction = v.SIDES[word]
    elif preposition in (*TO, "on") and way:
        details.direction = way  # type: ignore[assignment]
    else:
        return False
    return True


def _half(
    preposition: str, phrase: NounPhrase, details: Details, stock: Inventory, talk: Discourse
) -> bool:
    """ "On the right side of the table": right of its middle; "off the table on the left side":
    which way. Whether it says so."""
    side = _side_said(phrase)
    if phrase.head not in ("side", "half", "part") or side not in ("left", "right"):
        return False
    if preposition not in (*TO, "on", "onto", "at", "in"):
        return False
    if phrase.of is None:
        details.direction = details.direction or side
        return True
    place = resolve_place(phrase.of, stock, talk)
    if place is None or place.kind != "support" or place.part or place.name == stock.ground:
        return False
    on = () if preposition in TO else (("on", place),)
    half = ("left_of" if side == "left" else "right_of", replace(place, part="center"))
    details.places = (*details.places, *on, half)  # type: ignore[assignment]
    return True


def _without_side(preposition: str, phrase: NounPhrase, details: Details) -> NounPhrase:
    """ "Off the right side of the table", "off its back": off the table, and which way."""
    if v.PARTS.get(phrase.head) in ("edge", "end") and preposition not in ("at", "on"):
        # "Off the far edge", "to the right end": which of the edges.
        for adjective in phrase.adjectives:
            if adjective in v.SIDES and details.direction is None:
                details.direction = v.SIDES[adjective]
    if phrase.of is None or phrase.of.plural or phrase.head not in ("side", *v.SIDES):
        return phrase
    way = v.SIDES.get(phrase.head) or _side_said(phrase)
    whole = kind_of(phrase.of.head)
    if whole is not None and (whole.wheels or whole.is_alive):
        # "Off the back of the truck": that is the side where it ends, wherever it faces.
        return phrase.of
    if way and (phrase.head == "side" or v.RELATIONS.get(preposition) in ("off", "over")):
        details.direction = way
    return phrase.of


def _place(
    preposition: str, phrase: NounPhrase, details: Details, stock: Inventory, talk: Discourse
) -> None:
    relation = v.RELATIONS.get(preposition)
    side = _side_said(phrase)
    if phrase.head == "side" and phrase.of is None and relation in ("off", "over") and side:
        # "Off the right side", of whatever it stands on.
        details.direction = side
        details.places = (*details.places, ("off", Place("stack", "group")))
        return
    several = resolve_objects(phrase, stock, talk) if preposition not in ("to", "at") else None
    group = is_group(phrase, stock) and phrase.head in GROUPS
    plain = several is not None and not several.any_one and not group
    if several is not None and plain and len(several.names) > 1 and relation in PLURAL:
        rows = tuple((relation, Place(name, "object")) for name in several.names)
        details.places = (*details.places, *rows)  # type: ignore[assignment]
        return
    place = resolve_place(phrase, stock, talk)
    if place is not None and place.members and relation in ("toward", "at", "near", "past"):
        # "Is thrown at the tower": at one of it.
        place = replace(place, name=place.members[0], kind="object")
    if place is None or relation is None:
        if preposition == "away_from" and place is not None and place.kind != "group":
            details.places = (*details.places, ("away_from", place))
            return
        if preposition == "away_from" or is_measure(phrase) or phrase.pronoun:
            details.direction = details.direction or ("off" if preposition == "away_from" else None)
            if place is None and not (phrase.pronoun or is_measure(phrase)):
                # "Slips away from the dresser" that nobody marked: it goes, and that is a note.
                kind = kind_of(phrase.head) if preposition == "away_from" else None
                beside = kind is not None and kind.support is None
                (details.unmarked if beside else details.unknown)[phrase.head] = None
            return
        if phrase.head not in ("air", "second", "place"):
            details.unknown[phrase.head] = None
        return
    if relation in ("off", "over") and side and not _tells_apart(side, phrase, stock):
        # "Off the plate on the left".
        details.direction = details.direction or side
    if relation == "with" and place.kind == "object" and not details.struck:
        details.unknown[f"with the {phrase.head}"] = None
    if relation not in ("with", "by", "during"):
        details.places = (*details.places, (relation, place))  # type: ignore[assignment]
