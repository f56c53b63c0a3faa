"""Whose number a person's words speak of: wishes grounded in the fields of a program.

One number and one way make a change, which the next proposal follows. Where several could be meant,
or the way is not said, all of them are put before the person; nothing is then done by itself.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, replace

from physagent_studio.agent.roles import Situation
from physagent_studio.agent.rules.planner.parameters import (
    Knob,
    action_knobs,
    material_knobs,
    time_knobs,
)
from physagent_studio.knowledge import degrees
from physagent_studio.language.tokens.tokens import singular, tokenise, verb_base
from physagent_studio.language.tokens.verbs import VERBS
from physagent_studio.language.wishes import Wish, wishes
from physagent_studio.program import Action, Directed, PhysicalProgram
from physagent_studio.program.actions import ApplyDisturbance, FixObject
from physagent_studio.program.timing import FASTEST

FACTORS = {
    "strength": "magnitude",
    "speed": "magnitude",
    "reach": "magnitude",
    "time": "timing",
    "length": "duration",
    "height": "elevation",
    "weight": "density",
    "friction": "friction",
    "rolling": "rolling",
    "bounciness": "restitution",
}
"""Which factor of the planner a quantity of the language is."""
OF_THINGS = frozenset({"weight", "friction", "rolling", "bounciness"})
STATED = frozenset(
    [
        "is",
        "was",
        "are",
        "be",
        "too",
        "so",
        "very",
        "as",
        "that",
        "much",
        "more",
        "less",
        "quite",
        "rather",
        "not",
    ]
)
"""After these a word that may be a verb or an adjective ("slow") is an adjective."""
OFFERED, ABOUT = ("magnitude", "timing", "duration"), ("density", "friction")
"""Factors of an action, and of a thing, that are offered where words name just these."""
MOST_OFFERED = 6
"""More buttons than these would hide what they offer."""
SAID: dict[str, tuple[str, str, str]] = {
    "magnitude": ("strength", "stronger", "weaker"),
    "timing": ("start", "later", "earlier"),
    "duration": ("length", "longer", "shorter"),
    "direction": ("direction", "more to the left", "more to the right"),
    "elevation": ("upward angle", "higher", "lower"),
    "density": ("weight", "heavier", "lighter"),
    "friction": ("friction", "rougher", "more slippery"),
    "rolling": ("rolling resistance", "with more resistance", "with less resistance"),
    "restitution": ("bounciness", "bouncier", "less bouncy"),
    "pace": ("pace", "faster", "slower"),
}
"""Of each factor: what a person calls it, and more and less of it. Each is read back as itself."""


@dataclass(frozen=True, slots=True)
class Change:
    """One number to be turned. owner: the id of its action, or the thing; sign: +1 more, −1 less,
    0 where the way is not said."""

    knob: Knob
    owner: str
    sign: int


@dataclass(frozen=True, slots=True)
class Understood:
    """changes: what is certain. open: what could be meant instead. kept: paths to leave alone.
    photo: whether what is asked for lies in the photo. heard: whether anything was recognised."""

    changes: tuple[Change, ...] = ()
    open: tuple[Change, ...] = ()
    kept: tuple[str, ...] = ()
    photo: bool = False
    heard: bool = False

    @property
    def line(self) -> str:
        """What was understood, in a line; "" where nothing was."""
        told = [in_words(one) for one in self.changes]
        told += [f"{path.split('.')[-1].replace('_', ' ')} stays as it is" for path in self.kept]
        told += ["what the photo is read as"] if self.photo else []
        return "; ".join(dict.fromkeys(told))

    @property
    def meant(self) -> tuple[tuple[str, str], ...]:
        """What could be meant: the text of a button, and words that say just that."""
        return tuple((in_words(one), as_said(one)) for one in self.shown)

    @property
    def shown(self) -> tuple[Change, ...]:
        """What could be meant, each way by itself, as many as there are buttons."""
        both = [each for one in self.open for each in _both_ways(one)]
        return tuple({in_words(one): one for one in both}.values())[:MOST_OFFERED]


def in_words(one: Change) -> str:
    """ "later: the start of push red ball"."""
    what, more, less = SAID[one.knob.factor]
    whose = f" of {one.owner.replace('_', ' ')}" if one.owner else " of the clip"
    return f"{more if one.sign >= 0 else less}: the {what}{whose}"


def as_said(one: Change) -> str:
    """A sentence that is understood as this change and nothing else."""
    _, more, less = SAID[one.knob.factor]
    degree = more if one.sign >= 0 else less
    if one.knob.factor == "pace":
        return f"show the whole clip {degree}"
    verb = "aim" if one.knob.factor == "direction" else "make"
    return f"{verb} the {one.owner.replace('_', ' ')} {degree}"


def _both_ways(one: Change) -> list[Change]:
    return [one] if one.sign else [replace(one, sign=1), replace(one, sign=-1)]


def understood(program: PhysicalProgram, words: str) -> Understood:
    """What a person asks for, as far as the program has it."""
    told = wishes(words)
    everything = tuple(token.text for token in tokenise(words))
    changes: list[Change] = []
    offers: list[Change] = []
    for wish in told:
        certain, found = _grounded(program, wish, everything)
        (changes if certain else offers).extend(found)
    # What is said for certain settles what the same words left open.
    offers = [] if changes else offers
    kept = tuple(path for w in told if w.kind == "keep" for path in _kept(program, w, everything))
    photo = any(wish.kind == "photo" for wish in told)
    return Understood(_once(changes), _once(offers), kept, photo, bool(told))


def keeping(situation: Situation, kept: tuple[str, ...]) -> Situation:
    """The situation with paths that this proposal leaves alone, beside what is pinned."""
    if not kept:
        return situation
    pinned = tuple(dict.fromkeys((*situation.memory.pinned, *kept)))
    return replace(situation, memory=situation.memory.model_copy(update={"pinned": pinned}))


def suggested(program: PhysicalProgram, words: str) -> Understood:
    """What is offered where nothing was understood: numbers of the actions and things that the
    words name, else of what sets things in motion; and the photo, where a thing is named.
    """
    told = tuple(token.text for token in tokenise(words))
    things = _best(_scores_of_things(program, told), least=1)
    named = _best(_scores_of_actions(program, told), least=3)
    own = named or [action.id for action in _driving(program) if action.name in things]
    moving = own or ([] if things else [action.id for action in _driving(program)])
    found = [one for factor in OFFERED for one in _of_actions(program, moving, factor, 0)]
    if not named:
        found += [one for factor in ABOUT for one in _of_things(program, things, factor, 0)]
    return Understood(open=tuple(found), photo=bool(things))


def _once(found: Iterable[Change]) -> tuple[Change, ...]:
    return tuple({(one.knob.path, one.sign): one for one in found}.values())


def _grounded(
    program: PhysicalProgram, wish: Wish, text: Sequence[str]
) -> tuple[bool, list[Change]]:
    """Whether it is certain what is meant, and the changes that it could be."""
    if wish.kind == "pace" or (wish.whole and wish.quantity in ("speed", "strength")):
        return bool(wish.sign), [_pace(program, wish.sign)]
    if wish.kind == "side":
        found = _of_actions(program, _actions(program, wish, text), "direction", wish.sign)
        return bool(wish.sign) and len(found) == 1, found
    if wish.kind != "degree":
        return False, []
    if wish.quantity == "reach":
        return False, _reaching(program, wish, text)
    factor = FACTORS[wish.quantity]
    if wish.quantity in OF_THINGS and not wish.air:
        found = _of_things(program, _things(program, wish, text), factor, wish.sign)
    else:
        factor = "magnitude" if wish.air and factor == "density" else factor
        found = _of_actions(program, _actions(program, wish, text), factor, wish.sign)
    return bool(wish.sign) and len(found) == 1, found


def _reaching(program: PhysicalProgram, wish: Wish, text: Sequence[str]) -> list[Change]:
    """How far a thing gets has several causes: its push, its arc, what it rolls on, a brake."""
    actions = _actions(program, wish, text)
    found = _of_actions(program, actions, "magnitude", wish.sign)
    found += _of_actions(program, actions, "elevation", wish.sign)
    found += _of_things(program, _things(program, wish, text), "rolling", -wish.sign)
    brakes = {a.id for a in program.event.actions if _is_brake(a)}
    return found + _of_actions(program, brakes, "magnitude", -wish.sign)


def _pace(program: PhysicalProgram, sign: int) -> Change:
    return Change(replace(time_knobs(program)[0], high=FASTEST), "", sign)


def _of_actions(
    program: PhysicalProgram, ids: Iterable[str], factor: str, sign: int
) -> list[Change]:
    wanted = set(ids)
    return [
        Change(knob, knob.path.split(".")[2], sign)
        for knob in action_knobs(program)
        if knob.factor == factor and knob.path.split(".")[2] in wanted
    ]


def _of_things(
    program: PhysicalProgram, names: Iterable[str], factor: str, sign: int
) -> list[Change]:
    wanted = set(names)
    return [
        Change(knob, knob.target, sign)
        for knob in material_knobs(program)
        if knob.factor == factor and knob.target in wanted
    ]


def _kept(program: PhysicalProgram, wish: Wish, text: Sequence[str]) -> Iterator[str]:
    """Paths of what hands are to be kept off: an action that is named, else a thing."""
    named = _best(_scores_of_actions(program, wish.clause), least=3)
    yield from (f"event.actions.{name}" for name in named)
    if not named:
        things = _best(_scores_of_things(program, wish.clause), least=1)
        yield from (f"scene.objects.{name}" for name in things)


# --- whose ------------------------------------------------------------------------------------


def _actions(program: PhysicalProgram, wish: Wish, text: Sequence[str]) -> list[str]:
    """Ids of the actions that words speak of: in the clause, in the whole, or any driving."""
    for words in (wish.clause, text):
        scores = _scores_of_actions(program, words, air=wish.air)
        found = _best(scores, least=1)
        if wish.quantity in ("speed", "strength", "height", "reach") and len(found) > 1:
            found = [one for one in found if not _is_brake(_action(program, one))] or found
        if found:
            return found
    return [one.id for one in _driving(program)]


def _action(program: PhysicalProgram, name: str) -> Action:
    found = program.action(name)
    assert found is not None
    return found


def _scores_of_actions(
    program: PhysicalProgram, words: Sequence[str], *, air: bool = False
) -> dict[str, int]:
    """How much speaks for each action: its verb 3, its thing 2, any verb of driving 1."""
    before = ("", *words)
    senses = {_sense(w) for w, last in zip(words, before, strict=False) if last not in STATED}
    senses -= {""}
    things = _scores_of_things(program, words)
    blown = air or "blow" in senses
    driven = any(VERBS[base].kind == "act" for word in words if (base := verb_base(word)))
    scores: dict[str, int] = {}
    for action in program.event.actions:
        own = {_sense(word) for word in action.id.split("_")} - {""}
        verb = bool(own & senses) or (_is_brake(action) and bool(senses & {"stop", "slow"}))
        verb = verb or (isinstance(action, ApplyDisturbance) and blown)
        score = 3 * verb + min(things.get(action.name, 0), 2)
        if not verb and driven and action in _driving(program):
            score += 1
        scores[action.id] = score
    return scores


def _things(program: PhysicalProgram, wish: Wish, text: Sequence[str]) -> list[str]:
    """Things that words speak of: in the clause, in all that is said, or those that are driven."""
    for words in (wish.clause, text):
        found = _best(_scores_of_things(program, words), least=1)
        if found:
            return found
    driven = {one.name for one in _driving(program)}
    # A pronoun may stand for any of them.
    if {"it", "they", "them"} & set(wish.clause):
        return [one.name for one in program.scene.objects]
    return [one.name for one in program.scene.objects if one.name in driven]


def _scores_of_things(program: PhysicalProgram, words: Sequence[str]) -> dict[str, int]:
    """2 where the head of a thing's name is said, 1 where only what stands before it is."""
    said = {singular(word) for word in words} | set(words)
    scores: dict[str, int] = {}
    for item in program.scene.objects:
        *rest, head = item.name.split("_")
        if head.isdecimal() and rest:
            *rest, head = rest
        scores[item.name] = 2 * (head in said) + any(word in said for word in rest)
    return scores


def _best(scores: dict[str, int], least: int) -> list[str]:
    most = max(scores.values(), default=0)
    return [name for name, score in scores.items() if score == most and score >= least]


def _sense(word: str) -> str:
    if word in degrees().air:
        return "blow"
    base = verb_base(word)
    return VERBS[base].sense if base is not None else ""


def _driving(program: PhysicalProgram) -> list[Action]:
    return [
        one
        for one in program.event.actions
        if not one.muted and not isinstance(one, FixObject) and not _is_brake(one)
    ]


def _is_brake(action: Action) -> bool:
    """Whether an action takes speed away: against the way it goes, or by its name."""
    value = getattr(action, "force", None)
    against = isinstance(value, Directed) and value.along == "against_velocity"
    return against or any(_sense(word) == "stop" for word in action.id.split("_"))
