"""The benchmark's reference contracts: complete, and hard to satisfy by accident.

On the true scene behind each picture a contract has to reject a scene in which nothing is done, the
mirrored program, the right motion of a wrong thing, the picture's other events and twenty random
programs. A random program that pushes a thing of the sentence the way that the sentence sends it
is no wrong one; another is drawn in its place.
"""

from __future__ import annotations

from collections.abc import Iterator
from functools import cache
from itertools import islice

import numpy as np
import pytest

from physagent_studio.benchmark.paper.listing import FAMILIES, Event, events
from physagent_studio.contract import measure
from physagent_studio.program import PhysicalProgram
from physagent_studio.program.contract import Contract
from physagent_studio.simulation import simulate
from tests.benchmark.paper.truth import first_program, stage_of
from tests.reference_contracts.teeth import (
    acting,
    held_until_pushed,
    mirrored,
    misplaced,
    random_program,
    undone,
    way_of,
)

EVENTS = {event.label: event for event in events()}
DOSE = tuple(EVENTS)[:: len(EVENTS) // 6]
"""Events that every run of the tests holds against a few wrong programs; the rest are slow."""
every = pytest.mark.parametrize(
    "label", [pytest.param(n, marks=() if n in DOSE else (pytest.mark.slow,)) for n in EVENTS]
)


def test_there_are_27_scenes_and_80_events_of_five_families() -> None:
    assert len({event.scene for event in EVENTS.values()}) == 27
    assert len(EVENTS) == 80
    families = [event.family for event in EVENTS.values()]
    assert set(families) == set(FAMILIES)
    assert min(families.count(family) for family in FAMILIES) >= 14


def test_a_contract_speaks_of_what_is_in_the_picture() -> None:
    for event in EVENTS.values():
        stage = stage_of(event.scene)
        known = {*stage.objects, *stage.supports, *stage.landmarks, "floor"}
        for statement in event.reference.statements:
            for field in ("subject", "other", "landmark", "near", "before"):
                name = getattr(statement, field, None)
                assert name is None or name in known, (event.label, name)


def holds(event: Event, program: PhysicalProgram) -> bool:
    """Whether the reference holds on a run of the program."""
    judged = program.model_copy(update={"contract": event.reference})
    checks = measure(judged, simulate(judged, {}))
    return all(check.ok for check in checks if check.demanded and check.kind != "view")


@cache
def first(label: str) -> PhysicalProgram:
    return first_program(EVENTS[label])


@cache
def by_itself(label: str) -> bool:
    """Whether gravity alone makes the event."""
    return holds(EVENTS[label], acting(first(label), ()))


def resting(label: str, program: PhysicalProgram) -> PhysicalProgram:
    """The program; where gravity alone makes the event, all is held until it is pushed."""
    return held_until_pushed(program) if by_itself(label) else program


def has_direction(event: Event) -> bool:
    """Whether the reference gives a definite way."""
    return any(
        getattr(statement, field, None) not in (None, "either", "up", "down")
        for statement in event.reference.statements
        if statement.id not in event.reference.serving
        for field in ("direction", "side", "landmark")
    )


@every
def test_nothing_done_is_rejected(label: str) -> None:
    assert not holds(EVENTS[label], undone(first(label)))


@every
def test_the_mirrored_program_is_rejected(label: str) -> None:
    program = mirrored(first(label))
    if program is None or not has_direction(EVENTS[label]):
        pytest.skip("its sentence or its program has no direction to mirror")
    if by_itself(label):
        pytest.skip("gravity makes it, whichever way the thing is nudged before")
    assert not holds(EVENTS[label], program)


@every
def test_the_right_motion_of_a_wrong_thing_is_rejected(label: str) -> None:
    for program in misplaced(first(label)):
        assert not holds(EVENTS[label], resting(label, program))


ALIKE = ({"train_on_ramp/rolls_down", "train_on_ramp/then_hits_block"},)
"""Events of a picture of which one may do the other too: the same roll goes farther."""


@every
def test_the_other_events_of_the_picture_are_rejected(label: str) -> None:
    event = EVENTS[label]
    for other in EVENTS.values():
        if other.scene != event.scene or other is event:
            continue
        program = first(other.label)
        # A first program that does not make its own event says nothing about this one.
        if {label, other.label} not in ALIKE and holds(other, program):
            assert not holds(event, program.model_copy(update={"contract": Contract()})), other


def ways_of(event: Event) -> set[tuple[str, str]]:
    """(thing, way) that the sentence itself asks for, by the reference."""
    spots = {name: np.array(spot) for name, (_, spot, _) in stage_of(event.scene).objects.items()}
    ways: set[tuple[str, str]] = set()
    for statement in event.reference.statements:
        subject, way = getattr(statement, "subject", None), getattr(statement, "direction", None)
        if subject is None or statement.negated:
            continue
        if way is not None:
            ways.add((subject, way))
        elif statement.kind == "contacts" and statement.other in spots:
            ways.add((subject, towards(spots[statement.other] - spots[subject])))
    return ways


def towards(step: np.ndarray) -> str:
    """The level way that comes nearest to a step in the world."""
    if abs(step[0]) >= abs(step[1]):
        return "right" if step[0] > 0 else "left"
    return "away" if step[1] > 0 else "toward_camera"


def wrong(label: str, count: int) -> Iterator[tuple[int, PhysicalProgram]]:
    """Random programs, by seed, that do not do what the sentence asks for.

    Where gravity alone makes the event, whatever lets go of a thing of the sentence does.
    """
    event, program = EVENTS[label], first(label)
    meant = ways_of(event)
    let_go = {getattr(s, "subject", "") for s in event.reference.statements if not s.negated}
    if not by_itself(label):
        let_go = set()
    tried = ((seed, random_program(program, seed)) for seed in range(400))
    unmeant = (
        (seed, one)
        for seed, one in tried
        if not meant & {(a.name, way_of(a) or "") for a in one.event.actions}
        and not let_go & {a.name for a in one.event.actions}
    )
    for seed, one in islice(unmeant, count):
        yield seed, resting(label, one)


@every
def test_two_random_programs_are_rejected(label: str) -> None:
    assert not [seed for seed, one in wrong(label, 2) if holds(EVENTS[label], one)]


@pytest.mark.slow
@pytest.mark.parametrize("label", EVENTS)
def test_twenty_random_programs_are_rejected(label: str) -> None:
    found = list(wrong(label, 20))
    if not found:
        pytest.skip("whatever is pushed there lets go of what shall fall")
    assert len(found) == 20
    assert not [seed for seed, one in found if holds(EVENTS[label], one)]
