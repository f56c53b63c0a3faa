"""What stands on a pair of rails: over both of them, as low as they let it."""

import math

import numpy as np

from physagent_studio.program.scene.state import SceneObject, Slab
from physagent_studio.reconstruction.camera.rays import RAY
from physagent_studio.reconstruction.shapes.contact import vertical_gap
from physagent_studio.reconstruction.shapes.meshes import support_mesh
from physagent_studio.reconstruction.shapes.silhouettes import in_world
from physagent_studio.records.scene import Mesh


def standing(item: SceneObject, mesh: Mesh, rails: Slab) -> tuple[float, float, float]:
    """The position of an object on both rails, its middle over the line between them."""
    assert item.position is not None
    x, y, z = item.position
    turn = rails.yaw if rails.size[0] >= rails.size[1] else rails.yaw + math.pi / 2
    side = np.array([-math.sin(turn), math.cos(turn)])
    off = float((np.array([x, y]) - rails.position[:2]) @ side)
    x, y = x - off * float(side[0]), y - off * float(side[1])
    body = in_world(item.model_copy(update={"position": (x, y, z)}), mesh)
    bars = support_mesh(rails, 1.0)
    gap = vertical_gap(body, mesh.faces, bars.vertices, bars.faces)
    top = rails.position[2] + rails.size[2] / 2
    # Beside both ends of the rails there is nothing to stand on: it stays at their height.
    lower = gap if gap is not None else float(body[:, 2].min()) - top
    return x, y, z - lower + RAY.clearance_m
