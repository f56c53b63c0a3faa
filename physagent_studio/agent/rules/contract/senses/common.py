"""What several senses have in common: ways, blows, postures."""

from __future__ import annotations

from dataclasses import dataclass

from physagent_studio.agent.rules.contract.intents import met
from physagent_studio.agent.rules.contract.senses.whereabouts import farther_from, is_ground
from physagent_studio.agent.rules.contract.specs import (
    Context,
    Spec,
    any_of,
    before,
    forward,
    lies_on,
    over_way,
    spec,
    ways_of,
)
from physagent_studio.agent.rules.scene.framing import free_way, good_way
from physagent_studio.agent.rules.scene.measures import WAYS, place_name
from physagent_studio.agent.rules.scene.sides import lying_from, stands_tall
from physagent_studio.language import EventFrame
from physagent_studio.program.actions import Direction


@dataclass(frozen=True, slots=True)
class PostureSettings:
    """How far a thing is turned that ends in a posture, or gone that is pulled out."""

    flat_deg: float = 20.0  # 5..40: up to which it stands or lies flat
    over_deg: float = 160.0  # 120..180: from which it is upside down, and as flat
    # 45..80: from which it lies on its side; leaning against things included
    side_deg: float = 60.0
    side_most_deg: float = 125.0  # 100..135: up to which it does, and is not upside down
    out_share: float = 0.8  # 0.5..1: of its own extent, gone by what is pulled out


POSTURE = PostureSettings()


def travel(c: Context) -> list[Spec]:
    """That it moves, along the way that is said, towards what is named."""
    distance = least_way(c)
    if _comes_back_down(c):
        return [spec("falls", c.subject, drop=c.length(0.3, 0.015, 0.1))]
    ways: list[Direction] = [
        w for w in c.ways() if w != "down" or c.layout.is_raised(c.subject)
    ] or _carried_on(c)
    found = (
        [
            any_of(
                *(
                    spec(
                        "moves",
                        c.subject,
                        distance=least_along(c, _own_way(c, distance, w), w),
                        direction=w,
                    )
                    for w in ways
                )
            )
        ]
        if ways
        else []
    )
    toward = c.frame.place("toward", "at", "against")
    if toward is not None and not is_ground(c, toward) and toward.name != c.subject:
        known = all(c.layout.has(name) for name in (c.subject, toward.name))
        if c.frame.distance is not None and known:
            distance = round(c.layout.nearer(c.subject, toward.name, distance), 4)
        found.append(spec("moves", c.subject, distance=distance, toward=place_name(toward)))
    gone = c.frame.place("away_from")
    if gone is not None and gone.name != c.subject:
        found += farther_from(c, gone)
    return found or [spec("moves", c.subject, distance=distance)]


def goes_aside(c: Context, far: float, to_step: int | None = None) -> Spec:
    """It moves so far, m, to any level side, up to a step where one is given."""
    sides: tuple[Direction, ...] = ("left", "right", "away", "toward_camera")
    return any_of(
        *(spec("moves", c.subject, distance=far, direction=side, to_step=to_step) for side in sides)
    )


def _carried_on(c: Context) -> list[Direction]:
    """ "The puck slides to the left and hits the can, which slides on": to the left as well."""
    if c.frame.places or c.frame.agent:
        return []
    for index, frame in enumerate(c.reading.frames[: c.index]):
        if c.subject not in frame.patient or frame.sense != "hit" or len(frame.agent) != 1:
            continue
        told = [f for f in c.reading.frames[:index] if frame.agent[0] in f.patient]
        return [w for f in told[-1:] for w in ways_of(f.direction, f, frame.agent[0], c.layout)]
    return []


def _comes_back_down(c: Context) -> bool:
    """ "Is pushed up the ramp and slides back down": what was below goes down again."""
    below = c.layout.has(c.subject) and not c.layout.is_raised(c.subject)
    up = any(f.direction == "up" or f.place("up") or f.sense == "rise" for f in c.earlier)
    return c.frame.direction == "down" and below and up


