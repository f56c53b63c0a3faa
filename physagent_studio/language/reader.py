"""Reads an English event prompt into event frames over the case's names."""

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from itertools import takewhile, zip_longest

from physagent_studio.language.frames import EventFrame, ReadClause, Reading
from physagent_studio.language.reference.names import Resolved, resolve_objects
from physagent_studio.language.reference.stock import Inventory
from physagent_studio.language.semantics.details import Details, in_company, knocked_over
from physagent_studio.language.semantics.implied import with_blows
from physagent_studio.language.semantics.in_context import AT_REST, in_their_light
from physagent_studio.language.semantics.meanings import Meanings, reverses_to
from physagent_studio.language.semantics.modifiers import details_of
from physagent_studio.language.semantics.places import extent_of
from physagent_studio.language.syntax.chunker import Chunker
from physagent_studio.language.syntax.clauses import RawClause, split
from physagent_studio.language.syntax.phrases import NounPhrase
from physagent_studio.language.syntax.rewriting import UNREAD, rewritten
from physagent_studio.language.tokens import vocabulary as v
from physagent_studio.language.tokens.expressions import join_fixed
from physagent_studio.language.tokens.spelling import corrected, is_known, mostly_strange, once_each
from physagent_studio.language.tokens.tokens import tokenise

MAX_WORDS = 400
"""Longer prompts are cut here; what was cut is reported as not understood."""
NOT_ENGLISH = "the sentence, which must be English"
"""What is not understood of a prompt in another language, before its words."""


def read(prompt: str, stock: Inventory) -> Reading:
    """The event frames of `prompt`; never raises, whatever the words are."""
    if strange := mostly_strange(prompt, stock.nouns):
        # Of another language: words of it that look like English ones mean something else.
        return Reading((ReadClause("c1", prompt.strip()),), (), (NOT_ENGLISH, *strange))
    corrected_ones = corrected(tokenise(prompt), stock.nouns)
    things = (*stock.objects, *stock.supports, *stock.landmarks)
    nouns = {word for thing in things for word in thing.words}
    plain = rewritten(corrected_ones, stock.nouns)
    tokens = join_fixed(plain, stock.phrases(), nouns)
    cut, tokens = tokens[MAX_WORDS:], tokens[:MAX_WORDS]
    chunks = Chunker(tokens, stock.nouns).chunks()
    reader = _Reader(chunks, stock, prompt=prompt, tokens=tokens)
    said = " ".join(token.text for token in plain)
    reader.unknown |= {found.group(): None for found in UNREAD.finditer(said)}
    clauses = split(chunks)
    for clause, following in zip_longest(clauses, clauses[1:]):
        if following is not None:
            reader.anticipate(clause, following)
        reader.take(clause)
    return reader.finish(tuple(token.text for token in cut[:20]))


