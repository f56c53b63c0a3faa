"""`physagent studio`: prints the address at once, then loads what serves it.

Loading takes seconds. Only what could be wrong with the target is looked at before, so that it is
said before anything is served.
"""

from __future__ import annotations

import tempfile
from pathlib import Path
from typing import TYPE_CHECKING

from physagent_studio.assets import data_folder
from physagent_studio.cli.early import agent_name, target_there
from physagent_studio.errors import InputError
from physagent_studio.studio.access import Access, listening

if TYPE_CHECKING:
    from physagent_studio.workbench import commands

LOOPBACK = ("127.0.0.1", "localhost", "::1")
_WARNING = (
    "Warning: the studio listens on {host}. Whoever has an address below, and whoever reads this"
    " network, can use it; without TLS in front (docs/safety.md) that is everybody on the network."
)


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
    access = Access.to(host, public, viewers=viewers)
    agent_name(agent)
    root = (workspace or data_folder()).expanduser()
    if target is not None:
        target_there(target, root)
    _check_writable(root)
    opening = None if target is None else _opening(target, event, prompt, tuple(objects), root)
    with listening(access.host, port) as door:
        _announce(access, door.getsockname()[1])
        from physagent_studio.cli import serving
        from physagent_studio.session import Store

        store = Store(root)
        opening = opening or serving.opening_of(None, event, prompt, tuple(objects), store)
        serving.serve_until_interrupted(opening, store, access, door, agent, browser=browser)


def _announce(access: Access, port: int) -> None:
    if access.host not in LOOPBACK:
        print(_WARNING.format(host=access.host), flush=True)
    print(f"studio: {access.link(port)}  (Ctrl+C ends it; everything is kept)", flush=True)
    if access.guarded:
        print(f"to watch only: {access.link(port, 'viewer')}", flush=True)


def _opening(
    target: str, event: str | None, prompt: str, objects: tuple[str, ...], root: Path
) -> commands.Command:
    from physagent_studio.cli import serving
    from physagent_studio.session import Store

    return serving.opening_of(target, event, prompt, objects, Store(root))


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
