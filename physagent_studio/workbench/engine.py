"""Binds the rooms to the loop: reconstruction, simulation, measurement, rendering, files."""

import hashlib
import json
import os
from collections.abc import Callable, Collection, Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any, Literal, TypeVar

from physagent_studio.agent.by_hand import without_schedule
from physagent_studio.agent.crew import Bench, Crew
from physagent_studio.agent.previews import try_on
from physagent_studio.agent.roles import Trial
from physagent_studio.agent.rules import Easing, RuleGenerator, RulePlanner, RuleVerifier
from physagent_studio.agent.vlm import (
    Answers,
    CallRecord,
    crew_from_environment,
    load_settings,
)
from physagent_studio.agent.vlm import Limits as Spend
from physagent_studio.contract import measure
from physagent_studio.contract.view import Drawn
from physagent_studio.errors import Cancelled, StudioError
from physagent_studio.jobs import Executor, Inline, JobFailed, Limits, Processes
from physagent_studio.program import PhysicalProgram, SceneState
from physagent_studio.program.scene.state import Meshed
from physagent_studio.reconstruction.cache import same_sight
from physagent_studio.reconstruction.learned.at_hand import Learned, learned_here
from physagent_studio.records import Case, Check, Image, Mesh, Rollout, Scene
from physagent_studio.records.clip_look import AS_DRAWN, ClipLook
from physagent_studio.records.loop_state import RoleName
from physagent_studio.session import Session
from physagent_studio.workbench import tasks
from physagent_studio.workbench.ahead import Ahead, Lane, Lanes

Result = TypeVar("Result")
AgentName = Literal["rules", "vlm"]
"""The embedded agent, or a language model behind an OpenAI-compatible server."""


def limits_of(agent: AgentName) -> Spend | None:
    """What stops a model's calls; None where no model plays, or its settings are wrong."""
    if agent == "rules":
        return None
    try:
        return load_settings(os.environ).limits
    except StudioError:
        return None


@dataclass
class Control:
    """How a long piece of work hears of cancellation and tells of progress."""

    cancelled: Callable[[], bool] = lambda: False
    progress: Callable[[str, float | None], None] = lambda what, share: None

    def check(self) -> None:
        """Raises `Cancelled` where the person has cancelled."""
        if self.cancelled():
            raise Cancelled("cancelled")


