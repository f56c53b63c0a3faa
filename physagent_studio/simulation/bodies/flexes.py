"""Soft and plastic bodies, cloth and rope: MuJoCo flexes, written as MJCF in memory.

A flex lives below a body that does not move and has its first pose; its joints are displacements
along that body's axes. Soft and plastic bodies deform as a quadratic map of their bounding box (81
coordinates), which is fast and bends; cloth and rope have a node at every corner.
"""

import itertools
import math
from collections.abc import Iterable
from dataclasses import dataclass
from xml.sax.saxutils import quoteattr

import numpy as np

from physagent_studio.program import SceneObject
from physagent_studio.program.rotations import matrix_of, quaternion_of
from physagent_studio.program.scene.bodies import Cloth, Plastic, Rope, Soft
from physagent_studio.program.scene.materials import touch_of
from physagent_studio.records import Mesh
from physagent_studio.simulation.bodies.clouds import Cloud
from physagent_studio.simulation.bodies.filling import refined, skin_points
from physagent_studio.simulation.bodies.solids import Solid
from physagent_studio.simulation.mj import Model, mj
from physagent_studio.simulation.surfaces import FloatArray, hull

DENSITY = 1000.0
"""kg/m³ at which flexes are compiled."""

WORLD = {
    "bottom": (0.0, 0.0, -1.0),
    "top": (0.0, 0.0, 1.0),
    "left": (-1.0, 0.0, 0.0),
    "right": (1.0, 0.0, 0.0),
}


@dataclass(frozen=True, eq=False, slots=True)
class Flex:
    """A flex to be: its MJCF and the volume that weighs, m³."""

    name: str
    xml: str
    volume: float


def flex_of(item: SceneObject, solid: Solid, mesh: Mesh | None) -> Flex | None:
    """The flex of a soft, plastic, cloth or rope object; None for other kinds."""
    match item.body:
        case Soft() | Plastic():
            return _solid_flex(item, item.body, solid, mesh)
        case Cloth():
            return _cloth(item, item.body, solid)
        case Rope():
            return _rope(item, item.body, solid)
        case _:
            return None


def _solid_flex(item: SceneObject, body: Soft | Plastic, solid: Solid, mesh: Mesh | None) -> Flex:
    assert item.shape is not None
    surface = refined(hull(skin_points(item.shape, mesh, solid.extent), item.name))
    # Tetrahedra from the middle to every face fill a convex body.
    middle = len(surface[0])
    corners = np.concatenate([surface[0], surface[0].mean(0, keepdims=True)])
    tets = np.column_stack([np.full(len(surface[1]), middle), surface[1]])
    yields = f' yield="{body.yield_strain}"' if isinstance(body, Plastic) else ""
    inner = (
        f'<elasticity young="{body.young}" poisson="{body.poisson}"'
        f' damping="{body.damping}"{yields}/>'
    )
    inner += _pins(matrix_of(item.rotation), body.pinned, axes=3, last=2)
    spread = f'type="direct" dim="3" dof="quadratic" point="{_row(corners)}" element="{_row(tets)}"'
    volume = solid.mass.volume
    return Flex(
        item.name, _flexcomp(item, spread, inner, volume, matrix_of(item.rotation), 5e-4), volume
    )


def _cloth(item: SceneObject, body: Cloth, solid: Solid) -> Flex:
    frame = _frame(solid.extent)
    wide, high = (float(solid.extent @ np.abs(frame[:, axis])) for axis in (0, 1))
    count = body.cells + 1
    turn = matrix_of(item.rotation) @ frame
    inner = (
        f'<elasticity young="{body.young}" poisson="0.2" damping="{body.damping}"'
        f' thickness="{body.thickness}" elastic2d="both"/>'
    )
    inner += _pins(turn, body.pinned, axes=2, last=body.cells)
    spread = (
        f'type="grid" dim="2" count="{count} {count} 1"'
        f' spacing="{wide / body.cells} {high / body.cells} 1"'
    )
    volume = wide * high * body.thickness
    radius = body.thickness / 2
    return Flex(item.name, _flexcomp(item, spread, inner, volume, turn, radius), volume)


