"""Measures of what touches, carries and lets go, and of coming to rest."""

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from physagent_studio.arrays import FloatArray
from physagent_studio.contract.facts import Facts
from physagent_studio.contract.places import (
    Place,
    distance_to,
    gap_to,
    line_progress,
    place_of,
)
from physagent_studio.contract.track import (
    Outcome,
    Track,
    Window,
    bounded,
    inside_depth,
    slowness,
    unmeasurable,
    worst,
)
from physagent_studio.contract.words import number
from physagent_studio.program import statements


def contacts(statement: statements.Contacts, facts: Facts, window: Window) -> Outcome:
    """Touching at any step; while it fails, minus the smallest gap of the surfaces."""
    if statement.other not in facts.rollout.bodies:
        return _reaches_place(statement.subject, statement.other, facts, window)
    touching = facts.touching(statement.subject, statement.other, window)
    if touching.any():
        step = window.first + int(touching.argmax())
        note = "from the start" if step == 0 else ""
        margin = _firmness(statement.subject, statement.other, facts, window)
        return Outcome(margin, 0.0, 0.0, "m", "", step, note)
    gaps = facts.gaps(statement.subject, statement.other, window)
    if gaps is None:
        return unmeasurable(f"where {statement.other} is has not been found")
    return _missed(statement.subject, gaps, facts, window)


def _missed(subject: str, gaps: FloatArray, facts: Facts, window: Window) -> Outcome:
    track = facts.track(subject, window)
    nearest = int(gaps.argmin())
    least = max(float(gaps[nearest]), 1e-4)
    scale = max(float(gaps[0]), track.outline.radius)
    frame = facts.rollout.frame_of(window.first + nearest)
    note = f"comes within {number(least, 'm')} at frame {frame}"
    return Outcome(bounded(-least / scale), -least, 0.0, "m", "", window.first + nearest, note)


def _reaches_place(subject: str, name: str, facts: Facts, window: Window) -> Outcome:
    """Touching a landmark: some part of the object comes to it."""
    place = place_of(name, facts, window.first)
    if not isinstance(place, Place):
        return unmeasurable(place)
    track = facts.track(subject, window)
    gaps = gap_to(place, track.placed)
    reached = track.first(gaps <= 0)
    if reached is None:
        return _missed(subject, gaps, facts, window)
    margin = bounded(-float(gaps.min()) / track.size)
    return Outcome(margin, 0.0, 0.0, "m", "", reached)


def _firmness(subject: str, other: str, facts: Facts, window: Window) -> float:
    """How firmly they touch, in (0, 1]: the push that a search against a contact must undo."""
    rows = facts.pair(subject, other)
    inside = (rows["step"] >= window.first) & (rows["step"] <= window.last)
    push = float(rows["impulse"][inside].sum())
    mass = float(facts.rollout.masses[facts.rollout.objects.index(subject)])
    return 0.02 + 0.98 * push / (push + mass) if push > 0 and mass > 0 else 0.02


def leaves(statement: statements.Leaves, facts: Facts, window: Window) -> Outcome:
    """Has touched, and at the end does so no more; while it fails, how far it has shifted."""
    touching = facts.touching(statement.subject, statement.other, window)
    track = facts.track(statement.subject, window)
    item = facts.program.scene.object(statement.subject)
    if item is not None and getattr(item.body, "pinned", "none") != "none":
        note = "it is held where it stands"
        return Outcome(-1.0, None, None, "", "", window.last, note, lasting=True)
    if not touching.any():
        gaps = facts.gaps(statement.subject, statement.other, window)
        away = max(float(gaps.min()), 0.0) if gaps is not None else track.size
        margin = -1.0 - bounded(away / max(track.size, 1e-3))
        note = f"it never touches {statement.other}"
        return Outcome(margin, None, None, "", "", window.last, note, lasting=True)
    last = int(np.nonzero(touching)[0][-1])
    settled = max(1, round(0.03 / facts.dt))
    gaps = facts.gaps(statement.subject, statement.other, window)
    free = gaps is None or not track.outline.exact or float(gaps[-1]) > track.clear
    if len(touching) - 1 - last >= settled and free:
        away = max(float(gaps[-1]), 0.0) if gaps is not None else 0.0
        margin = 0.02 + bounded(away / max(track.size, 1e-3))
        step = window.first + last + 1
        return Outcome(margin, away, 0.0, "m", "", step, lasting=True)
    shifted = _shift(track, statement.other, facts, window)
    margin = -max(0.02, 1.0 - shifted)
    note = "still touching at the end"
    return Outcome(margin, 0.0, 0.0, "m", "", window.last, note, lasting=True)


