"""Which programs a sweep runs: grids of fields, draws, and the uncertain numbers moved."""

import hashlib
import itertools
import math
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from physagent_studio.contract.view import Drawn
from physagent_studio.errors import EditError, InputError, Problem, ProgramError
from physagent_studio.program import PhysicalProgram, SetField, apply, value_at
from physagent_studio.program.edits import Edit
from physagent_studio.records import Scene


@dataclass(frozen=True, slots=True)
class Span:
    """A field and the ends between which it is moved; steps: values of a grid, 0 where drawn."""

    path: str
    low: float
    high: float
    steps: int = 0

    @property
    def values(self) -> list[float]:
        """The values of a grid, both ends among them."""
        return np.linspace(self.low, self.high, self.steps).tolist()


def span_of(word: str, *, grid: bool) -> Span:
    """`FIELD=A:B:N` of a grid, or `FIELD=A:B` of what is drawn. Raises InputError."""
    path, _, ends = word.partition("=")
    try:
        low, high, *rest = (float(part) for part in ends.split(":"))
        steps = int(*rest) if grid else 0
        if len(rest) != grid or steps < grid or not path or not math.isfinite(low + high):
            raise ValueError(word)
    except (ValueError, OverflowError, TypeError):
        form = "FIELD=A:B:N" if grid else "FIELD=A:B"
        raise InputError(f"{word} is not of the form {form}") from None
    return Span(path.strip(), low, high, steps)


def checked(program: PhysicalProgram, span: Span) -> None:
    """Raises `EditError` where a field is no number of the program, or an end is not allowed."""
    if isinstance(value_at(program, span.path), bool | str | list | dict):
        try:
            value_at(program, f"{span.path}.?")
        except EditError as error:
            # What is in it is what may be meant.
            allowed = error.problems[0].allowed or "a field that holds a number"
            raise EditError((Problem(span.path, "is no number", allowed),)) from None
    for end in (span.low, span.high):
        apply(program, (setting(program, span.path, end),))


def setting(program: PhysicalProgram, path: str, value: float) -> SetField:
    """The edit that sets a field; where a whole number stands it stays one."""
    whole = isinstance(value_at(program, path), int)
    return SetField(path=path, value=round(value) if whole else value)


MOST_POINTS = 200_000
"""Points of one sweep; each is a row of its table."""
MESHED = ("inflated", "meshed")
"""Kinds of shape that collide as a mesh which the program does not hold."""


@dataclass(frozen=True, eq=False, slots=True)
class Target:
    """A program to begin with, complete, on its scene. label: what to call it.

    drawn: how like its photograph each thing is drawn, where there is one; a demand of its own.
    """

    label: str
    program: PhysicalProgram
    scene: Scene
    drawn: Mapping[str, Drawn] | None = None


@dataclass(frozen=True, eq=False)
class Point:
    """One program of a sweep. values: what was set, by path. seed: of its draw, −1 for none.

    program: None where the values make none that is valid; problem says why.
    """

    target: Target
    values: Mapping[str, float]
    program: PhysicalProgram | None
    seed: int = -1
    problem: str = ""

    @cached_property
    def key(self) -> str:
        """The hash of all that goes into its run: the program and the scene."""
        made = self.program.hash if self.program else repr(sorted(self.values.items()))
        return hashlib.sha256(f"{made}|{self.target.scene.hash}".encode()).hexdigest()


Draw = Callable[[PhysicalProgram, int], tuple[tuple[Edit, ...], Mapping[str, float]]]
"""The edits of the draw of that number, and the values that they set."""


@dataclass(frozen=True, slots=True)
class Plan:
    """What a sweep does to every target: each point of the grid, moved by each of the draws.

    random: fields that are drawn evenly; draw: what moves numbers otherwise. seeds: how many draws.
    """

    grid: tuple[Span, ...] = ()
    random: tuple[Span, ...] = ()
    seeds: int = 0
    draw: Draw | None = None

    @property
    def size(self) -> int:
        """Points for one target."""
        return math.prod(span.steps for span in self.grid) * max(self.seeds, 1)


def planned(plan: Plan, targets: tuple[Target, ...]) -> Iterator[Point]:
    """All points, target after target; the same plan gives the same points in the same order.

    Raises at once: EditError for a field that a target does not have, InputError for a sweep too
    large or of what a photograph shows.
    """
    if plan.size * len(targets) > MOST_POINTS:
        raise InputError(f"{plan.size * len(targets)} runs; one sweep has at most {MOST_POINTS}")
    for target, span in itertools.product(targets, (*plan.grid, *plan.random)):
        checked(target.program, span)
        if set_by_reconstruction(target, span.path):
            raise InputError(
                f"{span.path} is what {target.label} is reconstructed from, which a sweep does not"
                " do again; sweep it where shapes are stated as primitives, without a photograph"
            )
    return _points(plan, targets)


def set_by_reconstruction(target: Target, path: str) -> bool:
    """Whether only reconstruction answers another value: a photograph's forms, and meshes."""
    parts = path.split(".")
    if parts[0] != "scene" or not {"shape", "grounding", "camera", "horizon"} & set(parts):
        return False
    item = target.program.scene.object(parts[2]) if len(parts) > 2 else None
    meshed = item is not None and item.shape is not None and item.shape.kind in MESHED
    return meshed or target.scene.photo is not None


def _points(plan: Plan, targets: tuple[Target, ...]) -> Iterator[Point]:
    grid = itertools.product(*(span.values for span in plan.grid))
    paths = [span.path for span in plan.grid]
    for target, chosen in itertools.product(targets, list(grid)):
        for seed in range(plan.seeds) if plan.seeds else (-1,):
            yield _point(plan, target, dict(zip(paths, chosen, strict=True)), seed)


def _point(plan: Plan, target: Target, values: dict[str, float], seed: int) -> Point:
    # Of the seed and the field's place alone: a draw is the same whatever else a sweep has.
    for place, span in enumerate(plan.random):
        share = float(np.random.default_rng((seed, place)).random())
        values[span.path] = span.low + (span.high - span.low) * share
    try:
        program = target.program
        program = apply(program, [setting(program, path, one) for path, one in values.items()])
        if plan.draw is not None:
            moved, told = plan.draw(program, seed)
            # What the grid holds is not moved.
            program = apply(program, [edit for edit in moved if edit.path not in values])
            values = {**told, **values}
    except ProgramError as error:
        return Point(target, values, None, seed, str(error))
    return Point(target, values, program, seed)
