"""Which of several things are meant: by colour, position, order, and where they stand."""

import math
from collections.abc import Sequence

from physagent_studio.language.reference.stock import Discourse, Inventory, Thing
from physagent_studio.language.tokens import vocabulary as v


def filtered(
    found: tuple[Thing, ...],
    adjectives: Sequence[str],
    number: int | None,
    talk: Discourse,
    stock: Inventory | None = None,
) -> tuple[Thing, ...]:
    """The things that colours, sizes, positions and ordinals leave.

    stock: where the thing that acts is, from which a row is counted ("the first two pins").
    """
    kept = found
    for adjective in (v.NEARER.get(said, said) for said in adjectives):
        word = v.POSITIONS.get(adjective, adjective)
        named = tuple(t for t in kept if word in t.words or adjective in t.words)
        if named and not (number and number > len(named)):
            kept = named
        elif adjective in v.POSITIONS and len(kept) > 1:
            kept = _placed(kept, word, number or 1)
        elif adjective in v.ORDINALS and len(kept) > 1:
            side = next((v.COUNTED_FROM[a] for a in adjectives if a in v.COUNTED_FROM), None)
            if side is None and number and number > 1 and adjective in ("first", "last"):
                row = _in_a_row(kept, talk, stock)
                kept = row[:number] if adjective == "first" else row[-number:]
                continue
            kept = _ordinal(kept, v.ORDINALS[adjective], talk, side)
        elif adjective in v.SIZES and len(kept) > 1:
            kept = _sized(kept, adjective)
        elif adjective in v.COLOURS:
            kept = tuple(t for t in kept if not set(t.words) & v.COLOURS - {t.head})
    return kept


def _sized(kept: tuple[Thing, ...], word: str) -> tuple[Thing, ...]:
    """ "The taller vase", "the big ball": by a name that says it in another word, else by size."""
    said = v.SIZES[word]
    named = tuple(t for t in kept if any(v.SIZES.get(w) == said for w in t.words))
    if named:
        return named
    known = [t.extents for t in kept if t.extents is not None]
    if len(known) < len(kept):
        return kept
    by = 0 if word in _HEIGHTS else 1
    ordered = sorted(kept, key=lambda t: (t.extents or (0.0, 0.0))[by], reverse=said == "large")
    first, second = ((t.extents or (0.0, 0.0))[by] for t in ordered[:2])
    # What is of the same size is not told apart by it.
    return (ordered[0],) if abs(first - second) > 0.05 * first else kept


_HEIGHTS = ("tall", "taller", "tallest", "short", "shorter", "shortest")
"""Sizes that are heights."""


def _placed(kept: tuple[Thing, ...], word: str, number: int) -> tuple[Thing, ...]:
    """The `number` things that lie furthest on that side of the picture."""
    if any(t.spot is None for t in kept):
        return kept
    axis = 0 if word in ("left", "right") else 1
    ordered = sorted(kept, key=lambda t: (t.spot or (0, 0))[axis])
    if word in ("right", "bottom", "front"):
        ordered.reverse()
    if word in ("middle", "outer", "inner"):
        spread = [max(c) - min(c) for c in zip(*[t.spot or (0, 0) for t in kept], strict=True)]
        ordered = sorted(kept, key=lambda t: (t.spot or (0, 0))[int(spread[1] > spread[0])])
        if word != "middle" and len(kept) > 2:
            return tuple(ordered[1:-1] if word == "inner" else (ordered[0], ordered[-1]))
        start = max((len(ordered) - number) // 2, 0)
        return tuple(ordered[start : start + number])
    return tuple(ordered[:number])


def _in_a_row(
    kept: tuple[Thing, ...], talk: Discourse, stock: Inventory | None
) -> tuple[Thing, ...]:
    """The things as they stand in the picture, first what is nearest to the thing that acts.

    From the left, or from the top, where nothing acts; as the case has them without clicks.
    """
    spots = [t.spot for t in kept if t.spot is not None]
    if len(spots) < len(kept):
        return kept
    across, down = (max(c) - min(c) for c in zip(*spots, strict=True))
    axis = int(down > across)
    row = sorted(kept, key=lambda t: (t.spot or (0, 0))[axis])
    actors = [] if stock is None else [t for t in stock.objects if t.name in talk.subject]
    start = next((t.spot for t in actors if t.spot is not None and t not in kept), None)
    if start is not None:
        near, far = (abs((row[k].spot or (0, 0))[axis] - start[axis]) for k in (0, -1))
        row = row if near <= far else row[::-1]
    return tuple(row)


def _ordinal(
    kept: tuple[Thing, ...], which: int, talk: Discourse, side: str | None = None
) -> tuple[Thing, ...]:
    """ "A third orange" after two others is the one not spoken of; else by order of the case.

    side: counted from there in the picture.
    """
    if side is not None:
        ordered = _placed(kept, side, len(kept))
        return (ordered[which if which < 0 else min(which, len(kept)) - 1],)
    fresh = tuple(t for t in kept if t.name not in talk.known)
    there = kept[which if which < 0 else min(which, len(kept)) - 1]
    if len(fresh) < len(kept) and which != 1 and there not in fresh:
        return fresh[:1] or kept[-1:]
    return (there,)


def nearest_to(names: Sequence[str], place: Thing, stock: Inventory) -> tuple[str, ...]:
    """The names ordered by the distance of their clicks from those of a place."""
    by_name = {t.name: t for t in stock.objects}
    return tuple(sorted(names, key=lambda name: apart([by_name[name]], place)))


def apart(things: Sequence[Thing], place: Thing) -> float:
    """Pixels between the clicks of a place and the nearest of the things; 0 without clicks."""
    spots = [t.spot for t in things if t.spot is not None]
    return min((math.dist(a, b) for a in spots for b in place.spots), default=0.0)


def near_to(names: Sequence[str], place: Thing, stock: Inventory) -> tuple[str, ...]:
    """The names that belong to a place and not to another: their clicks are nearer to its clicks
    than to those of another support of its kind, or, without one, not twice as far as the nearest
    one; and no other support is in their name."""
    others = {w for t in stock.supports if t.name != place.name for w in t.words}
    others |= v.GROUND_WORDS - set(place.words)
    own = [name for name in names if not others & set(name.lower().split("_"))]
    spots = {t.name: t.spot for t in stock.objects if t.spot is not None}
    if not place.spots or any(name not in spots for name in own):
        return tuple(own)
    alike = [t for t in stock.supports if t.name != place.name and t.head == place.head and t.spots]
    if alike:
        return tuple(
            n for n in own if _beside(spots[n], place) < min(_beside(spots[n], t) for t in alike)
        )
    away = {name: min(math.dist(spots[name], spot) for spot in place.spots) for name in own}
    nearest = min(away.values(), default=0.0)
    return tuple(name for name in own if away[name] <= 2 * nearest)


def _beside(spot: tuple[float, float], place: Thing) -> float:
    """Pixels from a click to those of a place; across counts half, for supports are wide."""
    return min(math.hypot((spot[0] - x) / 2, spot[1] - y) for x, y in place.spots)
