"""`SceneState`, the S of a program P = (S, E): what is in the picture and what it is made of.

A geometric field that is None is *open*: reconstruction fills it and keeps everything else, so
a number that a person or a case gave survives every rerun. Derived data (masks, meshes, the
background plate) are not here; they belong to `records.Scene`.
"""

from typing import Annotated, Any, Literal

from pydantic import Field

from physagent_studio.program.base import (
    IDENTITY,
    Degrees,
    Frozen,
    Length,
    Name,
    Pixel,
    Pixels,
    Position,
    Quaternion,
    Source,
    Text,
    Tilt,
)
from physagent_studio.program.scene.aloft import Aloft
from physagent_studio.program.scene.bodies import Body, Rigid
from physagent_studio.program.scene.camera import Camera
from physagent_studio.program.scene.forms import (
    Box,
    Capsule,
    Cylinder,
    Ellipsoid,
    Floor,
    Frustum,
    Inflated,
    Meshed,
    MeshedSupport,
    Ramp,
    Revolved,
    Shape,
    Slab,
    Sphere,
    SupportShape,
    Torus,
    Vessel,
    Wall,
)

Density = Annotated[float, Field(ge=0.1, le=30000)]
Friction = Annotated[float, Field(ge=0, le=5)]
Restitution = Annotated[float, Field(ge=0, le=1)]
Rolling = Annotated[float, Field(ge=0, le=1)]


# --- grounding: what a person clicked --------------------------------------------------------


class Click(Frozen):
    """A click in the picture; label 1 lies inside the thing, 0 outside."""

    x: Annotated[float, Field(ge=-1e5, le=1e5)]
    y: Annotated[float, Field(ge=-1e5, le=1e5)]
    label: Literal[0, 1] = 1


class Mark(Frozen):
    """A click on a named part of a support, pixels.

    toe: where a ramp's slope meets the ground; a second one is the other corner of that edge.
    top: a ramp's upper end, or a corner of a level top. foot: the place on the ground below the
    first `top`; for a wall, where it meets the ground. end: far end of a ramp's level part.
    """

    role: Literal["toe", "top", "foot", "end"]
    x: Pixels
    y: Pixels


class Stroke(Frozen):
    """A correction of a mask, drawn by a person in the picture.

    tool: `brush` is a line through `points`, `radius` pixels to each side; `scissors` is the
    closed polygon of `points`, whose `radius` does not matter. effect: what is covered belongs to
    the thing (`add`), does not (`erase`), or is all of it (`only`). Later strokes win. points: in
    pixels of the stored image.
    """

    tool: Literal["brush", "scissors"] = "brush"
    effect: Literal["add", "erase", "only"] = "add"
    radius: Annotated[float, Field(gt=0, le=500)] = 6.0
    points: tuple[Pixel, ...] = Field(min_length=1, max_length=600)


class Grounding(Frozen):
    """How a name is tied to the picture: clicks, a box, the chosen mask, marks on a support.

    strokes: a person's corrections of the chosen mask. settled: a person has chosen the mask, so
    that clicks on other things no longer change it. proposed: nobody clicked, the points were
    found by the thing's words.
    """

    points: tuple[Click, ...] = Field(default=(), max_length=500)
    box: tuple[Pixels, Pixels, Pixels, Pixels] | None = None
    candidate: Annotated[int, Field(ge=0, le=15)] = 0
    marks: tuple[Mark, ...] = Field(default=(), max_length=16)
    strokes: tuple[Stroke, ...] = Field(default=(), max_length=64)
    settled: bool = False
    proposed: bool = False

    def marked(self, role: str) -> tuple[Pixel, ...]:
        """Pixels of the marks of that role, in their order."""
        return tuple((mark.x, mark.y) for mark in self.marks if mark.role == role)

    @property
    def inside(self) -> tuple[tuple[float, float], ...]:
        """Pixels that show it: clicks on it, else the middle of the box around it."""
        clicks = tuple((click.x, click.y) for click in self.points if click.label)
        if clicks or self.box is None:
            return clicks
        left, top, right, bottom = self.box
        return (((left + right) / 2, (top + bottom) / 2),)

    @property
    def shows_something(self) -> bool:
        """Whether there is anything from which a mask can be made."""
        inside = any(click.label for click in self.points)
        return inside or self.box is not None or any(s.effect != "erase" for s in self.strokes)


# --- things ----------------------------------------------------------------------------------


FormKind = Literal[
    "sphere",
    "ellipsoid",
    "cylinder",
    "frustum",
    "capsule",
    "torus",
    "box",
    "revolved",
    "inflated",
    "board",
]


class Wheels(Frozen):
    """What a thing stands on that rolls along one way and grips across it.

    heading: degrees in the world, seen from above at the initial pose, of where its front points:
    0 right, 90 away from the camera. rolling: resistance along, force over weight. grip: Coulomb
    friction across; None is that of its material on what carries it. known: whether the front is
    seen or was told, else it is assumed. It moves along its heading and keeps it, unless what
    pushes it is stronger than the grip; lying on its side it slides as its material does.
    """

    heading: Degrees
    rolling: Rolling = 0.02
    grip: Friction | None = None
    known: bool = False


