"""Options that several commands take."""

from __future__ import annotations

from typing import Annotated

import typer

Agent = Annotated[
    str, typer.Option(help="rules (embedded, offline) or vlm (a model; see docs/vlm.md).")
]
Objects = Annotated[
    list[str] | None,
    typer.Option(
        "--object",
        help='Where a thing is in the photo: "name@x,y" or, as two opposite corners,'
        ' "name@x0,y0,x1,y1"; "name" alone is looked for.',
    ),
]
Seconds = Annotated[
    float | None, typer.Option(min=2.0, max=10.0, help="How long the clip is shown; else 3.2.")
]
Horizon = Annotated[
    float | None,
    typer.Option(help="The row of the horizon, pixels from the top; it may lie outside."),
]
