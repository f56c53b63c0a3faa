"""Who plays the three roles, and what they and the loop work with."""

from collections.abc import Callable
from dataclasses import dataclass

from physagent_studio.agent.roles import Ahead, Director, Generator, Planner, Verifier
from physagent_studio.program import PhysicalProgram, SceneState
from physagent_studio.records import Case, Check, Image, Rollout, Scene


@dataclass(frozen=True, eq=False, slots=True)
class Crew:
    """Who plays the three roles, and who eases what holds; None leaves it as it is."""

    generator: Generator
    verifier: Verifier
    planner: Planner
    director: Director | None = None


@dataclass(frozen=True, eq=False, slots=True)
class Bench:
    """What the loop works with; the workbench supplies it.

    put/get pairs keep arrays out of the state: they return and take keys. evidence renders
    the sampled frames of a rollout, or returns () where nothing shall be rendered. ahead
    gives the trials of a scene on several cores, None where there is one.
    """

    case: Case
    reconstruct: Callable[[SceneState, Scene | None], Scene]
    simulate: Callable[[PhysicalProgram, Scene], Rollout]
    measure: Callable[[PhysicalProgram, Rollout, Scene], tuple[Check, ...]]
    view: Callable[[Scene], Image | None]
    evidence: Callable[[Scene, Rollout], tuple[Image, ...]]
    put_scene: Callable[[Scene], str]
    get_scene: Callable[[str], Scene]
    put_rollout: Callable[[Rollout], str]
    get_rollout: Callable[[str], Rollout]
    put_frames: Callable[[tuple[Image, ...]], str]
    ahead: Callable[[Scene], Ahead | None] = lambda scene: None
