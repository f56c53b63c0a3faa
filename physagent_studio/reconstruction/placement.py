"""Objects put in their places, from the ground up: nothing penetrates, nothing floats unasked."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from physagent_studio.program.camera import Camera
from physagent_studio.program.scene import (
    Inflated,
    Meshed,
    Ramp,
    SceneObject,
    Support,
    SupportShape,
)
from physagent_studio.reconstruction.contact import vertical_gap
from physagent_studio.reconstruction.forms import Form, forms, highest, lowest, with_flats
from physagent_studio.reconstruction.geometry import (
    CLEARANCE,
    metres_per_pixel,
    on_plane,
    on_upright,
)
from physagent_studio.reconstruction.inflation import inflated_mesh
from physagent_studio.reconstruction.layout import Stance
from physagent_studio.reconstruction.masks import BoolArray, bounds
from physagent_studio.reconstruction.meshes import mesh_of
from physagent_studio.reconstruction.ramps import height_at
from physagent_studio.reconstruction.shapes import Base
from physagent_studio.reconstruction.silhouette import in_world
from physagent_studio.reconstruction.survey import Survey
from physagent_studio.records.scene import Mesh

FloatArray = NDArray[np.float64]
HOLD_ON_OBJECT = 0.6
"""How strongly something on an object is taken to stand right above that object's middle."""


@dataclass(frozen=True, eq=False, slots=True)
class Placed:
    """Objects in place with their meshes (body frame, untextured)."""

    objects: tuple[SceneObject, ...]
    meshes: Mapping[str, Mesh]
    forms: Mapping[str, str] = field(default_factory=dict)


def place_all(
    objects: tuple[SceneObject, ...],
    supports: tuple[Support, ...],
    masks: Mapping[str, BoolArray],
    stances: Mapping[str, Stance],
    read: Survey,
    given: Mapping[str, Mesh],
    fresh: frozenset[str],
    tick: Callable[[float], None],
) -> Placed:
    """Every object with its open fields filled.

    given: meshes of `Meshed` shapes by name. fresh: those that just came from elsewhere; their
    places are kept but for their height over what they stand on.
    """
    done: dict[str, tuple[SceneObject, Mesh]] = {}
    kinds: dict[str, str] = {}
    order = _from_the_ground(objects, read)
    for count, item in enumerate(order):
        stance = stances.get(item.name)
        if stance is None:
            continue
        form = _form(item, stance, masks, read, supports, done, given)
        kinds[item.name] = form.kind
        done[item.name] = (
            _settled(item, form, read, supports, done, item.name in fresh),
            form.mesh,
        )
        tick((count + 1) / len(order))
    placed = tuple(done[item.name][0] if item.name in done else item for item in objects)
    return Placed(placed, {name: mesh for name, (_, mesh) in done.items()}, kinds)


def _from_the_ground(objects: tuple[SceneObject, ...], read: Survey) -> list[SceneObject]:
    """Lower things first: an object comes after what it stands on or hangs above."""

    def level(name: str) -> int:
        steps, below = 0, name
        while steps < len(objects) and below in read.on:
            nxt = read.under.get(below) if read.on[below] == "air" else read.on[below]
            if nxt is None:
                break
            below, steps = nxt, steps + 1
        return steps

    return sorted(objects, key=lambda item: level(item.name))


def _form(
    item: SceneObject,
    stance: Stance,
    masks: Mapping[str, BoolArray],
    read: Survey,
    supports: tuple[Support, ...],
    done: Mapping[str, tuple[SceneObject, Mesh]],
    given: Mapping[str, Mesh],
) -> Form:
    """The object's shape: the given one in its place, or the best that the picture shows."""
    mask = masks[item.name]
    base = _base(stance, read, supports, done)
    if item.shape is None:
        others = [
            other
            for name, other in masks.items()
            if name != item.name
            and not (_is_round(read, item.name) and read.on.get(name) == item.name)
        ]
        hidden = np.any(others, axis=0) if others else None
        kinds = (item.form,) if item.form is not None else None
        form = forms(read.camera, mask, base, read.usual[item.name], kinds, hidden)[0]
        balances = item.form is None and _is_in_round_stack(read, item.name)
        return with_flats(form) if balances else form
    if isinstance(item.shape, Inflated):
        mesh = inflated_mesh(mask, read.camera, item.shape)
    elif isinstance(item.shape, Meshed):
        mesh = given[item.name]
    else:
        mesh = mesh_of(item.shape)
    position = item.position or _place_given(read.camera, mask, base, mesh, item)
    return Form(item.shape.kind, item.shape, mesh, position, item.rotation, 1.0, 1.0)


def _is_round(read: Survey, name: str) -> bool:
    """Whether a name says round: such a thing ends where another is seen to stand on it."""
    return bool({"sphere", "ellipsoid"} & set(read.usual[name].shapes))


def _is_in_round_stack(read: Survey, name: str) -> bool:
    """Whether a round thing carries another or is carried by one: it shows that it balances."""
    beside = [other for other, on in read.on.items() if on == name]
    if read.on[name] in read.on:
        beside.append(read.on[name])
    return _is_round(read, name) and any(_is_round(read, other) for other in beside)


def _place_given(
    camera: Camera, mask: BoolArray, base: Base, mesh: Mesh, item: SceneObject
) -> tuple[float, float, float]:
    """A known body at the base: its near side where the foot is seen, its middle in the mask's."""
    x0, y0, x1, y1 = bounds(mask)
    reach = float(np.ptp(mesh.vertices[:, 1])) / 2
    y = base.y + (reach if base.hold < 1 and not base.free_z else 0.0)
    centre = on_upright(camera, [((x0 + x1) / 2, (y0 + y1) / 2)], y)[0]
    z = float(centre[2]) if base.free_z else base.z - lowest(mesh, item.rotation)
    return float(centre[0]), y, z


