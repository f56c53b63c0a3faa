"""What is gathered of a clause beside its verb, and the quantities, forces and paths in it."""

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from typing import Literal

from physagent_studio.language.frames import EventFrame, Place, Relation, Way
from physagent_studio.language.reference.names import is_group, resolve_objects
from physagent_studio.language.reference.stock import Discourse, Inventory
from physagent_studio.language.semantics.places import resolve_place
from physagent_studio.language.syntax import measures
from physagent_studio.language.syntax.phrases import NounPhrase
from physagent_studio.language.tokens import vocabulary as v

PATHS: dict[str, Literal["curve", "straight", "circle"]] = {
    "arc": "curve", "curve": "curve", "bend": "curve", "c": "curve",
    "semicircle": "curve", "line": "straight",
    "circle": "circle", "loop": "circle", "spiral": "circle",
}  # fmt: skip
PATH_ADJECTIVES: dict[str, Literal["curve", "straight", "circle"]] = {
    "curved": "curve", "curving": "curve", "straight": "straight", "circular": "circle",
    "bending": "curve",
}  # fmt: skip


@dataclass
class Details:
    """The modifiers of one clause. struck: objects that a "into …" or "with …" names,
    struck_as_one: together, as "the blocks" or "the tower". company: objects "along with" which."""

    direction: Way | None = None
    origin: Way | None = None
    places: tuple[tuple[Relation, Place], ...] = ()
    manner: frozenset[str] = frozenset()
    posture: str = ""
    path: Literal["", "curve", "straight", "circle"] = ""
    count: int | None = None
    steps: int | None = None
    distance: float | None = None
    cause: str = ""
    only: bool = False
    begins: tuple[tuple[Relation, Place], ...] = ()
    speed: float | None = None
    delay: float | None = None
    angle: float | None = None
    share: tuple[float, float] | None = None
    timing: Literal["", "in_turn", "together"] = ""
    by: tuple[str, ...] = ()
    struck: tuple[str, ...] = ()
    struck_as_one: bool = False
    company: tuple[str, ...] = ()
    unknown: dict[str, None] = field(default_factory=dict)
    unmarked: dict[str, None] = field(default_factory=dict)

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
            elif phrase.head in v.VIEW_WORDS or not is_measure(phrase):
                self.unknown[phrase.head] = None
        return tuple(found)


def knocked_over(sense: str, details: Details, over: bool) -> str:
    """ "Is knocked onto its side" is knocked over; "tips a little" only leans."""
    if sense == "topple" and "slight" in details.manner and not over:
        return "lean"
    off = any(relation in ("off", "from") for relation, _ in details.places)
    if details.posture not in ("side", "supine", "prone") or off:
        return sense
    acts = sense in ("push", "pull", "kick", "knock", "hit", "blow")
    return "knock_over" if acts else "topple" if sense == "roll" else sense


def in_company(frame: EventFrame, details: Details) -> EventFrame:
    """ "The book slides off together with the teacup": both do."""
    others = tuple(name for name in details.company if name not in (*frame.patient, *frame.agent))
    if not others or not frame.patient:
        return frame
    manner = frame.manner | {"along"}
    return replace(frame, patient=(*frame.patient, *others), manner=manner)


def take_measure(phrase: NounPhrase, details: Details) -> None:
    """ "Slides 20 cm to the left", "at 2 m/s", "by 90 degrees": a number with its unit."""
    if phrase.head == "time" and phrase.number:
        details.count = phrase.number
    if phrase.head == "angle" and {*phrase.nouns, *phrase.adjectives} & measures.ANGLES.keys():
        # "At a 45 degree angle".
        details.angle = phrase.amount or details.angle
    if phrase.head not in measures.UNITS:
        return
    if (seconds := measures.in_units(phrase, measures.TIMES)) is not None:
        details.unknown[f"{seconds:g} s"] = None
    details.distance = measures.in_units(phrase, measures.LENGTHS) or details.distance
    details.speed = measures.in_units(phrase, measures.SPEEDS) or details.speed
    details.angle = measures.in_units(phrase, measures.ANGLES) or details.angle
    for adjective in phrase.adjectives:
        if adjective in v.DIRECTIONS and details.direction is None:
            details.direction = v.DIRECTIONS[adjective]  # type: ignore[assignment]


def take_force(phrase: NounPhrase, details: Details) -> None:
    """ "A strong sideways push", "in a wide arc": how, which way and along which path."""
    for adjective in (*phrase.adjectives, *phrase.nouns[:-1]):
        if adjective in v.MANNERS:
            details.manner |= {v.MANNERS[adjective]}
        elif adjective in v.DIRECTIONS and details.direction is None:
            details.direction = v.DIRECTIONS[adjective]  # type: ignore[assignment]
        if adjective in PATH_ADJECTIVES:
            details.path = PATH_ADJECTIVES[adjective]
    if is_path(phrase):
        known = PATHS.get(phrase.head)
        details.path = known or details.path


def is_path(phrase: NounPhrase) -> bool:
    """Whether the phrase names the form of a path ("a curve", "a straight line")."""
    shaped = any(a in PATH_ADJECTIVES for a in (*phrase.adjectives, *phrase.nouns[:-1]))
    return phrase.head in ("arc", "curve", "circle", "semicircle", "loop", "spiral", "c") or (
        phrase.head in ("line", "path", "trajectory", "course", "motion", "arc") and shaped
    )


def is_measure(phrase: NounPhrase) -> bool:
    """Whether the phrase is a quantity, a force, a cause or a path, and no thing."""
    return (
        phrase.head in v.IGNORED_NOUNS
        or phrase.head in v.FORCE_NOUNS
        or phrase.head in v.CAUSES
        or phrase.head in measures.UNITS
        or phrase.head in ("second", "degree", "time", "masscenter")
        or is_path(phrase)
    )
