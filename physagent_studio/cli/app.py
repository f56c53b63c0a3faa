"""The commands of `physagent`; each only parses, calls the workbench and prints.

Rooms are imported inside the commands, so that `--help` and `validate` answer at once.
"""

import sys
from dataclasses import asdict
from pathlib import Path
from typing import Annotated

import typer
from typer.main import get_command

from physagent_studio.cli import early, output
from physagent_studio.cli.comparing import judges
from physagent_studio.cli.guard import BAD_INPUT, Json, Workspace, guarded, our_fault
from physagent_studio.cli.models import models
from physagent_studio.cli.options import Agent, Horizon, Objects, Seconds
from physagent_studio.cli.session import session as session_tools
from physagent_studio.cli.sweeping import attribute, sweep
from physagent_studio.errors import InputError, ProgramError

app = typer.Typer(
    name="physagent",
    help="Turn one photograph and one sentence into a physical program, run it, repair it.",
    no_args_is_help=True,
    add_completion=False,
    pretty_exceptions_enable=False,
    rich_markup_mode=None,
)

app.add_typer(models)
app.add_typer(judges)
app.add_typer(session_tools)
app.command(
    epilog="Example: physagent sweep program.yaml --grid event.actions.roll.velocity.0=0:2:21"
    " --out sweep/"
)(sweep)
app.command(epilog="Example: physagent attribute my-case-1105")(attribute)


def main() -> None:
    """Entry point of the console script."""
    sys.excepthook = our_fault
    # Calling `app` itself would put typer's hook in the place of ours.
    get_command(app)()


def _version(wanted: bool) -> None:
    if wanted:
        from physagent_studio import __version__

        typer.echo(f"physagent-studio {__version__}")
        raise typer.Exit


@app.callback()
def _root(
    version: Annotated[
        bool, typer.Option("--version", callback=_version, is_eager=True, help="Print the version.")
    ] = False,
) -> None:
    """Turn one photograph and one sentence into a physical program, run it, repair it."""


@app.command(epilog="Example: physagent studio my_case --event rolls_over_line")
@guarded
def studio(
    target: Annotated[
        str | None, typer.Argument(help="A case folder, session, program.yaml or image.")
    ] = None,
    event: Annotated[str | None, typer.Option(help="Which event of the case.")] = None,
    prompt: Annotated[str, typer.Option(help="The event, with an image as target.")] = "",
    objects: Objects = None,
    port: Annotated[
        int | None, typer.Option(min=1, max=65535, help="Else the next free one from 8080.")
    ] = None,
    browser: Annotated[bool, typer.Option(help="Open the address in the browser.")] = True,
    agent: Agent = "rules",
    workspace: Workspace = None,
    host: Annotated[
        str, typer.Option(help="Another address to listen on; then a token is asked for.")
    ] = "127.0.0.1",
    public: Annotated[
        str, typer.Option(help="Where a reverse proxy shows it: https://host/path.")
    ] = "",
    viewers: Annotated[
        bool, typer.Option("--viewers", help="Ask for tokens here too; prints one to watch only.")
    ] = False,
) -> None:
    """Open the studio in the browser; without a target the demo, or your sessions."""
    from physagent_studio.cli.studio import run_studio

    words = (target, event, prompt, objects or [])
    run_studio(*words, port, browser, agent, workspace, host, public, viewers)


