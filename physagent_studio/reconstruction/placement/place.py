"""Objects put in their places, from the ground up: nothing penetrates, nothing floats unasked."""

import itertools
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from physagent_studio.program.rotations import matrix_of
from physagent_studio.program.scene.aloft import AIR
from physagent_studio.program.scene.camera import Camera
from physagent_studio.program.scene.state import (
    Inflated,
    Meshed,
    SceneObject,
    Support,
)
from physagent_studio.reconstruction.camera.rays import (
    on_upright,
)
from physagent_studio.reconstruction.grounding.same_kind import alike
from physagent_studio.reconstruction.masks.hidden_tops import with_hidden_tops
from physagent_studio.reconstruction.photo.line_segments import Segments
from physagent_studio.reconstruction.photo.regions import BoolArray, bounds, iou
from physagent_studio.reconstruction.placement.bases import (
    base_of,
    is_in_round_stack,
    is_round,
    shape_of,
)
from physagent_studio.reconstruction.placement.basins import standing_for
from physagent_studio.reconstruction.placement.depenetration import moved_apart
from physagent_studio.reconstruction.placement.resting import settled
from physagent_studio.reconstruction.placement.seats import SEAT, bearers, seat_below
from physagent_studio.reconstruction.placement.tilted import tilt_of
from physagent_studio.reconstruction.shapes.flats import balances_on_a_point, with_flats
from physagent_studio.reconstruction.shapes.forms import (
    Form,
    forms,
    inflated_form,
    lowest,
)
from physagent_studio.reconstruction.shapes.inflation import inflated_mesh
from physagent_studio.reconstruction.shapes.lying import lies
from physagent_studio.reconstruction.shapes.meshes import mesh_of
from physagent_studio.reconstruction.shapes.primitives import Base
from physagent_studio.reconstruction.shapes.silhouettes import in_world, silhouette
from physagent_studio.reconstruction.shapes.vessels import hollow_first, hollow_kinds, opened
from physagent_studio.reconstruction.supports.stances import Stance
from physagent_studio.reconstruction.survey.survey import Survey
from physagent_studio.reconstruction.switches import at_work
from physagent_studio.records.scene import Mesh, ShapeOffer


@dataclass(frozen=True, eq=False, slots=True)
class Placed:
    """Objects in place with their meshes (body frame, untextured).

    offers: the shapes that were fitted to each mask, best first.
    """

    objects: tuple[SceneObject, ...]
    meshes: Mapping[str, Mesh]
    offers: Mapping[str, tuple[ShapeOffer, ...]] = field(default_factory=dict)


@dataclass(frozen=True, eq=False, slots=True)
class Ground:
    """What is known before objects are placed.

    given: meshes of `Meshed` shapes by name. fresh: those that just came from elsewhere; their
    places are kept but for their height over what they stand on. ranked: objects whose other
    shapes are known: where one is asked for, no more are fitted. found: edges of the picture.
    """

    supports: tuple[Support, ...]
    masks: Mapping[str, BoolArray]
    stances: Mapping[str, Stance]
    read: Survey
    given: Mapping[str, Mesh]
    fresh: frozenset[str]
    ranked: set[str]
    found: Segments


def place_all(
    objects: tuple[SceneObject, ...], ground: Ground, tick: Callable[[float], None]
) -> Placed:
    """Every object with its open fields filled."""
    read = ground.read
    ground = replace(ground, masks=with_hidden_tops(ground.masks, read.on))
    order = [item for item in _from_the_ground(objects, read) if item.name in ground.stances]
    done = _placed(order, ground, {}, tick)
    offers = {name: one.offers for name, one in done.items()}
    # A name that says nothing ("object 1", "object 2") does not say that things are alike.
    named = [item.name for item in order if item.shape is None and read.usual[item.name].known]
    agreed = alike({name: {one.kind: one.merit for one in offers[name]} for name in named})
    if at_work("alike kinds") and any(done[name].chosen != kind for name, kind in agreed.items()):
        done = _placed(order, ground, agreed, tick)
    meshes = {name: one.form.mesh for name, one in done.items()}
    free = frozenset(item.name for item in order if item.position is None)
    bodies = {name: one.item for name, one in done.items()}
    pools = standing_for(ground.supports)
    bodies |= {name: item for name, (item, _) in pools.items()}
    put = _apart(bodies, {**meshes, **{name: mesh for name, (_, mesh) in pools.items()}}, free)
    placed = tuple(put.get(item.name, item) for item in objects)
    return Placed(placed, meshes, offers)


