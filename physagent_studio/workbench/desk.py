"""The desk: one open session and what every command does to it. Synchronous, one thread."""

import time
from collections.abc import Mapping
from dataclasses import asdict
from functools import singledispatchmethod
from typing import Any

from physagent_studio.agent import loop
from physagent_studio.agent.by_hand import turn_of
from physagent_studio.agent.rules.planner import goal_search as wishing
from physagent_studio.agent.rules.planner.goal_search import proposal_for
from physagent_studio.errors import InputError, Problem, ProgramError
from physagent_studio.jobs import Executor, Inline
from physagent_studio.program import Edit, PhysicalProgram, apply, value_at
from physagent_studio.program.timing import FASTEST, PACE, SLOWEST, retimed
from physagent_studio.records import Decision, LoopState, Mesh, Override, Rollout, Round, Scene
from physagent_studio.session import Session
from physagent_studio.session.session import now
from physagent_studio.workbench import commands, deciding, mesh_edits, photo_edits
from physagent_studio.workbench.doing import doing_in
from physagent_studio.workbench.engine import AgentName, Control, Engine, limits_of
from physagent_studio.workbench.probing import Probed, probed
from physagent_studio.workbench.program_texts import read_program
from physagent_studio.workbench.snapshot import Attempt, Meter
from physagent_studio.workbench.trial import OnView, Trial


