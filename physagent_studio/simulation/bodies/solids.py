"""What a shape weighs and what it collides as: convex pieces that MuJoCo takes as they are."""

import math
from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from physagent_studio.program.base import IDENTITY
from physagent_studio.program.rotations import about_up, multiply
from physagent_studio.program.scene import forms
from physagent_studio.program.scene.boards import Size3, open_box
from physagent_studio.program.scene.shapes import frustum_centre
from physagent_studio.records import Mesh
from physagent_studio.simulation.bodies.carving import carved
from physagent_studio.simulation.bodies.vessel import rising, solid_slices, vessel
from physagent_studio.simulation.surfaces import (
    FloatArray,
    MassProperties,
    Surface,
    box_surface,
    ellipsoid_surface,
    hull,
    is_closed,
    mass_properties,
    revolve,
    together,
    welded,
)


@dataclass(frozen=True, eq=False, slots=True)
class Primitive:
    """kind: sphere, ellipsoid, box, cylinder or capsule; size: MuJoCo's half sizes, m.

    place, turn: pose of the piece in the body frame, m and wxyz.
    """

    kind: str
    size: tuple[float, float, float]
    place: tuple[float, float, float] = (0.0, 0.0, 0.0)
    turn: tuple[float, float, float, float] = IDENTITY


CONVEX_ENOUGH = 0.9
"""Volume over hull volume from which on the hull stands for the body."""


@dataclass(frozen=True, eq=False, slots=True)
class Hull:
    """A convex piece, vertices (V, 3) m in the body frame, and its faces (F, 3)."""

    vertices: FloatArray
    faces: np.ndarray


Piece = Primitive | Hull


@dataclass(frozen=True, eq=False, slots=True)
class Solid:
    """Collision pieces, mass properties at density 1, and what had to be approximated.

    extent: (3,) m, size of the bounding box. shadows: (3,) m², silhouette areas along the body
    axes. kind: the primitive's name, or "mesh". note: a sentence about a lossy stand-in, or "".
    rims: pieces that stand for the body's outline where it meets a flat support, and only there.
    barrel: a piece within the others that meets what has edges, beside them.
    """

    pieces: tuple[Piece, ...]
    mass: MassProperties
    extent: FloatArray
    shadows: FloatArray
    kind: str = "mesh"
    note: str = ""
    rims: tuple[Primitive, ...] = ()
    barrel: Primitive | None = None

    @property
    def middle(self) -> FloatArray:
        """(3,) middle of the bounding box, body frame, m: of what is not symmetric it is not the
        centre of mass."""
        hulls = [piece.vertices for piece in self.pieces if isinstance(piece, Hull)]
        if not hulls or len(hulls) < len(self.pieces):
            return np.zeros(3)
        points = np.concatenate(hulls)
        return (points.min(axis=0) + points.max(axis=0)) / 2


Decompose = Callable[[Surface], tuple[Surface, ...] | None]
"""Splits a concave surface into convex ones; None where the backend is missing."""


def solid_of(
    name: str, shape: forms.Shape | forms.MeshedSupport, mesh: Mesh | None, decompose: Decompose
) -> Solid:
    """The solid of an object, or of a support that is a mesh; `name` is for error texts.

    mesh: its visual mesh, used by shapes that are no primitives.
    """
    primitive = _primitive(shape)
    if primitive is not None:
        return primitive
    if isinstance(shape, forms.Revolved):
        return _round(rising(np.array(shape.profile, float)), shape.wall)
    if isinstance(shape, forms.Frustum):
        return _frustum(shape)
    if isinstance(shape, forms.Torus):
        return _torus(shape)
    if isinstance(shape, forms.Box):
        return _open_box(shape)
    assert isinstance(shape, forms.Inflated | forms.Meshed | forms.MeshedSupport)
    return _meshed(name, shape, mesh, decompose)


def _solid(pieces: tuple[Piece, ...], surface: Surface, note: str = "") -> Solid:
    vertices, faces = surface
    a, b, c = (vertices[faces[:, corner]] for corner in range(3))
    # Half of the projected faces: exact for convex bodies, a bound above for others.
    shadows = np.abs(np.cross(b - a, c - a)).sum(0) / 4
    return Solid(pieces, mass_properties(surface), np.ptp(vertices, axis=0), shadows, note=note)


