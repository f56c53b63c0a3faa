"""`PhysicalProgram` → MuJoCo model, built in memory.

The structure (shapes, supports, who may be fixed) is compiled once and cached; everything else
(density, friction, restitution, gravity, time step, poses) is written into the compiled model
before each run, on the first run too, so that a cached model gives the same bits as a new one.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from physagent_studio.errors import SimulationError
from physagent_studio.program import PhysicalProgram, SceneState
from physagent_studio.program.rotations import about_up
from physagent_studio.program.scene import Floor, MeshedSupport, Ramp, Slab, Wall
from physagent_studio.simulation.clouds import Cloud
from physagent_studio.simulation.contact_law import (
    IMPEDANCE,
    combine,
    density_of,
    reference,
    touch_of,
)
from physagent_studio.simulation.mj import Data, Model, Spec, SpecBody, mj
from physagent_studio.simulation.solids import Hull, Piece, Solid
from physagent_studio.simulation.surfaces import FloatArray, hull, prism

MEETING = 0.3
"""m/s of approach from which on two bodies meet with an impact: closer pairs are listed."""

REFERENCE_DENSITY = 1000.0
"""kg/m³ at which bodies are compiled; their real density is written in afterwards."""

GEOM_TYPES = {
    "sphere": mj.mjtGeom.mjGEOM_SPHERE,
    "ellipsoid": mj.mjtGeom.mjGEOM_ELLIPSOID,
    "box": mj.mjtGeom.mjGEOM_BOX,
    "cylinder": mj.mjtGeom.mjGEOM_CYLINDER,
    "capsule": mj.mjtGeom.mjGEOM_CAPSULE,
}


@dataclass(frozen=True, slots=True)
class Handle:
    """Where a rigid object lives in the model.

    body: MuJoCo body id. position: address in `qpos`. velocity: address in `qvel`.
    weld, pin: ids of the equalities that hold it in place or by a point, or −1. anchor: mocap
    index, or −1.
    """

    body: int
    position: int
    velocity: int
    weld: int = -1
    pin: int = -1
    anchor: int = -1


@dataclass(frozen=True, eq=False, slots=True)
class Compiled:
    """A compiled structure and its maps; the model's numbers are rewritten by `configure`.

    handles, solids: per object. geom_bodies: (ngeom,) index among objects-then-supports of
    each geom. pair_bodies: (npair, 2) the same for each explicit contact pair.
    pair_table: (ngeom, ngeom) pair of two geoms, or −1.
    """

    model: Model
    data: Data
    handles: tuple[Handle | Cloud, ...]
    solids: tuple[Solid, ...]
    geom_bodies: np.ndarray
    pair_bodies: np.ndarray
    pair_table: np.ndarray
    base_mass: FloatArray
    base_inertia: FloatArray


def compile_model(
    scene: SceneState,
    solids: tuple[Solid, ...],
    support_solids: Mapping[str, Solid],
    fixed: frozenset[str],
) -> Compiled:
    """Compiles the structure of a scene.

    solids: per object. support_solids: of the supports that are meshes, by name. fixed: names
    of the objects that some action may hold in place.
    Raises SimulationError where MuJoCo refuses the scene.
    """
    spec = mj.MjSpec()
    _options(spec)
    geoms: list[list[str]] = []
    for item, solid in zip(scene.objects, solids, strict=True):
        geoms.append(_add_object(spec, item.name, solid, item.name in fixed))
    for support in scene.supports:
        assert support.shape is not None
        shape = support.shape
        if isinstance(shape, MeshedSupport):
            geoms.append(_add_mesh(spec, support.name, shape, support_solids[support.name]))
        else:
            geoms.append(_add_support(spec, support.name, shape))
    pairs = _add_pairs(spec, geoms, len(scene.objects))
    try:
        model = spec.compile()
    except ValueError as error:
        raise SimulationError(f"the scene cannot be turned into a physics model: {error}") from None
    return _compiled(model, scene, solids, geoms, pairs)


def _options(spec: Spec) -> None:
    option = spec.option
    option.integrator = mj.mjtIntegrator.mjINT_IMPLICITFAST
    option.cone = mj.mjtCone.mjCONE_ELLIPTIC
    option.impratio = 10
    option.solver = mj.mjtSolver.mjSOL_NEWTON
    option.jacobian = mj.mjtJacobian.mjJAC_AUTO
    option.disableflags |= mj.mjtDisableBit.mjDSBL_AUTORESET
    spec.compiler.fusestatic = False
    spec.compiler.boundmass = 0
    spec.compiler.boundinertia = 0


def _add_object(spec: Spec, name: str, solid: Solid, fixed: bool) -> list[str]:
    body = spec.worldbody.add_body(name=f"object/{name}")
    body.add_freejoint(name=f"object/{name}")
    body.explicitinertial = True
    body.mass = solid.mass.volume * REFERENCE_DENSITY
    body.ipos = solid.mass.centre
    body.fullinertia = _six(solid.mass.inertia * REFERENCE_DENSITY)
    names = []
    for number, piece in enumerate(solid.pieces):
        names.append(f"object/{name}/{number}")
        _add_piece(spec, body, names[-1], piece)
    if fixed:
        spec.worldbody.add_body(name=f"anchor/{name}", mocap=True)
        _add_holds(spec, name)
    return names


def _add_holds(spec: Spec, name: str) -> None:
    """A weld and a ball joint between an object and its anchor, both off until an action."""
    for label, kind in (("weld", mj.mjtEq.mjEQ_WELD), ("pin", mj.mjtEq.mjEQ_CONNECT)):
        hold = spec.add_equality(
            name=f"{label}/{name}",
            type=kind,
            objtype=mj.mjtObj.mjOBJ_BODY,
            name1=f"anchor/{name}",
            name2=f"object/{name}",
            active=False,
            solimp=[0.9999, 0.9999, 0.001, 0.5, 2],
        )
        if label == "weld":
            # Anchor point, relative pose (identity) and torque scale.
            hold.data = [0, 0, 0, 0, 0, 0, 1, 0, 0, 0, 1, 0]


def _six(inertia: FloatArray) -> list[float]:
    """MuJoCo's order of a symmetric matrix: xx, yy, zz, xy, xz, yz."""
    xx, yy, zz = np.diag(inertia)
    return [xx, yy, zz, inertia[0, 1], inertia[0, 2], inertia[1, 2]]


