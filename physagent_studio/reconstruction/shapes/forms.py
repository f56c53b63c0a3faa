"""The form of one object: primitive, surface of revolution or inflation, whichever shows best."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

import cv2
import numpy as np

from physagent_studio.arrays import FloatArray
from physagent_studio.knowledge.things import UNKNOWN, Usual
from physagent_studio.program.base import IDENTITY
from physagent_studio.program.rotations import matrix_of
from physagent_studio.program.scene.camera import Camera
from physagent_studio.program.scene.state import (
    Inflated,
    Revolved,
    Shape,
)
from physagent_studio.reconstruction.camera.rays import metres_per_pixel, on_plane, on_upright
from physagent_studio.reconstruction.photo.line_segments import Segments
from physagent_studio.reconstruction.photo.regions import BoolArray, bounds, iou, solidity
from physagent_studio.reconstruction.shapes.footing import on_legs
from physagent_studio.reconstruction.shapes.inflation import (
    inflated_mesh,
    natural_depth,
    upright_extent,
)
from physagent_studio.reconstruction.shapes.lying import fit_lying
from physagent_studio.reconstruction.shapes.meshes import mesh_of
from physagent_studio.reconstruction.shapes.primitives import PRIMITIVE, Base, Fit, fit_all
from physagent_studio.reconstruction.shapes.prisms import plan_seen, prism_mesh
from physagent_studio.reconstruction.shapes.revolution import mirror_symmetry, revolved
from physagent_studio.reconstruction.shapes.rings import fit_ring, hole_of
from physagent_studio.reconstruction.shapes.silhouettes import silhouette
from physagent_studio.reconstruction.shapes.stems import WITH_PARTS, blobs
from physagent_studio.reconstruction.switches import at_work
from physagent_studio.records.scene import Mesh

PRIMITIVES = ("sphere", "ellipsoid", "cylinder", "frustum", "capsule", "box", "bowl")


@dataclass(frozen=True, slots=True)
class FormSettings:
    """When a form is taken for another."""

    revolved_cost: float = 0.04  # IoU, 0..0.2: a surface of revolution has to win by: it fits much
    inflated_cost: float = 0.09  # IoU, 0..0.2: an inflated mask has to win by: it fits anything
    # share, 0.4..0.9: of the hull around its mask, of what stands over its footprint
    min_solidity: float = 0.7
    min_turned_iou: float = 0.9  # IoU, 0.7..1: with its mask, of what stands over its footprint
    # 0.2..1: usual depth over the round one: flatter things show no sides
    min_straight_ratio: float = 0.75
    # ratio, 0.2..1: of a round body's depth over its width, from which on low feet tell no turn
    max_turned_depth: float = 0.5
    thin_deg: float = 12.0  # 3..30: least angle from which one looks down on thin things that lie
    thin_share: float = 0.1  # 0.02..0.3: of their length, up to which they are thin
    thick_deg: float = 30.0  # 10..60: on thick ones
    above_deg: float = 60.0  # 45..80: on what is not known to lie: its outline is that of its foot
    part_rounds: int = 8  # count, 1..16: in which a body and what stands off it are told apart
    min_part_step: float = 0.005  # IoU, 0..0.05: of body and parts, for which there is another
    min_across_iou: float = 0.5  # IoU, 0.2..0.8: with its mask, of what stands across its feet
    board_share: float = 0.25  # 0.05..0.5: of an outline's shorter side: how thick its board is
    min_part_gain: float = 0.03  # IoU, 0..0.1: in all, for which the body is taken without them


FORM = FormSettings()


@dataclass(frozen=True, eq=False, slots=True)
class Form:
    """A shape in place with its mesh (body frame). iou: its silhouette against the mask."""

    kind: str
    shape: Shape
    mesh: Mesh
    position: tuple[float, float, float]
    rotation: tuple[float, float, float, float]
    iou: float
    merit: float


def forms(
    camera: Camera,
    mask: BoolArray,
    base: Base,
    usual: Usual,
    kind: str | None = None,
    hidden: BoolArray | None = None,
    *,
    only: bool = True,
    found: Segments | None = None,
) -> list[Form]:
    """All forms that fit the mask at `base`, best first; never empty for a mask of ≥ 12 pixels.

    kind: the one that is asked for comes first; only: no others are tried then. hidden: pixels
    (H, W) of other objects, which may cover parts. found: straight edges of the picture. What has
    a handle or a stem is fitted once more without what stands off, where that shows more of it.
    """

    def fitted(own: BoolArray, covered: BoolArray | None) -> list[Form]:
        return _fitted(camera, own, base, usual, kind, covered, only=only, found=found)

    first = fitted(mask, hidden)
    if not usual.parts or not at_work("bodies without parts"):
        return first
    best, (beside, before) = first, _beside(camera, mask, first[0])
    shown = before
    for _ in range(FORM.part_rounds):
        if not beside.any():
            break
        covered = beside if hidden is None else hidden | beside
        again = fitted(mask & ~beside, covered)
        beside, value = _beside(camera, mask, again[0])
        if value <= shown + FORM.min_part_step:
            break
        best, shown = again, value
    return best if shown > before + FORM.min_part_gain else first


def _beside(camera: Camera, mask: BoolArray, form: Form) -> tuple[BoolArray, float]:
    """(H, W) what a mask shows standing off a body, and the IoU with it of both together.

    Nothing beside what is made from the mask itself.
    """
    world = form.mesh.vertices @ matrix_of(form.rotation).T + np.array(form.position)
    body = silhouette(camera, world, form.mesh.faces)
    found = blobs(mask, body) if form.kind in WITH_PARTS else []
    parts = np.any(found, axis=0) if found else np.zeros_like(mask)
    return parts, iou(body | parts, mask)


def _fitted(
    camera: Camera,
    mask: BoolArray,
    base: Base,
    usual: Usual,
    kind: str | None = None,
    hidden: BoolArray | None = None,
    *,
    only: bool = True,
    found: Segments | None = None,
) -> list[Form]:
    """All forms that fit the mask, best first; see `forms`."""
    if kind == "board":
        return [_board_form(camera, mask, base)]
    wanted = (kind,) if kind is not None else ()
    if kind is None or not only:
        wanted = tuple(dict.fromkeys((*wanted, *_worth_trying(mask, usual, hidden))))
    primitives = [kind for kind in PRIMITIVES if kind in wanted]
    fits = fit_all(camera, mask, base, primitives, usual.shapes, hidden, found)
    standing = max((fit.iou for fit in fits), default=0.0)
    fits += (
        []
        if not at_work("lying")
        else fit_lying(camera, mask, base, primitives, usual, hidden, standing)
    )
    made = [_form_of(fit) for fit in fits]
    if "torus" in wanted and at_work("rings"):
        ring = fit_ring(camera, mask, base, usual.shapes, hidden)
        made += [_form_of(ring)] if ring is not None else []
    if "revolved" in wanted and at_work("revolved"):
        made += _revolved_form(camera, mask, base, usual)
    if "inflated" in wanted or not made:
        lying = flat_form(camera, mask, base, usual)
        turned = _turned_form(camera, mask, base, usual)
        form = lying or turned or inflated_form(camera, mask, base, usual)
        if form.iou < FORM.min_across_iou and not (lying or turned):
            # What is taken for its feet is none: it is turned too far on them.
            facing = inflated_form(camera, mask, base, usual, facing=True)
            form = max(form, facing, key=lambda one: one.iou)
        made.append(form)
    made.sort(key=lambda form: (form.kind != kind, -form.merit))
    best: dict[str, Form] = {}
    for form in made:
        # Of a kind that stands or lies the better one.
        best.setdefault(form.kind, form)
    return list(best.values())


def _form_of(fit: Fit) -> Form:
    mesh = mesh_of(fit.shape)
    kind = fit.shape.kind
    return Form(kind, fit.shape, mesh, fit.position, fit.rotation, fit.iou, fit.merit)


def _worth_trying(mask: BoolArray, usual: Usual, hidden: BoolArray | None) -> tuple[str, ...]:
    """The kinds that a known name allows; all of them for an unknown one. A hole shows a ring."""
    ring = ("torus",) if hole_of(mask, hidden) is not None else ()
    if usual.shapes == ("sphere",):
        return ("sphere", "ellipsoid", *ring, "inflated")
    if "bowl" in usual.shapes:
        return tuple(kind for kind in usual.shapes if kind != "revolved")
    if usual.shapes:
        return tuple(dict.fromkeys((*usual.shapes, *ring, "inflated")))
    kinds = [*(kind for kind in PRIMITIVES if kind != "bowl"), *ring, "inflated"]
    if mirror_symmetry(mask) > 0.9:
        kinds.append("revolved")
    return tuple(kinds)


def _revolved_form(camera: Camera, mask: BoolArray, base: Base, usual: Usual) -> list[Form]:
    """The surface of revolution as its rows give it, or corrected until its box is the mask's."""
    made = revolved(camera, mask, base)
    if made is None:
        return []
    best: tuple[float, Revolved, tuple[float, float, float]] | None = None
    for _ in range(4 if at_work("corrected revolved") else 1):
        shape, position = made
        mesh = mesh_of(shape)
        seen = silhouette(camera, mesh.vertices + np.array(position), mesh.faces)
        value = iou(seen, mask)
        if best is None or value > best[0]:
            best = (value, shape, position)
        if not seen.any():
            break
        made = _corrected(camera, (shape, position), bounds(seen), bounds(mask), base)
    assert best is not None
    value, shape, position = best
    merit = value - FORM.revolved_cost + PRIMITIVE.named_gain * ("revolved" in usual.shapes)
    return [Form("revolved", shape, mesh_of(shape), position, IDENTITY, value, merit)]


