"""`simulate`: a physical program in, a rollout out."""

import hashlib
from collections import OrderedDict
from collections.abc import Callable, Mapping
from threading import Lock
from types import MappingProxyType
from typing import TypeVar

import numpy as np

from physagent_studio.errors import SimulationError
from physagent_studio.program import PhysicalProgram
from physagent_studio.program.actions import FixObject
from physagent_studio.program.rotations import matrix_of
from physagent_studio.program.scene.aloft import hangs
from physagent_studio.program.scene.bodies import Rigid
from physagent_studio.program.scene.materials import density_of, touch_of
from physagent_studio.program.scene.state import MeshedSupport, Shape, Vessel
from physagent_studio.records import Alarm, Mesh, Rollout
from physagent_studio.simulation.actions.world import World
from physagent_studio.simulation.bodies.balance import balanced
from physagent_studio.simulation.bodies.clouds import Cloud
from physagent_studio.simulation.bodies.convex_parts import split
from physagent_studio.simulation.bodies.solids import Solid, solid_of
from physagent_studio.simulation.bodies.undercarriage import on_wheels
from physagent_studio.simulation.contacts.wheels import wheels_of
from physagent_studio.simulation.mj import mj
from physagent_studio.simulation.model.build import compile_model
from physagent_studio.simulation.model.collision import outlines, settle, substeps_for
from physagent_studio.simulation.model.model import Compiled, configure
from physagent_studio.simulation.model.parts import part_of
from physagent_studio.simulation.stepping.engine import run
from physagent_studio.simulation.stepping.measure import rollout_of, with_alarms, with_vertices
from physagent_studio.simulation.stepping.resume import first_effect, restore, setting_key
from physagent_studio.simulation.stepping.trace import Trace, new_trace
from physagent_studio.simulation.surfaces import FloatArray

K = TypeVar("K")
V = TypeVar("V")

CAPACITY = 16
"""Compiled models that are kept."""
NO_MESHES: Mapping[str, Mesh] = MappingProxyType({})


