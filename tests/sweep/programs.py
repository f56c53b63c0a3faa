"""Programs of which it is known in closed form what moves them."""

from __future__ import annotations

from physagent_studio.program import PhysicalProgram
from physagent_studio.program.text.document import load_program
from physagent_studio.reconstruction import reconstruct
from physagent_studio.records import Case
from physagent_studio.sweep import Target

SLIDER = """
clip: {frames: 11}
scene:
  objects:
    - {name: block, shape: {kind: box, size: [0.2, 0.2, 0.1]}, position: [0, 2, 0.05],
       support: floor, friction: 0.3, source: given}
  supports:
    - {name: floor, shape: {kind: floor}, friction: 0.3}
event:
  prompt: The block slides to the right.
  actions:
    - {operator: SetVelocity, id: go, name: block, velocity: [1.0, 0, 0], start_step: 0}
contract:
  clauses: [{id: c1, text: slides}]
  statements:
    - {id: slides, kind: moves, subject: block, direction: right, distance: DISTANCE, clause: c1}
"""
"""A block that slides v² / 2 μ g = .17 m, and does so within the clip."""


def slider(distance: float) -> Target:
    """The block, of which it is demanded that it gets so far, m."""
    return target(SLIDER.replace("DISTANCE", str(distance)))


def target(text: str) -> Target:
    """A program without a photograph, ready to be run; nothing but its contract is demanded."""
    program = load_program(text)
    scene = reconstruct(Case("bare", prompt=program.event.prompt), program.scene)
    whole: PhysicalProgram = program.model_copy(update={"scene": scene.state})
    return Target("bare", whole, scene)
