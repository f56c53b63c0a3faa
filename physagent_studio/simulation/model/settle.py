"""Overlaps at the start, which a reconstruction cannot avoid, must not throw anything.

A pair that starts out a hair inside one another is taken to touch at that depth: its contact
force begins where it began (`margin = −depth`, so that nothing moves and no energy is added). A
pair that starts deeper than that keeps the hair and comes apart slowly for the rest.

An elastic body that stands or sticks out from where it is held is seen bent by its own weight: its
first shape is taken to carry that already, so that it does not sag and sway before anything acts.
"""

from __future__ import annotations

import numpy as np

from physagent_studio.program import SceneObject, SceneState
from physagent_studio.program.scene.bodies import Plastic, Soft
from physagent_studio.program.scene.materials import combine, touch_of
from physagent_studio.records import Alarm
from physagent_studio.simulation.bodies.clouds import Cloud
from physagent_studio.simulation.bodies.contact_law import reference
from physagent_studio.simulation.mj import mj
from physagent_studio.simulation.model.model import Compiled

HAIR = 0.08
"""Overlap that is tolerated for good, as a share of the thinner body's smallest extent."""

HANGING = ("none", "top", "top_corners")
"""Pins under which an elastic body's weight is left to act: it lies or hangs, and may swing."""

SILENT = 0.001
"""Overlaps below this, m, are not worth an alarm."""


def settle(compiled: Compiled, scene: SceneState, dt: float) -> list[Alarm]:
    """Softens the pairs that overlap at first and lets elastic bodies carry their weight.

    The data must be freshly reset.
    """
    model, data = compiled.model, compiled.data
    mj.mj_forward(model, data)
    for item, handle in zip(scene.objects, compiled.handles, strict=True):
        if isinstance(handle, Cloud) and _stands(item):
            dofs = (handle.velocity[handle.free][:, None] + np.arange(3)).ravel()
            # At rest all that must be borne is the weight.
            data.qfrc_applied[dofs] = data.qfrc_bias[dofs]
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


def _stands(item: SceneObject) -> bool:
    """Whether it is held by a foot or a side and keeps its shape by its stiffness alone."""
    return isinstance(item.body, Soft | Plastic) and item.body.pinned not in HANGING


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