def _corrected(
    camera: Camera,
    made: tuple[Revolved, tuple[float, float, float]],
    seen: tuple[int, int, int, int],
    wanted: tuple[int, int, int, int],
    base: Base,
) -> tuple[Revolved, tuple[float, float, float]]:
    """The shape and its place, its box in the picture drawn to the wanted one."""
    shape, (x, y, z) = made
    wide, tall = (
        float(np.clip((wanted[k + 2] - wanted[k]) / (seen[k + 2] - seen[k]), 0.7, 1.4))
        for k in (0, 1)
    )
    foot = z + shape.profile[0][0]
    x += ((wanted[0] + wanted[2]) - (seen[0] + seen[2])) / 2 * metres_per_pixel(camera, (x, y, z))
    if base.hold < 1 and not base.free_z:
        column = (wanted[0] + wanted[2]) / 2
        spots = on_plane(camera, [(column, wanted[3]), (column, seen[3])], foot)
        step = float(spots[0, 1] - spots[1, 1])
        y += (1 - base.hold) * step if np.isfinite(step) else 0.0
    profile = tuple((own * tall, radius * wide) for own, radius in shape.profile)
    return Revolved(profile=profile), (x, y, foot - profile[0][0])


def inflated_form(
    camera: Camera,
    mask: BoolArray,
    base: Base,
    usual: Usual,
    seat: float | None = None,
    *,
    facing: bool = False,
) -> Form:
    """The inflated mask, its size and place corrected until its silhouette spans the mask's.

    The foot that is seen is the near rim; the middle plane lies half a depth behind it. seat
    and facing: see `Inflated`.
    """
    x0, y0, x1, y1 = bounds(mask)
    natural = natural_depth(mask)
    depth = usual.depth * (x1 - x0) if usual.depth else natural
    straight = (
        at_work("straight inflated")
        and usual.depth is not None
        and (usual.drives or depth > FORM.min_straight_ratio * natural)
    )
    # A usual depth of what swells is that behind its front, and of what is about as deep as wide
    # one foot may stand before the other: neither tells how it is turned.
    compact = natural > FORM.max_turned_depth * (x1 - x0) and not on_legs(mask)
    facing = facing or ((usual.depth is not None or compact) and not straight)
    extent = upright_extent(mask, camera, depth, straight, facing)
    share = extent[1] / max(extent[0], 1e-9)
    along = base.hold < 1 and not base.free_z
    pixel = metres_per_pixel(camera, (base.x, base.y, base.z))
    width = (x1 - x0) * pixel
    height = width * extent[2] / max(extent[0], 1e-9)
    y = base.y + (0.5 * (1 - base.hold) * min(share, 1.0) * width if along else 0.0)
    x = float(on_upright(camera, [((x0 + x1) / 2, y1)], y)[0, 0])
    foot = base.z
    shape = Inflated(size=(width, share * width, height), straight=straight, facing=facing)
    mesh, place = inflated_mesh(mask, camera, shape), (x, y, foot)
    for _ in range(4):
        size = (width, max(share * width, 1e-4), height)
        shape = Inflated(size=size, straight=straight, seat=seat, facing=facing)
        mesh = inflated_mesh(mask, camera, shape)
        place = _centred(mesh, (x, y), foot)
        seen = camera.project(mesh.vertices + np.array(place))[0]
        low, high = seen.min(0), seen.max(0)
        pixel = metres_per_pixel(camera, place)
        width *= float(np.clip((x1 - x0) / (high[0] - low[0]), 0.7, 1.4))
        height *= float(np.clip((y1 - y0) / (high[1] - low[1]), 0.7, 1.4))
        x += ((x0 + x1) / 2 - float(low[0] + high[0]) / 2) * pixel
        off = y1 - float(high[1])
        if base.free_z:
            foot -= off * pixel
        elif along:
            spots = on_plane(camera, [(x0, y1), (x0, y1 - off)], base.z)
            step = float(spots[0, 1] - spots[1, 1])
            y += (1 - base.hold) * step if np.isfinite(step) else 0.0
    value = iou(silhouette(camera, mesh.vertices + np.array(place), mesh.faces), mask)
    merit = value - FORM.inflated_cost + PRIMITIVE.named_gain * ("inflated" in usual.shapes)
    return Form("inflated", shape, mesh, place, IDENTITY, value, merit)


