"""Writes what is on view as a video or a motion prior."""

import tempfile
from collections.abc import Sequence
from pathlib import Path

from physagent_studio.agent.memory import lessons_of
from physagent_studio.errors import InputError
from physagent_studio.exchange import write_bundles, write_lessons
from physagent_studio.exchange.files import written
from physagent_studio.records.clip_look import AS_DRAWN, ClipLook
from physagent_studio.workbench import commands
from physagent_studio.workbench.desk import Desk


def render_rollout(desk: Desk, path: Path, look: ClipLook = AS_DRAWN) -> Path:
    """The rollout on view as an MP4; returns where it was written."""
    scene, rollout, _ = desk.on_view()
    if scene is None or rollout is None:
        raise InputError("nothing was simulated yet, so there is nothing to render")
    desk.control.progress("rendering", 0.0)
    # What an ended process leaves lies in a folder that goes.
    with written(path) as partial, tempfile.TemporaryDirectory(dir=path.parent) as folder:
        made = Path(folder) / "clip.mp4"
        desk.engine.film(made, scene, rollout, desk.program, look)
        made.replace(partial)
    return path


def write_file(desk: Desk, command: commands.Write) -> Path:
    """Lets a writer of an upper room make a file; it is whole or not there."""
    with written(command.path) as partial:
        partial.write_bytes(command.writer(desk))
    return command.path


def export_rollout(desk: Desk, folder: Path, bundles: Sequence[str] = ()) -> list[str]:
    """The rollout on view as a motion prior folder, with what the session taught beside it.

    bundles: what it is rewritten as in the same folder, see `exchange.BUNDLES`. Returns a line on
    each of them.
    """
    scene, rollout, _ = desk.on_view()
    if scene is None or rollout is None:
        raise InputError("nothing was simulated yet, so there is nothing to export")
    desk.engine.export(folder, scene, rollout, desk.program)
    write_lessons(folder / "lessons.yaml", lessons_of(desk.state))
    control = desk.control
    return write_bundles(
        folder,
        bundles,
        cancelled=control.cancelled,
        progress=lambda what: control.progress(f"writing {what}", None),
    )
