"""What pulling at a side of a thing's box makes of its shape."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from pydantic import JsonValue

from physagent_studio.program import Edit, SceneObject, SetField
from physagent_studio.program.rotations import matrix_of
from physagent_studio.program.scene import state as shapes
from physagent_studio.program.scene.aloft import in_air
from physagent_studio.records import Mesh

FloatArray = NDArray[np.float64]
LEAST, MOST = 0.1, 10.0
"""What one pull may make of a length."""


def pulled(start: FloatArray, centre: FloatArray, eye: FloatArray, pointer: FloatArray) -> float:
    """By how much the line from `centre` to `start` grows when its end follows a pointer.

    All world, m. The pointer is a ray from `eye` through `pointer`; the new end is the point of
    the line that comes closest to it.
    """
    line, ray = start - centre, pointer - eye
    if not np.isfinite(ray).all() or np.linalg.norm(line) < 1e-9 or np.linalg.norm(ray) < 1e-9:
        return 1.0
    ray = ray / np.linalg.norm(ray)
    # Closest points of two lines: centre + s·line and eye + t·ray.
    across = line - (line @ ray) * ray
    if across @ across < 1e-6 * (line @ line):
        return 1.0
    grown = float(((eye - centre) @ across) / (across @ across))
    return min(max(grown, LEAST), MOST)


def factors_of(shape: shapes.Shape, axis: int | None, grown: float) -> FloatArray:
    """(3,) how a shape grows along its axes when it is pulled along one; None pulls at all."""
    factors = np.ones(3)
    if axis is None or isinstance(shape, shapes.Sphere):
        return factors * grown
    factors[axis] = grown
    round_ = shapes.Cylinder | shapes.Capsule | shapes.Frustum | shapes.Revolved | shapes.Torus
    if axis < 2 and isinstance(shape, round_):
        factors[:2] = grown
    return factors


def scaled(shape: shapes.Shape, factors: FloatArray) -> shapes.Shape | None:
    """The shape that is larger by `factors` along its axes; None for one without a size."""
    x, z = float(factors[0]), float(factors[2])
    change: dict[str, object]
    match shape:
        case shapes.Sphere():
            change = {"radius": _neat(shape.radius * x)}
        case shapes.Ellipsoid():
            change = {"radii": _each(shape.radii, factors)}
        case shapes.Box() | shapes.Inflated() | shapes.Meshed():
            change = {"size": _each(shape.size, factors)}
        case shapes.Cylinder() | shapes.Capsule():
            change = {"radius": _neat(shape.radius * x), "height": _neat(shape.height * z)}
        case shapes.Torus():
            change = {"radius": _neat(shape.radius * x), "tube": _neat(shape.tube * z)}
        case shapes.Frustum():
            change = {
                "bottom_radius": _neat(shape.bottom_radius * x),
                "top_radius": _neat(shape.top_radius * x),
                "height": _neat(shape.height * z),
            }
        case shapes.Revolved():
            profile = [[_neat(at * z), _neat(radius * x)] for at, radius in shape.profile]
            change = {"profile": profile}
        case _:
            return None
    return type(shape).model_validate(shape.model_dump() | change)


def _neat(value: float) -> float:
    return float(f"{value:.5g}")


def _each(values: tuple[float, float, float], factors: FloatArray) -> list[float]:
    return [_neat(one * float(factor)) for one, factor in zip(values, factors, strict=True)]


def scaling(item: SceneObject, mesh: Mesh, factors: FloatArray) -> tuple[Edit, ...]:
    """The edits that scale an object; what stands on something keeps standing there."""
    if item.shape is None or item.position is None:
        return ()
    made = scaled(item.shape, factors)
    if made is None or made == item.shape:
        return ()
    path = f"scene.objects.{item.name}"
    edits: list[Edit] = [SetField(path=f"{path}.shape", value=made.model_dump(mode="json"))]
    if not in_air(item):
        up = mesh.vertices @ matrix_of(item.rotation)[2]
        grown = (mesh.vertices * factors) @ matrix_of(item.rotation)[2]
        x, y, z = item.position
        place: list[JsonValue] = [x, y, _neat(z + float(up.min() - grown.min()))]
        edits.append(SetField(path=f"{path}.position", value=place))
    return tuple(edits)
