"""Overlaps at the start, which a reconstruction cannot avoid, must not throw anything.

A pair that starts out a hair inside one another is taken to touch at that depth: its contact
force begins where it began (`margin = −depth`, so that nothing moves and no energy is added). A
pair that starts deeper than that keeps the hair and comes apart slowly for the rest.
"""

from __future__ import annotations

import numpy as np

from physagent_studio.program import SceneState
from physagent_studio.records import Alarm
from physagent_studio.simulation.contact_law import combine, reference, touch_of
from physagent_studio.simulation.mj import mj
from physagent_studio.simulation.model import Compiled

HAIR = 0.08
"""Overlap that is tolerated for good, as a share of the thinner body's smallest extent."""

SILENT = 0.001
"""Overlaps below this, m, are not worth an alarm."""


def settle(compiled: Compiled, scene: SceneState, dt: float) -> list[Alarm]:
    """Softens the pairs that overlap in the initial state; the data must be freshly reset."""
    model, data = compiled.model, compiled.data
    mj.mj_forward(model, data)
    alarms = []
    things = (*scene.objects, *scene.supports)
    for (a, b), (depth, pairs) in sorted(_overlaps(compiled).items()):
        smallest = min(
            float(compiled.solids[index].extent.min())
            for index in (a, b)
            if index < len(scene.objects)
        )
        hair = min(depth, HAIR * smallest)
        restitution = combine(touch_of(things[a]), touch_of(things[b])).restitution
        for pair in pairs:
            model.pair_margin[pair] = -hair
            model.pair_gap[pair] += hair
            if depth > hair:
                model.pair_solref[pair] = reference(restitution, dt, depth - hair)
        if depth > SILENT:
            alarms.append(_alarm(things[a].name, things[b].name, depth, hair))
    return alarms


def _overlaps(compiled: Compiled) -> dict[tuple[int, int], tuple[float, list[int]]]:
    """Deepest overlap in m of each two bodies, and all contact pairs between them."""
    contact = compiled.data.contact
    geoms, distances = contact.geom, contact.dist
    paired = (geoms >= 0).all(axis=1)
    paired &= compiled.pair_table[geoms[:, 0], geoms[:, 1]] >= 0
    bodies = np.sort(compiled.geom_bodies[geoms[paired]], axis=1).tolist()
    depths: dict[tuple[int, int], float] = {}
    for (a, b), distance in zip(bodies, distances[paired].tolist(), strict=True):
        if a != b:
            depths[a, b] = max(depths.get((a, b), 0.0), -distance)
    members = compiled.pair_bodies.tolist()
    return {
        key: (depth, [n for n, pair in enumerate(members) if tuple(pair) == key])
        for key, depth in depths.items()
        if depth > 0
    }


def _alarm(a: str, b: str, depth: float, hair: float) -> Alarm:
    text = f"{a} and {b} overlap by {1000 * depth:.1f} mm in the initial state"
    if depth > hair:
        text += "; they come apart slowly"
    return Alarm(0, "penetration", text)
