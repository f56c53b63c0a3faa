"""What the sentence does not speak of is left alone: nothing that moves runs into it."""

from collections.abc import Iterator
from typing import Any

import numpy as np

from physagent_studio.contract.facts import Facts
from physagent_studio.contract.track import Window
from physagent_studio.contract.view.basics import height_of, view_check
from physagent_studio.contract.words import number
from physagent_studio.program.program import PhysicalProgram
from physagent_studio.program.statements import Contacts
from physagent_studio.records.judgement import Check

BUMP = 1.0
"""Fastest that something may come up to a bystander, its own heights per second: it leans on it."""
LEAST_BUMP = 0.1
"""The same for what is low, m/s."""


def bystanders(program: PhysicalProgram) -> frozenset[str]:
    """Objects that neither contract nor schedule speaks of."""
    told = {word for one in program.contract.statements for word in _words(one.model_dump())}
    told |= {word for action in program.event.actions for word in _words(action.model_dump())}
    return frozenset(item.name for item in program.scene.objects) - told


def leaves_alone(facts: Facts, names: tuple[str, ...]) -> list[Check]:
    """Who comes along the ground, at a speed that is seen, against what nothing is told of.

    What falls on something, or lay against it from the start, is not asked, nor what is told to
    meet another thing: where either goes from there is nobody's doing.
    """
    found = []
    meeting = _met(facts.program)
    beside = sorted(bystanders(facts.program) & set(facts.rollout.objects))
    for name in (one for one in names if one not in meeting):
        for other in beside:
            step = _meets(facts, name, other)
            if step is None:
                continue
            before = Window(step - 1, step - 1)
            own, theirs = (facts.track(one, before).velocities[0, :2] for one in (name, other))
            # Who stands still is run into, and runs into nobody.
            speed = float(min(np.linalg.norm(own - theirs), np.linalg.norm(own)))
            most = max(LEAST_BUMP, BUMP * height_of(facts, name))
            text = (
                f"{name} does not run into {other}, which nothing is told of: "
                f"{number(speed, 'm/s')} ≤ {number(most, 'm/s')}: {{answer}}"
            )
            found.append(
                view_check(
                    "alone", f"{name}.{other}", text, (most - speed) / most,
                    measured=speed, threshold=most, unit="m/s", step=step,
                )
            )  # fmt: skip
    return found


def _met(program: PhysicalProgram) -> frozenset[str]:
    """Objects that are told to meet another one."""
    objects = {item.name for item in program.scene.objects}
    pairs = [
        {one.subject, one.other}
        for one in program.contract.statements
        if isinstance(one, Contacts) and not one.negated
    ]
    return frozenset(name for pair in pairs if pair <= objects for name in pair)


def _meets(facts: Facts, name: str, other: str) -> int | None:
    """The step at which they first touch, if one comes to the other on the ground then."""
    touching = facts.touching(name, other, facts.whole())
    if not touching.any() or touching[0]:
        return None
    step = int(touching.argmax())
    carried = facts.touching_anything(name, Window(max(step - 2, 0), step - 1))
    return step if carried.any() else None


def _words(value: Any) -> Iterator[str]:
    if isinstance(value, str):
        yield value
    elif isinstance(value, dict | list | tuple):
        for part in value.values() if isinstance(value, dict) else value:
            yield from _words(part)
