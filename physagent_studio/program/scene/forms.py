"""Shapes of objects and of supports: what is written in a program, in metres."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import Field, model_validator

from physagent_studio.program.base import (
    IDENTITY,
    Frozen,
    Length,
    Metres,
    Position,
    Quaternion,
    Size,
)

Radians = Annotated[float, Field(ge=-7, le=7)]


# --- shapes of objects; every shape is centred on its own centre of mass ---------------------


class Sphere(Frozen):
    """A ball."""

    kind: Literal["sphere"] = "sphere"
    radius: Length


class Ellipsoid(Frozen):
    """Half-axes along body x, y, z."""

    kind: Literal["ellipsoid"] = "ellipsoid"
    radii: Size


class Box(Frozen):
    """An axis-aligned box in the body frame; `size` are the full edge lengths.

    wall: thickness of the sides and the bottom of a box that is open at the top; None is solid.
    The body frame stays that of the solid.
    """

    kind: Literal["box"] = "box"
    size: Size
    wall: Length | None = None


class Cylinder(Frozen):
    """Axis along body z."""

    kind: Literal["cylinder"] = "cylinder"
    radius: Length
    height: Length


class Capsule(Frozen):
    """Axis along body z; `height` includes both caps, so it is at least twice the radius."""

    kind: Literal["capsule"] = "capsule"
    radius: Length
    height: Length


class Torus(Frozen):
    """A ring about body z (tyre, hoop, doughnut): `radius` to the middle of its round tube.

    tube: radius of the tube. A tube thicker than the ring's radius closes the hole.
    """

    kind: Literal["torus"] = "torus"
    radius: Length
    tube: Length


class Frustum(Frozen):
    """A cone cut parallel to its base (a cup, a bucket); axis along body z.

    wall: thickness of the side and the bottom of a vessel that is open at the top; None is
    solid. The body frame stays that of the solid.
    """

    kind: Literal["frustum"] = "frustum"
    bottom_radius: Annotated[float, Field(ge=0, le=1e4)]
    top_radius: Annotated[float, Field(ge=0, le=1e4)]
    height: Length
    wall: Length | None = None


class Revolved(Frozen):
    """A surface of revolution about body z: the profile is (z, radius) from bottom to top, m.

    wall: thickness of the side and the bottom of a vessel that is open at the top; None is
    solid.
    """

    kind: Literal["revolved"] = "revolved"
    profile: tuple[tuple[Metres, Annotated[float, Field(ge=0, le=1e4)]], ...] = Field(
        min_length=2, max_length=256
    )
    wall: Length | None = None


Corners = Annotated[tuple[Position, ...], Field(max_length=64)]


class Inflated(Frozen):
    """The object's mask inflated along camera rays; `thickness` scales depth to width.

    `size` is the bounding box (x, y, z) of the result in the body frame, metres. `flat`: the thing
    lies, so that its outline is that of the level plane rather than of an upright one. `straight`:
    front and back are flat, and its sides run straight from one to the other, with a rounded rim.
    `turn`: degrees of its length, seen from above: one side of it over all its width, which is
    `thickness` times its length; None for what faces the view.
    `facing`: its front faces the view, wherever feet are seen. `seat`: the share of its height,
    from below, at which it has a level place to stand on: above that only its back goes on.
    `hull`: where it ends, some corners of its convex hull in the body frame, metres, as large as
    `size` says; without them it counts as an ellipsoid.
    """

    kind: Literal["inflated"] = "inflated"
    size: Size
    thickness: Annotated[float, Field(gt=0, le=5)] = 1.0
    flat: bool = False
    straight: bool = False
    turn: Annotated[float, Field(ge=-360, le=360)] | None = None
    facing: bool = False
    seat: Annotated[float, Field(gt=0, lt=1)] | None = None
    hull: Corners = ()


class Meshed(Frozen):
    """A triangle mesh given by value; `asset` is the content hash of the stored mesh.

    `size` and `hull`: as of what is inflated; without a hull it counts as a box.
    """

    kind: Literal["mesh"] = "mesh"
    asset: Annotated[str, Field(pattern=r"^[0-9a-f]{16,64}$")]
    size: Size
    hull: Corners = ()


Shape = Annotated[
    Sphere | Ellipsoid | Box | Cylinder | Capsule | Torus | Frustum | Revolved | Inflated | Meshed,
    Field(discriminator="kind"),
]


# --- supports: what does not move ------------------------------------------------------------


class Floor(Frozen):
    """The half-space z ≤ `height`."""

    kind: Literal["floor"] = "floor"
    height: Metres = 0.0


class Wall(Frozen):
    """The half-space behind a vertical plane: `point` on it, `yaw` of its outward normal."""

    kind: Literal["wall"] = "wall"
    point: Position
    yaw: Radians


class Slab(Frozen):
    """A solid box (table, shelf, step): `position` is its centre, `yaw` its turn about +z.

    rail: width of two rails; only they are there, along the long sides of the box.
    """

    kind: Literal["box"] = "box"
    position: Position
    size: Size
    yaw: Radians = 0.0
    rail: Length | None = None


class Ramp(Frozen):
    """A solid wedge, optionally with a flat plateau behind its top edge; or stairs.

    toe: middle of the lower edge on the ground. yaw: uphill direction, counter-clockwise from
    +x seen from above. run: horizontal length of the slope. rise: height. width: across. steps: of
    stairs, 0 for a slope: equal ones, the first rises at the toe, the edge of the uppermost lies
    `run` behind it, and that one is `plateau` deep or as deep as the others.
    """

    kind: Literal["ramp"] = "ramp"
    toe: Position
    yaw: Radians
    run: Length
    rise: Length
    width: Length
    plateau: Annotated[float, Field(ge=0, le=1e4)] = 0.0
    steps: Annotated[int, Field(ge=0, le=64)] = 0


class MeshedSupport(Frozen):
    """A triangle mesh that does not move; `asset` is the content hash of the stored mesh.

    position, rotation: pose R_world_body of the mesh's own frame. size: its bounding box there,
    centred on the origin, metres.
    """

    kind: Literal["mesh"] = "mesh"
    asset: Annotated[str, Field(pattern=r"^[0-9a-f]{16,64}$")]
    position: Position
    rotation: Quaternion = IDENTITY
    size: Size


class Vessel(Frozen):
    """An open vessel (bowl, tray, basket, box without a lid): what goes into it stays in it.

    body: its form, as that of an object that is hollow: it has a wall. position: of that form's
    centre of mass as a solid. yaw: its turn about +z.
    """

    kind: Literal["vessel"] = "vessel"
    position: Position
    yaw: Radians = 0.0
    body: Annotated[Frustum | Box | Revolved, Field(discriminator="kind")]

    @model_validator(mode="after")
    def _has_a_wall(self) -> Vessel:
        if self.body.wall is None:
            raise ValueError("the body of a vessel needs a wall (its thickness, m)")
        return self


SupportShape = Annotated[
    Floor | Wall | Slab | Ramp | Vessel | MeshedSupport, Field(discriminator="kind")
]
