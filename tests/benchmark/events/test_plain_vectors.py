"""Without semantic actions: plain forces and torques that do about the same."""

from __future__ import annotations

import numpy as np
import pytest

from physagent_studio.agent.crew import Bench, Crew
from physagent_studio.agent.loop import advance
from physagent_studio.agent.rules import RuleGenerator, RuleVerifier
from physagent_studio.benchmark.events.plain_vectors import PlainGenerator, PlainPlanner, plain
from physagent_studio.contract import measure
from physagent_studio.program import Directed, PhysicalProgram, SceneState
from physagent_studio.program.actions import (
    Action,
    ApplyAngledForce,
    ApplyDisturbance,
    ApplyForce,
    ApplyTorque,
    FixObject,
    OnContact,
    SetAngularVelocity,
    SetVelocity,
)
from physagent_studio.program.program import EventProgram
from physagent_studio.program.scene.state import Floor, SceneObject, Sphere, Support
from physagent_studio.records import LoopState, Rollout, Scene
from physagent_studio.simulation import simulate
from tests.agent.rules.scenes import STAGES


def program(*actions: Action) -> PhysicalProgram:
    """A ball in free space, so that what an action gives is what it has."""
    ball = SceneObject(name="ball", shape=Sphere(radius=0.1), position=(0, 2, 5), support="air")
    scene = SceneState(
        gravity=(0, 0, 0), objects=(ball,), supports=(Support(name="floor", shape=Floor()),)
    )
    return PhysicalProgram(scene=scene, event=EventProgram(actions=actions))


def only(compiled: PhysicalProgram) -> Action:
    (action,) = compiled.event.actions
    return action


def is_plain(action: Action) -> bool:
    vector = getattr(action, "force", None) or getattr(action, "torque", None)
    return (
        isinstance(action, ApplyForce | ApplyTorque)
        and not isinstance(vector, Directed)
        and action.when is None
    )


def final_velocity(compiled: PhysicalProgram) -> np.ndarray:
    rollout = simulate(compiled)
    return (rollout.positions[200, 0] - rollout.positions[100, 0]) / (100 * rollout.step_seconds)


@pytest.mark.parametrize(
    "action",
    [
        SetVelocity(id="a", name="ball", velocity=(1.0, -2.0, 0.5)),
        SetVelocity(id="a", name="ball", velocity=Directed(magnitude=1.5, direction="left")),
        ApplyForce(
            id="a", name="ball", duration=12,
            force=Directed(magnitude=2.0, direction="right", azimuth=30, elevation=20,
                           quantity="target_speed"),
        ),
        ApplyForce(
            id="a", name="ball", duration=20,
            force=Directed(magnitude=6.0, toward=(3.0, 2.0, 5.0), quantity="acceleration"),
        ),
    ],
)  # fmt: skip
def test_the_compiled_push_gives_the_same_velocity(action: Action):
    meant = program(action)
    compiled = plain(meant)
    assert is_plain(only(compiled))
    assert final_velocity(compiled) == pytest.approx(final_velocity(meant), abs=0.02)


def test_a_spin_becomes_a_torque():
    spin = SetAngularVelocity(id="a", name="ball", angular_velocity=(0, 0, 4.0), duration=30)
    compiled = plain(program(spin))
    action = only(compiled)
    assert isinstance(action, ApplyTorque)
    rollout = simulate(compiled)
    assert rollout.angular[100, 0, 2] > 1.0


def test_a_bend_follows_no_velocity_but_the_first_heading():
    push = SetVelocity(id="a", name="ball", velocity=(0.0, 2.0, 0.0))
    bend = ApplyAngledForce(id="b", name="ball", magnitude=3.0, angle=-90, duration=20)
    force = plain(program(push, bend)).event.actions[1]
    assert isinstance(force, ApplyForce)
    assert force.force == pytest.approx((3.0, 0.0, 0.0), abs=1e-9)


def test_a_wind_becomes_its_pressure():
    wind = ApplyDisturbance(
        id="a", name="ball", model="wind", amplitude=5, direction="left", duration=90
    )
    force = only(plain(program(wind)))
    assert isinstance(force, ApplyForce)
    assert force.force == pytest.approx((-0.6 * 0.04 * 25, 0, 0), abs=1e-6)


def test_holding_cannot_be_said_and_conditions_become_steps():
    hold = FixObject(id="h", name="ball", duration=30)
    later = ApplyTorque(
        id="t", name="ball", torque=(0, 0, 1), duration=10, when=OnContact(a="ball", b="floor")
    )
    (action,) = plain(program(hold, later)).event.actions
    assert action.id == "t"
    assert action.when is None
    assert action.start_step == 160


def test_compiling_twice_changes_nothing():
    push = ApplyForce(
        id="a", name="ball", duration=12,
        force=Directed(magnitude=2.0, direction="right", quantity="target_speed"),
    )  # fmt: skip
    once = plain(program(push))
    assert plain(once) is once


@pytest.mark.parametrize(
    ("stage", "prompt"),
    [
        ("lane", "The bowling ball rolls toward the middle pin, hits it and knocks it over."),
        ("desk", "The red cube is pushed to the right and falls off the table."),
        ("stack", "The top box is pushed to the left and falls off the stack."),
    ],
)
@pytest.mark.slow
def test_generator_and_planner_say_everything_plainly(stage: str, prompt: str):
    """The loop over plain vectors, from the first program through whatever it repairs."""
    case, kept = STAGES[stage].case(prompt), {}

    def put(value: object) -> str:
        kept[str(len(kept))] = value
        return str(len(kept) - 1)

    def run(candidate: PhysicalProgram, scene: Scene) -> Rollout:
        return simulate(candidate, scene.meshes)

    bench = Bench(
        case=case,
        reconstruct=lambda state, before: STAGES[stage].reconstruct(state),
        simulate=run,
        measure=lambda program, rollout, scene: measure(program, rollout),
        view=lambda scene: None,
        evidence=lambda scene, rollout: (),
        put_scene=put,
        get_scene=kept.__getitem__,  # type: ignore[arg-type]
        put_rollout=put,
        get_rollout=kept.__getitem__,  # type: ignore[arg-type]
        put_frames=put,
    )
    crew = Crew(PlainGenerator(), RuleVerifier(), PlainPlanner())
    state = LoopState(policy="auto", budget=3)
    while state.phase != "done":
        state = advance(state, crew, bench)
    assert state.rounds
    for item in state.rounds:
        assert all(is_plain(action) for action in item.program.event.actions)
    meant = RuleGenerator().first(case, STAGES[stage].reconstruct)
    assert len(state.rounds[0].program.event.actions) <= len(meant.event.actions)
