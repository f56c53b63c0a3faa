"""Small programs before a camera, and the situation that a director finds after running them."""

from __future__ import annotations

from types import MappingProxyType
from typing import Any

from physagent_studio.agent.roles import Situation, Trial
from physagent_studio.agent.rules import RuleVerifier
from physagent_studio.contract import measure
from physagent_studio.program import PhysicalProgram
from physagent_studio.records import Memory, Rollout, RolloutEvidence, Scene
from physagent_studio.simulation import simulate
from tests.agent.rules.scenes import CAMERA, STAGES

BALL = {
    "name": "ball", "shape": {"kind": "sphere", "radius": 0.11}, "position": [-1.0, 4.0, 0.11],
    "support": "floor", "rolling": 0.005,
}  # fmt: skip


def push(speed: float, name: str = "ball", duration: int = 12, **vector: Any) -> dict[str, Any]:
    """Brought to a speed to the right."""
    force = {"magnitude": speed, "quantity": "target_speed", "direction": "right", **vector}
    return {
        "operator": "ApplyForce", "id": f"push_{name}", "name": name, "start_step": 4,
        "duration": duration, "force": force,
    }  # fmt: skip


def filmed(
    things: list[dict[str, Any]], actions: list[dict[str, Any]], *statements: dict[str, Any]
) -> PhysicalProgram:
    """Things on a floor, seen by the camera of the scenes."""
    return PhysicalProgram.model_validate(
        {
            "scene": {
                "camera": CAMERA.model_dump(),
                "objects": things,
                "supports": [{"name": "floor", "shape": {"kind": "floor"}}],
            },
            "event": {"actions": actions},
            "contract": {"statements": statements},
        }
    )


def rolling(speed: float, **fields: Any) -> PhysicalProgram:
    """A ball that is pushed to the right and has to move half a metre."""
    moves = {
        "id": "moves", "kind": "moves", "subject": "ball", "distance": 0.5, "direction": "right",
    }  # fmt: skip
    return filmed([BALL | fields], [push(speed)], moves)


def try_out(program: PhysicalProgram) -> Trial:
    """One candidate run."""
    run: Rollout = simulate(program, {})
    return Trial(run, measure(program, run))


def situation_of(program: PhysicalProgram, memory: Memory | None = None) -> Situation:
    """What a planner or a director is given after a run of the program."""
    trial, empty = try_out(program), MappingProxyType({})
    scene = Scene(program.scene, None, None, empty, empty, empty, empty, (), "filmed")
    evidence = RolloutEvidence(program, scene, trial.rollout, trial.checks)
    judged = RuleVerifier().judge(evidence, "")
    case = STAGES["field"].case("The ball rolls to the right.")
    return Situation(case, program, scene, trial.rollout, judged, memory or Memory(), try_out)


def failing(program: PhysicalProgram) -> list[str]:
    """Ids of what fails."""
    return [check.id for check in try_out(program).checks if check.demanded and not check.ok]
