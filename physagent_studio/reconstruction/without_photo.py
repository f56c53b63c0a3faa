"""A scene without a photo: a program that states every number is drawn from its shapes alone."""

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace
from types import MappingProxyType

import numpy as np

from physagent_studio.errors import InputError
from physagent_studio.program.rotations import quaternion_of
from physagent_studio.program.scene.camera import Camera
from physagent_studio.program.scene.state import Floor, SceneState, Wall
from physagent_studio.reconstruction.shapes.meshes import support_mesh
from physagent_studio.reconstruction.shapes.stated_meshes import stated_mesh
from physagent_studio.records.scene import Mesh, Scene
from physagent_studio.rendering.backdrop import PALETTE


@dataclass(frozen=True, slots=True)
class ViewSettings:
    """The camera of a scene without a photo."""

    size_px: tuple[int, int] = (832, 480)  # 64..4096: width and height, a usual video's
    field_of_view_rad: float = math.radians(45)  # 0.3..1.5: from top to bottom
    pitch_rad: float = math.radians(18)  # 0..0.8: down, so that the ground shows
    # 1..4: of the picture to the things at rest, so that motion stays in it
    room_ratio: float = 1.7


VIEW = ViewSettings()


def scene_without_photo(state: SceneState, key: str, assets: Mapping[str, Mesh]) -> Scene:
    """The scene of a state in which nothing is open; an `InputError` names what is.

    assets: stored meshes by what `Meshed.asset` names.
    """
    for item in state.objects:
        if item.shape is None or item.position is None:
            field = "shape" if item.shape is None else "position"
            raise InputError(
                f"scene.objects.{item.name}.{field} is open and there is no photo to find it in; "
                "state it, or give a case with an image"
            )
    for support in state.supports:
        if support.shape is None:
            raise InputError(
                f"scene.supports.{support.name}.shape is open and there is no photo to find it in"
            )
    meshes = {
        item.name: replace(stated_mesh(item, assets), color=PALETTE[index % len(PALETTE)])
        for index, item in enumerate(state.objects)
    }
    bounds = _bounds(state, meshes)
    done = state if state.camera else state.model_copy(update={"camera": _camera(*bounds)})
    reach = 4.0 * bounds[1]
    return Scene(
        state=done,
        photo=None,
        plate=None,
        masks=MappingProxyType({}),
        meshes=MappingProxyType(meshes),
        support_meshes=MappingProxyType(
            {
                support.name: support_mesh(support.shape, reach)
                for support in done.supports
                if support.shape is not None
            }
        ),
        candidates=MappingProxyType({}),
        findings=(),
        hash=key,
    )


def _bounds(state: SceneState, meshes: dict[str, Mesh]) -> tuple[np.ndarray, float]:
    """Centre (3,) and half the size, m, of what is to be seen; half-spaces do not count."""
    points = [np.zeros((1, 3))] if not state.objects else []
    for item in state.objects:
        radius = float(np.linalg.norm(meshes[item.name].vertices, axis=1).max())
        points.append(np.array(item.position) + radius * np.array([[-1, -1, -1], [1, 1, 1]]))
    for support in state.supports:
        if support.shape is not None and not isinstance(support.shape, Floor | Wall):
            points.append(support_mesh(support.shape, 1.0).vertices)
    cloud = np.concatenate(points)
    low, high = cloud.min(axis=0), cloud.max(axis=0)
    return (low + high) / 2, max(float((high - low).max()) / 2, 0.25)


def _camera(centre: np.ndarray, half: float) -> Camera:
    """A camera that looks along +y and a little down on the things."""
    width, height = VIEW.size_px
    focal = height / 2 / math.tan(VIEW.field_of_view_rad / 2)
    distance = VIEW.room_ratio * half * focal / (height / 2)
    down, ahead = math.sin(VIEW.pitch_rad), math.cos(VIEW.pitch_rad)
    forward = np.array([0, ahead, -down])
    axes = np.column_stack([[1.0, 0, 0], [0, -down, -ahead], forward])
    x, y, z = (float(v) for v in centre - distance * forward)
    return Camera(
        size=VIEW.size_px,
        focal=focal,
        principal=(width / 2, height / 2),
        position=(x, y, z),
        rotation=quaternion_of(axes),
        source="given",
        confirmed=True,
    )
