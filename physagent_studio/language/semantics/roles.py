"""Who does what to whom: agents and patients of a clause, by the kind of its verb."""

from dataclasses import dataclass, replace

from physagent_studio.language.frames import EventFrame, Place
from physagent_studio.language.reference.names import Resolved, of_its_owner, resolve_objects
from physagent_studio.language.semantics.details import Details, is_measure
from physagent_studio.language.semantics.places import resolve_place
from physagent_studio.language.semantics.subjects import BESIDE, Subjects
from physagent_studio.language.syntax.clauses import RawClause
from physagent_studio.language.syntax.phrases import Chunk, NounPhrase
from physagent_studio.language.tokens import vocabulary as v


@dataclass
class Roles(Subjects):
    """Completes a frame with those who act and those who undergo."""

    def met_beside(
        self, frame: EventFrame, clause: RawClause, subject: Resolved | None
    ) -> EventFrame:
        """ "Bumps into the one next to it": of several the nearest."""
        phrases = [phrase for _, phrase in clause.places]
        beside = any(word in BESIDE for word, phrase in clause.places if phrase.pronoun)
        if not beside or any(phrase.plural for phrase in phrases) or frame.counted:
            return frame
        if not frame.agent or subject is None or len(subject.names) != 1 or len(frame.patient) < 2:
            return frame
        return replace(frame, patient=self.nearest(frame.patient, subject.names), any_one=False)

    def told_apart(self, frame: EventFrame, clause: RawClause) -> EventFrame:
        """ "The cup next to the box falls": which cup, and not where it falls."""
        beside = [
            resolve_place(p, self.stock, self.talk) for word, p in clause.lead if word in BESIDE
        ]
        names = {place.name for place in beside if place is not None and place.kind == "object"}
        kept = tuple(
            (relation, place)
            for relation, place in frame.places
            if place.name not in names or relation not in ("near", "beside", "past")
        )
        return replace(frame, places=kept) if names and clause.subjects else frame

    def completed(
        self,
        frame: EventFrame,
        clause: RawClause,
        kind: v.Kind,
        subject: Resolved | None,
        objects: tuple[NounPhrase, ...],
        details: Details,
    ) -> EventFrame | None:
        verb = clause.verb
        assert verb is not None
        direct = self._direct(objects, subject)
        if direct is not None and (spared := self.spared(clause)):
            kept = tuple(name for name in direct.names if name not in spared)
            direct = replace(direct, names=kept) if kept else direct
        if direct is not None and "objects" in clause.either:
            direct = replace(direct, any_one=True)
        if kind == "cause":
            return self._received(frame, clause, subject, direct)
        carried = verb.passive or (subject is None and direct is not None and frame.sense in _ALONG)
        if frame.cause == "wind" and kind == "move" and carried:
            frame = replace(frame, sense="wind")
        if (gone := self._withdrawn(frame, clause, subject, objects)) is not None:
            return gone
        if not verb.passive and direct is None and self._moves_what_is_fixed(frame, objects):
            return None
        if kind == "act":
            return self._acted(frame, verb, subject, direct, details, objects)
        if kind == "move" and direct is not None and not verb.passive:
            agent = subject.names if subject and frame.sense != "stay" else ()
            frame = replace(frame, agent=agent)
            subject = direct
        elif frame.sense == "bounce" and verb.passive and details.by:
            # "Is deflected by the box": off it.
            off = tuple(("off", Place(name, "object")) for name in details.by)
            frame = replace(frame, places=(*off, *frame.places))
        elif frame.sense == "stop" and verb.passive and details.by:
            # "Is stopped by the box": at it.
            at = tuple(("against", Place(name, "object")) for name in details.by[:1])
            frame = replace(frame, places=(*at, *frame.places))
        elif kind == "move" and verb.passive and details.by:
            # "Is squashed by the ball".
            frame = replace(frame, agent=details.by)
        elif kind in ("move", "goto") and objects:
            place = details.object_places(objects, self.stock, self.talk)
            if frame.sense == "rise" and place:
                # "Climbs the ramp".
                place = tuple(("up", one) for _, one in place)
                frame = replace(frame, sense="move")
            frame = replace(frame, places=(*place, *frame.places))
        return self._done_by(frame, subject)

    def _moves_what_is_fixed(self, frame: EventFrame, objects: tuple[NounPhrase, ...]) -> bool:
        """ "Tips the crate over", where the crate is a support: that cannot be, and is said."""
        if frame.sense not in _DONE_TO_A_THING:
            return False
        for phrase in objects:
            place = resolve_place(phrase, self.stock, self.talk)
            if place is not None and place.kind == "support":
                self.unknown |= dict.fromkeys(phrase.nouns or (phrase.head,))
                return True
        return False

    def _withdrawn(
        self,
        frame: EventFrame,
        clause: RawClause,
        subject: Resolved | None,
        objects: tuple[NounPhrase, ...],
    ) -> EventFrame | None:
        """ "The table is pulled away": a support that is taken from under the things on it.

        "The support plate beneath the ramp" is not in the picture; then what it carries goes.
        """
        assert clause.verb is not None
        if subject is not None or clause.verb.verb not in v.WITHDRAWING or frame.negated:
            return None
        about = clause.subjects if clause.verb.passive else objects
        for phrase in about:
            if phrase.head in v.PROPS:
                below = [np for prep, np in (*clause.lead, *clause.places) if prep in v.UNDER]
                about = (*below, *((phrase.of,) if phrase.of is not None else ()), phrase)
        for phrase in about:
            place = resolve_place(phrase, self.stock, self.talk)
            if place is not None and place.kind == "support":
                for word in (n for p in (*clause.subjects, *objects) for n in (p.head, *p.nouns)):
                    self.unknown.pop(word, None)
                return replace(frame, sense="withdrawn", places=(("object", place),))
        return None

    def _direct(self, objects: tuple[NounPhrase, ...], subject: Resolved | None) -> Resolved | None:
        names: dict[str, None] = {}
        any_one = False
        counted: Resolved | None = None
        for phrase in (of_its_owner(one, self.stock) for one in objects):
            found = resolve_objects(phrase, self.stock, self.talk)
            if found is not None:
                counted = found
                names |= dict.fromkeys(found.names)
                any_one |= found.any_one
                self.talk.mention(found.names)
            elif not is_measure(phrase) and resolve_place(phrase, self.stock, self.talk) is None:
                self.unknown |= dict.fromkeys(phrase.nouns or (phrase.head,))
        if counted is not None and len(objects) == 1:
            return counted
        return Resolved(tuple(names), any_one) if names else None

    def _done_by(self, frame: EventFrame, who: Resolved | None) -> EventFrame | None:
        if who is None and frame.cause == "wind":
            return replace(frame, sense="wind", patient=())
        if who is None:
            return None
        return replace(frame, patient=who.names, **who.counts)

    def _acted(
        self,
        frame: EventFrame,
        verb: Chunk,
        subject: Resolved | None,
        direct: Resolved | None,
        details: Details,
        direct_phrases: tuple[NounPhrase, ...],
    ) -> EventFrame | None:
        if frame.sense == "blow" or frame.cause == "wind":
            who = direct or (subject if not frame.cause or verb.passive else None)
            sense = frame.sense if frame.sense == "knock_over" else "wind"
            patient = who.names if who else ()
            return replace(frame, sense=sense, cause="wind", patient=patient)
        passive = verb.passive or (direct is None and verb.form == "pp" and not details.struck)
        if passive:
            agent = details.by
            if subject is not None and direct is not None and verb.passive:
                # "The right pin is knocked over, then the left one."
                both = tuple(dict.fromkeys((*subject.names, *direct.names)))
                subject = Resolved(both, subject.any_one)
            others = () if subject is None else tuple(n for n in subject.names if n not in agent)
            if subject is not None and others:
                # "The can is hit by the red can": the other one is.
                subject = replace(subject, names=others)
            return self._done_by(replace(frame, agent=agent), subject)
        struck = direct
        if direct is None and details.struck:
            struck = Resolved(details.struck, as_one=details.struck_as_one)
        if struck is None:
            if frame.sense == "hit" and subject is not None and not frame.places:
                frame = replace(
                    frame, places=details.object_places(direct_phrases, self.stock, self.talk)
                )
            if frame.sense == "hit" and frame.places:
                # "Hits the goal", "crashes into the wall": it gets to a place.
                return self._done_by(replace(frame, sense="strike"), subject)
            if frame.sense == "hit" and subject is not None and len(subject.names) == 2:
                # "The stones collide."
                first, second = subject.names
                return replace(frame, agent=(first,), patient=(second,))
            # "collides", "makes contact": with whom is not said.
            return self._done_by(frame, subject) if frame.sense != "hit" else None
        agent = subject.names if subject and not frame.cause else ()
        if frame.sense == "hit" and len(agent) == 1 and agent == struck.names:
            # "Hits itself", "hits it" with nothing else spoken of.
            heads = [phrase.head for phrase in direct_phrases] or [verb.word]
            self.unknown |= dict.fromkeys(heads)
            return None
        if len(struck.names) > len(agent) and set(agent) < set(struck.names):
            # "Hits nothing": nothing but itself.
            struck = replace(struck, names=tuple(n for n in struck.names if n not in agent))
        kept = tuple(
            (relation, place)
            for relation, place in frame.places
            if place.name not in struck.names and not set(place.members) & set(struck.names)
        )
        return replace(frame, agent=agent, patient=struck.names, places=kept, **struck.counts)

    def _received(
        self,
        frame: EventFrame,
        clause: RawClause,
        subject: Resolved | None,
        direct: Resolved | None,
    ) -> EventFrame | None:
        """ "Receives a strong push", "gives it a kick", "changes direction"."""
        nouns = [p.head for p in clause.objects if p.head in v.FORCE_NOUNS]
        if not nouns:
            for phrase in clause.objects:
                self.unknown[phrase.head] = None
            return None
        sense = v.FORCE_SENSE.get(nouns[0], "push")
        gives = frame.sense == "make"
        return self._done_by(replace(frame, sense=sense), direct if gives else subject)


_DONE_TO_A_THING = v.words_of(
    "push knock_over topple flip kick throw dislodge crush break deform lift pull spin turn"
)
"""What one thing does to another that can move."""
_ALONG = ("move", "slide", "drift", "roll", "fly")
"""What "the wind … the leaf" only sets going, whatever the verb."""