def _add_piece(spec: Spec, body: SpecBody, name: str, piece: Piece) -> None:
    # No geom collides on its own: every contact comes from an explicit pair with our rule.
    if isinstance(piece, Hull):
        spec.add_mesh(name=name, uservert=piece.vertices.ravel(), userface=piece.faces.ravel())
        body.add_geom(
            name=name, type=mj.mjtGeom.mjGEOM_MESH, meshname=name, contype=0, conaffinity=0
        )
        return
    body.add_geom(name=name, type=GEOM_TYPES[piece.kind], size=piece.size, contype=0, conaffinity=0)


def _add_support(spec: Spec, name: str, shape: Floor | Wall | Slab | Ramp) -> list[str]:
    label = f"support/{name}"
    body = spec.worldbody.add_body(name=label)
    plane = {"type": mj.mjtGeom.mjGEOM_PLANE, "size": [0, 0, 1]}
    match shape:
        case Floor(height=height):
            body.pos = [0, 0, height]
            body.add_geom(name=label, contype=0, conaffinity=0, **plane)
        case Wall(point=point, yaw=yaw):
            body.pos = point
            # Turns the plane's normal from +z to the horizontal direction `yaw`.
            half = math.sqrt(0.5)
            tilt = (half, 0.0, half, 0.0)
            body.quat = _product(about_up(yaw), tilt)
            body.add_geom(name=label, contype=0, conaffinity=0, **plane)
        case Slab(position=position, size=size, yaw=yaw):
            body.pos, body.quat = position, about_up(yaw)
            half_size = [edge / 2 for edge in size]
            kind = mj.mjtGeom.mjGEOM_BOX
            body.add_geom(name=label, type=kind, size=half_size, contype=0, conaffinity=0)
        case Ramp(toe=toe, yaw=yaw):
            body.pos, body.quat = toe, about_up(yaw)
            vertices, faces = hull(ramp_corners(shape), name)
            spec.add_mesh(name=label, uservert=vertices.ravel(), userface=faces.ravel())
            kind = mj.mjtGeom.mjGEOM_MESH
            body.add_geom(name=label, type=kind, meshname=label, contype=0, conaffinity=0)
    return [label]


def _add_mesh(spec: Spec, name: str, shape: MeshedSupport, solid: Solid) -> list[str]:
    body = spec.worldbody.add_body(name=f"support/{name}")
    body.pos, body.quat = shape.position, shape.rotation
    names = [f"support/{name}/{number}" for number in range(len(solid.pieces))]
    for label, piece in zip(names, solid.pieces, strict=True):
        _add_piece(spec, body, label, piece)
    return names


def ramp_corners(ramp: Ramp) -> FloatArray:
    """Corners (N, 3) of the solid under a ramp and its plateau, in the frame of its toe.

    It reaches below the toe, so that nothing meets a feather edge from inside.
    """
    depth = max(ramp.rise, 0.1)
    back = ramp.run + ramp.plateau
    outline = [(0.0, 0.0), (ramp.run, ramp.rise), (back, ramp.rise), (back, -depth), (0.0, -depth)]
    return prism(np.array(sorted(set(outline), key=outline.index)), ramp.width)


