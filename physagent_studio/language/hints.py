"""What a sentence says of a picture: of each thing in it, and what else is to be seen there."""

from __future__ import annotations

import re

from physagent_studio.knowledge import kind_of, kinds_in, words_of


def called(name: str, prompt: str) -> str:
    """The name with its noun as the sentence has it in full.

    "stone" alone is any stone, but the `yellow_stone` of a sentence about "curling stones" is a
    `yellow_curling_stone`.
    """
    own = list(words_of(name))
    kind = kind_of(name)
    noun = next((n for n in reversed(range(len(own))) if kind_of(own[n]) is kind), None)
    if kind is None or noun is None:
        return name
    for special, said in kinds_in(prompt):
        full = words_of(said)
        if special.size is not None and len(full) > 1 and full[-1] == own[noun]:
            return "_".join([*own[:noun], *full, *own[noun + 1 :]])
    return name


_NUMBERS = ("two", "three", "four", "five", "six", "seven", "eight", "nine", "ten")


def told_steps(text: str) -> int | None:
    """How many steps words tell: "three_steps", "a flight of four stairs"; None for none."""
    found = re.search(
        rf"\b({'|'.join(_NUMBERS)})\s+(?:\w+\s+){{0,2}}?(?:steps|stairs|treads)\b",
        text.lower().replace("_", " "),
    )
    return _NUMBERS.index(found.group(1)) + 2 if found else None