def least_way(c: Context) -> float:
    """How far it goes at least, as far as room is left to, m."""
    if c.frame.distance is not None:
        return round(0.8 * c.frame.distance, 4)
    if "out" in c.frame.manner:
        return c.length(POSTURE.out_share, 0.02, 2.0)
    if "far" in c.frame.manner:
        return c.length(4.0, 0.2, 1.5)
    if c.frame.partly_off:
        return c.length(0.35, 0.01, 0.2)
    return c.length(0.1, 0.01, 0.05) if "slight" in c.frame.manner else c.length(0.5, 0.02, 0.2)


def _own_way(c: Context, distance: float, way: Direction) -> float:
    """What goes on wheels or legs is seen to do so for its own length."""
    item = c.layout.state.object(c.subject)
    goes = c.frame.gait or (c.frame.sense == "roll" and item is not None and item.wheels)
    alone = all(f.sense in ("stop", "settle", "stay", "rest") for f in (*c.earlier, *c.later))
    if not (goes and alone) or c.frame.manner & _NEAR or c.frame.distance is not None:
        return distance
    own = c.layout.extent(c.subject, WAYS[way]) + c.layout.extent(c.subject, -WAYS[way])
    return max(distance, round(own, 3))


_NEAR = {"slight", "slow", "gentle", "offscreen"}


def least_along(c: Context, distance: float, way: Direction) -> float:
    """No farther than the picture and what stands there leave it room along a way, m."""
    if c.frame.distance is not None or "offscreen" in c.frame.manner:
        return distance
    if "out" in c.frame.manner:
        # "Is pulled out": clear of where it stood.
        own = c.layout.extent(c.subject, WAYS[way]) + c.layout.extent(c.subject, -WAYS[way])
        return max(round(POSTURE.out_share * own, 3), c.length(0.5, 0.02, 0.2))
    share = 0.8  # 0.5..1: of the way that the schedule has it go
    room = share * good_way(c.layout, c.subject, WAYS[way])
    if "far" in c.frame.manner:
        far_share = 0.65  # 0.5..0.9: of all the way that is free
        room = max(room, far_share * free_way(c.layout, c.subject, WAYS[way]))
    return round(min(distance, max(room, c.length(0.1, 0.01, 0.05))), 3)


def manner(c: Context) -> list[Spec]:
    """How fast, and whether to and fro, where the prompt says so."""
    if "rhythmic" in c.frame.manner and c.frame.sense in ("roll", "slide", "move", "drift"):
        return [spec("reverses", c.subject, angle=90.0, times=2), *_pace(c)]
    return _pace(c)


def comes_down(c: Context) -> bool:
    """Whether it falls before, after or by what it does: then it does fly for a while."""
    told = {f.sense for f in (*c.earlier, *c.later)}
    frames = [c.frame, *(f for f in (*c.earlier, *c.later) if c.subject in f.patient)]
    off = any(f.place("off", "from") is not None for f in frames) or c.frame.direction == "off"
    return off or bool(told & {"fall", "land", "bounce", "jump", "throw", "fly", "rise", "kick"})


def _pace(c: Context) -> list[Spec]:
    if "slow" in c.frame.manner or "gentle" in c.frame.manner:
        if c.frame.sense in ("float", "descend") or c.layout.ramp_below(c.subject) is not None:
            drop = c.length(0.3, 0.02, 0.1)
            return [spec("descends_slowly", c.subject, drop=drop, speed=0.6)]
        # What falls gets fast however slowly it came to the edge.
        level = True if comes_down(c) else None
        return [spec("speed_between", c.subject, low=0.02, high=1.0, level=level)]
    if "fast" in c.frame.manner or "hard" in c.frame.manner:
        return [spec("speed_between", c.subject, low=0.7)]
    return []


FLIGHTS = ("fly", "jump", "throw", "bounce")
"""What goes through the air while it is told."""


