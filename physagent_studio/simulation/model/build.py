"""A scene's structure → compiled MuJoCo model, through specs in memory and never files."""

from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np

from physagent_studio.errors import SimulationError
from physagent_studio.program import SceneObject, SceneState
from physagent_studio.program.scene.bodies import Breakable, Granular, Liquid
from physagent_studio.program.scene.state import Floor, MeshedSupport, Vessel, Wall
from physagent_studio.records import Mesh
from physagent_studio.simulation.bodies.clouds import Cloud
from physagent_studio.simulation.bodies.flexes import Flex, cloud_of, flex_of, mjcf
from physagent_studio.simulation.bodies.geoms import (
    add_piece,
    add_solid_support,
    add_support,
    is_flat,
)
from physagent_studio.simulation.bodies.grains import Swarm, add_grains, add_pieces, swarm_cloud
from physagent_studio.simulation.bodies.solids import Hull, Solid
from physagent_studio.simulation.mj import Data, Model, Spec, mj
from physagent_studio.simulation.model.clearances import Reach, reach_of
from physagent_studio.simulation.model.contact_view import ContactView
from physagent_studio.simulation.model.model import REFERENCE_DENSITY, Compiled, Handle
from physagent_studio.simulation.surfaces import FloatArray

MANY = 150
"""Grains from which on the conjugate gradient solver is faster."""


@dataclass(eq=False, slots=True)
class _Plan:
    """What goes into a spec: geoms of each body, and whether they meet in pairs or can break.

    rims: geoms that meet flat supports alone, and how wide their body is, m. edged: geoms that
    have edges; barrels: those that meet them alone.
    """

    geoms: list[list[str]] = field(default_factory=list)
    paired: list[bool] = field(default_factory=list)
    breaks: list[bool] = field(default_factory=list)
    rims: dict[str, float] = field(default_factory=dict)
    edged: set[str] = field(default_factory=set)
    barrels: set[str] = field(default_factory=set)
    flexes: dict[str, Flex] = field(default_factory=dict)
    swarms: dict[str, Swarm] = field(default_factory=dict)

    def add(self, names: list[str], paired: bool = True, breaks: bool = False) -> None:
        self.geoms.append(names)
        self.paired.append(paired)
        self.breaks.append(breaks)


def compile_model(
    scene: SceneState,
    solids: tuple[Solid, ...],
    support_solids: Mapping[str, Solid],
    fixed: frozenset[str],
    meshes: Mapping[str, Mesh],
) -> Compiled:
    """Compiles the structure of a scene.

    solids: per object. support_solids: of the supports that are meshes or vessels, by name. fixed:
    names of the objects that some action may hold in place.
    Raises SimulationError where MuJoCo refuses the scene.
    """
    plan = _Plan()
    for item, solid in zip(scene.objects, solids, strict=True):
        flex = flex_of(item, solid, meshes.get(item.name))
        if flex is not None:
            plan.flexes[item.name] = flex
    spec = mj.MjSpec.from_string(mjcf(plan.flexes.values())) if plan.flexes else mj.MjSpec()
    for item, solid in zip(scene.objects, solids, strict=True):
        _add_thing(spec, plan, item, solid, meshes.get(item.name), item.name in fixed)
    for support in scene.supports:
        assert support.shape is not None
        shape = support.shape
        if isinstance(shape, MeshedSupport | Vessel):
            plan.add(add_solid_support(spec, support.name, shape, support_solids[support.name]))
        else:
            plan.add(add_support(spec, support.name, shape))
        if not isinstance(shape, Floor | Wall):
            plan.edged |= set(plan.geoms[-1])
    pairs = _add_pairs(spec, plan, scene)
    _options(spec, plan)
    try:
        model = spec.compile()
    except ValueError as error:
        raise SimulationError(f"the scene cannot be turned into a physics model: {error}") from None
    return _compiled(model, scene, solids, plan, pairs)


def _add_thing(
    spec: Spec, plan: _Plan, item: SceneObject, solid: Solid, mesh: Mesh | None, fixed: bool
) -> None:
    """Adds an object as its body holds together; flexes are in the spec already."""
    match item.body:
        case Granular() | Liquid():
            swarm = add_grains(spec, item, item.body, solid, mesh)
        case Breakable():
            swarm = add_pieces(spec, item, item.body, solid, mesh)
        case _:
            names = []
            if item.name not in plan.flexes:
                names = _add_object(spec, item, solid, fixed)
                _sort(plan, solid, names)
            plan.add(names)
            return
    plan.swarms[item.name] = swarm
    breaks = isinstance(item.body, Breakable)
    plan.add(list(swarm.geoms), paired=breaks, breaks=breaks)


def _sort(plan: _Plan, solid: Solid, names: list[str]) -> None:
    """Notes which geoms of an object have edges, and which meet only some kinds of geoms."""
    pieces = dict(zip(names, solid.pieces, strict=False))
    plan.edged |= {
        n for n, piece in pieces.items() if isinstance(piece, Hull) or piece.kind == "box"
    }
    rims = names[len(pieces) : len(pieces) + len(solid.rims)]
    plan.rims |= dict.fromkeys(rims, float(solid.extent.max()))
    plan.barrels |= set(names[len(pieces) + len(rims) :])


