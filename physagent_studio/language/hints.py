"""What a sentence says of a picture: of each thing in it, and of what else is to be seen there."""

import re
from collections.abc import Collection, Mapping
from dataclasses import dataclass, field, replace
from types import MappingProxyType

from physagent_studio.knowledge import (
    Usual,
    has_lid,
    is_open,
    kind_of,
    kinds_in,
    usual_size,
    word_lists,
    words_of,
)

_ALOFT = re.compile(
    r"\b(hang\w*|hung|hover\w*|float\w*|suspend\w*|dangl\w*|levitat\w*"
    r"|mid-?air|in the air|airborne"
    r"|(?:sinks?|sinking|descends?|descending)\b[^.;,]{0,30}\bto the (?:ground|floor))\b"
)
_RISEN = re.compile(
    r"\b(ris(?:es?|en|ing)|rose|lift\w*|rais\w*|picked up|jump\w*|leap\w*|hop\w*|tak(?:es?|ing) off"
    r"|toss\w*|throw\w*|bounc\w*)\b"
)
_HOVERING = re.compile(r"\b(hover\w*|float\w*|mid-?air|in the air|airborne)\b")
_LEANING = re.compile(r"\b(lean(?:s|ing|t|ed)?|propped|tilted|aslant|askew)\b")
_SLIDING = re.compile(r"\b(slid\w*|glid\w*)\b")
_DROPPING = re.compile(
    r"\b(fall\w*|fell|drop\w*|plummet\w*|plunge\w*|detach\w*|land(?:s|ing|ed)?"
    r"|com(?:es?|ing) (?:loose|off|down)|let go|releas\w*|cut)\b"
)
_PLUNGING = r"drop\w*|plummet\w*|plunge\w*"
_ONTO = r"(?:fall|fell|land)\w*\s+(?:\w+\s+){0,2}?(?:on|onto|into|in|upon)\s+(?:\w+\s+){0,2}?"
_ROUND = ("sphere", "ellipsoid")
BEFORE, BEHIND = 60, 40
"""Letters before and behind words of posture among which the name of their owner stands."""
_BLOWS = "bump|crash|run|slam|knock|smash|bang|plough|plow|ram|hit|drive|collide"
_INTO = re.compile(
    r"\b(?P<verb>\w+)?\s*\b(?:into|inside|in)\s+"
    r"(?:the\s+|an?\s+|its\s+|this\s+)?(?P<what>(?:\w+\s+){0,3}\w+)"
)
_NUMBERS = ("two", "three", "four", "five", "six", "seven", "eight", "nine", "ten")


@dataclass(frozen=True, slots=True)
class SceneHints:
    """What reconstruction may know of the sentence.

    aloft, leaning, sliding, dropping: names that hang or float, or lean, or slide, or come down
    from what holds them. landing: names that drop, or come down onto a thing. hollow: names of open
    vessels, as the sentence uses them. steps: of a flight of stairs, where told. seen: what is to
    be looked for, as in `seen_by`. names: each name with its noun in full, as in `called`.
    """

    aloft: frozenset[str] = frozenset()
    leaning: frozenset[str] = frozenset()
    sliding: frozenset[str] = frozenset()
    dropping: frozenset[str] = frozenset()
    landing: frozenset[str] = frozenset()
    hollow: frozenset[str] = frozenset()
    steps: int | None = None
    seen: frozenset[str] = frozenset()
    names: Mapping[str, str] = field(default_factory=lambda: MappingProxyType({}))

    def usual(self, name: str) -> Usual:
        """What is usual for a thing of that name in this sentence: what slides has a flat base,
        unless a thing of that name is round."""
        usual = usual_size(self.names.get(name, name))
        if name not in self.sliding or not usual.shapes or usual.shapes[0] in _ROUND:
            return usual
        return replace(usual, shapes=tuple(s for s in usual.shapes if s not in _ROUND))


