"""`physagent study` and `physagent judge`: which clips are better."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from physagent_studio.cli.guard import guarded

judges = typer.Typer()


@judges.command(
    epilog="Example: physagent study clips/  (clips/METHOD/NAME.mp4, NAME.txt beside one)"
)
@guarded
def study(
    folder: Annotated[
        Path, typer.Argument(help="A folder for each method, clips of the same names in them.")
    ],
    figures: Annotated[
        bool, typer.Option("--figures", help="Ask nobody: the figures of the answers so far.")
    ] = False,
    seed: Annotated[int, typer.Option(help="Of order and sides; keep it while a study runs.")] = 0,
    port: Annotated[int, typer.Option(help="On loopback; 0 is any free one.")] = 0,
    question: Annotated[str, typer.Option(help="Asked about each pair, in place of ours.")] = "",
    browser: Annotated[bool, typer.Option(help="Open it in a browser.")] = True,
) -> None:
    """Ask people which of two clips is better; answers go to answers.csv in the folder."""
    from physagent_studio.cli.study import ask, figures_of

    if not figures:
        ask(folder, seed, port, question, browser=browser)
    for line in figures_of(folder):
        typer.echo(line)


@judges.command(
    epilog="Example: physagent judge clips/  (clips/METHOD/NAME.mp4, NAME.txt beside one)"
)
@guarded
def judge(
    folder: Annotated[
        Path, typer.Argument(help="A folder for each method, clips of the same names in them.")
    ],
    frames: Annotated[int, typer.Option(min=2, max=48, help="Of each clip, evenly spread.")] = 12,
    seed: Annotated[int, typer.Option(help="Of which order comes first.")] = 0,
    vbench: Annotated[
        bool, typer.Option("--vbench", help="VBench's scores in place of a model's.")
    ] = False,
    python: Annotated[str, typer.Option(help="The Python where VBench is installed.")] = "",
) -> None:
    """Have a model grade how real clips are, blind and in both orders (docs/vlm.md sets it up)."""
    from physagent_studio.cli.study import judged, vbench_of

    rows = vbench_of(folder, python) if vbench else judged(folder, seed, frames)
    for line in rows:
        typer.echo(line)
