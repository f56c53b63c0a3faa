"""Several clients on one session against a model of what they see: Hypothesis moves them.

Of the installation it needs the extra `test`, so it is imported only where it runs.
"""

from __future__ import annotations

import tempfile
from pathlib import Path
from typing import Any, ClassVar

from hypothesis import HealthCheck, Phase, settings
from hypothesis import strategies as st
from hypothesis.stateful import (
    RuleBasedStateMachine,
    initialize,
    invariant,
    precondition,
    rule,
    run_state_machine_as_test,
)

from physagent_studio.program import PhysicalProgram, SetField
from physagent_studio.session import Store
from physagent_studio.workbench import Workbench, commands
from physagent_studio.workbench.versions import Sender, sent_by

MAX_CLIENTS = 4


_CLIENT = st.integers(0, MAX_CLIENTS - 1)
_VALUE = st.integers(0, 39)


class Walk(RuleBasedStateMachine):
    """One walk of two to four clients on a new session of a program."""

    program: ClassVar[PhysicalProgram]
    taken: ClassVar[int] = 0

    def __init__(self) -> None:
        super().__init__()
        self._folder = tempfile.TemporaryDirectory()
        self._clients: Clients | None = None

    @initialize(count=st.integers(2, MAX_CLIENTS))
    def open(self, count: int) -> None:
        self._clients = Clients(Path(self._folder.name), self.program, count)

    def _act(self, client: int, *steps: str, value: int = 0) -> None:
        assert self._clients is not None
        for step in steps:
            self._clients.act(client % len(self._clients.seen), step, value)
        type(self).taken += 1

    @property
    def _can_undo(self) -> bool:
        return self._clients is not None and self._clients.bench.snapshot().can_undo

    @rule(client=_CLIENT, value=_VALUE)
    def edit(self, client: int, value: int) -> None:
        self._act(client, "edit", value=value)

    @rule(client=_CLIENT, value=_VALUE)
    def pin(self, client: int, value: int) -> None:
        self._act(client, "pin", value=value)

    @rule(client=_CLIENT)
    def look(self, client: int) -> None:
        self._act(client, "look")

    @rule(client=_CLIENT, step=st.sampled_from(("undo", "redo")))
    def undo_or_redo(self, client: int, step: str) -> None:
        self._act(client, step)

    @precondition(lambda self: self._can_undo)
    @rule(client=_CLIENT)
    def undo_and_redo(self, client: int) -> None:
        assert self._clients is not None
        before = self._clients.document()
        self._act(client, "look", "undo", "redo")
        assert self._clients.document() == before, "undo and redo led elsewhere"

    @invariant()
    def nothing_is_lost(self) -> None:
        assert self._clients is None or self._clients.lost == []

    def teardown(self) -> None:
        if self._clients is not None:
            self._clients.bench.close()
        self._folder.cleanup()


def walks_of(program: PhysicalProgram) -> type[Walk]:
    """The walks on a program; `taken` counts the steps of all of them."""
    return type("WalkOfProgram", (Walk,), {"program": program, "taken": 0})


def walking(runs: int, steps: int, **more: Any) -> settings:
    """How long the machine walks: always the same walks of that many steps."""
    return settings(
        max_examples=runs,
        # The first step opens the session.
        stateful_step_count=steps + 1,
        deadline=None,
        derandomize=True,
        database=None,
        suppress_health_check=(HealthCheck.too_slow, HealthCheck.data_too_large),
        **more,
    )


def walked(program: PhysicalProgram, runs: int, steps: int) -> tuple[int, int, str]:
    """Lost updates (at the first one it ends), steps that were taken, and what was lost."""
    machine: Any = walks_of(program)
    try:
        # Left to itself Hypothesis ends one walk in six before its time.
        run_state_machine_as_test(
            machine, settings=walking(runs, steps, phases=(Phase.generate,)), _min_steps=steps
        )
    except AssertionError as error:
        return 1, machine.taken, str(error)
    return 0, machine.taken, ""


PATH = "event.actions.go.start_step"


class Clients:
    """Clients that look at different times; `lost` says where the document was not as it had to be.

    A command made against an older document has to be refused and change nothing.
    """

    def __init__(self, root: Path, program: PhysicalProgram, count: int) -> None:
        self.bench = Workbench(Store(root), evidence=False)
        self._post(commands.OpenProgram(program, "clients"), Sender())
        self.seen = [self.bench.snapshot().version] * count
        self.past, self.future = [self.document()], []
        self.last_by = -1
        self.lost: list[str] = []

    def document(self) -> tuple[str, tuple[str, ...]]:
        shown = self.bench.snapshot()
        return shown.program.hash, shown.state.pinned

    def _post(self, command: commands.Command, sender: Sender) -> bool:
        """Whether it was carried out."""
        said: list[str] = []
        with sent_by(Sender(sender.client, sender.seen, said.append)):
            self.bench.post(command)
        self.bench.wait(120)
        return not said

    def act(self, client: int, step: str, value: int) -> None:
        """One step of one client; notes whatever differs from the model."""
        if step == "look":
            self.seen[client] = self.bench.snapshot().version
            return
        edit = SetField(path=PATH, value=value)
        made: dict[str, commands.Command] = {
            "edit": commands.ApplyEdits((edit,)),
            "pin": commands.Pin(f"event.actions.go.velocity.{value % 3}"),
            "undo": commands.Undo(),
            "redo": commands.Redo(),
        }
        before, version = self.document(), self.bench.snapshot().version
        current = self.seen[client] == version or self.last_by == client
        done = self._post(made[step], Sender(client, self.seen[client]))
        after = self.document()
        if not done and (current or after != before):
            self.lost.append(f"{step} of {client} was refused, or changed something all the same")
        if done and self.bench.snapshot().version != version:
            if not current:
                self.lost.append(f"{step} of {client} went over a change that it had not seen")
            self._model(step, after)
            self.last_by = client
            self.seen[client] = self.bench.snapshot().version

    def _model(self, step: str, after: tuple[str, tuple[str, ...]]) -> None:
        if step == "undo":
            self.future.append(self.past.pop())
        elif step == "redo":
            self.past.append(self.future.pop())
        else:
            self.past.append(after)
            self.future.clear()
        if after != self.past[-1]:
            self.lost.append(f"{step} did not lead to what was there")