def bent_path(c: Context) -> list[Spec]:
    """The shape of its path, where the prompt says one."""
    if not c.frame.path:
        return []
    if c.frame.path == "straight":
        return [spec("path_bends", c.subject, angle=15.0, negated=True)]
    angle = 150.0 if c.frame.path == "circle" else 10.0
    side = c.frame.direction if c.frame.direction in ("left", "right") else "either"
    if c.frame.place("around") is not None:
        # "Drives to the left in a curve around the cone": on either side of it.
        side = "either"
    if c.frame.path == "curve" and c.frame.sense in FLIGHTS:
        # Weight bends its way by itself, seen from the side: "flies in an arc to the right".
        return []
    return [spec("path_bends", c.subject, side=side, angle=angle)]


def touch(c: Context) -> list[Spec]:
    """The agents touch the subject: one of several suffices."""
    agents = [a for a in c.frame.agent if a != c.subject]
    if not agents:
        return []
    return [any_of(*(spec("contacts", a, other=c.subject) for a in agents))]


def gone_over(c: Context) -> Spec:
    """It falls over, as far as it has to for the posture in which it ends."""
    if c.frame.posture in LYING:
        return _lies(c)
    return spec("topples", c.subject, tilt=lying_from(c.layout, c.subject, 45.0))


LYING = ("side", "supine", "prone")


def _lies(c: Context) -> Spec:
    """It lies on a side of its own or its back, and is not upside down."""
    tilt = lying_from(c.layout, c.subject, POSTURE.side_deg)
    if c.frame.posture != "side" and not stands_tall(c.layout, c.subject):
        return spec("topples", c.subject, tilt=tilt)
    onto = lies_on(c.frame.posture, c.subject, c.layout)
    return spec("topples", c.subject, tilt=tilt, most=POSTURE.side_most_deg, onto=onto)


def lies_in_the_end(c: Context) -> list[Spec]:
    """ "Is pushed off the table onto its side": how it ends that goes on."""
    return posture(c) if c.frame.posture in LYING else []


def sideways_fall(c: Context) -> list[Spec]:
    """ "Topples to the left": its middle goes there."""
    frame = c.frame
    plain = frame.direction in (None, "up", "down", "off")
    way = falling_way(c) or (frame.origin if plain else frame.direction)
    if way in (None, "forward", "backward", "up", "down", "off"):
        return []
    far = c.length(0.25, 0.02, 0.2)
    ways = ways_of(way, frame, c.subject, c.layout)
    moved = [spec("moves", c.subject, distance=far, direction=w) for w in ways]
    return [any_of(*moved)] if moved else []


def falling_way(c: Context) -> Direction | None:
    """ "Topples backwards", "falls on its face"; away from what knocks it over backwards."""
    if not _was_struck(c) and (way := over_way(c.frame, c.subject, c.layout)) is not None:
        return way
    if c.frame.direction == "backward" and c.frame.agent:
        return forward(c.frame, c.subject, c.layout)
    return None


def _was_struck(c: Context) -> bool:
    return any(f.agent and c.subject in f.patient for f in c.earlier)


def siblings(c: Context) -> list[Spec]:
    """ "Only": the acting object touches none of the others of the kind."""
    if not c.frame.only:
        return []
    kind = c.subject.split("_")[-1]
    meant = {*c.frame.patient, *c.frame.agent}
    others = [o.name for o in c.layout.state.objects if o.name not in meant]
    alike = [name for name in others if name.split("_")[-1] == kind]
    if c.frame.agent:
        # "Hits only the cube": nothing else is hit, whatever it is, but what carries the agent.
        carriers = {c.layout.carrier(a) for a in c.frame.agent}
        spared = [name for name in others if name not in carriers]
        return [spec("contacts", a, other=s, negated=True) for a in c.frame.agent for s in spared]
    return [spec("stays", s, distance=0.05, tilt=15.0) for s in alike]


def struck_before(c: Context) -> list[Spec]:
    """The blow that an earlier clause tells of, with the subject on either side of it."""
    for frame in c.earlier:
        if frame.sense != "hit" or not frame.agent:
            continue
        if c.subject in frame.patient:
            struck = frame.patient if hit_as_one(c, frame) else (c.subject,)
            return [any_of(*(spec("contacts", frame.agent[0], other=name) for name in struck))]
        if c.subject in frame.agent and frame.patient:
            return [spec("contacts", c.subject, other=frame.patient[0])]
    for frame in c.reading.frames[: c.index]:
        # "Slides into the cup, which tips over".
        if c.subject in met(frame) and not frame.any_one and len(frame.patient) == 1:
            return [spec("contacts", frame.patient[0], other=c.subject)]
    return []


