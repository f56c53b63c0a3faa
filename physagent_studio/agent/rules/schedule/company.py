"""What goes along with another thing: both are sent alike, so that they do not part."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from physagent_studio.agent.rules.scene.measures import Layout
from physagent_studio.agent.rules.schedule import actions as act
from physagent_studio.knowledge import kind_of
from physagent_studio.language import EventFrame, Reading
from physagent_studio.language.tokens.vocabulary import words_of
from physagent_studio.program.actions import Action, ApplyForce

_GOES = words_of("move slide roll drift accelerate push pull stop settle")

_ON_FOOT = ("run", "walk")


def ridden(reading: Reading) -> dict[str, str]:
    """ "The man on the skateboard glides to the right": who stands on which thing on wheels, as
    the words tell before anything of either is told."""
    found: dict[str, str] = {}
    told: set[str] = set()
    for frame in reading.frames:
        on = frame.place("on", "atop")
        kind = kind_of(on.name) if on is not None and on.kind == "object" else None
        goes = frame.sense in _GOES and frame.gait not in _ON_FOOT
        if on is not None and kind is not None and kind.wheels and goes:
            fresh = (n for n in frame.patient if not told & {n, on.name} and n != on.name)
            found |= dict.fromkeys(fresh, on.name)
        told |= {*frame.patient, *frame.agent}
    return found


def with_what_bears_it(reading: Reading, layout: Layout) -> Reading:
    """ "The man on the skateboard glides to the right", "the bottle on the tray is carried": what
    he stands on goes as well, where it has wheels or is carried; the reading with that said."""
    frames: list[EventFrame] = []
    for frame in reading.frames:
        plain = not (frame.negated or frame.agent or frame.any_one or frame.counted)
        off = frame.place("off", "from") is not None or frame.direction == "off"
        stays = off or frame.sense not in _GOES or frame.gait in _ON_FOOT
        below = _bearer(frame, reading, layout) if plain and not stays else None
        if below is not None:
            manner = frame.manner | {"along"}
            frame = replace(frame, patient=(*frame.patient, below), manner=manner)
        frames.append(frame)
    return replace(reading, frames=tuple(frames))


def _bearer(frame: EventFrame, reading: Reading, layout: Layout) -> str | None:
    """The thing that the one of a frame stands on and that goes with it, of which nothing else is
    told."""
    name = frame.patient[0] if len(frame.patient) == 1 else ""
    below = layout.carrier(name) if layout.has(name) else None
    if below is None or layout.state.object(below) is None or layout.rolls(name):
        return None
    on = frame.place("on", "atop", "in")
    kind = kind_of(below)
    goes = kind is not None and bool(kind.wheels)
    goes |= "carried" in frame.manner and on is not None and on.name == below
    told = any(below in (*f.patient, *f.agent) for f in reading.frames)
    return below if goes and not told else None


def leaders(reading: Reading, layout: Layout) -> dict[str, str]:
    """Of what goes along with another: with which one, that of which most is told, the lowest of
    equals; nothing of what is told something else."""
    found: dict[str, str] = {}
    for frame in reading.frames:
        row = [n for n in frame.patient if layout.has(n)] if "along" in frame.manner else []
        own = {n: [f for f in reading.frames if n in (*f.patient, *f.agent)] for n in row}
        row.sort(key=lambda n: (-len(own[n]), layout.position(n)[2]))
        for name in row[1:]:
            if all(any(f is one for one in own[row[0]]) for f in own[name]):
                found.setdefault(name, row[0])
    return found


def pushed_alike(
    actions: Sequence[Action], company: dict[str, str], layout: Layout
) -> list[Action]:
    """The pushes of those that go ahead, for each that goes along: as fast and as long."""
    return [
        action.model_copy(
            update={
                "id": f"{action.id[:40]}_{name}"[:64],
                "name": name,
                "point": act.foot_point(layout, name) if action.point is not None else None,
            }
        )
        for name, leader in company.items()
        for action in actions
        if action.name == leader and isinstance(action, ApplyForce)
    ]
