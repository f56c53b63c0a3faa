"""What a thing's name says of it: its kind, how large it usually is, what it is to others."""

import re
from collections.abc import Callable
from dataclasses import dataclass
from functools import cache, lru_cache

from physagent_studio.errors import InputError
from physagent_studio.knowledge.catalogue import Kind, kinds, materials, word_lists

BALL_ASPECT = (1.0, 0.08)
"""Height over width of what is a sphere, and the spread of its logarithm: as masks are drawn."""
ADJECTIVE_SPREAD = 0.2
"""What an adjective of size adds to the spread of the logarithm of a size: people differ in it."""
RISER = 0.17
"""Usual height of a step, m."""


@dataclass(frozen=True, slots=True)
class Usual:
    """metres: longer visible side. spread: of its logarithm. shapes: likely ones, best first.

    known: whether the name said it. depth, aspect, lies, flat: as in `objects.yaml`. drives:
    whether it stands on wheels under its length. parts: what it has beside its body, as in
    `objects.yaml`. opens: whether it is open at the top.
    """

    metres: float
    spread: float
    shapes: tuple[str, ...] = ()
    known: bool = True
    depth: float | None = None
    aspect: tuple[float, float] | None = None
    lies: float | None = None
    drives: bool = False
    parts: tuple[str, ...] = ()
    opens: bool = False
    flat: float | None = None


UNKNOWN = Usual(0.3, 1.0, (), False)
"""Nothing known: an object is taken to be 0.3 m."""


def kind_of(name: str) -> Kind | None:
    """The kind of thing that a name speaks of, None where no word of it is known.

    Its last words count most: a `car_box` is a box, an `office_chair_2` an office chair.
    """
    return _match(_split(name))[0]


def words_of(name: str) -> tuple[str, ...]:
    """Lower-case words of a name such as `left_pin2`, numbers dropped, known plurals singular."""
    return tuple(
        next((form for form in _singular(word) if form in _by_word()), word)
        for word in re.findall(r"[a-z]+", name.lower())
    )


def is_listed(name: str) -> bool:
    """Whether exactly these words are a known kind of thing, as "bowling pin" is; not a place."""
    kind, rest = _match(_split(name))
    return kind is not None and not rest and kind.size is not None


def kinds_in(text: str) -> list[tuple[Kind, str]]:
    """The kinds that a sentence names in its order, each with its words; longest names first."""
    said = _split(text)
    found: list[tuple[Kind, str]] = []
    at = 0
    while at < len(said):
        for end in range(min(at + _longest(), len(said)), at, -1):
            kind, rest = _match(said[at:end])
            if kind is not None and not rest:
                found.append((kind, "_".join(said[at:end])))
                at = end - 1
                break
        at += 1
    return found


@cache
def material_words() -> dict[str, str]:
    """The material that each word for one speaks of."""
    return {word: name for name, row in materials().items() for word in row.words}


def all_words(of: Callable[[Kind], bool]) -> frozenset[str]:
    """The single words for all kinds of which something holds."""
    found = (word for kind in kinds() if of(kind) for word in (kind.name, *kind.synonyms))
    return frozenset(word for word in found if "_" not in word)


def usual_size(name: str) -> Usual:
    """What is usual for a thing of that name, adjectives of size among its words heeded."""
    kind, rest = _match(_split(name))
    if kind is None or kind.size is None:
        return UNKNOWN
    metres, spread = kind.size
    for word in rest:
        if word in word_lists().times:
            metres, spread = metres * word_lists().times[word], spread + ADJECTIVE_SPREAD
    aspect = kind.aspect or (BALL_ASPECT if kind.shapes[0] == "sphere" else None)
    drives, opens = kind.wheels == "long_axis", kind.hollow == "open"
    return Usual(
        metres,
        spread,
        kind.shapes,
        depth=kind.depth,
        aspect=aspect,
        lies=kind.lies,
        drives=drives,
        parts=kind.parts,
        opens=opens,
        flat=kind.flat,
    )


def support_height(name: str) -> float | None:
    """Usual height of a support's top above the floor, m; None where the name says nothing."""
    kind = kind_of(name)
    return None if kind is None else kind.top


def support_kind(name: str) -> str:
    """`floor`, `ramp`, `wall` or `slab`: what a support of that name is. Stairs are a ramp."""
    kind = kind_of(name)
    if kind is None:
        return "slab"
    if kind.support == "stairs":
        return "ramp"
    return kind.support if kind.support in ("floor", "ramp", "wall") else "slab"


