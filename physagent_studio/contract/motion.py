"""Measures of how an object moves and turns."""

import math

import numpy as np
from numpy.typing import NDArray

from physagent_studio.arrays import FloatArray
from physagent_studio.contract.facts import Facts
from physagent_studio.contract.places import Place, distance_to, place_of
from physagent_studio.contract.track import (
    Outcome,
    Track,
    Window,
    bounded,
    excess,
    shortfall,
    unmeasurable,
    worst,
)
from physagent_studio.contract.words import SIDES
from physagent_studio.program import statements
from physagent_studio.program.base import DIRECTIONS, Direction
from physagent_studio.program.rotations import matrices_of

BACK = 0.5
"""Own sizes that a thing goes one way and then back, from which on it is seen to turn back."""
WAY_M = 0.2
"""Of a large thing, m: no farther than this it has to have gone before it turns back."""
SIDE_DOWN = 60.0
"""Degrees from straight down, up to which a thing lies on a side of its own."""
KICK = 15.0
"""A turn of more than this many degrees within one step is an impact and not a bend."""


def moves(statement: statements.Moves, facts: Facts, window: Window) -> Outcome:
    """Greatest displacement since the window began, along the direction if one is given."""
    track = facts.track(statement.subject, window)
    travel = track.positions - track.positions[0]
    if statement.direction is not None:
        progress = travel @ np.array(DIRECTIONS[statement.direction])
    elif statement.toward is not None:
        place = place_of(statement.toward, facts, window.first)
        if not isinstance(place, Place):
            return unmeasurable(place)
        distance = distance_to(place, track.positions)
        progress = distance[0] - distance
    else:
        progress = np.linalg.norm(travel, axis=-1)
    return _peak(track, progress, statement.distance, "m")


def falls(statement: statements.Falls, facts: Facts, window: Window) -> Outcome:
    """Deepest drop of the centre of mass below its highest point so far."""
    track = facts.track(statement.subject, window)
    height = track.positions[:, 2]
    return _peak(track, np.maximum.accumulate(height) - height, statement.drop, "m")


def _peak(track: Track, values: FloatArray, threshold: float, unit: str) -> Outcome:
    """value ≥ threshold for the greatest of per-step values, decided when first reached."""
    best = float(values.max())
    step = track.first(values >= threshold)
    if step is None:
        step = track.window.first + int(values.argmax())
    return Outcome(excess(best, threshold), best, threshold, unit, "≥", step)


def stays(statement: statements.Stays, facts: Facts, window: Window) -> Outcome:
    """Greatest displacement and, but for a ball, greatest tilt, both since the window began."""
    track = facts.track(statement.subject, window)
    away = np.linalg.norm(track.positions - track.positions[0], axis=-1)
    tilt = track.tilt(since_start=True)
    outcomes = [_ceiling(track, away, statement.distance, "m", f"{track.name} moves")]
    if not track.outline.is_ball:
        outcomes.append(_ceiling(track, tilt, statement.tilt, "°", f"{track.name} tilts"))
    return worst(outcomes)


def _ceiling(track: Track, values: FloatArray, threshold: float, unit: str, claim: str) -> Outcome:
    """value ≤ threshold for all of the window, decided when first broken."""
    most = float(values.max())
    broken = track.first(values > threshold)
    step = track.window.last if broken is None else broken
    margin = shortfall(most, threshold)
    return Outcome(margin, most, threshold, unit, "≤", step, claim=claim, lasting=True)


def topples(statement: statements.Topples, facts: Facts, window: Window) -> Outcome:
    """Tilt at the end; while it has never been enough, the greatest tilt tells how near it was."""
    track = facts.track(statement.subject, window)
    if track.outline.is_ball:
        return Outcome(-1.0, 0.0, statement.tilt, "°", "≥", window.last, "a ball cannot topple")
    tilt, need = track.tilt(), statement.tilt
    final, most = float(tilt[-1]), float(tilt.max())
    if final >= need:
        # It topples when it passes the threshold for the last time.
        below = np.nonzero(tilt < need)[0]
        step = window.first + (int(below[-1]) + 1 if len(below) else 0)
        found = [Outcome(excess(final, need), final, need, "°", "≥", step, lasting=True)]
        if (most := statement.most) is not None:
            over = shortfall(final, most)
            found.append(Outcome(over, final, most, "°", "≤", step, lasting=True))
        if statement.onto is not None:
            found.append(_side_down(track, statement.onto, step))
        return worst(found)
    margin = excess(most, need) if most < need else -0.1 * (need - final) / max(need, 1e-3)
    note = "" if most < need else f"it tilted {most:.0f}° and came back"
    step = window.first + int(tilt.argmax())
    return Outcome(min(margin, -1e-6), final, need, "°", "≥", step, note, lasting=True)


def _side_down(track: Track, side: Direction, step: int) -> Outcome:
    """How far from straight down the side points at the end that faced that way at first."""
    turned = track.placed.matrices[-1] @ matrices_of(track.rest_rotation[None])[0].T
    off = math.degrees(math.acos(float(np.clip(-(turned @ DIRECTIONS[side])[2], -1, 1))))
    claim = f"{track.name} lies on the side that faced {SIDES[side]}, off by"
    return Outcome(
        shortfall(off, SIDE_DOWN), off, SIDE_DOWN, "°", "≤", step, claim=claim, lasting=True
    )


