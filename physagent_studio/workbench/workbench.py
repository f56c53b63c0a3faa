"""The workbench: a queue of commands, one worker thread that owns the document, snapshots out."""

import itertools
import queue
import threading
from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import partial

from physagent_studio.errors import Cancelled, InputError, ProgramError, StudioError
from physagent_studio.exchange import load_case
from physagent_studio.jobs import Executor, Inline
from physagent_studio.language.sought import Sought
from physagent_studio.program import Edit
from physagent_studio.reconstruction.grounding.proposals import Proposed
from physagent_studio.records import Case, Image, LoopState
from physagent_studio.session import Session, Store
from physagent_studio.session.session import MESH_SUFFIX
from physagent_studio.session.standing import interrupted
from physagent_studio.workbench import commands, tasks, versions
from physagent_studio.workbench.boundary import guarded
from physagent_studio.workbench.desk import Desk
from physagent_studio.workbench.doing import RUNNING
from physagent_studio.workbench.engine import AgentName, Control
from physagent_studio.workbench.journal import CHANGING, carry_out
from physagent_studio.workbench.naming import case_in_words, with_proposals
from physagent_studio.workbench.rendering import render_rollout, write_file
from physagent_studio.workbench.snapshot import Attempt, Notice, Snapshot

Subscriber = Callable[[Snapshot], None]
OVERTAKEN = Attempt()
"""Stands for an attempt that something newer has ended: nothing is shown of it."""
INTERRUPTED = (
    "What was going on when this was closed ({what}: {phase}) was cut short. Everything before it"
    " is kept; Step does it again."
)