def _primitive(shape: forms.Shape | forms.MeshedSupport) -> Solid | None:
    """Primitives with their closed-form volume and inertia."""
    match shape:
        case forms.Sphere(radius=r):
            return _ellipsoid("sphere", r, r, r)
        case forms.Ellipsoid(radii=(a, b, c)):
            return _ellipsoid("ellipsoid", a, b, c)
        case forms.Box(wall=wall) if wall is not None:
            return None
        case forms.Box(size=(x, y, z)):
            moments = [(y * y + z * z) / 12, (x * x + z * z) / 12, (x * x + y * y) / 12]
            half = (x / 2, y / 2, z / 2)
            return _exact("box", half, x * y * z, moments, [x, y, z], [y * z, x * z, x * y])
        case forms.Cylinder(radius=r, height=h):
            side = (3 * r * r + h * h) / 12
            shadows = [2 * r * h, 2 * r * h, math.pi * r * r]
            moments, extent = [side, side, r * r / 2], [2 * r, 2 * r, h]
            volume = math.pi * r * r * h
            exact = _exact("cylinder", (r, h / 2, 0), volume, moments, extent, shadows)
            return replace(exact, barrel=_barrel(r, h / 2))
        case forms.Capsule(radius=r, height=h):
            return _capsule(r, max(h - 2 * r, 1e-6))
        case _:
            return None


def _ellipsoid(kind: str, a: float, b: float, c: float) -> Solid:
    moments = [(b * b + c * c) / 5, (a * a + c * c) / 5, (a * a + b * b) / 5]
    shadows = [math.pi * b * c, math.pi * a * c, math.pi * a * b]
    volume = 4 / 3 * math.pi * a * b * c
    return _exact(kind, (a, b, c), volume, moments, [2 * a, 2 * b, 2 * c], shadows)


def _capsule(r: float, length: float) -> Solid:
    shaft, ball = math.pi * r * r * length, 4 / 3 * math.pi * r**3
    along = shaft * r * r / 2 + ball * 0.4 * r * r
    # A half ball's centroid lies 3r/8 from its flat face.
    across = shaft * (3 * r * r + length**2) / 12 + ball * (
        0.4 * r * r + length**2 / 4 + 3 * length * r / 8
    )
    volume = shaft + ball
    moments = [across / volume, across / volume, along / volume]
    side = 2 * r * length + math.pi * r * r
    extent, shadows = [2 * r, 2 * r, length + 2 * r], [side, side, math.pi * r * r]
    return _exact("capsule", (r, length / 2, 0), volume, moments, extent, shadows)


def _exact(
    kind: str,
    size: tuple[float, float, float],
    volume: float,
    moments: list[float],
    extent: list[float],
    shadows: list[float],
) -> Solid:
    mass = MassProperties(volume, np.zeros(3), np.diag(moments) * volume)
    return Solid((Primitive(kind, size),), mass, np.array(extent), np.array(shadows), kind)


def _barrel(radius: float, half: float) -> Primitive:
    """What rolls over an edge for a cylinder.

    MuJoCo takes the face's normal where a cylinder lies along the edge of a box, so that a can
    that rolls off a table sinks into its edge; of capsules and ellipsoids it finds the true one.
    """
    if half > 1.05 * radius:
        return Primitive("capsule", (radius, half - radius, 0.0))
    return Primitive("ellipsoid", (radius, radius, half))


def _frustum(shape: forms.Frustum) -> Solid:
    low = -frustum_centre(shape)
    profile = np.array([[low, shape.bottom_radius], [low + shape.height, shape.top_radius]])
    return _round(profile, shape.wall)


def _open_box(shape: forms.Box) -> Solid:
    boards = open_box(shape.size, shape.wall or 0.0)
    pieces = tuple(Primitive("box", half(size), place) for place, size in boards)
    mass = together([_box_mass(size, place) for place, size in boards])
    x, y, z = shape.size
    return Solid(pieces, mass, np.array([x, y, z]), np.array([y * z, x * z, x * y]))


def half(size: Size3) -> Size3:
    """Half of each edge."""
    return size[0] / 2, size[1] / 2, size[2] / 2


def _box_mass(size: Size3, place: Size3) -> MassProperties:
    x, y, z = size
    moments = np.diag([(y * y + z * z) / 12, (x * x + z * z) / 12, (x * x + y * y) / 12])
    volume = x * y * z
    return MassProperties(volume, np.array(place), moments * volume)


def _torus(shape: forms.Torus) -> Solid:
    made = ring(shape.radius, shape.tube)
    mass = MassProperties(made.volume, np.zeros(3), np.diag(made.moments) * made.volume)
    extent, shadows = np.array(made.extent), np.array(made.shadows)
    return Solid(made.pieces, mass, extent, shadows, "torus", rims=made.rims)


def _round(outline: FloatArray, wall: float | None) -> Solid:
    """A surface of revolution, solid or hollow."""
    surface = revolve(outline)
    if wall is None:
        whole = _solid(tuple(Hull(*part) for part in solid_slices(outline)), surface)
        return replace(whole, kind="revolved")
    parts, mass = vessel(outline, wall)
    hollow = _solid(tuple(Hull(*part) for part in parts), surface)
    return replace(hollow, mass=mass, kind="revolved")


