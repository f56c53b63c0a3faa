"""The engine alone, to measure what everything around it costs."""

import time
from collections.abc import Mapping

from physagent_studio.program import PhysicalProgram
from physagent_studio.records import Mesh
from physagent_studio.simulation.mj import mj
from physagent_studio.simulation.simulator import Simulator
from physagent_studio.simulation.stepping.trace import EXTRA, SNAPSHOT


def bare_seconds(
    simulator: Simulator, program: PhysicalProgram, meshes: Mapping[str, Mesh]
) -> float:
    """CPU seconds of plain calls of `mj_step` over the same states as a run, as many as it has.

    Every frame starts from the run's own snapshot, contact parameters included, and is stepped
    without reading anything, by the loop that anyone would write: the same work for the engine,
    none around it.
    """
    rollout = simulator.simulate(program, meshes)
    assert rollout.snapshots is not None
    compiled, world, trace = simulator.prepared(program, meshes)
    model, data, step = compiled.model, world.data, mj.mj_step
    size = trace.engine_size
    count = trace.substeps * rollout.steps_per_frame
    total = 0.0
    for row in rollout.snapshots[:-1]:
        mj.mj_setState(model, data, row[:size], SNAPSHOT)
        trace.grip.restore(row[size + EXTRA :])
        started = time.process_time()
        for _ in range(count):
            step(model, data)
        total += time.process_time() - started
    return total
