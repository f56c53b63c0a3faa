"""Cuts a sentence into chunks: noun phrases, prepositional phrases, verb groups, joints."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace

from physagent_studio.agent.rules.reading import vocabulary as v
from physagent_studio.agent.rules.reading.phrases import ADVERBIAL, ALWAYS, Chunk, NounPhrase
from physagent_studio.agent.rules.reading.tokens import (
    Token,
    is_participle,
    looks_like_verb,
    singular,
    verb_base,
)


@dataclass(frozen=True)
class Chunker:
    """Cuts tokens into chunks; `nouns` are the words that the case's names are made of."""

    tokens: tuple[Token, ...]
    nouns: frozenset[str]
    _memo: dict[int, tuple[NounPhrase, int] | None] = field(default_factory=dict)

    def chunks(self) -> tuple[Chunk, ...]:
        """All chunks in order; every token belongs to exactly one."""
        out: list[Chunk] = []
        index = 0
        while index < len(self.tokens):
            chunk = self._next(index, out)
            out.append(chunk)
            index = chunk.end
        return tuple(out)

    def word(self, index: int) -> str:
        """The word at a token index; "" past the end."""
        return self.tokens[index].text if 0 <= index < len(self.tokens) else ""

    def _next(self, i: int, before: list[Chunk]) -> Chunk:
        word = self.word(i)
        if word in ".,;:!?()":
            return Chunk("stop", i, i + 1, word, strong_stop=word in ".;!?")
        if word in v.RELATIVES and self._relative(i, before):
            return Chunk("rel", i, i + 1, word)
        if word in v.SUBORDINATORS and (word in ALWAYS or self._clause_follows(i + 1)):
            return Chunk("sub", i, i + 1, word)
        if word in v.CONJUNCTIONS:
            return Chunk("and", i, i + 1, word)
        if (group := self._verb_group(i, before)) is not None:
            return group
        if word in v.PREPOSITIONS or word in ("because_of", "away_from"):
            return self._preposition(i, word)
        if self._is_adverb(i, word):
            return Chunk("adv", i, i + 1, word)
        if (found := self._noun_phrase(i)) is not None:
            return Chunk("np", i, found[1], np=found[0])
        if word in v.PRONOUNS or word in v.DETERMINERS:
            np = NounPhrase(word, pronoun=True, plural=word in ("they", "them", "both", "all"))
            return Chunk("np", i, i + 1, np=replace(np, start=i, end=i + 1))
        if word in v.MANNERS or word in v.POSTURES or word in v.POSITIONS:
            return Chunk("adv", i, i + 1, word)
        return Chunk("gap", i, i + 1, word)

    def _relative(self, i: int, before: list[Chunk]) -> bool:
        if not before or before[-1].kind not in ("np", "pp", "stop"):
            return False
        nxt = self.word(i + 1)
        return nxt in v.AUXILIARIES or verb_base(nxt) is not None

    def _clause_follows(self, i: int) -> bool:
        """Whether a verb comes before the next stop."""
        for index in range(i, len(self.tokens)):
            word = self.word(index)
            if word in ".,;:!?":
                return False
            if word in v.BE or (verb_base(word) and not self._noun_here(index)):
                return True
        return False

    def _noun_here(self, i: int) -> bool:
        """Whether a word that could be a verb stands in a noun's place."""
        word, previous, following = self.word(i), self.word(i - 1), self.word(i + 1)
        if word in self.nouns or singular(word) in self.nouns:
            follows_name = previous in self.nouns or singular(previous) in self.nouns
            return not follows_name or "_" in word
        if (verb_base(previous) or "", word) in v.WITH_OBJECT:
            return True
        behind = self.word(i - 2) == "the" and self.word(i - 3) in ("in", "on", "at")
        closed = behind or previous in v.OTHERS or previous in v.NUMBERS or previous in v.DIRECTIONS
        adjective = _is_adjective(previous) and previous not in self.nouns and not closed
        if previous in ("both", "all", "each") and word not in v.FORCE_NOUNS:
            # "…, both come to rest": the subject is "both".
            return False
        if previous in v.DETERMINERS or (adjective and not self._after_noun(i - 1)):
            return True
        if previous in v.PREPOSITIONS and previous != "to":
            return not word.endswith("ing") or following in self.nouns
        return previous == "to" and (word.endswith(("s", "ing")) or verb_base(word) != word)

    def _after_noun(self, i: int) -> bool:
        previous = self.word(i - 1)
        return previous in self.nouns or singular(previous) in self.nouns

    def _is_adverb(self, i: int, word: str) -> bool:
        if word in v.FILLERS or word in v.COUNTS or word in ADVERBIAL:
            if word in ("only", "just") and self._noun_phrase(i + 1) is not None:
                return False
            return not (word == "first" and self._nominal(i + 1))
        if word in v.DIRECTIONS or word in v.MANNERS or word in v.POSTURES:
            return not self._nominal(i + 1) or self._after_noun(i)
        return word.endswith("ly") and len(word) > 4 and not self._nominal(i + 1)

    def _nominal(self, i: int) -> bool:
        """Whether the word can be the noun that an adjective before it belongs to."""
        word = self.word(i)
        return bool(word) and (
            word in self.nouns
            or singular(word) in self.nouns
            or word in v.FORCE_NOUNS
            or word in v.CAUSES
            or word in v.PARTS
            or _is_adjective(word)
        )

    def _qualifies(self, i: int) -> bool:
        """Whether what follows lets the word before be an adjective ("top and middle books")."""
        joined = self.word(i) in ("and", "or", ",") and _is_adjective(self.word(i + 1))
        return self._nominal(i) or (joined and self._reaches_noun(i + 1))

    def _preposition(self, i: int, word: str) -> Chunk:
        found = self._noun_phrase(i + 1)
        if found is None and self.word(i + 1) in v.PRONOUNS:
            np = NounPhrase(self.word(i + 1), pronoun=True, start=i + 1, end=i + 2)
            found = (np, i + 2)
        if found is None:
            return Chunk("adv", i, i + 1, word)
        return Chunk("pp", i, found[1], word, np=found[0])

    # --- verbs ---------------------------------------------------------------------------------

    def _verb_group(self, i: int, before: list[Chunk]) -> Chunk | None:
        j, passive, negated, finite = i, False, False, False
        while self.word(j) in v.AUXILIARIES | v.NEGATIONS or (
            j > i and self._skippable(j) and self._verb_ahead(j)
        ):
            word = self.word(j)
            negated |= word in v.NEGATIONS
            passive = word in v.BE if word in v.AUXILIARIES else passive
            finite |= word in v.AUXILIARIES
            j += 1
        word = self.word(j)
        base = verb_base(word)
        if j == i and (base is None or self._noun_here(i) or not self._verb_position(i, before)):
            return None
        if base is None:
            return self._auxiliary_alone(i, j, passive, negated)
        infinitive = self.word(i - 1) == "to"
        passive = passive and is_participle(word)
        form = "ing" if word.endswith("ing") else "pp" if is_participle(word) else "s"
        finite = finite or (form != "ing" and not infinitive)
        return Chunk("verb", i, j + 1, word, None, base, form, passive, finite, negated)

    def _skippable(self, j: int) -> bool:
        word = self.word(j)
        return word in v.FILLERS or word in v.MANNERS or word.endswith("ly")

    def _verb_ahead(self, j: int) -> bool:
        while self._skippable(j):
            j += 1
        return verb_base(self.word(j)) is not None

    def _auxiliary_alone(self, i: int, j: int, passive: bool, negated: bool) -> Chunk | None:
        if j == i:
            return None
        unknown = looks_like_verb(self.word(j)) and self.word(j) not in v.POSTURES
        if passive and not unknown and self.word(i) not in ("get", "gets", "got", "getting"):
            return Chunk("verb", i, j, "be", None, "be", "s", False, True, negated)
        if self.word(i) in ("get", "gets", "got", "getting") and not unknown:
            return Chunk("verb", i, j, self.word(i), None, "receive", "s", False, True, negated)
        if all(self.word(k) in v.NEGATIONS for k in range(i, j)):
            return Chunk("adv", i, j, "not")
        word = self.word(j) if unknown else " ".join(self.word(k) for k in range(i, j))
        return Chunk("verb", i, j + unknown, word, None, "?", "s", passive, True, negated)

    def _verb_position(self, i: int, before: list[Chunk]) -> bool:
        """A bare verb form is a verb unless a sentence opens with it before a noun."""
        word = self.word(i)
        if before and before[-1].kind != "stop":
            return True
        return not (word.endswith(("ing", "ed")) and self._nominal(i + 1) and not before)

    # --- nouns ---------------------------------------------------------------------------------

    def _noun_phrase(self, i: int) -> tuple[NounPhrase, int] | None:
        if i not in self._memo:
            self._memo[i] = self._parse_noun_phrase(i)
        return self._memo[i]

    def _parse_noun_phrase(self, i: int) -> tuple[NounPhrase, int] | None:
        j, only, determiner = i, False, ""
        while self.word(j) in ("only", "just"):
            only, j = True, j + 1
        while self.word(j) in v.DETERMINERS and self.word(j) not in ("no",):
            determiner, j = determiner or self.word(j), j + 1
        words, nouns, groups, j = self._nominal_words(j, bool(determiner))
        if not words:
            if determiner in ("all", "both", "each", "some") and self.word(j) == "of":
                words = [determiner]
            else:
                return None
        words, j = self._said_after(words, nouns, j)
        of = None
        if self.word(j) == "of" and (inner := self._noun_phrase(j + 1)) is not None:
            of, j = inner
        adjectives = tuple(w for w in words if w not in nouns) if nouns else tuple(words)
        head = singular(nouns[-1]) if nouns else words[-1]
        number = next((v.NUMBERS[w] for w in words if w in v.NUMBERS), None)
        phrase = NounPhrase(
            head, tuple(nouns), adjectives, tuple(groups), determiner, only,
            number if number is not None else _figure(words), False,
            bool(nouns) and singular(nouns[-1]) != nouns[-1], of, i, j,
        )  # fmt: skip
        return phrase, j

    def _said_after(self, words: list[str], nouns: list[str], j: int) -> tuple[list[str], int]:
        """ "The pin in the middle", "the ball on the left": a position said behind the noun."""
        if nouns and self.word(j) in v.COUNTED_FROM:
            return [self.word(j), *words], j + 1
        if not nouns or self.word(j) not in ("in", "on", "at") or self.word(j + 1) != "the":
            return words, j
        where, after = self.word(j + 2), j + 3
        if where not in v.POSITIONS or self._nominal(after) or self.word(after) == "of":
            return words, j
        return [where, *words], after

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
        return joins and _is_adjective(self.word(j + 1)) and self._reaches_noun(j + 1)

    def _reaches_noun(self, j: int) -> bool:
        while _is_adjective(self.word(j)) or self.word(j) in ("and", ","):
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
        if _is_adjective(word) or word in v.PARTS:
            return self._adjective_role(j, word, started, has_noun)
        if word in v.PRONOUNS or word in v.SUBORDINATORS or word in v.COUNTS:
            return "noun" if word == "others" and not has_noun else "end"
        if verb_base(word) is not None:
            if self.word(j - 1) in ("both", "all", "each") and word not in v.FORCE_NOUNS:
                return "end"
            return self._verbal_role(j, word, started, has_noun)
        if word in v.FILLERS or word in v.MANNERS or word in v.DIRECTIONS:
            if not has_noun and started and self._nominal(j + 1):
                return "skip" if word in v.FILLERS else "adjective"
            return "end"
        if word.endswith("ly") and len(word) > 4:
            return "skip" if started and not has_noun else "end"
        if word in v.POSTURES and not self._nominal(j + 1):
            return "end"
        return "noun"

    def _adjective_role(self, j: int, word: str, started: bool, has_noun: bool) -> str:
        if not has_noun:
            if word in v.FORCE_NOUNS or (word in v.PARTS and not self._qualifies(j + 1)):
                return "noun" if started else "end"
            bare = started or self._qualifies(j + 1) or word in v.NUMBERS or word in v.OTHERS
            bare = bare or word.isdecimal()
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
            describes = self._nominal(j + 1) or (started and self._plain_noun(j + 1))
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


def _is_adjective(word: str) -> bool:
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
        or word.isdecimal()
    )


def _figure(words: Sequence[str]) -> int | None:
    return next((int(word) for word in words if word.isdecimal() and len(word) < 4), None)
