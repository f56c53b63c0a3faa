"""The event contract: machine-checkable statements over a rollout.

A statement names a `subject` object and is tied to the clause of the prompt that it tests.
`negated` turns it around. Composite statements refer to others by id. Thresholds are in SI
units and degrees. `contract` (the room) measures them; this file is only their schema.
"""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import Field

from physagent_studio.program.base import Direction, Frozen, Name, Position, Step, Text

Distance = Annotated[float, Field(ge=0, le=1e4)]
Angle = Annotated[float, Field(ge=0, le=36000)]


class Clause(Frozen):
    """A part of the prompt that says something testable; `text` is its wording."""

    id: Name
    text: Text


class _Statement(Frozen):
    """`clause` ties it to the prompt; `negated` demands the opposite; the window is in steps."""

    id: Name
    clause: Name | None = None
    negated: bool = False
    from_step: Step | None = None
    to_step: Step | None = None


class Moves(_Statement):
    """Moves at least `distance` m, along `direction` or closer to `toward` if one is given."""

    kind: Literal["moves"] = "moves"
    subject: Name
    distance: Distance = 0.05
    direction: Direction | None = None
    toward: Name | None = None


class Falls(_Statement):
    """Its centre of mass comes down by at least `drop` m from its highest point so far."""

    kind: Literal["falls"] = "falls"
    subject: Name
    drop: Distance = 0.02


class Contacts(_Statement):
    """Touches `other` (object or support) at least once."""

    kind: Literal["contacts"] = "contacts"
    subject: Name
    other: Name


class Topples(_Statement):
    """Its up axis tilts by at least `tilt` degrees and is so at the end."""

    kind: Literal["topples"] = "topples"
    subject: Name
    tilt: Angle = 45.0


class Stays(_Statement):
    """Never moves further than `distance` m nor tilts more than `tilt` degrees."""

    kind: Literal["stays"] = "stays"
    subject: Name
    distance: Distance = 0.03
    tilt: Angle = 15.0


class RestsOn(_Statement):
    """At the end it is at rest and carried by `other`."""

    kind: Literal["rests_on"] = "rests_on"
    subject: Name
    other: Name
    speed: Distance = 0.05


class ReachesOn(_Statement):
    """Touches `other` from above for good: carried by it at the end, moving or not."""

    kind: Literal["reaches"] = "reaches"
    subject: Name
    other: Name


class Leaves(_Statement):
    """Loses contact with `other` for good."""

    kind: Literal["leaves"] = "leaves"
    subject: Name
    other: Name


class LandsIn(_Statement):
    """Ends inside the area or behind the opening `landmark`."""

    kind: Literal["lands_in"] = "lands_in"
    subject: Name
    landmark: Name


class PassesOver(_Statement):
    """Its centre crosses the line, area edge or opening `landmark`, or goes by it.

    `by`: it only has to get farther along than the place, beside it or over it.
    """

    kind: Literal["passes_over"] = "passes_over"
    subject: Name
    landmark: Name
    by: bool = False


class Stops(_Statement):
    """Has moved and is slower than `speed` at the end, within `distance` m of `near` if given."""

    kind: Literal["stops"] = "stops"
    subject: Name
    speed: Distance = 0.05
    near: Name | None = None
    distance: Distance = 0.3


class StopsBefore(_Statement):
    """Has moved, is at rest at the end and has not reached `before` (body or landmark)."""

    kind: Literal["stops_before"] = "stops_before"
    subject: Name
    before: Name
    speed: Distance = 0.05


class Airborne(_Statement):
    """Is without any contact for at least `seconds` in one stretch, and not held by an action."""

    kind: Literal["airborne"] = "airborne"
    subject: Name
    seconds: Distance = 0.08


class Rotates(_Statement):
    """Turns by at least `angle` degrees in total; net about `axis`, either way, if given."""

    kind: Literal["rotates"] = "rotates"
    subject: Name
    angle: Angle = 45.0
    axis: Position | None = None


class Flips(_Statement):
    """Turns over: its up axis sweeps at least `angle` degrees about a horizontal axis."""

    kind: Literal["flips"] = "flips"
    subject: Name
    angle: Angle = 80.0
    direction: Direction | None = None


class Upright(_Statement):
    """At the end tilted by at most `tilt` degrees from its first pose."""

    kind: Literal["upright"] = "upright"
    subject: Name
    tilt: Angle = 20.0


class SpeedBetween(_Statement):
    """Its greatest speed lies between `low` and `high` m/s."""

    kind: Literal["speed_between"] = "speed_between"
    subject: Name
    low: Distance = 0.0
    high: Distance = 1e4


