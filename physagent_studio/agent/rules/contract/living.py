"""People and animals: what they do with their limbs, and that they keep their balance.

A rigid body has no limbs. So a person or an animal that acts on a thing within its reach stays
where it is, and the thing moves as told; what is farther away it first goes to.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from physagent_studio.agent.rules.contract.intents import met
from physagent_studio.agent.rules.scene.measures import Layout, level, named_way
from physagent_studio.knowledge import kind_of
from physagent_studio.language import EventFrame, Place, Reading
from physagent_studio.language.tokens.vocabulary import words_of
from physagent_studio.program.scene.state import SceneObject, SceneState


@dataclass(frozen=True, slots=True)
class LivingSettings:
    """How far limbs reach."""

    # of its height, 0.3..0.7: a person's arm is .44 of it and the leg .5; so are necks and legs
    reach_share: float = 0.5
    # of its reach, 0.2..0.9: how near it goes to what it shall act on: a bent arm or leg
    near_share: float = 0.5
    # of the way to there, 0.3..0.9: after which it acts, where it was within reach before it went
    gone_share: float = 0.6


LIVING = LivingSettings()
_BY_LIMBS = words_of(
    "kick throw push hit strike knock knock_over tip_over topple pull move roll slide drift fly "
    "fall rise set_down put spin flip dislodge"
)
"""What is done to a thing with an arm, a leg, a paw or a head."""
_SENT = words_of("kick throw push hit strike knock move roll slide dislodge")
"""What sends a thing off: away from who does it, where no way is told."""
_UPSET = words_of(
    "topple fall flip knock_over tip_over lose_balance lose_support collapse lean hit strike "
    "knock kick throw crush break bend deform sway wind descend land fly float"
)
"""What takes a person's or an animal's balance, or shows it without."""


def is_living(name: str) -> bool:
    """Whether a thing is a person or an animal, by its name."""
    kind = kind_of(name)
    return kind is not None and kind.is_alive


def way_into_reach(layout: Layout, name: str, other: str) -> tuple[float, float]:
    """How far a living thing goes to act on another, and how much nearer it acts, m."""
    reach, gap = LIVING.reach_share * layout.height(name), max(layout.gap(name, other), 0.0)
    near = LIVING.near_share
    way = max(gap - near * reach, near * gap)
    gone = layout.nearer(name, other, max(gap - reach, LIVING.gone_share * way))
    return round(way, 3), round(gone, 3)


def by_limbs(reading: Reading, layout: Layout) -> Reading:
    """ "The boy kicks the ball": the ball is kicked, once he is within reach of it; the reading
    with that said."""
    frames: list[EventFrame] = []
    for index, frame in enumerate(reading.frames):
        if (goal := _goal(frame, layout)) is not None and frame.distance is None:
            # It goes up to it, and not into it.
            way, _ = way_into_reach(layout, frame.patient[0], goal)
            frame = replace(frame, distance=way)
        doer = _doer(frame, frames, layout)
        if doer is None:
            frames.append(frame)
            continue
        other = frame.patient[0]
        goes = any(_goal(f, layout) == other and f.patient == (doer,) for f in frames)
        near = layout.gap(doer, other) < LIVING.reach_share * layout.height(doer)
        if not goes and not near:
            way, _ = way_into_reach(layout, doer, other)
            going = EventFrame("move", frame.clause, (doer,), distance=way)
            there = replace(going, places=(("toward", Place(other, "object")),))
            frames.append(replace(there, manner=frame.manner & {"slow", "gentle"}))
        by = doer if goes or not near else ""
        done = replace(frame, agent=(), by=by)
        frames.append(_sent(done, doer, reading.frames[index + 1 :], layout))
    return replace(reading, frames=tuple(frames))


def _doer(frame: EventFrame, told: list[EventFrame], layout: Layout) -> str | None:
    """Who does it with its limbs; None where nobody does, or with the whole body: "runs into it
    and knocks it over"."""
    known = all(layout.has(name) for name in (*frame.agent, *frame.patient))
    if frame.sense not in _BY_LIMBS or frame.negated or len(frame.agent) != 1 or not known:
        return None
    doer, apart = frame.agent[0], set(frame.agent).isdisjoint(frame.patient)
    if not is_living(doer) or not frame.patient or not apart:
        return None
    runs = (f.place("into", "against") for f in told if doer in f.patient)
    bodily = "bodily" in frame.manner or any(
        place is not None and place.name in frame.patient for place in runs
    )
    return None if bodily else doer


def _goal(frame: EventFrame, layout: Layout) -> str | None:
    """The thing to which a living one is told to go by itself."""
    place = frame.place("toward", "near", "at")
    alone = len(frame.patient) == 1 and not frame.agent and not frame.negated
    if place is None or place.part or not alone or frame.sense not in ("move", "approach"):
        return None
    name = frame.patient[0]
    known = layout.has(name) and layout.has(place.name) and place.name != name
    return place.name if known and is_living(name) else None


def _sent(
    frame: EventFrame, doer: str, later: tuple[EventFrame, ...], layout: Layout
) -> EventFrame:
    """With where it goes, where nothing tells that: away from who does it, or to who pulls it."""
    name = frame.patient[0]
    rest = [frame, *(f for f in later if name in f.patient and not f.agent)]
    if any(f.direction not in (None, "forward", "backward") or f.places for f in rest):
        return frame
    if frame.sense == "pull":
        return replace(frame, places=(("toward", Place(doer, "object")),))
    away = level(layout.position(name) - layout.position(doer))
    if frame.sense not in _SENT or float(np.linalg.norm(away)) < 1e-3:
        return frame
    return replace(frame, direction=named_way(away))


def kept_upright(state: SceneState, reading: Reading) -> SceneState:
    """The scene with people and animals keeping their balance, where nothing is told to take it."""
    layout = Layout(state)
    upset = {
        name
        for frame in reading.frames
        if not frame.negated
        for name in (*(frame.patient if frame.sense in _UPSET else ()), *met(frame))
    }

    def keeps(item: SceneObject) -> bool:
        stands = item.body.kind == "rigid" and layout.carrier(item.name) is not None
        return stands and item.name not in upset and is_living(item.name)

    objects = tuple(
        item.model_copy(update={"balances": True})
        if keeps(item) and item.balances is None
        else item
        for item in state.objects
    )
    return state.model_copy(update={"objects": objects})
