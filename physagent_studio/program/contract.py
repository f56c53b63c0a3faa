"""The event contract: machine-checkable statements over a rollout.

What is said of one object is in `statements.py` and taken up here; composite statements refer to
others by id. `contract` (the room) measures them; this file is only their schema.
"""

from typing import Annotated, Literal

from pydantic import Field

from physagent_studio.program.base import Frozen, Name, Text
from physagent_studio.program.statements import Distance, Leaf, Stated


class Clause(Frozen):
    """A part of the prompt that says something testable; `text` is its wording."""

    id: Name
    text: Text


class Before(Stated):
    """Both become true, the statement `first` before the statement `second`.

    `within`: and `second` follows within so many seconds.
    """

    kind: Literal["before"] = "before"
    first: Name
    second: Name
    within: Distance | None = None


class AllOf(Stated):
    """Every one of `of` holds."""

    kind: Literal["all_of"] = "all_of"
    of: tuple[Name, ...] = Field(min_length=1, max_length=64)


class AnyOf(Stated):
    """At least one of `of` holds."""

    kind: Literal["any_of"] = "any_of"
    of: tuple[Name, ...] = Field(min_length=1, max_length=64)


class CountOf(Stated):
    """At least `low` and at most `high` of `of` hold: "only one of the pins falls"."""

    kind: Literal["count_of"] = "count_of"
    of: tuple[Name, ...] = Field(min_length=1, max_length=64)
    low: Annotated[int, Field(ge=0, le=64)] = 1
    high: Annotated[int, Field(ge=0, le=64)] = 64


class InTurn(Stated):
    """Each of `of` becomes true, no two of them within `apart` seconds of each other.

    `ordered`: in the order given.
    """

    kind: Literal["in_turn"] = "in_turn"
    of: tuple[Name, ...] = Field(min_length=2, max_length=64)
    apart: Distance = 0.1
    ordered: bool = False


class Together(Stated):
    """Each of `of` becomes true, all within `within` seconds."""

    kind: Literal["together"] = "together"
    of: tuple[Name, ...] = Field(min_length=2, max_length=64)
    within: Distance = 0.25


Composite = Before | AllOf | AnyOf | CountOf | InTurn | Together
"""A statement about other statements."""

Statement = Annotated[Leaf | Composite, Field(discriminator="kind")]


class Speeds(Frozen):
    """How fast a thing may be seen to go by the verb that the sentence has for it.

    verb: the sense of the verb. low, high: m/s of its centre, by the verb and the thing's size.
    """

    subject: Name
    verb: Text
    low: Distance = 0.0
    high: Distance


class Contract(Frozen):
    """What must be true of the rollout for the event to have happened.

    Statements that only serve a composite are listed in its `of`; all others must hold.
    not_understood: the words of the prompt that nothing here stands for. paces: the speeds that
    its verbs allow; a check of the view, not a demand. leaving: objects that it has leave the
    picture; partly: those of which a part does, and not all; backwards: those that it has go with
    their back first.
    """

    clauses: tuple[Clause, ...] = Field(default=(), max_length=64)
    statements: tuple[Statement, ...] = Field(default=(), max_length=256)
    not_understood: tuple[Text, ...] = Field(default=(), max_length=64)
    paces: tuple[Speeds, ...] = Field(default=(), max_length=64)
    leaving: tuple[Name, ...] = Field(default=(), max_length=64)
    partly: tuple[Name, ...] = Field(default=(), max_length=64)
    backwards: tuple[Name, ...] = Field(default=(), max_length=64)

    @property
    def serving(self) -> frozenset[str]:
        """Ids of statements that only serve a composite; they are measured but not demanded.

        What a `before`, an `in_turn` or a `together` speaks of is demanded like any other,
        unless that itself serves.
        """
        named: set[str] = set()
        for statement in self.statements:
            if isinstance(statement, AllOf | AnyOf | CountOf):
                named.update(statement.of)
        for _ in self.statements:
            inner = {
                one
                for statement in self.statements
                if statement.id in named
                for one in _timed(statement)
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


def spoken_of(statement: Statement) -> tuple[str, ...]:
    """Ids of the statements that a statement speaks of; none where it is about a thing."""
    if isinstance(statement, Before):
        return (statement.first, statement.second)
    return statement.of if isinstance(statement, Composite) else ()


def _timed(statement: Statement) -> tuple[str, ...]:
    """What a statement about the order of others speaks of."""
    return spoken_of(statement) if isinstance(statement, Before | InTurn | Together) else ()