def _product(a: tuple[float, ...], b: tuple[float, ...]) -> list[float]:
    result = np.zeros(4)
    mj.mju_mulQuat(result, np.asarray(a), np.asarray(b))
    return result.tolist()


def _add_pairs(spec: Spec, geoms: list[list[str]], objects: int) -> list[tuple[int, int, str]]:
    """Every two bodies that can touch, one pair per two geoms; supports do not move."""
    found = []
    for a in range(objects):
        for b in range(a + 1, len(geoms)):
            for one in geoms[a]:
                for other in geoms[b]:
                    name = f"{one}|{other}"
                    spec.add_pair(name=name, geomname1=one, geomname2=other, condim=3)
                    found.append((a, b, name))
    return found


def _compiled(
    model: Model,
    scene: SceneState,
    solids: tuple[Solid, ...],
    geoms: list[list[str]],
    pairs: list[tuple[int, int, str]],
) -> Compiled:
    geom_bodies = np.zeros(model.ngeom, np.int16)
    for index, names in enumerate(geoms):
        for name in names:
            geom_bodies[model.geom(name).id] = index
    pair_bodies = np.zeros((model.npair, 2), np.int64)
    for a, b, name in pairs:
        pair_bodies[model.pair(name).id] = (a, b)
    return Compiled(
        model,
        mj.MjData(model),
        tuple(_handle(model, item.name) for item in scene.objects),
        solids,
        geom_bodies,
        pair_bodies,
        _pair_table(model),
        model.body_mass.copy(),
        model.body_inertia.copy(),
    )


def _pair_table(model: Model) -> np.ndarray:
    table = np.full((model.ngeom, model.ngeom), -1, np.int32)
    index = np.arange(model.npair)
    table[model.pair_geom1, model.pair_geom2] = index
    table[model.pair_geom2, model.pair_geom1] = index
    return table


def _handle(model: Model, name: str) -> Handle:
    joint = model.joint(f"object/{name}")
    equality = mj.mjtObj.mjOBJ_EQUALITY
    anchor = mj.mj_name2id(model, mj.mjtObj.mjOBJ_BODY, f"anchor/{name}")
    return Handle(
        int(joint.bodyid[0]),
        int(joint.qposadr[0]),
        int(joint.dofadr[0]),
        mj.mj_name2id(model, equality, f"weld/{name}"),
        mj.mj_name2id(model, equality, f"pin/{name}"),
        int(model.body_mocapid[anchor]) if anchor >= 0 else -1,
    )


def configure(compiled: Compiled, program: PhysicalProgram, dt: float) -> None:
    """Writes the numbers of `program` into the compiled model and resets its data."""
    model, data, scene = compiled.model, compiled.data, program.scene
    model.opt.timestep = dt
    model.opt.gravity[:] = scene.gravity
    for item, handle in zip(scene.objects, compiled.handles, strict=True):
        scale = density_of(item) / REFERENCE_DENSITY
        bodies = handle.body if isinstance(handle, Handle) else handle.bodies[handle.free]
        model.body_mass[bodies] = compiled.base_mass[bodies] * scale
        model.body_inertia[bodies] = compiled.base_inertia[bodies] * scale
        if isinstance(handle, Handle) and handle.weld >= 0:
            model.eq_solref[[handle.weld, handle.pin]] = (2 * dt, 1)
    _configure_pairs(compiled, scene, dt)
    mj.mj_resetData(model, data)
    for item, handle in zip(scene.objects, compiled.handles, strict=True):
        if isinstance(handle, Handle):
            data.qpos[handle.position : handle.position + 3] = item.position
            data.qpos[handle.position + 3 : handle.position + 7] = item.rotation
    # Inverse weights of contacts follow from masses.
    qpos = data.qpos.copy()
    mj.mj_setConst(model, data)
    mj.mj_resetData(model, data)
    data.qpos[:] = qpos


def _configure_pairs(compiled: Compiled, scene: SceneState, dt: float) -> None:
    model = compiled.model
    touches = [touch_of(item) for item in (*scene.objects, *scene.supports)]
    model.pair_solimp[:] = IMPEDANCE
    model.pair_margin[:] = 0
    model.pair_gap[:] = MEETING * dt
    for index, (a, b) in enumerate(compiled.pair_bodies.tolist()):
        touch = combine(touches[a], touches[b])
        model.pair_friction[index] = (touch.friction, touch.friction, 0.005, 1e-4, 1e-4)
        model.pair_solref[index] = reference(touch.restitution, dt)