def hints(prompt: str, objects: Collection[str], supports: Collection[str] = ()) -> SceneHints:
    """What a prompt says of a picture in which things and supports of those names are."""
    names = (*objects, *supports)
    hollow = frozenset(name for name in names if _is_vessel(name, prompt))
    things = (*objects, *(name for name in supports if name in hollow))
    return SceneHints(
        aloft=frozenset(name for name in things if _hangs_at_first(name, things, prompt)),
        leaning=frozenset(name for name in things if _is_said(_LEANING, name, things, prompt)),
        sliding=frozenset(name for name in objects if _is_said(_SLIDING, name, things, prompt)),
        dropping=frozenset(name for name in objects if _is_said(_DROPPING, name, things, prompt)),
        landing=frozenset(name for name in objects if _lands(name, things, prompt)),
        hollow=hollow,
        steps=told_steps(prompt),
        seen=seen_by(prompt),
        names=MappingProxyType({name: called(name, prompt) for name in names}),
    )


def _hangs_at_first(name: str, things: Collection[str], prompt: str) -> bool:
    """Whether it is told to hang or float, and not only once it has gone up: "rises off the table
    and hovers in the air"."""
    if not _is_said(_ALOFT, name, things, prompt):
        return False
    risen = _RISEN.search(prompt.lower())
    if risen is None or not _is_said(_RISEN, name, things, prompt):
        return True
    before, after = prompt[: risen.end()], prompt[risen.end() :]
    return _is_said(_ALOFT, name, things, before + _HOVERING.sub("", after.lower()))


def _lands(name: str, things: Collection[str], prompt: str) -> bool:
    """Whether it is told to drop, or to come down onto another of the things."""
    nouns = {words_of(other)[-1] for other in things if other != name and words_of(other)}
    onto = f"|{_ONTO}(?:{'|'.join(map(re.escape, sorted(nouns)))})" if nouns else ""
    return _is_said(re.compile(rf"\b(?:{_PLUNGING}{onto})\b"), name, things, prompt)


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


def told_steps(text: str) -> int | None:
    """How many steps words tell: "three_steps", "a flight of four stairs"; None for none."""
    found = re.search(
        rf"\b({'|'.join(_NUMBERS)})\s+(?:\w+\s+){{0,2}}?(?:steps|stairs|treads)\b",
        text.lower().replace("_", " "),
    )
    return _NUMBERS.index(found.group(1)) + 2 if found else None


def seen_by(text: str) -> frozenset[str]:
    """What a picture shows by itself of the places that words name: keys of `seen`."""
    said = set(words_of(text))
    return frozenset(what for what, called_so in word_lists().seen.items() if said & called_so)


def _is_said(how: re.Pattern[str], name: str, names: Collection[str], prompt: str) -> bool:
    """Whether words of the sentence are said of an object: its name is the nearest to them."""
    noun = (words_of(name) or ("",))[-1]
    if len(names) == 1 and how.search(prompt.lower()):
        # There is nothing else in the picture that the words could mean.
        return True
    others = {(words_of(other) or ("",))[-1] for other in names if other != name} - {noun}
    for sentence in re.split(r"[.;]", prompt.lower()):
        for hit in how.finditer(sentence):
            around = sentence[max(0, hit.start() - BEFORE) : hit.end() + BEHIND]
            owners = [word for word in (noun, *sorted(others)) if word and word in around]
            if owners:
                where = hit.start() - max(0, hit.start() - BEFORE)
                ahead = [word for word in owners if -1 < around.find(word) < where]
                # "Lands beside the brick": what does it is named before, but of a falling brick.
                if ahead and not hit.group().endswith("ing"):
                    owners = ahead
                owner = min(owners, key=lambda word: abs(around.find(word) - where))
                if owner == noun:
                    return True
    return False


def _is_vessel(name: str, prompt: str) -> bool:
    """Whether a thing of that name is open at the top, as the sentence uses it."""
    return is_open(name) or (has_lid(name) and _gone_into(words_of(name)[-1], prompt))


def _gone_into(noun: str, prompt: str) -> bool:
    """Whether the sentence has something go into a thing: not hit it."""
    for found in _INTO.finditer(prompt.lower()):
        verb = found.group("verb") or ""
        if re.match(rf"(?:{_BLOWS})", verb):
            continue
        # "Into the pyramid of cans" is into the pyramid.
        what = re.split(r"\b(?:of|with|and|on|near|behind)\b", found.group("what"))[0]
        if noun in words_of(what.strip().replace(" ", "_")):
            return True
    return False
