"""Which script sets an object going, from what is said of it and how it stands."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

from physagent_studio.agent.rules.contract.intents import Intent, brought_above, carries_the_others
from physagent_studio.agent.rules.scene.measures import WAYS, Layout
from physagent_studio.agent.rules.schedule import actions as act
from physagent_studio.agent.rules.schedule import scripts
from physagent_studio.agent.rules.schedule.legs import one_way_then_another, shorter, ways_in_turn
from physagent_studio.agent.rules.schedule.ramps import down_ramp
from physagent_studio.agent.rules.schedule.scripts import Task
from physagent_studio.agent.rules.schedule.told_order import (
    GROUND,
    OVER,
    backs_first,
    goes_first,
    goes_on_after_bouncing,
    is_stiff,
    rolls_when_it_lies,
    spins_first,
    tips_onto,
    wobbles_first,
    wobbles_then,
)
from physagent_studio.knowledge import is_sheet
from physagent_studio.language import EDGES, EventFrame
from physagent_studio.program.actions import Action
from physagent_studio.program.scene.aloft import in_air

Script = Callable[[Task], list[Action]]


def script_for(task: Task) -> Script:
    """The script that sets an object going."""
    intent, layout = task.intent, task.layout
    if intent.has("wind") or _is_blown(task):
        return scripts.in_wind
    if intent.has("withdrawn"):
        return scripts.let_go
    if intent.has("float") or _sinks(task):
        return scripts.float_down
    if _is_carried(task):
        return scripts.carry
    if backs_first(task):
        return _back_and_on
    if intent.frames and intent.frames[0].sense == "rise":
        return scripts.lift
    if task.ramp_ahead() is not None:
        return scripts.up_ramp
    if layout.carrier(task.name) is None:
        left = intent.place("from", "off")
        if is_sheet(task.name) and intent.has("fall", "land", "descend"):
            return scripts.waft
        if left is not None and left.kind == "landmark" and intent.has("fall", "descend"):
            return _nothing
        if intent.has("slip", "lose_support") and intent.has("fall") and task.way() is None:
            # "Slips off its hook and falls": what held it is let go of, nothing pushes it.
            return _nothing
        if intent.has("miss") or intent.place("past", senses=("fall", "descend")):
            return scripts.past_what_is_below
        if scripts.landed_on(task) is not None:
            return scripts.off_what_it_fell_on
    if scripts.top_aim(task) is not None:
        return scripts.leap_onto
    flying = intent.has("kick", "throw", "fly") and not intent.has("roll", "slide")
    flying |= intent.has("fly") and intent.has("land")
    flying = (flying and not _shoots_along(task)) or _is_higher(task)
    if flying and not intent.has("fly") and _leaves_support(task):
        # "Is kicked off the table" is over its edge, and not out of the picture.
        return scripts.off_edge
    inside = task.target()
    if flying or (inside is not None and _is_opening(inside.name, layout) and intent.has("land")):
        return scripts.through_air
    if ways_in_turn(task):
        return one_way_then_another
    if wobbles_then(task) and not wobbles_first(task):
        return _rocked_then
    if rolls_when_it_lies(task):
        return scripts.over_and_off if _leaves_support(task) else scripts.over_and_on
    if _leaves_support(task):
        return scripts.off_edge
    on_ramp = layout.ramp_below(intent.name) is not None
    if on_ramp and intent.has(*_SLOPE) and not _against_slope(task):
        return down_ramp
    if task.wheels is not None and scripts.turns_off(task):
        return scripts.drive
    return _by_sense(task)


def _is_carried(task: Task) -> bool:
    """Whether a hand takes what stands there up, and brings it elsewhere or puts it down."""
    own = [f for f in task.intent.frames if not f.negated and task.name not in f.agent]
    first = own[0].sense if own else ""
    aloft = task.layout.carrier(task.name) is None
    by_hand = any("carried" in f.manner and not f.agent for f in own)
    brought = any(
        f.sense in ("set_down", "descend")
        or (f.sense in _BROUGHT and (f.places or f.direction))
        or (f.sense in ("fall", "land") and any(p.kind == "object" for _, p in f.places))
        for f in own[1:]
    )
    dropped = bool(own) and brought_above(task.layout, task.name, own[0])
    if (first == "rise" or not aloft) and scripts.turned_in_hand(task):
        # "Is picked up and tilted", "is turned upside down"; what leans or flips stands as it does.
        return first == "rise" or (first == "turn" and own[0].posture == "inverted")
    return (first == "rise" and brought) or (
        not aloft and (by_hand or dropped or first == "set_down")
    )


_BROUGHT = ("move", "push", "pull", "drift")


def _stays_there(task: Task) -> bool:
    """Whether nothing more is told of it than that it turns, on level ground."""
    told = {frame.sense for frame in task.intent.frames if not frame.negated}
    still = told <= {"turn_around", "turn", "stay", "rest", "be"}
    return still and task.layout.ramp_below(task.name) is None


def _sinks(task: Task) -> bool:
    """Whether it comes down through the air and not as things fall: slowly."""
    if task.layout.carrier(task.name) is not None:
        return False
    if task.intent.has("set_down"):
        return True
    down = (f for f in task.intent.frames if f.sense in ("descend", "fall"))
    return any(f.manner & {"slow", "gentle"} for f in down)


def _against_slope(task: Task) -> bool:
    """Whether it is told to go another way than the slope that it lies on or above."""
    downhill, way = task.layout.downhill(task.name), task.way()
    return downhill is not None and way is not None and float(downhill @ WAYS[way]) < -0.2


_SLOPE = (
    "roll",
    "slide",
    "move",
    "drift",
    "descend",
    "reach",
    "stop",
    "slip",
    "turn_around",
    "reverse",
)


def _is_higher(task: Task) -> bool:
    """Whether it shall get from the ground into or onto something that lies higher."""
    place, layout = task.target(), task.layout
    if place is None or layout.carrier(task.name) is None:
        return False
    if _is_out_of_reach(task):
        return True
    top = float(layout.position(task.name)[2]) + layout.height(task.name) / 2
    if place.kind == "landmark":
        mark = layout.state.landmark(place.name)
        heights = [p[2] for p in mark.points or ()] if mark is not None else []
        return bool(heights) and min(heights) > top
    on_top = task.intent.place("on", "atop", "in", senses=("land", "jump")) == place
    return place.kind == "object" and on_top and not layout.is_raised(task.name)


def _is_out_of_reach(task: Task) -> bool:
    """Whether what a ball shall hit stands on a thing that it would run into first; what has
    wheels or slides does not fly there."""
    layout, hits = task.layout, task.intent.hits
    if not hits or not layout.has(hits[0]) or layout.is_raised(task.name):
        return False
    if task.wheels is not None or not layout.rolls(task.name):
        return False
    base = layout.carrier(hits[0])
    if base is None or base == task.name or layout.state.object(base) is None:
        return False
    lowest = layout.position(hits[0])[2] - layout.height(hits[0]) / 2
    middle = float(layout.position(task.name)[2])
    return bool(lowest > middle) and base not in hits


def _shoots_along(task: Task) -> bool:
    """ "Shoots across the desk and hits the glass": along it, where both stand on it."""
    along, layout, hits = task.intent.place("along"), task.layout, task.intent.hits
    if along is None or not hits or not layout.has(hits[0]) or layout.rolls(task.name):
        return False
    return layout.carrier(task.name) == layout.carrier(hits[0]) == along.name


def _is_opening(name: str, layout: Layout) -> bool:
    landmark = layout.state.landmark(name)
    return landmark is not None and landmark.kind == "opening"


def _leaves_support(task: Task) -> bool:
    """Whether it shall come off what carries it, and something below can catch it."""
    layout = task.layout
    # What it knocks off the table is not told of itself.
    own = [f for f in task.intent.frames if task.name not in f.agent]
    intent = Intent(task.name, own)
    off = intent.place("off", "from")
    edge = intent.place("object", "over", "past")
    over_edge = edge is not None and edge.part in EDGES
    carrier = layout.carrier(task.name)
    if carrier is None:
        return False
    on_ground = carrier == layout.ground()
    if on_ground or (
        layout.ramp_below(task.name) is not None and layout.base(task.name) != carrier
    ):
        return False
    named = off is not None and (
        off.kind == "group" or off.name in (carrier, layout.base(task.name))
    )
    on_ramp = layout.downhill(task.name) is not None
    dropped = (f for f in intent.frames if not carries_the_others(layout, task.name, f))
    falls = any(_drops(frame) for frame in dropped) and not on_ramp
    # Of a stack that collapses, what stands on others comes off them.
    falls |= intent.has("collapse") and layout.state.object(carrier) is not None
    return named or over_edge or falls


def _drops(frame: EventFrame) -> bool:
    return frame.sense in ("fall", "slip") and not frame.lies_down


def _by_sense(task: Task) -> Script:
    intent = task.intent
    table: tuple[tuple[tuple[str, ...], Script], ...] = (
        (("sway",) if _hangs(task) and intent.hits else (), scripts.swing),
        (("jump",), _hopping(task)),
        (("bounce",), _bouncing(task)),
        (OVER if tips_onto(task) else (), scripts.tip),
        (("knock_over", "tip_over") if intent.hits else (), scripts.along_ground),
        (("reverse",) if not intent.hits else (), scripts.turn_back),
        (GROUND, scripts.along_ground),
        (("flip",), scripts.tip),
        (("knock_over", "tip_over", "topple", "lose_balance"), scripts.tip),
        (("spin",), scripts.spin_about),
        (("turn_around",) if _stays_there(task) else (), scripts.spin_about),
        (("turn_around", "reverse"), scripts.turn_back),
        (("turn",), scripts.spin_about),
        (("sway",) if _hangs(task) else (), scripts.swing),
        (("sway",), scripts.rock if is_stiff(task) else _nothing),
        (("stop", "settle"), scripts.along_ground if _on_level(task) else _nothing),
        (("deform",) if scripts.is_squeezed(task) else (), scripts.squeeze),
        (("crush", "collapse", "break", "spread", "sway", "bend", "deform"), _nothing),
        (("fall",) if _can_only_topple(task) else (), scripts.tip),
        (("fall", "land", "descend", "lose_support", "settle", "stop"), _nothing),
    )
    if (
        intent.hits
        and task.layout.carrier(task.name) is None
        and intent.has("fall", "land", "crush")
    ):
        return _nothing
    if spins_first(task):
        return scripts.spin_over
    if wobbles_first(task):
        return scripts.rock_over
    if goes_first(task):
        return scripts.go_over
    if (
        intent.has("spin")
        and intent.has("move", "slide", "drift", "push")
        and not task.layout.rolls(task.name)
    ):
        return scripts.spin_along
    for senses, script in table:
        if intent.has(*senses):
            return _unless_toppling(task, senses, script)
    return _nothing


def _bouncing(task: Task) -> Script:
    """What hangs in the air falls by itself; what shall bounce on to a place is thrown there."""
    if task.layout.carrier(task.name) is None:
        return _nothing
    if task.down_the_steps() is not None:
        return scripts.along_ground
    if goes_on_after_bouncing(task):
        return _bounced_then
    if scripts.hops_told(task) and task.target() is None and task.way() in (None, "up"):
        return scripts.hop_along
    if task.intent.hits:
        known = task.layout.has(task.intent.hits[0])
        return scripts.hop_onto if known and _bounces_first(task) else scripts.along_ground
    return scripts.through_air if task.target() is not None else scripts.leap


def _back_and_on(task: Task) -> list[Action]:
    """Backwards for two fifths of the clip, to a stand there; then on with its front first."""
    first, *rest = task.intent.frames
    # That it stops in between is told of its way back.
    rest = rest[next(k for k, f in enumerate(rest) if f.sense not in ("stop", "settle")) :]
    wait = task.clip.steps * 2 // 5
    halts = Intent(task.name, [first, EventFrame("stop", "")])
    back = scripts.along_ground(replace(task, intent=halts, clip=shorter(task.clip, wait)))
    return back + _onward(task, rest, wait)


def _bounced_then(task: Task) -> list[Action]:
    """It leaps on the spot as often as is told, and is set going where it comes down last."""
    first, *rest = task.intent.frames
    here = replace(task, intent=Intent(task.name, [first]))
    leaps = _bouncing(here)(here)
    return leaps + _onward(task, rest, scripts.bounced_steps(here, leaps))


def _rocked_then(task: Task) -> list[Action]:
    """It wobbles where it stands, and then goes on; what stands and rolls falls over for that."""
    first, *rest = (f for f in task.intent.frames if not f.negated)
    rocked, wait = scripts.rock_first(replace(task, intent=Intent(task.name, [first])))
    if rest[0].sense == "roll" and task.layout.rolls_on_its_side(task.name):
        rest.insert(0, EventFrame("topple", "", patient=(task.name,)))
    return rocked + _onward(task, rest, wait)


def _onward(task: Task, frames: list[EventFrame], wait: int) -> list[Action]:
    """What else is told of it, in what is left of the clip after so many steps."""
    clip = shorter(task.clip, task.clip.steps - wait)
    rest = replace(task, intent=replace(task.intent, frames=frames), clip=clip)
    return [act.later(action, wait) for action in script_for(rest)(rest)]


def _hopping(task: Task) -> Script:
    """One leap, or as many as are told or as it takes to a thing."""
    several = scripts.hops_told(task) or scripts.hop_aim(task) is not None
    return scripts.hop_along if several and not task.intent.hits else scripts.leap


def _bounces_first(task: Task) -> bool:
    """ "Bounces twice, then hits the can", and not "hits the wall and bounces back"."""
    told = [f for f in task.intent.frames if f.sense == "bounce" or task.name in f.agent]
    first = told[0] if told else None
    off = first is not None and first.place("off") is not None
    return first is not None and first.sense == "bounce" and not (first.negated or off)


def _can_only_topple(task: Task) -> bool:
    """ "The pins fall", "falls onto its side": what stands on the ground, or is told to end so,
    and is no ball."""
    layout = task.layout
    lies = any(frame.lies_down for frame in task.intent.frames)
    return (lies or not layout.is_raised(task.name)) and not layout.rolls(task.name)


def _unless_toppling(task: Task, senses: tuple[str, ...], script: Script) -> Script:
    """A push that only shall make a thing fall over acts at its top."""
    own = task.intent.has("topple", "knock_over", "tip_over") and not task.intent.hits
    plain = not task.intent.has("roll", "slide", "move", "curve", "cross", "reach", "drift")
    return scripts.tip if senses is GROUND and own and plain else script


def _hangs(task: Task) -> bool:
    """Whether it is rigid and hangs in the air."""
    item = task.layout.state.object(task.name)
    return item is not None and item.body.kind == "rigid" and in_air(item)


def _on_level(task: Task) -> bool:
    """Whether it stands on something level and is not said to fall."""
    layout = task.layout
    stands = layout.carrier(task.name) is not None and layout.downhill(task.name) is None
    return stands and not task.intent.has("fall", "land", "descend", "lose_support")


def _is_blown(task: Task) -> bool:
    """Whether it sways or bends, gives way and nothing but the air is told to move it."""
    item, intent = task.layout.state.object(task.name), task.intent
    gives = item is not None and item.body.kind in ("soft", "cloth")
    moved = intent.struck_by or any(f.agent or f.cause not in ("", "wind") for f in intent.frames)
    moved = moved or intent.has("push", "pull", "kick", "knock", "hit", "throw", "fall")
    return gives and intent.has("sway", "bend") and not moved


def _nothing(task: Task) -> list[Action]:
    """Gravity does it; what hangs in the air is seen to hang before it falls."""
    if task.layout.carrier(task.name) is not None or _is_struck_in_air(task):
        return []
    return [act.hold(task.name, act.STEPS.hang_steps)]


def _is_struck_in_air(task: Task) -> bool:
    """Whether something else sets it going."""
    return bool(task.intent.struck_by)
