"""The form of one object: primitive, surface of revolution or inflation, whichever shows best."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from physagent_studio.program.base import IDENTITY
from physagent_studio.program.camera import Camera
from physagent_studio.program.rotations import matrix_of
from physagent_studio.program.scene import Inflated, Shape
from physagent_studio.reconstruction.geometry import metres_per_pixel, on_upright
from physagent_studio.reconstruction.inflation import inflated_mesh, natural_depth
from physagent_studio.reconstruction.masks import BoolArray, bounds, iou
from physagent_studio.reconstruction.meshes import mesh_of
from physagent_studio.reconstruction.names import Usual
from physagent_studio.reconstruction.revolve import mirror_symmetry, revolved
from physagent_studio.reconstruction.shapes import PRIOR, Base, fit_all
from physagent_studio.reconstruction.silhouette import silhouette
from physagent_studio.records.scene import Mesh

FloatArray = NDArray[np.float64]
PRIMITIVES = ("sphere", "ellipsoid", "cylinder", "frustum", "capsule", "box")
REVOLVED_COST = 0.04
INFLATED_COST = 0.07


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
    kinds: Sequence[str] | None = None,
) -> list[Form]:
    """All forms that fit the mask at `base`, best first; never empty for a mask of ≥ 12 pixels.

    kinds: only these, if given.
    """
    wanted = tuple(kinds) if kinds else _worth_trying(mask, usual)
    found = [
        Form(fit.shape.kind, fit.shape, mesh_of(fit.shape), fit.position, fit.rotation, fit.iou, m)
        for fit in fit_all(
            camera, mask, base, [k for k in PRIMITIVES if k in wanted], usual.shapes
        )
        for m in [fit.merit]
    ]
    if "revolved" in wanted:
        found += _revolved_form(camera, mask, base, usual)
    if "inflated" in wanted or not found:
        found.append(_inflated_form(camera, mask, base, usual))
    return sorted(found, key=lambda form: -form.merit)


def _worth_trying(mask: BoolArray, usual: Usual) -> tuple[str, ...]:
    """A name that says "free form" spares the primitives; a clear name tries its own first."""
    if usual.shapes == ("inflated",):
        return ("inflated",)
    if usual.shapes == ("sphere",):
        return ("sphere", "ellipsoid", "inflated")
    kinds = [*PRIMITIVES, "inflated"]
    if mirror_symmetry(mask) > 0.9:
        kinds.append("revolved")
    return tuple(kinds)


def _revolved_form(camera: Camera, mask: BoolArray, base: Base, usual: Usual) -> list[Form]:
    made = revolved(camera, mask, base)
    if made is None:
        return []
    shape, position = made
    mesh = mesh_of(shape)
    seen = silhouette(camera, mesh.vertices + np.array(position), mesh.faces)
    value = iou(seen, mask)
    merit = value - REVOLVED_COST + PRIOR * ("revolved" in usual.shapes)
    return [Form("revolved", shape, mesh, position, IDENTITY, value, merit)]


def _inflated_form(camera: Camera, mask: BoolArray, base: Base, usual: Usual) -> Form:
    x0, y0, x1, y1 = bounds(mask)
    natural = natural_depth(mask)
    wanted = usual.depth * (x1 - x0) if usual.depth else natural
    # The foot that is seen is the near rim; the middle plane lies half a depth behind it.
    middle_y = base.y
    if base.hold < 1 and not base.free_z:
        pixel = metres_per_pixel(camera, (base.x, base.y, base.z))
        middle_y = base.y + (1 - base.hold) * 0.5 * min(wanted, x1 - x0) * pixel
    corners = on_upright(camera, [(x0, y1), (x1, y1), ((x0 + x1) / 2, y0)], middle_y)
    width = abs(float(corners[1, 0] - corners[0, 0]))
    low = float(corners[:2, 2].mean())
    height = abs(float(corners[2, 2]) - low)
    size = (width, max(wanted * width / max(x1 - x0, 1), 1e-4), height)
    shape = Inflated(size=size)
    mesh = inflated_mesh(mask, camera, shape)
    middle = (float(corners[2, 0]), middle_y)
    foot = low if base.free_z else base.z
    place = _centred(mesh, middle, foot)
    seen = silhouette(camera, mesh.vertices + np.array(place), mesh.faces)
    value = iou(seen, mask)
    merit = value - INFLATED_COST + PRIOR * ("inflated" in usual.shapes)
    return Form("inflated", shape, mesh, place, IDENTITY, value, merit)


def _centred(
    mesh: Mesh, middle: tuple[float, float], foot: float
) -> tuple[float, float, float]:
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