def is_surface(word: str) -> bool:
    """Whether a word is for what is level and ends somewhere, and made for things to stand on."""
    kind = kind_of(word)
    return kind is not None and bool(kind.surface) and kind.support in (None, "board")


def is_table(name: str) -> bool:
    """Whether a thing of that name is a table of some kind: its level top is its widest part."""
    kind = kind_of(name)
    return kind is not None and kind.surface == "level"


def is_sheet(name: str) -> bool:
    """Whether a thing of that name is a cloth."""
    return is_flag(name) or _with("body", "sheet")(name)


def is_container(name: str) -> bool:
    """Whether a thing of that name can have something in it."""
    kind = kind_of(name)
    return kind is not None and kind.hollow is not None


def density_of(name: str) -> float | None:
    """Mean density of a thing that is mostly air in its outline, kg/m³; None of any other."""
    kind = kind_of(name)
    return None if kind is None else kind.density


def stiffness_of(name: str) -> float | None:
    """Young's modulus, Pa, of a thing that is known to wobble and give way; None for others."""
    kind = kind_of(name)
    return None if kind is None else kind.young


def _with(field: str, value: str) -> Callable[[str], bool]:
    """Whether a name is of a kind whose row has that value: no, where there is no row."""
    return lambda name: getattr(kind_of(name), field, None) == value


is_stairs = _with("support", "stairs")
"""Whether a support of that name has several steps; one step or stair is a block."""
is_step = _with("support", "step")
"""Whether a support of that name is one of several steps that belong together."""
is_board = _with("support", "board")
"""Whether a support of that name is one of several boards that belong together."""
is_rails = _with("support", "rails")
"""Whether a support of that name is a pair of rails."""
is_solid = _with("base", "solid")
"""Whether a support of that name reaches down to the floor as one body."""
is_splayed = _with("base", "splayed")
"""Whether a support of that name has legs that are not upright."""
is_flag = _with("body", "flag")
"""Whether it is a cloth that is held along one side."""
is_loose = _with("body", "grains")
"""Whether it is made of grains."""
is_open = _with("hollow", "open")
"""Whether a thing of that name is hollow and has no lid."""
has_lid = _with("hollow", "lidded")
"""Whether a thing of that name may be open: it is where something goes into it."""
grows = _with("body", "plant")
"""Whether a thing of that name is rooted where it stands; a pine table is not."""


def _split(text: str) -> tuple[str, ...]:
    return tuple(re.findall(r"[a-z]+", text.lower()))


@lru_cache(maxsize=4096)
def _match(said: tuple[str, ...]) -> tuple[Kind | None, tuple[str, ...]]:
    """The kind that the last known words name, the longest name first; and the other words."""
    table, longest = _by_word(), _longest()
    for end in range(len(said), 0, -1):
        for start in range(max(end - longest, 0), end):
            for last in _singular(said[end - 1]):
                found = table.get("_".join([*said[start : end - 1], last]))
                if found is not None and not _is_tint(said[start:end], said[end:]):
                    return found, said[:start] + said[end:]
    return None, said


def _is_tint(name: tuple[str, ...], after: tuple[str, ...]) -> bool:
    """Whether a fruit is only the colour of what is named after it: an orange ring, but not an
    orange slice. Single letters after it tell things apart."""
    nouns = [word for word in after if len(word) > 1]
    return bool(nouns) and set(name) <= word_lists().tints and not set(nouns) & word_lists().food


@cache
def _by_word() -> dict[str, Kind]:
    """The kinds by name and synonym."""
    table: dict[str, Kind] = {}
    for kind in kinds():
        for word in (kind.name, *kind.synonyms):
            if word in table:
                raise InputError(f"objects.yaml: '{word}' stands in two rows")
            table[word] = kind
    return table


@cache
def _longest() -> int:
    """Words of the longest name."""
    return max(word.count("_") + 1 for word in _by_word())


def _singular(word: str) -> tuple[str, ...]:
    """What a word may be the plural of, itself first."""
    endings = (("ies", "y"), ("ves", "fe"), ("ves", "f"), ("es", ""), ("s", ""))
    return (word, *(word.removesuffix(a) + b for a, b in endings if word.endswith(a)))
