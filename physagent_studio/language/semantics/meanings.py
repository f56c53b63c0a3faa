"""What a verb means in its clause: its sense with particle and object, its cause, its denial."""

from dataclasses import dataclass

from physagent_studio.language.semantics.roles import Roles
from physagent_studio.language.syntax.clauses import RawClause
from physagent_studio.language.syntax.phrases import NounPhrase
from physagent_studio.language.tokens import vocabulary as v
from physagent_studio.language.tokens.tokens import Token


@dataclass
class Meanings(Roles):
    """left_so: the clause before said how something is left. acting: what goes on acting."""

    left_so: bool = False
    acting: str = ""
    tokens: tuple[Token, ...] = ()

    def _cause(self, clause: RawClause) -> str:
        """What brings it about that is no object; it goes on doing so ("… and tips the cup")."""
        goes_on = not clause.subjects and clause.joint == "and" and bool(clause.objects)
        self.acting = self._named_cause(clause) or (self.acting if goes_on else "")
        return self.acting

    def _named_cause(self, clause: RawClause) -> str:
        for phrase in clause.subjects:
            heads = (phrase.head, phrase.of.head if phrase.of else "")
            if any(h in v.CAUSES for h in heads) and not self.is_object(phrase):
                return next(v.CAUSES[h] for h in reversed(heads) if h in v.CAUSES)
            if phrase.head in v.FORCE_NOUNS and not self.is_object(phrase):
                return "person"
        return ""

    def _sense(self, clause: RawClause) -> tuple[str, v.Kind, tuple[NounPhrase, ...]]:
        """The sense of the verb with its particle or object, and the objects that are left."""
        verb = clause.verb
        assert verb is not None
        if self._in_the_end(clause):
            return "end", "state", clause.objects
        if verb.verb == "be":
            return "be", "state", clause.objects
        if self.left_so and v.VERBS[verb.verb].kind == "state":
            return "stay", "state", clause.objects
        if verb.verb in ("leave", "keep") and clause.objects and _left_so(clause):
            return "stay", "move", clause.objects
        entry = v.VERBS[verb.verb]
        sense, kind = entry.sense, entry.kind
        if kind == "light":
            sense, kind = "rest", "state"
        if reverses_to(clause):
            return "move", "move", clause.objects
        if sense in ("topple", "lean") and "rhythmically" in clause.adverbs:
            # "Tips back and forth": it rocks, and does not fall over.
            return "sway", "move", clause.objects
        into = any(p in ("into", "against") and self.is_object(np) for p, np in clause.places)
        if verb.verb in ("smash", "burst", "plunge") and into and not clause.objects:
            # "Smashes into the pot" is no breaking of its own.
            return "hit", "act", clause.objects
        if verb.verb == "take" and clause.objects and any(p == "with" for p, _ in clause.places):
            # "Takes the plate with it"; what falls over and does so brings it down.
            fell = bool(self.frames) and self.frames[-1].sense in ("topple", "collapse")
            return "knock_over" if fell else "push", "act", clause.objects
        for phrase in (np for prep, np in clause.places if prep == "to"):
            if phrase.head in _STANDSTILL and kind == "move":
                # "Skids to a halt".
                return "stop", "move", clause.objects
        for phrase in (*clause.objects, *(np for prep, np in clause.places if prep == "to")):
            key = (verb.verb, phrase.head)
            if key in v.WITH_OBJECT and not (phrase.nouns and self.is_object(phrase)):
                rest = tuple(p for p in clause.objects if p is not phrase)
                return v.WITH_OBJECT[key], "move", rest
        for particle in clause.adverbs:
            if (verb.verb, particle) in v.COMBINED:
                sense = v.COMBINED[(verb.verb, particle)]
                # "Comes crashing down on the vase": what comes down is not the vase.
                own = kind in ("act", "cause") and sense in _OWN and not verb.passive
                along = {*clause.adverbs, *(p for p, _ in clause.places)} & _ALONG
                if verb.verb == "take" and own and along:
                    # "The car takes off down the road".
                    sense = "move"
                if own and not clause.objects:
                    return sense, "move", clause.objects
                return sense, "act" if kind == "cause" else kind, clause.objects
        for preposition, _ in clause.places:
            if preposition == "off" and kind != "cause" and (verb.verb, "off") in v.COMBINED:
                # "Is knocked off the table", "pops off the jar".
                return v.COMBINED[(verb.verb, "off")], kind, clause.objects
        stranded = self._stranded(clause)
        for particle, _ in stranded[:1]:
            if (verb.verb, particle) in v.COMBINED:
                phrases = tuple(phrase for _, phrase in stranded)
                return v.COMBINED[(verb.verb, particle)], kind, phrases
        return sense, kind, clause.objects

    def _in_the_end(self, clause: RawClause) -> bool:
        """ "Are standing at the end", "in the end the cup lies on the floor"."""
        verb = clause.verb
        assert verb is not None
        state = verb.verb == "be" or v.VERBS[verb.verb].kind == "state"
        told = any(
            prep in ("at", "in", "by") and np.head == "end" and np.of is None and not np.adjectives
            for prep, np in (*clause.lead, *clause.places)
        )
        return state and told

    def _stranded(self, clause: RawClause) -> tuple[tuple[str, NounPhrase], ...]:
        """ "Knocks over the pin": a preposition that is the verb's particle, with its object."""
        verb = clause.verb
        assert verb is not None
        if v.VERBS[verb.verb].kind != "act" or clause.objects or verb.passive:
            return ()
        found = tuple((prep, np) for prep, np in clause.places if self.is_object(np))
        # "Knocks over the left and the right pin".
        return tuple(row for row in found if row[0] == found[0][0])

    def _forestalled(self, clause: RawClause) -> bool:
        """ "Drives off before the other can hit it": it does not."""
        verb = clause.verb
        assert verb is not None
        said = {self.tokens[i].text for i in range(verb.start, verb.end)}
        return clause.joint == "before" and not verb.negated and bool(said & {"can", "could"})

    def _manner_within(self, clause: RawClause) -> frozenset[str]:
        """ "Is slowly pushed": how, between the parts of the verb."""
        verb = clause.verb
        assert verb is not None
        said = (self.tokens[i].text for i in range(verb.start, verb.end - 1))
        return frozenset(v.MANNERS[word] for word in said if word in v.MANNERS)

    def _negated(self, clause: RawClause) -> bool:
        assert clause.verb is not None
        none = any(p.determiner == "no" for p in clause.subjects)
        nearly = any(word in v.NEARLY for word in clause.adverbs)
        return (
            nearly
            or self._forestalled(clause)
            or clause.verb.negated
            or clause.joint == "without"
            or "not" in clause.adverbs
            or none
        )


_OWN = ("fall", "rise", "descend", "topple", "leave", "move")
"""Senses of what something does by itself, whatever the verb without its particle."""
_ALONG = {"to", "down", "along", "across", "toward", "towards", "leftwards", "rightwards"}
_INTO = ("into", "against", "toward", "towards", "off", "onto")
_STANDSTILL = ("halt", "stop", "standstill", "rest")


def reverses_to(clause: RawClause) -> bool:
    """ "Backs up into the crate": it goes there with its back first."""
    verb = clause.verb
    return verb is not None and verb.verb == "reverse" and any(p in _INTO for p, _ in clause.places)


def _left_so(clause: RawClause) -> bool:
    """ "Leaving the others untouched": how they are left."""
    return any(a in v.POSTURES or a in ("motionless", "alone") for a in clause.adverbs)
