"""`physagent study` and `physagent judge`: people, a model or VBench say which clips are better."""

import sys
from pathlib import Path
from typing import Annotated

import typer

from physagent_studio.cli.guard import guarded

judges = typer.Typer()
Folder = Annotated[
    Path, typer.Argument(help="A folder for each method, clips of the same names in them.")
]
_EXAMPLE = "Example: physagent {} clips/  (clips/METHOD/NAME.mp4, NAME.txt beside one)"


@judges.command(epilog=_EXAMPLE.format("study"))
@guarded
def study(
    folder: Folder,
    figures: Annotated[
        bool, typer.Option("--figures", help="Ask nobody: the figures of the answers so far.")
    ] = False,
    seed: Annotated[int, typer.Option(help="Of order and sides; keep it while a study runs.")] = 0,
    port: Annotated[int, typer.Option(help="On loopback; 0 is any free one.")] = 0,
    question: Annotated[str, typer.Option(help="Asked about each pair, in place of ours.")] = "",
    browser: Annotated[bool, typer.Option(help="Open it in a browser.")] = True,
) -> None:
    """Ask people which of two clips is better; answers go to answers.csv in the folder."""
    from physagent_studio.benchmark.study.server import QUESTION, StudyServer
    from physagent_studio.benchmark.study.trials import read_answers, study_of, summary

    asked = study_of(folder, seed)
    if not figures:
        with StudyServer(asked, port, question or QUESTION) as server:
            typer.echo(f"study: {server.address}  (Ctrl+C ends it; every answer is kept)")
            if browser:
                typer.launch(server.address)
            try:
                server.serve_forever()
            except KeyboardInterrupt:
                typer.echo()
    typer.echo("\n".join(summary(read_answers(folder))))


@judges.command(epilog=_EXAMPLE.format("judge"))
@guarded
def judge(
    folder: Folder,
    frames: Annotated[int, typer.Option(min=2, max=48, help="Of each clip, evenly spread.")] = 12,
    seed: Annotated[int, typer.Option(help="Of which order comes first.")] = 0,
    vbench: Annotated[
        bool, typer.Option("--vbench", help="VBench's scores in place of a model's.")
    ] = False,
    python: Annotated[str, typer.Option(help="The Python where VBench is installed.")] = "",
) -> None:
    """Have a model grade how real clips are, blind and in both orders (docs/vlm.md sets it up)."""
    from physagent_studio.benchmark.judge import agreement, judging
    from physagent_studio.benchmark.judge.vbench import vbench_scores
    from physagent_studio.benchmark.study.trials import study_of

    asked = study_of(folder, seed)
    if vbench:
        for method, row in vbench_scores(asked, python or sys.executable).items():
            typer.echo(f"{method}: " + ", ".join(f"{k} {score:.3f}" for k, score in row.items()))
        return
    found = []
    for one in judging.judge(asked, judging.line_from_environment(), frames):
        found.append(one)
        typer.echo(f"{one.clip}: {one.preferred or 'equal'}, {one.reason}", err=True)
    typer.echo("\n".join(agreement.summary(found)))
