"""Statements about one object over a rollout: their schema, each with typed parameters.

A statement names a `subject` object and is tied to the clause of the prompt that it tests.
`negated` turns it around. Thresholds are in SI units and degrees. `contract` (the room) measures
them; statements about other statements are in `contract.py` beside this file.
"""

from typing import Annotated, Literal

from pydantic import Field

from physagent_studio.program.base import Direction, Frozen, Name, Position, Step

Distance = Annotated[float, Field(ge=0, le=1e4)]
Angle = Annotated[float, Field(ge=0, le=36000)]


class Stated(Frozen):
    """`clause` ties it to the prompt; `negated` demands the opposite; the window is in steps."""

    id: Name
    clause: Name | None = None
    negated: bool = False
    from_step: Step | None = None
    to_step: Step | None = None


class Told(Stated):
    """A statement about the object `subject`."""

    subject: Name


class Moves(Told):
    """Moves at least `distance` m, along `direction` or closer to `toward` if one is given."""

    kind: Literal["moves"] = "moves"
    distance: Distance = 0.05
    direction: Direction | None = None
    toward: Name | None = None


class Falls(Told):
    """Its centre of mass comes down by at least `drop` m from its highest point so far."""

    kind: Literal["falls"] = "falls"
    drop: Distance = 0.02


class Contacts(Told):
    """Touches `other` (object or support) at least once."""

    kind: Literal["contacts"] = "contacts"
    other: Name


class Topples(Told):
    """Its up axis tilts by at least `tilt` degrees and is so at the end; by no more than `most`
    there, and with the side down that faced `onto` at first, where these are given."""

    kind: Literal["topples"] = "topples"
    tilt: Angle = 45.0
    most: Angle | None = None
    onto: Direction | None = None


class Stays(Told):
    """Never moves further than `distance` m nor tilts more than `tilt` degrees."""

    kind: Literal["stays"] = "stays"
    distance: Distance = 0.03
    tilt: Angle = 15.0


class RestsOn(Told):
    """At the end it is at rest and carried by `other`."""

    kind: Literal["rests_on"] = "rests_on"
    other: Name
    speed: Distance = 0.05


class ReachesOn(Told):
    """Touches `other` from above for good: carried by it at the end, moving or not."""

    kind: Literal["reaches"] = "reaches"
    other: Name


class Leaves(Told):
    """Loses contact with `other` for good."""

    kind: Literal["leaves"] = "leaves"
    other: Name


class LandsIn(Told):
    """Ends inside the area or behind the opening `landmark`."""

    kind: Literal["lands_in"] = "lands_in"
    landmark: Name


class PassesOver(Told):
    """Its centre crosses the line, area edge or opening `landmark`, or goes by it.

    `by`: it only has to get farther along than the place, beside it or over it.
    """

    kind: Literal["passes_over"] = "passes_over"
    landmark: Name
    by: bool = False


class Stops(Told):
    """Has moved and is slower than `speed` at the end, within `distance` m of `near` if given."""

    kind: Literal["stops"] = "stops"
    speed: Distance = 0.05
    near: Name | None = None
    distance: Distance = 0.3


class StopsBefore(Told):
    """Has moved, is at rest at the end and has not reached `before` (body or landmark)."""

    kind: Literal["stops_before"] = "stops_before"
    before: Name
    speed: Distance = 0.05


class Airborne(Told):
    """Is without any contact for at least `seconds` in one stretch, and not held by an action."""

    kind: Literal["airborne"] = "airborne"
    seconds: Distance = 0.08


class Rotates(Told):
    """Turns by at least `angle` degrees in total; net about `axis`, either way, if given."""

    kind: Literal["rotates"] = "rotates"
    angle: Angle = 45.0
    axis: Position | None = None


class Flips(Told):
    """Turns over: its up axis sweeps at least `angle` degrees about a horizontal axis."""

    kind: Literal["flips"] = "flips"
    angle: Angle = 80.0
    direction: Direction | None = None


class Upright(Told):
    """At the end tilted by at most `tilt` degrees from its first pose."""

    kind: Literal["upright"] = "upright"
    tilt: Angle = 20.0


class SpeedBetween(Told):
    """Its greatest speed lies between `low` and `high` m/s; `level`: the level part of it."""

    kind: Literal["speed_between"] = "speed_between"
    low: Distance = 0.0
    high: Distance = 1e4
    level: bool = False


class PathBends(Told):
    """Its horizontal path turns by at least `angle` degrees in all, to the given side."""

    kind: Literal["path_bends"] = "path_bends"
    side: Literal["left", "right", "either"] = "either"
    angle: Angle = 15.0


class Reverses(Told):
    """Its horizontal direction of motion turns by more than `angle` degrees, `times` times."""

    kind: Literal["reverses"] = "reverses"
    angle: Angle = 90.0
    times: Annotated[int, Field(ge=1, le=50)] = 1


class DescendsSlowly(Told):
    """Comes down by at least `drop` m and never faster than `speed` m/s."""

    kind: Literal["descends_slowly"] = "descends_slowly"
    drop: Distance = 0.02
    speed: Distance = 0.5


class Deforms(Told):
    """Its shape changes by at least `strain` of its size; is still changed at the end with
    `at_end`."""

    kind: Literal["deforms"] = "deforms"
    strain: Distance = 0.05
    at_end: bool = False


class Spreads(Told):
    """Its footprint grows by at least the factor `factor`."""

    kind: Literal["spreads"] = "spreads"
    factor: Distance = 1.3


class Breaks(Told):
    """At least one of its joints releases."""

    kind: Literal["breaks"] = "breaks"


class Sways(Told):
    """Moves to and fro at least `cycles` times with at least `amplitude` degrees."""

    kind: Literal["sways"] = "sways"
    amplitude: Angle = 3.0
    cycles: Distance = 1.0


class Bounces(Told):
    """Touches `other` and is thrown back at least `times` times, each time by `height` m."""

    kind: Literal["bounces"] = "bounces"
    other: Name
    times: Annotated[int, Field(ge=1, le=50)] = 1
    height: Distance = 0.01


class Covers(Told):
    """At its farthest it has covered a share between `low` and `high` of the way to `other`."""

    kind: Literal["covers"] = "covers"
    other: Name
    low: Annotated[float, Field(ge=0, le=10)] = 0.35
    high: Annotated[float, Field(ge=0, le=10)] = 0.65


Side = Literal["behind", "in_front", "left", "right", "above", "under", "beside"]


class SideOf(Told):
    """Gets to that side of `other`, as the camera sees it; is there at the end with `at_end`."""

    kind: Literal["side_of"] = "side_of"
    other: Name
    side: Side
    at_end: bool = False


Leaf = Annotated[
    Moves | Falls | Contacts | Topples | Stays | RestsOn | ReachesOn | Leaves | LandsIn
    | PassesOver | Stops | StopsBefore | Airborne | Rotates | Flips | Upright | SpeedBetween
    | PathBends | Reverses | DescendsSlowly | Deforms | Spreads | Breaks | Sways | Bounces
    | Covers | SideOf,
    Field(discriminator="kind"),
]  # fmt: skip
"""A statement about one object; composites refer to others instead."""
