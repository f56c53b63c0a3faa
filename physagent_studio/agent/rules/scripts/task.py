"""One object to set going, with what is said of it, and where it shall get to."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from physagent_studio.agent.rules import actions as act
from physagent_studio.agent.rules.intents import Intent
from physagent_studio.agent.rules.layout import WAYS, Layout, level
from physagent_studio.agent.rules.reading import Place
from physagent_studio.agent.rules.reading.vocabulary import words_of
from physagent_studio.agent.rules.specs import place_name, ways_of
from physagent_studio.program.actions import Direction
from physagent_studio.program.program import Clip
from physagent_studio.program.scene import Ramp

UP = WAYS["up"]
FASTEST = 8.0
"""No first program sends a thing along the ground faster than this, m/s."""


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
        return act.FIRST_STEP + self.rank * 25

    def seconds(self, share: float) -> float:
        """A share of the clip, s."""
        return self.clip.seconds * share

    def way(self) -> Direction | None:
        """The named direction that is said, as the scene lies."""
        said = self.intent.way()
        frame = next((f for f in self.intent.frames if said in (f.direction, f.origin)), None)
        if said is None or frame is None:
            return None
        ways = ways_of(said, frame, self.name, self.layout)
        return ways[self.rank % len(ways)] if ways else None

    def target(self) -> Place | None:
        """Where it shall get to: what it hits, enters, crosses, reaches, stops near."""
        if self.intent.hits:
            return Place(self.intent.hits[0], "object")
        for relations in (
            ("in", "into"),
            ("object", "over", "between"),
            ("near", "at"),
            ("toward", "against"),
            ("on",),
        ):
            place = self.intent.place(*relations, senses=_ARRIVING)
            if place is not None and self._is_aim(place):
                return place
        return None

    def _is_aim(self, place: Place) -> bool:
        if place.kind == "group" or place.name == self.name:
            return False
        if place.name == self.layout.carrier(self.name) and not place.part:
            return False
        return self.layout.is_known(place_name(place))

    def passes(self) -> str | None:
        """The object that it shall go by, and not bump into."""
        for frame in self.intent.frames:
            place = frame.place("over") or (
                frame.place("object") if frame.sense in ("pass", "miss") else None
            )
            going = frame.sense not in ("jump", "fly", "throw", "fall")
            if place is not None and place.kind == "object" and not place.part and going:
                return place.name if place.name not in self.intent.hits else None
        return None

    def ramp_ahead(self) -> Ramp | None:
        """The ramp that it shall go up."""
        place = self.intent.place("up")
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
        return self.layout.rolling(self.name, carrier)


_ARRIVING = tuple(
    words_of(
        "move slide drift roll fly curve push pull kick throw hit cross pass reach enter approach "
        "stop settle land knock knock_over accelerate fall bounce jump crush strike"
    )
)
