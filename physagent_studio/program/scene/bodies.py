"""How an object holds together: rigid, deformable, loose or breakable.

Stiffness and yield are in Pa. `pinned` names the part that is held to the world in its first
pose. Grains and liquids fill the object's shape with spheres; a liquid is a visual proxy of
frictionless spheres and not a fluid solver.
"""

from typing import Annotated, Literal

from pydantic import Field

from physagent_studio.program.base import Frozen, Position, Quaternion, Size

Pascals = Annotated[float, Field(ge=10.0, le=1e12)]
PoissonRatio = Annotated[float, Field(ge=0.0, le=0.49)]
Damping = Annotated[float, Field(ge=0.0, le=100.0)]
Pinned = Literal["none", "bottom", "top", "left", "right", "top_corners", "all_corners"]


class Rigid(Frozen):
    """Keeps its shape."""

    kind: Literal["rigid"] = "rigid"


class Soft(Frozen):
    """An elastic solid that comes back to its shape."""

    kind: Literal["soft"] = "soft"
    young: Pascals = 2e5
    poisson: PoissonRatio = 0.3
    damping: Damping = 0.02
    pinned: Pinned = "none"


class Plastic(Frozen):
    """A solid that keeps part of its deformation above `yield_strain`."""

    kind: Literal["plastic"] = "plastic"
    young: Pascals = 2e5
    poisson: PoissonRatio = 0.3
    damping: Damping = 0.05
    yield_strain: Annotated[float, Field(gt=0, le=1)] = 0.05
    pinned: Pinned = "none"


class Cloth(Frozen):
    """A thin sheet spanning the two largest extents of the object's shape."""

    kind: Literal["cloth"] = "cloth"
    thickness: Annotated[float, Field(gt=0, le=0.1)] = 0.002
    young: Pascals = 1e6
    damping: Damping = 0.02
    cells: Annotated[int, Field(ge=2, le=40)] = 14
    pinned: Pinned = "top"


class Rope(Frozen):
    """A rope along the longest extent of the object's shape."""

    kind: Literal["rope"] = "rope"
    thickness: Annotated[float, Field(gt=0, le=0.5)] = 0.01
    young: Pascals = 1e7
    damping: Damping = 0.02
    segments: Annotated[int, Field(ge=2, le=100)] = 20
    pinned: Literal["none", "top", "bottom", "left", "right", "both"] = "top"


class Granular(Frozen):
    """Dry grains that fill the shape and flow when nothing holds them.

    grains: how many spheres stand for them. cohesion: 0 runs like dry sand, 1 keeps its shape
    until it is hit.
    """

    kind: Literal["granular"] = "granular"
    grains: Annotated[int, Field(ge=8, le=1000)] = 300
    cohesion: Annotated[float, Field(ge=0, le=1)] = 0.0


class Liquid(Frozen):
    """A visual proxy of a liquid: frictionless spheres that fill the shape."""

    kind: Literal["liquid"] = "liquid"
    grains: Annotated[int, Field(ge=8, le=1000)] = 300


class Piece(Frozen):
    """A box-shaped piece of a breakable object, in its body frame, m."""

    position: Position
    size: Size
    rotation: Quaternion = (1.0, 0.0, 0.0, 0.0)


class Breakable(Frozen):
    """Pre-cut pieces joined by welds that let go above an impulse.

    pieces: given one by one, or the shape's bounding box cut into `cuts` parts along body x, y
    and z. release_impulse: N·s that a joint's pieces must take within one control step.
    """

    kind: Literal["breakable"] = "breakable"
    cuts: tuple[
        Annotated[int, Field(ge=1, le=6)],
        Annotated[int, Field(ge=1, le=6)],
        Annotated[int, Field(ge=1, le=6)],
    ] = (2, 2, 2)
    pieces: tuple[Piece, ...] = Field(default=(), max_length=64)
    release_impulse: Annotated[float, Field(gt=0, le=1e6)] = 1.0


Body = Annotated[
    Rigid | Soft | Plastic | Cloth | Rope | Granular | Liquid | Breakable,
    Field(discriminator="kind"),
]
DEFORMABLE = frozenset({"soft", "plastic", "cloth", "rope", "granular", "liquid"})
"""Kinds whose shape is carried by `Rollout.vertices`."""


FLUTTER = 0.12
"""Share of its broad side with which a cloth catches a wind that blows along it, since it flutters
(Carruthers and Filippone 2005, J. Aircraft 42, 976: flags about .1 to .2)."""
