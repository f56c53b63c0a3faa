"""Grains, liquids and cut pieces: one object as many bodies with geoms."""

from dataclasses import dataclass
from itertools import combinations, product

import numpy as np

from physagent_studio.program import SceneObject
from physagent_studio.program.rotations import matrix_of, multiply
from physagent_studio.program.scene.bodies import Breakable, Granular, Liquid, Piece
from physagent_studio.program.scene.materials import touch_of
from physagent_studio.records import Mesh
from physagent_studio.simulation.bodies.clouds import Cloud
from physagent_studio.simulation.bodies.filling import packed, skin_points
from physagent_studio.simulation.bodies.solids import Solid
from physagent_studio.simulation.mj import Model, Spec, SpecGeom, mj
from physagent_studio.simulation.surfaces import FloatArray, hull

DENSITY = 1000.0
"""kg/m³ at which bodies are compiled."""

STICKY = 40.0
"""Times its own weight with which a grain of cohesion 1 holds to its neighbour."""


@dataclass(frozen=True, eq=False, slots=True)
class Swarm:
    """Many bodies of one object. geoms: their names. joined: (J, 2) pieces with a weld between."""

    name: str
    geoms: tuple[str, ...]
    places: FloatArray
    shares: FloatArray
    volume: float
    joined: np.ndarray


def add_grains(
    spec: Spec, item: SceneObject, body: Granular | Liquid, solid: Solid, mesh: Mesh | None
) -> Swarm:
    """Adds the spheres of a heap or a liquid; they slide and roll on one another."""
    assert item.shape is not None
    assert item.position is not None
    outer = hull(skin_points(item.shape, mesh, solid.extent), item.name)
    local, radii = packed(outer, body.grains)
    places = local @ matrix_of(item.rotation).T + item.position
    volume = solid.mass.volume
    shares = radii**3 / (radii**3).sum()
    names = []
    for number, (place, radius) in enumerate(zip(places, radii.tolist(), strict=True)):
        mass = float(shares[number]) * volume * DENSITY
        label = f"grain/{item.name}/{number}"
        part = spec.worldbody.add_body(name=label, pos=place.tolist())
        part.explicitinertial = True
        part.ipos = [0, 0, 0]
        part.mass = mass
        part.inertia = [0.4 * mass * radius**2] * 3
        for axis in np.eye(3):
            part.add_joint(type=mj.mjtJoint.mjJNT_SLIDE, axis=axis.tolist())
        geom = part.add_geom(name=label, type=mj.mjtGeom.mjGEOM_SPHERE, size=[radius, 0, 0])
        _grain_contact(geom, item, body, radius, mass)
        names.append(label)
    return Swarm(item.name, tuple(names), places, shares, volume, np.zeros((0, 2), np.int64))


def _grain_contact(
    geom: SpecGeom, item: SceneObject, body: Granular | Liquid, radius: float, mass: float
) -> None:
    geom.contype, geom.conaffinity = 6, 4
    geom.solref = [0.01, 1.0]
    if isinstance(body, Liquid):
        geom.condim = 1
        return
    geom.condim = 3
    geom.friction = [touch_of(item).friction, 0.005, 0.0001]
    if body.cohesion > 0:
        geom.adhesion = STICKY * body.cohesion * mass * 9.81
        geom.gap = 0.1 * radius


def add_pieces(
    spec: Spec, item: SceneObject, body: Breakable, solid: Solid, mesh: Mesh | None
) -> Swarm:
    """Adds the boxes of a breakable object and the welds between those that touch."""
    boxes = body.pieces or cut(solid.extent, body.cuts, solid.middle)
    pieces = boxes
    if not body.pieces:
        fits = fitted(boxes, mesh)
        boxes, pieces = (tuple(row) for row in zip(*fits, strict=True))
    volumes = np.array([float(np.prod(piece.size)) for piece in pieces])
    shares = volumes / volumes.sum()
    turn = matrix_of(item.rotation)
    assert item.position is not None
    names, places = [], []
    for number, piece in enumerate(pieces):
        label = f"piece/{item.name}/{number}"
        place = np.array(item.position) + turn @ np.array(piece.position)
        part = spec.worldbody.add_body(name=label, pos=place.tolist())
        part.quat = multiply(item.rotation, piece.rotation)
        part.add_freejoint(name=label)
        mass = float(shares[number]) * solid.mass.volume * DENSITY
        x, y, z = piece.size
        part.explicitinertial = True
        part.ipos = [0, 0, 0]
        part.mass = mass
        part.inertia = [
            mass * (y * y + z * z) / 12,
            mass * (x * x + z * z) / 12,
            mass * (x * x + y * y) / 12,
        ]
        half = [x / 2, y / 2, z / 2]
        kind = mj.mjtGeom.mjGEOM_BOX
        part.add_geom(name=label, type=kind, size=half, contype=0, conaffinity=2)
        names.append(label)
        places.append(place)
    joined = [pair for pair in combinations(range(len(pieces)), 2) if _touch(boxes, *pair)]
    for a, b in joined:
        _add_weld(spec, item.name, pieces, a, b)
    pairs = np.array(joined, np.int64).reshape(-1, 2)
    return Swarm(item.name, tuple(names), np.array(places), shares, solid.mass.volume, pairs)


def cut(extent: FloatArray, cuts: tuple[int, int, int], middle: FloatArray) -> tuple[Piece, ...]:
    """A bounding box (3,) about `middle`, body frame, cut into equal boxes."""
    size = extent / np.array(cuts)
    found = []
    for cell in product(*(range(count) for count in cuts)):
        x, y, z = ((np.array(cell) + 0.5) * size - extent / 2 + middle).tolist()
        wide, deep, high = size.tolist()
        found.append(Piece(position=(x, y, z), size=(wide, deep, high)))
    return tuple(found)


