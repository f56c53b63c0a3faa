"""What a clause means in the light of those before and after it."""

from dataclasses import replace
from itertools import pairwise

from physagent_studio.knowledge import kind_of
from physagent_studio.language.frames import EventFrame, Place, Relation, Way


def in_their_light(frames: list[EventFrame]) -> None:
    """Puts frames right, in place, that mean something else beside one another than alone."""
    _almost_off(frames)
    _as_it_came(frames)
    _aim_at_what_gives_way(frames)
    _but_not(frames)
    _but_what_stays(frames)
    _struck_the_one(frames)
    _passed_on(frames)
    _back_to_a_side(frames)
    _backwards_at_first(frames)
    _back_once_turned(frames)
    _behind_what_went(frames)
    _bounced_off(frames)
    _until_it_lies(frames)
    _where_it_struck(frames)
    _springs_back(frames)


_OFF = ("fall", "slip", "slide", "roll", "move", "leave", "drop")
_SHOVED = ("slide", "roll", "move", "push", "pull", "drift")


def _almost_off(frames: list[EventFrame]) -> None:
    """ "Is pulled to the left and almost falls off the table": to its edge, where it stops."""
    for index in range(len(frames) - 1, -1, -1):
        frame = frames[index]
        off = frame.place("off", "from")
        nearly = frame.negated and "nearly" in frame.manner and frame.sense in _OFF
        if not nearly or off is None or off.kind != "support" or off.part not in ("", "edge"):
            continue
        edge: tuple[tuple[Relation, Place], ...] = (("toward", replace(off, part="edge")),)
        stop = EventFrame("stop", frame.clause, frame.patient)
        kept = replace(frame, sense="fall", negated=False, link="before")
        led = frames[index - 1] if index else None
        if led is None or led.patient != frame.patient or led.sense not in _SHOVED or led.places:
            led = EventFrame("slide", frame.clause, frame.patient, places=edge, link=frame.link)
            frames[index : index + 1] = [led, stop, kept]
        else:
            frames[index - 1 : index + 1] = [replace(led, places=edge), stop, kept]


def _as_it_came(frames: list[EventFrame]) -> None:
    """ "It rolls off after it has fallen over": it falls over, then it rolls off."""
    for index, (frame, earlier) in enumerate(pairwise(frames)):
        alone = not (frame.agent or earlier.agent or frame.negated or earlier.negated)
        after = earlier.link == "after" and not earlier.leads
        if after and alone and frame.patient == earlier.patient:
            frames[index] = replace(earlier, link=frame.link, sequel=frame.sequel)
            frames[index + 1] = replace(frame, link="then", sequel=True)


_GOES = ("move", "roll", "slide", "drift", "fly", "leave", "curve", "reverse")


def _behind_what_went(frames: list[EventFrame]) -> None:
    """ "The truck drives off to the left, and the ball rolls after it": the same way, and later;
    after what went nowhere, it goes towards it. "The brick falls, and the board falls after it":
    later."""
    for index, frame in enumerate(frames):
        ahead = frame.place("after")
        if ahead is None or ahead.kind != "object":
            continue
        if frame.sense not in _GOES:
            told = frames[index - 1] if index else None
            if told is not None and ahead.name in told.patient and frame.link == "then":
                rest = tuple(row for row in frame.places if row[0] != "after")
                frames[index] = replace(frame, places=rest, sequel=True)
            continue
        went = [f for f in frames[:index] if ahead.name in f.patient and f.sense in _GOES]
        led = next((f for f in reversed(went) if not f.negated), None)
        way = frame.direction or (led.direction if led is not None else None)
        # Whichever way forward is for the one, the other goes where that one stood.
        way = None if way in ("forward", "backward", "off") else way
        kept = tuple(row for row in frame.places if row[0] != "after")
        aim: tuple[tuple[Relation, Place], ...] = () if way else (("toward", ahead),)
        next_told = index > 0 and frames[index - 1] is led and frame.link == "then"
        frames[index] = replace(
            frame, places=(*aim, *kept), direction=way, sequel=frame.sequel or next_told
        )


AT_REST = ("stop", "settle", "stay", "rest")


