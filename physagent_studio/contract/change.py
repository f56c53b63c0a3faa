"""Measures of what changes shape, spreads, breaks or sways."""

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from physagent_studio.arrays import FloatArray
from physagent_studio.contract.facts import Facts
from physagent_studio.contract.track import Outcome, Track, Window, bounded, excess
from physagent_studio.contract.words import number
from physagent_studio.program.statements import Breaks, Deforms, Spreads, Sways

RIGID = "nothing deformable was simulated"
SAMPLES = 400
"""Vertices that are looked at; every n-th of a larger mesh."""


def _never(window: Window, reason: str) -> Outcome:
    """What is rigid does not do this; that it does not is then true."""
    return Outcome(-1.0, step=window.last, note=reason, lasting=True)


def _vertices(
    name: str, facts: Facts, window: Window
) -> tuple[FloatArray, NDArray[np.intp]] | None:
    """(F, V, 3) sampled vertices of the frames inside the window, and the steps (F,)."""
    given = dict(facts.rollout.vertices).get(name)
    if given is None or not len(given):
        return None
    steps = facts.rollout.frame_steps()[: len(given)]
    inside = np.nonzero((steps >= window.first) & (steps <= window.last))[0]
    stride = max(1, given.shape[1] // SAMPLES)
    values = given[inside][:, ::stride]
    good = np.isfinite(values).all(axis=(1, 2))
    if not good.any():
        return None
    return values[good], steps[inside][good].astype(np.intp)


def _peak(values: FloatArray, steps: NDArray[np.intp], threshold: float, unit: str) -> Outcome:
    best = float(values.max())
    over = np.nonzero(values >= threshold)[0]
    step = int(steps[over[0]] if len(over) else steps[values.argmax()])
    return Outcome(excess(best, threshold), best, threshold, unit, "≥", step)


def deforms(statement: Deforms, facts: Facts, window: Window) -> Outcome:
    """Greatest change of the distance between its points, in per cent of its size.

    Distances do not see where the object is or how it is turned. The 99th percentile keeps one
    stray vertex from deciding. Of what another thing runs into, the change from then on: that it
    sinks under its own weight is not what is told.
    """
    found = _vertices(statement.subject, facts, _once_hit(statement.subject, facts, window))
    if found is None:
        return _never(window, RIGID)
    vertices, steps = found
    count = vertices.shape[1]
    one = np.arange(count)
    pairs = np.concatenate([(one + count // k) % count for k in (2, 3, 5, 7)])
    apart = np.linalg.norm(vertices[:, np.tile(one, 4)] - vertices[:, pairs], axis=-1)
    size = max(float(np.ptp(vertices[0], axis=0).max()), 1e-6)
    strain = 100 * np.percentile(np.abs(apart - apart[0]), 99, axis=1) / size
    if statement.at_end:
        final, most = float(strain[-1]), 100 * statement.strain
        margin, step = excess(final, most), int(steps[-1])
        return Outcome(margin, final, most, "%", "≥", step, "at the end", lasting=True)
    return _peak(strain, steps, 100 * statement.strain, "%")


def _once_hit(name: str, facts: Facts, window: Window) -> Window:
    """The window from the frame before another thing first touches it; whole where none does."""
    hits: list[int] = []
    for other in facts.rollout.objects:
        if other != name and (touching := facts.touching(name, other, window)).any():
            hits.append(int(touching.argmax()))
    later = [hit for hit in hits if hit > 0]
    if not later:
        return window
    first = window.first + min(later) - facts.rollout.steps_per_frame
    return replace(window, first=max(first, window.first))


def spreads(statement: Spreads, facts: Facts, window: Window) -> Outcome:
    """Growth of its footprint: the area of the convex outline seen from above."""
    found = _vertices(statement.subject, facts, window)
    if found is None:
        return _never(window, RIGID)
    vertices, steps = found
    areas = np.array([_footprint(frame[:, :2]) for frame in vertices])
    factor = areas / max(float(areas[0]), 1e-9)
    # From 1 (no growth) to the factor asked for.
    best = float(factor.max())
    over = np.nonzero(factor >= statement.factor)[0]
    step = int(steps[over[0]] if len(over) else steps[factor.argmax()])
    margin = bounded((best - statement.factor) / max(statement.factor - 1.0, 0.05))
    return Outcome(margin, best, statement.factor, "×", "≥", step)


def _footprint(points: FloatArray) -> float:
    """Area of the convex hull of points (V, 2) by its width function (Cauchy), m²."""
    angles = np.pi * 2 * np.arange(64) / 64
    directions = np.stack([np.cos(angles), np.sin(angles)])
    corners = points[np.argmax(points @ directions, axis=0)]
    x, y = corners.T
    return float(0.5 * abs(np.sum(x * np.roll(y, -1) - y * np.roll(x, -1))))


def breaks(statement: Breaks, facts: Facts, window: Window) -> Outcome:
    """Number of its joints that let go."""
    item = facts.program.scene.object(statement.subject)
    if item is None or item.body.kind != "breakable":
        return _never(window, "nothing breakable was simulated")
    released = [
        one.step
        for one in facts.rollout.releases
        if one.name == statement.subject and window.first <= one.step <= window.last
    ]
    if released:
        count = len(released)
        return Outcome(float(count), float(count), 1.0, "joints", "≥", min(released))
    strongest = max((one for one in _blows(statement.subject, facts, window)), default=0.0)
    margin = max(-1.0, min(strongest / item.body.release_impulse - 1.0, -1e-3))
    note = f"its hardest blow was {strongest:.3g} N·s"
    return Outcome(margin, 0.0, 1.0, "joints", "≥", window.last, note)


def _blows(name: str, facts: Facts, window: Window) -> list[float]:
    """Normal impulse on the object summed over each step of the window, N·s."""
    rows, index = facts.rollout.contacts, facts.rollout.index(name)
    mine = rows[(rows["a"] == index) | (rows["b"] == index)]
    mine = mine[(mine["step"] >= window.first) & (mine["step"] <= window.last)]
    if not len(mine):
        return []
    sums = np.bincount(mine["step"] - window.first, weights=mine["impulse"])
    return [float(value) for value in sums]


def sways(statement: Sways, facts: Facts, window: Window) -> Outcome:
    """Full swings to and fro of at least the amplitude about the middle of its motion."""
    found = _vertices(statement.subject, facts, window)
    if found is not None:
        angle, steps = _lean_of_vertices(found[0]), found[1]
    else:
        angle, steps = (
            _lean(facts.track(statement.subject, window)),
            np.arange(window.first, window.last + 1),
        )
    swing = float(np.ptp(angle)) / 2 if len(angle) else 0.0
    if swing < statement.amplitude:
        margin = excess(swing, statement.amplitude) - 1e-3
        note = f"swings by ±{number(swing, '°')}"
        return Outcome(margin, swing, statement.amplitude, "°", "≥", int(steps[-1]), note)
    cycles, done = _cycles(angle, statement.amplitude, statement.cycles)
    margin = bounded((cycles - statement.cycles) / max(statement.cycles, 0.5))
    note = f"by ±{number(swing, '°')}"
    return Outcome(margin, cycles, statement.cycles, "swings", "≥", int(steps[done]), note)


def _lean(track: Track) -> FloatArray:
    """(W,) signed degrees of the up axis along the direction in which it leans most."""
    first = track.placed.matrices[0]
    up = first.T @ np.array([0.0, 0.0, 1.0])
    flat = (track.placed.matrices @ up)[:, :2]
    return np.degrees(np.arcsin(np.clip(_principal(flat), -1, 1)))


def _lean_of_vertices(vertices: FloatArray) -> FloatArray:
    """(F,) signed degrees by which the part that moves most leans, seen over the whole size."""
    shift = vertices - vertices[0]
    reach = np.linalg.norm(shift, axis=-1).max(axis=0)
    moving = np.argsort(reach)[-max(1, len(reach) // 10) :]
    size = max(float(np.ptp(vertices[0], axis=0).max()), 1e-6)
    return np.degrees(np.arctan(_principal(shift[:, moving].mean(axis=1)) / size))


def _principal(path: FloatArray) -> FloatArray:
    """(T,) coordinate along the main direction of a path (T, D), its middle at zero."""
    centred = path - (path.max(axis=0) + path.min(axis=0)) / 2
    if not np.any(centred):
        return np.zeros(len(path))
    direction = np.linalg.svd(centred - centred.mean(axis=0), full_matrices=False)[2][0]
    return centred @ direction


def _cycles(angle: FloatArray, amplitude: float, need: float) -> tuple[float, int]:
    """Full swings (to and fro is one) whose each way spans twice the amplitude, and the row at
    which `need` of them were done (else the last).
    """
    span, low, high = 2 * amplitude * 0.999, angle[0], angle[0]
    halves, rising, done = 0, None, len(angle) - 1
    for row, value in enumerate(angle):
        low, high = min(low, value), max(high, value)
        if rising is not True and value - low >= span:
            halves, rising, high = halves + 1, True, value
        elif rising is not False and high - value >= span:
            halves, rising, low = halves + 1, False, value
        else:
            continue
        if halves / 2 >= need and done == len(angle) - 1:
            done = row
    return halves / 2, done
