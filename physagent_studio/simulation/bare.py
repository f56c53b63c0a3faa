"""The engine alone, to measure what everything around it costs."""

from __future__ import annotations

import time
from collections.abc import Mapping

from physagent_studio.program import PhysicalProgram
from physagent_studio.records import Mesh
from physagent_studio.simulation.mj import mj
from physagent_studio.simulation.simulator import Simulator
from physagent_studio.simulation.trace import EXTRA, SNAPSHOT


def bare_seconds(
    simulator: Simulator, program: PhysicalProgram, meshes: Mapping[str, Mesh]
) -> float:
    """CPU seconds of `mj_step` alone over the same states as a run, one frame at a stretch.

    Every frame starts from the run's own snapshot, contact parameters included, and is stepped
    as a whole, without reading anything: the same work for the engine, none around it.
    """
    rollout = simulator.simulate(program, meshes)
    assert rollout.snapshots is not None
    compiled, world, trace = simulator.prepared(program, meshes)
    size = trace.engine_size
    count = trace.substeps * rollout.steps_per_frame
    total = 0.0
    for row in rollout.snapshots[:-1]:
        mj.mj_setState(compiled.model, world.data, row[:size], SNAPSHOT)
        trace.grip.restore(row[size + EXTRA :])
        started = time.process_time()
        mj.mj_step(compiled.model, world.data, nstep=count)
        total += time.process_time() - started
    return total
