"""Surfaces of revolution: solid ones cut into convex slices, hollow ones into wall segments."""

import math
from itertools import pairwise

import numpy as np

from physagent_studio.simulation.surfaces import (
    FloatArray,
    MassProperties,
    Surface,
    hull,
    mass_properties,
    revolve,
)

SECTORS = 16
"""Wall segments around a vessel."""

SLACK = 0.02
"""How far, as a share of the largest radius, an outline may be simplified."""


def rising(profile: FloatArray) -> FloatArray:
    """The outline (N, 2) of (z, radius) from bottom to top, each height once."""
    ordered = profile if profile[-1, 0] >= profile[0, 0] else profile[::-1]
    keep = np.concatenate([[True], np.diff(np.maximum.accumulate(ordered[:, 0])) > 1e-9])
    return ordered[keep]


def solid_slices(outline: FloatArray) -> list[Surface]:
    """Convex slices of the solid inside an outline, cut where it has a waist."""
    slack = SLACK * float(outline[:, 1].max())
    last = len(outline) - 1
    cuts = [0, *_waists(outline, 0, last, slack), last]
    parts = [outline[start : stop + 1] for start, stop in pairwise(cuts)]
    return [
        hull(revolve(part)[0], "surface of revolution")
        for part in parts
        if part[-1, 0] - part[0, 0] > 1e-6 and part[:, 1].max() > 1e-6
    ]


def _waists(outline: FloatArray, first: int, last: int, slack: float) -> list[int]:
    """Indices at which to cut so that the radius of each part is nearly concave in z."""
    if last - first < 2:
        return []
    z, r = outline[first : last + 1].T
    # Where the concave cover of the outline lies above it, the body has a waist.
    gap = _cover(z, r) - r
    deepest = int(np.argmax(gap[1:-1])) + 1
    if gap[deepest] <= slack:
        return []
    middle = first + deepest
    left = _waists(outline, first, middle, slack)
    return [*left, middle, *_waists(outline, middle, last, slack)]


def _cover(z: FloatArray, r: FloatArray) -> FloatArray:
    """Values at z of the least concave function above r (Andrew's monotone chain)."""
    chain: list[int] = []
    for index in range(len(z)):
        while len(chain) > 1:
            a, b = chain[-2], chain[-1]
            rise = (r[b] - r[a]) * (z[index] - z[a])
            if rise > (r[index] - r[a]) * (z[b] - z[a]):
                break
            chain.pop()
        chain.append(index)
    return np.interp(z, z[chain], r[chain])


def vessel(outline: FloatArray, wall: float) -> tuple[list[Surface], MassProperties]:
    """Convex pieces and exact mass properties of an open vessel with walls and bottom `wall`."""
    thick = min(wall, 0.9 * float(outline[-1, 0] - outline[0, 0]))
    inner = _inside(outline, thick)
    full = revolve(np.concatenate([outline, inner[::-1]]))
    simple = _simplified(outline, SLACK * float(outline[:, 1].max()))
    simple_inner = np.interp(simple[:, 0], inner[:, 0], inner[:, 1])
    pieces = [_bottom(outline, thick)]
    floor = float(outline[0, 0]) + thick
    for low, high in pairwise(range(len(simple))):
        if simple[high, 0] <= floor:
            continue
        bottom = max(float(simple[low, 0]), floor - thick / 2)
        radius = float(np.interp(bottom, simple[:, 0], simple[:, 1]))
        hollow = float(np.interp(max(bottom, floor), inner[:, 0], inner[:, 1]))
        ring = ((bottom, hollow, radius), (simple[high, 0], simple_inner[high], simple[high, 1]))
        pieces += [_segment(ring, number) for number in range(SECTORS)]
    return pieces, mass_properties(full)


def _inside(outline: FloatArray, thick: float) -> FloatArray:
    """The inner outline, from the vessel's floor to its rim."""
    floor = float(outline[0, 0]) + thick
    heights = np.concatenate([[floor], outline[outline[:, 0] > floor + 1e-9, 0]])
    radii = np.interp(heights, outline[:, 0], outline[:, 1]) - thick
    return np.column_stack([heights, np.maximum(radii, 1e-4)])


def _bottom(outline: FloatArray, thick: float) -> Surface:
    floor = float(outline[0, 0]) + thick
    below = outline[outline[:, 0] < floor]
    rim = [[floor, float(np.interp(floor, outline[:, 0], outline[:, 1]))]]
    return hull(revolve(np.concatenate([below, rim]))[0], "vessel bottom")


def _segment(ring: tuple[tuple[float, float, float], ...], number: int) -> Surface:
    """One convex piece of a ring given as two rows of (z, inner radius, outer radius)."""
    points = []
    for turn in (number, number + 1):
        angle = 2 * math.pi * turn / SECTORS
        for z, inner, outer in ring:
            # The inside of a sector is flat: it keeps the hollow's radius in its middle.
            radius = inner / math.cos(math.pi / SECTORS)
            for r in (min(radius, outer - 1e-5), outer):
                points.append([r * math.cos(angle), r * math.sin(angle), z])
    return hull(np.array(points), "vessel wall")


def _simplified(outline: FloatArray, slack: float) -> FloatArray:
    """The outline with points dropped that lie within `slack` (Douglas–Peucker)."""
    keep = {0, len(outline) - 1}
    todo = [(0, len(outline) - 1)]
    while todo:
        first, last = todo.pop()
        if last - first < 2:
            continue
        part = outline[first : last + 1]
        direction = (part[-1] - part[0]) / max(float(np.linalg.norm(part[-1] - part[0])), 1e-12)
        away = part - part[0]
        distance = np.abs(away[:, 0] * direction[1] - away[:, 1] * direction[0])
        farthest = int(np.argmax(distance))
        if distance[farthest] > slack:
            keep.add(first + farthest)
            todo += [(first, first + farthest), (first + farthest, last)]
    return outline[sorted(keep)]