def _apart(
    items: Mapping[str, SceneObject], meshes: Mapping[str, Mesh], free: frozenset[str]
) -> dict[str, SceneObject]:
    """The objects with those moved that stood in one another. On slopes nothing is moved."""
    if not at_work("depenetration"):
        return dict(items)
    level = frozenset(n for n in free if _is_level(items[n]))
    out = dict(items)
    for name, (x, y) in moved_apart(items, meshes, level).items():
        position = items[name].position
        assert position is not None
        place = (position[0] + x, position[1] + y, position[2])
        out[name] = items[name].model_copy(update={"position": place})
    return out


def _is_level(item: SceneObject) -> bool:
    """Whether it stands or lies as on level ground."""
    min_upward = 0.999  # cosine, 0.99..1: of the own axis of what stands level
    return matrix_of(item.rotation)[2, 2] > min_upward or lies(item.rotation)


@dataclass(frozen=True, eq=False, slots=True)
class _One:
    """An object in place; its form, the kind chosen and the kinds that were tried, best first."""

    item: SceneObject
    form: Form
    chosen: str
    offers: tuple[ShapeOffer, ...]


def _placed(
    order: Sequence[SceneObject],
    ground: Ground,
    kinds: Mapping[str, str],
    tick: Callable[[float], None],
) -> dict[str, _One]:
    """Every object in its place, from the ground up. kinds: forms that are settled, by name."""
    out: dict[str, _One] = {}
    done = standing_for(ground.supports)
    for count, item in enumerate(order):
        one, on = _one(item, ground, done, kinds.get(item.name)), ground.read.on[item.name]
        if item.shape is None and on in out and _shown(one, ground) < SEAT.max_top_iou:
            carrier = next(below for below in order if below.name == on)
            one = _elsewhere(item, carrier, ground, (done, out), one)
        out[item.name] = one
        done[item.name] = (one.item, one.form.mesh)
        tick((count + 1) / len(order))
    return out


def _one(
    item: SceneObject,
    ground: Ground,
    done: Mapping[str, tuple[SceneObject, Mesh]],
    kind: str | None = None,
) -> _One:
    """An object in its place on what carries it. kind: the form that is settled, if it is."""
    offers, read = _offers(item, ground, done, kind), ground.read
    form = offers[0]
    hollow = item.shape is None and item.form is None and item.name in read.vessels
    form = hollow_first(offers) if hollow else form
    if item.shape is None and item.form is None and _is_seen_to_balance(form, item.name, read):
        form = with_flats(form) if at_work("flats") else form
    if item.shape is None and item.name in read.vessels:
        form = opened(form)
    put = _put(item, form, ground, done)
    tried = tuple(ShapeOffer(one.kind, one.merit, one.iou) for one in offers)
    chosen = form.kind if hollow else offers[0].kind
    return _One(put, form, chosen, tried if item.shape is None else ())


def _put(
    item: SceneObject,
    form: Form,
    ground: Ground,
    done: Mapping[str, tuple[SceneObject, Mesh]],
) -> SceneObject:
    fresh = item.name in ground.fresh
    put = settled(item, form, ground.read, ground.supports, bearers(done), fresh)
    return _with_hull(put, form.mesh)


def _shown(one: _One, ground: Ground) -> float:
    """IoU of a thing in its place with its mask, where no other thing is seen."""
    mask = ground.masks[one.item.name]
    seen = silhouette(ground.read.camera, in_world(one.item, one.form.mesh), one.form.mesh.faces)
    others = [other for name, other in ground.masks.items() if name != one.item.name]
    hidden = np.any(others, axis=0) if others else np.zeros_like(mask)
    return iou(seen & (mask | ~hidden), mask)


