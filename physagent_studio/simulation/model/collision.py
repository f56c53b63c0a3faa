"""What the engine collides, how bodies are settled before a run, and how finely it steps.

Overlaps at the start, which a reconstruction cannot avoid, must not throw anything. A pair that
starts out a hair inside one another is taken to touch at that depth: its contact force begins
where it began (`margin = −depth`, so that nothing moves and no energy is added). A pair that starts
deeper than that keeps the hair and comes apart slowly for the rest.

An elastic body that stands or sticks out from where it is held is seen bent by its own weight: its
first shape is taken to carry that already, so that it does not sag and sway before anything acts.
"""

import math

import numpy as np
from scipy.spatial import ConvexHull

from physagent_studio.program import PhysicalProgram, SceneObject, SceneState
from physagent_studio.program.preflight.mechanics import expected_speed
from physagent_studio.program.rotations import matrix_of
from physagent_studio.program.scene.bodies import Plastic, Soft
from physagent_studio.program.scene.materials import combine, density_of, touch_of
from physagent_studio.program.scene.stairs import treads_of
from physagent_studio.program.scene.state import MeshedSupport, Ramp, Slab, Vessel
from physagent_studio.records import Alarm, Mesh
from physagent_studio.simulation.bodies.clouds import Cloud
from physagent_studio.simulation.bodies.contact_law import reference
from physagent_studio.simulation.bodies.solids import Solid
from physagent_studio.simulation.mj import Model, mj
from physagent_studio.simulation.model.model import Compiled, Handle
from physagent_studio.simulation.surfaces import FloatArray

ROUND, RINGS = 24, 7
"""Corners of a circle, and rings from pole to pole, of the outline of a round geom."""


def outlines(program: PhysicalProgram, compiled: Compiled) -> dict[str, tuple[Mesh, ...]]:
    """Convex outlines by name: of rigid objects in the body frame, of supports in the world, m.

    Planes have none, being endless; what deforms collides as it is drawn.
    """
    scene, model = program.scene, compiled.model
    names = [item.name for item in (*scene.objects, *scene.supports)]
    found: dict[str, list[Mesh]] = {}
    for geom in range(model.ngeom):
        index = int(compiled.geom_bodies[geom])
        rigid = index >= len(scene.objects) or isinstance(compiled.handles[index], Handle)
        points = _points(model, geom) if rigid and index < len(names) else None
        if points is None:
            continue
        points = points @ matrix_of(model.geom_quat[geom].tolist()).T + model.geom_pos[geom]
        if index >= len(scene.objects):
            body = model.geom_bodyid[geom]
            points = points @ matrix_of(model.body_quat[body].tolist()).T + model.body_pos[body]
        found.setdefault(names[index], []).append(_hull(points))
    return {name: tuple(meshes) for name, meshes in found.items()}


def _points(model: Model, geom: int) -> FloatArray | None:
    """(P, 3) m, geom frame: points whose convex hull is the geom; None for what has none."""
    kinds, size = mj.mjtGeom, np.asarray(model.geom_size[geom], float)
    kind = model.geom_type[geom]
    if kind == kinds.mjGEOM_BOX:
        return np.array([(x, y, z) for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)]) * size
    if kind == kinds.mjGEOM_SPHERE:
        return _ball() * size[0]
    if kind == kinds.mjGEOM_ELLIPSOID:
        return _ball() * size
    if kind == kinds.mjGEOM_CAPSULE:
        ball, shift = _ball() * size[0], np.array([0, 0, size[1]])
        return np.concatenate([ball[ball[:, 2] >= 0] + shift, ball[ball[:, 2] <= 0] - shift])
    if kind == kinds.mjGEOM_CYLINDER:
        ring, shift = _ring() * size[0], np.array([0, 0, size[1]])
        return np.concatenate([ring + shift, ring - shift])
    if kind == kinds.mjGEOM_MESH:
        mesh = model.geom_dataid[geom]
        first, count = model.mesh_vertadr[mesh], model.mesh_vertnum[mesh]
        return np.asarray(model.mesh_vert[first : first + count], float)
    return None


def _ring() -> FloatArray:
    angle = np.arange(ROUND) * 2 * np.pi / ROUND
    return np.stack([np.cos(angle), np.sin(angle), np.zeros(ROUND)], axis=1)


def _ball() -> FloatArray:
    heights = np.cos(np.linspace(0, np.pi, RINGS + 2)[1:-1])
    rings = [_ring() * [np.sqrt(1 - z * z), np.sqrt(1 - z * z), 1] + [0, 0, z] for z in heights]
    return np.concatenate([*rings, np.array([[0, 0, 1.0], [0, 0, -1.0]])])


def _hull(points: FloatArray) -> Mesh:
    hull = ConvexHull(points)
    used, faces = np.unique(hull.simplices, return_inverse=True)
    return Mesh(points[used], faces.reshape(-1, 3).astype(np.int32))


SAFETY = 3.0
"""Engine steps that a body takes at least to cross another body and its own extent."""

MAX_SUBSTEPS = 1000

LOOSE = 0.4
"""Share of the clip's substeps in scenes with deformables or grains."""


def substeps_for(program: PhysicalProgram, solids: tuple[Solid, ...]) -> int:
    """Engine steps per control step: the clip's own number, or more where things are fast.

    dt ≤ (extent of the moving body + thickness of what it may hit) / (3 · its fastest speed).
    Half-spaces cannot be passed.
    """
    scene, clip = program.scene, program.clip
    least = clip.substeps
    if any(item.body.kind not in ("rigid", "breakable") for item in scene.objects):
        # Elastic forces are integrated implicitly; 2.5 ms are as good and cost less.
        least = max(1, round(LOOSE * clip.substeps))
    finest = clip.step_seconds / least
    sizes = [float(solid.extent.min()) for solid in solids]
    walls = [min(s.shape.size) for s in scene.supports if isinstance(s.shape, Slab | MeshedSupport)]
    slabs = [s.shape for s in scene.supports if isinstance(s.shape, Slab)]
    walls += [slab.rail for slab in slabs if slab.rail is not None]
    walls += [s.shape.body.wall or 0.0 for s in scene.supports if isinstance(s.shape, Vessel)]
    ramps = [s.shape for s in scene.supports if isinstance(s.shape, Ramp)]
    walls += [tread.top for ramp in ramps for tread in treads_of(ramp)[:1]]
    for index, item in enumerate(scene.objects):
        others = [*sizes[:index], *sizes[index + 1 :], *walls]
        if not others:
            continue
        mass = density_of(item) * solids[index].mass.volume
        speed = expected_speed(program, item, mass)
        finest = min(finest, (sizes[index] + min(others)) / (SAFETY * max(speed, 1e-6)))
    return min(max(least, math.ceil(clip.step_seconds / finest - 1e-9)), MAX_SUBSTEPS)


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