def _board_form(camera: Camera, mask: BoolArray, base: Base) -> Form:
    """The outline cut out of a board that stands where its foot is seen: it covers the mask."""
    x0, y0, x1, y1 = bounds(mask)
    depth = FORM.board_share * min(x1 - x0, y1 - y0) / (x1 - x0)
    thin = replace(UNKNOWN, depth=depth, drives=True)
    form = inflated_form(camera, mask, replace(base, hold=0.0), thin, facing=True)
    return replace(form, kind="board")


def _turned_form(camera: Camera, mask: BoolArray, base: Base, usual: Usual) -> Form | None:
    """The mask over the footprint that is seen; None for what has no wheels, or shows none.

    What has gaps, as a bicycle has, is no prism.
    """
    if not (usual.drives and at_work("prisms")) or base.free_z or base.hold >= 1:
        return None
    if solidity(mask) < FORM.min_solidity:
        return None
    aspect = usual.aspect[0] if usual.aspect else None
    plan = plan_seen(mask, camera, base.z, usual.depth, aspect)
    if plan is None or not plan.shown:
        return None
    body, _ = prism_mesh(mask, camera, plan)
    eye = np.asarray(camera.position)
    low, high = (eye + (end - eye) * (eye[2] - base.z) for end in (body.min(0), body.max(0)))
    x, y, z = (float(value) for value in high - low)
    shape = Inflated(size=(x, y, z), turn=round(plan.turn, 2), thickness=round(plan.slim, 4))
    mesh = inflated_mesh(mask, camera, shape)
    place = _centred(mesh, (float(low[0] + high[0]) / 2, float(low[1] + high[1]) / 2), base.z)
    value = iou(silhouette(camera, mesh.vertices + np.array(place), mesh.faces), mask)
    if value < FORM.min_turned_iou:
        return None
    merit = value - FORM.inflated_cost + PRIMITIVE.named_gain * ("inflated" in usual.shapes)
    return Form("inflated", shape, mesh, place, IDENTITY, value, merit)