@app.command(epilog="Example: physagent run my_case --event falls  (or an image with --prompt)")
@guarded
def run(
    target: Annotated[
        str,
        typer.Argument(
            help="A case folder, an image, a session, or a file of a peer: config.yaml (PhysAgent, "
            "RealWonder), sim.yaml (PhysGen), a CSV of forces (Force Prompting, Goal Force)."
        ),
    ],
    event: Annotated[str | None, typer.Option(help="Which event of the case.")] = None,
    prompt: Annotated[str, typer.Option(help="The event, with an image as target.")] = "",
    objects: Objects = None,
    annotation: Annotated[
        Path | None, typer.Option(help="A file with more clicks: horizon, a size, supports, …")
    ] = None,
    rounds: Annotated[int, typer.Option(min=1, max=100, help="Most rounds to try.")] = 10,
    policy: Annotated[str, typer.Option(help="auto, ask or ask_when: who decides.")] = "auto",
    by_hand: Annotated[
        list[str] | None,
        typer.Option(help="A role that you play: generator, verifier or planner; repeatable."),
    ] = None,
    frames: Annotated[
        bool | None,
        typer.Option(
            "--frames/--no-frames",
            help="Render the frames of every round at once; else where a model looks at them.",
        ),
    ] = None,
    lessons: Annotated[
        Path | None, typer.Option(help="What an earlier session taught: its exported lessons.yaml.")
    ] = None,
    agent: Agent = "rules",
    yes: Annotated[
        bool, typer.Option("--yes", help="Go on where a mask is doubtful, and say so.")
    ] = False,
    horizon: Horizon = None,
    seconds: Seconds = None,
    out: Annotated[Path | None, typer.Option(help="Where its clip goes, .mp4.")] = None,
    masks: Annotated[Path | None, typer.Option(help="A picture of what was cut out, .png.")] = None,
    verbose: Annotated[
        bool, typer.Option("--verbose", help="List all checks, not just those that fail.")
    ] = False,
    as_json: Json = False,
    workspace: Workspace = None,
) -> None:
    """Run the reflection loop until the event happens or the budget ends."""
    words, played = tuple(objects or ()), tuple(by_hand or ())
    who = (policy, played, frames, agent)
    also = (annotation, lessons, yes, horizon, seconds, out, masks, verbose)
    request = early.RunRequest(target, event, prompt, words, rounds, *who, *also)
    early.target_there(target, workspace, "a case folder or an image")
    from physagent_studio.cli.run import run_loop

    raise typer.Exit(run_loop(request, workspace, as_json))


@app.command("import", epilog="Example: physagent import scene.xml --out program.yaml")
@guarded
def import_(
    scene: Annotated[
        Path, typer.Argument(help="MJCF (.xml, .mjcf), URDF (.urdf), or .glb, .obj, .ply, .stl.")
    ],
    out: Annotated[Path, typer.Option(help="Where the program goes, .yaml.")],
) -> None:
    """Turn a scene of MuJoCo, or a textured mesh, into a program; what is left out is listed."""
    early.there(scene, "a scene or a mesh")
    from physagent_studio.cli.programs import import_scene

    for line in import_scene(scene, out):
        typer.echo(line)


@app.command(epilog="Example: physagent validate program.yaml")
@guarded
def validate(
    program: Annotated[Path, typer.Argument(help="A program in YAML.")], as_json: Json = False
) -> None:
    """Check a program: every problem with its path, line and what is allowed."""
    from physagent_studio.cli.files import read_program
    from physagent_studio.program.preflight.preflight import preflight

    try:
        parsed = read_program(program)
    except ProgramError as error:
        if not as_json:
            raise
        output.print_json({"valid": False, "problems": [asdict(one) for one in error.problems]})
        raise typer.Exit(BAD_INPUT) from None
    findings = preflight(parsed)
    if as_json:
        rows = [{"path": item.path, "message": item.message} for item in findings]
        output.print_json({"valid": True, "hash": parsed.hash, "warnings": rows})
        return
    counts = (
        f"{output.count(len(parsed.scene.objects), 'object')}, "
        f"{output.count(len(parsed.event.actions), 'action')}"
    )
    typer.echo(f"{program}: valid, {counts}")
    for item in findings:
        typer.echo(f"  note · {item.path}: {item.message}")


@app.command(epilog="Example: physagent simulate program.yaml --out rollout.npz")
@guarded
def simulate(
    program: Annotated[Path, typer.Argument(help="A program in YAML.")],
    out: Annotated[Path, typer.Option(help="Where the rollout goes, .npz.")],
    as_json: Json = False,
) -> None:
    """Run a program once and save its rollout."""
    from physagent_studio.cli.files import read_program

    parsed = read_program(program)
    from physagent_studio.cli.programs import simulate_program

    raise typer.Exit(simulate_program(parsed, program, out, as_json))


