"""Distances, sizes and masses of a scene, as mechanics and thresholds need them."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from physagent_studio.agent.rules.scene.apart import Body, gap, is_on, size_of
from physagent_studio.arrays import FloatArray
from physagent_studio.language import Place
from physagent_studio.program.base import DIRECTIONS, Direction
from physagent_studio.program.preflight.mechanics import mass_of
from physagent_studio.program.rotations import matrix_of
from physagent_studio.program.scene.aloft import AIR, in_air
from physagent_studio.program.scene.materials import Touch, combine, touch_of
from physagent_studio.program.scene.shapes import Placed, lowest, outline_of, reach
from physagent_studio.program.scene.state import (
    Floor,
    Ramp,
    SceneObject,
    SceneState,
    Slab,
    Support,
    Vessel,
    Wall,
)

WAYS: dict[Direction, FloatArray] = {way: np.array(v) for way, v in DIRECTIONS.items()}
UP = WAYS["up"]
OPPOSITE: dict[Direction, Direction] = {
    "left": "right", "right": "left", "up": "down", "down": "up", "away": "toward_camera",
    "toward_camera": "away",
}  # fmt: skip


def are_opposite(way: str | None, other: str | None) -> bool:
    """Whether these are two named directions, and one the reverse of the other."""
    return (way, other) in OPPOSITE.items()


def named_way(vector: FloatArray) -> Direction:
    """The named horizontal direction nearest to a vector."""
    if abs(vector[0]) >= abs(vector[1]):
        return "right" if vector[0] >= 0 else "left"
    return "away" if vector[1] >= 0 else "toward_camera"


def unit(vector: FloatArray) -> FloatArray:
    """The vector (3,) at length 1, or +x where it has none."""
    length = float(np.linalg.norm(vector))
    return vector / length if length > 1e-9 else np.array([1.0, 0.0, 0.0])


def level(vector: FloatArray) -> FloatArray:
    """The vector without its vertical part."""
    return vector * np.array([1.0, 1.0, 0.0])


@dataclass(frozen=True)
class Layout:
    """Asks a completed scene state; lengths in m, world frame."""

    state: SceneState

    def with_places(self, places: dict[str, FloatArray]) -> Layout:
        """The layout with some objects put elsewhere, in the air."""
        if not places:
            return self
        objects = tuple(
            item.model_copy(
                update={"position": tuple(float(p) for p in places[item.name]), "support": AIR}
            )
            if item.name in places
            else item
            for item in self.state.objects
        )
        return Layout(self.state.model_copy(update={"objects": objects}))

    def has(self, name: str) -> bool:
        """Whether an object of that name has its shape and place."""
        item = self.state.object(name)
        return item is not None and item.shape is not None and item.position is not None

    def placed(self, name: str) -> Placed | None:
        """An object in its first pose, or a support."""
        body = self._body(name)
        return None if body is None else body.placed()

    def _body(self, name: str) -> Body | None:
        item = self.state.object(name)
        if item is not None and item.shape is not None and item.position is not None:
            return Body((item.shape, item.position, item.rotation))
        support = self.state.support(name)
        return Body(support.shape) if support is not None and support.shape else None

    def position(self, name: str) -> FloatArray:
        """Centre of mass of an object; the middle of a support or a landmark."""
        item = self.state.object(name)
        if item is not None and item.position is not None:
            return np.array(item.position, float)
        landmark = self.state.landmark(name)
        if landmark is not None and landmark.points:
            return np.array(landmark.points, float).mean(axis=0)
        support = self.state.support(name)
        if support is not None and isinstance(support.shape, Slab | Vessel):
            return np.array(support.shape.position, float)
        if support is not None and isinstance(support.shape, Ramp):
            return _ramp_middle(support.shape)
        if support is not None and isinstance(support.shape, Wall):
            return np.array(support.shape.point, float)
        return np.zeros(3)

    def is_known(self, name: str) -> bool:
        """Whether `position` of that name means something."""
        landmark = self.state.landmark(name)
        if landmark is not None:
            return bool(landmark.points)
        support = self.state.support(name)
        if support is not None:
            return support.shape is not None and not isinstance(support.shape, Floor)
        return self.has(name)

    def extent(self, name: str, way: FloatArray) -> float:
        """How far an object reaches from its centre along a unit direction (3,)."""
        body = self.placed(name)
        if body is None or body.outline is None:
            return 0.05
        return float(reach(body, way)[0] - self.position(name) @ way)

    def size(self, name: str) -> float:
        """Mean edge of the bounding box."""
        item = self.state.object(name)
        return size_of(item.shape) if item and item.shape else 0.1

    def height(self, name: str) -> float:
        """Vertical extent of an object in its first pose."""
        return self.extent(name, UP) + self.extent(name, -UP)

    def rolls(self, name: str) -> bool:
        """Whether it rolls and has no up side: a ball, or what is long and round and lies."""
        item = self.state.object(name)
        if item is None or item.shape is None:
            return False
        # sine, 0.02..0.2: of an axis that counts as level
        max_level_sine = math.sin(math.radians(5))
        upright = self._roller(item)
        if upright is None:
            return outline_of(item.shape).is_ball
        return upright < max_level_sine

    def rolls_on_its_side(self, name: str) -> bool:
        """Whether it stands, and would roll if it lay: a tin, a bottle, a pin."""
        item = self.state.object(name)
        if item is None or item.shape is None:
            return False
        # cosine, 0.9..1: of an axis that counts as upright
        min_upright_cosine = math.cos(math.radians(10))
        return (self._roller(item) or 0.0) > min_upright_cosine

    def _roller(self, item: SceneObject) -> float | None:
        """The share of its axis that points up or down; None for what has no axis to roll about."""
        assert item.shape is not None
        outline = outline_of(item.shape)
        if outline.is_ball or outline.axis is None or outline.rings is None:
            return None
        axis = np.array(outline.axis)
        along = float(outline.support([axis])[0] @ axis)
        across = np.roll(axis, 1)
        wide = float(outline.support([across])[0] @ across)
        # 0.3..2: length over width of what cannot stand on its edge as a disc does
        min_roller_ratio = 0.7
        if along <= min_roller_ratio * wide:
            return None
        return abs(float(matrix_of(item.rotation)[2] @ axis))

    def lies_flat(self, name: str) -> bool:
        """Whether the way in which it is thinnest is about upright, or it is as thick any way."""
        item = self.state.object(name)
        if item is None or item.shape is None:
            return True
        axes = matrix_of(item.rotation).T
        reach = np.array([self.extent(name, axis) + self.extent(name, -axis) for axis in axes])
        thinnest = axes[reach < 1.15 * reach.min()]
        return bool((np.abs(thinnest[:, 2]) > math.cos(math.radians(25))).any())

    def mass(self, name: str) -> float:
        """Mass estimate, kg."""
        item = self.state.object(name)
        return (mass_of(item) if item is not None else None) or 1.0

    def friction(self, name: str, other: str) -> float:
        """Coulomb coefficient between two bodies: the mean that the simulation uses.

        Of what stands on wheels it is the resistance with which it rolls on along them.
        """
        item = self.state.object(name)
        if item is not None and item.wheels is not None:
            return item.wheels.rolling
        return self.touch(name, other).friction

    def touch(self, name: str, other: str) -> Touch:
        """How two bodies meet; what the scene does not have is of wood."""
        things = [self.state.object(one) or self.state.support(one) for one in (name, other)]
        first, second = (touch_of(thing or Support(name="none")) for thing in things)
        return combine(first, second)

    # --- what stands on what -----------------------------------------------------------------

    def gap(self, name: str, other: str) -> float:
        """Distance of two bodies' surfaces; 0 where they touch."""
        first, second = self._body(name), self._body(other)
        if first is None or second is None:
            return math.inf
        return gap(first, second)

    def nearer(self, name: str, other: str, way: float) -> float:
        """How much nearer its centre is to that of another thing, m, once it has gone towards it
        so far along the ground, m: less, where it is the higher one."""
        x, y, z = self.position(other) - self.position(name)
        left = max(math.hypot(x, y) - way, 0.0)
        return math.hypot(x, y, z) - math.hypot(left, z)

    def carrier(self, name: str) -> str | None:
        """What the object stands on at first: a support or an object; None in the air."""
        item = self.state.object(name)
        if item is None or in_air(item):
            return None
        if item.support is not None and not self._is_over(name, item.support):
            return None
        return item.support if item.support is not None else self._nearest_below(name)

    def _is_over(self, name: str, other: str) -> bool:
        body, below = self._body(name), self._body(other)
        return body is not None and below is not None and is_on(body, below)

    def _nearest_below(self, name: str) -> str | None:
        others = [o.name for o in self.state.objects if o.name != name and self.has(o.name)]
        below = [o for o in others if self.position(o)[2] < self.position(name)[2]]
        found = [s.name for s in self.state.supports if s.shape is not None] + below
        near = [(self.gap(name, o), o) for o in found if self._is_over(name, o)]
        return min(near)[1] if near else None

    def base(self, name: str) -> str | None:
        """The support that in the end carries the object, through others it stands on."""
        seen: set[str] = set()
        below = self.carrier(name)
        while below is not None and self.state.support(below) is None and below not in seen:
            seen.add(below)
            below = self.carrier(below)
        return below if below is not None and self.state.support(below) is not None else None

    def above(self, name: str) -> tuple[str, ...]:
        """Objects that stand on this one, directly or through others, from low to high."""
        found: list[str] = []
        for item in self.state.objects:
            below, steps = self.carrier(item.name), 0
            while below is not None and steps < 50:
                if below == name:
                    found.append(item.name)
                    break
                below, steps = self.carrier(below), steps + 1
        return tuple(sorted(found, key=lambda n: self.position(n)[2]))

    def ground(self) -> str:
        """The name of the lowest flat support."""
        floors = [s for s in self.state.supports if isinstance(s.shape, Floor)]
        if floors:
            return min(floors, key=lambda s: s.shape.height).name  # type: ignore[union-attr]
        return self.state.supports[-1].name if self.state.supports else "floor"

    def ground_height(self) -> float:
        """Height of the ground."""
        support = self.state.support(self.ground())
        return support.shape.height if support and isinstance(support.shape, Floor) else 0.0

    def is_raised(self, name: str) -> bool:
        """Whether the object is in the air or stands on something above the ground."""
        body = self.placed(name)
        if body is None:
            return False
        clearance = float(lowest(body)[0]) - self.ground_height()
        return clearance > max(0.03, 0.3 * self.height(name))

    # --- ways off a support --------------------------------------------------------------------

    def way_to_edge(self, name: str, way: FloatArray) -> float:
        """Way along a horizontal unit direction until the centre is over the edge of its base."""
        support = self.state.support(self.base(name) or "")
        if support is None or not isinstance(support.shape, Slab):
            return math.inf
        return _exit(support.shape, self.position(name), way)

    def nearest_edge(self, name: str) -> tuple[FloatArray, float] | None:
        """Unit direction (3,) to the nearest edge of its base, and the way there.

        Not over the far edge, where the fall is hidden and a wall may be, nor where the picture
        cuts the base off and no edge is seen, as long as another is left.
        """
        support = self.state.support(self.base(name) or "")
        if support is None or not isinstance(support.shape, Slab):
            return None
        cos, sin = math.cos(support.shape.yaw), math.sin(support.shape.yaw)
        sides = [np.array(s) for s in ((cos, sin, 0.0), (-sin, cos, 0.0))]
        ways = [way * sign for way in sides for sign in (1.0, -1.0)]
        free = [w for w in ways if self._is_open_edge(support.shape, w)]
        best = min(free or ways, key=lambda way: self.way_to_edge(name, way))
        return best, self.way_to_edge(name, best)

    def _is_open_edge(self, slab: Slab, way: FloatArray) -> bool:
        """Whether the edge at that side is the front one, or one to a side that ends within the
        picture."""
        camera, named = self.state.camera, named_way(way)
        if camera is None or named == "toward_camera":
            return True
        half_x, half_y, _ = (side / 2 for side in slab.size)
        cos, sin = math.cos(slab.yaw), math.sin(slab.yaw)
        corners = np.array([
            (slab.position[0] + cos * x - sin * y, slab.position[1] + sin * x + cos * y,
             slab.position[2] + slab.size[2] / 2)
            for x in (-half_x, half_x) for y in (-half_y, half_y)
        ])  # fmt: skip
        ends = corners[np.argsort(corners @ way)[2:]]
        columns, depths = camera.project(ends)
        inside = (columns[:, 0] > 0) & (columns[:, 0] < camera.size[0]) & (depths > 0)
        return named != "away" and bool(inside.all())

    def downhill(self, name: str) -> FloatArray | None:
        """Unit direction (3,) down the ramp that carries the object; None where there is none."""
        ramp = self.ramp_below(name)
        if ramp is None:
            return None
        assert isinstance(ramp.shape, Ramp)
        shape = ramp.shape
        angle = math.atan2(shape.rise, shape.run)
        flat = math.cos(angle)
        return np.array(
            [-math.cos(shape.yaw) * flat, -math.sin(shape.yaw) * flat, -math.sin(angle)]
        )

    def ramp_below(self, name: str) -> Support | None:
        """The ramp that carries the object, or over which it hangs."""
        support = self.state.support(self.base(name) or "")
        if support is not None and isinstance(support.shape, Ramp):
            return support
        ramps = [s for s in self.state.supports if isinstance(s.shape, Ramp)]
        return next((r for r in ramps if self.gap(name, r.name) < self.size(name)), None)


def _ramp_middle(shape: Ramp) -> FloatArray:
    ahead = np.array([math.cos(shape.yaw), math.sin(shape.yaw), 0.0]) * shape.run / 2
    return np.array(shape.toe, float) + ahead + np.array([0, 0, shape.rise / 2])


def _exit(slab: Slab, position: FloatArray, way: FloatArray) -> float:
    """Way along a horizontal direction from a point to the outline of a slab, m."""
    cos, sin = math.cos(slab.yaw), math.sin(slab.yaw)
    offset = position - np.array(slab.position)
    own = np.array([cos * offset[0] + sin * offset[1], -sin * offset[0] + cos * offset[1]])
    along = np.array([cos * way[0] + sin * way[1], -sin * way[0] + cos * way[1]])
    half = np.array(slab.size[:2]) / 2
    ways = [
        (half[i] * np.sign(along[i]) - own[i]) / along[i] for i in (0, 1) if abs(along[i]) > 1e-9
    ]
    return max(float(min(ways)), 0.0) if ways else math.inf


def place_name(place: Place) -> str:
    """The name by which statements refer to a place: a part of a support is a landmark."""
    if place.kind == "support" and place.part:
        return f"{place.name}_{place.part}"
    return place.name