LEAST_FILLED = 0.15
"""Part of a box's face that the mesh covers, below which there is no piece."""
CELLS = 8
"""Cells along an edge by which that is told."""


def fitted(boxes: tuple[Piece, ...], mesh: Mesh | None) -> list[tuple[Piece, Piece]]:
    """Each box with one as large as what of the mesh is in it, and none where there is hardly any:
    a stool breaks into a seat and legs, and not into blocks that stand by themselves."""
    if mesh is None or not len(mesh.faces):
        return [(box, box) for box in boxes]
    points = _on_faces(mesh, min(min(box.size) for box in boxes) / CELLS)
    found = []
    for box in boxes:
        middle, half = np.array(box.position), np.array(box.size) / 2
        mine = points[(np.abs(points - middle) <= half + 1e-9).all(axis=1)]
        if not len(mine):
            continue
        cells = np.unique(
            ((mine - middle + half) / (2 * half) * (CELLS - 1e-6)).astype(int)[:, ::2], axis=0
        )
        if len(cells) < LEAST_FILLED * CELLS**2:
            continue
        low, high = mine.min(axis=0), mine.max(axis=0)
        size = np.maximum(high - low, 0.15 * np.array(box.size))
        (x, y, z), (wide, deep, tall) = ((low + high) / 2).tolist(), size.tolist()
        found.append((box, Piece(position=(x, y, z), size=(wide, deep, tall))))
    return _leaning(found) if len(found) > 1 else [(box, box) for box in boxes]


LEANS, THINNER = np.radians(9.0), 0.88
"""How far a middle piece is turned outwards within its box, rad, and how much it gives way to that.
Cut squarely, pieces would go on standing on each other when nothing joins them any more."""


def _leaning(fits: list[tuple[Piece, Piece]]) -> list[tuple[Piece, Piece]]:
    """The pieces between the lowest and the highest turned outwards about the body's y axis; seen
    is that only once they come loose."""
    heights = [box.position[2] for box, _ in fits]
    low, high = min(heights), max(heights)
    found = []
    for box, piece in fits:
        between = low + 1e-9 < box.position[2] < high - 1e-9
        if between:
            turn = LEANS / 2 if piece.position[0] >= 0 else -LEANS / 2
            wide, deep, tall = piece.size
            piece = piece.model_copy(
                update={
                    "size": (wide * THINNER, deep, tall * THINNER),
                    "rotation": (float(np.cos(turn)), 0.0, float(np.sin(turn)), 0.0),
                }
            )
        found.append((box, piece))
    return found


def _on_faces(mesh: Mesh, step: float) -> FloatArray:
    """(K, 3) points of a mesh's faces, hardly farther from each other than `step`, m."""
    a, b, c = (mesh.vertices[mesh.faces[:, i]] for i in range(3))
    longest = np.max([np.linalg.norm(v, axis=1) for v in (b - a, c - b, a - c)], axis=0)
    found = [mesh.vertices]
    parts = np.clip(np.ceil(longest / max(step, 1e-6)).astype(int), 1, 40)
    for count in np.unique(parts):
        mine = parts == count
        grid = [(i / count, j / count) for i in range(count + 1) for j in range(count + 1 - i)]
        u, v = np.array(grid).T[:, :, None, None]
        found.append((a[mine] + u * (b - a)[mine] + v * (c - a)[mine]).reshape(-1, 3))
    return np.concatenate(found)


def _touch(pieces: tuple[Piece, ...], a: int, b: int) -> bool:
    """Whether two boxes share a face, within 2 % of their size (by their bounding boxes)."""
    reach = []
    for piece in (pieces[a], pieces[b]):
        reach.append(np.abs(matrix_of(piece.rotation)) @ np.array(piece.size) / 2)
    away = np.abs(np.array(pieces[a].position) - np.array(pieces[b].position))
    gap = away - reach[0] - reach[1]
    slack = 0.02 * float(min(reach[0].max(), reach[1].max()))
    # A shared face: together along one axis, overlapping along the other two.
    return bool((gap <= slack).all() and (gap < -slack).sum() >= 2)


def _add_weld(spec: Spec, name: str, pieces: tuple[Piece, ...], a: int, b: int) -> None:
    one, other = pieces[a], pieces[b]
    away = np.array(other.position) - np.array(one.position)
    w, x, y, z = one.rotation
    relative = matrix_of(one.rotation).T @ away
    turn = multiply((w, -x, -y, -z), other.rotation)
    weld = spec.add_equality(
        name=f"joint/{name}/{a}-{b}",
        type=mj.mjtEq.mjEQ_WELD,
        objtype=mj.mjtObj.mjOBJ_BODY,
        name1=f"piece/{name}/{a}",
        name2=f"piece/{name}/{b}",
        solref=[0.004, 1],
        solimp=[0.99, 0.999, 0.001, 0.5, 2],
    )
    weld.data = [0, 0, 0, *relative, *turn, 1, 0]


def swarm_cloud(model: Model, item: SceneObject, swarm: Swarm) -> Cloud:
    """Where a compiled swarm keeps its bodies."""
    bodies = np.array([model.body(name).id for name in swarm.geoms])
    joints = model.body_jntadr[bodies]
    whole = item.body.kind == "breakable"
    names = [f"joint/{swarm.name}/{a}-{b}" for a, b in swarm.joined]
    return Cloud(
        bodies,
        model.jnt_qposadr[joints],
        model.jnt_dofadr[joints],
        swarm.places,
        swarm.shares,
        matrix_of(item.rotation),
        swarm.volume,
        whole=whole,
        joints=np.array([model.equality(name).id for name in names], np.int64),
        joined=swarm.joined,
    )
