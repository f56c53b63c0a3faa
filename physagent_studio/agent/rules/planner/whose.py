"""Whose a wish is: the actions and things of a program that a person's words speak of."""

from __future__ import annotations

from collections.abc import Sequence

from physagent_studio.knowledge import degrees
from physagent_studio.language.tokens.tokens import singular, verb_base
from physagent_studio.language.tokens.verbs import VERBS
from physagent_studio.language.wishes import Wish
from physagent_studio.program import Action, Directed, PhysicalProgram
from physagent_studio.program.actions import ApplyDisturbance, FixObject

STATED = frozenset(
    ["is", "was", "are", "be", "too", "so", "very", "as", "that", "much", "more", "less", "quite",
     "rather", "not"]
)  # fmt: skip
"""After these a word that may be a verb or an adjective ("slow") is an adjective."""


def actions_meant(program: PhysicalProgram, wish: Wish, text: Sequence[str]) -> list[str]:
    """Ids of the actions that words speak of: in the clause, in the whole, or any driving."""
    for words in (wish.clause, text):
        scores = _scores_of_actions(program, words, air=wish.air)
        found = _best(scores, least=1)
        if wish.quantity in ("speed", "strength", "height", "reach") and len(found) > 1:
            found = [one for one in found if not is_brake(_action(program, one))] or found
        if found:
            return found
    return [one.id for one in driving(program)]


def _action(program: PhysicalProgram, name: str) -> Action:
    found = program.action(name)
    assert found is not None
    return found


def _scores_of_actions(
    program: PhysicalProgram, words: Sequence[str], *, air: bool = False
) -> dict[str, int]:
    """How much speaks for each action: its verb 3, its thing 2, any verb of driving 1."""
    done = senses(words)
    named = _scores_of_things(program, words)
    blown = air or "blow" in done
    driven = any(VERBS[base].kind == "act" for word in words if (base := verb_base(word)))
    scores: dict[str, int] = {}
    for action in program.event.actions:
        own = {_sense(word) for word in action.id.split("_")} - {""}
        verb = bool(own & done) or (is_brake(action) and bool(done & {"stop", "slow"}))
        verb = verb or (isinstance(action, ApplyDisturbance) and blown)
        score = 3 * verb + min(named.get(action.name, 0), 2)
        if not verb and driven and action in driving(program):
            score += 1
        scores[action.id] = score
    return scores


def things_meant(program: PhysicalProgram, wish: Wish, text: Sequence[str]) -> list[str]:
    """Things that words speak of: in the clause, in all that is said, or those that are driven."""
    for words in (wish.clause, text):
        found = named_things(program, words)
        if found:
            return found
    driven = {one.name for one in driving(program)}
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


def named_actions(program: PhysicalProgram, words: Sequence[str]) -> list[str]:
    """Ids of the actions whose verb is among the words."""
    return _best(_scores_of_actions(program, words), least=3)


def named_things(program: PhysicalProgram, words: Sequence[str]) -> list[str]:
    """The things that the words name best."""
    return _best(_scores_of_things(program, words), least=1)


def _best(scores: dict[str, int], least: int) -> list[str]:
    most = max(scores.values(), default=0)
    return [name for name, score in scores.items() if score == most and score >= least]


def senses(words: Sequence[str]) -> set[str]:
    """What is done, by the verbs among words."""
    before = ("", *words)
    found = {_sense(w) for w, last in zip(words, before, strict=False) if last not in STATED}
    return found - {""}


def _sense(word: str) -> str:
    if word in degrees().air:
        return "blow"
    base = verb_base(word)
    return VERBS[base].sense if base is not None else ""


def driving(program: PhysicalProgram) -> list[Action]:
    """Actions that set something in motion."""
    return [
        one
        for one in program.event.actions
        if not one.muted and not isinstance(one, FixObject) and not is_brake(one)
    ]


def is_brake(action: Action) -> bool:
    """Whether an action takes speed away: against the way it goes, or by its name."""
    value = getattr(action, "force", None)
    against = isinstance(value, Directed) and value.along == "against_velocity"
    return against or any(_sense(word) == "stop" for word in action.id.split("_"))