class SceneObject(Frozen):
    """A thing that can move.

    position: centre of mass in the world, m. rotation: pose R_world_body; reconstruction sets it
    together with an open shape. support: what it stands on in the picture (support or object),
    "air" for nothing, None for open. aloft: it `hangs` in the air until the first action on it
    begins, or `floats` without weight; None: in the air it falls. tether: length of the thread or
    cord that it is seen to hang by, from its middle to where that is held, m; None where none is
    seen. material: a row of `program.materials`; density (kg/m³), friction, restitution and rolling
    (resistance of round things, the force that it takes to keep one rolling over its weight)
    override that row. body: how it holds together. wheels: on which it stands, None for none.
    balances: it keeps its balance, as a person or an animal does, and does not tilt. form: the kind
    of shape that an open `shape` becomes; None leaves the choice open too; `board` is its outline
    cut out of a board, the last resort where no kind shows it.
    """

    name: Name
    grounding: Grounding = Grounding()
    form: FormKind | None = None
    shape: Shape | None = None
    position: Position | None = None
    rotation: Quaternion = IDENTITY
    support: Name | None = None
    aloft: Aloft | None = None
    tether: Length | None = None
    material: Name = "plastic"
    density: Density | None = None
    friction: Friction | None = None
    restitution: Restitution | None = None
    rolling: Rolling | None = None
    wheels: Wheels | None = None
    balances: bool | None = None
    body: Body = Rigid()
    source: Source = "estimated"


class Support(Frozen):
    """A thing that does not move and carries others; shape None is still unresolved."""

    name: Name
    grounding: Grounding = Grounding()
    shape: SupportShape | None = None
    material: Name = "wood"
    friction: Friction | None = None
    restitution: Restitution | None = None
    rolling: Rolling | None = None
    source: Source = "estimated"


class Landmark(Frozen):
    """A named place: a point, a line, an area or an opening, on a support or in space.

    pixels: where it was clicked. points: the same places in the world, m; None is open.
    """

    name: Name
    kind: Literal["point", "line", "area", "opening"]
    on: Name | None = None
    pixels: tuple[Pixel, ...] = Field(default=(), max_length=64)
    points: tuple[Position, ...] | None = Field(default=None, max_length=64)
    source: Source = "estimated"


class Scale(Frozen):
    """What fixes metres: the reference's name, its assumed size, and where that came from."""

    reference: Name | None = None
    metres: Length | None = None
    source: Source = "assumed"


class SceneState(Frozen):
    """Everything that reconstruction knows or has to find, in the world frame.

    horizon: its row in the middle column of the picture, pixels; horizon_source: who says so.
    roll: degrees by which the camera is turned clockwise: the horizon rises to the right by them.
    """

    camera: Camera | None = None
    horizon: Annotated[float, Field(ge=-1e5, le=1e5)] | None = None
    horizon_source: Source = "estimated"
    roll: Tilt = 0.0
    gravity: tuple[float, float, float] = (0.0, 0.0, -9.81)
    scale: Scale = Scale()
    objects: tuple[SceneObject, ...] = Field(default=(), max_length=200)
    supports: tuple[Support, ...] = Field(default=(), max_length=64)
    landmarks: tuple[Landmark, ...] = Field(default=(), max_length=64)
    flags: tuple[Text, ...] = Field(default=(), max_length=64)

    @property
    def names(self) -> tuple[str, ...]:
        """Names of all that is in it: objects, supports, landmarks."""
        return tuple(one.name for one in (*self.objects, *self.supports, *self.landmarks))

    def object(self, name: str) -> SceneObject | None:
        """The object of that name, or None."""
        return next((item for item in self.objects if item.name == name), None)

    def support(self, name: str) -> Support | None:
        """The support of that name, or None."""
        return next((item for item in self.supports if item.name == name), None)

    def landmark(self, name: str) -> Landmark | None:
        """The landmark of that name, or None."""
        return next((item for item in self.landmarks if item.name == name), None)

    @property
    def without(self) -> dict[str, Any]:
        """What a hash leaves out (pydantic's `exclude`): fields that came later and are not used,
        so that a scene without them keeps the hash that it always had."""
        later = ("wheels", "aloft", "tether", "balances")
        rows = enumerate(self.objects)
        unused = {i: {f for f in later if getattr(o, f) is None} for i, o in rows}
        unused = {i: fields for i, fields in unused.items() if fields}
        return {"objects": unused} if unused else {}

    @property
    def is_closed(self) -> bool:
        """Whether nothing is left for reconstruction to fill, the camera included."""
        return self.camera is not None and self.is_resolved

    @property
    def is_resolved(self) -> bool:
        """Whether nothing that a simulation needs is open."""
        return all(o.shape is not None and o.position is not None for o in self.objects) and all(
            s.shape is not None for s in self.supports
        )
