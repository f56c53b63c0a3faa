"""One object to set going, with what is said of it, and where it shall get to."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from physagent_studio.agent.rules.contract.intents import Intent
from physagent_studio.agent.rules.contract.specs import (
    over_way,
    spot_name,
    ways_of,
)
from physagent_studio.agent.rules.scene.framing import free_way, way_hidden
from physagent_studio.agent.rules.scene.measures import (
    WAYS,
    FloatArray,
    Layout,
    level,
    named_way,
    place_name,
    unit,
)
from physagent_studio.agent.rules.scene.steps import way_down
from physagent_studio.agent.rules.schedule import actions as act
from physagent_studio.language import Place
from physagent_studio.language.tokens.vocabulary import words_of
from physagent_studio.program.actions import Directed, Direction
from physagent_studio.program.program import Clip
from physagent_studio.program.scene.state import Landmark, Ramp, Wheels


@dataclass(frozen=True, slots=True)
class TaskSettings:
    """How far and how fast a first program sends things."""

    max_speed_mps: float = 8.0  # 3..20: along the ground
    # cosine, 0.5..0.95: what lies so far beside the way that is said is not met on it
    min_onto_cosine: float = math.cos(math.radians(45.0))
    short_share: float = 0.75  # 0.4..0.95: of the way, gone by what stops before a thing


TASK = TaskSettings()


@dataclass(frozen=True)
class Task:
    """One object to set going. rank: its place in a row of objects that do the same."""

    intent: Intent
    layout: Layout
    clip: Clip
    rank: int = 0
    of: int = 1

    @property
    def name(self) -> str:
        """The object."""
        return self.intent.name

    @property
    def delay(self) -> int:
        """Steps by which it starts later than the first of its row."""
        # What one wind does to several it does to all at once, and what goes along goes then.
        told = self.intent.frames
        together = any(f.timing == "together" or f.cause == "wind" for f in told)
        together |= self.intent.manner("along")
        return act.STEPS.first_step + (0 if together else self.rank * 25)

    @property
    def wheels(self) -> Wheels | None:
        """What it rolls on, None for what has no wheels or leaves their axis."""
        item = self.layout.state.object(self.name)
        return None if item is None else item.wheels

    @property
    def backwards(self) -> bool:
        """Whether the prompt has it go with its back first, from the beginning: what bounces back
        from a thing went there front first."""
        said = [f for f in self.intent.frames if not f.agent and f.sense != "bounce"]
        return any(f.direction == "backward" or "backwards" in f.manner for f in said)

    @property
    def goes_its_own_way(self) -> bool:
        """Whether the prompt has it go forward or backward, whichever way that is."""
        ways = [f.direction for f in self.intent.frames if not f.agent and f.direction]
        return bool(ways) and set(ways) <= {"forward", "backward"}

    def axis_way(self) -> FloatArray | None:
        """Level unit direction (3,) in which it can be set going on its wheels; None without."""
        if self.wheels is None:
            return None
        angle = math.radians(self.wheels.heading + (180.0 if self.backwards else 0.0))
        return np.array([math.cos(angle), math.sin(angle), 0.0])

    def seconds(self, share: float) -> float:
        """A share of the clip, s."""
        return self.clip.seconds * share

    def way(self) -> Direction | None:
        """The named direction that is said, as the scene lies."""
        over: Direction | None = next(
            (w for f in self.intent.frames if (w := over_way(f, self.name, self.layout))), None
        )
        if over is not None:
            return over
        said = self.intent.way()
        if said is None and self._comes_straight_down() and self.intent.has("kick", "throw"):
            return "up"
        frame = next((f for f in self.intent.frames if said in (f.direction, f.origin)), None)
        if said is None or frame is None:
            return self._side()
        ways = ways_of(said, frame, self.name, self.layout)
        if len(ways) > 1 and self.of == 1:
            # "Sideways" is where there is most room.
            return max(ways, key=lambda way: free_way(self.layout, self.name, WAYS[way]))
        return ways[self.rank % len(ways)] if ways else None

    def _comes_straight_down(self) -> bool:
        """ "Is kicked into the air and lands where it was"."""
        down = (f for f in self.intent.frames if f.sense in ("land", "fall"))
        return any("straight" in f.manner for f in down)

    def onto(self) -> str | None:
        """The first thing that it shall meet, where that lies the way that is said, if one is."""
        hits, way = self.intent.hits, self.way()
        if not hits or not self.layout.has(hits[0]):
            return None
        if way is None or float(self.way_onto(hits[0]) @ WAYS[way]) > TASK.min_onto_cosine:
            return hits[0]
        return None

    def clear_along(self, way: FloatArray) -> float:
        """How far along a level way (3,) it is clear of where it stood, m; 0 where it is not
        pulled out."""
        own = self.layout.extent(self.name, way) + self.layout.extent(self.name, -way)
        return own if self.intent.manner("out") else 0.0

    def way_out(self, way: FloatArray) -> float:
        """How far it goes on along a level way (3,) from where it is last seen whole, to be out of
        the picture, or the part of its length that is told, m."""
        said = (f.share for f in self.intent.frames if "offscreen" in f.manner and f.share)
        if (share := next(said, None)) is None or share[1] >= 1:
            return way_hidden(self.layout, self.name, way)
        long = self.layout.extent(self.name, way) + self.layout.extent(self.name, -way)
        return sum(share) / 2 * long

    def way_onto(self, name: str) -> FloatArray:
        """Level unit direction (3,) from its centre to another thing's."""
        return unit(level(self.layout.position(name) - self.layout.position(self.name)))

    def away_from(self, name: str, speed: float) -> Directed:
        """A push away from a thing, or square away from a line, to the side on which what it
        stands on lies where the line is an edge of that."""
        mark, base = self.layout.state.landmark(name), self.layout.base(self.name)
        if mark is not None and mark.kind == "line":
            own = mark.on if mark.on is not None and mark.on == base else self.name
            square = square_to(mark, self.layout.position(own))
            if square is not None:
                return act.toward_or_along(speed, vector=square)
        return act.toward_or_along(speed, toward=name, azimuth=180.0)

    def down_the_steps(self) -> FloatArray | None:
        """The level way (3,) to the middle of the next lower step, or of one so many steps on as
        is told, where it shall go down them."""
        told = any(f.direction == "down" or f.place("down") for f in self.intent.frames)
        return way_down(self.layout, self.name, self.steps) if told else None

    @property
    def steps(self) -> int:
        """How many steps it shall go down at once."""
        return next((f.steps for f in self.intent.frames if f.steps), 1)

    def _side(self) -> Direction | None:
        """The way to the side of a thing on which it shall end, or to what it shall fall
        towards, where no way is named."""
        for frame in self.intent.frames:
            toward = frame.place("toward", "against")
            falls = frame.sense in ("topple", "lean", "fall")
            if falls and toward and self.layout.has(toward.name):
                away = self.layout.position(toward.name) - self.layout.position(self.name)
                return named_way(level(away))
            for relation, place in frame.places:
                if relation in SIDE_WAYS and self.layout.is_known(place.name):
                    return SIDE_WAYS[relation]
        return None

    @property
    def share(self) -> float | None:
        """The part of a way that it shall cover, its middle; more than 1 for all of it."""
        said = next((f.share for f in self.intent.frames if f.share is not None), None)
        if said is None:
            return TASK.short_share if self._stops_short() else None
        return sum(said) / 2 if said[1] <= 1 else 1.05

    def _stops_short(self) -> bool:
        """Whether it shall stop before a thing."""
        frames = (f for f in self.intent.frames if f.sense in ("stop", "settle"))
        return any(f.place("before", "in_front") is not None for f in frames)

    @property
    def ends_short(self) -> bool:
        """Whether it shall come to rest before the end of a way, or after a way of its own."""
        return (self.share is not None and self.share < 1) or self.far is not None

    @property
    def far(self) -> float | None:
        """How far it shall go, where the prompt says it in numbers or with "a little", m."""
        for frame in self.intent.frames:
            if frame.place("off", "from") is not None or frame.sense in ("stop", "settle"):
                continue
            if frame.distance is not None:
                return frame.distance
            if "slight" in frame.manner:
                return min(max(0.6 * self.layout.size(self.name), 0.03), 0.3)
        return None

    @property
    def speed(self) -> float | None:
        """How fast it shall go, where the prompt says it in numbers, m/s."""
        return next((f.speed for f in self.intent.frames if f.speed is not None), None)

    def way_to(self, place: Place) -> float:
        """Horizontal way to a place, or the part of it that it shall cover, m."""
        way, name = self.distance_to(place), place.name
        if place.kind == "object" and any(f.share is not None for f in self.intent.frames):
            # Halfway to a thing is half of what lies between them.
            ahead = self.way_onto(name)
            way -= self.layout.extent(self.name, ahead) + self.layout.extent(name, -ahead)
        return max(way, 0.0) * (self.share if self.share is not None else 1.0)

    def target(self) -> Place | None:
        """Where it shall get to: what it hits, enters, crosses, reaches, stops near."""
        for frame in self.intent.frames:
            if frame.extent is not None and self.layout.is_known(place_name(frame.extent)):
                return frame.extent
        if self.intent.hits:
            return Place(self.intent.hits[0], "object")
        if (spot := self._beside_a_thing(ENDING)) is not None:
            return spot
        for relations in (
            ("in", "into"),
            ("object", "over", "past", "between", "through"),
            ("near", "at"),
            ("toward", "against"),
            ("on", "atop"),
            ("before",) if not self._stops_short() else ("before", "in_front"),
        ):
            place = self.intent.place(*relations, senses=_ARRIVING)
            if place is not None and self._is_aim(place):
                return place
        return self._beside_a_thing()

    def _beside_a_thing(self, senses: tuple[str, ...] = ()) -> Place | None:
        """The spot behind, in front of or beside a thing, where it shall get there."""
        for frame in self.intent.frames:
            if senses and frame.sense not in senses:
                continue
            for relation, place in frame.places:
                spot = Place(spot_name(relation, place), "landmark")
                if relation in SIDE_WAYS and self.layout.is_known(spot.name):
                    return spot
        return None

    def _is_aim(self, place: Place) -> bool:
        if place.kind == "group" or place.name == self.name:
            return False
        if place.name == self.layout.carrier(self.name) and not place.part:
            return False
        return self.layout.is_known(place_name(place))

    def passes(self) -> str | None:
        """The object that it shall go by, and not bump into; the first of several.

        None where it ends beside a thing: an arc leads there.
        """
        if self._beside_a_thing(ENDING) is not None:
            return None
        return next(iter(self.passed()), None)

    def passed(self) -> tuple[str, ...]:
        """All objects that it shall go by."""
        for frame in self.intent.frames:
            asked = ("over", "past", *(("object",) if frame.sense in ("pass", "miss") else ()))
            rows = [p for r, p in frame.places if r in asked and p.kind == "object" and not p.part]
            going = frame.sense not in ("jump", "fly", "throw", "fall")
            if rows and going:
                return tuple(p.name for p in rows if p.name not in self.intent.hits)
        return ()

    def off_the_top(self) -> Place | None:
        """The upper end of the ramp that carries it, where it shall come off that."""
        place, ramp = self.intent.place("off", "from"), self.layout.ramp_below(self.name)
        if place is None or ramp is None or place.part != "upper_end":
            return None
        return place if ramp.name == place.name else None

    def _to_the_top(self) -> Place | None:
        """The upper end of a ramp, where it is told to get there."""
        place = self.intent.place("toward", "at", senses=("move", "roll", "slide", "reach"))
        return place if place is not None and place.part == "upper_end" else None

    def ramp_ahead(self) -> Ramp | None:
        """The ramp that it shall go up."""
        place = self.intent.place("up") or self.off_the_top() or self._to_the_top()
        support = self.layout.state.support(place.name) if place is not None else None
        shape = support.shape if support is not None else None
        return shape if isinstance(shape, Ramp) else None

    def distance_to(self, place: Place) -> float:
        """Horizontal way from its centre to the middle of a place."""
        way = self.layout.position(place_name(place)) - self.layout.position(self.name)
        return float(np.linalg.norm(level(way)))

    def ground_friction(self) -> float:
        """Friction with what carries it."""
        carrier = self.layout.carrier(self.name) or self.layout.ground()
        return self.layout.friction(self.name, carrier)

    def ground_rolling(self) -> float:
        """Coefficient of rolling resistance on what carries it."""
        carrier = self.layout.carrier(self.name) or self.layout.ground()
        return self.layout.touch(self.name, carrier).rolling


def square_to(line: Landmark, place: FloatArray) -> FloatArray | None:
    """Level unit vector (3,) square to a line, to the side on which a place (3,) lies; None where
    it has no two points or the place lies on it."""
    if line.points is None or len(line.points) < 2:
        return None
    start, end = (np.array(point, float) for point in (line.points[0], line.points[-1]))
    along = unit(level(end - start))
    square = np.array([-along[1], along[0], 0.0])
    off = float(square @ (place - start))
    return None if off == 0 else square if off > 0 else -square


ENDING = ("stop", "settle", "end", "rest")
SIDE_WAYS: dict[str, Direction] = {
    "behind": "away", "in_front": "toward_camera", "left_of": "left", "right_of": "right",
}  # fmt: skip
"""Where a side of a thing lies, seen from it."""
_ARRIVING = tuple(
    words_of(
        "move slide drift roll fly curve push pull kick throw hit cross pass reach enter approach "
        "stop settle land end knock knock_over accelerate fall bounce jump crush strike"
    )
)