def _meshed(
    name: str,
    shape: forms.Inflated | forms.Meshed | forms.MeshedSupport,
    mesh: Mesh | None,
    decompose: Decompose,
) -> Solid:
    note = ""
    if mesh is not None:
        surface = welded((np.asarray(mesh.vertices, float), np.asarray(mesh.faces, np.int32)))
    elif isinstance(shape, forms.Inflated):
        x, y, z = shape.size
        surface = ellipsoid_surface((x / 2, y / 2, z / 2))
    else:
        surface = box_surface(shape.size)
        note = f"no mesh was given for {name}: it collides and weighs as a box of its size"
    outer = hull(surface[0], name)
    outer_mass = mass_properties(outer)
    own = mass_properties(surface) if is_closed(surface) else None
    if own is None or not 0.02 * outer_mass.volume < own.volume <= 1.001 * outer_mass.volume:
        note = note or f"the mesh of {name} is not closed: it weighs as much as its convex hull"
        return replace(_solid((Hull(*outer),), surface, note), mass=outer_mass)
    if own.volume >= CONVEX_ENOUGH * outer_mass.volume:
        return _solid((Hull(*outer),), surface, note)
    # What was inflated has no hollows that its silhouette does not show.
    parts = None if isinstance(shape, forms.Inflated) else decompose(surface)
    if parts is None:
        parts = carved(surface)
        if not isinstance(shape, forms.Inflated):
            note = (
                f"{name} is hollow or concave and collides in pieces cut along its silhouettes: "
                "install the extra 'convex' (pip install 'physagent-studio[convex]') to follow "
                "its hollows too"
            )
    return _solid(tuple(Hull(*part) for part in parts), surface, note)


FEWEST, MOST = 12, 36
"""Capsules of a ring."""
SAG = 0.15
"""How far a straight piece may lie inside the round ring, as a share of the tube's radius."""
TREAD, EDGE = 0.2, 0.1
"""Half width of the band on which a ring rolls, and half thickness of the discs at its sides, as

shares of the tube's radius. Lens-shaped discs: MuJoCo's contact of a cylinder with a plane is off
by centimetres where their tilt is a rounding error.
"""


@dataclass(frozen=True, slots=True)
class Ring:
    """pieces: capsules, their joints on the ring. rims: discs that stand for the outline on flat

    ground, where a chain of straight pieces would rattle. volume: m³. moments: m², about the body
    axes over the volume. extent: m. shadows: m², silhouettes along the body axes.
    """

    pieces: tuple[Primitive, ...]
    rims: tuple[Primitive, ...]
    volume: float
    moments: tuple[float, float, float]
    extent: tuple[float, float, float]
    shadows: tuple[float, float, float]


def ring(radius: float, tube: float) -> Ring:
    """The ring about z whose tube of radius `tube` runs at `radius` from the middle, m."""
    tube = min(tube, radius)
    across = radius**2 / 2 + 5 / 8 * tube**2
    outer = radius + tube
    broad = 4 * radius * tube + math.pi * tube**2
    return Ring(
        pieces=_chain(radius, tube),
        rims=tuple(
            Primitive("ellipsoid", (outer, outer, EDGE * tube), (0.0, 0.0, side * TREAD * tube))
            for side in (-1, 1)
        ),
        volume=2 * math.pi**2 * radius * tube**2,
        moments=(across, across, radius**2 + 3 / 4 * tube**2),
        extent=(2 * outer, 2 * outer, 2 * tube),
        shadows=(broad, broad, math.pi * (outer**2 - (radius - tube) ** 2)),
    )


def _chain(radius: float, tube: float) -> tuple[Primitive, ...]:
    # The middle of a chord of the ring lies R (1 − cos π/n) inside it.
    turn = math.acos(max(1 - SAG * tube / radius, 0.0))
    count = min(max(math.ceil(math.pi / max(turn, 1e-6)), FEWEST), MOST)
    half = radius * math.sin(math.pi / count)
    middle = radius * math.cos(math.pi / count)
    # Turns a capsule's own axis, z, to y, the direction of the ring where it crosses x.
    lie = (math.sqrt(0.5), -math.sqrt(0.5), 0.0, 0.0)
    out = []
    for number in range(count):
        angle = 2 * math.pi * number / count
        place = (middle * math.cos(angle), middle * math.sin(angle), 0.0)
        out.append(Primitive("capsule", (tube, half, 0.0), place, multiply(about_up(angle), lie)))
    return tuple(out)