class Simulator:
    """Runs programs and keeps the last compiled models, so that an edit costs only the run.

    One run at a time; a second caller waits.
    """

    def __init__(self) -> None:
        self._models: OrderedDict[str, Compiled] = OrderedDict()
        self._solids: OrderedDict[str, Solid] = OrderedDict()
        self._digests: OrderedDict[tuple[int, int], tuple[tuple[np.ndarray, ...], str]] = (
            OrderedDict()
        )
        self._lock = Lock()

    def simulate(
        self,
        program: PhysicalProgram,
        meshes: Mapping[str, Mesh] = NO_MESHES,
        *,
        cancelled: Callable[[], bool] | None = None,
    ) -> Rollout:
        """Runs a program whose scene is resolved.

        meshes: visual mesh per object name, body frame; shapes that are no primitives collide as
        its convex hull, or as convex parts. The same program and meshes give the same bits.
        Raises SimulationError for a scene that cannot run and Cancelled when `cancelled` says
        so. A blow-up is no error: the rollout ends before it
        with a warning of kind `blow_up`.
        """
        return self._run(program, meshes, None, 0, cancelled)

    def resimulate(
        self,
        program: PhysicalProgram,
        meshes: Mapping[str, Mesh],
        previous: Rollout,
        from_step: int,
        *,
        cancelled: Callable[[], bool] | None = None,
    ) -> Rollout:
        """The rollout of an edited program, taking over what `previous` did before `from_step`.

        It starts from the last snapshot that no edit can have touched, even where `from_step` is
        later, and from the very start where more than actions was edited; so the result always
        has the same bits as `simulate(program, meshes)`.
        """
        return self._run(program, meshes, previous, from_step, cancelled)

    def outlines(
        self, program: PhysicalProgram, meshes: Mapping[str, Mesh]
    ) -> dict[str, tuple[Mesh, ...]]:
        """What the engine collides, by name; see `collision.outlines`."""
        _require_resolved(program)
        with self._lock:
            return outlines(program, self._compiled(program, meshes)[1])

    def prepared(
        self, program: PhysicalProgram, meshes: Mapping[str, Mesh]
    ) -> tuple[Compiled, World, Trace]:
        """The model with the program written into it, ready for its first step; for measuring."""
        _require_resolved(program)
        compiled = self._compiled(program, meshes)[1]
        return (compiled, *_prepare(program, compiled, meshes))

    def _run(
        self,
        program: PhysicalProgram,
        meshes: Mapping[str, Mesh],
        previous: Rollout | None,
        from_step: int,
        cancelled: Callable[[], bool] | None,
    ) -> Rollout:
        _require_resolved(program)
        with self._lock:
            key, compiled = self._compiled(program, meshes)
            world, trace = _prepare(program, compiled, meshes)
            setting = setting_key(program, key, trace.substeps)
            frame = 0
            if previous is not None and _fits(previous, setting, trace):
                frame = _frame(program, previous, from_step)
            step = 0
            if frame > 0 and previous is not None:
                step = restore(world, trace, previous, frame)
            run(world, trace, step, cancelled)
            rollout = with_vertices(world, trace, rollout_of(world, trace, setting))
            return with_alarms(world, rollout)

    def _solid(self, name: str, shape: Shape | MeshedSupport | None, mesh: Mesh | None) -> Solid:
        assert shape is not None
        key = f"{name}|{shape.model_dump_json()}|{self._digest(mesh)}"
        if key not in self._solids:
            self._solids[key] = solid_of(name, shape, mesh, split)
        return _recent(self._solids, key, 8 * CAPACITY)

    def _compiled(
        self, program: PhysicalProgram, meshes: Mapping[str, Mesh]
    ) -> tuple[str, Compiled]:
        """The structure of the scene: shapes, supports and who may be fixed; and its hash."""
        scene = program.scene
        # What breaks or gives way does so as it is drawn.
        colliding = {
            item.name: mesh.colliding if isinstance(item.body, Rigid) else mesh
            for item in scene.objects
            if (mesh := meshes.get(item.name)) is not None
        }
        solids = tuple(
            balanced(
                on_wheels(self._solid(item.name, item.shape, colliding.get(item.name)), item), item
            )
            for item in scene.objects
        )
        fixed = frozenset(a.name for a in program.event.actions if isinstance(a, FixObject))
        fixed |= {item.name for item in scene.objects if hangs(item)}
        parts = [mj.mj_versionString(), *sorted(fixed), "|"]
        parts += [f"floats {o.name}" for o in scene.objects if o.aloft == "floats"]
        for item, solid in zip(scene.objects, solids, strict=True):
            assert item.shape is not None
            shape = item.shape.model_dump_json()
            parts += [item.name, shape, self._digest(colliding.get(item.name))]
            parts += [repr(rim) for rim in solid.rims]
            parts += [f"balances {item.rotation}"] if item.balances else []
            if not isinstance(item.body, Rigid):
                # Nodes, grains and pieces are compiled where they start.
                kept = {"body", "position", "rotation", "material", "friction"}
                parts.append(item.model_dump_json(include=kept))
        meshed = {}
        for support in scene.supports:
            shape, mesh = support.shape, meshes.get(support.name)
            assert shape is not None
            parts += [support.name, shape.model_dump_json()]
            if isinstance(shape, MeshedSupport):
                parts.append(self._digest(mesh))
                meshed[support.name] = self._solid(support.name, shape, mesh)
            elif isinstance(shape, Vessel):
                meshed[support.name] = self._solid(support.name, shape.body, None)
        key = hashlib.sha256("\n".join(parts).encode()).hexdigest()
        if key not in self._models:
            self._models[key] = compile_model(scene, solids, meshed, fixed, meshes)
        return key, _recent(self._models, key, CAPACITY)

    def _digest(self, mesh: Mesh | None) -> str:
        """Content hash of a mesh's surface, remembered per pair of arrays."""
        if mesh is None:
            return ""
        key = (id(mesh.vertices), id(mesh.faces))
        if key not in self._digests:
            arrays = (mesh.vertices, mesh.faces)
            digest = hashlib.blake2b(digest_size=16)
            for part in map(np.ascontiguousarray, arrays):
                digest.update(str(part.shape).encode())
                digest.update(part.tobytes())
            # The arrays are kept as well: an id is only theirs while they are there.
            self._digests[key] = (arrays, digest.hexdigest())
        return _recent(self._digests, key, 64 * CAPACITY)[1]


