"""Cuts a sentence into chunks: noun phrases, prepositional phrases, verb groups, joints."""

from dataclasses import dataclass, replace

from physagent_studio.language.syntax.measures import UNITS, amount_of
from physagent_studio.language.syntax.noun_phrases import NounPhrases, is_adjective
from physagent_studio.language.syntax.phrases import Chunk, NounPhrase
from physagent_studio.language.tokens import vocabulary as v
from physagent_studio.language.tokens.expressions import ADVERBIAL
from physagent_studio.language.tokens.tokens import (
    is_number,
    is_participle,
    looks_like_verb,
    singular,
    verb_base,
)

ALWAYS = v.words_of("assoonas while when because although though whereas whilst")
"""Subordinators that are nothing else, so that a clause begins even where its verb is unknown."""


@dataclass(frozen=True)
class Chunker(NounPhrases):
    """Cuts tokens into chunks; `nouns` are the words that the case's names are made of."""

    def chunks(self) -> tuple[Chunk, ...]:
        """All chunks in order; every token belongs to exactly one."""
        out: list[Chunk] = []
        index = 0
        while index < len(self.tokens):
            chunk = self._next(index, out)
            out.append(chunk)
            index = chunk.end
        return tuple(out)

    def _next(self, i: int, before: list[Chunk]) -> Chunk:
        word = self.word(i)
        if word in ".,;:!?()":
            return Chunk("stop", i, i + 1, word, strong_stop=word in ".;!?")
        if word in v.RELATIVES and self._relative(i, before):
            return Chunk("rel", i, i + 1, word)
        if word in v.SUBORDINATORS and self._subordinates(i, word):
            return Chunk("sub", i, i + 1, word)
        if word in v.CONJUNCTIONS:
            return Chunk("and", i, i + 1, word)
        if (group := self._verb_group(i, before)) is not None:
            return group
        if word in v.PREPOSITIONS or word in ("because_of", "away_from"):
            return self._preposition(i, word)
        if self._is_adverb(i, word):
            return Chunk("adv", i, i + 1, word)
        if (found := self.noun_phrase(i)) is not None:
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
        # "…, which then falls over".
        nxt = self.word(i + 2 if self.word(i + 1) in v.FILLERS | {"then"} else i + 1)
        return nxt in v.AUXILIARIES or verb_base(nxt) is not None

    def _subordinates(self, i: int, word: str) -> bool:
        """Whether the word begins a clause; "bounces once and rolls" is a count."""
        if word == "once" and self.noun_phrase(i + 1) is None and self.word(i + 1) not in _THEY:
            return False
        if word in ("after", "before", "until") and self._is_quantity(i + 1):
            return False
        return word in ALWAYS or self._clause_follows(i + 1)

    def _is_quantity(self, i: int) -> bool:
        """ "After 1 second …"; "after rolling two metres" is none."""
        if self.word(i).endswith("ing") and verb_base(self.word(i)) is not None:
            return False
        found = self.noun_phrase(i)
        return found is not None and found[0].head in UNITS and amount_of(found[0]) is not None

    def _clause_follows(self, i: int) -> bool:
        """Whether a verb comes before the next stop."""
        for index in range(i, len(self.tokens)):
            word = self.word(index)
            if word in ".,;:!?":
                return False
            following = self.word(index + 1)
            if word in ("and", "but") and verb_base(following) and not self._noun_here(index + 1):
                # "Veers left before the pins and misses them": that is the verb before the pins.
                return False
            if word in v.BE or word in _DOES or (verb_base(word) and not self._noun_here(index)):
                return True
        return False

    def _noun_here(self, i: int) -> bool:
        """Whether a word that could be a verb stands in a noun's place."""
        word, previous, following = self.word(i), self.word(i - 1), self.word(i + 1)
        if word in self.nouns or singular(word) in self.nouns:
            follows_name = previous in self.nouns or singular(previous) in self.nouns
            return not follows_name or "_" in word
        if (verb_base(previous) or "", word) in v.WITH_OBJECT or self._one(i):
            return True
        if previous in ("below", "above", "underneath", "beneath") and is_number(self.word(i - 2)):
            # "The two below stay".
            return False
        if previous == "behind" and (self._after_noun(i - 1) or self.word(i - 2) == "one"):
            # "The one behind falls".
            return False
        behind = self.word(i - 2) == "the" and self.word(i - 3) in ("in", "on", "at")
        # "On the left falls …", and not "on the second swing it …".
        behind &= previous not in v.ORDINALS
        behind |= (self.word(i - 2), previous) in (("on", "top"), ("in", "front"))
        closed = behind or previous in v.OTHERS or previous in v.NUMBERS or previous in v.DIRECTIONS
        adjective = is_adjective(previous) and previous not in self.nouns and not closed
        if previous in ("both", "all", "each") and word not in v.FORCE_NOUNS:
            # "…, both come to rest": the subject is "both".
            return False
        if previous in v.DETERMINERS or (adjective and not self._after_noun(i - 1)):
            return True
        if previous in v.PREPOSITIONS and previous != "to":
            return not word.endswith("ing") or following in self.nouns
        return previous == "to" and verb_base(word) != word

    def _one(self, i: int) -> bool:
        """ "A high arc": of one that does something the verb would have its ending."""
        back = i - 1
        while i - back < 4 and self.word(back).isalpha() and self.word(back) not in ("a", "an"):
            closed = self.word(back) in v.PREPOSITIONS | v.CONJUNCTIONS
            if self._after_noun(back + 1) or closed:
                return False
            back -= 1
        return verb_base(self.word(i)) == self.word(i) and self.word(back) in ("a", "an")

    def _after_noun(self, i: int) -> bool:
        previous = self.word(i - 1)
        return previous in self.nouns or singular(previous) in self.nouns

    def _is_adverb(self, i: int, word: str) -> bool:
        if word in v.BOUNDS:
            return self.noun_phrase(i) is None
        if word in v.FILLERS or word in v.COUNTS or word in ADVERBIAL:
            if word in ("only", "just") and self.noun_phrase(i + 1) is not None:
                return False
            return not (word == "first" and self.nominal(i + 1))
        if word in v.DIRECTIONS or word in v.MANNERS or word in v.POSTURES:
            return not self.nominal(i + 1) or self._after_noun(i)
        return word.endswith("ly") and len(word) > 4 and not self.nominal(i + 1)

    def _preposition(self, i: int, word: str) -> Chunk:
        found = self.noun_phrase(i + 1)
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
        # "The book that lies on top": behind such a "that" there is the verb.
        relates = bool(before) and before[-1].kind == "rel"
        here = not relates and self._noun_here(i)
        if j == i and (base is None or here or not self._verb_position(i, before)):
            return None
        if base is None:
            return self._auxiliary_alone(i, j, passive, negated)
        infinitive = self.word(i - 1) == "to"
        passive = passive and is_participle(word)
        form = (
            "ing" if word.endswith("ing") and base != word else "pp" if is_participle(word) else "s"
        )
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
        return not (word.endswith(("ing", "ed")) and self.nominal(i + 1) and not before)


_DOES = ("does", "do", "did")
_THEY = v.PRONOUNS | v.DETERMINERS
"""Words with which a subject can begin."""