def upright(statement: statements.Upright, facts: Facts, window: Window) -> Outcome:
    """Tilt at the end of the window."""
    track = facts.track(statement.subject, window)
    final = float(track.tilt()[-1])
    note = "a ball has no upright side" if track.outline.is_ball else ""
    margin = shortfall(final, statement.tilt)
    return Outcome(margin, final, statement.tilt, "°", "≤", window.last, note, lasting=True)


def airborne(statement: statements.Airborne, facts: Facts, window: Window) -> Outcome:
    """Longest stretch visibly clear of everything; being held in the air is not flying."""
    free = ~facts.touching_anything(statement.subject, window)
    free &= ~facts.acted_on(statement.subject, ("FixObject",))[window.rows]
    if free.any():
        free &= facts.is_clear(statement.subject, window)
    best = run = 0
    best_end = 0
    reached: int | None = None
    for row, is_free in enumerate(free):
        run = run + 1 if is_free else 0
        if run > best:
            best, best_end = run, row
        if reached is None and run and (run - 1) * facts.dt >= statement.seconds:
            reached = row
    seconds = max(best - 1, 0) * facts.dt
    step = window.first + (best_end if reached is None else reached)
    margin = excess(seconds, statement.seconds)
    return Outcome(margin, seconds, statement.seconds, "s", "≥", step)


def rotates(statement: statements.Rotates, facts: Facts, window: Window) -> Outcome:
    """Turning in total; about an axis, in either sense, the net turn."""
    track = facts.track(statement.subject, window)
    turned = np.degrees(_cumulative(track.angular, track.dt))
    if statement.axis is not None:
        axis = np.array(statement.axis)
        length = float(np.linalg.norm(axis))
        if length < 1e-9:
            return unmeasurable("the axis is zero")
        return _peak(track, np.abs(turned @ (axis / length)), statement.angle, "°")
    # Summed over tenths of a second, so that the trembling of a resting body does not add up.
    stride = max(1, round(0.1 / track.dt))
    marks = np.unique(np.append(np.arange(0, len(turned), stride), len(turned) - 1))
    parts = np.linalg.norm(np.diff(turned[marks], axis=0), axis=-1)
    total = np.concatenate([[0.0], np.cumsum(np.where(parts > 0.5, parts, 0.0))])
    return _peak(track, np.interp(np.arange(len(turned)), marks, total), statement.angle, "°")


def _cumulative(rates: FloatArray, dt: float) -> FloatArray:
    """(W, 3) trapezoidal integral of per-step rates (W, 3), starting at zero."""
    steps = (rates[1:] + rates[:-1]) * dt / 2
    return np.concatenate([np.zeros((1, rates.shape[1])), np.cumsum(steps, axis=0)])


def flips(statement: statements.Flips, facts: Facts, window: Window) -> Outcome:
    """How far its up axis sweeps about a horizontal axis; rolling about its own axis is none.

    The sweep is the net turn about horizontal axes from any moment to any later one, so to and
    fro does not add up.
    """
    track = facts.track(statement.subject, window)
    if track.outline.is_ball:
        return Outcome(-1.0, 0.0, statement.angle, "°", "≥", window.last, "a ball cannot flip")
    rates = track.angular.copy()
    if track.outline.axis is not None:
        axes = track.placed.matrices @ np.array(track.outline.axis)
        rates -= np.sum(rates * axes, axis=-1, keepdims=True) * axes
    swept = np.degrees(_cumulative(rates, track.dt)[:, :2])
    if statement.direction is not None:
        dx, dy, _ = DIRECTIONS[statement.direction]
        # Tipping towards d turns about z × d.
        along = swept @ np.array([-dy, dx])
        return _peak(track, along - np.minimum.accumulate(along), statement.angle, "°")
    gaps = np.linalg.norm(swept[:, None] - swept[None, :], axis=-1)
    return _peak(track, np.tril(gaps).max(axis=1), statement.angle, "°")


def speed_between(statement: statements.SpeedBetween, facts: Facts, window: Window) -> Outcome:
    """Greatest speed of the centre of mass."""
    track = facts.track(statement.subject, window)
    parts = track.velocities[:, :2] if statement.level else track.velocities
    speed = np.linalg.norm(parts, axis=1)
    best = float(speed.max())
    step = window.first + int(speed.argmax())
    scale = max(statement.low, min(statement.high, 100.0) * 0.1, 0.1)
    fast = (best - statement.low) / scale
    slow = (statement.high - best) / scale
    claim = f"{track.name} has a top level speed of" if statement.level else ""
    if fast <= slow:
        return Outcome(fast, best, statement.low, "m/s", "≥", step, claim=claim, lasting=True)
    return Outcome(slow, best, statement.high, "m/s", "≤", step, claim=claim, lasting=True)


