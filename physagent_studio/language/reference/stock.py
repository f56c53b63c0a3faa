"""What a case names, and what was spoken of so far."""

from dataclasses import dataclass, field

from physagent_studio.knowledge import kind_of
from physagent_studio.language.frames import Place
from physagent_studio.language.tokens import vocabulary as v
from physagent_studio.language.tokens.tokens import singular
from physagent_studio.program.scene.state import Grounding

FUNCTION_WORDS = v.PREPOSITIONS | v.CONJUNCTIONS | v.DETERMINERS
"""Words that say how others belong together: a name may have them, but is not told by them."""


@dataclass(frozen=True, slots=True)
class Thing:
    """A name of the case with the words it is made of and where it was clicked, pixels.

    extents: height and mean edge, m, where they are known.
    """

    name: str
    words: tuple[str, ...]
    spots: tuple[tuple[float, float], ...] = ()
    extents: tuple[float, float] | None = None

    @property
    def head(self) -> str:
        """The last word of the name that is no position or number."""
        plain = [w for w in self.words if w not in v.POSITIONS and not w.isdecimal()]
        return plain[-1] if plain else self.words[-1]

    @property
    def spot(self) -> tuple[float, float] | None:
        """The mean of its clicks, pixels."""
        if not self.spots:
            return None
        n = len(self.spots)
        return (sum(x for x, _ in self.spots) / n, sum(y for _, y in self.spots) / n)


def thing(name: str, grounding: Grounding = Grounding()) -> Thing:  # noqa: B008 - frozen
    """A name with its words; a box stands for a click in its middle."""
    words = tuple(singular(word) for word in name.lower().replace("-", "_").split("_") if word)
    spots = tuple((c.x, c.y) for c in grounding.points if c.label)
    if not spots and grounding.box is not None:
        x0, y0, x1, y1 = grounding.box
        spots = (((x0 + x1) / 2, (y0 + y1) / 2),)
    return Thing(name, words or (name.lower(),), spots)


@dataclass(frozen=True)
class Inventory:
    """Everything that the case names, and the name of its ground.

    stacks: objects that stand on one another, from the lowest to the highest, where it is known.
    on: objects with the support that carries them in the end, where that is known.
    """

    objects: tuple[Thing, ...]
    supports: tuple[Thing, ...] = ()
    landmarks: tuple[Thing, ...] = ()
    ground: str = "floor"
    nouns: frozenset[str] = field(default_factory=frozenset)
    stacks: tuple[tuple[str, ...], ...] = ()
    on: tuple[tuple[str, str], ...] = ()

    def phrases(self) -> tuple[tuple[str, ...], ...]:
        """Names of several words that would confuse a word-by-word reading."""
        things = (*self.objects, *self.supports, *self.landmarks)
        return tuple(t.words for t in things if _confuses(t))


def _confuses(thing: Thing) -> bool:
    """Whether a word of a name has a part of its own in a sentence ("block on top"), or is a
    position that is none ("spinning top")."""
    kind = kind_of(thing.name) if thing.words[-1] in v.POSITIONS else None
    names = (kind.name, *kind.synonyms) if kind is not None else ()
    ends = any(name.endswith(f"_{thing.words[-1]}") for name in names)
    return ends or any(word in FUNCTION_WORDS | v.AUXILIARIES for word in thing.words)


@dataclass
class Discourse:
    """What was spoken of so far in the prompt; lives only while it is read.

    subject: what was last a subject. acting: the subject of the clause whose other words are read.
    """

    mentions: list[tuple[str, ...]] = field(default_factory=list)
    subject: tuple[str, ...] = ()
    acting: tuple[str, ...] = ()
    support: Place | None = None
    landmark: Place | None = None

    def mention(self, names: tuple[str, ...], behind: bool = False) -> None:
        """Notes that these objects were spoken of; behind: what something only leaves is less at
        hand than that."""
        if names:
            self.mentions.insert(max(len(self.mentions) - behind, 0), names)

    @property
    def known(self) -> frozenset[str]:
        """All objects mentioned so far."""
        return frozenset(name for names in self.mentions for name in names)
