"""A compiled scene and the numbers that are written into it before each run.

The structure (shapes, supports, who may be fixed) is compiled once and cached; everything else
(density, friction, restitution, gravity, time step, poses) is written into the compiled model
before each run, on the first run too, so that a cached model gives the same bits as a new one.
"""

from dataclasses import dataclass

import numpy as np

from physagent_studio.program import PhysicalProgram, SceneState
from physagent_studio.program.scene.materials import combine, density_of, touch_of
from physagent_studio.simulation.bodies.balance import STEADYING_S
from physagent_studio.simulation.bodies.clouds import Cloud
from physagent_studio.simulation.bodies.contact_law import (
    IMPEDANCE,
    reference,
)
from physagent_studio.simulation.bodies.solids import Solid
from physagent_studio.simulation.mj import Data, Model, mj
from physagent_studio.simulation.model.clearances import Reach
from physagent_studio.simulation.model.contact_view import ContactView
from physagent_studio.simulation.surfaces import FloatArray

MEETING = 0.3
"""m/s of approach from which on two bodies meet with an impact: closer pairs are listed."""

REFERENCE_DENSITY = 1000.0
"""kg/m³ at which bodies are compiled; their real density is written in afterwards."""


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
    each geom, flex_bodies: (nflex,) of each flex. pair_bodies: (npair, 2) the same for each
    explicit contact pair. pair_table: (ngeom, ngeom) pair of two geoms, or −1. contacts: the
    engine's contact list. reach: bounds of distances, None where not everything is rigid.
    """

    model: Model
    data: Data
    handles: tuple[Handle | Cloud, ...]
    solids: tuple[Solid, ...]
    geom_bodies: np.ndarray
    flex_bodies: np.ndarray
    pair_bodies: np.ndarray
    pair_table: np.ndarray
    base_mass: FloatArray
    base_inertia: FloatArray
    contacts: ContactView
    reach: Reach | None


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
        if isinstance(handle, Handle):
            turning = slice(handle.velocity + 3, handle.velocity + 6)
            inertia = float(model.body_inertia[handle.body].min())
            model.dof_damping[turning] = inertia / STEADYING_S if item.balances else 0.0
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


ROUND = ("sphere", "ellipsoid", "cylinder", "capsule", "torus", "revolved")


def _rolling_radius(solid: Solid) -> float:
    """m; 0 for what does not roll by itself: the corners of a mesh cost it speed enough."""
    return float(np.median(solid.extent)) / 2 if solid.kind in ROUND else 0.0


def _configure_pairs(compiled: Compiled, scene: SceneState, dt: float) -> None:
    model = compiled.model
    touches = [touch_of(item) for item in (*scene.objects, *scene.supports)]
    radii = [_rolling_radius(solid) for solid in compiled.solids] + [0.0] * len(scene.supports)
    model.pair_solimp[:] = IMPEDANCE
    model.pair_margin[:] = 0
    model.pair_gap[:] = MEETING * dt
    # Bodies of many pieces have thousands of pairs, and all of two bodies are alike.
    ends, alike = np.unique(compiled.pair_bodies, axis=0, return_inverse=True)
    for number, (a, b) in enumerate(ends.tolist()):
        index = alike.reshape(-1) == number
        touch = combine(touches[a], touches[b])
        # The torque of rolling resistance is its force times the radius that rolls.
        lever = touch.rolling * min((r for r in (radii[a], radii[b]) if r > 0), default=0.0)
        model.pair_dim[index] = 6 if lever > 0 else 3
        model.pair_friction[index] = (touch.friction, touch.friction, lever, lever, lever)
        model.pair_solref[index] = reference(touch.restitution, dt)
