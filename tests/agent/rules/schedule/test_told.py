"""First programs of what is told in passing: which way, how slowly, and that it stays there."""

from __future__ import annotations

import math

import numpy as np

from physagent_studio.agent.rules import RuleGenerator
from physagent_studio.contract.facts import Facts
from physagent_studio.contract.picture import sight_of
from physagent_studio.program import PhysicalProgram
from physagent_studio.program.actions import ApplyForce, FixObject, SetAngularVelocity
from physagent_studio.program.rotations import matrix_of
from physagent_studio.program.scene.state import Box, Cylinder, Ramp, Slab, Sphere
from physagent_studio.simulation import simulate
from tests.agent.rules.scenes import Stage

SPINNER = {"spinning_top": (Cylinder(radius=0.05, height=0.1), (0.0, 2.5, 0.05), "floor")}


def program_of(stage: Stage, prompt: str) -> PhysicalProgram:
    return RuleGenerator().first(stage.case(prompt), stage.reconstruct)


def test_what_spins_on_its_way_stays_upright():
    rollout = simulate(
        program_of(Stage("yard", SPINNER), "The spinning top spins and moves to the right.")
    )
    tilts = [matrix_of(one.tolist())[2, 2] for one in rollout.rotations[:, 0]]
    assert min(tilts) > math.cos(math.radians(10))
    assert rollout.positions[-1, 0, 0] - rollout.positions[0, 0, 0] > 0.05


def test_what_turns_around_and_nothing_more_stays_there():
    things = {"box": (Box(size=(0.2, 0.1, 0.1)), (0.0, 2.5, 0.05), "floor")}
    program = program_of(Stage("yard", things), "The box turns around.")
    assert [type(action) for action in program.event.actions] == [SetAngularVelocity]
    rollout = simulate(program)
    first, last = (matrix_of(rollout.rotations[row, 0].tolist()) for row in (0, -1))
    turned = math.degrees(math.acos(np.clip(first[:, 0] @ last[:, 0], -1, 1)))
    assert turned > 150
    assert np.linalg.norm(rollout.positions[-1, 0] - rollout.positions[0, 0]) < 0.03


def test_what_slips_off_what_held_it_falls_straight_down():
    things = {"mug": (Cylinder(radius=0.04, height=0.1), (0.3, 3.0, 0.6), "air")}
    program = program_of(Stage("yard", things), "The mug slips and falls to the ground.")
    assert [type(action) for action in program.event.actions] == [FixObject]


def test_what_sinks_slowly_from_high_up_sinks_evenly_and_gets_there():
    things = {"board": (Box(size=(0.3, 0.2, 0.03)), (0.0, 3.0, 0.9), "air")}
    stage = Stage("yard", things)
    rollout = simulate(program_of(stage, "The board sinks slowly down to the ground."))
    assert -rollout.velocities[:, 0, 2].min() < 0.6
    # It has its weight back where it lands, and does not rise again.
    assert rollout.positions[-1, 0, 2] < 0.02


def test_on_top_of_a_slope_it_goes_the_way_that_is_said():
    ramp = Ramp(toe=(1.0, 2.5, 0.0), yaw=math.pi, run=0.8, rise=0.4, width=0.5, plateau=0.5)
    things = {"ball": (Sphere(radius=0.05), (-0.1, 2.5, 0.45), "ramp")}
    stage = Stage("yard", things, {"ramp": ramp})
    program = program_of(stage, "The ball rolls a little to the left and stops.")
    rollout = simulate(program)
    assert rollout.positions[:, 0, 0].min() < -0.11
    assert any(isinstance(action, ApplyForce) for action in program.event.actions)


def test_what_is_kicked_away_comes_down_where_it_is_seen():
    things = {"ball": (Sphere(radius=0.05), (0.0, 2.5, 0.05), "floor")}
    program = program_of(Stage("yard", things), "The ball is thrown to the right.")
    rollout = simulate(program)
    lands = np.flatnonzero(rollout.positions[:, 0, 2] > 0.07)[-1]
    sight = sight_of(Facts.of(program, rollout), "ball")
    assert sight is not None
    share = sight.share
    assert share[min(rollout.frame_of(int(lands)) + 1, len(share) - 1)] > 0.5


def test_what_slides_off_falls_beside_what_it_stood_on():
    table = Slab(position=(0.0, 3.0, 0.4), size=(0.6, 0.5, 0.05))
    things = {"box": (Box(size=(0.12, 0.12, 0.12)), (0.1, 3.0, 0.485), "table")}
    stage = Stage("room", things, {"table": table})
    rollout = simulate(program_of(stage, "The box slides off the table to the right."))
    path = rollout.positions[:, 0]
    landed = path[path[:, 2] < 0.12]
    # Thrown off by a blow it came down .38 m beyond the edge.
    assert 0.3 < landed[0, 0] < 0.6
