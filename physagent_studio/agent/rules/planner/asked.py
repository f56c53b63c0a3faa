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
    way_knobs,
)
from physagent_studio.agent.rules.planner.whose import (
    actions_meant,
    driving,
    is_brake,
    named_actions,
    named_things,
    senses,
    things_meant,
)
from physagent_studio.language.tokens.tokens import tokenise
from physagent_studio.language.wishes import Wish, wishes
from physagent_studio.program import PhysicalProgram
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
OF_ACTIONS = ("magnitude", "timing", "duration", "elevation", "direction")
OFFERED = ("magnitude", "timing", "density", "friction", *OF_ACTIONS[2:])
"""Factors that are offered where words name an action, and where they name a thing."""
OPPOSITE = {
    "left": "right", "right": "left", "away": "toward_camera", "toward_camera": "away",
}  # fmt: skip
WAYS = {
    "left": "to the left", "right": "to the right", "away": "away from the camera",
    "toward_camera": "towards the camera",
}  # fmt: skip
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
    0 where it is not said. way: where an action is to point instead."""

    knob: Knob
    owner: str
    sign: int
    way: str = ""


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
        max_offered = 6  # count, 2..12: more numbers would hide what they offer
        both = [each for one in self.open[:max_offered] for each in _both_ways(one)]
        return tuple({in_words(one): one for one in both}.values())


def in_words(one: Change) -> str:
    """ "later: the start of push red ball"."""
    what, more, less = SAID[one.knob.factor]
    whose = f" of {one.owner.replace('_', ' ')}" if one.owner else " of the clip"
    return f"{WAYS[one.way] if one.way else more if one.sign >= 0 else less}: the {what}{whose}"


def as_said(one: Change) -> str:
    """A sentence that is understood as this change and nothing else."""
    _, more, less = SAID[one.knob.factor]
    degree = WAYS[one.way] if one.way else more if one.sign >= 0 else less
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
    offers = [one for one in offers if one.way] if changes else offers
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
    things = named_things(program, told)
    named = named_actions(program, told)
    own = named or [action.id for action in driving(program) if action.name in things]
    moving = own or ([] if things else [action.id for action in driving(program)])
    found = [
        one
        for factor in (OF_ACTIONS if named else OFFERED)
        for one in (
            *_of_actions(program, moving, factor, 0),
            *_of_things(program, things, factor, 0),
        )
    ]
    if not own and not things:
        found.insert(len(moving), _pace(program, 0))
    return Understood(open=tuple(found), photo=bool(things))


def _once(found: Iterable[Change]) -> tuple[Change, ...]:
    return tuple({(one.knob.path, one.sign, one.way): one for one in found}.values())


def _grounded(
    program: PhysicalProgram, wish: Wish, text: Sequence[str]
) -> tuple[bool, list[Change]]:
    """Whether it is certain what is meant, and the changes that it could be."""
    if wish.kind == "pace" or (wish.whole and wish.quantity in ("speed", "strength")):
        return bool(wish.sign), [_pace(program, wish.sign)]
    if wish.kind in ("side", "way"):
        found = _pointed(program, wish, actions_meant(program, wish, text))
        return bool(wish.sign) and len(found) == 1, found
    if wish.kind != "degree":
        return False, []
    if wish.quantity == "reach":
        return False, _reaching(program, wish, text)
    factor = FACTORS[wish.quantity]
    if wish.quantity in OF_THINGS and not wish.air:
        found = _of_things(program, things_meant(program, wish, text), factor, wish.sign)
    else:
        factor = "magnitude" if wish.air and factor == "density" else factor
        found = _of_actions(program, actions_meant(program, wish, text), factor, wish.sign)
    # Who speaks of a brake where there is none does not speak of the push.
    braked = {"stop", "slow"} & senses(wish.clause) and wish.quantity not in OF_THINGS
    lost = braked and not any(is_brake(one) for one in program.event.actions)
    return bool(wish.sign) and len(found) == 1 and not lost, found


def _pointed(program: PhysicalProgram, wish: Wish, ids: Sequence[str]) -> list[Change]:
    """These actions turned: all the way where it is said or their own is the opposite, else by
    degrees, which do not send to the left what goes right."""
    found = [
        Change(knob, action.id, 1, way)
        for way in wish.ways
        for action, now, knob in way_knobs(program, way)
        if action.id in ids and (wish.kind == "way" or now == OPPOSITE[way])
    ]
    if wish.kind == "way":
        return found
    around = {one.owner for one in found} if wish.sign else set()
    by_degrees = _of_actions(program, set(ids) - around, "direction", wish.sign)
    return [*by_degrees, *found]


def _reaching(program: PhysicalProgram, wish: Wish, text: Sequence[str]) -> list[Change]:
    """How far a thing gets has several causes: its push, its arc, what it rolls on, a brake."""
    actions = actions_meant(program, wish, text)
    found = _of_actions(program, actions, "magnitude", wish.sign)
    found += _of_actions(program, actions, "elevation", wish.sign)
    found += _of_things(program, things_meant(program, wish, text), "rolling", -wish.sign)
    brakes = {a.id for a in program.event.actions if is_brake(a)}
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
    named = named_actions(program, wish.clause)
    yield from (f"event.actions.{name}" for name in named)
    if not named:
        things = named_things(program, wish.clause)
        yield from (f"scene.objects.{name}" for name in things)
