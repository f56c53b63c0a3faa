"""What is told of one thing to happen one after the other: first it wobbles, then it falls over."""

from __future__ import annotations

from physagent_studio.agent.rules.schedule.scripts import Task
from physagent_studio.language.tokens.vocabulary import words_of

OVER = ("topple", "lose_balance", "fall")
GROUND = tuple(
    words_of(
        "move slide drift roll curve circle push pull kick throw hit cross pass reach enter end "
        "approach accelerate dislodge knock slip strike"
    )
)


def spins_first(task: Task) -> bool:
    """ "It spins, then it falls over": on the spot, one after the other."""
    told = [frame.sense for frame in task.intent.frames if not frame.negated]
    over = next((k for k, sense in enumerate(told) if sense in OVER), 0)
    return "spin" in told[:over] and can_only_topple_here(task) and not task.intent.has(*GROUND)


def wobbles_first(task: Task) -> bool:
    """ "It wobbles, then it topples", where nothing strikes it."""
    told = [frame.sense for frame in task.intent.frames if not frame.negated]
    over = next((k for k, sense in enumerate(told) if sense in OVER), 0)
    alone = not task.intent.struck_by and not task.intent.hits and not task.intent.has(*GROUND)
    return "sway" in told[:over] and alone and is_stiff(task) and can_only_topple_here(task)


def wobbles_then(task: Task) -> bool:
    """ "It wobbles, then it rolls off the table": first where it stands, and then what follows."""
    told = [frame for frame in task.intent.frames if not frame.negated]
    alone = not task.intent.struck_by and not task.intent.hits
    goes = {*OVER, "tip_over", "roll", "slide", "move", "slip"} & {f.sense for f in told[1:]}
    stands = is_stiff(task) and task.layout.carrier(task.name) is not None
    return bool(goes) and told[0].sense == "sway" and alone and stands


def rolls_when_it_lies(task: Task) -> bool:
    """ "The tin tips over and rolls into the box": first it stands, then it lies and is round."""
    told = [f.sense for f in task.intent.frames if not f.negated and task.name in f.patient]
    roll = next((k for k, sense in enumerate(told) if sense == "roll"), 0)
    over = {*OVER, "tip_over", "knock_over"} & {*told[:roll]}
    alone = not task.intent.struck_by and task.layout.downhill(task.name) is None
    stands = task.layout.carrier(task.name) is not None
    return bool(over) and alone and stands and task.layout.rolls_on_its_side(task.name)


def goes_first(task: Task) -> bool:
    """ "It rolls, slows down and falls over": on level ground, one after the other."""
    told = [frame.sense for frame in task.intent.frames if not frame.negated]
    over = next((k for k, sense in enumerate(told) if sense in OVER), 0)
    goes = bool({"roll", "slide", "move", "slow"} & set(told[:over]))
    alone = not task.intent.hits and not task.intent.struck_by and task.target() is None
    level = task.layout.downhill(task.name) is None and task.wheels is None
    return goes and alone and level and can_only_topple_here(task)


def tips_onto(task: Task) -> bool:
    """ "The first domino falls and knocks down the next", "the bottle topples and hits the bowl":
    it stands within reach of it, and falls before anything else is told of it."""
    layout, hits = task.layout, task.intent.hits
    if not hits or not can_only_topple_here(task) or not layout.has(hits[0]):
        return False
    told = [frame.sense for frame in task.intent.frames if not frame.negated]
    over = next((k for k, sense in enumerate(told) if sense in OVER), 0)
    own = {f.sense for f in task.intent.frames if not f.negated and task.name not in f.agent}
    if {"roll", "slide", "move", "drift", "push"} & own or "hit" in told[:over]:
        return False
    return layout.gap(task.name, hits[0]) < layout.height(task.name)


def can_only_topple_here(task: Task) -> bool:
    """Whether it stands, is no ball, and shall fall: that can only be over."""
    layout = task.layout
    own = [f for f in task.intent.frames if f.sense in OVER and task.name in f.patient]
    return bool(own) and layout.carrier(task.name) is not None and not layout.rolls(task.name)


def is_stiff(task: Task) -> bool:
    """Whether it keeps its form, and rocks where it stands."""
    item = task.layout.state.object(task.name)
    return item is not None and item.body.kind == "rigid" and not task.layout.rolls(task.name)


def backs_first(task: Task) -> bool:
    """ "Reverses, then drives into the box": on its wheels, first with its back first."""
    return task.wheels is not None and is_told_to_back(task)


def is_told_to_back(task: Task) -> bool:
    """The same of what has no wheels, or whose wheels are not known yet."""
    told = [f for f in task.intent.frames if not f.negated]
    if len(told) < 2 or task.layout.ramp_below(task.name) is not None:
        return False
    first, on = told[0], told[1:]
    back = first.direction == "backward" or "backwards" in first.manner
    return (
        back
        and not first.agent
        and all(f.direction != "backward" and "backwards" not in f.manner for f in on)
        and any(f.sense in GROUND for f in on)
    )


def goes_on_after_bouncing(task: Task) -> bool:
    """ "Bounces twice and then rolls out of the picture": on the spot first, not on its way."""
    told = [f for f in task.intent.frames if not f.negated]
    if len(told) < 2 or told[0].sense != "bounce" or told[0].places or task.intent.hits:
        return False
    goes = told[1].sense in ("roll", "slide", "move", "leave") and told[1].link == "then"
    return goes and task.layout.rolls(task.name)
