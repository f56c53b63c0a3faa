"""Physics bench: what our stepping costs beside the bare engine."""

import gc
import time
from collections.abc import Callable
from functools import partial
from statistics import median

import numpy as np

from physagent_studio.benchmark.physics.scenes import ground, program, thing
from physagent_studio.benchmark.rows import Row, at_most
from physagent_studio.program import Directed, PhysicalProgram, SceneObject
from physagent_studio.program.actions import ApplyForce, SetVelocity
from physagent_studio.program.scene.state import Meshed
from physagent_studio.records import Mesh
from physagent_studio.simulation import Simulator
from physagent_studio.simulation.bare import bare_seconds
from physagent_studio.simulation.surfaces import ellipsoid_surface


def stones(count: int) -> tuple[PhysicalProgram, dict[str, Mesh]]:
    """A clip of mesh objects of 320 triangles that fall, roll and are pushed."""
    draw = np.random.default_rng(0)
    meshes: dict[str, Mesh] = {}
    items: list[SceneObject] = []
    for number in range(count):
        vertices, faces = ellipsoid_surface((0.06, 0.05, 0.045), 18)
        name = f"stone{number}"
        meshes[name] = Mesh(vertices * draw.uniform(0.95, 1.05, (len(vertices), 1)), faces)
        shape = Meshed(asset="0" * 16, size=(0.12, 0.1, 0.09))
        x, y = 0.3 * (number % 4), 0.3 * (number // 4)
        items.append(thing(name, shape, (x, y, 0.3), restitution=0.3))
    push = Directed(magnitude=1, direction="right", quantity="target_speed")
    actions = [
        SetVelocity(id="throw", name="stone0", velocity=(0.5, 0, 1)),
        ApplyForce(id="push", name="stone1", force=push, start_step=100, duration=40),
    ]
    return program(items, [ground(restitution=0.3)], actions), meshes


def _cpu(work: Callable[[], object]) -> float:
    gc.collect()
    started = time.process_time()
    work()
    return time.process_time() - started


def overhead() -> list[Row]:
    """CPU time of a run over that of bare `mj_step` on the same states, interleaved."""
    rows = []
    for count in (3, 10):
        clip, meshes = stones(count)
        simulator = Simulator()
        simulator.simulate(clip, meshes)
        ratios = []
        for _ in range(7):
            bare = bare_seconds(simulator, clip, meshes)
            ratios.append(_cpu(partial(simulator.simulate, clip, meshes)) / bare)
        rows.append(
            at_most(f"cost over bare mj_step, {count} mesh objects", median(ratios), 1.10, "×")
        )
    return rows


def rerun() -> list[Row]:
    """Running again after an edit at 60 % of the clip: the same bits, in less time."""
    clip, meshes = stones(3)
    edit = SetVelocity(id="late", name="stone2", velocity=(0, 1, 1), start_step=192)
    event = clip.event.model_copy(update={"actions": (*clip.event.actions, edit)})
    edited = clip.model_copy(update={"event": event})
    simulator = Simulator()
    before = simulator.simulate(clip, meshes)
    full, tail, same = [], [], True
    for _ in range(7):
        whole = simulator.simulate(edited, meshes)
        full.append(_cpu(lambda: simulator.simulate(edited, meshes)))
        again = simulator.resimulate(edited, meshes, before, 192)
        tail.append(_cpu(lambda: simulator.resimulate(edited, meshes, before, 192)))
        same &= np.array_equal(whole.positions, again.positions)
        same &= np.array_equal(whole.contacts, again.contacts)
    share = median(tail) / median(full)
    return [
        at_most("re-simulation after an edit at 60 %, different bits", 0 if same else 1, 0),
        at_most("re-simulation after an edit at 60 %, share of a full run", share, 0.55, "×"),
    ]


def cold() -> list[Row]:
    """Compile and run ten mesh objects with nothing cached."""
    clip, meshes = stones(10)
    Simulator().simulate(clip, meshes)
    seconds = median(_cpu(lambda: Simulator().simulate(clip, meshes)) for _ in range(3))
    return [at_most("compile and simulate 10 mesh objects, CPU", seconds, 0.3, "s")]
