"""Captions say what the simulation did."""

from __future__ import annotations

from physagent_studio.exchange.prior.captions import captions
from physagent_studio.program import PhysicalProgram, SceneObject, SceneState, Support
from physagent_studio.program.actions import SetVelocity
from physagent_studio.program.program import EventProgram
from physagent_studio.program.scene.state import Box, Floor, Sphere
from physagent_studio.reconstruction import reconstruct
from physagent_studio.records import Case, Rollout
from physagent_studio.simulation import simulate


def run_of(program: PhysicalProgram) -> Rollout:
    scene = reconstruct(Case("a", None, "", (), (), (), ""), program.scene)
    return simulate(program.model_copy(update={"scene": scene.state}), scene.meshes)


def test_what_falls_hits_and_comes_to_rest_is_said() -> None:
    ball = SceneObject(name="red_ball", shape=Sphere(radius=0.1), position=(0, 2, 2.0))
    crate = SceneObject(name="crate", shape=Box(size=(0.2, 0.2, 0.2)), position=(1, 2, 0.1))
    floor = Support(name="floor", shape=Floor())
    push = SetVelocity(id="push", name="crate", velocity=(0.8, 0, 0))
    program = PhysicalProgram(
        scene=SceneState(objects=(ball, crate), supports=(floor,)),
        event=EventProgram(actions=(push,)),
    )
    found = captions(run_of(program))
    assert [(one["first"], one["last"]) for one in found] == [
        (0, 19),
        (20, 39),
        (40, 59),
        (60, 79),
        (80, 80),
    ]
    said = [str(one["caption"]) for one in found]
    assert "the red ball falls" in said[0].lower()
    assert "the red ball hits the floor" in said[0].lower()
    assert "crate" in said[0]
    assert "hits the floor" not in " ".join(said[1:])
    assert "crate" not in said[-1]


def test_a_still_scene_has_nothing_to_say() -> None:
    crate = SceneObject(name="crate", shape=Box(size=(0.2, 0.2, 0.2)), position=(1, 2, 0.1))
    floor = Support(name="floor", shape=Floor())
    program = PhysicalProgram(scene=SceneState(objects=(crate,), supports=(floor,)))
    assert {str(one["caption"]) for one in captions(run_of(program))} == {"Nothing moves."}