@app.command(epilog="Example: physagent render SESSION --out clip.mp4")
@guarded
def render(
    session: Annotated[str, typer.Argument(help="A session id or a unique beginning of one.")],
    out: Annotated[Path, typer.Option(help="Where the video goes, .mp4.")],
    round_id: Annotated[str | None, typer.Option("--round", help="Else the best round.")] = None,
    size: Annotated[str, typer.Option(help="832x480; else that of the photo as it was read.")] = "",
    letterbox: Annotated[
        bool, typer.Option("--letterbox", help="All of the picture in that size, not cropped.")
    ] = False,
    shutter: Annotated[
        float, typer.Option(help="Motion blur: the share of a frame that it is open, 0 to 1.")
    ] = 0.0,
    pbr: Annotated[
        bool, typer.Option("--pbr", help="Path traced by Mitsuba (extra pbr); minutes to hours.")
    ] = False,
    samples: Annotated[
        int, typer.Option(help="With --pbr: rays for each pixel, up to a power of four.")
    ] = 16,
    workspace: Workspace = None,
) -> None:
    """Write a session's clip as an H.264 video."""
    from physagent_studio.records.clip_look import ClipLook

    way = "letterbox" if letterbox else "crop"
    look = ClipLook(early.size_of(size), way, shutter, samples if pbr else None)
    early.video_name(out)
    early.session_there(session, workspace)
    from physagent_studio.cli.clips import render_session

    typer.echo(render_session(session, round_id, out, workspace, look))


@app.command(epilog="Example: physagent export SESSION --out prior/  (or replay.html, or x.viser)")
@guarded
def export(
    session: Annotated[str, typer.Argument(help="A session id or a unique beginning of one.")],
    out: Annotated[
        Path,
        typer.Option(
            help="A folder: new, empty or an earlier export of the session; or .html, or .viser."
        ),
    ],
    round_id: Annotated[str | None, typer.Option("--round", help="Else the best round.")] = None,
    also: Annotated[
        list[str] | None,
        typer.Option(
            help="Rewritten too, again for more: flo, kitti, csv, parquet, mjcf, rerun, "
            "peer-config, final-sim, wan-vace, wan-fun, go-with-the-flow."
        ),
    ] = None,
    overwrite: Annotated[
        bool, typer.Option("--overwrite", help="Replace the export of another session, too.")
    ] = False,
    workspace: Workspace = None,
) -> None:
    """Write a motion prior: frames, exact flow, masks, depth, program, rollout, lessons.

    With a .html file: the session as one page that plays anywhere. With .viser: the moving scene.
    """
    early.session_there(session, workspace)
    from physagent_studio.cli.clips import export_session

    for line in export_session(session, round_id, out, workspace, also or (), overwrite):
        typer.echo(line)


@app.command(epilog="Example: physagent generate prior/ --out clip.mp4 --size 832x480")
@guarded
def generate(
    prior: Annotated[Path, typer.Argument(help="A folder that `export` wrote.")],
    out: Annotated[Path, typer.Option(help="Where the video goes, .mp4.")],
    size: Annotated[str, typer.Option(help="Of our own clip, cropped to it: 832x480.")] = "",
    endpoint: Annotated[str, typer.Option(help="A ComfyUI server, http://127.0.0.1:8188.")] = "",
    workflow: Annotated[
        Path | None,
        typer.Option(
            help="Its workflow as saved for the API, with {physagent:control_video}, "
            "{physagent:start_image} and {physagent:prompt} where ours go."
        ),
    ] = None,
    diffusers: Annotated[
        str, typer.Option(help="A Wan VACE pipeline, run here: its folder or its id (extra).")
    ] = "",
    fetch: Annotated[bool, typer.Option("--fetch", help="It may be fetched by its id.")] = False,
    steps: Annotated[int, typer.Option(min=1, help="Of its denoising.")] = 30,
    guidance: Annotated[float, typer.Option(help="How closely it keeps to the prompt.")] = 5.0,
    seed: Annotated[int, typer.Option(min=0, help="Of its noise, or of the server's.")] = 0,
) -> None:
    """Make a video from a motion prior: our own clip, or what Wan VACE or a server makes of it."""
    early.video_name(out)
    early.there(prior, "a folder that `physagent export` wrote")
    within = early.size_of(size)
    from physagent_studio.cli.clips import generate_video
    from physagent_studio.exchange.generators import Diffusers

    own = Diffusers(diffusers, fetch, steps, guidance, seed) if diffusers else None
    typer.echo(f"wrote {generate_video(prior, out, within, endpoint, workflow, own, seed)}")


