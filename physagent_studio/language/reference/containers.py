"""Names of things that can have something in them."""

from __future__ import annotations

from physagent_studio.language.tokens.vocabulary import words_of

_CONTAINERS = words_of(
    "box crate carton basket bin bucket bowl cup mug glass pot pan can trash_can bag drawer sink "
    "tray hole pit tub bathtub barrel jar vase trashcan dustbin hat nest cart wagon"
)


def is_container(name: str) -> bool:
    """Whether a thing of that name can have something in it."""
    words = name.lower().split("_")
    return words[-1] in _CONTAINERS or "_".join(words[-2:]) in _CONTAINERS
