"""`physagent session`: what can be done to one stored session."""

import shutil
import tempfile
from pathlib import Path
from typing import Annotated

import typer

from physagent_studio.cli import output
from physagent_studio.cli.guard import NOT_REALISED, Json, Workspace, guarded

session = typer.Typer(
    name="session",
    help="Look after one session: check, repair, vacuum, export, import, audit, replay.",
    no_args_is_help=True,
)
Id = Annotated[str, typer.Argument(help="A session id or a unique beginning of one.")]


def _folder(session_id: str, workspace: Path | None) -> Path:
    from physagent_studio.session import Store

    return Store(workspace).folder_of(session_id)


@session.command(epilog="Example: physagent session check my-case-1105")
@guarded
def check(session_id: Id, workspace: Workspace = None) -> None:
    """Whether the database, every round and every file are whole; exit code 3 where not."""
    from physagent_studio.session import care

    problems = care.check(_folder(session_id, workspace))
    for one in problems:
        typer.echo(one)
    if problems:
        raise typer.Exit(NOT_REALISED)
    typer.echo("whole")


@session.command(epilog="Example: physagent session repair my-case-1105")
@guarded
def repair(session_id: Id, workspace: Workspace = None) -> None:
    """Keep all that can be read; the damaged database stays beside the new one."""
    from physagent_studio.session import care

    done = care.repair(_folder(session_id, workspace))
    for one in done or ["nothing had to be repaired"]:
        typer.echo(one)


@session.command(epilog="Example: physagent session vacuum my-case-1105")
@guarded
def vacuum(session_id: Id, workspace: Workspace = None) -> None:
    """Remove files that nothing refers to, and pack the database."""
    from physagent_studio.session import care

    count, size = care.vacuum(_folder(session_id, workspace))
    typer.echo(f"{output.count(count, 'file')} removed, {size / 2**20:.1f} MB freed")


@session.command("export", epilog="Example: physagent session export my-case --out a.physagent")
@guarded
def export_one(
    session_id: Id,
    out: Annotated[Path, typer.Option(help="The file to write.")],
    workspace: Workspace = None,
) -> None:
    """Write the whole session to one file, which `import` takes in elsewhere."""
    from physagent_studio.session import Session, archive

    with Session(_folder(session_id, workspace), writing=False) as one:
        typer.echo(f"wrote {archive.export(one, out)}")


@session.command("import", epilog="Example: physagent session import a.physagent")
@guarded
def import_one(
    archive: Annotated[Path, typer.Argument(help="A file that `export` wrote.")],
    workspace: Workspace = None,
) -> None:
    """Take in a session from one file; every part of it is checked first."""
    from physagent_studio.session import Store

    typer.echo(f"session {Store(workspace).import_from(archive)}")


@session.command(epilog="Example: physagent session audit my-case-1105 --json")
@guarded
def audit(session_id: Id, as_json: Json = False, workspace: Workspace = None) -> None:
    """Who decided what and when, with the hashes of programs."""
    from physagent_studio.session import care

    entries = care.audit(_folder(session_id, workspace))
    if as_json:
        output.print_json(entries)
        return
    for one in entries:
        command = one.get("command")
        what = command["kind"] if isinstance(command, dict) else one.get("round", "")
        program = str(one.get("program", ""))[:12]
        typer.echo(f"{one['at']}  {one['kind']:<10} {one['author']:<20} {what:<18} {program}")


@session.command(epilog="Example: physagent session replay my-case-1105")
@guarded
def replay(session_id: Id, agent: str = "rules", workspace: Workspace = None) -> None:
    """Do everything again from the audit and compare the bits; exit code 3 where some differ."""
    from physagent_studio.cli.early import agent_name
    from physagent_studio.session import Store
    from physagent_studio.workbench.journal import replayed

    scratch = Path(tempfile.mkdtemp(prefix="physagent-replay-"))
    try:
        found = replayed(Store(workspace), session_id, scratch, agent_name(agent))
    finally:
        shutil.rmtree(scratch, ignore_errors=True)
    for one in found["said"]:
        typer.echo(one)
    typer.echo(f"{found['same']} of {output.count(found['commands'], 'command')} to the same bits")
    if found["different"]:
        typer.echo(f"different: {', '.join(found['different'])}")
        raise typer.Exit(NOT_REALISED)
