"""What a draft makes, and what an edit under the pointer would make: run at once, kept at hand."""

from collections.abc import Mapping
from dataclasses import replace

from physagent_studio.errors import SimulationError
from physagent_studio.program import PhysicalProgram
from physagent_studio.records import Check, Mesh, Rollout, Round, Scene
from physagent_studio.session import Session
from physagent_studio.workbench.engine import Engine
from physagent_studio.workbench.snapshot import Attempt

OnView = tuple[Scene | None, Rollout | None, tuple[Check, ...]]
"""Scene, rollout and checks of a program, as far as there are any."""


class Trial:
    """The runs of a session that are no rounds: the last draft and the last attempt."""

    def __init__(self, session: Session, engine: Engine) -> None:
        self._session = session
        self._engine = engine
        self._draft: tuple[str, OnView] | None = None
        self._tried: tuple[str, OnView] | None = None
        self._outlines: tuple[Scene, Mapping[str, tuple[Mesh, ...]]] | None = None

    def run(self, draft: PhysicalProgram, head: Round | None) -> OnView:
        """What a draft makes; run where it was not yet. head: the round that it was made from."""
        if self._draft is None or self._draft[0] != draft.hash:
            scene = self._engine.reconstruct(draft.scene, self._scene_before(head))
            if self._tried and self._tried[0] == draft.hash and self._tried[1][0] is scene:
                self._draft = self._tried
            else:
                complete = draft.model_copy(update={"scene": scene.state})
                rollout = self._engine.again(complete, scene, self._rollout_before(head))
                checks = self._engine.measure(complete, rollout, scene)
                self._draft = (draft.hash, (scene, rollout, checks))
        return self._draft[1]

    def attempt(self, now: PhysicalProgram, edited: PhysicalProgram, on_view: OnView) -> Attempt:
        """What edits under the pointer make of the program on view, from their first step on."""
        scene, before, _ = on_view
        if scene is None:
            return Attempt(edited)
        built = self._built(edited, now, scene)
        complete = edited.model_copy(update={"scene": built.state})
        rollout = self._engine.again(complete, built, before)
        checks = self._engine.measure(complete, rollout, built)
        self._tried = (edited.hash, (built, rollout, checks))
        return Attempt(complete, rollout, checks)

    def outlines(
        self, program: PhysicalProgram, scene: Scene
    ) -> Mapping[str, tuple[Mesh, ...]] | None:
        """What the engine collides in a scene; None where something is still open."""
        if self._outlines is None or self._outlines[0] is not scene:
            try:
                complete = program.model_copy(update={"scene": scene.state})
                self._outlines = (scene, self._engine.outlines(complete, scene))
            except SimulationError:
                return None
        return self._outlines[1]

    def _scene_before(self, head: Round | None) -> Scene | None:
        if self._draft is not None:
            return self._draft[1][0]
        return self._session.scene(head.scene) if head and head.scene else None

    def _rollout_before(self, head: Round | None) -> Rollout | None:
        if self._draft is not None:
            return self._draft[1][1]
        return self._session.rollout(head.rollout) if head and head.rollout else None

    def _built(self, edited: PhysicalProgram, now: PhysicalProgram, scene: Scene) -> Scene:
        """The scene of an edited program; what only stands elsewhere keeps its meshes."""
        if edited.scene in (scene.state, now.scene):
            return scene
        old = {item.name: item.shape for item in scene.state.objects}
        whole = all(
            one.position is not None and one.shape is not None and old.get(one.name) == one.shape
            for one in edited.scene.objects
        ) and all(one.shape is not None for one in edited.scene.supports)
        if whole:
            return replace(scene, state=edited.scene)
        return self._engine.build(edited.scene, scene)
