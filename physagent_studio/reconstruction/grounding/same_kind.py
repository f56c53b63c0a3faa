"""Things of one kind: what their names share, and the form that suits them all."""

from collections.abc import Mapping

from physagent_studio.knowledge import colours, words_of

_PLACES = ("left", "right", "middle", "centre", "center", "front", "back", "rear", "near", "far")
_ORDER = ("first", "second", "third", "fourth", "fifth", "sixth", "last", "top", "upper", "lower")
_REST = ("bottom", "inner", "outer", "one", "two", "three", "four", "a", "b", "c", "d", "e", "f")
_APART = frozenset((*_PLACES, *_ORDER, *_REST))
"""Words that tell like things apart."""


def kind_name(name: str) -> str:
    """What a thing is called without its place, number or colour: `left_pin` and `pin2` are `pin`.

    An orange stays an orange.
    """
    words = [word for word in words_of(name) if word not in _APART]
    plain = [word for word in words if word not in colours()]
    return " ".join(plain or words) or name


def alike(offers: Mapping[str, Mapping[str, float]]) -> dict[str, str]:
    """The kind of form for each thing that has its like: the one that suits all of them best.

    offers: merit of each kind of form, by name of the thing. Things without a kind in common
    keep their own.
    """
    groups: dict[str, list[str]] = {}
    for name in offers:
        groups.setdefault(kind_name(name), []).append(name)
    out: dict[str, str] = {}
    for names in groups.values():
        shared = sorted(set.intersection(*(set(offers[name]) for name in names)))
        if len(names) > 1 and shared:
            merit = {kind: sum(offers[name][kind] for name in names) for kind in shared}
            best = max(shared, key=lambda kind: merit[kind])
            out.update((name, best) for name in names)
    return out
