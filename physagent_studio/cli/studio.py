"""`physagent studio`: opens a target in the browser and serves until Ctrl+C."""

from __future__ import annotations

import signal
import tempfile
import threading
from pathlib import Path

from physagent_studio.assets import assets_dir
from physagent_studio.cli.files import read_program
from physagent_studio.cli.targets import PROGRAMS, agent_name, case_of, is_session, parse_objects
from physagent_studio.errors import InputError
from physagent_studio.jobs import Processes
from physagent_studio.session import Store
from physagent_studio.workbench import Workbench, commands, tasks


def run_studio(
    target: str | None,
    event: str | None,
    prompt: str,
    objects: list[str],
    port: int | None,
    browser: bool,
    agent: str,
    workspace: Path | None,
    host: str = "127.0.0.1",
    public: str = "",
    viewers: bool = False,
) -> None:
    """Serves the studio until it is interrupted; on loopback unless another address is given."""
    from physagent_studio.studio import serve
    from physagent_studio.studio.access import Access

    access = Access.to(host, public, viewers=viewers)

    store = Store(workspace)
    _check_writable(store.root)
    opening = _opening(target, event, prompt, tuple(objects), store)
    # What crashes, hangs or is cancelled there leaves the studio as it is.
    processes = Processes(1, keeping=True)
    workbench = Workbench(store, agent=agent_name(agent), executor=processes)
    try:
        running = serve(workbench, access, port=port, open_browser=browser)
        if access.host not in LOOPBACK:
            print(_WARNING.format(host=access.host), flush=True)
        print(f"studio: {running.address}  (Ctrl+C ends it; everything is kept)", flush=True)
        if running.viewer_address:
            print(f"to watch only: {running.viewer_address}", flush=True)
        processes.warm(*tasks.MODULES)
        if opening is not None:
            workbench.post(opening)
        _until_interrupted()
        running.stop()
    finally:
        workbench.close()
        processes.close()


LOOPBACK = ("127.0.0.1", "localhost", "::1")
_WARNING = (
    "Warning: the studio listens on {host}. Whoever has an address below, and whoever reads this"
    " network, can use it; without TLS in front (docs/safety.md) that is everybody on the network."
)


def _check_writable(root: Path) -> None:
    """Said before anything is served, not when the first session is made."""
    try:
        root.mkdir(parents=True, exist_ok=True)
        tempfile.TemporaryFile(dir=root).close()
    except OSError as error:
        raise InputError(
            f"the workspace {root} cannot be written: {error.strerror}; choose another with"
            " --workspace or PHYSAGENT_HOME"
        ) from error


SHOWN_FIRST = "block_stays_standing"
"""Event of the demo whose first program falls short, so that a newcomer sees it repaired."""


def _opening(
    target: str | None, event: str | None, prompt: str, objects: tuple[str, ...], store: Store
) -> commands.Command | None:
    """The command that opens the target; bad input is said before anything is served."""
    if target is None:
        sessions = store.list()
        if sessions:
            return commands.OpenSession(sessions[0].id)
        return commands.OpenCase(assets_dir() / "demo", event or SHOWN_FIRST)
    if is_session(target, store):
        store.open(target).close()
        return commands.OpenSession(target)
    path = Path(target)
    if path.suffix.lower() in PROGRAMS and path.name not in ("case.yaml", "case.yml"):
        return commands.OpenProgram(read_program(path), path.stem)
    case = case_of(target, event, prompt, objects, ask=False)
    if path.is_dir() or path.suffix.lower() in PROGRAMS:
        return commands.OpenCase(path, event)
    return commands.OpenImage(path, case.prompt, tuple(parse_objects(objects).items()))


def _until_interrupted() -> None:
    stop = threading.Event()
    for number in (signal.SIGINT, signal.SIGTERM):
        signal.signal(number, lambda *_: stop.set())
    while not stop.wait(0.5):
        pass
