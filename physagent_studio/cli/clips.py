"""What a stored session gives away: its clip, a replay, a motion prior."""

import json
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from physagent_studio.cli.output import progress_control
from physagent_studio.errors import InputError
from physagent_studio.exchange import BUNDLES, Prior, check_bundles, made_from, video_size
from physagent_studio.exchange.generators import ComfyUI, Composite, Diffusers, VideoGenerator
from physagent_studio.records import LoopState
from physagent_studio.records.clip_look import AS_DRAWN, ClipLook
from physagent_studio.session import Store
from physagent_studio.workbench import commands
from physagent_studio.workbench.desk import Desk
from physagent_studio.workbench.rendering import export_rollout, render_rollout, write_file


def render_session(
    session_id: str,
    round_id: str | None,
    out: Path,
    workspace: Path | None,
    look: ClipLook = AS_DRAWN,
    *,
    quiet: bool = False,
) -> str:
    """Writes the clip of a round, or of the best one, as a video; a line on what was written.

    quiet: no progress on standard error.
    """
    with _showing(session_id, round_id, workspace, quiet=quiet) as desk:
        made = render_rollout(desk, out, look)
    width, height = video_size(made)
    return f"wrote {made}, {width} × {height} pixels"


def export_session(
    session_id: str,
    round_id: str | None,
    out: Path,
    workspace: Path | None,
    bundles: Sequence[str] = (),
    overwrite: bool = False,
) -> list[str]:
    """A round, or the best one: by the ending of `out` a replay, a recording or a motion prior.

    bundles: what a prior is rewritten as beside its frames. overwrite: also where the prior of
    another session is. Returns what was written, a line each.
    """
    unknown = [name for name in bundles if name not in BUNDLES]
    page = out.suffix.lower() in (".html", ".viser")
    if unknown or (bundles and page):
        raise InputError(
            f"--also {(unknown or list(bundles))[0]}: a motion prior, which is a folder, can also "
            f"be {', '.join(BUNDLES)}"
        )
    check_bundles(bundles)
    with _showing(session_id, round_id, workspace) as desk:
        if not page:
            said = replaced(out, desk.state, overwrite=overwrite)
            return [*said, f"wrote {out}", *export_rollout(desk, out, bundles)]
        from physagent_studio.studio.replay import recording_of, replay_of

        writer = replay_of if out.suffix.lower() == ".html" else recording_of
        return [f"wrote {write_file(desk, commands.Write(out, '', writer))}"]


def replaced(out: Path, state: LoopState, *, overwrite: bool) -> list[str]:
    """A line where a session's motion prior replaces one. Raises InputError for anything else."""
    if not out.is_dir() or not any(out.iterdir()):
        return []
    earlier = made_from(out)
    if earlier is None:
        raise InputError(f"{out} is not empty and holds no earlier export; name a new folder")
    if earlier.get("program") in {one.program.hash for one in state.rounds}:
        return [f"{out} held an earlier export of this session, which is replaced"]
    if not overwrite:
        raise InputError(
            f"{out} holds the export of another session; name a new folder, or replace it with"
            " --overwrite"
        )
    return [f"{out} held the export of another session, which is replaced"]


def generate_video(
    prior: Path,
    out: Path,
    size: tuple[int, int] | None = None,
    endpoint: str = "",
    workflow: Path | None = None,
    own: Diffusers | None = None,
    seed: int = 0,
) -> Path:
    """A video from an exported motion prior: by a ComfyUI server, by a model here, or ours.

    own: the model here. seed: of the server's.
    """
    found = Prior.open(prior)
    made: VideoGenerator
    if endpoint and own is not None:
        raise InputError("--endpoint and --diffusers are two generators; name one of them")
    if own is not None:
        made = own
    elif endpoint:
        if workflow is None:
            raise InputError("--endpoint goes with --workflow, a workflow saved for ComfyUI's API")
        made = ComfyUI(endpoint, _workflow(workflow), seed)
    else:
        made = Composite(size)
    with progress_control(False) as control:
        return made.generate(found, out, cancelled=control.cancelled, progress=control.progress)


def _workflow(path: Path) -> dict[str, Any]:
    try:
        found = json.loads(path.read_text(encoding="utf-8"))
    except (OSError, ValueError, RecursionError) as error:
        raise InputError(f"{path} is no workflow: {error}") from error
    if not isinstance(found, dict):
        raise InputError(f"{path} is no workflow saved for ComfyUI's API: not an object of nodes")
    return found


@contextmanager
def _showing(
    session_id: str, round_id: str | None, workspace: Path | None, *, quiet: bool = False
) -> Iterator[Desk]:
    """A session with that round, or its best one, on view."""
    with (
        Store(workspace).open(session_id, writing=False) as session,
        progress_control(quiet) as control,
    ):
        desk = Desk(session, control)
        best = desk.state.best
        if round_id is None and best is None:
            raise InputError(
                f"session {session.id} has no round that ran;"
                f" `physagent run {session.id}` goes on, or says what stops it"
            )
        desk.handle(commands.ShowRound(round_id or (best.id if best else None)))
        yield desk