class PathBends(_Statement):
    """Its horizontal path turns by at least `angle` degrees in all, to the given side."""

    kind: Literal["path_bends"] = "path_bends"
    subject: Name
    side: Literal["left", "right", "either"] = "either"
    angle: Angle = 15.0


class Reverses(_Statement):
    """Its horizontal direction of motion turns by more than `angle` degrees."""

    kind: Literal["reverses"] = "reverses"
    subject: Name
    angle: Angle = 90.0


class DescendsSlowly(_Statement):
    """Comes down by at least `drop` m and never faster than `speed` m/s."""

    kind: Literal["descends_slowly"] = "descends_slowly"
    subject: Name
    drop: Distance = 0.02
    speed: Distance = 0.5


class Deforms(_Statement):
    """Its shape changes by at least `strain` of its size."""

    kind: Literal["deforms"] = "deforms"
    subject: Name
    strain: Distance = 0.05


class Spreads(_Statement):
    """Its footprint grows by at least the factor `factor`."""

    kind: Literal["spreads"] = "spreads"
    subject: Name
    factor: Distance = 1.3


class Breaks(_Statement):
    """At least one of its joints releases."""

    kind: Literal["breaks"] = "breaks"
    subject: Name


class Sways(_Statement):
    """Moves to and fro at least `cycles` times with at least `amplitude` degrees."""

    kind: Literal["sways"] = "sways"
    subject: Name
    amplitude: Angle = 3.0
    cycles: Distance = 1.0


class Before(_Statement):
    """Both become true, the statement `first` before the statement `second`.

    `within`: and `second` follows within so many seconds.
    """

    kind: Literal["before"] = "before"
    first: Name
    second: Name
    within: Distance | None = None


class AllOf(_Statement):
    """Every one of `of` holds."""

    kind: Literal["all_of"] = "all_of"
    of: tuple[Name, ...] = Field(min_length=1, max_length=64)


class AnyOf(_Statement):
    """At least one of `of` holds."""

    kind: Literal["any_of"] = "any_of"
    of: tuple[Name, ...] = Field(min_length=1, max_length=64)


class CountOf(_Statement):
    """At least `low` and at most `high` of `of` hold: "only one of the pins falls"."""

    kind: Literal["count_of"] = "count_of"
    of: tuple[Name, ...] = Field(min_length=1, max_length=64)
    low: Annotated[int, Field(ge=0, le=64)] = 1
    high: Annotated[int, Field(ge=0, le=64)] = 64


Leaf = Annotated[
    Moves
    | Falls
    | Contacts
    | Topples
    | Stays
    | RestsOn
    | ReachesOn
    | Leaves
    | LandsIn
    | PassesOver
    | Stops
    | StopsBefore
    | Airborne
    | Rotates
    | Flips
    | Upright
    | SpeedBetween
    | PathBends
    | Reverses
    | DescendsSlowly
    | Deforms
    | Spreads
    | Breaks
    | Sways,
    Field(discriminator="kind"),
]
"""A statement about one object; composites refer to others instead."""

Statement = Annotated[Leaf | Before | AllOf | AnyOf | CountOf, Field(discriminator="kind")]


class Contract(Frozen):
    """What must be true of the rollout for the event to have happened.

    Statements that only serve a composite are listed in its `of`; all others must hold.
    not_understood: the words of the prompt that nothing here stands for.
    """

    clauses: tuple[Clause, ...] = Field(default=(), max_length=64)
    statements: tuple[Statement, ...] = Field(default=(), max_length=256)
    not_understood: tuple[Text, ...] = Field(default=(), max_length=64)

    @property
    def serving(self) -> frozenset[str]:
        """Ids of statements that only serve a composite; they are measured but not demanded.

        What a `before` orders is demanded like any other, unless the `before` itself serves.
        """
        named: set[str] = set()
        for statement in self.statements:
            if isinstance(statement, AllOf | AnyOf | CountOf):
                named.update(statement.of)
        for _ in self.statements:
            inner = {
                one
                for statement in self.statements
                if isinstance(statement, Before) and statement.id in named
                for one in (statement.first, statement.second)
            }
            if inner <= named:
                break
            named |= inner
        return frozenset(named)

    @property
    def untested(self) -> tuple[Clause, ...]:
        """Clauses of the prompt that no statement tests (coverage)."""
        tested = {statement.clause for statement in self.statements}
        return tuple(clause for clause in self.clauses if clause.id not in tested)