@app.command(epilog="Example: physagent reconstruct my_case --sheet sheet.png")
@guarded
def reconstruct(
    target: Annotated[str, typer.Argument(help="A case folder, or an image.")],
    sheet: Annotated[Path, typer.Option(help="Where the contact sheet goes, .png.")],
    prompt: Annotated[str, typer.Option(help="The event, with an image as target.")] = "",
    objects: Objects = None,
    horizon: Horizon = None,
) -> None:
    """Reconstruct a scene once and write a contact sheet of every step."""
    early.there(target, "a case folder or an image")
    from physagent_studio.cli.programs import reconstruct_case

    words = tuple(objects or ())
    typer.echo(f"wrote {reconstruct_case(target, sheet, prompt, words, horizon)}")


@app.command(epilog="Example: physagent sessions")
@guarded
def sessions(as_json: Json = False, workspace: Workspace = None) -> None:
    """List the sessions of the workspace, last changed first."""
    from physagent_studio.session import Store

    store = Store(workspace)
    if store.root.exists() and not store.root.is_dir():
        raise InputError(f"{store.root} is a file; a workspace is a folder")
    if workspace is not None and not store.root.exists():
        raise InputError(f"the workspace {store.root} does not exist; --workspace takes a folder")
    output.print_sessions(store.list(), as_json)


@app.command(epilog="Example: physagent bench physics --json")
@guarded
def bench(
    name: Annotated[str, typer.Argument(help="Which bench; `physagent bench list` names them.")],
    cases: Annotated[Path | None, typer.Option(help="Folder of case folders.")] = None,
    out: Annotated[Path | None, typer.Option(help="Also write the table here, Markdown.")] = None,
    annotations: Annotated[Path | None, typer.Option(help="Folder of a person's clicks.")] = None,
    references: Annotated[
        Path | None, typer.Option(help="Folder of <case>__<event>.yaml with reference contracts.")
    ] = None,
    only: Annotated[
        list[str] | None, typer.Option(help="A case or case/event; again for more.")
    ] = None,
    sheets: Annotated[
        Path | None, typer.Option(help="view, paper: folder for a contact sheet of each event.")
    ] = None,
    events: Annotated[
        int | None, typer.Option(help="paper: so many of its 80 events, drawn by seed.")
    ] = None,
    variant: Annotated[
        list[str] | None, typer.Option(help="paper: full, no_semantics or model; again for more.")
    ] = None,
    without: Annotated[
        list[str] | None, typer.Option(help="reconstruction: a heuristic left out; again for more.")
    ] = None,
    full: Annotated[
        bool, typer.Option("--full", help="physics, durability, safety: all of it, not a dose.")
    ] = False,
    as_json: Json = False,
) -> None:
    """Measure: prints a table, exits 0 only when every bound holds."""
    early.writable(out)
    from physagent_studio.cli.bench import measured

    rows = measured(
        name,
        cases=cases,
        out=out,
        annotations=annotations,
        references=references,
        only=tuple(only or ()),
        full=full,
        sheets=sheets,
        left_out=tuple(without or ()),
        count=events,
        variants=tuple(variant or ()),
    )
    output.print_rows(name, rows, as_json)
    if not all(row.ok for row in rows):
        raise typer.Exit(3)
