"""Geoms of a spec: the convex pieces of objects and supports, and what supports are made of."""

import math
from typing import Any

import numpy as np

from physagent_studio.program.rotations import about_up, multiply
from physagent_studio.program.scene import forms
from physagent_studio.program.scene.boards import rails_of
from physagent_studio.program.scene.stairs import treads_of
from physagent_studio.simulation.bodies.solids import Hull, Piece, Solid
from physagent_studio.simulation.mj import Spec, SpecBody, mj
from physagent_studio.simulation.surfaces import FloatArray, hull, prism

GEOM_TYPES = {
    "sphere": mj.mjtGeom.mjGEOM_SPHERE,
    "ellipsoid": mj.mjtGeom.mjGEOM_ELLIPSOID,
    "box": mj.mjtGeom.mjGEOM_BOX,
    "cylinder": mj.mjtGeom.mjGEOM_CYLINDER,
    "capsule": mj.mjtGeom.mjGEOM_CAPSULE,
}

TOUCH: dict[str, Any] = {
    "contype": 0,
    "conaffinity": 2,
    "friction": [0.0, 0.005, 0.0001],
    "solref": [0.01, 1.0],
}
"""Rigid geoms meet one another in explicit pairs only, with our rule. Deformables and grains find
them by themselves, and bring the friction, since MuJoCo takes the larger one there."""


def is_flat(shape: forms.SupportShape | None, width: float) -> bool:
    """Whether a thing of that width (m) meets a support as it would meet a half-space."""
    if isinstance(shape, forms.Slab):
        return shape.rail is None and min(shape.size[:2]) >= width
    return isinstance(shape, forms.Floor | forms.Wall) or (
        isinstance(shape, forms.Ramp) and not shape.steps
    )


def add_piece(spec: Spec, body: SpecBody, name: str, piece: Piece) -> None:
    """One convex piece of a body."""
    # No geom collides on its own: every contact comes from an explicit pair with our rule.
    if isinstance(piece, Hull):
        spec.add_mesh(name=name, uservert=piece.vertices.ravel(), userface=piece.faces.ravel())
        body.add_geom(name=name, type=mj.mjtGeom.mjGEOM_MESH, meshname=name, **TOUCH)
        return
    kind = GEOM_TYPES[piece.kind]
    body.add_geom(name=name, type=kind, size=piece.size, pos=piece.place, quat=piece.turn, **TOUCH)


def add_support(
    spec: Spec, name: str, shape: forms.Floor | forms.Wall | forms.Slab | forms.Ramp
) -> list[str]:
    """A support that does not move; returns the names of its geoms."""
    label = f"support/{name}"
    body = spec.worldbody.add_body(name=label)
    plane = {"type": mj.mjtGeom.mjGEOM_PLANE, "size": [0, 0, 1]}
    match shape:
        case forms.Floor(height=height):
            body.pos = [0, 0, height]
            body.add_geom(name=label, **TOUCH, **plane)
        case forms.Wall(point=point, yaw=yaw):
            body.pos = point
            # Turns the plane's normal from +z to the horizontal direction `yaw`.
            half = math.sqrt(0.5)
            tilt = (half, 0.0, half, 0.0)
            body.quat = multiply(about_up(yaw), tilt)
            body.add_geom(name=label, **TOUCH, **plane)
        case forms.Slab(rail=rail) if rail is not None:
            return _add_rails(body, label, shape)
        case forms.Slab(position=position, size=size, yaw=yaw):
            body.pos, body.quat = position, about_up(yaw)
            half_size = [edge / 2 for edge in size]
            kind = mj.mjtGeom.mjGEOM_BOX
            body.add_geom(name=label, type=kind, size=half_size, **TOUCH)
        case forms.Ramp(steps=steps) if steps > 0:
            return _add_stairs(body, label, shape)
        case forms.Ramp(toe=toe, yaw=yaw):
            body.pos, body.quat = toe, about_up(yaw)
            vertices, faces = hull(ramp_corners(shape), name)
            spec.add_mesh(name=label, uservert=vertices.ravel(), userface=faces.ravel())
            kind = mj.mjtGeom.mjGEOM_MESH
            body.add_geom(name=label, type=kind, meshname=label, **TOUCH)
    return [label]


def _add_rails(body: SpecBody, label: str, slab: forms.Slab) -> list[str]:
    body.pos, body.quat = slab.position, about_up(slab.yaw)
    names = []
    for number, (place, size) in enumerate(rails_of(slab)):
        names.append(f"{label}/{number}")
        kind, half = mj.mjtGeom.mjGEOM_BOX, [edge / 2 for edge in size]
        body.add_geom(name=names[-1], type=kind, size=half, pos=place, **TOUCH)
    return names


def _add_stairs(body: SpecBody, label: str, stairs: forms.Ramp) -> list[str]:
    """A box for each step, from its edge to the back of them all."""
    body.pos, body.quat = stairs.toe, about_up(stairs.yaw)
    treads, names = treads_of(stairs), []
    back, below = treads[-1].end, -max(stairs.rise / len(treads), 0.1)
    for number, tread in enumerate(treads):
        size = [(back - tread.start) / 2, stairs.width / 2, (tread.top - below) / 2]
        place = [(back + tread.start) / 2, 0.0, (tread.top + below) / 2]
        names.append(f"{label}/{number}")
        kind = mj.mjtGeom.mjGEOM_BOX
        body.add_geom(name=names[-1], type=kind, size=size, pos=place, **TOUCH)
        below = tread.top
    return names


def add_solid_support(
    spec: Spec, name: str, shape: forms.MeshedSupport | forms.Vessel, solid: Solid
) -> list[str]:
    """A support that collides in pieces: a mesh, a vessel; returns the names of its geoms."""
    body = spec.worldbody.add_body(name=f"support/{name}")
    turn = about_up(shape.yaw) if isinstance(shape, forms.Vessel) else shape.rotation
    body.pos, body.quat = shape.position, turn
    names = [f"support/{name}/{number}" for number in range(len(solid.pieces))]
    for label, piece in zip(names, solid.pieces, strict=True):
        add_piece(spec, body, label, piece)
    return names


def ramp_corners(ramp: forms.Ramp) -> FloatArray:
    """Corners (N, 3) of the solid under a ramp and its plateau, in the frame of its toe.

    It reaches below the toe, so that nothing meets a feather edge from inside.
    """
    depth = max(ramp.rise, 0.1)
    back = ramp.run + ramp.plateau
    outline = [(0.0, 0.0), (ramp.run, ramp.rise), (back, ramp.rise), (back, -depth), (0.0, -depth)]
    return prism(np.array(sorted(set(outline), key=outline.index)), ramp.width)
