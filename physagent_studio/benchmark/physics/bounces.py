"""Physics bench: what is thrown about and lands as it may gains no energy in a bounce."""

from __future__ import annotations

import numpy as np

from physagent_studio.benchmark.physics.scenes import ground, program, thing
from physagent_studio.benchmark.rows import Row, at_most
from physagent_studio.program import PhysicalProgram
from physagent_studio.program.actions import SetAngularVelocity, SetVelocity
from physagent_studio.program.rotations import about_axis
from physagent_studio.program.scene.state import Box, Capsule, Cylinder, Ellipsoid, Shape
from physagent_studio.records import Rollout
from physagent_studio.simulation import Simulator

HEIGHT = 0.6
"""m above the floor."""

ELASTIC_STEPS = 6
"""Control steps for which a contact may hold energy that the books do not show."""

SHAPES: dict[str, Shape] = {
    "box": Box(size=(0.1, 0.15, 0.2)),
    "plate": Box(size=(0.2, 0.2, 0.02)),
    "can": Cylinder(radius=0.05, height=0.15),
    "disc": Cylinder(radius=0.1, height=0.03),
    "egg": Ellipsoid(radii=(0.12, 0.04, 0.04)),
    "pill": Capsule(radius=0.04, height=0.2),
}


def tumbling(shape: Shape, restitution: float, seed: int) -> PhysicalProgram:
    """A thing thrown and spun at random above a floor of the same restitution."""
    draw = np.random.default_rng(seed)
    x, y, z = draw.normal(size=3).tolist()
    turned = about_axis((x, y, z), float(draw.uniform(0, 3)))
    item = thing("it", shape, (0, 0, HEIGHT), rotation=turned, restitution=restitution)
    a, b, c = (5 * draw.normal(size=3)).tolist()
    actions = [
        SetVelocity(id="throw", name="it", velocity=(1, 0, 0)),
        SetAngularVelocity(id="spin", name="it", angular_velocity=(a, b, c)),
    ]
    return program([item], [ground(restitution=restitution)], actions, seconds=2.0)


def gained(rollout: Rollout) -> float:
    """Energy that appears over the level of the moment before, as a share of the first."""
    total = (rollout.kinetic + rollout.potential).sum(axis=1)[2:]
    before = np.lib.stride_tricks.sliding_window_view(total, ELASTIC_STEPS).max(axis=1)[:-1]
    start = rollout.kinetic[2].sum() + float(rollout.masses.sum()) * 9.81 * HEIGHT
    return float(np.maximum(total[ELASTIC_STEPS:] - before, 0).sum() / start)


def bounces() -> list[Row]:
    """Six shapes, two restitutions, four throws each; the worst of them."""
    simulator = Simulator()
    worst = max(
        gained(simulator.simulate(tumbling(shape, restitution, seed)))
        for shape in SHAPES.values()
        for restitution in (0.5, 0.7)
        for seed in range(4)
    )
    return [at_most("tumbling things, energy gained in 2 s of bounces", 100 * worst, 1.0, "%")]