def _options(spec: Spec, plan: _Plan) -> None:
    option = spec.option
    loose = [swarm for swarm in plan.swarms.values() if len(swarm.geoms) > MANY]
    if plan.flexes:
        # The integrator that is implicit in elastic forces; it has no restitution.
        option.integrator = mj.mjtIntegrator.mjINT_DISCRETE
    else:
        option.integrator = mj.mjtIntegrator.mjINT_IMPLICITFAST
    option.cone = mj.mjtCone.mjCONE_ELLIPTIC
    option.impratio = 10
    option.solver = mj.mjtSolver.mjSOL_NEWTON
    sheets = any('dim="2"' in flex.xml for flex in plan.flexes.values())
    if loose:
        option.solver = mj.mjtSolver.mjSOL_CG
        option.tolerance = 1e-6
    if loose and sheets:
        # A cloth that lies on something gains energy where the gradients stop short.
        option.tolerance, option.iterations = 1e-8, 300
    if loose or sheets:
        spec.memory = 2**29
    option.jacobian = mj.mjtJacobian.mjJAC_AUTO
    option.disableflags |= mj.mjtDisableBit.mjDSBL_AUTORESET
    spec.compiler.fusestatic = False
    spec.compiler.boundmass = 0
    spec.compiler.boundinertia = 0


def _add_object(spec: Spec, item: SceneObject, solid: Solid, fixed: bool) -> list[str]:
    name = item.name
    body = spec.worldbody.add_body(name=f"object/{name}")
    body.add_freejoint(name=f"object/{name}")
    body.gravcomp = float(item.aloft == "floats")
    body.explicitinertial = True
    body.mass = solid.mass.volume * REFERENCE_DENSITY
    body.ipos = solid.mass.centre
    body.fullinertia = _six(solid.mass.inertia * REFERENCE_DENSITY)
    names = []
    barrel = () if solid.barrel is None else (solid.barrel,)
    for number, piece in enumerate((*solid.pieces, *solid.rims, *barrel)):
        names.append(f"object/{name}/{number}")
        add_piece(spec, body, names[-1], piece)
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


def _add_pairs(spec: Spec, plan: _Plan, scene: SceneState) -> list[tuple[int, int, str]]:
    """Every two bodies that can touch, one pair per two geoms; supports do not move.

    The pieces of one object have pairs among themselves, which are off while it is whole.
    """
    found = []
    objects = len(scene.objects)
    shapes = [*(None for _ in scene.objects), *(item.shape for item in scene.supports)]
    pieces = {index for index in range(objects) if plan.breaks[index]}
    for a in range(objects):
        for b in range(a, len(plan.geoms)):
            if (a == b and a not in pieces) or not (plan.paired[a] and plan.paired[b]):
                continue
            for number, one in enumerate(plan.geoms[a]):
                width = plan.rims.get(one)
                if width is not None and not is_flat(shapes[b], width):
                    continue
                for other in plan.geoms[b][number + 1 if a == b else 0 :]:
                    if other in plan.rims or not _meet(plan, one, other):
                        continue
                    name = f"{one}|{other}"
                    spec.add_pair(name=name, geomname1=one, geomname2=other, condim=3)
                    found.append((a, b, name))
    return found


def _meet(plan: _Plan, one: str, other: str) -> bool:
    """Whether two geoms meet as far as barrels go."""
    if one in plan.barrels:
        return other in plan.edged
    return other not in plan.barrels or one in plan.edged


def _compiled(
    model: Model,
    scene: SceneState,
    solids: tuple[Solid, ...],
    plan: _Plan,
    pairs: list[tuple[int, int, str]],
) -> Compiled:
    geom_bodies = np.zeros(model.ngeom, np.int16)
    for index, names in enumerate(plan.geoms):
        for name in names:
            geom_bodies[model.geom(name).id] = index
    pair_bodies = np.zeros((model.npair, 2), np.int64)
    for a, b, name in pairs:
        pair_bodies[model.pair(name).id] = (a, b)
    flex_bodies = np.zeros(model.nflex, np.int16)
    for index, item in enumerate(scene.objects):
        if item.name in plan.flexes:
            flex = mj.mj_name2id(model, mj.mjtObj.mjOBJ_FLEX, f"flex/{item.name}")
            flex_bodies[flex] = index
    data, handles = mj.MjData(model), [_handle(model, item, plan) for item in scene.objects]
    return Compiled(
        model,
        data,
        tuple(handles),
        solids,
        geom_bodies,
        flex_bodies,
        pair_bodies,
        _pair_table(model),
        model.body_mass.copy(),
        model.body_inertia.copy(),
        ContactView(data),
        _reach(model, data, handles, geom_bodies),
    )


def _reach(
    model: Model, data: Data, handles: list[Handle | Cloud], geom_bodies: np.ndarray
) -> Reach | None:
    rigid = [handle for handle in handles if isinstance(handle, Handle)]
    if len(rigid) < len(handles):
        return None
    places = [(handle.position, handle.velocity) for handle in rigid]
    return reach_of(model, data, places, geom_bodies)


def _pair_table(model: Model) -> np.ndarray:
    table = np.full((model.ngeom, model.ngeom), -1, np.int32)
    index = np.arange(model.npair)
    table[model.pair_geom1, model.pair_geom2] = index
    table[model.pair_geom2, model.pair_geom1] = index
    return table


def _handle(model: Model, item: SceneObject, plan: _Plan) -> Handle | Cloud:
    name = item.name
    if name in plan.flexes:
        return cloud_of(model, item, plan.flexes[name].volume)
    if name in plan.swarms:
        return swarm_cloud(model, item, plan.swarms[name])
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