def _shift(track: Track, other: str, facts: Facts, window: Window) -> float:
    """How far it has moved over the other, in parts of what would bring it off, 0 … 1."""
    own = track.positions[-1] - track.positions[0]
    if facts.is_object(other):
        carrier = facts.track(other, window)
        own = own - (carrier.positions[-1] - carrier.positions[0])
        return min(
            1.0, float(np.linalg.norm(own)) / (track.outline.radius + carrier.outline.radius)
        )
    place = place_of(other, facts, window.first)
    travelled = float(np.linalg.norm(own))
    if not isinstance(place, Place) or place.solid is None or place.solid.outline is None:
        return min(1.0, travelled / (travelled + 1.0))
    reach = float(distance_from_edge(track.positions[:1], place)[0])
    left = float(distance_from_edge(track.positions[-1:], place)[0])
    return float(np.clip(1.0 - left / max(reach, track.size), 0.0, 1.0))


def distance_from_edge(points: FloatArray, place: Place) -> FloatArray:
    """(T,) how far inside the outline of a body seen from above, m; negative outside."""
    return inside_depth(points[:, :2], place.points[:, :2])


def _carrying(track: Track, other: str, facts: Facts) -> Outcome:
    """Carried by `other` at the end: it pushes up on it during the last tenth of a second."""
    window = track.window
    carried = facts.carried(track.name, other, window)
    recent = carried[-max(1, round(0.1 / facts.dt)) :]
    if recent.any():
        onset = _last_onset(carried, facts.dt)
        margin = 0.1 + 0.9 * float(recent.mean())
        return Outcome(margin, 0.0, 0.0, "m", "", window.first + onset, lasting=True)
    gaps = facts.gaps(track.name, other, window)
    if gaps is None:
        return unmeasurable(f"where {other} is has not been found")
    away = max(float(gaps[-1]), 1e-3)
    touching = facts.touching(track.name, other, window)[-1]
    note = f"{number(away, 'm')} from {other} at the end"
    note = f"touches {other} from the side" if touching else note
    margin = bounded(-away / max(float(gaps[0]), track.outline.radius))
    return Outcome(margin, -away, 0.0, "m", "", window.last, note, lasting=True)


def _last_onset(carried: NDArray[np.bool_], dt: float) -> int:
    """First row of the last stretch in which it is carried; gaps up to 0.1 s are bounces."""
    rows = np.nonzero(carried)[0]
    breaks = np.nonzero(np.diff(rows) * dt > 0.1)[0]
    return int(rows[breaks[-1] + 1]) if len(breaks) else int(rows[0])


def reaches(statement: statements.ReachesOn, facts: Facts, window: Window) -> Outcome:
    """Carried by `other` at the end, moving or not."""
    if statement.other not in facts.rollout.bodies:
        return _reaches_place(statement.subject, statement.other, facts, window)
    return _carrying(facts.track(statement.subject, window), statement.other, facts)


def rests_on(statement: statements.RestsOn, facts: Facts, window: Window) -> Outcome:
    """Carried by `other` and at rest, both at the end."""
    track = facts.track(statement.subject, window)
    if statement.other not in facts.rollout.bodies:
        return unmeasurable(f"{statement.other} is a place and carries nothing")
    return _both([_carrying(track, statement.other, facts), _stillness(track, statement.speed)])


def _stillness(track: Track, speed: float) -> Outcome:
    """At rest at the end, decided when it became slow for good."""
    final, bustle = track.final_bustle(), track.bustle
    fast = np.nonzero(bustle > speed)[0]
    step = track.window.first + (int(fast[-1]) + 1 if len(fast) else 0)
    step = min(step, track.window.last)
    margin = slowness(final, speed)
    claim = f"{track.name} ends at a speed of"
    note = "" if margin >= 0 else "still moving at the end"
    return Outcome(margin, final, speed, "m/s", "≤", step, note, claim=claim, lasting=True)


def _both(outcomes: list[Outcome]) -> Outcome:
    """The worst, or, where all hold, the worst decided when the last of them did."""
    least = worst(outcomes)
    if not least.holds:
        return least
    steps = [one.step for one in outcomes if one.step is not None]
    return replace(least, step=max(steps, default=None), lasting=True)


