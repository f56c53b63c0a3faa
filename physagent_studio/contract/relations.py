"""Measures of how often, how far and to which side of another thing something gets."""

from dataclasses import replace

import numpy as np

from physagent_studio.arrays import BoolArray, FloatArray
from physagent_studio.contract.facts import Facts
from physagent_studio.contract.places import (
    Place,
    at_the_end,
    line_progress,
    place_of,
    reached_once,
)
from physagent_studio.contract.track import (
    Outcome,
    Track,
    Window,
    bounded,
    inside_depth,
    unmeasurable,
)
from physagent_studio.contract.words import number
from physagent_studio.program.statements import Bounces, Covers, SideOf

THROWN_BACK = 0.5
"""Seconds within which what bounces is free again; what stays longer has come to lie."""


def bounces(statement: Bounces, facts: Facts, window: Window) -> Outcome:
    """How often it comes from afar, touches the other body and gets as far away again."""
    if statement.other not in facts.rollout.bodies:
        return unmeasurable(f"{statement.other} is a place and nothing bounces off it")
    gaps = facts.gaps(statement.subject, statement.other, window)
    if gaps is None:
        return unmeasurable(f"where {statement.other} is has not been found")
    touching = facts.touching(statement.subject, statement.other, window)
    found, part = _rebounds(gaps, touching, statement.height, round(THROWN_BACK / facts.dt))
    times, count = statement.times, len(found)
    margin = bounded((count + part - times) / times)
    if count < times:
        note = f"{count} of {times}"
        return Outcome(min(margin, -1e-6), count, times, "", "", window.last, note)
    step = window.first + found[times - 1]
    return Outcome(max(margin, 0.02), count, times, "", "", step, f"{count} in all")


def _rebounds(
    gaps: FloatArray, touching: BoolArray, height: float, longest: int
) -> tuple[list[int], float]:
    """Rows at which it touches and is thrown back, and how much of the next rebound there is."""
    found: list[int] = []
    came, touched, part = False, -1, 0.0
    for row, (gap, touches) in enumerate(zip(gaps, touching, strict=True)):
        if touched >= 0 and row - touched > longest:
            touched, came = -1, False
        if touches:
            touched = row if came and touched < 0 else touched
        elif gap >= height:
            if touched >= 0:
                found.append(touched)
                part = 0.0
            came, touched = True, -1
        elif touched >= 0:
            part = max(part, min(float(gap) / height, 0.99))
    return found, part


def covers(statement: Covers, facts: Facts, window: Window) -> Outcome:
    """Which share of the way to a body or place it has covered when it is nearest to it."""
    track = facts.track(statement.subject, window)
    place = place_of(statement.other, facts, window.first)
    if not isinstance(place, Place):
        return unmeasurable(place)
    if place.solid is not None:
        left = facts.gaps(statement.subject, statement.other, window)
        left = np.zeros(len(window)) if left is None else left
    else:
        left = -line_progress(track.positions, _as_line(place))[0]
    way = float(left[0])
    if way < 0.1 * track.size:
        return unmeasurable(f"it is at {statement.other} from the start")
    share = 1.0 - left / way
    most = float(share.max())
    step = window.first + int(share.argmax())
    width = max(0.5 * (statement.high - statement.low), 0.05)
    short, over = (most - statement.low) / width, (statement.high - most) / width
    head = f"{track.name} covers a share of the way to {statement.other} of"
    limit, op = (statement.low, "≥") if short <= over else (statement.high, "≤")
    return Outcome(
        bounded(min(short, over)), most, limit, "", op, step, claim=head, lasting=True
    )  # fmt: skip


def _as_line(place: Place) -> Place:
    """Areas and openings count by their middle: the way there is what is asked for."""
    if place.kind in ("point", "line"):
        return place
    return replace(place, kind="point", points=place.centre[None])


def side_of(statement: SideOf, facts: Facts, window: Window) -> Outcome:
    """On that side of a body or place, and not far beside it; above and under over its outline."""
    track = facts.track(statement.subject, window)
    seen = window.last if statement.at_end else window.first
    place = place_of(statement.other, facts, seen)
    if not isinstance(place, Place):
        return unmeasurable(place)
    if place.solid is not None and place.solid.half_space is not None:
        return unmeasurable(f"{place.name} has no sides")
    fit = _fit(statement.side, track, place, facts)
    if statement.at_end:
        return at_the_end(track, fit, max(abs(float(fit[0])), track.size), "off")
    outcome = reached_once(track, fit, max(abs(float(fit[0])), track.size))
    away = number(max(-float(fit.max()), 0.0), "m")
    return outcome if outcome.holds else replace(outcome, note=f"{away} off")


def _fit(side: str, track: Track, place: Place, facts: Facts) -> FloatArray:
    """(W,) how far it is on that side, m; negative by what it lacks."""
    if side in ("above", "under"):
        return _over_or_under(side, track, place)
    if side == "beside":
        return _beside(track, place)
    away = _sight(facts, place)
    across = np.array([away[1], -away[0], 0.0])
    if side in ("left", "right"):
        return _past(track, place, across if side == "right" else -across)
    beyond = _past(track, place, away if side == "behind" else -away)
    return np.minimum(beyond, _abreast(track, place, across))


def _sight(facts: Facts, place: Place) -> FloatArray:
    """(3,) level unit vector from the camera to a place; straight ahead without a camera."""
    camera = facts.program.scene.camera
    way = place.centre - np.array(camera.position) if camera is not None else np.array([0, 1.0, 0])
    way[2] = 0.0
    length = float(np.linalg.norm(way))
    return way / length if length > 1e-9 else np.array([0.0, 1.0, 0.0])


def _past(track: Track, place: Place, way: FloatArray) -> FloatArray:
    """(W,) how far its centre is beyond the place along a level direction, m."""
    return track.positions @ way - float((place.points @ way).max())


def _abreast(track: Track, place: Place, across: FloatArray) -> FloatArray:
    """(W,) overlap of the two, seen along the line of sight, m."""
    reach = place.points @ across
    middle, half = float(reach.max() + reach.min()) / 2, float(np.ptp(reach)) / 2
    own = float(track.outline.size.mean()) / 2
    return half + own - np.abs(track.positions @ across - middle)


def _over_or_under(side: str, track: Track, place: Place) -> FloatArray:
    inside = inside_depth(track.positions[:, :2], place.points[:, :2])
    top = float(place.points[:, 2].max())
    if side == "above":
        return np.minimum(inside, track.positions[:, 2] - top)
    return np.minimum(inside, top - place.height - track.positions[:, 2])


def _beside(track: Track, place: Place) -> FloatArray:
    """(W,) its centre outside the outline, and no farther from it than the larger of the two."""
    outside = -inside_depth(track.positions[:, :2], place.points[:, :2])
    near = max(track.size, float(np.ptp(place.points[:, :2], axis=0).mean()))
    level = track.size + place.height - np.abs(track.positions[:, 2] - place.points[:, 2].max())
    return np.minimum.reduce([outside, near + track.size / 2 - outside, level])