def _recent(cache: OrderedDict[K, V], key: K, capacity: int) -> V:
    """Marks `key` as just used and drops what has not been used for longest."""
    cache.move_to_end(key)
    while len(cache) > capacity:
        cache.popitem(last=False)
    return cache[key]


def _require_resolved(program: PhysicalProgram) -> None:
    scene = program.scene
    open_fields = [
        *(f"scene.objects.{o.name}.shape" for o in scene.objects if o.shape is None),
        *(f"scene.objects.{o.name}.position" for o in scene.objects if o.position is None),
        *(f"scene.supports.{s.name}.shape" for s in scene.supports if s.shape is None),
    ]
    if open_fields:
        raise SimulationError(
            f"{', '.join(open_fields)} is open: reconstruct the scene or give it before simulating"
        )


def _prepare(
    program: PhysicalProgram, compiled: Compiled, meshes: Mapping[str, Mesh]
) -> tuple[World, Trace]:
    """Writes the program into the model and stands everything at its initial state."""
    scene, clip = program.scene, program.clip
    substeps = substeps_for(program, compiled.solids)
    dt = clip.step_seconds / substeps
    configure(compiled, program, dt)
    names = {item.name: index for index, item in enumerate(scene.objects)}
    things = (*scene.objects, *scene.supports)
    bodies = {item.name: index for index, item in enumerate(things)}
    parts = tuple(
        part_of(compiled, handle, density_of(item))
        for handle, item in zip(compiled.handles, scene.objects, strict=True)
    )
    skins = _skins(program, compiled, meshes)
    wheels = wheels_of(program, compiled, parts)
    world = World(program, compiled, parts, dt, names, bodies, skins, wheels)
    trace = new_trace(program, compiled, substeps)
    for solid in compiled.solids:
        if solid.note:
            trace.alarms.append(Alarm(0, "material", solid.note))
    trace.alarms += [*_lost(program), *settle(compiled, scene, dt)]
    return world, trace


def _skins(
    program: PhysicalProgram, compiled: Compiled, meshes: Mapping[str, Mesh]
) -> dict[str, FloatArray]:
    """World vertices of what is not rigid: of its mesh, else of its nodes."""
    found = {}
    for item, handle in zip(program.scene.objects, compiled.handles, strict=True):
        if isinstance(handle, Cloud):
            mesh = meshes.get(item.name)
            assert item.position is not None
            turn = matrix_of(item.rotation)
            points = handle.rest if mesh is None else mesh.vertices @ turn.T + item.position
            found[item.name] = points
    return found


def _lost(program: PhysicalProgram) -> list[Alarm]:
    """What a scene loses by what it mixes."""
    scene = program.scene
    elastic = [o.name for o in scene.objects if o.body.kind in ("soft", "plastic", "cloth", "rope")]
    alarms = []
    firm = [o for o in scene.objects if o.body.kind in ("rigid", "breakable")]
    if elastic and any(touch_of(o).restitution > 0.05 for o in firm):
        text = f"nothing bounces in this run: the integrator that {', '.join(elastic)} needs"
        alarms.append(Alarm(0, "material", f"{text} has no restitution"))
    for item in scene.objects:
        if item.body.kind == "liquid":
            text = f"{item.name} is a visual proxy of a liquid: frictionless spheres"
            alarms.append(Alarm(0, "material", text))
    return alarms


def _fits(previous: Rollout, setting: str, trace: Trace) -> bool:
    """Whether a run can be gone on from: of this setting, and stored by this version of ours."""
    if previous.setting != setting or previous.snapshots is None:
        return False
    return previous.snapshots.shape[1] == trace.snapshots.shape[1]


def _frame(program: PhysicalProgram, previous: Rollout, from_step: int) -> int:
    """The last frame of `previous` from which on `program` may run."""
    step = min(max(from_step, 0), first_effect(program, previous))
    return max(min(step // previous.steps_per_frame, len(previous.memories) - 1), 0)


def simulate(program: PhysicalProgram, meshes: Mapping[str, Mesh] = NO_MESHES) -> Rollout:
    """`Simulator.simulate` without anything kept between calls."""
    return Simulator().simulate(program, meshes)