def _elsewhere(
    item: SceneObject,
    carrier: SceneObject,
    ground: Ground,
    so_far: tuple[dict[str, tuple[SceneObject, Mesh]], dict[str, _One]],
    first: _One,
) -> _One:
    """A thing that is not seen where it would be on top of what ends it below.

    It stands on a seat of that, which then gets one, or beside it on the same ground. so_far: what
    is in place, and how that came; a carrier with a seat is put there. first: the thing on top.
    """
    (done, out), read = so_far, ground.read
    name, on, least = item.name, carrier.name, _shown(first, ground) + SEAT.min_gain
    mask = ground.masks[on]
    seat = seat_below(ground.stances[name], read.camera, *done[on], mask)
    if seat is not None and carrier.shape is None:
        base = _base(carrier, ground, done)
        form = inflated_form(read.camera, mask, base, read.usual[on], seat)
        put = _put(carrier, form, ground, done)
        found = _one(item, ground, {**done, on: (put, form.mesh)})
        loss = out[on].form.iou - form.iou
        if loss < SEAT.max_loss and _shown(found, ground) > least:
            done[on], out[on] = (put, form.mesh), replace(out[on], item=put, form=form)
            return found
    if read.on[on] == AIR:
        return first
    beside = replace(read, on={**read.on, name: read.on[on]})
    found = _one(item, replace(ground, read=beside), done)
    return found if _shown(found, ground) > least else first


def _with_hull(item: SceneObject, mesh: Mesh) -> SceneObject:
    """The object, whose shape knows where its mesh ends along the axes and corners of a cube."""
    if not isinstance(item.shape, Inflated | Meshed):
        return item
    corners = np.array(list(itertools.product((-1.0, 1.0), repeat=3)))
    ways = np.vstack([np.eye(3), -np.eye(3), corners])
    # Whatever its proportions, corners are sought as on a cube.
    spread = np.maximum(np.ptp(mesh.vertices, axis=0), 1e-9)
    ends = np.unique(np.argmax(ways @ (mesh.vertices / spread).T, axis=1))
    hull = tuple(tuple(round(float(part), 5) for part in mesh.vertices[end]) for end in ends)
    return item.model_copy(update={"shape": item.shape.model_copy(update={"hull": hull})})


def _is_seen_to_balance(form: Form, name: str, read: Survey) -> bool:
    """Whether a round body stands where it could not without flats: on its end, or in a stack."""
    return is_in_round_stack(read, name) or (read.on[name] != AIR and balances_on_a_point(form))


def _from_the_ground(objects: tuple[SceneObject, ...], read: Survey) -> list[SceneObject]:
    """Lower things first: an object comes after what it stands on or hangs above."""

    def level(name: str) -> int:
        steps, below = 0, name
        while steps < len(objects) and below in read.on:
            nxt = read.under.get(below) if read.on[below] == AIR else read.on[below]
            if nxt is None:
                break
            below, steps = nxt, steps + 1
        return steps

    return sorted(objects, key=lambda item: level(item.name))


def _base(item: SceneObject, ground: Ground, done: Mapping[str, tuple[SceneObject, Mesh]]) -> Base:
    base = base_of(ground.stances[item.name], ground.read, ground.supports, done)
    usual = ground.read.usual[item.name]
    if not usual.known:
        return base
    longest = (usual.metres, usual.spread)
    return replace(base, longest=longest, deep=usual.depth, flat=usual.flat)


def _offers(
    item: SceneObject,
    ground: Ground,
    done: Mapping[str, tuple[SceneObject, Mesh]],
    kind: str | None,
) -> list[Form]:
    """The object's shape: the given one in its place, or those that the picture shows, best first.

    kind: the only one wanted, if it is settled.
    """
    read, mask = ground.read, ground.masks[item.name]
    base, usual = _base(item, ground, done), read.usual[item.name]
    tilt = tilt_of(base, shape_of(read.on[item.name], ground.supports), usual.shapes)
    camera = tilt.camera(read.camera) if tilt is not None else read.camera
    if item.shape is None:
        others = [
            other
            for name, other in ground.masks.items()
            if name != item.name
            and (read.on[item.name] != name or name in read.vessels or name in read.basins)
            and not (is_round(read, item.name) and read.on.get(name) == item.name)
        ]
        hidden = np.any(others, axis=0) if others else None
        wanted = item.form or kind
        only = wanted is not None and (kind is not None or item.name in ground.ranked)
        if item.name in read.vessels and item.form is None:
            usual = hollow_kinds(usual)
        tried = forms(camera, mask, base, usual, wanted, hidden, only=only, found=ground.found)
        return [tilt.in_world(form) for form in tried] if tilt is not None else tried
    if isinstance(item.shape, Inflated):
        mesh = inflated_mesh(mask, camera, item.shape)
    elif isinstance(item.shape, Meshed):
        mesh = ground.given[item.name]
    else:
        mesh = mesh_of(item.shape)
    position = item.position or _place_given(read.camera, mask, base, mesh, item)
    return [Form(item.shape.kind, item.shape, mesh, position, item.rotation, 1.0, 1.0)]


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