def _rope(item: SceneObject, body: Rope, solid: Solid) -> Flex:
    frame = _frame(solid.extent)
    length = float(solid.extent.max())
    turn = matrix_of(item.rotation) @ frame
    # An inextensible edge that MuJoCo holds to .02 % of its length.
    inner = '<edge equality="true" solref="0.005 1" solimp="0.999 0.9999 0.001"/>'
    inner += f'<elasticity young="{body.young}" poisson="0.3" damping="{body.damping}"/>'
    ends = _rope_pins(turn[:, 0], body.pinned, body.segments)
    inner += "".join(f'<pin id="{end}"/>' for end in ends)
    spread = f'type="grid" dim="1" count="{body.segments + 1} 1 1"'
    spread += f' spacing="{length / body.segments} 1 1"'
    volume = math.pi / 4 * body.thickness**2 * length
    radius = body.thickness / 2
    return Flex(item.name, _flexcomp(item, spread, inner, volume, turn, radius), volume)


def _flexcomp(
    item: SceneObject, spread: str, inner: str, volume: float, turn: FloatArray, radius: float
) -> str:
    assert item.position is not None
    friction = touch_of(item).friction
    # A rope over an edge hangs with all its weight on a node or two, and must not sink in for it.
    seconds = 0.005 if isinstance(item.body, Rope) else 0.01
    contact = (
        f'<contact selfcollide="none" contype="6" conaffinity="4" condim="3" solref="{seconds} 1"'
        f' solimp="0.95 0.99 0.001"'
        f' friction="{friction} 0.005 0.0001"/>'
    )
    return (
        f'<body name={quoteattr("frame/" + item.name)} pos="{_row(np.array(item.position))}"'
        f' quat="{_row(np.array(quaternion_of(turn)))}">'
        f"<flexcomp name={quoteattr('flex/' + item.name)} {spread} radius={quoteattr(str(radius))}"
        f' mass="{volume * DENSITY}">{inner}{contact}</flexcomp></body>'
    )


def _row(values: np.ndarray) -> str:
    return " ".join(repr(value) for value in values.ravel().tolist())


def _frame(extent: FloatArray) -> FloatArray:
    """(3, 3) body axes by falling extent, right-handed, as columns."""
    order = np.argsort(-extent, kind="stable")
    frame = np.eye(3)[:, order]
    frame[:, 2] *= np.linalg.det(frame)
    return frame


def _side(turn: FloatArray, where: str, axes: int) -> tuple[int, bool]:
    """The grid axis, and whether its far end, that points most to a world side."""
    along = turn[:, :axes].T @ np.array(WORLD[where])
    axis = int(np.argmax(np.abs(along)))
    return axis, bool(along[axis] > 0)


def _pins(turn: FloatArray, pinned: str, axes: int, last: int) -> str:
    """Pins of a grid whose nodes run from 0 to `last` along each of its axes."""
    if pinned == "none":
        return ""
    if pinned in ("all_corners", "top_corners"):
        ends = list(itertools.product((0, last), repeat=axes))
        if pinned == "top_corners":
            axis, far = _side(turn, "top", axes)
            ends = [end for end in ends if end[axis] == (last if far else 0)]
        return "".join(f'<pin grid="{_row(np.array(end))}"/>' for end in ends)
    axis, far = _side(turn, pinned, axes)
    low, high = [0] * axes, [last] * axes
    low[axis] = high[axis] = last if far else 0
    return f'<pin gridrange="{_row(np.array(low + high))}"/>'


def _rope_pins(direction: FloatArray, pinned: str, last: int) -> list[int]:
    if pinned == "none":
        return []
    if pinned == "both":
        return [0, last]
    return [last if direction @ np.array(WORLD[pinned]) > 0 else 0]


def mjcf(flexes: Iterable[Flex]) -> str:
    """The document that a model with flexes starts from."""
    bodies = "".join(flex.xml for flex in flexes)
    return f"<mujoco><worldbody>{bodies}</worldbody></mujoco>"


def cloud_of(model: Model, item: SceneObject, volume: float) -> Cloud:
    """Where a compiled flex keeps its nodes."""
    index = mj.mj_name2id(model, mj.mjtObj.mjOBJ_FLEX, f"flex/{item.name}")
    parent = model.body(f"frame/{item.name}").id
    if model.flex_nodenum[index]:
        start, count = model.flex_nodeadr[index], model.flex_nodenum[index]
        bodies = model.flex_nodebodyid[start : start + count].copy()
        local, line = model.flex_node[start : start + count], np.array([1.0, 4.0, 1.0]) / 6
        shares = np.einsum("i,j,k->ijk", line, line, line).ravel()
    else:
        start, count = model.flex_vertadr[index], model.flex_vertnum[index]
        bodies = model.flex_vertbodyid[start : start + count].copy()
        local, shares = model.flex_vert[start : start + count], np.full(count, 1 / count)
    free = bodies != parent
    joints = model.body_jntadr[bodies]
    axes = matrix_of(model.body_quat[parent].tolist())
    placed = np.where(free[:, None], model.body_pos[bodies], 0.0) + local
    shares = np.where(free, model.body_mass[bodies], shares * volume * DENSITY)
    return Cloud(
        bodies,
        np.where(free, model.jnt_qposadr[joints], -1),
        np.where(free, model.jnt_dofadr[joints], -1),
        model.body_pos[parent] + placed @ axes.T,
        shares / shares.sum(),
        matrix_of(item.rotation),
        volume,
        axes,
    )


