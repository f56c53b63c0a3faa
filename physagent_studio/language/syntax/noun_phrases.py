"""Noun phrases: which words of a sentence name a thing, and what is said of it."""

from collections.abc import Sequence
from dataclasses import dataclass, field

from physagent_studio.language.syntax.phrases import NounPhrase
from physagent_studio.language.tokens import vocabulary as v
from physagent_studio.language.tokens.expressions import ADVERBIAL
from physagent_studio.language.tokens.tokens import (
    Token,
    is_number,
    is_participle,
    singular,
    verb_base,
)


@dataclass(frozen=True)
class NounPhrases:
    """Finds noun phrases; `nouns` are the words that the case's names are made of."""

    tokens: tuple[Token, ...]
    nouns: frozenset[str]
    _memo: dict[int, tuple[NounPhrase, int] | None] = field(default_factory=dict)

    def word(self, index: int) -> str:
        """The word at a token index; "" past the end."""
        return self.tokens[index].text if 0 <= index < len(self.tokens) else ""

    def nominal(self, i: int) -> bool:
        """Whether the word can be the noun that an adjective before it belongs to."""
        word = self.word(i)
        return bool(word) and (
            word in self.nouns
            or singular(word) in self.nouns
            or word in v.FORCE_NOUNS
            or word in v.CAUSES
            or word in v.PARTS
            or is_adjective(word)
        )

    def _qualifies(self, i: int) -> bool:
        """Whether what follows lets the word before be an adjective ("top and middle books")."""
        joined = self.word(i) in ("and", "or", ",") and is_adjective(self.word(i + 1))
        return self.nominal(i) or (joined and self._reaches_noun(i + 1))

    def noun_phrase(self, i: int) -> tuple[NounPhrase, int] | None:
        if i not in self._memo:
            self._memo[i] = self._parse_noun_phrase(i)
        return self._memo[i]

    def _parse_noun_phrase(self, i: int) -> tuple[NounPhrase, int] | None:
        j, only, determiner, bound = i, False, "", ""
        while self.word(j) in ("only", "just") or self.word(j) in v.BOUNDS:
            only |= self.word(j) not in v.BOUNDS
            bound, j = self.word(j) if self.word(j) in v.BOUNDS else bound, j + 1
        while self.word(j) in v.DETERMINERS and self.word(j) not in ("no",):
            determiner, j = determiner or self.word(j), j + 1
        words, nouns, groups, j = self._nominal_words(j, bool(determiner))
        if not words:
            if determiner in ("all", "both", "each", "some") and self.word(j) == "of":
                words = [determiner]
            else:
                return None
        words, j = self._said_after(words, nouns, i, j)
        of = None
        if self.word(j) == "of" and (inner := self.noun_phrase(j + 1)) is not None:
            of, j = inner
        adjectives = tuple(w for w in words if w not in nouns) if nouns else tuple(words)
        head = singular(nouns[-1]) if nouns else words[-1]
        number = next((v.NUMBERS[w] for w in words if w in v.NUMBERS), _figure(words))
        if only and number is not None and not determiner:
            # "Only two of the pins": two, and no more.
            only, bound = False, bound or "exactly"
        phrase = NounPhrase(
            head, tuple(nouns), adjectives, tuple(groups), determiner, only,
            bound if number is not None else "", number, _amount(words), False,
            bool(nouns) and singular(nouns[-1]) != nouns[-1], of, i, j,
        )  # fmt: skip
        return phrase, j

    def _said_after(
        self, words: list[str], nouns: list[str], i: int, j: int
    ) -> tuple[list[str], int]:
        """ "The pin in the middle", "the ball on the left": a position said behind the noun."""
        if nouns and self.word(j) in v.COUNTED_FROM:
            return [self.word(j), *words], j + 1
        if (self.word(j), self.word(j + 1)) == ("on", "top") and (nouns or words == ["one"]):
            # "The one on top".
            return ["top", *words], j + 2
        named = bool(nouns) or words in (["one"], ["ones"])
        if named and (deep := self._in_depth(i, j)):
            return [deep[0], *words], deep[1]
        if not named or self.word(j) not in ("in", "on", "at") or self.word(j + 1) != "the":
            return words, j
        if self.word(j + 2) in ("left", "right") and self.word(i - 1) in _GOING_BY:
            # "Past the pins on the right": where it passes them, and not which of them.
            return words, j
        where, after = self.word(j + 2), j + 3
        closed = v.CAUSES.keys() | v.FORCE_NOUNS | v.PARTS.keys() | self.nouns
        told = self.word(after) in closed or self._reaches_noun(after)
        if where not in v.POSITIONS or told or self.word(after) == "of":
            return words, j
        return [where, *words], after

    def _in_depth(self, i: int, j: int) -> tuple[str, int] | None:
        """ "The box in front", "the one behind": which way in depth, and what comes after.

        "Left behind" tells what stays, and "behind the box" where something goes.
        """
        if (self.word(j), self.word(j + 1)) == ("in", "front"):
            word, after = "front", j + 2
        elif self.word(j) == "behind" and self.word(i - 1) not in _LEAVING:
            word, after = "back", j + 1
        else:
            return None
        closed = self.word(after) == "of" or self.word(after) in v.DETERMINERS
        return None if closed or self._reaches_noun(after) else (word, after)

    def _nominal_words(
        self, j: int, determined: bool
    ) -> tuple[list[str], list[str], list[tuple[str, ...]], int]:
        words: list[str] = []
        nouns: list[str] = []
        groups: list[tuple[str, ...]] = []
        current: list[str] = []
        while j < len(self.tokens):
            word = self.word(j)
            if self._joins_adjectives(j, words, nouns):
                groups.append(tuple(current))
                current = []
                j += 1
                continue
            role = self._role(j, bool(words) or determined, bool(nouns))
            if role == "end":
                break
            if role == "noun":
                nouns.append(word)
            elif role == "adjective":
                current.append(word)
            if role != "skip":
                words.append(word)
            j += 1
        if groups:
            groups.append(tuple(current))
        return words, nouns, groups, j

    def _joins_adjectives(self, j: int, words: list[str], nouns: list[str]) -> bool:
        joins = self.word(j) in ("and", "or", ",") and bool(words) and not nouns
        return joins and is_adjective(self.word(j + 1)) and self._reaches_noun(j + 1)

    def _reaches_noun(self, j: int) -> bool:
        while is_adjective(self.word(j)) or self.word(j) in ("and", ","):
            j += 1
        word = self.word(j)
        return word in self.nouns or singular(word) in self.nouns

    def _role(self, j: int, started: bool, has_noun: bool) -> str:
        word = self.word(j)
        if not word or not (word[0].isalnum()):
            return "end"
        known = word in self.nouns or singular(word) in self.nouns
        if known and not (has_noun and verb_base(word) and word not in self.nouns):
            return "noun"
        closed = (
            v.PREPOSITIONS | v.CONJUNCTIONS | v.RELATIVES | v.AUXILIARIES | v.NEGATIONS
            | v.DETERMINERS | ADVERBIAL | frozenset(("because_of", "away_from"))
            | v.COUNTED_FROM.keys()
        )  # fmt: skip
        if word in closed:
            return "end"
        if is_adjective(word) or word in v.PARTS:
            return self._adjective_role(j, word, started, has_noun)
        if word in v.PRONOUNS or word in v.SUBORDINATORS or word in v.COUNTS:
            return "noun" if word == "others" and not has_noun else "end"
        if verb_base(word) is not None:
            if self.word(j - 1) in ("both", "all", "each") and word not in v.FORCE_NOUNS:
                return "end"
            return self._verbal_role(j, word, started, has_noun)
        if word in v.FILLERS or word in v.MANNERS or word in v.DIRECTIONS:
            if not has_noun and started and self.nominal(j + 1):
                return "skip" if word in v.FILLERS - v.NEARER.keys() else "adjective"
            return "end"
        if word.endswith("ly") and len(word) > 4:
            return "skip" if started and not has_noun else "end"
        if word in v.POSTURES and not self.nominal(j + 1):
            return "end"
        return "adjective" if word in v.NEARER and started and self.nominal(j + 1) else "noun"

    def _adjective_role(self, j: int, word: str, started: bool, has_noun: bool) -> str:
        if not has_noun:
            if word in v.FORCE_NOUNS or (word in v.PARTS and not self._qualifies(j + 1)):
                return "noun" if started else "end"
            bare = started or self._qualifies(j + 1) or word in v.NUMBERS or word in v.OTHERS
            bare = bare or is_number(word)
            return "adjective" if bare else "end"
        return "noun" if word in v.PARTS and word not in v.DIRECTIONS else "end"

    def _verbal_role(self, j: int, word: str, started: bool, has_noun: bool) -> str:
        if has_noun or self.word(j - 1) in v.OTHERS or self.word(j - 1) in v.NUMBERS:
            return "end"
        after_preposition = self.word(j - 1) in v.PREPOSITIONS - {"to"}
        if singular(word) in v.FORCE_NOUNS and (started or after_preposition):
            return "noun"
        if (verb_base(self.word(j - 1)) or "", word) in v.WITH_OBJECT:
            return "noun"
        if word.endswith(("ing", "ed")) or is_participle(word):
            describes = self.nominal(j + 1) or (started and self._plain_noun(j + 1))
            return "adjective" if describes else "end"
        return "noun" if started else "end"

    def _plain_noun(self, j: int) -> bool:
        """Whether an unknown word can only be a noun."""
        word = self.word(j)
        closed = (
            v.PREPOSITIONS | v.CONJUNCTIONS | v.RELATIVES | v.AUXILIARIES | v.NEGATIONS
            | v.DETERMINERS | v.PRONOUNS | v.SUBORDINATORS | v.FILLERS | ADVERBIAL
        )  # fmt: skip
        other = word in closed or word in v.DIRECTIONS or word in v.MANNERS or word.endswith("ly")
        return word.isalpha() and not other and verb_base(word) is None


_GOING_BY = ("past", "beyond", "by", "around")
_LEAVING = ("leave", "leaves", "left", "leaving")


def is_adjective(word: str) -> bool:
    """Whether the word can describe a noun that follows."""
    return (
        word in v.COLOURS
        or word in v.SIZES
        or word in v.POSITIONS
        or word in v.ORDINALS
        or word in v.NUMBERS
        or word in v.OTHERS
        or word in v.MATERIAL_WORDS
        or word in v.PLAIN_ADJECTIVES
        or (word in v.MANNERS and not word.endswith("ly"))
        or word in ("sideways", "lateral", "horizontal", "vertical", "sideway")
        or is_number(word)
    )


def _amount(words: Sequence[str]) -> float | None:
    """The number that words say: "90", "ninety", "forty five", "one hundred and eighty"."""
    numbers = [float(v.NUMBERS.get(word, word)) for word in words if is_number(word)]
    if not numbers:
        return None
    total = numbers[0]
    for number in numbers[1:]:
        total = total * number if total < number == 100.0 else total + number
    return total


def _figure(words: Sequence[str]) -> int | None:
    return next((int(word) for word in words if word.isdecimal() and len(word) < 4), None)