class Workbench:
    """Owns the open session. `post` returns at once; subscribers are called by the worker.

    Only the worker thread touches the desk, so a command is atomic and the order of posting
    is the order of effect.
    """

    def __init__(
        self,
        store: Store,
        *,
        evidence: bool = True,
        agent: AgentName = "rules",
        executor: Executor | None = None,
    ) -> None:
        """executor: who carries out the heavy steps; without one this process does."""
        self.store = store
        self._executor = executor or Inline()
        self._evidence = evidence
        self._agent: AgentName = agent
        self._queue: queue.Queue[Callable[[], None] | None] = queue.Queue()
        self.versions = versions.Versions()
        self.backlog = versions.Backlog()
        self._cancel = threading.Event()
        self._lock = threading.Lock()
        self._subscribers: list[Subscriber] = []
        self._snapshot = Snapshot(revision=0)
        self._numbers = itertools.count(1)
        self._desk: Desk | None = None
        self._with_collisions = False
        self._wanted: list[tuple[Edit, ...] | None] = []
        self._trying: tuple[Edit, ...] | None = None
        self._overtaken = threading.Event()
        self._control = Control(self._stopped, self._progress)
        self._worker = threading.Thread(target=self._work, name="workbench", daemon=True)
        self._worker.start()

    # --- for any thread ----------------------------------------------------------------------

    def post(self, command: commands.Command) -> None:
        """Queues a command; what is being tried gives way to it, unless it is just that.

        Inside `sent_by` it carries who asks and the version that was seen: where somebody else
        has changed the document since, it is refused with what changed.
        """
        with self._lock:
            self._wanted.clear()
            same = isinstance(command, commands.ApplyEdits) and command.edits == self._trying
            if not same:
                self._overtaken.set()
        sender = versions.present_sender()
        self.backlog.add(sender)
        self._queue.put(lambda: self._carry_out(command, sender))

    def try_out(self, edits: tuple[Edit, ...] | None) -> None:
        """Runs edits that are still under the pointer, and shows it as `Snapshot.attempt`.

        Of those that wait only the newest is run; None ends the trying. Nothing is stored.
        """
        with self._lock:
            waiting = bool(self._wanted)
            self._wanted[:] = [edits]
        if not waiting:
            self._queue.put(self._try)

    def cancel(self) -> None:
        """Stops what is running now; what was acknowledged stays."""
        self._cancel.set()

    def snapshot(self) -> Snapshot:
        """The latest snapshot."""
        return self._snapshot

    def subscribe(self, callback: Subscriber) -> Callable[[], None]:
        """Calls back after every change, first with the present snapshot; returns the undoing."""
        with self._lock:
            self._subscribers.append(callback)
        callback(self._snapshot)

        def unsubscribe() -> None:
            with self._lock:
                if callback in self._subscribers:
                    self._subscribers.remove(callback)

        return unsubscribe

    def wait(self, timeout: float = 60.0) -> bool:
        """Whether everything posted so far was carried out within `timeout` seconds."""
        done = threading.Event()
        self._queue.put(done.set)
        return done.wait(timeout)

    def close(self) -> None:
        """Cancels what runs, closes the session and ends the worker."""
        self._cancel.set()
        self._queue.put(None)
        self._worker.join(timeout=10)

    # --- the worker --------------------------------------------------------------------------

    def _work(self) -> None:
        while (act := self._queue.get()) is not None:
            self._cancel.clear()
            act()
        if self._desk is not None:
            self._desk.session.close()

    def _stopped(self) -> bool:
        """Whether the work at hand shall end: cancelled, or a try that a command has overtaken."""
        return self._cancel.is_set() or (self._trying is not None and self._overtaken.is_set())

    def _try(self) -> None:
        with self._lock:
            if not self._wanted:
                return
            self._trying = edits = self._wanted.pop()
            self._overtaken.clear()
        desk = self._desk

        def attempt() -> Attempt | None:
            try:
                return None if edits is None or desk is None else desk.attempt(edits)
            except Cancelled:
                return OVERTAKEN

        try:
            found = guarded(attempt, lambda text: Attempt(problem=text), "an attempt")
        finally:
            with self._lock:
                self._trying = None
        if found is OVERTAKEN:
            return
        self._publish(replace(self._snapshot, attempt=found, busy=None, progress=None))

    def _carry_out(self, command: commands.Command, sender: versions.Sender) -> None:
        """Any failure becomes a notice instead of a dead worker."""
        name = f"command {type(command).__name__}"
        tried = partial(self._tried, command, sender)
        guarded(tried, lambda text: self._notice("error", text), name)
        self.backlog.add(sender, -1)
        self._publish_desk()

    def _tried(self, command: commands.Command, sender: versions.Sender) -> None:
        """A command, with what a failure of it means where that is no error to be told."""
        try:
            if isinstance(command, CHANGING):
                self.versions.check(sender)
            before = self._document()
            try:
                self._dispatch(command, sender)
            finally:
                if self._document() != before:
                    self.versions.changed(sender, command)
        except versions.Stale as error:
            if sender.refused is None:
                raise
            sender.refused(str(error))
        except Cancelled:
            self._notice("info", "Cancelled. Everything up to here is kept.")
        except ProgramError as error:
            # Problems of a text are shown at their lines; everything else needs a notice.
            if self._desk is None or self._desk.problems != error.problems:
                raise

    def _document(self) -> tuple[object, ...]:
        """What commands change, to be compared by identity."""
        desk = self._desk
        return (None,) if desk is None else (desk.session.id, id(desk.state), desk.shown)

    def _dispatch(self, command: commands.Command, sender: versions.Sender) -> None:
        if isinstance(command, commands.OpenCase):
            case = load_case(command.folder, command.event)
            self._open_case(with_proposals(case, ask=False, seek=self._seek))
        elif isinstance(command, commands.OpenImage):
            self._progress("looking for what the sentence names", None)
            marks = dict(command.objects)
            case = case_in_words(command.path, command.prompt, marks, ask=False, seek=self._seek)
            self._open_case(case, command.title)
        elif isinstance(command, commands.OpenProgram):
            self._open_program(command)
        elif isinstance(command, commands.OpenSession):
            self._reopen(command.id)
        elif isinstance(command, commands.DismissNotice):
            kept = tuple(item for item in self._snapshot.notices if item.id != command.id)
            self._publish(replace(self._snapshot, notices=kept))
        elif isinstance(command, commands.ShowCollisions):
            self._with_collisions = command.on
        elif self._desk is None:
            raise InputError(
                "nothing is open yet: begin with an example, a photo or an empty scene"
            )
        elif isinstance(command, commands.Render):
            path = render_rollout(self._desk, command.path, command.look)
            self._notice("info", f"The video was written to {path}")
        elif isinstance(command, commands.Write):
            path = write_file(self._desk, command)
            self._notice("info", f"{command.what} was written to {path}")
        else:
            carry_out(self._desk, command, sender.author)

    def _seek(self, image: Image, wanted: list[Sought]) -> Sequence[Proposed]:
        limits = tasks.RECONSTRUCTION
        return self._executor.submit(
            tasks.proposed, image, wanted, limits=limits, cancelled=self._stopped
        )

    def _open_case(self, case: Case, title: str | None = None) -> None:
        self._open(self.store.create(case, LoopState(), title=title))

    def _open_program(self, command: commands.OpenProgram) -> None:
        program = command.program
        case = Case(command.title, prompt=program.event.prompt)
        session = self.store.create(case, LoopState(draft=program), title=command.title)
        for data in command.forms.values():
            session.files.put(data, MESH_SUFFIX)
        self._open(session)

    def _reopen(self, session_id: str) -> None:
        folder = self.store.folder_of(session_id)
        if self._desk is not None and self._desk.session.folder == folder:
            # Its lock would be in the way of itself.
            self._desk.session.close()
        self._open(self.store.open(session_id))

    def _open(self, session: Session) -> None:
        if self._desk is not None:
            self._desk.session.close()
        desk = Desk(
            session,
            self._control,
            evidence=self._evidence,
            agent=self._agent,
            executor=self._executor,
        )
        self._desk = desk
        # A warning is about the session in which it was said.
        kept = tuple(item for item in self._snapshot.notices if item.level != "warning")
        self._publish(replace(self._snapshot, notices=kept))
        if session.read_only:
            self._notice("warning", f"{session.read_only[0].upper()}{session.read_only[1:]}.")
        elif doing := interrupted(session):
            self._notice(
                "info",
                INTERRUPTED.format(
                    what=doing, phase=RUNNING.get(desk.state.phase, desk.state.phase)
                ),
            )
        if desk.case.image is not None and desk.unprepared:
            self._publish_desk()
            self._progress("masks", None)  # at once: a process is started first
            carry_out(desk, commands.Advance(until="simulate"), "physagent")

    # --- snapshots ---------------------------------------------------------------------------

    def _progress(self, what: str, share: float | None) -> None:
        self._publish(replace(self._snapshot, busy=what, progress=share))

    def _notice(self, level: str, text: str) -> None:
        notice = Notice(next(self._numbers), level, text)  # type: ignore[arg-type]
        notices = (*self._snapshot.notices[-9:], notice)
        self._publish(replace(self._snapshot, notices=notices))

    def _publish_desk(self) -> None:
        desk = self._desk
        if desk is None:
            self._publish(replace(self._snapshot, busy=None, progress=None))
            return
        try:
            scene, rollout, checks = desk.on_view()
            preview = desk.preview()
            collisions = desk.outlines(scene) if self._with_collisions and scene else None
        except StudioError as error:
            self._notice("error", str(error))
            scene, rollout, checks, preview, collisions = None, None, (), None, None
        program, shown = desk.program, desk.round
        self._publish(
            Snapshot(
                revision=0,
                session_id=desk.session.id,
                title=desk.session.title,
                case=desk.case,
                state=desk.state,
                program=program,
                scene=scene,
                rollout=rollout,
                checks=checks,
                preview_rollout=preview,
                shown_round=shown.id if shown else None,
                read_only=desk.shown is not None,
                has_draft=desk.state.draft is not None,
                yaml_problems=desk.problems,
                collisions=collisions,
                probed=desk.probed,
                notices=self._snapshot.notices,
                can_undo=desk.session.can_undo,
                can_redo=desk.session.can_redo,
                spending=desk.meter.read(),
                version=self.versions.number,
            )
        )

    def _publish(self, snapshot: Snapshot) -> None:
        self._snapshot = replace(snapshot, revision=self._snapshot.revision + 1)
        with self._lock:
            subscribers = tuple(self._subscribers)
        for callback in subscribers:
            callback(self._snapshot)
