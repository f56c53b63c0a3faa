"""Tables that the prompt alone speaks of: what leaves them needs an edge to leave and a way down.

A photo that a table fills shows one level, and things slide about on it as on a floor. Where the
prompt has something come off that table, or speaks of its edge, the table is a support of its own.
"""

from collections.abc import Iterable

from physagent_studio.knowledge import is_surface, support_kind
from physagent_studio.language import EDGES, Inventory, Reading, inventory, read
from physagent_studio.language.tokens.tokens import singular
from physagent_studio.program.scene.state import Grounding
from physagent_studio.records import Case

_STAYING = frozenset(("bounce", "rise", "jump"))
"""What goes up from a surface and may come down on it."""


def surface_left(case: Case) -> str | None:
    """The word for the surface that something leaves, where the case has no support for it.

    None as well where the case names any other support, for that may stand on the surface.
    """
    if any(not _is_ground(support.name) for support in case.supports):
        return None
    given = [*(name for name, _ in case.objects), *(support.name for support in case.supports)]
    taken = {singular(word) for name in given for word in name.lower().replace("-", "_").split("_")}
    for word in _words(case.prompt):
        if is_surface(word) and word not in taken:
            stock = inventory(case.objects, [(word, Grounding())], [m.name for m in case.landmarks])
            if _is_left(word, read(case.prompt, stock), stock):
                return word
    return None


def _words(prompt: str) -> Iterable[str]:
    """The words of a prompt in the singular, each once."""
    plain = "".join(c if c.isalpha() else " " for c in prompt.lower())
    return dict.fromkeys(singular(word) for word in plain.split())


def _is_ground(name: str) -> bool:
    return support_kind(name) == "floor"


def _is_left(name: str, reading: Reading, stock: Inventory) -> bool:
    """Whether something comes off it, reaches its edge, or comes from it to the ground."""
    on_it = any(place.name == name for place in reading.places())
    lands = any(place.name == stock.ground for place in reading.places())
    for frame in reading.frames:
        for relation, place in frame.places:
            if place.name != name or frame.sense in _STAYING:
                continue
            off = relation in ("off", "from") or frame.sense == "leave" or place.part in EDGES
            if off:
                return True
    return on_it and lands