def descends_slowly(statement: statements.DescendsSlowly, facts: Facts, window: Window) -> Outcome:
    """Drop of the centre since its highest point, and greatest speed downwards."""
    track = facts.track(statement.subject, window)
    height = track.positions[:, 2]
    drop = _peak(track, np.maximum.accumulate(height) - height, statement.drop, "m")
    fastest = float((-track.velocities[:, 2]).max())
    slow = Outcome(
        shortfall(fastest, statement.speed),
        fastest,
        statement.speed,
        "m/s",
        "≤",
        window.first + int((-track.velocities[:, 2]).argmax()),
        claim=f"{track.name} comes down at",
        lasting=True,
    )
    return worst([drop, slow])


def path_bends(statement: statements.PathBends, facts: Facts, window: Window) -> Outcome:
    """How far the horizontal path turns to one side, knocks left out.

    Left and right are the mover's own, which is also how it looks in the picture, except for
    what comes towards the camera: there they are the picture's.
    """
    track = facts.track(statement.subject, window)
    flat = _smoothed(track.velocities[:, :2], 2)
    speed = np.linalg.norm(flat, axis=-1)
    moving = speed > max(0.05, 0.05 * float(speed.max()))
    heading = np.degrees(np.arctan2(flat[:, 1], flat[:, 0]))
    turn = (np.diff(heading) + 180) % 360 - 180
    turn[~(moving[1:] & moving[:-1]) | (np.abs(turn) > KICK)] = 0.0
    left = np.concatenate([[0.0], np.cumsum(turn)])
    if moving.any() and _comes_closer(flat[int(np.argmax(moving))]):
        left = -left
    to_left = left - np.minimum.accumulate(left)
    to_right = np.maximum.accumulate(left) - left
    sides = {"left": to_left, "right": to_right, "either": np.maximum(to_left, to_right)}
    return _peak(track, sides[statement.side], statement.angle, "°")


def _comes_closer(heading: FloatArray) -> bool:
    return bool(heading[1] < -abs(heading[0]))


def _smoothed(values: FloatArray, reach: int) -> FloatArray:
    """Moving average over 2 · reach + 1 rows."""
    if len(values) < 3:
        return values
    padded = np.pad(values, ((reach, reach), (0, 0)), mode="edge")
    sums = np.cumsum(np.pad(padded, ((1, 0), (0, 0))), axis=0)
    width = 2 * reach + 1
    return (sums[width:] - sums[:-width]) / width


def reverses(statement: statements.Reverses, facts: Facts, window: Window) -> Outcome:
    """Greatest angle between an earlier and a later horizontal heading, both really travelled: for
    half of its size, as less is not seen, or the earlier one as far as a way is asked for.

    With `times` more than one: how often it so turns against the heading it had taken since.
    """
    track = facts.track(statement.subject, window)
    stride = max(1, round(0.08 / track.dt))
    marks = np.arange(0, len(track.positions), stride)
    legs = np.diff(track.positions[marks, :2], axis=0)
    length = np.linalg.norm(legs, axis=-1)
    real = np.nonzero(length > max(0.004, 0.02 * float(length.max(initial=0.0))))[0]
    if len(real) < 2:
        return Outcome(-1.0, 0.0, statement.angle, "°", "≥", window.last)
    unit = legs[real] / length[real, None]
    if statement.times > 1:
        return _returns(unit, marks[real + 1], statement, window)
    angles = np.degrees(np.arccos(np.clip(unit @ unit.T, -1, 1)))
    far, along = BACK * track.size, track.positions[marks, :2] @ unit.T
    gone, here = np.arange(len(marks))[:, None] <= real, along[real, np.arange(len(real))]
    # How far it came along each heading until then, a rebound of a hair's breadth is no way, and
    # how far it goes on.
    come = along[real + 1, np.arange(len(real))] - np.where(gone, along, np.inf).min(axis=0)
    goes = np.where(gone, -np.inf, along).max(axis=0) - here
    angles = np.where((come >= min(far, WAY_M)) & (goes >= far)[:, None], np.tril(angles), 0.0)
    values = np.zeros(len(track.positions))
    values[marks[real + 1]] = angles.max(axis=1)
    return _peak(track, values, statement.angle, "°")


def _returns(
    headings: FloatArray, rows: NDArray[np.intp], statement: statements.Reverses, window: Window
) -> Outcome:
    """How often the heading (K, 2) turns by more than the angle since it last did."""
    found: list[int] = []
    widest, since = 0.0, 0
    for leg in range(1, len(headings)):
        turns = np.degrees(np.arccos(np.clip(headings[since:leg] @ headings[leg], -1, 1)))
        widest = max(widest, float(turns.max()))
        if widest >= statement.angle:
            found.append(int(rows[leg]))
            widest, since = 0.0, leg
    count, times = len(found), statement.times
    part = min(widest / max(statement.angle, 1.0), 0.99)
    margin = bounded((count + part - times) / times)
    step = window.first + (found[times - 1] if count >= times else int(rows[-1]))
    note = f"{count} of {times}" if count < times else f"{count} in all"
    margin = max(margin, 0.02) if count >= times else min(margin, -1e-6)
    return Outcome(margin, count, times, "", "", step, note)
