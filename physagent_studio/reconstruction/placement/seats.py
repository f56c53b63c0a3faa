"""Things that stand on a part of another that lies below its top: on a seat, before its back."""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from physagent_studio.program.scene.camera import Camera
from physagent_studio.program.scene.state import Inflated, SceneObject
from physagent_studio.reconstruction.camera.rays import on_plane, on_upright
from physagent_studio.reconstruction.photo.regions import BoolArray, bounds
from physagent_studio.reconstruction.shapes.primitives import Base
from physagent_studio.reconstruction.shapes.silhouettes import in_world
from physagent_studio.reconstruction.supports.stances import Stance
from physagent_studio.records.scene import Mesh


@dataclass(frozen=True, slots=True)
class SeatSettings:
    """When a thing stands on a seat, and where on it."""

    max_top_iou: float = 0.5  # IoU, 0.2..0.8: with its mask, on top of a thing, that is looked into
    min_gain: float = 0.2  # IoU, 0.05..0.5: with its mask, for which it stands elsewhere
    max_loss: float = 0.15  # IoU, 0..0.4: with its mask, that a carrier may lose for its seat
    # 0.05..0.5: of what is seen of its carrier, from below and from above, where no seat is
    ends_share: float = 0.15
    near_share: float = 0.25  # 0.05..0.5: of a seat's depth, before what stands on it
    front_share: float = 0.5  # 0.3..0.8: of a body's depth, from its front, where its seat is


SEAT = SeatSettings()


def seat_below(
    stance: Stance, camera: Camera, below: SceneObject, mesh: Mesh, mask: BoolArray
) -> float | None:
    """The share of a carrier's height at which the foot is seen on it; None for what has no seat.

    mask: of the carrier.
    """
    shape = below.shape
    if not isinstance(shape, Inflated) or shape.flat or shape.turn is not None:
        return None
    world = in_world(below, mesh)
    near, far = float(world[:, 1].min()), float(world[:, 1].max())
    spot = on_upright(camera, [stance.foot], near + SEAT.near_share * (far - near))[0]
    edge = camera.project(np.array([[spot[0], near, spot[2]]]))[0][0]
    _, top, _, foot = bounds(mask)
    share = (foot - float(edge[1])) / (foot - top)
    return share if SEAT.ends_share < share < 1 - SEAT.ends_share else None


def has_seat(item: SceneObject) -> bool:
    """Whether it has a level place to stand on below its top."""
    return isinstance(item.shape, Inflated) and item.shape.seat is not None


def base_on_seat(stance: Stance, camera: Camera, below: SceneObject, mesh: Mesh) -> Base:
    """Where the foot is seen on the seat, before its back."""
    world = in_world(below, bearing(below, mesh))
    low, high = world.min(0), world.max(0)
    y = float(on_plane(camera, [stance.foot], float(high[2]))[0, 1])
    nearest = float(low[1] + SEAT.near_share / 2 * (high[1] - low[1]))
    farthest = float(low[1] + SEAT.front_share * (high[1] - low[1]))
    y = min(max(y, nearest), farthest) if np.isfinite(y) else nearest
    x = float(on_upright(camera, [stance.foot], y)[0, 0])
    return Base(x, y, float(high[2]))


def bearing(item: SceneObject, mesh: Mesh) -> Mesh:
    """The mesh of what carries: of a thing with a seat what lies below that, else all of it."""
    if not has_seat(item):
        return mesh
    y, z = mesh.vertices[:, 1], mesh.vertices[:, 2]
    front = y < y.min() + SEAT.front_share * float(np.ptp(y))
    level = float(z[front].max())
    faces = mesh.faces[(z[mesh.faces] <= level + 1e-9).all(1)]
    used, own = np.unique(faces, return_inverse=True)
    return Mesh(mesh.vertices[used], own.reshape(-1, 3).astype(np.int32))


def bearers(
    done: Mapping[str, tuple[SceneObject, Mesh]],
) -> dict[str, tuple[SceneObject, Mesh]]:
    """Things in place, each with the mesh of what carries of it."""
    return {name: (item, bearing(item, mesh)) for name, (item, mesh) in done.items()}
