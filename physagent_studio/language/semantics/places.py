"""From noun phrases to places: landmarks, supports, their parts, and objects as places."""

from collections.abc import Sequence
from dataclasses import replace

from physagent_studio.language.frames import LandmarkKind, Place, Relation
from physagent_studio.language.reference.names import GROUPS, is_group, of_pronoun, resolve_objects
from physagent_studio.language.reference.selecting import apart, filtered
from physagent_studio.language.reference.stock import Discourse, Inventory, Thing
from physagent_studio.language.syntax.phrases import NounPhrase
from physagent_studio.language.tokens import vocabulary as v
from physagent_studio.language.tokens.tokens import singular


def resolve_place(phrase: NounPhrase, stock: Inventory, talk: Discourse) -> Place | None:
    """The place meant by a noun phrase, or None where it names none that is known."""
    if is_group(phrase, stock) and len(stock.objects) > 1 and phrase.head in GROUPS:
        return Place("stack", "group", members=_members(phrase, stock, talk))
    if phrase.pronoun:
        found = of_pronoun(phrase.head, stock, talk, False)
        # "… towards the goal but misses it": nothing misses itself.
        own = found is not None and found.names == talk.subject
        if (found is None or own) and phrase.head in ("it", "that", "this"):
            return talk.landmark or talk.support
        return Place(found.names[0], "object") if found else None
    if (own := _landmark(phrase, stock)) is not None:
        if (part := _as_part(own, stock)) is not None:
            return part
        talk.landmark = own
        return own
    if phrase.head in v.PARTS and phrase.head not in ("side",):
        return _part(phrase, stock, talk)
    if (support := _support(phrase, stock, talk)) is not None:
        talk.support = support
        return support
    if phrase.of is not None and phrase.head in v.SIDES:
        return resolve_place(phrase.of, stock, talk)
    found = resolve_objects(phrase, stock, talk)
    if found is not None:
        meant = [t for t in stock.objects if t.name in found.names]
        names = [t.name for t in _by_nearness(meant, stock, talk)] if found.any_one else found.names
        together = found.names if found.as_one and len(found.names) > 1 else ()
        return Place(names[0], "object", members=together)
    if phrase.head in v.GROUND_WORDS | v.TABLE_WORDS | v.LAID:
        return Place(stock.ground, "support")
    if phrase.head in v.LANDMARKS:
        return _needed_landmark(phrase, talk)
    return None


def _members(phrase: NounPhrase, stock: Inventory, talk: Discourse) -> tuple[str, ...]:
    """What a stack, a row or a set consists of, without what acts."""
    found = resolve_objects(phrase, stock, talk)
    if found is None or not found.as_one:
        return ()
    return tuple(name for name in found.names if name not in talk.acting)


def _as_part(own: Place, stock: Inventory) -> Place | None:
    """A landmark that a person clicked as a part of a support, such as `table_edge`."""
    for support in stock.supports:
        part = own.name.removeprefix(f"{support.name}_")
        if part != own.name and part in (*v.PARTS.values(), *v.PARTS):
            return Place(support.name, "support", v.PARTS.get(part, part))
    return None


def _needed_landmark(phrase: NounPhrase, talk: Discourse) -> Place:
    words = [w for w in phrase.adjectives if w in v.COLOURS] + [singular(n) for n in phrase.nouns]
    place = Place("_".join(words), "landmark", "", _landmark_kind(v.LANDMARKS[phrase.head]))
    talk.landmark = place
    return place


def _landmark_kind(word: str) -> LandmarkKind:
    kinds: dict[str, LandmarkKind] = {"opening": "opening", "line": "line", "area": "area"}
    return kinds.get(word, "point")


def _landmark(phrase: NounPhrase, stock: Inventory) -> Place | None:
    nouns = {singular(n) for n in phrase.nouns}
    if phrase.of is not None:
        nouns |= {singular(n) for n in phrase.of.nouns}
    for t in stock.landmarks:
        if set(t.words) == nouns or (phrase.head == t.head and nouns <= set(t.words)):
            return Place(t.name, "landmark")
    alike = [
        t for t in stock.landmarks if any(phrase.head in s and t.head in s for s in v.SYNONYMS)
    ]
    return Place(alike[0].name, "landmark") if len(alike) == 1 else None