def _bounced_off(frames: list[EventFrame]) -> None:
    """ "Rolls to the box and bounces off": off the box."""
    for index, (frame, after) in enumerate(pairwise(frames)):
        to = frame.place("toward", "into", "against", "at")
        bare = all(place.kind == "group" for _, place in after.places)
        alone = after.patient == frame.patient and bare and not after.agent
        off = after.sense == "bounce" and after.direction in ("off", "backward") and alone
        if off and to is not None and to.kind == "object" and not frame.negated:
            places: tuple[tuple[Relation, Place], ...] = (("off", to),)
            frames[index + 1] = replace(after, places=places, direction=None)


def _until_it_lies(frames: list[EventFrame]) -> None:
    """ "Is pushed until it lies next to the bucket": it stops there."""
    for index, frame in enumerate(frames):
        near = frame.place("near")
        if frame.sense == "rest" and frame.link == "until" and near is not None:
            frames[index] = replace(frame, sense="stop")


def _where_it_struck(frames: list[EventFrame]) -> None:
    """ "Hits the mug and stops there", "slides into it and stays there": near the mug."""
    for index, (frame, after) in enumerate(pairwise(frames)):
        into = frame.place("into", "against")
        met = frame.patient if frame.sense == "hit" else (into.name,) if into is not None else ()
        who = frame.agent if frame.sense == "hit" else frame.patient
        same = after.patient == who and after.sense in AT_REST and not after.negated
        if len(met) == 1 and same and "there" in after.manner and not after.places:
            near: tuple[tuple[Relation, Place], ...] = (("near", Place(met[0], "object")),)
            frames[index + 1] = replace(after, sense="stop", places=near)


def _springs_back(frames: list[EventFrame]) -> None:
    """ "Is squeezed flat and springs back": into its form, so that it is flat only until then. What
    did not lose its form swings back."""
    for index, frame in enumerate(frames):
        if frame.sense != "recover":
            continue
        squeezed = [
            k
            for k, f in enumerate(frames[:index])
            if f.sense in ("deform", "crush") and f.patient == frame.patient and not f.negated
        ]
        if not squeezed:
            frames[index] = replace(frame, sense="sway")
        for k in squeezed:
            frames[k] = replace(frames[k], posture="")


_THROWN = ("throw", "kick", "push")
_GIVES_WAY = (
    "topple", "fall", "knock_over", "tip_over", "collapse", "break", "flip", "sway", "leave",
    "spin", "slide", "roll", "slip", "dislodge",
)  # fmt: skip


def _aim_at_what_gives_way(frames: list[EventFrame]) -> None:
    """ "Is thrown at the clock, which falls": it is thrown against it, not only towards it."""
    for index, (frame, after) in enumerate(pairwise(frames)):
        aim = frame.place("at")
        if frame.sense not in _THROWN or frame.negated or aim is None or aim.kind != "object":
            continue
        whole = aim.members or (aim.name,)
        if after.patient == whole and after.sense in _GIVES_WAY and not after.negated:
            rows = tuple(("against", p) if r == "at" else (r, p) for r, p in frame.places)
            frames[index] = replace(frame, places=rows)  # type: ignore[arg-type]


def _back_to_a_side(frames: list[EventFrame]) -> None:
    """ "Rolls back to the right": that way, on wheels with its back first; where it came from,
    if it had gone or met something before, unless that had been the same way."""
    for index, frame in enumerate(frames):
        if "back" not in frame.manner:
            continue
        plain = replace(frame, manner=frame.manner - {"back"})
        told = [f for f in frames[:index] if {*frame.patient} & {*f.patient, *f.agent} and _acts(f)]
        ways = [f.direction for f in told if f.direction in OPPOSITE]
        met = bool(told) and (not ways or ways[-1] != frame.direction)
        if met or frame.sense == "bounce":
            turned = any(f.sense == "turn_around" for f in told) or frame.sense not in _GOES
            there = not turned and ways[-1:] == [OPPOSITE.get(frame.direction or "")]
            sense = "reverse" if there else frame.sense
            frames[index] = replace(plain, sense=sense, direction="backward")
        else:
            manner = plain.manner | ({"backwards"} if _wheeled(frame) else set())
            sense = "move" if frame.sense == "reverse" else frame.sense
            frames[index] = replace(plain, sense=sense, manner=manner)


OPPOSITE: dict[str, Way] = {"left": "right", "right": "left"}


def _acts(frame: EventFrame) -> bool:
    return frame.sense not in (*_GOES_NOWHERE, *AT_REST) and not frame.negated


def _wheeled(frame: EventFrame) -> bool:
    kinds = [kind_of(name) for name in frame.patient]
    return bool(kinds) and all(kind is not None and kind.wheels for kind in kinds)


