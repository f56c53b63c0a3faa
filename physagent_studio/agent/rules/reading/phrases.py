"""Chunks of a sentence: noun phrases, prepositional phrases, verb groups and what joins them."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import Literal

from physagent_studio.agent.rules.reading import vocabulary as v
from physagent_studio.agent.rules.reading.tokens import (
    Token,
    singular,
)
from physagent_studio.agent.rules.reading.vocabulary import words_of

ChunkKind = Literal["np", "pp", "verb", "adv", "and", "sub", "rel", "stop", "gap"]


@dataclass(frozen=True, slots=True)
class NounPhrase:
    """head: singular noun, or the pronoun. words: its nouns and adjectives as written.

    alternatives: coordinated adjectives ("the top and middle …"). of: what follows "of".
    bound: the limit that the number is ("at least two"), a word of `BOUNDS`. amount: the number
    that it begins with, be it a count or not.
    """

    head: str
    nouns: tuple[str, ...] = ()
    adjectives: tuple[str, ...] = ()
    alternatives: tuple[tuple[str, ...], ...] = ()
    determiner: str = ""
    only: bool = False
    bound: str = ""
    number: int | None = None
    amount: float | None = None
    pronoun: bool = False
    plural: bool = False
    of: NounPhrase | None = None
    start: int = 0
    end: int = 0


@dataclass(frozen=True, slots=True)
class Chunk:
    """A piece of the sentence; start and end are token indices."""

    kind: ChunkKind
    start: int
    end: int
    word: str = ""
    np: NounPhrase | None = None
    verb: str = ""
    form: str = ""
    passive: bool = False
    finite: bool = True
    negated: bool = False
    strong_stop: bool = False


FIXED: tuple[tuple[tuple[str, ...], str], ...] = tuple(
    (tuple(words.split()), one)
    for words, one in (
        ("in front of", "infront"),
        ("on top of", "atop"),
        ("onto the top of", "atop"),
        ("to the left of", "leftof"),
        ("to the right of", "rightof"),
        ("on the left of", "leftof"),
        ("on the right of", "rightof"),
        ("left of", "leftof"),
        ("right of", "rightof"),
        ("next to", "near"),
        ("up against", "against"),
        ("in opposite directions", "apart"),
        ("in different directions", "apart"),
        ("picks up speed", "accelerates"),
        ("pick up speed", "accelerate"),
        ("picking up speed", "accelerating"),
        ("gathers speed", "accelerates"),
        ("gather speed", "accelerate"),
        ("gathering speed", "accelerating"),
        ("out from under", "off"),
        ("from under", "off"),
        ("make it to", "reach"),
        ("makes it to", "reaches"),
        ("made it to", "reached"),
        ("making it to", "reaching"),
        ("make it as far as", "reach"),
        ("gets to the", "reaches the"),
        ("get to the", "reach the"),
        ("getting to the", "reaching the"),
        ("gets up", "rises"),
        ("fails to", "does not"),
        ("fail to", "do not"),
        ("refuses to", "does not"),
        ("is unable to", "does not"),
        ("is not able to", "does not"),
        ("on its back", "supine"),
        ("onto its back", "supine"),
        ("on its face", "prone"),
        ("onto its face", "prone"),
        ("flat on its face", "prone"),
        ("face down", "prone"),
        ("face first", "prone"),
        ("meters per second", "m/s"),
        ("metres per second", "m/s"),
        ("meter per second", "m/s"),
        ("metre per second", "m/s"),
        ("meters a second", "m/s"),
        ("metres a second", "m/s"),
        ("kilometers per hour", "km/h"),
        ("kilometres per hour", "km/h"),
        ("miles per hour", "mph"),
        ("back the way it came", "back"),
        ("back the way they came", "back"),
        ("back where it came from", "back"),
        ("where it started", "where_it_started"),
        ("where it began", "where_it_started"),
        ("where it came from", "where_it_started"),
        ("where they started", "where_it_started"),
        ("to its starting point", "where_it_started"),
        ("to its starting position", "where_it_started"),
        ("to its original position", "where_it_started"),
        ("to its original place", "where_it_started"),
        ("one step after another", "stepwise"),
        ("step by step", "stepwise"),
        ("close to", "near"),
        ("because of", "because_of"),
        ("due to", "because_of"),
        ("as a result of", "because_of"),
        ("away from", "away_from"),
        ("out of", "off"),
        ("off of", "off"),
        ("down from", "off"),
        ("from behind", "from_behind"),
        ("from above", "from_above"),
        ("from below", "from_below"),
        ("along with", "with"),
        ("together with", "with"),
        ("center of mass", "masscenter"),
        ("centre of mass", "masscenter"),
        ("center of gravity", "masscenter"),
        ("no longer", "not"),
        ("on the far side of", "behind"),
        ("on the other side of", "behind"),
        ("to the far side of", "behind"),
        ("on the near side of", "infront"),
        ("short of", "before"),
        ("up to the", "to the"),
        ("except for", "except"),
        ("apart from", "except"),
        ("other than", "except"),
        ("with the exception of", "except"),
        ("down from left to right", "down rightwards"),
        ("down from right to left", "down leftwards"),
        ("from left to right", "rightwards"),
        ("from right to left", "leftwards"),
        ("takes out", "knocks over"),
        ("take out", "knock over"),
        ("taking out", "knocking over"),
        ("took out", "knocked over"),
        ("is the only one that", "alone"),
        ("is the only one which", "alone"),
        ("is the only one to", "alone"),
        ("are the only ones that", "alone"),
        ("are the only ones to", "alone"),
        ("on the spot", "motionless"),
        ("ends up", "ends_up"),
        ("end up", "ends_up"),
        ("ended up", "ends_up"),
        ("ending up", "ends_up"),
        ("winds up", "ends_up"),
        ("any of them", "them"),
        ("toward each other", "inwards"),
        ("towards each other", "inwards"),
        ("toward one another", "inwards"),
        ("towards one another", "inwards"),
        ("away from each other", "apart"),
        ("away from one another", "apart"),
        ("gives way", "collapses"),
        ("give way", "collapse"),
        ("upside down", "inverted"),
        ("in place", "motionless"),
        ("in the air", "airborne"),
        ("through the air", "airborne"),
        ("in mid air", "airborne"),
        ("in midair", "airborne"),
        ("on its side", "sidelong"),
        ("onto its side", "sidelong"),
        ("on their sides", "sidelong"),
        ("at rest", "motionless"),
        ("half way", "halfway"),
        ("half of the way", "halfway"),
        ("half the way", "halfway"),
        ("part of the way", "partway"),
        ("some of the way", "partway"),
        ("part way", "partway"),
        ("most of the way", "mostway"),
        ("a third of the way", "thirdway"),
        ("one third of the way", "thirdway"),
        ("the whole way", "alltheway"),
        ("all the way", "alltheway"),
        ("to the camera", "toward_camera"),
        ("toward the camera", "toward_camera"),
        ("towards the camera", "toward_camera"),
        ("toward the viewer", "toward_camera"),
        ("towards the viewer", "toward_camera"),
        ("from the camera", "from_camera"),
        ("from the viewer", "from_camera"),
        ("away from the camera", "from_camera"),
        ("away from the viewer", "from_camera"),
        ("to the left", "leftwards"),
        ("to the right", "rightwards"),
        ("toward the left", "leftwards"),
        ("toward the right", "rightwards"),
        ("towards the left", "leftwards"),
        ("towards the right", "rightwards"),
        ("to its left", "leftwards"),
        ("to its right", "rightwards"),
        ("to the side", "sideways"),
        ("to one side", "sideways"),
        ("coming from the left", "from_left"),
        ("coming from the right", "from_right"),
        ("coming from behind", "from_behind"),
        ("blowing from the left", "from_left"),
        ("blowing from the right", "from_right"),
        ("from the left", "from_left"),
        ("from the right", "from_right"),
        ("from the front", "from_front"),
        ("from the side", "from_side"),
        ("from one side", "from_side"),
        ("from the left side", "from_left"),
        ("from the right side", "from_right"),
        ("to and fro", "rhythmically"),
        ("back and forth", "rhythmically"),
        ("side to side", "rhythmically"),
        ("so that", "so"),
        ("as soon as", "assoonas"),
        ("the moment that", "assoonas"),
        ("the instant that", "assoonas"),
        ("no sooner than", "assoonas"),
        ("at least", "atleast"),
        ("no fewer than", "atleast"),
        ("no less than", "atleast"),
        ("at most", "atmost"),
        ("no more than", "atmost"),
        ("not more than", "atmost"),
        ("more than", "morethan"),
        ("fewer than", "fewerthan"),
        ("less than", "fewerthan"),
        ("a couple of", "two"),
        ("two or more", "atleast two"),
        ("one or more", "atleast one"),
        ("most of the", "most"),
        ("all but one of the", "allbutone"),
        ("all but one", "allbutone"),
        ("either of the", "either"),
        ("tries to", "starts"),
        ("at once", "immediately"),
        ("a little", "slightly"),
        ("a bit", "slightly"),
        ("table top", "tabletop"),
        ("trash can", "trash_can"),
        ("right before", "before"),
        ("just before", "before"),
        ("shortly before", "before"),
        ("right after", "after"),
        ("just after", "after"),
        ("shortly after", "after"),
        ("right at", "at"),
        ("right next to", "near"),
        ("right past", "past"),
        ("right through", "through"),
        ("right over", "over"),
        ("right off", "off"),
        ("back down", "down"),
        ("back up", "up"),
        ("back onto", "onto"),
        ("back on", "on"),
        ("back into", "into"),
        ("back in", "in"),
        ("around to the right", "rightwards"),
        ("around to the left", "leftwards"),
        ("over to the right", "rightwards"),
        ("over to the left", "leftwards"),
        ("they both", "they"),
        ("they all", "they"),
        ("them both", "them"),
        ("both of them", "both"),
        ("all of them", "all"),
        ("either of them", "them"),
        ("all of the", "all the"),
        ("both of the", "both the"),
        ("each of the", "each"),
        ("a couple of times", "twice"),
        ("any of the", "the"),
        ("everything else", "others"),
        ("everyone else", "others"),
        ("anything else", "others"),
        ("all else", "others"),
        ("the rest of the", "the other"),
        ("all the rest", "others"),
        ("the rest", "others"),
        # A quantity of nothing denies the clause that it stands in.
        ("none of the", "not all the"),
        ("none of them", "not them"),
        ("neither of the", "not both the"),
        ("neither of them", "not them"),
        ("nothing else", "not others"),
        ("nothing", "not everything"),
        ("with no", "without"),
        ("neither", "not both"),
        ("nor", "and not"),
        ("no", "not every"),
        ("one after the other", "successively"),
        ("one after another", "successively"),
        ("one by one", "successively"),
        ("at the same time", "simultaneously"),
        ("at the same moment", "simultaneously"),
        ("by itself", "naturally"),
        ("by themselves", "naturally"),
        ("on its own", "naturally"),
        ("on their own", "naturally"),
        ("head on", "squarely"),
        ("as well", "also"),
        ("starting with", "starting_with"),
        ("beginning with", "starting_with"),
        ("gets there", "arrives"),
        ("get there", "arrive"),
        ("getting there", "arriving"),
        ("from the top", "counted_top"),
        ("from the bottom", "counted_bottom"),
    )
)
ADVERBIAL = words_of(
    "motionless airborne sidelong inverted halfway midway alltheway partway mostway thirdway "
    "successively simultaneously stepwise alone nearly almost supine prone where_it_started "
    "toward_camera from_camera from_left from_right from_front from_side from_behind "
    "from_above from_below"
)


ALWAYS = v.words_of("assoonas while when because although though whereas whilst")
"""Subordinators that are nothing else, so that a clause begins even where its verb is unknown."""


def join_fixed(tokens: Sequence[Token], names: Iterable[tuple[str, ...]]) -> tuple[Token, ...]:
    """Replaces fixed expressions by plainer ones, and the case's own names of several words by one
    token each; all tokens of a replacement have the span of what was written."""
    own = [(words, "_".join(words)) for words in names if len(words) > 1]
    table = sorted([*own, *FIXED], key=lambda row: -len(row[0]))
    joined: list[Token] = []
    index = 0
    while index < len(tokens):
        for words, one in table:
            part = tokens[index : index + len(words)]
            if len(part) == len(words) and _same(part, words, one):
                joined += [Token(word, part[0].start, part[-1].end) for word in one.split()]
                index += len(words)
                break
        else:
            joined.append(tokens[index])
            index += 1
    return tuple(joined)


def _same(part: Sequence[Token], words: tuple[str, ...], one: str) -> bool:
    last = part[-1].text
    return all(t.text == w for t, w in zip(part[:-1], words, strict=False)) and (
        last == words[-1] or ("_" in one and singular(last) == words[-1])
    )
