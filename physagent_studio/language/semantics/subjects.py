"""Who a clause is about: its subject, a pronoun, what a relative clause hangs on."""

from dataclasses import dataclass, field, replace

from physagent_studio.language.frames import EventFrame
from physagent_studio.language.reference.names import Resolved, of_them, resolve_objects
from physagent_studio.language.reference.selecting import filtered, near_to, nearest_to
from physagent_studio.language.reference.stock import Discourse, Inventory
from physagent_studio.language.syntax.clauses import RawClause
from physagent_studio.language.syntax.phrases import Chunk, NounPhrase
from physagent_studio.language.tokens import vocabulary as v

BESIDE = ("near", "beside", "by")
"""Prepositions that tell a thing by what it is next to."""


@dataclass
class Subjects:
    """What was read so far, and who is meant now; words that name nothing go to `unknown`."""

    chunks: tuple[Chunk, ...]
    stock: Inventory
    talk: Discourse = field(default_factory=Discourse)
    frames: list[EventFrame] = field(default_factory=list)
    unknown: dict[str, None] = field(default_factory=dict)
    last: Resolved | None = None
    relative: Resolved | None = None

    def is_object(self, phrase: NounPhrase) -> bool:
        return resolve_objects(phrase, self.stock, Discourse()) is not None

    def _is_named(self, phrase: NounPhrase) -> bool:
        """Whether the case has a thing of that very word, as a picture on a wall."""
        return any(phrase.head == t.head for t in self.stock.objects)

    def subject_of(self, clause: RawClause) -> Resolved | None:
        """The objects that the subject stands for; None where it names nothing of the case."""
        if clause.complement:
            return self._shared_subject(clause)
        if not clause.subjects:
            if clause.relative:
                return self._antecedent(clause)
            return self.relative if self._goes_on(clause) else self.last
        names: dict[str, None] = {}
        any_one = "subjects" in clause.either
        counted: Resolved | None = None
        for phrase in clause.subjects:
            plain = phrase.head in v.IGNORED_NOUNS | {"motion", "masscenter"}
            if plain and not phrase.pronoun and not self._is_named(phrase):
                found = self._possessed(phrase)
            elif phrase.head == "it" and (struck := self._struck(clause)) is not None:
                found = struck
            else:
                found = resolve_objects(phrase, self.stock, self.talk, subject_of_clause=True)
            if found is None:
                self.unknown |= dict.fromkeys(phrase.nouns or (phrase.head,))
                continue
            found = self._count_by_place(found, phrase, clause)
            found = self._placed_there(phrase, clause) or self._standing_there(found, clause)
            names |= dict.fromkeys(found.names)
            any_one |= found.any_one
            counted = found
            self.talk.mention(found.names)
        if not names:
            return None
        for spared in self.spared(clause):
            names.pop(spared, None)
        resolved = Resolved(tuple(names), any_one)
        if self.spared(clause):
            counted = None
        if len(clause.subjects) == 1 and counted is not None:
            resolved = replace(counted, any_one=any_one)
        elif (limits := of_them(clause.subjects, len(names))) is not None:
            # "Exactly one of the cup and the box": of both together.
            resolved = replace(limits, names=tuple(names))
        self.talk.subject = resolved.names
        return resolved

    def spared(self, clause: RawClause) -> tuple[str, ...]:
        """What an "except …" of the clause takes out of it."""
        found: dict[str, None] = {}
        for preposition, phrase in (*clause.lead, *clause.places):
            if preposition == "except":
                named = resolve_objects(phrase, self.stock, self.talk)
                found |= dict.fromkeys(named.names if named is not None else ())
        return tuple(found)

    def _goes_on(self, clause: RawClause) -> bool:
        """ "…, which topples over and hits the next one": still what the relative is about.

        After a comma the sentence goes back to its own subject.
        """
        before = self.chunks[clause.start - 1] if clause.start else None
        comma = before is not None and before.kind == "stop"
        opens = self.chunks[clause.start]
        # "…, which wobbles but does not fall", "…, which sways without falling".
        joined = opens.kind == "and" and opens.word in ("and", "but")
        joined |= opens.kind == "sub" and opens.word == "without"
        return self.relative is not None and joined and not comma

    def _struck(self, clause: RawClause) -> Resolved | None:
        """ "The ball hits the pin and it tips over": what was hit, where such things fall over."""
        before = self.frames[-1] if self.frames else None
        if before is None or clause.verb is None or not before.patient:
            return None
        if clause.joint == "until" and before.agent and before.sense in ("push", "pull"):
            # "Pushes the ball until it lies by the box": what is pushed.
            return Resolved(before.patient)
        aim = before.place("at", "toward", "against")
        entry = v.VERBS.get(clause.verb.verb)
        thrown = before.sense in ("throw", "kick", "push") and not before.agent
        if thrown and aim is not None and aim.kind == "object" and entry is not None:
            # "Someone throws the ball at the vase and it breaks": not what was thrown.
            over = entry.sense in ("break", "topple", "collapse") or "over" in clause.adverbs
            gives = over and clause.joint in ("and", "so")
            whole = Resolved(aim.members or (aim.name,), as_one=bool(aim.members))
            return whole if gives else None
        if not before.agent:
            return None
        if clause.verb.verb not in v.VERBS or clause.joint not in ("and", "but", "so", ""):
            return None
        gives_way = (
            "topple", "fall", "collapse", "break", "flip", "lean", "sway", "spin", "turn", "rise",
        )  # fmt: skip
        entry = v.VERBS[clause.verb.verb]
        # "The racket hits the ball and it flies off", where "it rolls on" or "back" goes with what
        # struck.
        sent = entry.sense in ("roll", "slide", "fly", "move", "drift")
        sent &= not set(clause.adverbs) & {"on", "onward", "along", "back", "backward", "backwards"}
        return Resolved(before.patient) if sent or entry.sense in gives_way else None

    def _antecedent(self, clause: RawClause) -> Resolved | None:
        """What a relative clause is about: the noun phrase right before it."""
        within = range(clause.start, clause.end)
        index = next((i for i in within if self.chunks[i].kind == "rel"), clause.start) - 1
        while index >= 0 and self.chunks[index].np is None:
            index -= 1
        phrase = self.chunks[index].np if index >= 0 else None
        about = self.talk.mentions[-1] if self.talk.mentions else ()
        if phrase is None:
            return self.last
        if not phrase.nouns and about:
            # "… the yellow one, which …": what was spoken of last.
            return Resolved(about)
        found = resolve_objects(replace(phrase, adjectives=()), self.stock, self.talk)
        if found is not None and set(about) <= set(found.names) and about:
            return Resolved(about)
        return found or self.last

    def _possessed(self, phrase: NounPhrase) -> Resolved | None:
        """ "Its motion", "the motion of the car", "the center of mass": whose it is."""
        if phrase.of is not None:
            return resolve_objects(phrase.of, self.stock, self.talk, subject_of_clause=True)
        return self.last

    def _shared_subject(self, clause: RawClause) -> Resolved | None:
        """The subject of a verb that follows another without a joint ("makes it stop")."""
        previous = self._previous_objects(clause)
        if not previous:
            return self.last
        found = [resolve_objects(p, self.stock, self.talk) for p in previous[-1:]]
        for one in found:
            if one is not None:
                self.talk.mention(one.names)
                return one
        return self.last

    def _previous_objects(self, clause: RawClause) -> tuple[NounPhrase, ...]:
        start = clause.start - 1
        while start >= 0 and self.chunks[start].kind not in ("verb", "stop", "and"):
            start -= 1
        return tuple(c.np for c in self.chunks[start + 1 : clause.start] if c.kind == "np" and c.np)

    def _placed_there(self, phrase: NounPhrase, clause: RawClause) -> Resolved | None:
        """ "The right orange on the belt": of those that are on it, where that is known."""
        if not any(a in v.POSITIONS or a in v.ORDINALS for a in phrase.adjectives):
            return None
        for preposition, place in clause.lead:
            supports = [t.name for t in self.stock.supports if place.head in t.words]
            if preposition not in ("on", "in", "upon") or len(supports) != 1:
                continue
            there = {name for name, below in self.stock.on if below == supports[0]}
            known = tuple(t for t in self.stock.objects if t.name in there)
            if 0 < len(known) < len(self.stock.objects):
                among = replace(self.stock, objects=known)
                return resolve_objects(phrase, among, self.talk, subject_of_clause=True)
        return None

    def _standing_there(self, found: Resolved, clause: RawClause) -> Resolved:
        """ "The oranges on the belt": of several, those that are on it in the picture."""
        for preposition, place in clause.lead:
            if preposition in BESIDE and found.any_one and len(found.names) > 1:
                # "The cup next to the box".
                there = resolve_objects(place, self.stock, Discourse())
                if there is not None and len(there.names) == 1:
                    return replace(
                        found, names=self.nearest(found.names, there.names), any_one=False
                    )
            if preposition not in ("on", "in", "upon") or len(found.names) < 2:
                continue
            alike = tuple(t for t in self.stock.supports if place.head in t.words)
            there = filtered(alike, (*place.adjectives, *place.nouns[:-1]), None, self.talk)
            named = [n for n in found.names if place.head in n.split("_")]
            if named:
                return replace(found, names=tuple(named))
            for support in there[:1]:
                known = tuple(n for n, below in self.stock.on if below == support.name)
                there = tuple(name for name in found.names if name in known)
                kept = there or near_to(found.names, support, self.stock)
                # "All but one of the things on the shelf": of those that are there.
                fewer = len(found.names) - len(kept)
                least = max(found.least - fewer, 0) if found.most is not None else found.least
                most = max(found.most - fewer, 0) if found.most is not None else None
                most = found.most if found.most == found.least == 1 else most
                least = found.least if found.most == found.least == 1 else least
                return replace(found, names=kept, least=least, most=most) if kept else found
        return found

    def nearest(self, names: tuple[str, ...], to: tuple[str, ...]) -> tuple[str, ...]:
        """The one of several things that is nearest in the picture to another; all of them where
        that is not known."""
        known = {t.name: t for t in self.stock.objects}
        place = known.get(to[0])
        others = tuple(name for name in names if name not in to)
        if place is None or not place.spots or any(not known[name].spots for name in others):
            return names
        return nearest_to(others, place, self.stock)[:1] or names

    def _count_by_place(self, found: Resolved, phrase: NounPhrase, clause: RawClause) -> Resolved:
        """ "Two oranges slide off the belt": of three, the two that are nearest to the belt."""
        wanted = phrase.number
        plain = bool(phrase.nouns) and all(a in v.NUMBERS for a in phrase.adjectives)
        if wanted is None or not plain:
            return found
        everything = resolve_objects(
            replace(phrase, number=None, plural=True, adjectives=()), self.stock, Discourse()
        )
        if everything is None or len(everything.names) <= wanted or wanted != len(found.names):
            return found
        for _, place in clause.places:
            for support in self.stock.supports:
                if place.head in support.words or (place.of and place.of.head in support.words):
                    return Resolved(nearest_to(everything.names, support, self.stock)[:wanted])
        return found