def _support(phrase: NounPhrase, stock: Inventory, talk: Discourse) -> Place | None:
    nouns = {singular(n) for n in phrase.nouns}
    heads = [t for t in stock.supports if phrase.head in t.words]
    words = heads or [t for t in stock.supports if nouns & set(t.words) and phrase.head != "plate"]
    alike = [
        t
        for t in stock.supports
        for row in v.SUPPORT_CLASSES.values()
        if phrase.head in row and set(t.words) & row
    ]
    found = words or alike
    if any(phrase.head in t.words for t in stock.objects) and not heads:
        return None
    if len(found) > 1:
        # "The low table": words that are no known adjectives count among the nouns.
        found = [t for t in found if nouns <= set(t.words)] or found
        kept = filtered(tuple(found), phrase.adjectives, phrase.number, Discourse())
        found = _most_likely(list(kept) or found, phrase, stock, talk)
    return Place(found[0].name, "support") if found else None


def _most_likely(
    found: list[Thing], phrase: NounPhrase, stock: Inventory, talk: Discourse
) -> list[Thing]:
    """Of several supports first the one that was spoken of, else the one nearest to what acts.

    "The other table" is one that was not spoken of.
    """
    spoken = talk.support.name if talk.support is not None else ""
    if v.OTHERS & {*phrase.nouns, *phrase.adjectives} or phrase.determiner == "another":
        found = [t for t in found if t.name != spoken] or found
    elif any(t.name == spoken for t in found):
        return [t for t in found if t.name == spoken]
    return _by_nearness(found, stock, talk)


def _by_nearness(found: Sequence[Thing], stock: Inventory, talk: Discourse) -> list[Thing]:
    """Things, first the one that is clicked nearest to what acts; as they come where none is."""
    actors = [t for t in stock.objects if t.name in talk.acting]
    return sorted(found, key=lambda t: apart(actors, t))


def _part(phrase: NounPhrase, stock: Inventory, talk: Discourse) -> Place | None:
    """A place on a support: "the table edge", "the lower end of the ramp", "the bottom"."""
    part = v.PARTS[phrase.head]
    if part == "end":
        part = _which_end(phrase.adjectives)
    base = _base_of_part(phrase, stock, talk)
    if base is None:
        return None
    if base.kind != "support" or part == "surface":
        return base
    if part in ("upper_end", "lower_end") and not _is_slope(base.name, stock):
        return base if phrase.head != "end" else Place(base.name, "support", "end")
    return Place(base.name, "support", "edge" if part == "side" else part)


def _which_end(adjectives: Sequence[str]) -> str:
    if any(a in ("lower", "bottom", "lowest", "far") for a in adjectives):
        return "lower_end"
    return "upper_end" if any(a in ("upper", "top", "highest") for a in adjectives) else "end"


def _base_of_part(phrase: NounPhrase, stock: Inventory, talk: Discourse) -> Place | None:
    if phrase.of is not None and (base := resolve_place(phrase.of, stock, talk)) is not None:
        return base
    if len(phrase.nouns) > 1:
        whose = NounPhrase(singular(phrase.nouns[-2]), phrase.nouns[:-1], phrase.adjectives)
        if (base := resolve_place(whose, stock, talk)) is not None:
            return base
    if phrase.of is not None:
        return None
    return talk.support or next(
        (Place(t.name, "support") for t in _by_nearness(stock.supports, stock, talk)), None
    )


def _is_slope(name: str, stock: Inventory) -> bool:
    words = next((t.words for t in stock.supports if t.name == name), ())
    return bool(set(words) & v.SUPPORT_CLASSES["slope"])


def extent_of(
    share: tuple[float, float] | None,
    places: Sequence[tuple[Relation, Place]],
    stock: Inventory,
    way: str | None = None,
) -> Place | None:
    """What the whole way leads to of which a share is gone: "halfway across the table" is to
    its edge, "halfway down the ramp" to its lower end."""
    if share is None:
        return None
    for relation, place in places:
        if relation not in _LEADING or place.kind == "group":
            continue
        across = place.kind == "support" and not place.part
        if not across or relation in ("toward", "object", "at", "against", "near"):
            return place
        if place.name == stock.ground:
            continue
        if _is_slope(place.name, stock):
            return replace(place, part="upper_end" if relation == "up" else "lower_end")
        return replace(place, part="edge")
    slopes = [t.name for t in stock.supports if _is_slope(t.name, stock)]
    if len(slopes) == 1 and way in ("down", "up"):
        # "Rolls halfway down", where there is one slope to roll down.
        return Place(slopes[0], "support", "upper_end" if way == "up" else "lower_end")
    return None


_LEADING = (
    "toward", "object", "at", "against", "near", "down", "up", "along", "over", "past", "on",
    "through",
    "in", "into",
)  # fmt: skip