def flat_form(camera: Camera, mask: BoolArray, base: Base, usual: Usual) -> Form | None:
    """The mask inflated where it lies on the level plane; None for what is seen from too low.

    What is thick hides how far it reaches along the ground. What is not known to lie is taken for
    lying where it is seen from right above: upright, its mask would show its top only.
    """
    if not at_work("flat inflated") or base.free_z or base.hold >= 1:
        return None
    x0, y0, x1, y1 = bounds(mask)
    ray = camera.rays(np.array([[(x0 + x1) / 2, (y0 + y1) / 2]]))[0]
    down = -float(ray[2]) / float(np.linalg.norm(ray))
    thin = usual.lies is not None and usual.lies <= FORM.thin_share
    least = FORM.above_deg if usual.lies is None else FORM.thin_deg if thin else FORM.thick_deg
    if down < math.sin(math.radians(least)):
        return None
    round_half = natural_depth(mask) / 2 * metres_per_pixel(camera, (base.x, base.y, base.z))
    length = float(np.ptp(on_plane(camera, _corners(mask), base.z), axis=0)[:2].max())
    half = round_half if usual.lies is None else min(round_half, usual.lies * length / 2)
    spots = on_plane(camera, _corners(mask), base.z + half)
    if not np.isfinite(spots).all() or not half > 0:
        return None
    low, high = spots.min(0), spots.max(0)
    size = (float(high[0] - low[0]), float(high[1] - low[1]), 2 * half)
    shape = Inflated(size=size, flat=True)
    mesh = inflated_mesh(mask, camera, shape)
    place = _centred(mesh, (float(low[0] + high[0]) / 2, float(low[1] + high[1]) / 2), base.z)
    value = iou(silhouette(camera, mesh.vertices + np.array(place), mesh.faces), mask)
    named = usual.lies is not None or "inflated" in usual.shapes
    merit = value - FORM.inflated_cost + PRIMITIVE.named_gain * named
    return Form("inflated", shape, mesh, place, IDENTITY, value, merit)


def _corners(mask: BoolArray) -> FloatArray:
    """Points (N, 2) of the mask's outline."""
    outlines, _ = cv2.findContours(mask.astype(np.uint8), cv2.RETR_EXTERNAL, cv2.CHAIN_APPROX_NONE)
    return np.vstack(outlines)[:, 0].astype(float) + 0.5


def _centred(mesh: Mesh, middle: tuple[float, float], foot: float) -> tuple[float, float, float]:
    """Position of the centre of mass that puts the bounding box over `middle` on `foot`."""
    low, high = mesh.vertices.min(0), mesh.vertices.max(0)
    offset = (low + high) / 2
    return middle[0] - float(offset[0]), middle[1] - float(offset[1]), foot - float(low[2])


def lowest(mesh: Mesh, rotation: Sequence[float]) -> float:
    """z of the lowest point of a turned mesh, relative to its centre of mass, m."""
    return float((mesh.vertices @ matrix_of(rotation).T)[:, 2].min())


def highest(mesh: Mesh, rotation: Sequence[float]) -> float:
    """z of the highest point of a turned mesh, relative to its centre of mass, m."""
    return float((mesh.vertices @ matrix_of(rotation).T)[:, 2].max())