@dataclass
class Engine:
    """The rooms at work for one session. `evidence`: whether rounds render their frames.

    executor: who carries out the heavy steps; with processes they have the same bits, their
    crash or hang fails the step alone, and they end within a second where a person cancels.
    spare: the one of what a search may ask for next, where that is not done there as well.
    answers: what a model has answered before, by question, where a session is replayed.
    """

    session: Session
    case: Case
    control: Control = field(default_factory=Control)
    evidence: bool = True
    agent: AgentName = "rules"
    learned: Learned = field(default_factory=learned_here)
    members: Crew | None = None
    answers: Mapping[str, dict[str, Any]] = field(default_factory=dict)
    executor: Executor = field(default_factory=Inline)
    spare: Executor | None = None
    _scenes: dict[str, Scene] = field(default_factory=dict)
    _lanes: Lanes | None = None
    _likened: tuple[Scene, Mapping[str, Drawn]] | None = None

    def crew(self, by_hand: Collection[RoleName] = ()) -> Crew:
        """Who plays the three roles; a language model's calls are kept in the session's log.

        by_hand: the roles that a person plays. What a person judges from is measured by the
        embedded verifier: a model is not asked for a verdict that nobody waits for.
        """
        embedded = Crew(RuleGenerator(), RuleVerifier(), RulePlanner(), Easing())
        crew = self.members or (embedded if self.agent == "rules" else self._model(embedded))
        return replace(crew, verifier=embedded.verifier) if "verifier" in by_hand else crew

    def laid_out(self) -> PhysicalProgram:
        """What a person who writes the first program begins with: all but a schedule."""
        first = RuleGenerator().first(self.case, lambda state: self.reconstruct(state, None))
        return without_schedule(first)

    def _model(self, embedded: Crew) -> Crew:
        earlier = [
            CallRecord.model_validate(payload)
            for _, kind, _, payload in self.session.log()
            if kind == "model call"
        ]

        def record(call: CallRecord) -> None:
            self.session.record("model call", call.model, call.model_dump(mode="json"))

        def arrived(key: str) -> dict[str, Any] | None:
            return self.answers.get(key) or self.session.answer(key)

        return crew_from_environment(
            self.control.cancelled,
            record,
            default=embedded,
            earlier=earlier,
            answers=Answers(arrived, self.session.keep_answer),
        )

    def bench(self) -> Bench:
        """What the loop works with."""
        session = self.session
        return Bench(
            case=self.case,
            reconstruct=self.reconstruct,
            simulate=self.simulate,
            measure=self.measure,
            view=self.view,
            evidence=self.sample,
            put_scene=session.put_scene,
            get_scene=session.scene,
            put_rollout=session.put_rollout,
            get_rollout=session.rollout,
            put_frames=session.put_frames,
            ahead=self.ahead,
        )

    def ahead(self, scene: Scene) -> Ahead | None:
        """The trials of a scene on all cores; None where there is one."""
        spare = self.spare or self.executor
        width = spare.width + 1 if self.spare else spare.width
        if width == 1:
            return None
        if self._lanes is None:
            lanes = [self._lane(spare if number else self.executor) for number in range(width)]
            self._lanes = Lanes(lanes, self.control.check)
        # Known before several lanes ask for it at once.
        self.likeness(scene)
        return Ahead(self._lanes, scene)

    def _lane(self, executor: Executor) -> Lane:
        """An engine of its own."""

        def run(program: PhysicalProgram, scene: Scene, dropped: Callable[[], bool]) -> Trial:
            control = self.control
            either = replace(control, cancelled=lambda: dropped() or control.cancelled())
            own = replace(self, executor=executor, control=either)
            return try_on(scene, own.reconstruct, own.trial, program)

        def open_it() -> None:
            if isinstance(executor, Processes):
                executor.another(*tasks.MODULES)

        return Lane(run, open_it)

    def trial(self, program: PhysicalProgram, scene: Scene) -> Trial:
        """One run of the physics engine and every check of it."""
        values = (program, scene.meshes, self.likeness(scene))
        return Trial(*self.carry_out("the simulation", tasks.SIMULATION, tasks.ran, *values))

    def reconstruct(self, state: SceneState, previous: Scene | None) -> Scene:
        """The scene of that state, from the cache where nothing changed."""
        key = _hash(state)
        if previous is not None and previous.state == state:
            return previous
        if key not in self._scenes:
            scene = self.build(state, previous)
            # A completed state reconstructs to itself, so it is known by both keys.
            self._scenes[key] = self._scenes[_hash(scene.state)] = scene
        return self._scenes[key]

    def build(self, state: SceneState, previous: Scene | None) -> Scene:
        """The same without the cache, for what is tried while a hand still moves."""
        # Masks and plate of any earlier scene of the picture serve as long as they fit.
        near = previous or next(reversed(self._scenes.values()), None)
        values = (self.case, state, near, self._assets(state), self.learned)
        if near is not None and same_sight(near.state, state):
            # Nothing is looked at again: what it looked at stays, and is known again as the same.
            return tasks.reconstructed(*values)
        return self.carry_out(
            "the reconstruction", tasks.RECONSTRUCTION, tasks.reconstructed, *values
        )

    def carry_out(
        self, what: str, limits: Limits, task: Callable[..., Result], *values: Any
    ) -> Result:
        """A heavy step's result. Raises what it raises, or a sentence on how it has ended."""
        self.control.check()
        try:
            return self.executor.submit(
                task,
                *values,
                limits=limits,
                cancelled=self.control.cancelled,
                tell=self.control.progress,
            )
        except JobFailed as error:
            raise StudioError(
                f"{what} was ended: {error}. Everything before it is kept; change something, or"
                " try again"
            ) from error

    def _assets(self, state: SceneState) -> dict[str, Mesh]:
        """The stored meshes that a state names; those of other origin are the backend's."""
        named = {item.shape.asset for item in state.objects if isinstance(item.shape, Meshed)}
        found = {asset: self.session.mesh(asset) for asset in named}
        return {asset: mesh for asset, mesh in found.items() if mesh is not None}

    def simulate(self, program: PhysicalProgram, scene: Scene) -> Rollout:
        """One run of the physics engine."""
        return self.again(program, scene, None)

    def again(self, program: PhysicalProgram, scene: Scene, before: Rollout | None) -> Rollout:
        """One run that takes over what an edit cannot have changed; the same bits as `simulate`."""
        values = (program, scene.meshes, before)
        return self.carry_out("the simulation", tasks.SIMULATION, tasks.simulated, *values)

    def outlines(self, program: PhysicalProgram, scene: Scene) -> dict[str, tuple[Mesh, ...]]:
        """What the physics engine collides, by name."""
        values = (program, scene.meshes)
        return self.carry_out("the simulation", tasks.SIMULATION, tasks.outlined, *values)

    def view(self, scene: Scene) -> Image | None:
        """The reconstruction seen by its own camera, to be held against the photo."""
        if not self.evidence or scene.state.camera is None or not scene.state.objects:
            return None
        return self._drawing(tasks.viewed, scene)

    def measure(
        self, program: PhysicalProgram, rollout: Rollout, scene: Scene
    ) -> tuple[Check, ...]:
        """Every check of a run: the contract, the physics, the view."""
        return measure(program, rollout, self.likeness(scene))

    def likeness(self, scene: Scene) -> Mapping[str, Drawn]:
        """How like the photograph each thing of a scene is drawn, however heavy or rough it is."""
        if self._likened is None or not _drawn_alike(self._likened[0], scene):
            self._likened = scene, self._drawing(tasks.likened, scene)
        return self._likened[1]

    def sample(self, scene: Scene, rollout: Rollout) -> tuple[Image, ...]:
        """Every third frame of a rollout, rendered."""
        if not self.evidence or scene.state.camera is None:
            return ()
        return self._drawing(tasks.sampled, scene, rollout)

    def film(
        self,
        path: Path,
        scene: Scene,
        rollout: Rollout,
        program: PhysicalProgram,
        look: ClipLook = AS_DRAWN,
    ) -> None:
        """A rollout as a video; where it is ended, files may be left beside the path."""
        limits = tasks.RENDERING if look.samples is None else tasks.TRACING
        values = (path, scene, rollout, program, look)
        self.carry_out("the rendering", limits, tasks.filmed, *values)

    def export(self, path: Path, scene: Scene, rollout: Rollout, program: PhysicalProgram) -> None:
        """A rollout as a motion prior."""
        self._drawing(tasks.exported, path, scene, rollout, program)

    def _drawing(self, task: Callable[..., Result], *values: Any) -> Result:
        return self.carry_out("the rendering", tasks.RENDERING, task, *values)


def _drawn_alike(one: Scene, other: Scene) -> bool:
    """Whether two scenes show the same things in the same places: the same pixels when drawn."""
    if one.hash == other.hash:
        return True
    kept = one.masks is other.masks and one.meshes is other.meshes
    bodies = ([item.body for item in scene.state.objects] for scene in (one, other))
    return kept and same_sight(one.state, other.state) and next(bodies) == next(bodies)


def _hash(state: SceneState) -> str:
    text = json.dumps(state.model_dump(mode="json"), sort_keys=True)
    return hashlib.sha256(text.encode()).hexdigest()
