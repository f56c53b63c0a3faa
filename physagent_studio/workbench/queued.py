"""What stands in the workbench's queue, and what comes of a try that is overtaken there."""

from __future__ import annotations

import threading
from dataclasses import dataclass

from physagent_studio.errors import Cancelled
from physagent_studio.program import Edit
from physagent_studio.workbench import commands
from physagent_studio.workbench.desk import Desk
from physagent_studio.workbench.snapshot import Attempt
from physagent_studio.workbench.versions import Sender


def attempted(desk: Desk, edits: tuple[Edit, ...]) -> Attempt:
    """What edits under the pointer make, or that they were overtaken."""
    try:
        return desk.attempt(edits)
    except Cancelled:
        return OVERTAKEN


OVERTAKEN = Attempt()
"""Stands for an attempt that something newer has ended: nothing is shown of it."""


@dataclass(frozen=True, slots=True)
class Posted:
    """A command with who asks for it."""

    command: commands.Command
    sender: Sender


class Try:
    """The place in the queue where the newest of what shall be tried is run."""


TRY = Try()


class Marker:
    """A place in the queue that somebody waits for."""

    def __init__(self, done: threading.Event) -> None:
        self.done = done