@dataclass
class _Reader(Meanings):
    """Walks through the clauses once; what was said before resolves what comes."""

    prompt: str = ""
    clauses: list[ReadClause] = field(default_factory=list)
    pending_cause: str = ""
    pending_manner: frozenset[str] = frozenset()
    pending_way: str | None = None
    pending_text: int | None = None
    pending_rest: bool = False
    pending_denial: bool = False
    pending_nobody: bool = False
    unmarked: dict[str, None] = field(default_factory=dict)

    def take(self, clause: RawClause) -> None:
        """Adds the frames of one clause."""
        start = clause.start if self.pending_text is None else self.pending_text
        text = self._text(start, clause.end)
        if clause.verb is None:
            self._add_clause(text)
            self._report_words(clause)
            return
        if self._is_prelude(clause):
            self.pending_text = start
            self.pending_rest = _of_the_rest(clause)
            self.pending_denial = self._negated(clause)
            return
        self.pending_text = None
        if self._says_nothing(clause):
            return
        clause_id = self._add_clause(text)
        if clause.verb.verb == "?":
            self.unknown[clause.verb.word] = None
            self.subject_of(clause)
            self._report_words(clause)
            return
        if self._lacks_a_verb(clause):
            self._report_words(clause)
        frame = self._frame(clause, clause_id)
        if frame is not None:
            self.frames.append(frame)
            if spared := self.spared(clause):
                # "All but the left one fall": that one does not.
                other = replace(frame, patient=spared, negated=not frame.negated)
                self.frames.append(replace(other, any_one=False, least=0, most=None))
        self.pending_cause, self.pending_manner, self.left_so = "", frozenset(), False
        self.pending_way, self.pending_rest, self.pending_denial = None, False, False
        self.pending_nobody = False

    def anticipate(self, clause: RawClause, following: RawClause) -> None:
        """ "Rolling forward, the ball …": the subject is only named in the next clause."""
        verb = clause.verb
        opens = self.last is None and not clause.subjects and not clause.complement
        if verb is not None and verb.form == "ing" and opens and following.subjects:
            self.last = self.subject_of(following)

    def finish(self, cut: Sequence[str]) -> Reading:
        """The reading of everything taken."""
        for word in cut:
            self.unknown[word] = None
        in_their_light(self.frames)
        clauses = tuple(c for c in self.clauses if c.text)
        if not self.frames and not self.unknown:
            # Known words, and yet nothing that happens.
            self.unknown |= {clause.text: None for clause in clauses}
        unknown = {self._as_written(word): None for word in self.unknown}
        frames = tuple(with_blows(self.frames))
        return Reading(clauses, frames, once_each(unknown), tuple(self.unmarked))

    def _as_written(self, word: str) -> str:
        """A word that was not understood in the person's own, where it was put plainly for them."""
        spans = (self.prompt[t.start : t.end] for t in self.tokens if t.text == word)
        return word if word in self.prompt.lower() else next(spans, word).strip()

    # --- clauses that only introduce the next one ------------------------------------------------

    def _is_prelude(self, clause: RawClause) -> bool:
        """ "starts to …", "makes it …", "leaves the others …": the next verb has the meaning."""
        assert clause.verb is not None
        entry = v.VERBS.get(clause.verb.verb)
        following = self._complement_follows(clause)
        if entry is None or not following:
            return False
        if clause.verb.verb in ("leave", "keep") and clause.objects:
            self.subject_of(clause)
            self.left_so = True
            return True
        if entry.kind == "light" or (entry.sense in ("stay", "move") and not clause.objects):
            subject = self.subject_of(clause)
            # "Both glasses keep standing", of which none is marked: nothing else does.
            self.pending_nobody = subject is None and bool(clause.subjects)
            self.last = subject or self.last
            self.left_so = entry.sense == "stay"
            passing = ("keep", "continue", "go", "come", "remain", "stay")
            return entry.kind == "light" or clause.verb.verb in passing
        if entry.sense in ("make", "receive"):
            self._note_cause(clause)
            return True
        return False

    def _says_nothing(self, clause: RawClause) -> bool:
        """ "… stays where it is"."""
        assert clause.verb is not None
        bare = not clause.places and not clause.objects
        return clause.joint == "where" and clause.verb.verb == "be" and bare

    def _complement_follows(self, clause: RawClause) -> bool:
        rest = list(self.chunks[clause.end :])
        if (
            not rest
            or rest[0].kind != "verb"
            or self.chunks[clause.end - 1].kind in ("and", "stop")
        ):
            return False
        return not rest[0].finite or bool(clause.objects) or rest[0].form == "pp"

    def _note_cause(self, clause: RawClause) -> None:
        for phrase in clause.subjects:
            if phrase.head in v.CAUSES or phrase.head in v.FORCE_NOUNS:
                self.pending_cause = v.CAUSES.get(phrase.head, "person")
                said = {v.MANNERS[a] for a in phrase.adjectives if a in v.MANNERS}
                self.pending_manner = frozenset(said)
                ways = [w for w in (*clause.adverbs, *phrase.adjectives) if w in v.DIRECTIONS]
                self.pending_way = v.DIRECTIONS[ways[0]] if ways else None
                return
        self.last = self.subject_of(clause) or self.last

    # --- one clause ------------------------------------------------------------------------------

    def _frame(self, clause: RawClause, clause_id: str) -> EventFrame | None:
        assert clause.verb is not None
        before = self.last
        self.talk.acting = ()
        cause = self._cause(clause)
        nobody = bool(cause) or (self.pending_nobody and not clause.subjects)
        subject = None if nobody else self.subject_of(clause)
        self.talk.acting = subject.names if subject is not None else ()
        sense, kind, objects = self._sense(clause)
        objects = tuple(self._said_before(phrase) for phrase in objects)
        details = details_of(clause, objects, self.stock, self.talk, self.unknown, sense)
        details.manner |= self._manner_within(clause)
        self.unmarked |= details.unmarked
        named = (phrase for _, phrase in clause.places)
        frame = EventFrame(
            knocked_over(sense, details, "over" in clause.adverbs),
            clause_id,
            **{name: getattr(details, name) for name in _AS_SAID},
            cause=cause or details.cause or self.pending_cause,
            only=any(p.only for p in (*clause.subjects, *clause.objects, *named))
            or (bool(objects) and "only" in clause.adverbs)
            or details.only,
            direction=details.direction or self.pending_way,  # type: ignore[arg-type]
            manner=details.manner | frozenset(_manner(clause, sense)) | self.pending_manner,
            posture=_posture(clause, sense, details),
            sequel=clause.sequel,
            rest=self.pending_rest or _of_the_rest(clause),
            negated=self._negated(clause) != self.pending_denial,
            link=self._link(clause),
            leads=self._leads(clause),
            gait=_gait(clause, sense),
            extent=extent_of(details.share, details.places, self.stock, details.direction),
        )
        if details.count not in (None, 1) and sense not in COUNTABLE:
            self.unknown[_COUNTED.get(details.count, f"{details.count} times")] = None
        if "pliant" in details.manner and sense not in YIELDING:
            self.unknown["pliantly"] = None
        frame = self._laid_flat(self.told_apart(frame, clause), subject)
        frame = self.completed(frame, clause, kind, subject, objects, details)
        frame = None if frame is None else self.met_beside(frame, clause, subject)
        frame = None if frame is None else in_company(frame, details)
        goes_on = subject is not None and subject is self.relative and not clause.subjects
        self.relative = self.relative if goes_on else subject if clause.relative else None
        if clause.relative or goes_on:
            self.last = before
        elif frame is not None:
            self.last = self._next_subject(frame, subject, before)
        if self.last is not None:
            self.talk.subject = self.last.names
        return frame

    def _laid_flat(self, frame: EventFrame, subject: Resolved | None) -> EventFrame:
        """ "The book falls flat on the shelf", on which it stands: it topples there, and lies; so
        does what "is laid on its side"."""
        if frame.sense == "set_down" and frame.posture in ("side", "supine", "prone"):
            return replace(frame, sense="topple", manner=frame.manner | {"gentle"})
        if frame.sense != "fall" or frame.posture != "flat" or subject is None:
            return frame
        below = {carrier for name, carrier in self.stock.on if name in subject.names}
        here = all(r == "on" and p.name in below for r, p in frame.places)
        return replace(frame, sense="topple") if below and here else frame

    def _said_before(self, phrase: NounPhrase) -> NounPhrase:
        """ "Pushes it into the bowl": not the bowl, which is only named behind it."""
        if not phrase.pronoun or phrase.head not in ("it", "him", "her"):
            return phrase
        meant = resolve_objects(phrase, self.stock, self.talk)
        if meant is None or len(meant.names) != 1:
            return phrase
        name = meant.names[0]
        return replace(phrase, head=name.lower(), nouns=(name.lower(),), pronoun=False)

    def _next_subject(
        self, frame: EventFrame, subject: Resolved | None, before: Resolved | None
    ) -> Resolved | None:
        return subject or (Resolved(frame.patient, frame.any_one) if frame.patient else before)

    def _link(self, clause: RawClause) -> str:
        if clause.joint in ("while", "as", "whilst", "whereas", "when"):
            return "as" if clause.joint in ("as", "when") else "while"
        if self._forestalled(clause):
            return "while"
        if clause.joint in ("before", "after", "until", "because", "since"):
            return clause.joint
        if clause.joint in ("assoonas", "once"):
            return "once"
        return "which" if clause.relative else "then"

    def _leads(self, clause: RawClause) -> bool:
        """ "After it hits the cup, …": the clause that it hangs on is still to come."""
        first = clause.start == 0 or self.chunks[clause.start - 1].strong_stop
        return first and self.chunks[clause.start].kind == "sub"

    # --- wording ---------------------------------------------------------------------------------

    def _text(self, start: int, end: int) -> str:
        first, last = self.chunks[start].start, self.chunks[end - 1].end
        said = self.tokens[first:last]
        text = self.prompt[min(t.start for t in said) : max(t.end for t in said)]
        return text.strip(" ,.;:!?\n\t")

    def _add_clause(self, text: str) -> str:
        clause_id = f"c{len(self.clauses) + 1}"
        self.clauses.append(ReadClause(clause_id, text))
        return clause_id

    def _report_words(self, clause: RawClause) -> None:
        """What is in a clause of which no verb is known."""
        for chunk in self.chunks[clause.start : clause.end]:
            phrase = chunk.np
            if chunk.kind == "gap":
                self.unknown[chunk.word] = None
            elif phrase is None or phrase.pronoun:
                continue
            elif strange := self._strange(phrase):
                self.unknown |= dict.fromkeys(strange)
            elif chunk.kind == "np" and resolve_objects(phrase, self.stock, self.talk) is None:
                self.unknown |= dict.fromkeys(phrase.nouns or (phrase.head,))

    def _strange(self, phrase: NounPhrase) -> tuple[str, ...]:
        """ "The ball gribbles": unknown words that were taken for nouns behind a known one."""
        known = [is_known(word, self.stock.nouns) for word in phrase.nouns]
        return tuple(word for at, word in enumerate(phrase.nouns) if any(known[:at]) > known[at])

    def _lacks_a_verb(self, clause: RawClause) -> bool:
        """ "The ball gribbles and falls over": something is told before the "and", but not read."""
        chunks = self.chunks[clause.start : clause.end]
        head = [c.kind for c in takewhile(lambda c: c.kind != "verb", chunks) if c.kind != "adv"]
        return bool(clause.subjects) and head[-1:] == ["and"]