def _base(
    stance: Stance,
    read: Survey,
    supports: tuple[Support, ...],
    done: Mapping[str, tuple[SceneObject, Mesh]],
) -> Base:
    on = read.on[stance.name]
    if on == "air":
        return _in_the_air(stance, read, supports, done)
    if on in done:
        below, mesh = done[on]
        assert below.position is not None
        assert below.shape is not None
        z = below.position[2] + highest(mesh, below.rotation)
        x = float(on_upright(read.camera, [stance.foot], below.position[1])[0, 0])
        # Round things balance only right above each other; flat ones may be shifted.
        round_both = _is_round(read, stance.name) and below.shape.kind != "box"
        return Base(x, below.position[1], z, 1.0 if round_both else HOLD_ON_OBJECT)
    shape = _shape_of(on, supports)
    if isinstance(shape, Ramp):
        return _on_the_ramp(stance, read.camera, shape)
    top = read.tops.get(on, 0.0)
    spot = on_plane(read.camera, [stance.foot], top)[0]
    if not np.isfinite(spot).all():
        return _in_the_air(stance, read, supports, done)
    return Base(float(spot[0]), float(spot[1]), top)


def _on_the_ramp(stance: Stance, camera: Camera, ramp: Ramp) -> Base:
    """Where the foot's ray meets the ramp's surface, kept away from its sides."""
    x, y = float(on_upright(camera, [stance.foot], ramp.toe[1])[0, 0]), ramp.toe[1]
    height = height_at(ramp, x, y) or 0.0
    inner = 0.3 * ramp.width
    for _ in range(6):
        spot = on_plane(camera, [stance.foot], height)[0]
        if not np.isfinite(spot).all():
            break
        y = float(np.clip(spot[1], ramp.toe[1] - inner, ramp.toe[1] + inner))
        x = float(on_upright(camera, [stance.foot], y)[0, 0])
        height = height_at(ramp, x, y) or height
    return Base(x, y, height, 0.5)


def _in_the_air(
    stance: Stance,
    read: Survey,
    supports: tuple[Support, ...],
    done: Mapping[str, tuple[SceneObject, Mesh]],
) -> Base:
    """On the plumb line above what is beneath it, else as far as its usual size says."""
    beneath = read.under.get(stance.name)
    if beneath is not None and beneath in done:
        position = done[beneath][0].position
        assert position is not None
        y = position[1]
    elif isinstance(ramp := _shape_of(beneath, supports), Ramp):
        y = ramp.toe[1]
    else:
        depth = read.usual[stance.name].metres * read.camera.focal / max(stance.extent, 1)
        ray = read.camera.rays(np.array([stance.foot]))[0]
        y = read.camera.position[1] + depth * float(ray[1])
    spot = on_upright(read.camera, [stance.foot], y)[0]
    return Base(float(spot[0]), y, float(spot[2]), 1.0, free_z=True)


def _shape_of(name: str | None, supports: tuple[Support, ...]) -> SupportShape | None:
    return next((support.shape for support in supports if support.name == name), None)


def _settled(
    item: SceneObject,
    form: Form,
    read: Survey,
    supports: tuple[Support, ...],
    done: Mapping[str, tuple[SceneObject, Mesh]],
    fresh: bool,
) -> SceneObject:
    """The object with its fields filled, lowered or raised onto what it stands on."""
    on = read.on[item.name]
    update: dict[str, object] = {"shape": form.shape, "support": on}
    if item.shape is None:
        update["rotation"] = form.rotation
    position = form.position
    if (item.position is None or fresh) and on != "air":
        trial = item.model_copy(update={**update, "position": position})
        position = (position[0], position[1], _resting_z(trial, form.mesh, read, supports, done))
    elif item.position is None and (under := read.under.get(item.name)) is not None:
        # In the air, but never inside what it hangs above.
        trial = item.model_copy(update={**update, "position": position, "support": under})
        rest = _resting_z(trial, form.mesh, read, supports, done)
        position = (position[0], position[1], max(position[2], rest))
    update["position"] = position
    return item.model_copy(update=update)


def _resting_z(
    item: SceneObject,
    mesh: Mesh,
    read: Survey,
    supports: tuple[Support, ...],
    done: Mapping[str, tuple[SceneObject, Mesh]],
) -> float:
    """z of the centre of mass with the body touching what it stands on."""
    assert item.position is not None
    on = item.support
    if on is not None and on in done:
        below, body = done[on]
        gap = vertical_gap(in_world(item, mesh), mesh.faces, in_world(below, body), body.faces)
        return item.position[2] - (gap or 0.0) + CLEARANCE
    shape = _shape_of(on, supports)
    if isinstance(shape, Ramp):
        return _on_ramp(item, mesh, shape) + CLEARANCE
    return read.tops.get(on or "", 0.0) - lowest(mesh, item.rotation) + CLEARANCE


def _on_ramp(item: SceneObject, mesh: Mesh, ramp: Ramp) -> float:
    """z at which the lowest-lying vertex touches the ramp's surface."""
    assert item.position is not None
    world = in_world(item, mesh)
    need = [
        height - float(point[2])
        for point in world[:: max(1, len(world) // 1500)]
        for height in [height_at(ramp, float(point[0]), float(point[1]))]
        if height is not None
    ]
    return item.position[2] + max(need, default=0.0)


def pixel_size(camera: Camera, item: SceneObject) -> float:
    """Size of a pixel at an object's centre, m."""
    return metres_per_pixel(camera, item.position or (0.0, 1.0, 0.0))