def _moved(track: Track) -> Outcome:
    """Has really moved: only what moves can stop."""
    away = np.linalg.norm(track.positions - track.positions[0], axis=-1)
    need = max(0.02, 0.1 * track.size)
    most = float(away.max())
    step = track.first(away >= need)
    step = track.window.last if step is None else step
    margin = bounded((most - need) / need)
    claim = f"{track.name}, before it stops, moves"
    return Outcome(margin, most, need, "m", "≥", step, claim=claim, lasting=True)


def stops(statement: statements.Stops, facts: Facts, window: Window) -> Outcome:
    """Has moved, is at rest at the end, and is near the named place."""
    track = facts.track(statement.subject, window)
    parts = [_stillness(track, statement.speed), _moved(track)]
    if statement.near is not None:
        place = place_of(statement.near, facts, window.last)
        if not isinstance(place, Place):
            return unmeasurable(place)
        away = float(_from_middle(place, track.positions[-1:])[0])
        scale = max(statement.distance, 1e-3)
        margin = bounded((statement.distance - away) / scale)
        claim = f"{track.name} ends away from {statement.near} by"
        limit, last = statement.distance, window.last
        parts.append(Outcome(margin, away, limit, "m", "≤", last, claim=claim, lasting=True))
    return _both(parts)


def _from_middle(place: Place, points: FloatArray) -> FloatArray:
    """Distance to a place as "near the centre of" means it: an area's middle, a body's surface."""
    if place.solid is None and place.kind in ("area", "opening"):
        off = points - place.centre
        return np.linalg.norm(off[:, :2] if place.lies else off, axis=-1)
    if place.solid is None and place.kind == "point":
        return np.linalg.norm((points - place.points[0])[:, :2], axis=-1)
    return distance_to(place, points)


def stops_before(statement: statements.StopsBefore, facts: Facts, window: Window) -> Outcome:
    """Has moved, is at rest at the end, and has not reached the place named."""
    track = facts.track(statement.subject, window)
    short = _not_reached(track, statement.before, facts)
    if not short.measurable:
        return short
    return _both([short, _stillness(track, statement.speed), _moved(track)])


def _not_reached(track: Track, name: str, facts: Facts) -> Outcome:
    """Never touches a body, never crosses a landmark; past it, minus how far it went on."""
    window = track.window
    if name in facts.rollout.bodies:
        touching = facts.touching(track.name, name, window)
        gaps = facts.gaps(track.name, name, window)
        if gaps is None:
            return unmeasurable(f"where {name} is has not been found")
        scale = max(float(gaps[0]), track.size)
        beyond = _gone_by(track, name, facts)
        reached = track.first(touching | (beyond > 0))
        left = min(float(gaps.min()), float(-beyond.max()))
        if reached is not None:
            went_on = np.diff(track.positions[reached - window.first :], axis=0)
            left = -max(float(np.linalg.norm(went_on, axis=-1).sum()), 1e-3)
    else:
        place = place_of(name, facts, window.first)
        if not isinstance(place, Place):
            return unmeasurable(place)
        ahead = _ahead(track, place)
        scale = max(float(ahead[0]), track.size)
        reached, left = track.first(ahead <= 0), float(ahead.min())
    step = window.last if reached is None else reached
    note = "" if reached is None else f"reaches {name} and goes on for {number(-left, 'm')}"
    margin = bounded(left / scale) if reached is None else min(bounded(left / scale), -1e-6)
    return Outcome(margin, left, 0.0, "m", "", step, note, lasting=True)


def _gone_by(track: Track, name: str, facts: Facts) -> FloatArray:
    """(W,) how far its centre is past that of a body, along the way that led there, m."""
    place = place_of(name, facts, track.window.first)
    if not isinstance(place, Place) or not len(place.points):
        return np.full(len(track.window), -np.inf)
    middle = replace(place, kind="point", points=place.centre[None])
    return line_progress(track.positions, middle)[0]


def _ahead(track: Track, place: Place) -> FloatArray:
    """(W,) way left until the landmark is reached by its nearest part, m."""
    if place.kind in ("line", "point"):
        reach = float(track.outline.size.min() / 2)
        progress, _ = line_progress(track.positions, place)
        return -progress - (reach if -progress[0] > reach else 0.0)
    return gap_to(place, track.placed)
