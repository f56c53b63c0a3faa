"""What a sentence asks to be found: things by their words, with colour, size and place."""

import re
from collections.abc import Sequence
from dataclasses import dataclass

from physagent_studio.knowledge import colours, things, word_lists
from physagent_studio.language.tokens import vocabulary as v
from physagent_studio.language.tokens.tokens import verb_base

SIDES = {
    "left": "left", "leftmost": "left", "right": "right", "rightmost": "right",
    "top": "top", "upper": "top", "topmost": "top", "bottom": "bottom", "lower": "bottom",
    "bottommost": "bottom", "middle": "middle", "center": "middle", "central": "middle",
    "centre": "middle", "front": "bottom", "rear": "top",
}  # fmt: skip
LARGE = frozenset(
    {"big", "large", "huge", "giant", "tall", "long", "bigger", "larger", "taller", "biggest",
     "largest", "tallest", "longest"}
)  # fmt: skip
SMALL = frozenset({"small", "little", "tiny", "short", "smaller", "smallest", "tiniest", "mini"})
COUNTS = {"two": 2, "three": 3, "four": 4, "five": 5, "six": 6, "both": 2}
TEXTURES = v.MATERIAL_WORDS | word_lists().meant.keys() | v.PLAIN_ADJECTIVES
_DETERMINERS = frozenset({"the", "a", "an", "another", "this", "that", "one", *COUNTS})
_NO_THINGS = frozenset(
    {"of", "and", "or", "to", "along", "side", "end", "edge", "half", "part", "way", "direction",
     "corner", "center", "centre", "middle", "top", "bottom", "stack", "pile", "row", "group",
     "surface", "air", "camera", "scene", "picture", "photo", "image", *_DETERMINERS}
)  # fmt: skip
_ON = re.compile(r"\b(?:on|onto|upon|atop|on top of)\s+(?:the|a|an)\s+([a-z ]{2,40})")


@dataclass(frozen=True, slots=True)
class Sought:
    """A thing to be found. name: as the case will call it. side: left, right, top, bottom, middle.

    size: +1 for a large one of its kind, −1 for a small one. on: head of what it rests on.
    """

    name: str
    head: str
    colours: tuple[str, ...] = ()
    side: str = ""
    size: int = 0
    on: str = ""


def sought_by(name: str, prompt: str = "") -> Sought:
    """What a name asks for: `small_red_ball`, `left_pin_2`."""
    words = [word for word in re.split(r"[^a-z]+", name.lower()) if word]
    plain = [w for w in words if w not in SIDES and w not in colours() and w not in LARGE | SMALL]
    head = plain[-1] if plain else (words[-1] if words else name)
    return Sought(
        name=name,
        head=head,
        # An orange is a thing; an orange ball is a colour.
        colours=tuple(w for w in words if w in colours() and w != head),
        side=next((SIDES[w] for w in words if w in SIDES), ""),
        size=bool(LARGE & set(words)) - bool(SMALL & set(words)),
        on=_base(head, prompt),
    )


def _base(head: str, prompt: str) -> str:
    """The head noun of what a thing rests on, if the sentence says so right after it."""
    text = prompt.lower()
    at = text.find(head)
    match = _ON.search(text, at) if at >= 0 else None
    if match is None or match.start() - at > len(head) + 12:
        return ""
    words = match.group(1).split()
    known = [n for n in range(len(words), 0, -1) if things.usual_size("_".join(words[:n])).known]
    return words[known[0] - 1] if known else ""


def things_in(prompt: str) -> tuple[Sought, ...]:
    """The things that a sentence speaks of, in its order; what carries them is left out."""
    tokens = re.findall(r"[a-z]+|[.,;]", prompt.lower())
    found: dict[str, Sought] = {}
    heads: set[str] = set()
    at = 0
    while at < len(tokens):
        phrase, count, after = _phrase(tokens, at)
        if not phrase:
            at += 1
            continue
        at = after
        head = phrase[-1]
        bare = len(phrase) == 1 and head in heads
        if _carries(phrase) or bare:
            continue
        heads.add(head)
        stem = "_".join(phrase)
        names = [stem] if count == 1 else [f"{stem}_{number + 1}" for number in range(count)]
        for name in names:
            found.setdefault(name, sought_by(name, prompt))
    return tuple(found.values())


def slopes_in(prompt: str) -> tuple[str, ...]:
    """Names of the slopes and stairs that a sentence speaks of, and of boards that it has something
    go down or up: where they are cannot be told from what stands on them."""
    text = prompt.lower()

    def leads(said: str) -> bool:
        words = r"\s+".join(map(re.escape, said.split("_")))
        return bool(re.search(rf"\b(?:down|up)\s+(?:the|an?|its)\s+(?:\w+\s+)?{words}\b", text))

    found = (
        said
        for kind, said in things.kinds_in(prompt)
        if kind.support in ("ramp", "stairs") or (kind.surface == "flat" and leads(said))
    )
    return tuple(dict.fromkeys(found))


def _carries(phrase: Sequence[str]) -> bool:
    """Whether the phrase names a place or furniture to stand on rather than a thing that moves."""
    name = "_".join(phrase)
    place = phrase[-1] in v.PARTS or v.LANDMARKS.get(phrase[-1]) == "line"
    return place or things.is_surface(name) or things.support_kind(name) != "slab"


def _phrase(tokens: Sequence[str], at: int) -> tuple[tuple[str, ...], int, int]:
    """(words, how many, index after them) of the noun phrase that begins there; no words: none."""
    start, count = at, 1
    while at < len(tokens) and tokens[at] in _DETERMINERS:
        count = COUNTS.get(tokens[at], count)
        at += 1
    determined = at > start
    adjectives: list[str] = []
    while at < len(tokens) - 1 and _describes(tokens, at):
        adjectives.append(tokens[at])
        at += 1
    if not determined and not adjectives:
        return (), 0, at
    noun = _noun(tokens, at)
    if not noun and at + 1 < len(tokens) and tokens[at].isalpha() and not _acts(tokens[at + 1]):
        # A word that is not known describes a noun after it, or is a noun of its own.
        noun = _noun(tokens, at + 1)
        at += bool(noun)
    seen = any(word in colours() or word in TEXTURES for word in adjectives)
    if not noun and (seen or start == 0) and at < len(tokens) and tokens[at] not in _NO_THINGS:
        noun = (tokens[at],)
    if not noun or not noun[0].isalpha():
        return (), 0, max(start, at)
    return (*adjectives, *(_singular(word) for word in noun)), count, at + len(noun)


def _describes(tokens: Sequence[str], at: int) -> bool:
    """Whether a word describes the noun after it; an orange that is followed by none is a noun."""
    word = tokens[at]
    known = word in colours() or word in SIDES or word in LARGE | SMALL | TEXTURES
    if not known:
        return False
    next_word = tokens[at + 1]
    more = next_word in colours() or next_word in SIDES or next_word in LARGE | SMALL | TEXTURES
    return more or bool(_noun(tokens, at + 1)) or word not in word_lists().also_things


def _acts(word: str) -> bool:
    """Whether a word may be the verb of what stands before it: "the gizmo rolls"."""
    return verb_base(word) is not None


def _noun(tokens: Sequence[str], at: int) -> tuple[str, ...]:
    """The longest name of a known kind of thing that begins there."""
    for count in (3, 2, 1):
        words = tuple(tokens[at : at + count])
        whole = len(words) == count and all(word.isalpha() for word in words)
        if whole and things.is_listed("_".join(words)):
            return words
    return ()


def _singular(word: str) -> str:
    return things.words_of(word)[0] if things.words_of(word) else word
