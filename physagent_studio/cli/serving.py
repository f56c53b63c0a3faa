"""What `physagent studio` does once its address is printed: opens the target and serves."""

import os
import signal
import socket
import time
from collections.abc import Callable
from pathlib import Path

from physagent_studio.assets import assets_dir
from physagent_studio.cli.early import agent_name, is_session
from physagent_studio.cli.files import read_program
from physagent_studio.cli.marks import parse_objects
from physagent_studio.cli.targets import PROGRAMS, case_of
from physagent_studio.jobs import Processes
from physagent_studio.session import Store
from physagent_studio.studio import photo_desk, serve
from physagent_studio.studio.access import Access
from physagent_studio.workbench import Snapshot, Workbench, commands, tasks
from physagent_studio.workbench.mesh_edits import forms_beside

LOOKING_ENDS = 5.0
"""Seconds in which a search for masks that nobody waits for ends by itself: what it has is kept."""


def serve_until_interrupted(
    opening: commands.Command,
    store: Store,
    access: Access,
    door: socket.socket,
    agent: str,
    *,
    browser: bool,
) -> None:
    """Serves on a socket that listens already; everything is kept when it ends."""
    # What crashes, hangs or is cancelled there leaves the studio as it is.
    # One is at work on a session; the others start for the candidates of a search.
    processes = Processes(os.cpu_count() or 1, keeping=True)
    apart = Processes(1, keeping=True, grace=LOOKING_ENDS)
    workbench = Workbench(store, agent=agent_name(agent), executor=processes)
    try:
        running = serve(workbench, access, port=door, open_browser=browser, apart=apart)
        processes.warm(*tasks.MODULES)
        workbench.subscribe(_once_marked(apart))
        workbench.post(opening)
        _until_interrupted()
        running.stop()
    finally:
        workbench.close()
        processes.close()
        apart.close()


def _once_marked(apart: Processes) -> Callable[[Snapshot], None]:
    """Nobody clicks in a photo that is not there yet: until then its process need not be."""

    def look(snapshot: Snapshot) -> None:
        nonlocal wanted
        if wanted and snapshot.scene is not None:
            wanted = False
            apart.warm(*photo_desk.MODULES)

    wanted = True
    return look


SHOWN_FIRST = "block_stays_standing"
"""Event of the demo whose first program falls short, so that a newcomer sees it repaired."""


def opening_of(
    target: str | None, event: str | None, prompt: str, objects: tuple[str, ...], store: Store
) -> commands.Command:
    """The command that opens the target; bad input is said before anything is served."""
    if target is None:
        sessions = store.list()
        if sessions:
            return commands.OpenSession(sessions[0].id)
        return commands.OpenCase(assets_dir() / "demo", event or SHOWN_FIRST)
    if is_session(target):
        store.open(target).close()
        return commands.OpenSession(target)
    path = Path(target)
    if path.suffix.lower() in PROGRAMS and path.name not in ("case.yaml", "case.yml"):
        program = read_program(path)
        return commands.OpenProgram(program, path.stem, forms_beside(path, program))
    case = case_of(target, event, prompt, objects, ask=False)
    if path.is_dir() or path.suffix.lower() in PROGRAMS:
        return commands.OpenCase(path, event)
    return commands.OpenImage(path, case.prompt, tuple(parse_objects(objects).items()))


def _until_interrupted() -> None:
    # No lock in a handler: a second Ctrl+C may come while the first is being answered.
    asked: list[int] = []
    for number in (signal.SIGINT, signal.SIGTERM):
        signal.signal(number, lambda got, _: asked.append(got))
    while not asked:
        time.sleep(0.2)
