"""Round bodies with small flats at their poles, as fruit has: they carry and are carried."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

from physagent_studio.program.scene.state import Capsule, Ellipsoid, Revolved, Sphere
from physagent_studio.reconstruction.shapes.forms import Form
from physagent_studio.reconstruction.shapes.lying import lies
from physagent_studio.reconstruction.shapes.meshes import capsule_profile, mesh_of


def with_flats(form: Form) -> Form:
    """A round body with small flats at its poles, as fruit has: it can carry and be carried.

    Its height and width stay; other bodies stay as they are, and so does what lies.
    """
    if lies(form.rotation):
        return form
    if isinstance(form.shape, Capsule):
        whole = np.array(capsule_profile(form.shape))
    elif isinstance(form.shape, Sphere | Ellipsoid):
        radii = (form.shape.radius,) * 3 if isinstance(form.shape, Sphere) else form.shape.radii
        turn = np.linspace(-math.pi / 2, math.pi / 2, 49)
        whole = np.column_stack([radii[2] * np.sin(turn), radii[0] * np.cos(turn)])
    else:
        return form
    flat_share = 0.94  # 0.8..1: of a round body's half height, where the flats of a stack begin
    level = np.sin(np.linspace(-1, 1, 25) * math.asin(flat_share)) * whole[-1, 0]
    radius = np.interp(level, whole[:, 0], whole[:, 1])
    shape = Revolved(
        profile=tuple((float(z), float(r)) for z, r in zip(level / flat_share, radius, strict=True))
    )
    return replace(form, kind="revolved", shape=shape, mesh=mesh_of(shape))


def balances_on_a_point(form: Form) -> bool:
    """Whether a round body stands on its end, where it would fall over without a flat there."""
    shape = form.shape
    if lies(form.rotation):
        return False
    if isinstance(shape, Capsule):
        return shape.height > 2.05 * shape.radius
    return isinstance(shape, Ellipsoid) and shape.radii[2] > 1.15 * min(shape.radii[:2])