def _of_the_rest(clause: RawClause) -> bool:
    """ "… the other stays": about what was left over."""
    said = [a for p in clause.subjects for a in (p.head, p.determiner, *p.adjectives)]
    return any(word in v.OTHERS or word == "another" for word in said)


_AS_SAID = (
    "origin", "places", "path", "count", "steps", "distance", "speed", "delay", "angle", "begins",
    "share", "timing",
)  # fmt: skip
"""What a frame takes over from the details of its clause as it is."""
_COUNTED = {2: "twice", 3: "thrice"}
YIELDING = ("sway", "bend", "lean", "deform")
"""Senses of what can be seen to be soft by it."""
COUNTABLE = ("flip", "spin", "rotate", "turn", "turn_around", "bounce", "reverse", "sway", "jump")
"""Senses of which it can be measured how often they happen."""


def _posture(clause: RawClause, sense: str, details: Details) -> str:
    """How it ends; what "stays up" is upright."""
    upright = verb_is(clause, "stand") or (sense == "stay" and "up" in clause.adverbs)
    return details.posture or ("upright" if upright else "")


def verb_is(clause: RawClause, base: str) -> bool:
    """Whether the clause's verb is this one."""
    return clause.verb is not None and clause.verb.verb == base


def _gait(clause: RawClause, sense: str) -> v.Gait:
    entry = v.VERBS.get(clause.verb.verb) if clause.verb is not None else None
    return entry.gait if entry is not None and entry.sense == sense else ""


def _manner(clause: RawClause, sense: str) -> tuple[str, ...]:
    assert clause.verb is not None
    entry = v.VERBS.get(clause.verb.verb)
    manner = entry.manner if entry else ()
    if sense in AT_REST and "there" in clause.adverbs:
        manner = (*manner, "there")
    return (*manner, "backwards") if reverses_to(clause) else manner