def hit_as_one(c: Context, frame: EventFrame) -> bool:
    """Whether a blow is to a stack or a row: who hits one of it has hit it."""
    stacked = any(c.layout.carrier(name) in frame.patient for name in frame.patient)
    return frame.as_one and (stacked or len(frame.patient) > 2)


def posture(c: Context) -> list[Spec]:
    """How it ends."""
    if c.layout.rolls(c.subject):
        return []
    flat = spec("upright", c.subject, tilt=POSTURE.flat_deg)
    if c.frame.posture == "flat" and not c.layout.lies_flat(c.subject):
        return [spec("topples", c.subject, tilt=90.0 - POSTURE.flat_deg)]
    if c.frame.posture == "flat":
        return [any_of(flat, spec("topples", c.subject, tilt=POSTURE.over_deg))]
    if c.frame.posture == "upright":
        return [flat]
    if c.frame.posture in LYING:
        return [_lies(c), *([] if c.frame.posture == "side" else sideways_fall(c))]
    return [spec("topples", c.subject, tilt=135.0)] if c.frame.posture == "inverted" else []


def rolls(c: Context) -> bool:
    """Whether the subject rolls and has no up side."""
    return c.layout.rolls(c.subject)


def still(c: Context) -> list[Spec]:
    """It stays where and as it is."""
    return [spec("stays", c.subject, distance=c.length(0.4, 0.03, 0.05), tilt=15.0)]


def quality(c: Context) -> list[Spec]:
    """ "The motion is gentle, continuous and rhythmic"."""
    found: list[Spec] = []
    if "gentle" in c.frame.manner or "slow" in c.frame.manner:
        found.append(spec("speed_between", c.subject, low=0.01, high=1.5))
    if "continuous" in c.frame.manner:
        found.append(spec("sways", c.subject, amplitude=2.0, cycles=1.0, from_step=160))
    if "rhythmic" in c.frame.manner:
        found.append(spec("sways", c.subject, amplitude=2.0, cycles=2.0))
    return found


_OVER = ("topple", "fall", "knock_over", "tip_over", "flip", "collapse", "lose_balance")


def keeps_standing(c: Context) -> list[Spec]:
    """What bends or sways does not fall over, unless that is told next."""
    falls = any(f.sense in _OVER and not f.negated for f in c.later)
    if c.layout.rolls_on_its_side(c.subject):
        # What stands and rolls off lies for that.
        falls |= any(f.sense == "roll" and not f.negated for f in c.later)
    return [] if rolls(c) or falls else [spec("topples", c.subject, tilt=60.0, negated=True)]


def arrival(c: Context, frame: EventFrame) -> Spec | None:
    """The statement that the subject gets to the place of a frame; None where it names none."""
    place = frame.place("object", "on", "at", "toward", "in", "into", "against")
    if place is None or place.kind == "group":
        return None
    if place.kind == "support" and place.part == "lower_end":
        return spec("contacts", c.subject, other=c.layout.ground())
    name = place_name(place)
    if place.kind == "landmark":
        return spec("passes_over", c.subject, landmark=name)
    return spec("contacts", c.subject, other=name)


def struck_or_passed_on(c: Context, over: Spec) -> list[Spec]:
    """ "Knocks all three over": the ball hits one at least, and each falls because it is hit by
    the ball or by another of them."""
    agents = [a for a in c.frame.agent if a not in c.frame.patient]
    hits = [spec("contacts", a, other=p) for a in agents for p in c.frame.patient]
    if not hits:
        return [over]
    mine = [spec("contacts", a, other=c.subject) for a in agents]
    passed_on = [spec("contacts", p, other=c.subject) for p in c.frame.patient if p != c.subject]
    caused = Spec("all_of", {}, (before(any_of(*mine, *passed_on), over),))
    return [any_of(*hits), over, caused]