def _backwards_at_first(frames: list[EventFrame]) -> None:
    """ "The car backs up": what has wheels and has not gone anywhere yet goes backwards."""
    went: set[str] = set()
    for index, frame in enumerate(frames):
        first = frame.sense == "reverse" and not went & {*frame.patient}
        if first and (frame.direction in _WAYS or frame.place("toward") is not None):
            # "Rolls back towards the camera": back is where it is said to go.
            frames[index] = replace(frame, sense="move")
        elif first and _wheeled(frame):
            way = frame.direction or "backward"
            manner = frame.manner | {"backwards"}
            frames[index] = replace(frame, sense="move", direction=way, manner=manner)
        went |= {*frame.patient} if frame.sense not in _GOES_NOWHERE else set()


_WAYS = ("away", "toward_camera")
_GOES_NOWHERE = ("be", "stay", "rest", "hang")
"""Senses of what goes nowhere."""


def _back_once_turned(frames: list[EventFrame]) -> None:
    """ "It turns around and drives back": where it came from, front first."""
    turned: set[str] = set()
    for index, frame in enumerate(frames):
        if frame.direction == "backward" and turned & {*frame.patient}:
            frames[index] = replace(frame, direction=None)
        turned |= {*frame.patient} if frame.sense == "turn_around" else set()


_OVER = ("topple", "fall", "knock_over", "tip_over")


def _passed_on(frames: list[EventFrame]) -> None:
    """ "The first domino is pushed and they fall one by one", "… and the rest follow": the first
    one falls over and brings the others down, each the next."""
    for index, (frame, after) in enumerate(pairwise(frames)):
        alone = len(frame.patient) == 1 and not (frame.agent or frame.negated or frame.places)
        started = alone and frame.sense in (*_OVER, "push")
        others = tuple(name for name in after.patient if name not in frame.patient)
        told = after.timing == "in_turn" if len(others) < len(after.patient) else after.sequel
        free = not (after.agent or after.negated or after.any_one or after.counted or after.places)
        if started and told and free and after.sense in _OVER and len(others) > 1:
            frames[index] = replace(frame, sense="topple")
            frames[index + 1] = replace(after, sense="topple", patient=others, agent=frame.patient)


def _but_not(frames: list[EventFrame]) -> None:
    """ "The dominoes fall, but not the last two": those that do are the others."""
    for index, (frame, after) in enumerate(pairwise(frames)):
        denied = after.negated and not frame.negated and after.sense == frame.sense
        fewer = set(after.patient) < set(frame.patient) and after.link == "then"
        if denied and fewer and not (frame.any_one or frame.counted or after.sequel):
            kept = tuple(name for name in frame.patient if name not in after.patient)
            frames[index] = replace(frame, patient=kept)


def _but_what_stays(frames: list[EventFrame]) -> None:
    """ "The stack is pushed: the top book slides off, while the others stay", "… and only the top
    book moves": the others are not pushed. What stays where it came to is."""
    for index, (before, frame) in enumerate(pairwise(frames)):
        if frame.any_one or frame.counted or frame.places or "there" in frame.manner:
            continue
        still = set(frame.patient) - set(before.patient if frame.rest else ())
        contrasts = frame.sense == "stay" and frame.link == "while"
        contrasts |= frame.sense == "move" and frame.negated
        alone = frame.only and frame.sense == "move" and frame.direction is None
        if alone and not frame.negated:
            still = set(before.patient) - set(frame.patient)
        elif not contrasts and not (frame.sense == "stay" and frame.posture == "still"):
            continue
        senses = _SHOVED if contrasts else ("push", "pull")
        for place, earlier in enumerate(frames[: index + 1]):
            kept = tuple(name for name in earlier.patient if name not in still)
            if earlier.sense in senses and not (earlier.negated or earlier.agent) and kept:
                frames[place] = replace(earlier, patient=kept)


def _struck_the_one(frames: list[EventFrame]) -> None:
    """ "The ball hits the tower, and only the top block falls": that is the one that it hits."""
    for index, (frame, after) in enumerate(pairwise(frames)):
        fewer = after.only and set(after.patient) < set(frame.patient)
        falls = after.sense in _OVER and not (after.agent or after.negated or after.counted)
        if frame.sense == "hit" and frame.agent and not frame.negated and fewer and falls:
            frames[index] = replace(frame, patient=after.patient, as_one=False)
