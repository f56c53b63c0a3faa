"""The demo event as its first program has it, reconstructed and simulated."""

from __future__ import annotations

from physagent_studio.agent.rules import RuleGenerator
from physagent_studio.assets import assets_dir
from physagent_studio.exchange import load_case
from physagent_studio.program import PhysicalProgram
from physagent_studio.program.scene.state import SceneState
from physagent_studio.reconstruction import reconstruct
from physagent_studio.records import Rollout, Scene
from physagent_studio.simulation import simulate


def demo_run() -> tuple[Scene, Rollout, PhysicalProgram]:
    """Scene, rollout and program of the demo's first event."""
    case = load_case(assets_dir() / "demo")
    found: list[Scene] = []

    def seen(state: SceneState) -> Scene:
        found.append(reconstruct(case, state, previous=found[-1] if found else None))
        return found[-1]

    program = RuleGenerator().first(case, seen)
    scene = seen(program.scene)
    return scene, simulate(program, scene.meshes), program