class Desk:
    """Carries out commands on a session; after each the session is on the disk."""

    def __init__(
        self,
        session: Session,
        control: Control,
        *,
        evidence: bool = True,
        agent: AgentName = "rules",
        answers: Mapping[str, dict[str, Any]] | None = None,
        executor: Executor | None = None,
        spare: Executor | None = None,
    ) -> None:
        self.session = session
        self.control = control
        self.case = session.case
        self.engine = Engine(
            session,
            self.case,
            control,
            evidence,
            agent,
            answers=answers or {},
            executor=executor or Inline(),
            spare=spare,
        )
        self.state: LoopState = session.load()
        self.meter = Meter(session, limits_of(agent))
        self.shown: str | None = None
        self.problems: tuple[Problem, ...] = ()
        self.trial = Trial(session, self.engine)
        self._probed = Probed()

    # --- what is on view ---------------------------------------------------------------------

    @property
    def round(self) -> Round | None:
        """The round on view."""
        wanted = self.shown or self.state.head
        return next((item for item in self.state.rounds if item.id == wanted), None)

    @property
    def program(self) -> PhysicalProgram:
        """The draft, else the program of the round on view."""
        if self.shown is None and self.state.draft is not None:
            return self.state.draft
        return self.round.program if self.round else PhysicalProgram()

    def on_view(self) -> OnView:
        """Scene, rollout and checks of what is on view; a draft is run where it was not yet."""
        if self.shown is None and self.state.draft is not None:
            return self.trial.run(self.state.draft, self.state.current)
        item = self.round
        if item is None:
            return None, None, ()
        scene = self.session.scene(item.scene) if item.scene else None
        rollout = self.session.rollout(item.rollout) if item.rollout else None
        return scene, rollout, item.assessment.checks if item.assessment else ()

    def preview(self) -> Rollout | None:
        """The rollout of the head's proposal, tried out."""
        item = self.state.current
        if self.shown not in (None, self.state.head) or item is None or item.preview is None:
            return None
        return self.session.rollout(item.preview.rollout) if item.preview.rollout else None

    def outlines(self, scene: Scene) -> Mapping[str, tuple[Mesh, ...]] | None:
        """What the engine collides in a scene; None where something is still open."""
        return self.trial.outlines(self.program, scene)

    @property
    def probed(self) -> Probed | None:
        """What was found by looking into the program on view."""
        return self._probed if self._probed.program == self.program.hash else None

    def attempt(self, edits: tuple[Edit, ...]) -> Attempt:
        """What edits under the pointer would make: run from their first step, nothing stored."""
        self._require_head("edit")
        edited = apply(self.program, edits)
        return self.trial.attempt(self.program, edited, self.on_view())

    # --- the loop ----------------------------------------------------------------------------

    @property
    def unprepared(self) -> bool:
        """Whether there is a sentence of which nothing has been made yet."""
        begun = self.state.rounds or self.state.draft is not None or self.session.read_only
        return not begun and bool(self.case.prompt.strip())

    def advance(self, *, policy: str | None = None, until: str = "done") -> None:
        """Goes on until a person has to act or all is done; every phase is saved."""
        began = time.monotonic()
        try:
            self._go_on(policy, until)
        finally:
            self.meter.add_work(time.monotonic() - began)

    def _go_on(self, policy: str | None, until: str) -> None:
        crew, bench = self.engine.crew(self.state.by_hand), self.engine.bench()
        kept = self.state.policy
        while self.state.phase not in ("done", until):
            self.control.check()
            if doing := doing_in(self.state):
                self.control.progress(doing, None)
            working = self.state.model_copy(update={"policy": policy or kept})
            after = loop.advance(working, crew, bench)
            if after is working:
                self._lay_out()
                break
            self._log_decision(working, after)
            self._save(after.model_copy(update={"policy": kept}))

    def _lay_out(self) -> None:
        """A draft to begin with, where a person is to write the first program."""
        if turn_of(self.state) == "generator":
            self._save(self.state.model_copy(update={"draft": self.engine.laid_out()}))

    def _log_decision(self, before: LoopState, after: LoopState) -> None:
        old, new = before.current, None
        if old is not None:
            new = next(item for item in after.rounds if item.id == old.id)
        if new is not None and old is not None and new.decision not in (None, old.decision):
            assert new.decision is not None
            payload = {"round": new.id, **new.decision.model_dump(mode="json")}
            self.session.record("decision", new.decision.author, payload)

    def _save(self, state: LoopState, checkpoint: str | None = None) -> None:
        self.session.save(state, checkpoint=checkpoint)
        self.state = state

    # --- commands ----------------------------------------------------------------------------

    @singledispatchmethod
    def handle(self, command: Any) -> None:
        """Carries out one command or raises a `StudioError` and changes nothing."""
        raise InputError(f"the command {type(command).__name__} is not known here")

    @handle.register
    def _(self, command: commands.Advance) -> None:
        self.advance(policy=command.policy, until=command.until)

    @handle.register
    def _(self, command: commands.Step) -> None:
        self._begin("step")
        self.advance()

    @handle.register
    def _(self, command: commands.Run) -> None:
        self._begin("run")
        self.advance(policy="auto")

    def _begin(self, label: str) -> None:
        """Turns a draft into the next round; a new checkpoint for undo either way."""
        self.shown = None
        state = self.state
        if state.draft is not None and state.current is not None:
            state = deciding.with_draft_as_round(state)
        elif state.phase == "done" and state.outcome == "realised":
            return
        elif state.phase == "done":
            state = deciding.taken_up_again(state)
        self._save(state, label)

    @handle.register
    def _(self, command: commands.Decide) -> None:
        item = self.state.current
        if item is None or item.proposal is None or item.proposal.id != command.proposal_id:
            return  # A second click on a proposal that is already decided has no effect.
        before, after = self.state, deciding.decided(self.state, item, command)
        self._save(after, command.kind)
        self._log_decision(before, after)
        self.advance()

    @handle.register
    def _(self, command: commands.ApplyEdits) -> None:
        self._require_head("edit")
        draft = apply(self.program, command.edits)
        self._draft(draft, command.reason or "edit")

    @handle.register
    def _(self, command: commands.Retime) -> None:
        self._require_head("change its pace")
        if not SLOWEST <= command.factor <= FASTEST:
            raise InputError(
                f"a time factor of {command.factor:g} is not allowed ({SLOWEST:g} … {FASTEST:g})"
            )
        draft = apply(self.program, retimed(self.program, command.factor))
        self._draft(draft, "pace", pins=PACE)

    @handle.register
    def _(self, command: commands.AddMesh) -> None:
        self._require_head("add something")
        name = mesh_edits.name_for(self.program, command.name)
        asset = self.session.put_mesh(command.body)
        edits = mesh_edits.adding(name, command.body, asset, command.foot, command.support)
        self._draft(apply(self.program, edits), f"added {name}")

    @handle.register
    def _(self, command: commands.Wish) -> None:
        self._require_head("say where something should be")
        item = self.state.current
        if item is None or item.rollout is None or item.scene is None:
            raise InputError("nothing has run yet; run it first, then say where things should be")
        if self.state.draft is not None:
            raise InputError("run or drop your edits first, then say where things should be")
        rollout, scene = self.session.rollout(item.rollout), self.session.scene(item.scene)
        if command.name not in rollout.objects:
            raise InputError(f"there is no object '{command.name}' in this run")
        self.control.progress(f"searching for what brings {command.name} there", None)
        proposal = proposal_for(
            item.program,
            rollout,
            wishing.Wish(command.name, command.position, command.step),
            lambda program: self.engine.again(program, scene, rollout),
            self.state.pinned,
        )
        words = f"shown where {command.name} should be at step {command.step}"
        turned_down = Decision(kind="reject", author="person", at=now(), reason=words)
        state = loop.offer(self.state, proposal, self.engine.bench(), turned_down)
        self._save(state, "wish")
        self.session.record("wish", "person", {"round": item.id, **asdict(command)})

    @handle.register
    def _(self, command: commands.ApplyText) -> None:
        self._require_head("edit")
        self._draft(self._parsed(command.text), "program text")

    @handle.register
    def _(self, command: commands.ValidateText) -> None:
        self._parsed(command.text)

    def _parsed(self, text: str) -> PhysicalProgram:
        try:
            program = read_program(text)
        except ProgramError as error:
            self.problems = error.problems
            raise
        self.problems = ()
        return program

    def _draft(self, draft: PhysicalProgram, label: str, pins: tuple[str, ...] = ()) -> None:
        """Takes over a draft, and what is pinned with it, as one step to undo."""
        pinned = tuple(dict.fromkeys((*self.state.pinned, *pins)))
        changed: dict[str, Any] = {} if pinned == self.state.pinned else {"pinned": pinned}
        if draft != self.program:
            changed["draft"] = self._completed(draft)
            self.problems = ()
        if changed:
            self._save(self.state.model_copy(update=changed), label)

    def _completed(self, draft: PhysicalProgram) -> PhysicalProgram:
        """The draft after its first run, with what an edit had opened as the photo shows it."""
        scene, _, _ = self.trial.run(draft, self.state.current)
        if scene is None or self.case.image is None or draft.scene.is_closed:
            return draft
        done = draft.model_copy(update={"scene": photo_edits.stated(scene.state)})
        self.trial.run(done, self.state.current)
        return done

    def _require_head(self, what: str) -> None:
        if self.shown not in (None, self.state.head):
            raise InputError(f"round {self.shown} is shown read-only; fork from it to {what}")

    @handle.register
    def _(self, command: commands.DiscardDraft) -> None:
        if self.state.draft is not None:
            self._save(self.state.model_copy(update={"draft": None}), "discard draft")
        self.problems = ()

    @handle.register
    def _(self, command: commands.ShowRound) -> None:
        known = {item.id for item in self.state.rounds}
        if command.id is not None and command.id not in known:
            raise InputError(f"there is no round '{command.id}'; rounds: {', '.join(known)}")
        self.shown = None if command.id == self.state.head else command.id

    @handle.register
    def _(self, command: commands.ForkFrom) -> None:
        after = deciding.forked(self.state, command.id)
        self.shown = None
        self._save(after, f"fork from {command.id}")

    @handle.register
    def _(self, command: commands.OverruleVerdict) -> None:
        override = Override(passed=command.passed, author="person", at=now(), words=command.words)
        awaited = turn_of(self.state) == "verifier"
        state = deciding.overruled(self.state, override)
        self._save(state, "verdict" if awaited else "overrule verdict")
        self.session.record("override", "person", {"round": state.head, **override.model_dump()})
        if awaited:
            self.advance()

    @handle.register
    def _(self, command: commands.SetPolicy) -> None:
        self._save(self.state.model_copy(update={"policy": command.policy}), "policy")

    @handle.register
    def _(self, command: commands.TakeRole) -> None:
        self._save(deciding.with_role(self.state, command.role, on=command.on), "role")

    @handle.register
    def _(self, command: commands.SetBudget) -> None:
        if not 1 <= command.rounds <= 100:
            raise InputError(f"a budget of {command.rounds} rounds is not allowed (1 … 100)")
        self._save(self.state.model_copy(update={"budget": command.rounds}), "budget")

    @handle.register
    def _(self, command: commands.Pin) -> None:
        value_at(self.program, command.path)
        pinned = tuple(dict.fromkeys((*self.state.pinned, command.path)))
        self._save(self.state.model_copy(update={"pinned": pinned}), "pin")

    @handle.register
    def _(self, command: commands.Unpin) -> None:
        pinned = tuple(path for path in self.state.pinned if path != command.path)
        self._save(self.state.model_copy(update={"pinned": pinned}), "unpin")

    @handle.register
    def _(self, command: commands.Undo) -> None:
        self._move(self.session.undo())

    @handle.register
    def _(self, command: commands.Redo) -> None:
        self._move(self.session.redo())

    def _move(self, state: LoopState | None) -> None:
        if state is not None:
            self.state, self.shown, self.problems = state, None, ()

    @handle.register
    def _(self, command: commands.Probe) -> None:
        self._probed = probed(self, command.what, self._probed)

    @handle.register
    def _(self, command: commands.Rename) -> None:
        title = command.title.strip()
        if not title or len(title) > 200:
            raise InputError("a title has 1 to 200 characters")
        self.session.rename(title)
