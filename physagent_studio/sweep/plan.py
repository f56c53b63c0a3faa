"""Which programs a sweep runs: grids, draws, and the uncertain numbers moved."""

from __future__ import annotations

import hashlib
import itertools
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field
from functools import cached_property
from types import MappingProxyType

import numpy as np

from physagent_studio.contract.view import Drawn
from physagent_studio.errors import InputError, ProgramError
from physagent_studio.program import PhysicalProgram, apply
from physagent_studio.program.edits import Edit
from physagent_studio.records import Mesh, Scene
from physagent_studio.sweep.fields import Span, checked, setting

MOST_POINTS = 200_000
"""Points of one sweep; each is a line of its tables."""


@dataclass(frozen=True, eq=False)
class Target:
    """A program to begin with. program: complete, its scene reconstructed. label: what to call it.

    drawn: how like its photograph each thing is drawn, where there is one; a demand of its own.
    """

    label: str
    program: PhysicalProgram
    scene: str = ""
    meshes: Mapping[str, Mesh] = field(default_factory=lambda: MappingProxyType({}))
    drawn: Mapping[str, Drawn] | None = None
    photo: bool = False

    @classmethod
    def of(
        cls,
        label: str,
        program: PhysicalProgram,
        scene: Scene,
        drawn: Mapping[str, Drawn] | None = None,
    ) -> Target:
        """The program on a scene, in whose meshes it runs."""
        return cls(label, program, scene.hash, scene.meshes, drawn, scene.photo is not None)


@dataclass(frozen=True, eq=False)
class Point:
    """One program of a sweep. values: what was set, by path. seed: of its draw, −1 for none.

    program: None where the values make none that is valid; problem says why.
    """

    target: Target
    values: Mapping[str, float]
    seed: int
    program: PhysicalProgram | None
    problem: str = ""

    @cached_property
    def key(self) -> str:
        """The hash of all that goes into its run: the program and the scene."""
        made = self.program.hash if self.program else repr(sorted(self.values.items()))
        return hashlib.sha256(f"{made}|{self.target.scene}".encode()).hexdigest()


Draw = Callable[[PhysicalProgram, int], tuple[tuple[Edit, ...], Mapping[str, float]]]
"""The edits of the draw of that seed, and the values that they set."""


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
        return int(np.prod([span.steps for span in self.grid], initial=1)) * max(self.seeds, 1)


def planned(plan: Plan, targets: tuple[Target, ...]) -> Iterator[Point]:
    """All points, target after target; the same plan gives the same points in the same order.

    Raises at once: EditError for a field that a target does not have, InputError for a sweep too
    large.
    """
    if plan.size * len(targets) > MOST_POINTS:
        raise InputError(f"{plan.size * len(targets)} runs; one sweep has at most {MOST_POINTS}")
    for target in targets:
        for span in (*plan.grid, *plan.random):
            _allowed(target, span)
            checked(target.program, span)
    return _points(plan, targets)


def _allowed(target: Target, span: Span) -> None:
    """Raises InputError for what only reconstruction answers: a photograph's forms, and meshes'."""
    parts = span.path.split(".")
    scenery = parts[0] == "scene" and bool({"shape", "grounding", "camera"} & set(parts))
    item = target.program.scene.object(parts[2]) if scenery and len(parts) > 2 else None
    meshed = item is not None and item.shape is not None and item.shape.kind in MESHED
    if scenery and (target.photo or meshed):
        raise InputError(
            f"{span.path} is what {target.label} is reconstructed from, which a sweep does not do"
            " again; sweep it where shapes are stated as primitives, without a photograph"
        )


MESHED = ("inflated", "meshed")
"""Kinds of shape that collide as a mesh which the program does not hold."""


def _points(plan: Plan, targets: tuple[Target, ...]) -> Iterator[Point]:
    for target in targets:
        for chosen in itertools.product(*(span.values for span in plan.grid)):
            values = {span.path: value for span, value in zip(plan.grid, chosen, strict=True)}
            for seed in range(plan.seeds) if plan.seeds else (-1,):
                yield _point(plan, target, values, seed)


def _point(plan: Plan, target: Target, values: Mapping[str, float], seed: int) -> Point:
    drawn = dict(values)
    # Of the seed and the field's place alone: a draw is the same whatever else a sweep has.
    for place, span in enumerate(plan.random):
        share = np.random.default_rng((seed, place)).random()
        drawn[span.path] = span.low + (span.high - span.low) * float(share)
    try:
        edits = [setting(target.program, path, value) for path, value in drawn.items()]
        program = apply(target.program, edits)
        if plan.draw is not None:
            moved, told = plan.draw(program, seed)
            # What the grid holds is not moved.
            kept = [edit for edit in moved if edit.path not in drawn]
            program, drawn = apply(program, kept), {**told, **drawn}
    except ProgramError as error:
        return Point(target, drawn, seed, None, str(error))
    return Point(target, drawn, seed, program)
