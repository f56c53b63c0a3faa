"""Edits that make a thing stand, hang, float or fall, and that move it along its line of sight.

What moves along its line of sight and is scaled with its distance covers the same pixels as before:
the photo does not tell a small thing that hangs near from a large one that stands far away.
"""

from collections.abc import Collection

import numpy as np
from pydantic import JsonValue

from physagent_studio.arrays import FloatArray
from physagent_studio.errors import InputError
from physagent_studio.program import Edit, PhysicalProgram, SetField
from physagent_studio.program.base import Pixel
from physagent_studio.program.preflight.mechanics import standing
from physagent_studio.program.preflight.scaling import farther
from physagent_studio.program.scene.aloft import AIR, Carriage, carriage_of
from physagent_studio.program.scene.camera import Camera
from physagent_studio.program.scene.shapes import Placed, lowest, place_object, reach
from physagent_studio.program.scene.state import Floor, SceneObject, SceneState
from physagent_studio.workbench.photo_edits import opened_objects

AT_EYE_LEVEL = 0.02
"""Sine of the angle below or above the camera's level under which height says nothing of depth."""
NEAREST, FARTHEST = 0.02, 50.0
"""How many times as far as before a thing may be put."""
_SIDES = np.array([[1.0, 0, 0], [0, 1.0, 0]])


def carriage_edits(
    program: PhysicalProgram, pinned: Collection[str], name: str, how: Carriage
) -> tuple[Edit, ...]:
    """The thing stands, hangs, floats, or nothing holds it; its place in the photo stays.

    In the air it stays where it was until it is raised; set down, its place is found anew from what
    is under it.
    """
    item = _thing(program, name)
    if carriage_of(item) == how:
        return ()
    path = f"scene.objects.{name}"
    under = _below(program.scene, item) if how == "stands" else AIR
    edits: list[Edit] = [
        SetField(path=f"{path}.support", value=under),
        SetField(path=f"{path}.aloft", value=how if how in ("hangs", "floats") else None),
    ]
    if item.tether is not None and how != "hangs":
        edits.append(SetField(path=f"{path}.tether", value=None))
    if how != "stands":
        return tuple(edits)
    opened = opened_objects((item,), pinned, ("shape", "position"))
    return (*edits, *(opened or [_set_down(program.scene, item, under)]))


def ground_edits(program: PhysicalProgram, name: str, pixel: Pixel) -> tuple[Edit, ...]:
    """The thing in the air above a place of the ground that is seen at a pixel."""
    item, camera = _thing(program, name), _camera(program)
    ground = _ground(program.scene)
    ray, eye = camera.rays(np.array([pixel], float))[0], np.array(camera.position)
    share = (ground - eye[2]) / ray[2] if ray[2] < 0 else 0.0
    if share <= 0:
        raise InputError("no ground is seen there: drag the line below the horizon")
    far, near = share * ray[:2], np.array(item.position)[:2] - eye[:2]
    return moved_along(program, item, float(np.linalg.norm(far) / np.linalg.norm(near)))


def height_edits(program: PhysicalProgram, name: str, height: float) -> tuple[Edit, ...]:
    """The thing with its lowest point so high above the ground, m, where the photo shows it."""
    item, camera = _thing(program, name), _camera(program)
    eye, place = np.array(camera.position), np.array(item.position)
    found = foot_of(program.scene, item)
    assert found is not None
    drop = _ground(program.scene) + found[1] - eye[2]
    if abs(drop) < AT_EYE_LEVEL * float(np.linalg.norm(place - eye)):
        raise InputError(
            f"{name.replace('_', ' ')} is seen at the height of the camera, however far it is:"
            " drag its ground line in the photo instead"
        )
    return moved_along(program, item, (_ground(program.scene) + height - eye[2]) / drop)


def moved_along(program: PhysicalProgram, item: SceneObject, share: float) -> tuple[Edit, ...]:
    """The thing so many times as far from the camera, and as much larger; it hangs if it stood."""
    if not NEAREST < share < FARTHEST:
        raise InputError("it cannot be there and in its place in the photo at once")
    eye = np.array(_camera(program).position)
    path, moved = f"scene.objects.{item.name}", farther(item, eye, share)
    assert moved.position is not None
    assert moved.shape is not None
    edits: list[Edit] = [
        SetField(path=f"{path}.position", value=list(moved.position)),
        SetField(path=f"{path}.shape", value=moved.shape.model_dump(mode="json")),
    ]
    if moved.tether is not None:
        edits.append(SetField(path=f"{path}.tether", value=moved.tether))
    if carriage_of(item) == "stands":
        edits += [
            SetField(path=f"{path}.support", value=AIR),
            SetField(path=f"{path}.aloft", value="hangs"),
        ]
    return tuple(edits)


def foot_of(scene: SceneState, item: SceneObject) -> tuple[FloatArray, float] | None:
    """The place (3,) of the ground straight below a thing, m, and how high above it that is."""
    if item.shape is None or item.position is None:
        return None
    ground = _ground(scene)
    foot = float(lowest(place_object(item.shape, [item.position], [item.rotation]))[0])
    return np.array([*item.position[:2], ground]), foot - ground


def _thing(program: PhysicalProgram, name: str) -> SceneObject:
    item = program.scene.object(name)
    if item is None or item.position is None or item.shape is None:
        raise InputError(f"there is no {name.replace('_', ' ')} in the scene yet")
    return item


def _camera(program: PhysicalProgram) -> Camera:
    if program.scene.camera is None:
        raise InputError("this scene has no photo")
    return program.scene.camera


def _ground(scene: SceneState) -> float:
    floors = [s.shape.height for s in scene.supports if isinstance(s.shape, Floor)]
    return min(floors, default=0.0)


def _below(scene: SceneState, item: SceneObject) -> str:
    """What is straight below a thing, the highest of it; else the ground."""
    assert item.position is not None
    placed, floors = standing(scene), [s for s in scene.supports if isinstance(s.shape, Floor)]
    under = {
        name: _top(body)
        for name, body in placed.items()
        if name != item.name and body.outline is not None and _is_over(item.position, body)
    }
    lower = {name: top for name, top in under.items() if top <= item.position[2]}
    if lower:
        return max(lower, key=lambda name: lower[name])
    if not floors:
        raise InputError("there is nothing below it that it could stand on")
    return floors[0].name


def _top(body: Placed) -> float:
    return float(reach(body, np.array([0.0, 0.0, 1.0]))[0])


def _is_over(place: tuple[float, float, float], body: Placed) -> bool:
    return all(
        -float(reach(body, -side)[0]) <= float(side @ place) <= float(reach(body, side)[0])
        for side in _SIDES
    )


def _set_down(scene: SceneState, item: SceneObject, under: str) -> Edit:
    """A thing that no photo shows, lowered onto what it stands on."""
    assert item.position is not None
    assert item.shape is not None
    body = standing(scene).get(under)
    top = _ground(scene) if body is None or body.outline is None else _top(body)
    x, y, z = item.position
    foot = float(lowest(place_object(item.shape, [item.position], [item.rotation]))[0])
    place: list[JsonValue] = [x, y, round(z - foot + top, 5)]
    return SetField(path=f"scene.objects.{item.name}.position", value=place)
