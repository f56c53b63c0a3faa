"""Open vessels: forms with walls and a bottom for what things fall into."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from physagent_studio.knowledge import Usual
from physagent_studio.program.scene.state import Box, Cylinder, Frustum, Revolved, Shape
from physagent_studio.reconstruction.shapes.forms import Form
from physagent_studio.reconstruction.shapes.meshes import mesh_of

CAN_BE_HOLLOW = ("box", "cylinder", "frustum", "revolved")
"""Kinds of forms that walls can be given."""


def hollow_kinds(usual: Usual) -> Usual:
    """What is usual for a vessel: only forms that can be hollow, with a rim for turned ones."""
    kinds = tuple(kind for kind in usual.shapes if kind in CAN_BE_HOLLOW)
    turned = ("bowl",) if "revolved" in kinds else ()
    return replace(usual, shapes=(*turned, *kinds) or ("bowl", "frustum", "box"))


def hollow_first(found: Sequence[Form]) -> Form:
    """The best of several forms, best first, that can be hollow; the best of all where none can."""
    return next((form for form in found if _hollow(form.shape) is not None), found[0])


def opened(form: Form) -> Form:
    """The form with walls and a bottom, open at the top; what cannot be hollow stays as it is."""
    shape = _hollow(form.shape)
    if shape is None:
        return form
    return replace(form, kind=shape.kind, shape=shape, mesh=mesh_of(shape))


def _hollow(shape: Shape) -> Shape | None:
    match shape:
        case Cylinder(radius=radius, height=height):
            return Frustum(
                bottom_radius=radius, top_radius=radius, height=height, wall=_wall(radius, height)
            )
        case Frustum(top_radius=radius, height=height) if radius >= 0.5 * shape.bottom_radius:
            return shape.model_copy(update={"wall": _wall(radius, height)})
        case Revolved(profile=profile):
            height = abs(profile[-1][0] - profile[0][0])
            return shape.model_copy(update={"wall": _wall(profile[-1][1], height)})
        case Box(size=(x, y, z)):
            return shape.model_copy(update={"wall": _wall(min(x, y) / 2, z)})
        case _:
            return None


def _wall(radius: float, height: float) -> float:
    wall_ratio = 0.06  # 0.01..0.2: over the width of the rim
    min_wall_m = 0.0015  # 0.0005..0.005: so thin is a cup; thinner walls are passed through
    return min(max(2 * wall_ratio * radius, min_wall_m), 0.3 * height, 0.4 * radius)
