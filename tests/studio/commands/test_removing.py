"""What is deleted takes with it what would speak of nothing, in one step."""

from __future__ import annotations

import pytest

from physagent_studio.errors import ProgramError
from physagent_studio.program import apply
from physagent_studio.program.text.document import load_program
from physagent_studio.studio.commands.program import removing

PROGRAM = load_program("""
scene:
  objects:
    - {name: ball, shape: {kind: sphere, radius: 0.1}, position: [0, 2, 0.1], support: floor}
    - {name: box, shape: {kind: box, size: [0.2, 0.2, 0.2]}, position: [1, 2, 0.1]}
    - {name: lid, shape: {kind: box, size: [0.2, 0.2, 0.02]}, position: [1, 2, 0.21], support: box}
  supports: [{name: floor, shape: {kind: floor}}]
event:
  prompt: The ball hits the box.
  actions:
    - {operator: SetVelocity, id: go, name: ball, start_step: 0,
       velocity: {magnitude: 2, toward: box}}
    - {operator: SetVelocity, id: hop, name: ball, velocity: [0, 0, 1],
       when: {kind: after, action: go}}
    - {operator: SetVelocity, id: own, name: lid, velocity: [0, 0, 1], start_step: 9}
contract:
  clauses: [{id: c1, text: hits the box}]
  statements:
    - {id: hit, kind: contacts, subject: ball, other: box, clause: c1}
    - {id: rolls, kind: moves, subject: ball}
""")


def test_actions_statements_and_stands_go_with_a_thing() -> None:
    after = apply(PROGRAM, removing(PROGRAM, "scene.objects.box"))
    assert [one.name for one in after.scene.objects] == ["ball", "lid"]
    lid = after.scene.object("lid")
    assert lid is not None
    assert lid.support is None
    assert [one.id for one in after.event.actions] == ["own"], (
        "one aimed at it, one waited for that"
    )
    assert [one.id for one in after.contract.statements] == ["rolls"]


def test_what_nobody_speaks_of_goes_alone() -> None:
    assert len(removing(PROGRAM, "event.actions.own")) == 1
    assert len(removing(PROGRAM, "contract.statements.rolls")) == 1


def test_what_is_not_there_is_said() -> None:
    with pytest.raises(ProgramError, match="nobody"):
        removing(PROGRAM, "scene.objects.nobody")
