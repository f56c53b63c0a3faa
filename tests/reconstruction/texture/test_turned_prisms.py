"""What stands over a turned footprint shows on its far side what its near one shows."""

import numpy as np
import trimesh

from physagent_studio.program import Camera
from physagent_studio.program.scene.state import Inflated, SceneObject
from physagent_studio.reconstruction.texture.turned_prisms import OPPOSITE, opposite_parts
from physagent_studio.records.scene import Mesh

LONG, WIDE, HIGH = 0.4, 0.18, 0.2


def test_a_far_side_shows_the_near_one_and_a_far_end_what_is_beside_it():
    box = trimesh.creation.box((LONG, WIDE, HIGH))
    for _ in range(4):
        box = box.subdivide()
    ways, middles = np.array(box.face_normals), np.array(box.triangles_center)
    turn = trimesh.transformations.rotation_matrix(np.radians(35.0), (0, 0, 1))[:3, :3]
    mesh = Mesh(np.array(box.vertices) @ turn.T, np.array(box.faces, np.int32))
    shape = Inflated(size=(LONG, WIDE, HIGH), turn=35.0)
    item = SceneObject(name="van", shape=shape, position=(0.0, 2.7, HIGH / 2))
    camera = Camera.from_horizon((832, 480), 40.0, 1.0, source="given", confirmed=True)
    (own, _), (across, mirrored), (carried, _), (folded, beside) = opposite_parts(
        camera, item, mesh
    )
    assert (own.astype(int) + across + carried + folded == 1).all()
    inner = np.sort(np.abs(middles / (LONG, WIDE, HIGH)), axis=1)[:, 1] < 0.3
    assert own[inner & (ways[:, 1] < -0.9)].all()
    assert across[inner & (ways[:, 1] > 0.9)].all()
    assert folded[inner & (ways[:, 0] > 0.9)].all()
    assert carried[inner & (ways[:, 2] < -0.9)].all()
    # From both corners of the end to its middle, what is beside it comes around them.
    far = np.array(box.vertices)
    end = np.abs(far[:, 0] - LONG / 2) < 1e-9
    into = OPPOSITE.fold_ratio * (WIDE / 2 - np.abs(far[end, 1]))
    expected = np.column_stack([far[end, 0] - into, np.full(end.sum(), -WIDE / 2), far[end, 2]])
    assert np.allclose((beside @ turn)[end], expected)
    assert np.allclose(mirrored @ turn, np.array(box.vertices) * (1, -1, 1))