NEIGHBOURS = 4
"""Nodes that carry a vertex."""


def skinned(cloud: Cloud, points: FloatArray, qpos: FloatArray, kind: str) -> FloatArray:
    """Vertices (F, V, 3) world, m, of the raw states (F, nq).

    points: (V, 3) m, the first places of the vertices in the world. kind: of the body.
    """
    places = cloud.places(qpos)
    if kind in ("soft", "plastic"):
        return np.einsum("vk,fkj->fvj", _quadratic(cloud, points), places)
    if kind == "breakable":
        return _pieces(cloud, points, places, cloud.turns(qpos))
    return _blended(cloud, points, places, turning=kind in ("cloth", "rope"))


def _quadratic(cloud: Cloud, points: FloatArray) -> FloatArray:
    """(V, 27) weights of a quadratic map of the nodes' box (Lagrange on 0, ½, 1)."""
    corner, far = cloud.rest[0], cloud.rest[26]
    size = (far - corner) @ cloud.axes
    share = np.clip(((points - corner) @ cloud.axes) / size, -0.2, 1.2)
    low = 2 * (share - 0.5) * (share - 1)
    middle = 4 * share * (1 - share)
    high = 2 * share * (share - 0.5)
    line = np.stack([low, middle, high], -1)
    weights = np.einsum("vi,vj,vk->vijk", line[:, 0], line[:, 1], line[:, 2])
    return weights.reshape(len(points), 27)


def _pieces(cloud: Cloud, points: FloatArray, places: FloatArray, turns: FloatArray) -> FloatArray:
    """Every vertex stays with the piece whose middle was nearest."""
    away = np.linalg.norm(points[:, None] - cloud.rest[None], axis=-1)
    owner = np.argmin(away, axis=1)
    first = turns[0, owner]
    local = np.einsum("vji,vj->vi", first, points - cloud.rest[owner])
    return places[:, owner] + np.einsum("fvij,vj->fvi", turns[:, owner], local)


def _blended(cloud: Cloud, points: FloatArray, places: FloatArray, turning: bool) -> FloatArray:
    """Every vertex follows its nearest nodes, and turns with them where the nodes are a sheet."""
    away = np.linalg.norm(points[:, None] - cloud.rest[None], axis=-1)
    count = min(NEIGHBOURS, len(cloud.rest))
    near = np.argsort(away, axis=1, kind="stable")[:, :count]
    weight = 1 / np.maximum(np.take_along_axis(away, near, 1), 1e-6) ** 2
    weight /= weight.sum(1, keepdims=True)
    offset = points[:, None] - cloud.rest[near]
    result = np.empty((len(places), len(points), 3))
    for frame, nodes in enumerate(places):
        moved = offset
        if turning:
            moved = np.einsum("vkij,vkj->vki", _turns(cloud, nodes)[near], offset)
        result[frame] = np.einsum("vk,vki->vi", weight, nodes[near] + moved)
    return result


def _turns(cloud: Cloud, nodes: FloatArray) -> FloatArray:
    """(K, 3, 3) rotation of the surroundings of each node since the start."""
    away = np.linalg.norm(cloud.rest[:, None] - cloud.rest[None], axis=-1)
    near = np.argsort(away, axis=1, kind="stable")[:, 1:9]
    first = cloud.rest[near] - cloud.rest[:, None]
    now = nodes[near] - nodes[:, None]
    moment = np.einsum("kni,knj->kij", now, first)
    size = np.einsum("kni,kni->k", first, first)
    u, _, vt = np.linalg.svd(moment + 1e-3 * size[:, None, None] * np.eye(3))
    sign = np.ones((len(nodes), 3))
    sign[:, 2] = np.sign(np.linalg.det(u @ vt))
    return (u * sign[:, None, :]) @ vt
