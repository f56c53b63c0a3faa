"""Several clients on one session, against a model of what they should see; `walks` moves them."""

from __future__ import annotations

from pathlib import Path

from physagent_studio.program import PhysicalProgram, SetField
from physagent_studio.session import Store
from physagent_studio.workbench import Workbench, commands
from physagent_studio.workbench.versions import Sender, sent_by

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
        fresh = self.seen[client] == version or self.last_by == client
        done = self._post(made[step], Sender(client, self.seen[client]))
        after = self.document()
        if not done and (fresh or after != before):
            self.lost.append(f"{step} of {client} was refused, or changed something all the same")
        if done and self.bench.snapshot().version != version:
            if not self._is_current(client, version):
                self.lost.append(f"{step} of {client} went over a change that it had not seen")
            self._model(step, before, after)
            self.last_by = client
            self.seen[client] = self.bench.snapshot().version

    def _is_current(self, client: int, version: int) -> bool:
        return self.seen[client] == version or self.last_by == client

    def _model(self, step: str, before: object, after: tuple[str, tuple[str, ...]]) -> None:
        if step == "undo":
            self.future.append(self.past.pop())
            expected = self.past[-1]
        elif step == "redo":
            self.past.append(self.future.pop())
            expected = self.past[-1]
        else:
            self.past.append(after)
            self.future.clear()
            expected = after
        if after != expected:
            self.lost.append(f"{step} did not lead to what was there")
