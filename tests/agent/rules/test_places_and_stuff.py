"""Halves and edges of tables, what is thrown over things, what behaves like jelly, scenery."""

from __future__ import annotations

import numpy as np
import pytest

from physagent_studio.agent.rules import RuleGenerator
from physagent_studio.contract.measure import measure
from physagent_studio.language import Reading, inventory, read
from physagent_studio.program import PhysicalProgram
from physagent_studio.program.scene.bodies import Soft
from physagent_studio.program.scene.state import Box, Cylinder, Grounding, Slab, Sphere
from physagent_studio.records import Check
from physagent_studio.simulation import simulate
from tests.agent.rules.scenes import Stage

TABLE = Stage(
    "table",
    {
        "lamp": (Box(size=(0.08, 0.08, 0.15)), (-0.5, 2.5, 0.825), "table"),
        "vase": (Cylinder(radius=0.05, height=0.2), (-0.1, 2.5, 0.85), "table"),
        "cup": (Cylinder(radius=0.04, height=0.1), (0.1, 2.7, 0.8), "table"),
        "book": (Box(size=(0.04, 0.15, 0.2)), (0.5, 2.5, 0.85), "table"),
    },
    {"table": Slab(position=(0.0, 2.5, 0.375), size=(1.6, 0.8, 0.75))},
)
FLOOR = Stage(
    "floor",
    {
        "monkey": (Box(size=(0.1, 0.1, 0.12)), (-0.5, 3.0, 0.06), "floor"),
        "cardboard_box": (Box(size=(0.2, 0.2, 0.2)), (0.2, 3.0, 0.1), "floor"),
        "truck": (Box(size=(0.3, 0.12, 0.12)), (-0.6, 2.5, 0.06), "floor"),
        "ball": (Sphere(radius=0.1), (0.3, 2.5, 0.1), "floor"),
    },
)


def _program(stage: Stage, prompt: str) -> PhysicalProgram:
    program = RuleGenerator().first(stage.case(prompt), stage.reconstruct)
    assert not program.contract.untested
    assert not program.contract.not_understood
    return program


def _missed(program: PhysicalProgram) -> list[Check]:
    checks = measure(program, simulate(program, {}))
    return [check for check in checks if check.demanded and check.kind != "view" and not check.ok]


def _reading(prompt: str, objects: str, supports: str = "") -> Reading:
    things, below = ([(n, Grounding()) for n in text.split()] for text in (objects, supports))
    return read(prompt, inventory(things, below))


@pytest.mark.parametrize(
    ("prompt", "name", "side"),
    [
        ("The lamp is thrown over the vase and lands on the right side of the table.", "lamp", 1),
        ("The lamp flies over the vase and lands on the right half of the table.", "lamp", 1),
        ("The cup slides to the right side of the table.", "cup", 1),
        ("The cup is pushed onto the left half of the table.", "cup", -1),
    ],
)
def test_it_ends_in_that_half_of_the_table(prompt: str, name: str, side: int) -> None:
    program = _program(TABLE, prompt)
    rollout = simulate(program, {})
    end = np.asarray(rollout.positions[-1, rollout.index(name)])
    assert end[0] * side > 0
    assert any(getattr(s, "other", "") == "table_center" for s in program.contract.statements)
    assert not _missed(program)


def test_what_is_only_above_a_thing_is_not_over_it() -> None:
    program = _program(TABLE, "The lamp is thrown over the vase.")
    passing = [s for s in program.contract.statements if s.kind == "passes_over"]
    assert [getattr(s, "by", False) for s in passing] == [False, True]
    assert not _missed(program)


@pytest.mark.parametrize(
    ("prompt", "way"),
    [
        ("The brown cup slides slowly to the left edge of the table and falls off.", "left"),
        ("The cup rolls up to the right end of the table.", "right"),
        ("The cup is pushed to the right rim of the table.", "right"),
    ],
)
def test_the_edge_of_a_marked_table_is_a_place(prompt: str, way: str) -> None:
    reading = _reading(prompt, "cup", "table")
    assert not reading.not_understood
    first = reading.frames[0]
    assert first.direction == way
    assert [(p.name, bool(p.part)) for _, p in first.places] == [("table", True)]


@pytest.mark.parametrize(
    "prompt",
    [
        "The basket is lifted up by its handle and carried to the left.",
        "The guitar slips away from the dresser and falls over to the left.",
        "The cup is pushed off the table on the left side.",
        "The cushion slides off the table and drops onto the rug.",
        "The cup rolls away from the sofa.",
    ],
)
def test_scenery_on_which_nothing_depends_is_no_doubt(prompt: str) -> None:
    assert not _reading(prompt, "basket guitar cup cushion", "table").not_understood


@pytest.mark.parametrize(
    ("prompt", "word"),
    [
        ("The cup rolls to the sofa.", "sofa"),
        ("The cup hits the dresser.", "dresser"),
        ("The cup slides off the dresser.", "dresser"),
    ],
)
def test_what_changes_the_event_stays_a_doubt(prompt: str, word: str) -> None:
    assert word in _reading(prompt, "cup").not_understood


def test_what_was_not_marked_is_said() -> None:
    program = _program(FLOOR, "The ball rolls away from the dresser.")
    assert any("dresser" in text for text in program.scene.flags)


@pytest.mark.parametrize(
    "prompt",
    [
        "The vase wobbles like jelly.",
        "The vase shakes as if it were made of rubber.",
        "The vase sways as though made of soft foam.",
    ],
)
def test_what_behaves_like_jelly_is_soft(prompt: str) -> None:
    program = _program(TABLE, prompt)
    item = program.scene.object("vase")
    assert item is not None
    assert isinstance(item.body, Soft)


def test_a_thing_that_only_moves_is_not_like_jelly() -> None:
    reading = _reading("The vase slides to the left like jelly.", "vase")
    assert [f.sense for f in reading.frames] == ["slide"]
    assert reading.not_understood == ("like jelly",)


def test_what_is_squeezed_springs_back_into_its_form() -> None:
    program = _program(FLOOR, "The ball is squeezed flat and springs back.")
    kinds = [(s.kind, s.negated) for s in program.contract.statements]
    assert kinds == [("deforms", False), ("deforms", True)]
    assert not _missed(program)


def test_what_falls_flat_on_what_it_stands_on_topples() -> None:
    program = _program(TABLE, "The book falls flat on the table.")
    assert {"topples"} <= {statement.kind for statement in program.contract.statements}
    assert not _missed(program)


def test_away_is_farther_than_its_own_size() -> None:
    program = _program(FLOOR, "The truck drives to the right and knocks the ball away.")
    gone = [s for s in program.contract.statements if s.kind == "moves"]
    assert any(s.subject == "ball" and s.distance >= 0.3 for s in gone)
    assert not _missed(program)


@pytest.mark.parametrize(
    "prompt",
    [
        "The truck drives to the right, bumps the ball and comes to a halt.",
        "The truck drives into the ball and stops.",
    ],
)
def test_what_a_heavier_thing_bumps_stirs(prompt: str) -> None:
    program = _program(FLOOR, prompt)
    rollout = simulate(program, {})
    ball, truck = (
        np.asarray(rollout.positions[:, rollout.index(name)]) for name in ("ball", "truck")
    )
    assert ball[-1, 0] > ball[0, 0] + 0.05
    assert abs(truck[-1, 0] - truck[-40, 0]) < 0.01
    assert not _missed(program)
